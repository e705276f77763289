//! The end of a run: the gate of the checker, the files, the summary.

use std::path::Path;
use std::process::ExitCode;

use contract::{Ledger, ProblemStatement, StageKind};
use miette::{Context, IntoDiagnostic};
use plan::{Failure, Origin, Plan, Provenance, ResultKind, StageCount};
use refiner::End;

use crate::exit;
use crate::in_process::RunEnd;
use crate::progress::Progress;

/// Passes a plan through the checker, writes `plan.json` or `failure.json`, and says how the run ended.
///
/// # Errors
/// When a file cannot be written, asking failed, or the checker refuses the plan (which is kept for the developers).
pub fn conclude(
    statement: &ProblemStatement,
    run: &RunEnd,
    out: &Path,
    progress: &Progress,
) -> miette::Result<ExitCode> {
    match (&run.refinement.end, &run.plan) {
        (End::Solved { .. }, Some(bytes)) => solved(statement, run, bytes, out, progress),
        (End::Solved { .. }, None) => Err(miette::miette!("the plan's product is lost")),
        (End::Failed { result, causes }, _) => {
            let failure = Failure {
                format: plan::FAILURE_FORMAT.to_owned(),
                problem: statement.problem.name.clone(),
                result: *result,
                causes: causes.clone(),
                stages: run.refinement.stages.clone(),
                provenance: provenance(statement, &run.refinement.ledger),
            };
            failed(&failure, out)
        }
        (End::Fault(fault), _) => Err(miette::miette!("{fault}")),
    }
}

/// What a plan or failure was made from.
#[must_use]
pub fn provenance(statement: &ProblemStatement, ledger: &Ledger) -> Provenance {
    Provenance {
        problem_digest: statement.problem_digest().hex(),
        seed: statement.seed,
        implementations: StageKind::ALL
            .into_iter()
            .map(|stage| format!("{stage} {}", statement.implementation(stage)))
            .collect(),
        ledger_digest: ledger.digest().hex(),
    }
}

/// The finished plan of a solved run: the product's, with its provenance.
///
/// # Errors
/// When the product is no plan.
pub fn finished_plan(statement: &ProblemStatement, ledger: &Ledger, product: &[u8]) -> miette::Result<Plan> {
    let bytes = match contract::decode(product).into_diagnostic()? {
        contract::Product::Plan(bytes) => bytes,
        _ => return Err(miette::miette!("the composite stage's plan is another product")),
    };
    let mut plan = plan::read_plan(&bytes).into_diagnostic()?;
    plan.provenance = provenance(statement, ledger);
    Ok(plan)
}

fn solved(
    statement: &ProblemStatement,
    run: &RunEnd,
    product: &[u8],
    out: &Path,
    progress: &Progress,
) -> miette::Result<ExitCode> {
    let plan = finished_plan(statement, &run.refinement.ledger, product)?;
    let bytes = plan::write_plan(&plan).into_diagnostic()?;
    progress.say("[checker] checks the plan");
    match validation::check_plan(&statement.problem, &plan) {
        Ok(_) => {
            write(out, "plan.json", &bytes)?;
            remove_stale(out, "failure.json")?;
            progress.say("[checker] certified");
            print!("{}", summary(&plan, &run.refinement.stages, progress, out));
            Ok(ExitCode::from(exit::SOLVED))
        }
        Err(violations) => {
            write(out, "plan.rejected.json", &bytes)?;
            let said: Vec<String> =
                violations.iter().take(10).map(|v| format!("  {}: {}", v.rule.name(), v.message)).collect();
            Err(miette::miette!(
                "the checker refuses the plan in {} places; this is a fault of mrtamp, the plan is kept in {}\n{}",
                violations.len(),
                out.join("plan.rejected.json").display(),
                said.join("\n")
            ))
        }
    }
}

fn failed(failure: &Failure, out: &Path) -> miette::Result<ExitCode> {
    write(out, "failure.json", &plan::write_failure(failure).into_diagnostic()?)?;
    remove_stale(out, "plan.json")?;
    let (code, said) = match failure.result {
        ResultKind::InfeasibleProven => (exit::INFEASIBLE, "There is no plan: proven."),
        ResultKind::SamplesExhausted => (exit::EXHAUSTED, "No plan among the samples tried. That is no proof."),
        ResultKind::LimitReached => (exit::LIMIT, "No plan within the limit."),
    };
    eprintln!("\n{said}");
    for count in &failure.stages {
        eprintln!("  {:<10} {:>6} jobs, {:>6} failed", count.stage, count.jobs, count.failures);
    }
    if !failure.causes.is_empty() {
        eprintln!("What was in the way, most frequent first:");
    }
    for (cause, times) in failure.causes.iter().take(8) {
        eprintln!("  {times:>6} times: {}", crate::words::cause(cause));
    }
    eprintln!("Written: {}", out.join("failure.json").display());
    Ok(ExitCode::from(code))
}

/// The summary of a solved run, for stdout.
fn summary(plan: &Plan, stages: &[StageCount], progress: &Progress, out: &Path) -> String {
    let origin = |wanted: Origin| plan.orderings.iter().filter(|ordering| ordering.origin == wanted).count();
    let bound = &plan.lower_bound;
    let mut text = format!(
        "\nCertified plan of {} in {:.1} s\n  makespan     {:.2} s for the task, {:.2} s in all\n  lower bound  {:.2} s ({})\n  \
         orderings    {} given, {} discovered\n  arcs         {} between robots\n",
        plan.problem,
        progress.elapsed_s(),
        plan.makespan.task_s,
        plan.makespan.total_s,
        bound.seconds,
        bound.kind,
        origin(Origin::Given),
        origin(Origin::Discovered),
        plan.dependencies.len(),
    );
    for ordering in plan.orderings.iter().filter(|ordering| ordering.origin == Origin::Discovered) {
        let because =
            ordering.cause.as_ref().map_or(String::new(), |cause| format!(": {}", crate::words::cause(cause)));
        let (before, after) = (&ordering.before, &ordering.after);
        text += &format!(
            "    {} of {} before {} of {}{because}\n",
            before.point.name(),
            before.pair,
            after.point.name(),
            after.pair
        );
    }
    for count in stages {
        text += &format!(
            "  {:<11}  {} jobs, {} failed, {} work units\n",
            count.stage, count.jobs, count.failures, count.work
        );
    }
    text + &format!("  written      {}\n", out.join("plan.json").display())
}

/// Writes a file whole or not at all.
fn write(out: &Path, name: &str, bytes: &[u8]) -> miette::Result<()> {
    let write = || {
        std::fs::create_dir_all(out)?;
        let unfinished = out.join(format!(".{name}.unfinished"));
        std::fs::write(&unfinished, bytes)?;
        std::fs::rename(&unfinished, out.join(name))
    };
    write().into_diagnostic().wrap_err_with(|| format!("{} cannot be written", out.join(name).display()))
}

/// Removes what an earlier run left under the other name.
fn remove_stale(out: &Path, name: &str) -> miette::Result<()> {
    match std::fs::remove_file(out.join(name)) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(error).into_diagnostic().wrap_err_with(|| format!("{} cannot be removed", out.join(name).display()))
        }
        _ => Ok(()),
    }
}
