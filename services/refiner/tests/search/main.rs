//! The search against scripted stages that count what they are asked: no geometry, no bus.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod completeness;
mod limits;
mod merged;
mod mutual;
mod policies;
mod rounds;
mod scripted;
mod superset;
mod urgency;
mod worlds;

use std::collections::BTreeMap;

use contract::{
    Answer, CauseTally, ComposeJob, Composition, Decision, Digest, Job, JobId, Outcome, ProductRef, Request, Soundness,
};
use model::{PairId, RobotId};
use plan::{Cause, ResultKind};
use refiner::End;
use scripted::{Rule, Scripted, decisions, fails, no_path, relay, statement, transfer_fails_with};
use skeleton::ModeId;

#[test]
fn a_relay_is_committed_in_an_order_that_respects_the_hops() {
    let statement = relay();
    let mut stages = Scripted::new(&statement, Vec::new());
    let run = stages.run();
    assert!(matches!(run.end, End::Solved { .. }));
    let commits: Vec<ModeId> = decisions(&run.ledger)
        .into_iter()
        .filter_map(|decision| match decision {
            Decision::Commit(mode) => Some(mode),
            _ => None,
        })
        .collect();
    let at = |robot: usize, step: u32| commits.iter().position(|m| m.robot.index() == robot && m.step == step).unwrap();
    let (first, second) = (statement.problem.pairs[0].robot.index(), statement.problem.pairs[1].robot.index());
    let hop_one_first = statement.problem.pairs[0].hop == 1;
    let (giver, taker) = if hop_one_first { (first, second) } else { (second, first) };
    assert!(at(giver, 1) < at(taker, 0), "the object is placed before it is picked: {commits:?}");
    assert_eq!(commits.len(), 6);
}

#[test]
fn a_mode_without_a_way_revises_the_alternative_of_its_pair_and_no_other() {
    let statement = relay();
    let mut stages = Scripted::new(&statement, vec![transfer_fails_with(0, 0..2)]);
    let run = stages.run();
    assert!(matches!(run.end, End::Solved { .. }));
    let revised: Vec<Decision> = decisions(&run.ledger)
        .into_iter()
        .filter(|decision| matches!(decision, Decision::Alternative { .. }))
        .collect();
    let pair = PairId::at(statement.problem.pairs.iter().position(|pair| pair.robot.0 == 0).unwrap());
    assert_eq!(revised, [1, 2].map(|index| Decision::Alternative { pair, index }));
    assert_eq!(stages.count(|request| matches!(request, Request::Placement(_))), 1);
    assert_eq!(stages.count(|request| matches!(request, Request::Transition(_))), 2);
}

/// The roadmap with grasp 0 is obstructed by the first possible pose, those with other grasps do not connect.
fn obstructed_or_disconnected(robot: u32) -> Rule {
    Box::new(move |request| match request {
        Request::Mode(job) if job.mode.robot.0 == robot && !job.possible.is_empty() => match job.holding {
            Some(holding) if holding.grasp.0 > 0 => Some(fails(no_path("x"), Soundness::Soft { level: 0 })),
            Some(_) => {
                let digest = Digest::of("test", &[&contract::encode_canonical(job)]);
                let roadmap = ProductRef { digest, made_by: JobId(digest) };
                Some(Outcome::answer(Answer::Mode { roadmap, shortest_s: 1.0, in_the_way: vec![0] }, 1))
            }
            None => None,
        },
        _ => None,
    })
}

#[test]
fn a_detour_on_which_nothing_connects_ends_where_it_began_and_the_ordering_is_added() {
    let statement = statement("t05_tiny_region");
    let mut stages = Scripted::new(&statement, vec![obstructed_or_disconnected(0)]);
    let run = stages.run();
    assert!(matches!(run.end, End::Solved { .. }), "{:?}", run.end);
    let orders = decisions(&run.ledger).into_iter().filter(|decision| matches!(decision, Decision::Order(_)));
    assert_eq!(orders.count(), 1);
    assert_eq!(stages.count(|request| matches!(request, Request::Placement(_))), 1);
}

