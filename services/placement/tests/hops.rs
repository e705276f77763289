//! Choices for one hop: hop by hop they make the same candidates as whole placements.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod common;
#[path = "common/orders.rs"]
mod orders;

use std::collections::BTreeSet;

use common::{ask, candidates, job, pair_id, shipped, stage};
use contract::{Answer, HopChoice, HopJob, Interrupted, Job, Placed, Request, Soundness, encode};
use model::{PairId, Pose, Problem};
use orders::irredundant;
use placement::PlacementStage;
use plan::{BodyRef, Cause};
use skeleton::Event;

fn hop_job(pair: PairId, placed: Vec<Placed>, orders: Vec<(Event, Event)>) -> Job {
    Job { request: Request::Hop(HopJob { pair, level: 0, placed, orders, first: 0, count: 10_000 }), budget: 4_000_000 }
}

fn window(mut job: Job, window: (u32, u32)) -> Job {
    if let Request::Hop(hop) = &mut job.request {
        (hop.first, hop.count) = window;
    }
    job
}

fn choices(stage: &PlacementStage, job: &Job) -> Vec<HopChoice> {
    match ask(stage, job).unwrap().result {
        Ok(Answer::Hop { choices, .. }) => choices,
        other => panic!("no choices but {other:?}"),
    }
}

/// A candidate without its causes: the sample of each pair, and the orders.
type Key = (Vec<u32>, Vec<(Event, Event)>);

/// Every way to place the pairs from number `next` on.
fn hop_by_hop(
    problem: &Problem,
    stage: &PlacementStage,
    pairs: &[PairId],
    placed: &[Placed],
    orders: &[(Event, Event)],
    found: &mut Vec<Key>,
) {
    let Some(pair) = pairs.get(placed.len()) else {
        let mut samples: Vec<(PairId, u32)> = placed.iter().map(|placed| (placed.pair, placed.sample)).collect();
        samples.sort_unstable();
        found.push((samples.into_iter().map(|(_, sample)| sample).collect(), irredundant(problem, orders)));
        return;
    };
    for choice in choices(stage, &hop_job(*pair, placed.to_vec(), orders.to_vec())) {
        let placed = [placed, &[choice.placed]].concat();
        let new: Vec<(Event, Event)> = choice.orders.iter().map(|order| (order.before, order.after)).collect();
        hop_by_hop(problem, stage, pairs, &placed, &[orders, &new].concat(), found);
    }
}

#[test]
fn hop_by_hop_in_any_sequence_the_same_candidates_are_found_as_all_at_once() {
    let (mut all, mut with_orders) = (0, 0);
    let cases = [
        ("t05_tiny_region", 8),
        ("t09_swap", 4),
        ("t10_swap_with_buffer", 3),
        ("t08_off_diagonal", 6),
        ("t03_relay", 5),
    ];
    for (scene, samples) in cases {
        let mut problem = shipped(scene);
        problem.levels.placements = samples;
        for seed in 0..3 {
            let stage = stage(&problem, seed);
            let whole = candidates(&stage, &job(0, 0, 10_000, vec![])).into_iter().map(|candidate| {
                let orders = candidate.orders.iter().map(|order| (order.before, order.after)).collect();
                (candidate.placements.iter().map(|placed| placed.sample).collect(), orders)
            });
            let whole: BTreeSet<Key> = whole.collect();
            let forwards: Vec<PairId> = (0..problem.pairs.len()).map(PairId::at).collect();
            let backwards: Vec<PairId> = forwards.iter().rev().copied().collect();
            for pairs in [forwards, backwards] {
                let mut found = Vec::new();
                hop_by_hop(&problem, &stage, &pairs, &[], &[], &mut found);
                assert_eq!(found.iter().cloned().collect::<BTreeSet<Key>>(), whole, "{scene}, seed {seed}");
                assert_eq!(found.len(), whole.len(), "{scene}, seed {seed}: something comes twice");
            }
            all += whole.len();
            with_orders += whole.iter().filter(|(_, orders)| !orders.is_empty()).count();
        }
    }
    assert!(all > 300 && with_orders > 100, "{all} {with_orders}");
}

#[test]
fn choices_come_with_fewest_orders_first_and_a_window_is_a_part_of_the_whole() {
    let problem = shipped("t09_swap");
    let stage = stage(&problem, 0);
    let whole = hop_job(PairId(0), vec![], vec![]);
    let all = choices(&stage, &whole);
    assert!(all.is_sorted_by_key(|choice| (choice.orders.len(), choice.placed.sample)));
    assert!(all.len() > 10);
    assert_eq!(choices(&stage, &window(whole.clone(), (3, 5))), all[3..8]);
    assert_eq!(choices(&stage, &window(whole, (u32::MAX, 5))), []);
}

#[test]
fn what_a_hop_collides_with_is_told_and_why_it_has_no_place() {
    let problem = shipped("t07_three_in_two");
    let stage = stage(&problem, 0);
    let mut placed = Vec::new();
    for pair in (0..problem.pairs.len()).map(PairId::at) {
        let Ok(Answer::Hop { choices, against, causes }) =
            ask(&stage, &hop_job(pair, placed.clone(), vec![])).unwrap().result
        else {
            panic!("no answer")
        };
        let Some(choice) = choices.first() else {
            let hops: Vec<u32> = against.iter().map(|occupancy| occupancy.hop).collect();
            assert_eq!(hops, vec![1; placed.len()], "it collides with every object in the region");
            let [object, region] = [&problem.pair(pair).object.index(), &problem.pair(pair).to.index()];
            let (object, region) = (&problem.movable[*object].name, &problem.regions[*region].name);
            assert!(causes.contains(&(Cause::NoPlacement { object: object.clone(), region: region.clone() }, 1)));
            let collides = |cause: &Cause| matches!(cause, Cause::Collision { first: BodyRef::Object(_), .. });
            assert!(causes.iter().any(|(cause, _)| collides(cause)), "{causes:?}");
            return;
        };
        placed.push(choice.placed);
    }
    panic!("three objects have places where two fit");
}

#[test]
fn a_hop_that_makes_no_sense_is_refused_and_a_budget_ends_it() {
    let problem = shipped("t09_swap");
    let stage = stage(&problem, 0);
    let place = |pair| Placed { pair, sample: 0, world_from_object: Pose::identity() };
    let (first, second) = (PairId(0), pair_id(&problem, &problem.pairs[1].name));
    let grasp_last = (Event::release(first), Event::grasp(first));
    for (pair, placed, orders) in [
        (PairId(99), vec![], vec![]),
        (first, vec![place(first)], vec![]),
        (first, vec![place(second), place(second)], vec![]),
        (first, vec![place(PairId(99))], vec![]),
        (first, vec![], vec![grasp_last]),
        (first, vec![], vec![(Event::grasp(PairId(99)), Event::grasp(first))]),
    ] {
        assert!(matches!(ask(&stage, &hop_job(pair, placed, orders)), Err(Interrupted::Unfit(_))));
    }
    let whole = ask(&stage, &hop_job(first, vec![], vec![])).unwrap();
    for budget in 0..=whole.work {
        let job = Job { budget, ..hop_job(first, vec![], vec![]) };
        let outcome = ask(&stage, &job).unwrap();
        match &outcome.result {
            Err(report) => {
                assert_eq!(report.soundness, Soundness::Soft { level: 0 });
                assert_eq!(report.causes, [(Cause::Budget { stage: "placement".into() }, 1)]);
            }
            Ok(_) => assert_eq!((budget, encode(&outcome).unwrap()), (whole.work, encode(&whole).unwrap())),
        }
    }
}
