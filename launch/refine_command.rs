//! `mrtamp refine`: the refiner process of a run.

use std::process::ExitCode;

use contract::{AskStages, LedgerEntry, ProblemStatement, encode_canonical};
use miette::IntoDiagnostic;
use refiner::{End, Refinement, refine_plan};

pub use crate::set::refine_process::RefineArgs;
use crate::set::{Searched, refine_process};

/// What the refiner says it is.
const IMPLEMENTATION: &str = concat!("mrtamp-refiner/", env!("CARGO_PKG_VERSION"));

/// Searches until its run is over.
///
/// # Errors
/// A report for the log.
pub fn run(args: &RefineArgs) -> miette::Result<ExitCode> {
    refine_process::run(args, IMPLEMENTATION, &search).into_diagnostic()?;
    Ok(ExitCode::SUCCESS)
}

/// This program's own search, its end encoded for the bus.
pub fn search(
    statement: &ProblemStatement,
    stages: &mut dyn AskStages,
    observe: &mut dyn FnMut(&LedgerEntry),
) -> Searched {
    let Refinement { ledger, end, stages } = refine_plan(statement, stages, observe);
    let plan = match &end {
        End::Solved { plan, .. } => Some(*plan),
        End::Failed { .. } | End::Fault(_) => None,
    };
    Searched { ledger, conclusion: encode_canonical(&(end, stages)), plan }
}
