//! `mrtamp schema`.

use std::process::ExitCode;

use clap::{Args, ValueEnum};
use miette::IntoDiagnostic;

/// Arguments of `mrtamp schema`.
#[derive(Args, Debug)]
pub struct SchemaArgs {
    /// Which format.
    pub format: Format,
}

/// File formats.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Format {
    /// `plan.json`.
    Plan,
    /// `failure.json`.
    Failure,
    /// Launch files.
    Launch,
}

/// Prints a schema.
///
/// # Errors
/// A report for the user.
pub fn run(args: &SchemaArgs) -> miette::Result<ExitCode> {
    let schema = match args.format {
        Format::Plan => schemars::schema_for!(plan::Plan),
        Format::Failure => schemars::schema_for!(plan::Failure),
        Format::Launch => schemars::schema_for!(crate::set::launch_file::LaunchFile),
    };
    println!("{}", serde_json::to_string_pretty(&schema).into_diagnostic()?);
    Ok(ExitCode::SUCCESS)
}
