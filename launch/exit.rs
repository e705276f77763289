//! How the program ends: exit codes.

use std::process::ExitCode;

/// Exit code of a run that found a plan, or of a check that accepted one.
pub const SOLVED: u8 = 0;
/// Exit code of anything that has no code of its own.
pub const FAULT: u8 = 1;
/// Exit code for input that cannot be worked with.
pub const BAD_INPUT: u8 = 2;
/// Exit code of a problem that is proven to have no plan.
pub const INFEASIBLE: u8 = 3;
/// Exit code of a search that ran out of samples.
pub const EXHAUSTED: u8 = 4;
/// Exit code of a search that reached a limit.
pub const LIMIT: u8 = 5;
/// Exit code of a plan that the checker rejects.
pub const REJECTED: u8 = 6;

/// The user's input cannot be worked with. Put at the root of a report, it sets the exit code.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("{message}")]
pub struct BadInput {
    /// What is wrong with it.
    pub message: String,
    /// What to do about it.
    #[help]
    pub help: Option<String>,
}

impl BadInput {
    /// Bad input without advice.
    #[must_use]
    pub fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), help: None }
    }
}

/// Exit code of a report: bad input if it is [`BadInput`] or a problem that cannot be loaded, else a fault.
#[must_use]
pub fn of_report(report: &miette::Report) -> ExitCode {
    let bad = report.is::<BadInput>() || report.is::<model::ProblemError>();
    ExitCode::from(if bad { BAD_INPUT } else { FAULT })
}
