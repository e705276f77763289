//! What happens in a run, for people: a line for each event of note.

use contract::{Answer, Composition, Decision, Job, LedgerEntry, Outcome, Request, StageKind};
use model::Problem;

use crate::words;

/// A line about an answered job, if it is worth one; `count` is how many its stage has answered.
#[must_use]
pub fn of_job(problem: &Problem, job: &Job, outcome: &Outcome, count: u64) -> Option<String> {
    match &outcome.result {
        Err(report) => {
            let cause = super::tally::first_cause(report).map_or(String::new(), words::cause);
            Some(format!("{} failed: {cause}", subject(problem, job)))
        }
        Ok(Answer::Placements(_) | Answer::Alternatives(_)) => Some(subject(problem, job)),
        Ok(_) if job.stage() == StageKind::Roadmap && count.is_multiple_of(20) => {
            Some(format!("{count} jobs answered"))
        }
        Ok(_) => None,
    }
}

/// A line about a committed entry, if it is worth one.
#[must_use]
pub fn of_entry(problem: &Problem, entry: &LedgerEntry) -> Option<String> {
    let because =
        |cause: Option<&plan::Cause>| cause.map_or(String::new(), |cause| format!(": {}", words::cause(cause)));
    Some(match entry {
        LedgerEntry::Decided(Decision::Commit(mode)) => format!("{} is committed", words::mode(problem, *mode)),
        LedgerEntry::Decided(Decision::Order(order)) => {
            format!("ordering added: {}{}", words::order(problem, order), because(Some(&order.cause)))
        }
        LedgerEntry::Decided(decision) => words::decision(problem, decision),
        LedgerEntry::Backtrack { stage, because: cause, .. } => format!("back to {stage}{}", because(cause.as_ref())),
        LedgerEntry::Stopped { stage } => format!("{stage} has failed, the run stops"),
        LedgerEntry::LimitReached { work, spent } => {
            format!("{work} has spent {spent} work units, more than its limit")
        }
        LedgerEntry::Used { .. } | LedgerEntry::Learnt(_) => return None,
        LedgerEntry::Solved { .. } => "solved".to_owned(),
    })
}

/// Whether an entry is of note where bars already show the rest.
#[must_use]
pub fn is_notable(entry: &LedgerEntry) -> bool {
    match entry {
        LedgerEntry::Decided(Decision::Commit(_) | Decision::Alternative { .. } | Decision::Hop { .. })
        | LedgerEntry::Used { .. }
        | LedgerEntry::Learnt(_) => false,
        LedgerEntry::Backtrack { decision, .. } => matches!(decision, Decision::Placement(_) | Decision::Order(_)),
        LedgerEntry::Decided(_)
        | LedgerEntry::Stopped { .. }
        | LedgerEntry::LimitReached { .. }
        | LedgerEntry::Solved { .. } => true,
    }
}

fn subject(problem: &Problem, job: &Job) -> String {
    match &job.request {
        Request::Placement(job) => format!("placements from candidate {}", job.first),
        Request::Hop(job) => format!("places for {}", problem.pair(job.pair).name),
        Request::Samples(job) => format!("samples for {}", problem.pair(job.pair).name),
        Request::GraspBlockers(job) => format!("samples in the way of {}", problem.pair(job.pair).name),
        Request::Transition(job) => format!("alternatives for {}", problem.pair(job.pair).name),
        Request::Blockers(job) => format!("objects in the way of {}", problem.robot(job.robot).name),
        Request::Piece(job) => format!("roadmap piece of {}", problem.robot(job.robot).name),
        Request::Mode(job) => format!("roadmap of {}", words::mode(problem, job.mode)),
        Request::Compose(job) => match &job.composition {
            Composition::CommitMode { mode, .. } => format!("motion of {}", words::mode(problem, *mode)),
            Composition::Repair { mode, .. } => {
                format!("motion of {} and of those in its way", words::mode(problem, *mode))
            }
            Composition::Passages { .. } => "passages".to_owned(),
            Composition::Drrt { .. } => "composite search".to_owned(),
            Composition::Assemble { .. } => "retiming".to_owned(),
            Composition::Synchronous { .. } => "synchronous schedule".to_owned(),
        },
    }
}
