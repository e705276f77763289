//! `mrtamp stage`: a worker process of a run.

use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};

use clap::{Args, ValueEnum};
use contract::{Interrupted, Job, JobContext, Outcome, ProblemStatement, Stage, StageKind};
use miette::IntoDiagnostic;
use model::Problem;

use crate::progress::{ABOUT_A_JOB, lines};
use crate::set::member::MemberArgs;
use crate::set::stage_process;
use crate::stages::own_stage;

/// Arguments of `mrtamp stage`.
#[derive(Args, Debug)]
pub struct StageArgs {
    /// Which stage.
    pub stage: StageName,
    /// Its place in the run.
    #[command(flatten)]
    pub member: MemberArgs,
}

/// Names of stages.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum StageName {
    /// Poses of objects.
    Placement,
    /// Grasps and transition configurations.
    Transition,
    /// Roadmaps of single robots.
    Roadmap,
    /// Composite motion.
    Composite,
}

impl From<StageName> for StageKind {
    fn from(name: StageName) -> Self {
        match name {
            StageName::Placement => StageKind::Placement,
            StageName::Transition => StageKind::Transition,
            StageName::Roadmap => StageKind::Roadmap,
            StageName::Composite => StageKind::Composite,
        }
    }
}

/// Serves a stage until its run is over.
///
/// # Errors
/// A report for the log.
pub fn run(args: &StageArgs) -> miette::Result<ExitCode> {
    let kind = StageKind::from(args.stage);
    let make = |statement: &ProblemStatement| {
        let stage = own_stage(kind, statement).map_err(|report| report.to_string())?;
        let (problem, answered) = (statement.problem.clone(), AtomicU64::new(0));
        Ok(Box::new(Told { stage, problem, answered }) as Box<dyn Stage>)
    };
    stage_process::run(&args.member, kind, &ProblemStatement::own_implementation(kind), &make).into_diagnostic()?;
    Ok(ExitCode::SUCCESS)
}

/// A stage that says on stderr what it has done; the supervisor puts its name before every line.
struct Told {
    stage: Box<dyn Stage>,
    problem: Problem,
    answered: AtomicU64,
}

impl Stage for Told {
    fn refine(&self, job: &Job, context: &mut JobContext<'_>) -> Result<Outcome, Interrupted> {
        let outcome = self.stage.refine(job, context)?;
        let count = self.answered.fetch_add(1, Ordering::Relaxed) + 1;
        if let Some(line) = lines::of_job(&self.problem, job, &outcome, count) {
            eprintln!("{ABOUT_A_JOB}{line}");
        }
        Ok(outcome)
    }
}
