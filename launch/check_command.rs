//! `mrtamp check`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

/// Arguments of `mrtamp check`.
#[derive(Args, Debug)]
pub struct CheckArgs {
    /// Problem file.
    pub problem: PathBuf,
    /// Plan file.
    pub plan: PathBuf,
    /// Results for programs.
    #[arg(long)]
    pub json: bool,
}

/// Checks a plan.
///
/// # Errors
/// A report for the user.
pub fn run(args: &CheckArgs) -> miette::Result<ExitCode> {
    Err(miette::miette!("checking of {} is being built", args.plan.display()))
}
