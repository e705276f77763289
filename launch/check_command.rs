//! `mrtamp check`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use plan::PlanFileError;
use validation::Violation;

use crate::exit::{self, BadInput};
use crate::packages::PackageArgs;
use crate::{explain, problem_source};

/// Arguments of `mrtamp check`.
#[derive(Args, Debug)]
pub struct CheckArgs {
    /// Problem file.
    pub problem: PathBuf,
    /// Plan file, or file of a failure.
    pub plan: PathBuf,
    /// Results for programs.
    #[arg(long)]
    pub json: bool,
    /// Also say why the plan is as it is, or what to try where there is none.
    #[arg(long)]
    pub explain: bool,
    /// Where ROS packages lie.
    #[command(flatten)]
    pub packages: PackageArgs,
}

/// Checks a plan; or a failure, whose certificate is verified if it is called proven.
///
/// # Errors
/// A report for the user.
pub fn run(args: &CheckArgs) -> miette::Result<ExitCode> {
    let problem = problem_source::load_with(Some(&args.problem), &args.packages)?;
    let bytes = problem_source::read_file(&args.plan)?;
    let unreadable = |error: PlanFileError, format: &str| BadInput {
        message: format!("{}: {error}", args.plan.display()),
        help: Some(format!("`mrtamp schema {format}` prints what a {format} looks like")),
    };
    match plan::read_failure(&bytes) {
        Ok(failure) => {
            let why = || explain::failure_text(&problem, &failure);
            Ok(said(args, validation::check_failure(&problem, &failure), why))
        }
        Err(error) if is_failure(&bytes) => Err(unreadable(error, "failure").into()),
        Err(_) => {
            let plan = plan::read_plan(&bytes).map_err(|error| unreadable(error, "plan"))?;
            let why = || explain::plan_reasons::plan_text(&problem, &plan, None);
            Ok(said(args, validation::check_plan(&problem, &plan).map(|_| ()), why))
        }
    }
}

/// Whether a file says that it is a failure.
fn is_failure(bytes: &[u8]) -> bool {
    let value: Option<serde_json::Value> = serde_json::from_slice(bytes).ok();
    value.is_some_and(|value| value["format"] == plan::FAILURE_FORMAT)
}

/// Says the verdict.
fn said(args: &CheckArgs, verdict: Result<(), Vec<Violation>>, why: impl Fn() -> String) -> ExitCode {
    let Err(violations) = verdict else {
        println!("accepted: {}", args.plan.display());
        if args.explain {
            print!("\n{}", why());
        }
        return ExitCode::from(exit::SOLVED);
    };
    for violation in &violations {
        println!("{}: {}", violation.rule.name(), violation.message);
    }
    println!("rejected: {}, {} violations", args.plan.display(), violations.len());
    ExitCode::from(exit::REJECTED)
}
