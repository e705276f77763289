//! The reference mode: one process, stages called directly.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use contract::{AskFault, AskStages, DirectCalls, Foresight, Job, JobId, Outcome, ProblemStatement};
use refiner::{End, Refinement};

use crate::progress::Progress;
use crate::stages::{BusyTimes, own_stages};

/// The clock and the user's wish to end are looked at this often.
const LOOK: Duration = Duration::from_millis(20);

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
    time_limit: Option<Duration>,
    cancelled: &Arc<AtomicBool>,
    progress: &Progress,
) -> miette::Result<RunEnd> {
    let busy = progress.busy().clone();
    let ended = Arc::new(AtomicBool::new(false));
    let mut calls = DirectCalls::new(statement.clone(), own_stages(statement, &busy)?, ended.clone());
    let watched = progress.clone();
    calls.observe(move |job, outcome| watched.answered(job, outcome));
    let products = calls.products();
    let mut limited = Limited { calls, deadline: time_limit.map(|limit| Instant::now() + limit) };
    let over = Arc::new(AtomicBool::new(false));
    let watch = watch(ended, cancelled.clone(), limited.deadline, over.clone());
    let refinement = refiner::refine_plan(statement, &mut limited, &mut |entry| progress.committed(entry));
    over.store(true, Ordering::Relaxed);
    // It only looks at a clock and a flag.
    let _ = watch.join();
    let plan = match &refinement.end {
        End::Solved { plan, .. } => products.get(&plan.digest),
        End::Failed { .. } | End::Fault(_) => None,
    };
    Ok(RunEnd { refinement, plan, busy })
}

/// Sets `ended` when the user or the clock wants the run to end; stages look at it while they work.
fn watch(
    ended: Arc<AtomicBool>,
    cancelled: Arc<AtomicBool>,
    deadline: Option<Instant>,
    over: Arc<AtomicBool>,
) -> std::thread::JoinHandle<()> {
    std::thread::spawn(move || {
        while !over.load(Ordering::Relaxed) {
            let late = deadline.is_some_and(|deadline| Instant::now() >= deadline);
            if late || cancelled.load(Ordering::Relaxed) {
                ended.store(true, Ordering::Relaxed);
            }
            std::thread::sleep(LOOK);
        }
    })
}

/// Direct calls that end at a deadline.
struct Limited {
    calls: DirectCalls,
    deadline: Option<Instant>,
}

impl AskStages for Limited {
    fn ask(&mut self, jobs: &[Job]) -> Result<Vec<Outcome>, AskFault> {
        let late = || self.deadline.is_some_and(|deadline| Instant::now() >= deadline);
        if late() {
            return Err(AskFault::TimeLimit);
        }
        match self.calls.ask(jobs) {
            Err(AskFault::Cancelled) if late() => Err(AskFault::TimeLimit),
            result => result,
        }
    }

    fn foresee(&mut self, foresight: Foresight) {
        self.calls.foresee(foresight);
    }

    fn job_id(&self, job: &Job) -> JobId {
        self.calls.job_id(job)
    }
}
