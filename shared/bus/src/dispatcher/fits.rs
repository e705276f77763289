//! Whether an outcome can be the answer to a job at all: the cheap part of checking what a stage claims.

use contract::{Answer, Composition, Job, JobId, Outcome, Request};

use crate::worker::product_of;

/// What is wrong with an outcome; none: it fits.
pub(super) fn misfit(id: JobId, job: &Job, outcome: &Outcome) -> Option<String> {
    let Ok(answer) = &outcome.result else { return None };
    if !is_answer_to(answer, &job.request) {
        return Some("its answer does not belong to the job".to_owned());
    }
    // What is asked for again is asked of the job that made it.
    let foreign = product_of(outcome).is_some_and(|product| product.made_by != id);
    foreign.then(|| "it names a product of another job as its answer".to_owned())
}

fn is_answer_to(answer: &Answer, request: &Request) -> bool {
    match (request, answer) {
        (Request::Placement(job), Answer::Placements(candidates)) => candidates.len() <= job.count as usize,
        (Request::Hop(job), Answer::Hop { choices, .. }) => {
            choices.len() <= job.count as usize && choices.iter().all(|choice| choice.placed.pair == job.pair)
        }
        (Request::Transition(job), Answer::Alternatives(alternatives)) => alternatives.len() <= job.count as usize,
        (Request::Blockers(job), Answer::Blocked(blocked)) => blocked.len() == job.standing.len(),
        (Request::GraspBlockers(job), Answer::Blocked(blocked)) => blocked.len() == job.standing.len(),
        (Request::Samples(_), Answer::Samples(_)) => true,
        (Request::Piece(_), Answer::Piece(_)) | (Request::Mode(_), Answer::Mode { .. }) => true,
        (Request::Compose(job), answer) => match &job.composition {
            Composition::CommitMode { .. } | Composition::Drrt { .. } => matches!(answer, Answer::Committed { .. }),
            Composition::Assemble { .. } => matches!(answer, Answer::Plan { .. }),
            Composition::Synchronous { .. } => matches!(answer, Answer::Rounds { .. }),
            Composition::Repair { mode, .. } => {
                matches!(answer, Answer::Repaired { modes, .. } if modes.iter().any(|(done, _)| done == mode))
            }
            Composition::Passages { .. } => matches!(answer, Answer::NoPassage(_)),
        },
        _ => false,
    }
}
