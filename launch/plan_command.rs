//! `mrtamp plan`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use clap::{Args, ValueEnum};
use contract::{AskFault, CompositeMethod, Merge, ProblemStatement, SearchOptions};
use miette::{IntoDiagnostic, Report};
use refiner::End;
use signal_hook::consts::{SIGINT, SIGTERM};

use crate::ending::Conclusion;
use crate::exit::BadInput;
use crate::in_process::RunEnd;
use crate::packages::PackageArgs;
use crate::processes::Members;
use crate::progress::{Progress, Show};
use crate::result_file::refuse_unwritable;
use crate::search_args::SearchArgs;
use crate::set::launch_file;
use crate::{in_process, problem_source, processes};

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
    /// Which of the paper's steps are done as one.
    #[arg(long, value_enum, default_value_t)]
    pub merge: MergedSteps,
    /// Launch file with the set of processes.
    #[arg(long, value_name = "LAUNCH_FILE")]
    pub set: Option<PathBuf>,
    /// Seconds after which the search is ended.
    #[arg(long, value_name = "SECONDS")]
    pub time_limit: Option<f64>,
    /// What the search does when a stage fails, and how much it may work.
    #[command(flatten)]
    pub search: SearchArgs,
    /// What happens and the result for programs: one JSON object a line on stdout.
    #[arg(long)]
    pub json: bool,
    /// Also say why the plan is as it is: orderings, what was given up, waits, the gap to the lower bound.
    #[arg(long)]
    pub explain: bool,
    /// Where ROS packages lie.
    #[command(flatten)]
    pub packages: PackageArgs,
}

/// How composite motion is searched for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Composite {
    /// Mode by mode with safe tails; the composite search where that fails.
    #[default]
    Prioritised,
    /// The paper's multi-modal dRRT* alone.
    Drrt,
    /// In rounds, for comparison: as many robots as can, one mode each, then all wait.
    SyncGreedy,
    /// In rounds, for comparison: the shortest sequence of rounds.
    SyncOpt,
    /// The shorter of `prioritised` and the motion of `sync-opt` without its waits.
    Shorter,
}

impl Composite {
    /// Name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Composite::Prioritised => "prioritised",
            Composite::Drrt => "drrt",
            Composite::SyncGreedy => "sync-greedy",
            Composite::SyncOpt => "sync-opt",
            Composite::Shorter => "shorter",
        }
    }
}

impl From<Composite> for CompositeMethod {
    fn from(composite: Composite) -> Self {
        match composite {
            Composite::Prioritised => Self::Prioritised,
            Composite::Drrt => Self::Drrt,
            Composite::SyncGreedy => Self::SyncGreedy,
            Composite::SyncOpt => Self::SyncOpt,
            Composite::Shorter => Self::Shorter,
        }
    }
}

/// Which of the paper's steps are done as one (its ablations).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum MergedSteps {
    /// None: each step has all that the one before found.
    #[default]
    None,
    /// Placement and transition configurations: MERGE 1&2.
    #[value(name = "1-2")]
    OneAndTwo,
    /// Placement, transition configurations and roadmaps: MERGE 1–3.
    #[value(name = "1-3")]
    OneToThree,
}

impl MergedSteps {
    /// Name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            MergedSteps::None => "none",
            MergedSteps::OneAndTwo => "1-2",
            MergedSteps::OneToThree => "1-3",
        }
    }
}

impl From<MergedSteps> for Merge {
    fn from(merge: MergedSteps) -> Self {
        match merge {
            MergedSteps::None => Self::None,
            MergedSteps::OneAndTwo => Self::PlacementAndTransition,
            MergedSteps::OneToThree => Self::PlacementToRoadmap,
        }
    }
}

/// Plans.
///
/// # Errors
/// A report for the user.
pub fn run(args: &PlanArgs) -> miette::Result<ExitCode> {
    let problem = problem_source::load_with(args.problem.as_deref(), &args.packages)?;
    refuse_unwritable(&args.out)?;
    let launch = launch_file::load(args.set.as_deref())?;
    let search = args.search.settings().over(launch.search).over(problem.search);
    let mut statement = ProblemStatement::new(problem, args.seed, args.composite.into());
    statement.options = SearchOptions { merge: args.merge.into(), ..SearchOptions::of(&search) };
    let statement = Arc::new(statement);
    let cancelled = cancelled_by_signal().into_diagnostic()?;
    let time_limit = args.time_limit.or(search.time_limit.map(f64::from)).map(time_limit).transpose()?;
    let progress = Progress::new(statement.clone(), Show::choose(args.json));
    let ended = if args.in_process {
        in_process::run(&statement, time_limit, &cancelled, &progress).map(|run| (run, None))
    } else {
        processes::run(&statement, &launch, Members::Processes, time_limit, &cancelled, &progress)
    };
    let concluded = ended.and_then(|(run, end)| {
        keep_replay(&args.out, &run, end.as_ref().and_then(|end| end.replay.as_deref()))?;
        let statement = end.map_or(statement, |end| end.statement);
        let (out, json, explain) = (&args.out, args.json, args.explain);
        Conclusion { statement: &statement, out, json, explain, time_limit, progress: &progress }.conclude(&run)
    });
    progress.finish();
    concluded
}

/// Set by the first signal to end; the second ends the program at once.
fn cancelled_by_signal() -> std::io::Result<Arc<AtomicBool>> {
    let cancelled = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        signal_hook::flag::register_conditional_shutdown(signal, 128 + signal, cancelled.clone())?;
        signal_hook::flag::register(signal, cancelled.clone())?;
    }
    Ok(cancelled)
}

fn time_limit(seconds: f64) -> miette::Result<Duration> {
    Duration::try_from_secs_f64(seconds)
        .map_err(|error| Report::new(BadInput::new(format!("--time-limit {seconds}: {error}"))))
}

/// Keeps a job that killed its workers, for the developers.
fn keep_replay(out: &Path, run: &RunEnd, replay: Option<&[u8]>) -> miette::Result<()> {
    let (End::Fault(AskFault::PoisonJob { replay: name, .. }), Some(bytes)) = (&run.refinement.end, replay) else {
        return Ok(());
    };
    std::fs::create_dir_all(out).and_then(|()| std::fs::write(out.join(name), bytes)).into_diagnostic()
}