#[test]
fn when_no_alternative_is_left_the_next_placement_is_tried_and_later_stages_wait() {
    let statement = relay();
    let rule: Rule = Box::new(|request| match request {
        Request::Transition(_) => Some(fails(Cause::NoCommonGrasp { pair: "p".into() }, Soundness::Soft { level: 0 })),
        _ => None,
    });
    let mut stages = Scripted::new(&statement, vec![rule]);
    let run = stages.run();
    let End::Failed { result, causes, .. } = run.end else { panic!("solved without a grasp") };
    assert_eq!(result, ResultKind::SamplesExhausted);
    assert_eq!(causes[0].0, Cause::NoCommonGrasp { pair: "p".into() });
    let levels = decisions(&run.ledger).into_iter().filter(|d| matches!(d, Decision::Level(_))).count();
    assert_eq!(levels, 2);
    let placements = stages.count(|request| matches!(request, Request::Placement(_)));
    assert!(placements > levels, "{placements}");
    assert_eq!(
        stages.count(|request| matches!(request, Request::Piece(_) | Request::Mode(_) | Request::Compose(_))),
        0
    );
}

#[test]
fn a_hard_failure_of_placement_ends_the_search_at_once() {
    let statement = relay();
    let cause = Cause::NoPlacement { object: "o".into(), region: "w".into() };
    let hard = fails(cause.clone(), Soundness::Hard);
    let rule: Rule = Box::new(move |request| matches!(request, Request::Placement(_)).then(|| hard.clone()));
    let mut stages = Scripted::new(&statement, vec![rule]);
    let run = stages.run();
    assert_eq!(stages.asked.len(), 1);
    let result = ResultKind::SamplesExhausted;
    assert_eq!(run.end, End::Failed { result, causes: vec![(cause, 1)], certificate: None });
}

#[test]
fn where_no_mode_can_be_committed_the_composite_search_is_asked_and_then_an_alternative_revised() {
    let statement = relay();
    let blocked = |request: &Request, with_drrt: bool| match request {
        Request::Compose(job) if job.assignment.grasps.iter().any(|grasp| grasp.0 == 0) => match job.composition {
            Composition::CommitMode { mode, .. } | Composition::Repair { mode, .. } => mode.step == 1,
            Composition::Drrt { .. } => with_drrt,
            Composition::Assemble { .. } | Composition::Synchronous { .. } | Composition::Passages { .. } => false,
        },
        _ => false,
    };
    let deadlock = || fails(Cause::Deadlock { robots: vec!["r1".into(), "r2".into()] }, Soundness::Soft { level: 0 });
    let helped = move |request: &Request| blocked(request, false).then(deadlock);
    let mut stages = Scripted::new(&statement, vec![Box::new(helped)]);
    let run = stages.run();
    assert!(matches!(run.end, End::Solved { .. }));
    assert_eq!(decisions(&run.ledger).last(), Some(&Decision::Drrt));
    let unhelped = move |request: &Request| blocked(request, true).then(deadlock);
    let mut stages = Scripted::new(&statement, vec![Box::new(unhelped)]);
    let run = stages.run();
    assert!(matches!(run.end, End::Solved { .. }), "{:?}", run.end);
    assert!(decisions(&run.ledger).iter().any(|d| matches!(d, Decision::Alternative { index: 1, .. })));
}

/// A mode of the first robot cannot be committed while the first alternative of its pair is chosen.
fn stuck(request: &Request) -> Option<Outcome> {
    let is_stuck = match request {
        Request::Compose(job) => matches!(&job.composition, Composition::CommitMode { mode, .. }
            if (mode.robot.0, mode.step) == (0, 1) && job.assignment.grasps[0].0 == 0),
        _ => false,
    };
    let deadlock = Cause::Deadlock { robots: vec!["r1".into(), "r2".into()] };
    is_stuck.then(|| fails(deadlock, Soundness::Soft { level: 0 }))
}

fn repairs(stages: &Scripted<'_>) -> Vec<(ModeId, usize)> {
    let of_job = |job: &Job| match &job.request {
        Request::Compose(ComposeJob { composition: Composition::Repair { mode, robots, .. }, .. }) => {
            Some((*mode, robots.len()))
        }
        _ => None,
    };
    stages.asked.iter().filter_map(of_job).collect()
}

