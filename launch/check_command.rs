//! `mrtamp check`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use crate::exit::{self, BadInput};
use crate::packages::PackageArgs;
use crate::problem_source;

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
    /// Where ROS packages lie.
    #[command(flatten)]
    pub packages: PackageArgs,
}

/// Checks a plan.
///
/// # Errors
/// A report for the user.
pub fn run(args: &CheckArgs) -> miette::Result<ExitCode> {
    let problem = problem_source::load_with(Some(&args.problem), &args.packages)?;
    let bytes = problem_source::read_file(&args.plan)?;
    let plan = plan::read_plan(&bytes).map_err(|error| {
        miette::Report::new(BadInput {
            message: format!("{}: {error}", args.plan.display()),
            help: Some("`mrtamp schema plan` prints what a plan looks like".to_owned()),
        })
    })?;
    match validation::check_plan(&problem, &plan) {
        Ok(_) => {
            println!("accepted: {}", args.plan.display());
            Ok(ExitCode::from(exit::SOLVED))
        }
        Err(violations) => {
            for violation in &violations {
                println!("{}: {}", violation.rule.name(), violation.message);
            }
            println!("rejected: {}, {} violations", args.plan.display(), violations.len());
            Ok(ExitCode::from(exit::REJECTED))
        }
    }
}
