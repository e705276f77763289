//! `mrtamp view`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use miette::{Context, IntoDiagnostic};

use crate::exit::{self, BadInput};
use crate::packages::PackageArgs;
use crate::view::{self, PageError};
use crate::{problem_source, result_file};

/// Arguments of `mrtamp view`.
#[derive(Args, Debug)]
pub struct ViewArgs {
    /// Plan or failure file.
    pub result: PathBuf,
    /// Problem file (default: the built-in scene that the plan names).
    #[arg(long, value_name = "PROBLEM")]
    pub problem: Option<PathBuf>,
    /// Page to write (default: beside the file, with the ending `.html`).
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Where ROS packages lie.
    #[command(flatten)]
    pub packages: PackageArgs,
}

/// Writes the page of a plan or a failure again.
///
/// # Errors
/// A report for the user.
pub fn run(args: &ViewArgs) -> miette::Result<ExitCode> {
    let page = page(args)?;
    let out = args.out.clone().unwrap_or_else(|| args.result.with_extension("html"));
    result_file::write_whole(&out, page.as_bytes())
        .into_diagnostic()
        .wrap_err_with(|| format!("{} cannot be written", out.display()))?;
    println!("{}", out.display());
    Ok(ExitCode::from(exit::SOLVED))
}

fn page(args: &ViewArgs) -> miette::Result<String> {
    let bytes = problem_source::read_file(&args.result)?;
    let made = match plan::read_failure(&bytes) {
        Ok(failure) => {
            let digest = &failure.provenance.problem_digest;
            let named = args.problem.as_deref();
            let problem = result_file::load_problem(&failure.problem, digest, &args.result, named, &args.packages)?;
            view::failure_page(&problem, &failure)
        }
        Err(_) => {
            let loaded = result_file::load(&args.result, args.problem.as_deref(), &args.packages)?;
            let violations = match validation::check_plan(&loaded.problem, &loaded.plan) {
                Ok(_) => Vec::new(),
                Err(violations) => violations.iter().map(|v| format!("{}: {}", v.rule.name(), v.message)).collect(),
            };
            view::plan_page(&loaded.problem, &loaded.plan, &[], &violations)
        }
    };
    made.map_err(|error| match error {
        PageError::Mismatch(mismatch) => BadInput::new(format!("{}: {mismatch}", args.result.display())).into(),
        PageError::Unwritable(_) => miette::Report::msg(error),
    })
}
