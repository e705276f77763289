//! Merged steps: what is asked in which sequence, and where the search goes back to.

use contract::{CauseTally, Choice, Decision, FailureReport, Job, Ledger, Merge, Outcome, ProblemStatement, Request};
use model::{FailurePolicy, ObjectId, PairId};
use plan::{Cause, ResultKind};
use refiner::End;
use skeleton::Occupancy;

use crate::scripted::{Rule, Scripted, decisions, statement};

fn merged(scene: &str, merge: Merge, causes: bool) -> ProblemStatement {
    let mut statement = statement(scene);
    statement.options.merge = merge;
    statement.options.policies.transition = Some(FailurePolicy::Backtrack { causes });
    statement
}

/// What was asked, a letter for each job: Hop, Transition, Blockers, Piece, Mode, Compose.
fn letters(asked: &[Job]) -> String {
    let letter = |job: &Job| match job.request {
        Request::Placement(_) => 'p',
        Request::Hop(_) => 'H',
        Request::Transition(_) => 'T',
        Request::Samples(_) => 'S',
        Request::GraspBlockers(_) => 'G',
        Request::Blockers(_) => 'B',
        Request::Piece(_) => 'P',
        Request::Mode(_) => 'M',
        Request::Compose(_) => 'C',
    };
    asked.iter().map(letter).collect()
}

fn hops_tried(ledger: &Ledger) -> Vec<(usize, u32)> {
    let of_decision = |decision: Decision| match decision {
        Decision::Hop { pair, sample, .. } => Some((pair.index(), sample)),
        _ => None,
    };
    decisions(ledger).into_iter().filter_map(of_decision).collect()
}

#[test]
fn with_merged_steps_the_pair_of_a_hop_is_served_before_the_next_hop_is_placed() {
    for (merge, first) in [(Merge::PlacementAndTransition, "HTHTTT"), (Merge::PlacementToRoadmap, "HTPPPPPPPMMMHT")] {
        let statement = merged("t03_relay", merge, true);
        let mut stages = Scripted::new(&statement, Vec::new());
        let run = stages.run();
        assert!(matches!(run.end, End::Solved { .. }));
        let asked = letters(&stages.asked);
        assert!(asked.starts_with(first), "{merge:?}: {asked}");
        assert_eq!(hops_tried(&run.ledger), [(0, 0), (1, 0)]);
    }
}

/// The place of the second pair cannot be reached from these places of the first, wherever the object is brought.
fn out_of_reach_from(samples: std::ops::Range<u32>, of: PairId) -> Rule {
    Box::new(move |request| match request {
        Request::Transition(job) if job.pair == of && samples.contains(&(job.world_from_pick.translation.x as u32)) => {
            let cause = Cause::Unreachable {
                robot: "r1".into(),
                pair: "r1.3".into(),
                object: "x".into(),
                region: "buffer".into(),
            };
            let mut causes = CauseTally::default();
            causes.count(cause);
            let picked = Choice::Pose(Occupancy { object: ObjectId(0), hop: 1 });
            Some(Outcome { result: Err(FailureReport::soft(causes, 0).resting_on(vec![picked])), work: 1 })
        }
        _ => None,
    })
}

#[test]
fn with_causes_the_hop_at_fault_is_placed_elsewhere_at_once_and_without_them_only_after_all_later_ones() {
    let mut tried = Vec::new();
    for causes in [true, false] {
        let statement = merged("t10_swap_with_buffer", Merge::PlacementAndTransition, causes);
        // x goes to the buffer, y to x's place, x from the buffer on: sample 2 of the first hop is the first that serves.
        let mut stages = Scripted::new(&statement, vec![out_of_reach_from(0..2, PairId(2))]);
        let run = stages.run();
        assert!(matches!(run.end, End::Solved { .. }), "{:?}", run.end);
        tried.push(hops_tried(&run.ledger));
    }
    assert_eq!(tried[0], [(0, 0), (1, 0), (2, 0), (0, 1), (1, 0), (2, 0), (0, 2), (1, 0), (2, 0)]);
    assert_eq!(tried[1].len(), 2 * (1 + 4 + 4 * 4) + 3);
    assert_eq!(tried[1].last(), tried[0].last());
}

#[test]
fn a_level_tries_as_many_hops_as_its_candidates_have() {
    let mut statement = merged("t10_swap_with_buffer", Merge::PlacementToRoadmap, false);
    statement.options.candidates = 5;
    let mut stages = Scripted::new(&statement, vec![out_of_reach_from(0..4, PairId(2))]);
    let run = stages.run();
    let End::Failed { result, causes, certificate } = run.end else { panic!("solved out of reach") };
    assert_eq!((result, certificate), (ResultKind::SamplesExhausted, None));
    assert!(matches!(causes[0].0, Cause::Unreachable { .. }));
    assert_eq!(hops_tried(&run.ledger).len(), 2 * 5 * 3, "two levels of five candidates of three hops");
}
