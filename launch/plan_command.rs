//! `mrtamp plan`.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::{Args, ValueEnum};
use contract::{CompositeMethod, ProblemStatement};

use crate::ending::Conclusion;
use crate::packages::PackageArgs;
use crate::progress::Progress;
use crate::{in_process, problem_source};

/// Arguments of `mrtamp plan`.
#[derive(Args, Debug)]
pub struct PlanArgs {
    /// Problem file, or the name of a built-in scene (default: figure1).
    pub problem: Option<PathBuf>,
    /// Seed of all random values.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Folder for plan.json or failure.json.
    #[arg(long, value_name = "DIR", default_value = "mrtamp-out")]
    pub out: PathBuf,
    /// Plan in this one process, by direct calls.
    #[arg(long)]
    pub in_process: bool,
    /// How composite motion is searched for.
    #[arg(long, value_enum, default_value_t)]
    pub composite: Composite,
    /// Launch file with the set of processes.
    #[arg(long, value_name = "LAUNCH_FILE")]
    pub set: Option<PathBuf>,
    /// Seconds after which the search is ended.
    #[arg(long, value_name = "SECONDS")]
    pub time_limit: Option<f64>,
    /// Results for programs.
    #[arg(long)]
    pub json: bool,
    /// Where ROS packages lie.
    #[command(flatten)]
    pub packages: PackageArgs,
}

/// How composite motion is searched for.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub enum Composite {
    /// Mode by mode with safe tails; the composite search where that fails.
    #[default]
    Prioritised,
    /// The paper's multi-modal dRRT* alone.
    Drrt,
}

impl Composite {
    /// Name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Composite::Prioritised => "prioritised",
            Composite::Drrt => "drrt",
        }
    }
}

impl From<Composite> for CompositeMethod {
    fn from(composite: Composite) -> Self {
        match composite {
            Composite::Prioritised => Self::Prioritised,
            Composite::Drrt => Self::Drrt,
        }
    }
}

/// Plans.
///
/// # Errors
/// A report for the user.
pub fn run(args: &PlanArgs) -> miette::Result<ExitCode> {
    let problem = problem_source::load_with(args.problem.as_deref(), &args.packages)?;
    let statement = Arc::new(ProblemStatement::new(problem, args.seed, args.composite.into()));
    let progress = Progress::new(statement.clone(), args.json);
    let cancelled = Arc::new(AtomicBool::new(false));
    let run = in_process::run(&statement, &cancelled, &progress)?;
    Conclusion { statement: &statement, out: &args.out, json: args.json, progress: &progress }.conclude(&run)
}
