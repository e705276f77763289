//! `mrtamp plan`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

/// Arguments of `mrtamp plan`.
#[derive(Args, Debug)]
pub struct PlanArgs {
    /// Problem file.
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
    /// Launch file with the set of processes.
    #[arg(long, value_name = "LAUNCH_FILE")]
    pub set: Option<PathBuf>,
    /// Seconds after which the search is ended.
    #[arg(long, value_name = "SECONDS")]
    pub time_limit: Option<f64>,
    /// Results for programs.
    #[arg(long)]
    pub json: bool,
}

/// Plans.
///
/// # Errors
/// A report for the user.
pub fn run(args: &PlanArgs) -> miette::Result<ExitCode> {
    Err(miette::miette!("planning of {:?} is being built", args.problem))
}
