//! The end of a run: the gate of the checker, the files, the summary.

use std::path::Path;
use std::process::ExitCode;

use contract::{Ledger, ProblemStatement, StageKind};
use miette::{Context, IntoDiagnostic};
use plan::{Cause, Certificate, Failure, Origin, Plan, Provenance, ResultKind, StageCount};
use refiner::End;
use serde::Serialize;

use crate::exit;
use crate::in_process::RunEnd;
use crate::progress::Progress;
use crate::result_file::write_whole;
use crate::view;

/// How a run is concluded.
pub struct Conclusion<'a> {
    /// What was planned.
    pub statement: &'a ProblemStatement,
    /// Folder for `plan.json` or `failure.json`.
    pub out: &'a Path,
    /// One line of JSON on stdout instead of words.
    pub json: bool,
    /// The run's clock, and its lines.
    pub progress: &'a Progress,
}

/// The result for programs: one line of JSON on stdout.
#[derive(Serialize)]
struct Report<'a> {
    result: &'a str,
    problem: &'a str,
    seed: u64,
    file: String,
    elapsed_s: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    plan: Option<PlanFigures>,
    causes: &'a [(Cause, u64)],
    stages: Vec<StageFigures<'a>>,
}

/// A plan in figures.
#[derive(Serialize)]
struct PlanFigures {
    task_s: f64,
    total_s: f64,
    lower_bound_s: f64,
    given: usize,
    discovered: usize,
    arcs: usize,
}

/// A stage's work and time.
#[derive(Serialize)]
struct StageFigures<'a> {
    #[serde(flatten)]
    count: &'a StageCount,
    busy_s: f64,
}

