//! Planning with a set of processes, or of threads: as `in_process`, with everything at once.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use bus::Note;
use contract::{AskFault, ProblemStatement, decode};
use miette::IntoDiagnostic;
use refiner::{End, Refinement};

use crate::in_process::RunEnd;
use crate::progress::Progress;
use crate::refine_command;
use crate::set::launch_file::LaunchFile;
use crate::set::supervisor::run_set;
use crate::set::threads::run_channels;
use crate::set::{RunFault, SetEnd, SetEvent, SetOptions};
use crate::stages::own_stage;

/// How the processes of a run are held together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Members {
    /// Processes, over shared memory.
    Processes,
    /// Threads of this process, over channels.
    Threads,
}

/// Refines a statement with the set of a launch file. A run that a signal or its limit cut short leaves no set's end.
///
/// # Errors
/// When the set cannot run; never because the search found no plan.
pub fn run(
    statement: &ProblemStatement,
    launch: &LaunchFile,
    members: Members,
    time_limit: Option<Duration>,
    cancelled: &Arc<AtomicBool>,
    progress: &Progress,
) -> miette::Result<(RunEnd, Option<SetEnd>)> {
    let mut tell = |event: SetEvent| told(&event, progress);
    let options = SetOptions { time_limit, stop: cancelled.clone(), on_event: &mut tell };
    let end: Result<SetEnd, RunFault> = match members {
        Members::Processes => run_set(statement.clone(), launch, options),
        Members::Threads => {
            let make = Arc::new(|kind, statement: &ProblemStatement| {
                own_stage(kind, statement).map_err(|report| report.to_string())
            });
            run_channels(statement.clone(), launch, options, make, Arc::new(refine_command::search))
        }
    };
    let busy = progress.busy().clone();
    let end = match end {
        Ok(end) => end,
        Err(RunFault::Cancelled) => return Ok((cut_short(AskFault::Cancelled, progress), None)),
        Err(RunFault::Overdue) => return Ok((cut_short(AskFault::TimeLimit, progress), None)),
        Err(fault) => return Err(fault).into_diagnostic(),
    };
    let (search_end, stages) = decode(&end.search.conclusion).into_diagnostic()?;
    let refinement = Refinement { ledger: end.search.ledger.clone(), end: search_end, stages };
    let plan = end.search.plan.clone().map(Into::into);
    Ok((RunEnd { refinement, plan, busy }, Some(end)))
}

/// The end of a run whose search had no time to conclude: what was seen of it.
fn cut_short(fault: AskFault, progress: &Progress) -> RunEnd {
    let tally = progress.tally();
    let refinement = Refinement { ledger: tally.ledger().clone(), end: End::Fault(fault), stages: tally.counts() };
    RunEnd { refinement, plan: None, busy: progress.busy().clone() }
}

fn told(event: &SetEvent, progress: &Progress) {
    match event {
        SetEvent::Begun { .. } | SetEvent::Started { .. } => {}
        SetEvent::Exited { name, how, returns } => {
            let then = if *returns { "it is started again" } else { "it is not started again" };
            progress.say(&format!("[supervisor] {name} has ended: {how}; {then}"));
        }
        SetEvent::Line { name, text } => progress.heard(name, text),
        SetEvent::Note(Note::Ready { members }) => progress.say(&format!("[supervisor] {members} processes are ready")),
        SetEvent::Note(Note::Answered { stage, outcome, took, .. }) => {
            progress.busy().add_us(*stage, u64::try_from(took.as_micros()).unwrap_or(u64::MAX));
            progress.noted(*stage, outcome);
        }
        SetEvent::Note(Note::Committed(entry)) => progress.committed(entry),
        SetEvent::Note(Note::Unfit { name, why }) => {
            progress.say(&format!("[supervisor] {name} gets no work: {why}"));
        }
    }
}
