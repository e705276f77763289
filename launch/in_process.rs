//! The reference mode: one process, stages called directly.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use contract::{DirectCalls, ProblemStatement};
use refiner::{End, Refinement};

use crate::progress::Progress;
use crate::stages::{BusyTimes, own_stages};

/// What a run leaves: the refinement and, if it was solved, the bytes of its plan.
#[derive(Debug)]
pub struct RunEnd {
    /// Ledger, end and counts of the search.
    pub refinement: Refinement,
    /// Bytes of the product that the end names.
    pub plan: Option<Arc<[u8]>>,
    /// Time that each stage has worked on jobs, over all its workers.
    pub busy: BusyTimes,
}

/// Refines a statement by direct calls.
///
/// # Errors
/// Why the stages cannot be set up.
pub fn run(
    statement: &Arc<ProblemStatement>,
    cancelled: &Arc<AtomicBool>,
    progress: &Progress,
) -> miette::Result<RunEnd> {
    let busy = BusyTimes::default();
    let mut calls = DirectCalls::new(statement.clone(), own_stages(statement, &busy)?, cancelled.clone());
    let watched = progress.clone();
    calls.observe(move |job, outcome| watched.answered(job, outcome));
    let products = calls.products();
    let refinement = refiner::refine_plan(statement, &mut calls, &mut |entry| progress.committed(entry));
    let plan = match &refinement.end {
        End::Solved { plan, .. } => products.get(&plan.digest),
        End::Failed { .. } | End::Fault(_) => None,
    };
    Ok(RunEnd { refinement, plan, busy })
}