impl Conclusion<'_> {
    /// Passes a plan through the checker, writes `plan.json` or `failure.json`, and says how the run ended.
    ///
    /// # Errors
    /// When a file cannot be written, asking failed, or the checker refuses the plan (which is kept for the developers).
    pub fn conclude(&self, run: &RunEnd) -> miette::Result<ExitCode> {
        match (&run.refinement.end, &run.plan) {
            (End::Solved { .. }, Some(bytes)) => self.solved(run, bytes),
            (End::Solved { .. }, None) => Err(miette::miette!("the plan's product is lost")),
            (End::Failed { result, causes, certificate }, _) => {
                self.failed(run, self.failure(run, *result, causes, certificate.as_ref()))
            }
            (End::Fault(fault), _) => Err(miette::miette!("{fault}")),
        }
    }

    fn solved(&self, run: &RunEnd, product: &[u8]) -> miette::Result<ExitCode> {
        let plan = finished_plan(self.statement, &run.refinement.ledger, product)?;
        let bytes = plan::write_plan(&plan).into_diagnostic()?;
        self.progress.say("[checker] checks the plan");
        if let Err(violations) = validation::check_plan(&self.statement.problem, &plan) {
            write(self.out, "plan.rejected.json", &bytes)?;
            let said = violations.iter().take(10).map(|v| format!("  {}: {}", v.rule.name(), v.message));
            return Err(miette::miette!(
                "the checker refuses the plan in {} places; this is a fault of mrtamp, the plan is kept in {}\n{}",
                violations.len(),
                self.out.join("plan.rejected.json").display(),
                said.collect::<Vec<_>>().join("\n")
            ));
        }
        write(self.out, "plan.json", &bytes)?;
        let page = view::plan_page(&self.statement.problem, &plan, &run.refinement.stages, &[]).into_diagnostic()?;
        write(self.out, "plan.html", page.as_bytes())?;
        remove_stale(self.out, "failure.json")?;
        remove_stale(self.out, "failure.html")?;
        self.progress.say("[checker] certified");
        if self.json {
            self.report("solved", run, "plan.json", Some(figures(&plan)), &[])?;
        } else {
            print!("{}", self.summary(&plan, run));
        }
        Ok(ExitCode::from(exit::SOLVED))
    }

    /// What `failure.json` says. Nothing is called proven unless the checker verifies the certificate.
    fn failure(
        &self,
        run: &RunEnd,
        result: ResultKind,
        causes: &[(Cause, u64)],
        certificate: Option<&Certificate>,
    ) -> Failure {
        let failure = Failure {
            format: plan::FAILURE_FORMAT.to_owned(),
            problem: self.statement.problem.name.clone(),
            result,
            causes: causes.to_vec(),
            certificate: certificate.cloned(),
            stages: run.refinement.stages.clone(),
            provenance: provenance(self.statement, &run.refinement.ledger),
        };
        match validation::check_failure(&self.statement.problem, &failure) {
            Ok(()) => failure,
            Err(violations) => {
                for violation in violations {
                    eprintln!("[checker] refuses the certificate: {}", violation.message);
                }
                Failure { result: ResultKind::SamplesExhausted, certificate: None, ..failure }
            }
        }
    }

    fn failed(&self, run: &RunEnd, failure: Failure) -> miette::Result<ExitCode> {
        let (result, causes) = (failure.result, failure.causes.as_slice());
        write(self.out, "failure.json", &plan::write_failure(&failure).into_diagnostic()?)?;
        let page = view::failure_page(&self.statement.problem, &failure).into_diagnostic()?;
        write(self.out, "failure.html", page.as_bytes())?;
        remove_stale(self.out, "plan.json")?;
        remove_stale(self.out, "plan.html")?;
        let (code, name) = match result {
            ResultKind::InfeasibleProven => (exit::INFEASIBLE, "infeasible_proven"),
            ResultKind::SamplesExhausted => (exit::EXHAUSTED, "samples_exhausted"),
            ResultKind::LimitReached => (exit::LIMIT, "limit_reached"),
        };
        eprintln!("\n{}", crate::words::result(result));
        for count in &failure.stages {
            eprintln!("  {:<10} {:>6} jobs, {:>6} failed", count.stage, count.jobs, count.failures);
        }
        if !causes.is_empty() {
            eprintln!("What was in the way, most frequent first:");
        }
        for (cause, times) in causes.iter().take(8) {
            eprintln!("  {times:>6} times: {}", crate::words::cause(cause));
        }
        eprintln!("Written: {}", self.out.join("failure.json").display());
        eprintln!("To look at: {}", self.out.join("failure.html").display());
        if self.json {
            self.report(name, run, "failure.json", None, causes)?;
        }
        Ok(ExitCode::from(code))
    }

    fn report(
        &self,
        result: &str,
        run: &RunEnd,
        file: &str,
        plan: Option<PlanFigures>,
        causes: &[(Cause, u64)],
    ) -> miette::Result<()> {
        let report = Report {
            result,
            problem: &self.statement.problem.name,
            seed: self.statement.seed,
            file: self.out.join(file).display().to_string(),
            elapsed_s: self.progress.elapsed_s(),
            plan,
            causes,
            stages: stage_figures(run),
        };
        println!("{}", serde_json::to_string(&report).into_diagnostic()?);
        Ok(())
    }

    /// The summary of a solved run, for stdout.
    fn summary(&self, plan: &Plan, run: &RunEnd) -> String {
        let figures = figures(plan);
        let mut text = format!(
            "\nCertified plan of {} in {:.1} s\n  makespan     {:.2} s for the task, {:.2} s in all\n  lower bound  {:.2} s \
             ({})\n  orderings    {} given, {} discovered\n  arcs         {} between robots\n",
            plan.problem,
            self.progress.elapsed_s(),
            figures.task_s,
            figures.total_s,
            figures.lower_bound_s,
            plan.lower_bound.kind,
            figures.given,
            figures.discovered,
            figures.arcs,
        );
        for ordering in plan.orderings.iter().filter(|ordering| ordering.origin == Origin::Discovered) {
            text += &format!("    {}\n", crate::words::ordering(ordering));
        }
        for StageFigures { count, busy_s } in stage_figures(run) {
            text += &format!(
                "  {:<11}  {busy_s:.2} s, {} jobs, {} failed, {} work units\n",
                count.stage, count.jobs, count.failures, count.work
            );
        }
        text += &format!("  written      {}\n", self.out.join("plan.json").display());
        text + &format!("  to look at   {}\n", self.out.join("plan.html").display())
    }
}

fn figures(plan: &Plan) -> PlanFigures {
    let of_origin = |wanted: Origin| plan.orderings.iter().filter(|ordering| ordering.origin == wanted).count();
    PlanFigures {
        task_s: plan.makespan.task_s,
        total_s: plan.makespan.total_s,
        lower_bound_s: plan.lower_bound.seconds,
        given: of_origin(Origin::Given),
        discovered: of_origin(Origin::Discovered),
        arcs: plan.dependencies.len(),
    }
}

fn stage_figures(run: &RunEnd) -> Vec<StageFigures<'_>> {
    let busy_s = |name: &str| StageKind::of_name(name).map_or(0.0, |kind| run.busy.seconds(kind));
    run.refinement.stages.iter().map(|count| StageFigures { count, busy_s: busy_s(&count.stage) }).collect()
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

/// Writes a file whole or not at all.
fn write(out: &Path, name: &str, bytes: &[u8]) -> miette::Result<()> {
    let path = out.join(name);
    write_whole(&path, bytes).into_diagnostic().wrap_err_with(|| format!("{} cannot be written", path.display()))
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
