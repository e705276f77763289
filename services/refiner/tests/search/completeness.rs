//! The search loses no candidate that can be completed, and ends at the first one.

use contract::{Job, Request};
use plan::Cause;
use refiner::End;

use crate::scripted::Scripted;
use crate::worlds::{Choices, Rates, World};

const SCENES: [&str; 5] =
    ["t05_tiny_region", "t09_swap", "t10_swap_with_buffer", "t18_parked_in_the_door", "t24_four_arms"];

fn rates(seed: u64) -> Rates {
    let of = |values: [u64; 3], every: u64| values[(seed / every % 3) as usize];
    Rates {
        roadmap: [10, 20, 30, 40][seed as usize % 4],
        reach: of([0, 5, 15], 1),
        grasp: of([0, 4, 10], 3),
        transition: of([0, 4, 2], 9),
        overlap: of([0, 6, 12], 18),
        alternatives: 1 + seed % 3,
    }
}

/// The candidate that the search completes, and how many it tries.
fn solved_by(world: &std::rc::Rc<World>) -> (Option<Choices>, usize, End) {
    let mut stages = Scripted::new(&world.statement, world.rules());
    let run = stages.run();
    let candidate_of = |job: &Job| match &job.request {
        Request::Placement(placement) => world.next_candidate(placement).cloned(),
        _ => None,
    };
    let mut tried: Vec<Choices> = stages.asked.iter().filter_map(candidate_of).collect();
    let count = tried.len();
    let solved = matches!(run.end, End::Solved { .. }).then(|| tried.pop()).flatten();
    (solved, count, run.end)
}

#[test]
fn the_search_ends_at_the_first_candidate_that_can_be_completed() {
    let (mut solved, mut unsolvable, mut optimistic, mut tried_in_all, mut candidates) = (0, 0, 0, 0, 0);
    for seed in 0..480_u64 {
        for scene in SCENES {
            let world = World::new(scene, seed, rates(seed));
            let first = world.candidates.iter().position(|candidate| world.can_be_completed(candidate));
            let (found, tried, end) = solved_by(&world);
            tried_in_all += tried;
            candidates += first.map_or(world.candidates.len(), |first| first + 1);
            if let End::Failed { causes, .. } = &end {
                let ran_out = |(cause, _): &(Cause, u64)| matches!(cause, Cause::Budget { .. });
                assert!(!causes.iter().any(ran_out), "{scene}, seed {seed}: patience, not proof");
            }
            let at = found.as_ref().map(|found| world.candidates.iter().position(|other| other == found).unwrap());
            match (first, at) {
                (Some(first), Some(at)) => {
                    assert!(at <= first, "{scene}, seed {seed}: candidate {first} is lost, {at} found");
                    solved += 1;
                    optimistic += u32::from(at < first);
                }
                (Some(first), None) => panic!("{scene}, seed {seed}: candidate {first} is lost"),
                (None, Some(_)) => optimistic += 1,
                (None, None) => unsolvable += 1,
            }
        }
    }
    println!("{solved} solved, {unsolvable} not, {optimistic} that composite motion would refuse");
    println!("{tried_in_all} candidates tried of {candidates}");
    assert!(solved > 1000 && unsolvable > 400 && optimistic < 120, "{solved} {unsolvable} {optimistic}");
    assert!(candidates > 2 * tried_in_all, "{tried_in_all} tried of {candidates}: causes exclude too little");
}