#[test]
fn behind_a_repair_modes_are_committed_one_by_one_again() {
    let statement = relay();
    let mut stages = Scripted::new(&statement, vec![Box::new(stuck)]);
    let run = stages.run();
    assert!(matches!(run.end, End::Solved { .. }));
    let mode = ModeId { robot: RobotId(0), step: 1 };
    assert_eq!(repairs(&stages), [(mode, 2)]);
    let decided = decisions(&run.ledger);
    let repair = decided.iter().position(|decision| *decision == Decision::Repair(mode)).unwrap();
    let behind: Vec<&Decision> = decided[repair + 1..].iter().collect();
    assert_eq!(behind[0], &Decision::Commit(mode));
    assert!(behind.len() > 1 && behind.iter().all(|decision| matches!(decision, Decision::Commit(_))), "{behind:?}");
    assert_eq!(stages.count(Request::is_drrt), 0);
}

#[test]
fn where_a_mode_has_no_passage_its_pairs_are_revised_at_once() {
    let statement = relay();
    let no_passage: Rule = Box::new(|request| match request {
        Request::Compose(job) if matches!(job.composition, Composition::Passages { .. }) => {
            let mode = ModeId { robot: RobotId(0), step: 1 };
            Some(Outcome::answer(Answer::NoPassage(vec![(mode, RobotId(1))]), 1))
        }
        _ => None,
    });
    let mut stages = Scripted::new(&statement, vec![no_passage, Box::new(stuck)]);
    let run = stages.run();
    assert!(matches!(run.end, End::Solved { .. }), "{:?}", run.end);
    assert!(repairs(&stages).is_empty() && stages.count(Request::is_drrt) == 0);
    let revised = |decision: &Decision| matches!(decision, Decision::Alternative { pair: PairId(0), .. });
    assert!(decisions(&run.ledger).iter().any(revised));
}

#[test]
fn a_run_that_is_cut_short_leaves_a_prefix_of_the_whole_ledger() {
    let statement = relay();
    let rules = || vec![transfer_fails_with(0, 0..2), transfer_fails_with(1, 0..1)];
    let mut stages = Scripted::new(&statement, rules());
    let whole = stages.run();
    let jobs = stages.asked.len();
    assert!(jobs > 30);
    for patience in 0..jobs {
        let mut stages = Scripted::new(&statement, rules());
        stages.patience = patience;
        let cut = stages.run();
        assert!(matches!(cut.end, End::Failed { result: ResultKind::LimitReached, .. }));
        assert_eq!(cut.ledger.entries[..], whole.ledger.entries[..cut.ledger.entries.len()]);
    }
}

#[test]
fn counts_of_stages_count_each_job_once() {
    let statement = relay();
    let mut stages = Scripted::new(&statement, vec![transfer_fails_with(0, 0..2)]);
    let run = stages.run();
    let mut distinct: BTreeMap<String, std::collections::BTreeSet<JobId>> = BTreeMap::new();
    for job in &stages.asked {
        distinct.entry(job.stage().name().to_owned()).or_default().insert(job.id(&statement));
    }
    for count in &run.stages {
        assert_eq!(count.jobs, distinct[&count.stage].len() as u64, "{}", count.stage);
    }
    let mut tally = CauseTally::default();
    tally.count(no_path("x"));
    assert_eq!(tally.ranked(), [(no_path("x"), 1)]);
}

#[test]
fn of_pairs_that_exclude_one_another_whatever_their_alternatives_every_combination_is_looked_at_once() {
    let mut statement = statement("t10_swap_with_buffer");
    statement.options.candidates = 3;
    // The way from one pair's object to the next one's.
    let no_way_on: Rule = Box::new(|request| match request {
        Request::Mode(job) if job.mode.step == 2 => Some(fails(no_path("x"), Soundness::Soft { level: 0 })),
        _ => None,
    });
    let mut stages = Scripted::new(&statement, vec![no_way_on]);
    let End::Failed { result, causes, .. } = stages.run().end else { panic!("solved without a way") };
    assert_eq!(result, ResultKind::SamplesExhausted);
    // Three alternatives at level 0, six at level 1, three candidates at each.
    let combinations = 3 * (3 * 3 + 6 * 6);
    assert_eq!(causes, [(no_path("x"), combinations)]);
    let looks = stages.count(|request| matches!(request, Request::Mode(job) if job.mode.step == 2));
    assert_eq!(looks as u64, combinations);
}
