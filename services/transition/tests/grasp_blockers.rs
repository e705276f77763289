//! What blocks the hand under every grasp blocks every reach.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod common;

use common::{Random, alternatives, ask, first_hops, job, middle_of_target, scene, statement};
use contract::{Answer, BlockersJob, GraspBlockersJob, Job, Outcome, Request};
use model::{Holding, ObjectId, PairId, Pose, Problem, Standing};
use plan::PairEnd;
use transition::TransitionStage;

fn blocked(outcome: Outcome) -> Vec<bool> {
    match outcome.result {
        Ok(Answer::Blocked(blocked)) => blocked,
        other => panic!("{other:?}"),
    }
}

/// Another object at many places beside a pose.
fn beside(problem: &Problem, pair: PairId, world_from_object: &Pose, random: &mut Random) -> Vec<Standing> {
    let own = problem.pair(pair).object;
    let other = (0..problem.movable.len()).map(ObjectId::at).find(|object| *object != own).unwrap_or(own);
    (0..40).map(|_| Standing { object: other, world_from_object: random.beside(world_from_object, 0.16) }).collect()
}

/// How often a hand was told to be blocked, and how often not.
fn check(name: &str) -> [usize; 2] {
    let problem = scene(name);
    let statement = statement(problem.clone());
    let stage = TransitionStage::new(&statement).unwrap();
    let mut counts = [0, 0];
    for (seed, pair) in (0_u64..).zip(first_hops(&problem)) {
        let mut random = Random(seed);
        let reaches = alternatives(ask(&stage, &statement, &job(&problem, pair, 16)));
        let noun = problem.pair(pair);
        let from = problem.movable[noun.object.index()].world_from_start;
        for (end, world_from_object) in [(PairEnd::Pick, from), (PairEnd::Place, middle_of_target(&problem, pair))] {
            let standing = beside(&problem, pair, &world_from_object, &mut random);
            let ask_for = |request: Request| blocked(ask(&stage, &statement, &Job { request, budget: 1_000_000 }));
            let by_hand = ask_for(Request::GraspBlockers(GraspBlockersJob {
                pair,
                end,
                world_from_object,
                level: 0,
                standing: standing.clone(),
            }));
            assert_eq!(by_hand.len(), standing.len());
            for alternative in &reaches {
                let reach = if end == PairEnd::Pick { &alternative.pick } else { &alternative.place };
                let holding = Holding { object: noun.object, grasp: alternative.grasp };
                let by_reach = ask_for(Request::Blockers(BlockersJob {
                    robot: noun.robot,
                    holding,
                    reach: reach.clone(),
                    standing: standing.clone(),
                }));
                for (i, (by_hand, by_reach)) in by_hand.iter().zip(&by_reach).enumerate() {
                    let name = &noun.name;
                    assert!(
                        *by_reach || !by_hand,
                        "{name}, seed {seed}: object {i} blocks the hand, not alternative {}",
                        alternative.index
                    );
                }
            }
            by_hand.iter().for_each(|blocked| counts[usize::from(*blocked)] += 1);
        }
    }
    counts
}

#[test]
fn an_object_that_leaves_the_hand_no_grasp_is_in_the_way_of_every_reach() {
    for name in ["t12_deep_cabinet", "t13_occluded", "figure1_tight"] {
        let [free, blocked] = check(name);
        assert!(free > 10 && blocked > 10, "{name}: {free} free, {blocked} blocked");
    }
}
