//! The end of a run: the gate of the checker, the files, the summary.

use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

use contract::{AskFault, Ledger, LedgerEntry, ProblemStatement};
use miette::IntoDiagnostic;
use plan::{Cause, Certificate, Failure, Plan, ResultKind};
use refiner::End;

use crate::in_process::RunEnd;
use crate::progress::{Progress, tally};
use crate::provenance::{provenance, stopped_by};
use crate::report::{PlanFigures, Report, StageFigures, stage_figures, summary};
use crate::result_folder::ResultFolder;
use crate::{exit, explain, view};

/// How a run is concluded.
pub struct Conclusion<'a> {
    /// What was planned.
    pub statement: &'a ProblemStatement,
    /// Folder for `plan.json` or `failure.json`.
    pub out: &'a Path,
    /// A JSON object on stdout instead of words.
    pub json: bool,
    /// Also why the plan is as it is.
    pub explain: bool,
    /// The run's limit on time.
    pub time_limit: Option<Duration>,
    /// The run's clock, counts and lines.
    pub progress: &'a Progress,
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
            (End::Failed { result: ResultKind::LimitReached, .. }, _) if !ended_itself(run) => {
                self.failed(run, &self.cut_short(run))
            }
            (End::Fault(AskFault::TimeLimit | AskFault::Cancelled), _) => self.failed(run, &self.cut_short(run)),
            (End::Failed { result, causes, certificate }, _) => {
                self.failed(run, &self.failure(run, *result, causes, certificate.as_ref()))
            }
            (End::Fault(fault), _) => Err(miette::miette!("{fault}")),
        }
    }

    fn solved(&self, run: &RunEnd, product: &[u8]) -> miette::Result<ExitCode> {
        let plan = finished_plan(self.statement, &run.refinement.ledger, product)?;
        let bytes = plan::write_plan(&plan).into_diagnostic()?;
        let folder = ResultFolder(self.out);
        self.progress.say("[checker] checks the plan");
        if let Err(violations) = validation::check_plan(&self.statement.problem, &plan) {
            let kept = folder.write("plan.rejected.json", &bytes)?;
            let said = violations.iter().take(10).map(|v| format!("  {}: {}", v.rule.name(), v.message));
            return Err(miette::miette!(
                "the checker refuses the plan in {} places; this is a fault of mrtamp, the plan is kept in {}\n{}",
                violations.len(),
                kept.display(),
                said.collect::<Vec<_>>().join("\n")
            ));
        }
        let file = folder.write("plan.json", &bytes)?;
        let page = view::plan_page(&self.statement.problem, &plan, &run.refinement.stages, &[]).into_diagnostic()?;
        let page = folder.write("plan.html", page.as_bytes())?;
        folder.remove("failure.json")?;
        folder.remove("failure.html")?;
        self.progress.say("[checker] certified");
        self.progress.finish();
        let figures = PlanFigures::of(&plan);
        let mut words = summary(&plan, &figures, run, self.progress.elapsed_s());
        words += &format!("  written      {}\n  to look at   {}\n", file.display(), page.display());
        if self.explain {
            let (problem, ledger) = (&self.statement.problem, &run.refinement.ledger);
            words += &format!("\n{}", explain::plan_reasons::plan_text(problem, &plan, Some(ledger)));
        }
        match (self.json, self.explain) {
            (false, _) => print!("{words}"),
            (true, true) => eprint!("{words}"),
            (true, false) => {}
        }
        let stages = stage_figures(&run.refinement.stages, &run.busy);
        self.report("solved", &file, Some(figures), None, stages);
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
            stopped_by: stopped_by(self.statement, run, self.time_limit),
            causes: causes.to_vec(),
            certificate: certificate.cloned(),
            stages: run.refinement.stages.clone(),
            reached: tally::reached(&run.refinement.ledger),
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

    /// The failure of a search that could not come to its own end: what was seen of it so far.
    fn cut_short(&self, run: &RunEnd) -> Failure {
        let tally = self.progress.tally();
        Failure { stages: tally.counts(), ..self.failure(run, ResultKind::LimitReached, &tally.causes(), None) }
    }

    fn failed(&self, run: &RunEnd, failure: &Failure) -> miette::Result<ExitCode> {
        self.progress.finish();
        let folder = ResultFolder(self.out);
        let file = folder.write("failure.json", &plan::write_failure(failure).into_diagnostic()?)?;
        let page = view::failure_page(&self.statement.problem, failure).into_diagnostic()?;
        let page = folder.write("failure.html", page.as_bytes())?;
        let (code, name) = match failure.result {
            ResultKind::InfeasibleProven => (exit::INFEASIBLE, "infeasible_proven"),
            ResultKind::SamplesExhausted => (exit::EXHAUSTED, "samples_exhausted"),
            ResultKind::LimitReached => (exit::LIMIT, "limit_reached"),
        };
        eprint!("\n{}", explain::failure_text(&self.statement.problem, failure));
        eprintln!("Written: {}\nTo look at: {}", file.display(), page.display());
        match failure.result {
            ResultKind::LimitReached => folder.keep_earlier_plan(),
            ResultKind::InfeasibleProven | ResultKind::SamplesExhausted => folder.set_earlier_plan_aside()?,
        }
        self.report(name, &file, None, Some(failure), stage_figures(&failure.stages, &run.busy));
        Ok(ExitCode::from(code))
    }

    fn report(
        &self,
        result: &str,
        file: &Path,
        plan: Option<PlanFigures>,
        failure: Option<&Failure>,
        stages: Vec<StageFigures<'_>>,
    ) {
        self.progress.emit(&Report {
            event: "result",
            result,
            problem: &self.statement.problem.name,
            seed: self.statement.seed,
            file: file.display().to_string(),
            elapsed_s: self.progress.elapsed_s(),
            plan,
            stopped_by: failure.and_then(|failure| failure.stopped_by.as_ref()),
            causes: failure.map_or(&[], |failure| &failure.causes),
            stages,
        });
    }
}

/// Whether the search came to its own end: a limit on work is one, a limit on time is not.
fn ended_itself(run: &RunEnd) -> bool {
    matches!(run.refinement.ledger.entries.last(), Some(LedgerEntry::LimitReached { .. }))
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
