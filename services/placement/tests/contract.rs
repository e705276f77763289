//! What every stage promises: equal jobs have equal outcomes, samples do not depend on levels, anything may be asked.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod common;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use common::{ONE_SLOT, Scene, WIDE, ask, assert_sound, candidates, job, shipped, stage};
use contract::{Answer, Interrupted, JobContext, JobId, Literal, MemoryProducts, Request, Soundness, Stage, encode};
use model::{FixedId, ObjectId, PairId, Point, Pose, Problem, Shape};
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use plan::{BodyRef, Cause};
use skeleton::{Event, Occupancy};

#[test]
fn the_papers_task_needs_no_order_and_little_work() {
    for scene in ["figure1", "figure1_slots"] {
        let problem = shipped(scene);
        for seed in 0..5 {
            let outcome = ask(&stage(&problem, seed), &job(0, 0, 1, vec![])).unwrap();
            let Ok(Answer::Placements(found)) = &outcome.result else { panic!("{scene}: {outcome:?}") };
            assert_sound(&problem, &found[0]);
            assert!(found[0].orders.is_empty(), "{scene}, seed {seed}: {:?}", found[0].orders);
            assert!(outcome.work < 3_000, "{scene}, seed {seed}: {} work units", outcome.work);
        }
    }
}

#[test]
fn a_job_costs_and_answers_the_same_whatever_was_asked_before() {
    let problem = shipped("t05_tiny_region");
    let jobs = [job(0, 0, 3, vec![]), job(1, 2, 2, vec![]), job(0, 1, 1, vec![]), job(0, 0, 200, vec![])];
    let one_by_one = jobs.clone().map(|job| encode(&ask(&stage(&problem, 7), &job).unwrap()).unwrap());
    let warm = stage(&problem, 7);
    for _ in 0..2 {
        for (job, alone) in jobs.iter().zip(&one_by_one).rev() {
            assert_eq!(&encode(&ask(&warm, job).unwrap()).unwrap(), alone);
        }
    }
    let other_seed = encode(&ask(&stage(&problem, 8), &jobs[3]).unwrap()).unwrap();
    assert_ne!(other_seed, one_by_one[3]);
}

#[test]
fn every_budget_gives_the_same_outcome_warm_or_cold() {
    let problem = shipped("t05_tiny_region");
    let warm = stage(&problem, 0);
    let whole = ask(&warm, &job(0, 0, 3, vec![])).unwrap().work;
    let mut without_answer = 0;
    for budget in (0..whole + 5).step_by(3) {
        let mut job = job(0, 0, 3, vec![]);
        job.budget = budget;
        let outcome = ask(&warm, &job).unwrap();
        assert_eq!(encode(&outcome).unwrap(), encode(&ask(&stage(&problem, 0), &job).unwrap()).unwrap(), "{budget}");
        if let Err(report) = &outcome.result {
            assert!(report.causes.contains(&(Cause::Budget { stage: "placement".into() }, 1)), "{report:?}");
            assert_eq!(report.soundness, Soundness::Soft { level: 0 });
            without_answer += 1;
        }
    }
    assert!(without_answer > 10, "{without_answer}");
}

#[test]
fn a_window_of_candidates_is_a_part_of_the_whole_sequence() {
    let problem = shipped("t05_tiny_region");
    let stage = stage(&problem, 1);
    let all = candidates(&stage, &job(0, 0, 60, vec![]));
    assert_eq!(all.len(), 60);
    assert!(all.iter().enumerate().all(|(i, candidate)| candidate.index as usize == i));
    assert!(all.windows(2).all(|two| two[0].orders.len() <= two[1].orders.len()));
    assert_eq!(candidates(&stage, &job(0, 17, 30, vec![])), all[17..47]);
    all.iter().for_each(|candidate| assert_sound(&problem, candidate));
}

#[test]
fn the_sequence_ends_and_then_has_nothing_more() {
    let mut problem = shipped("t05_tiny_region");
    problem.levels.placements = 2;
    let stage = stage(&problem, 0);
    let all = candidates(&stage, &job(0, 0, 1000, vec![]));
    assert!((2..1000).contains(&all.len()), "{}", all.len());
    assert_eq!(candidates(&stage, &job(0, all.len() as u32, 5, vec![])), []);
    assert_eq!(candidates(&stage, &job(0, 0, 0, vec![])), []);
}

#[test]
fn samples_of_a_level_are_the_first_ones_of_the_next() {
    let mut problem = shipped("figure1");
    problem.levels.placements = 4;
    let pose_of = |level| {
        let all = candidates(&stage(&problem, 3), &job(level, 0, 2000, vec![]));
        let placed = all.into_iter().flat_map(|candidate| candidate.placements);
        placed.map(|p| ((p.pair, p.sample), p.world_from_object)).collect::<Vec<((PairId, u32), Pose)>>()
    };
    let (coarse, fine) = (pose_of(0), pose_of(1));
    let late = fine.iter().filter(|((_, sample), _)| *sample >= 4).count();
    assert!(late > 100 && coarse.iter().all(|((_, sample), _)| *sample < 4), "{late}");
    for (key, pose) in &coarse {
        let same = fine.iter().find(|(other, _)| other == key).unwrap();
        assert_eq!(&same.1, pose, "{key:?}");
    }
}

/// Regions of many sizes and turns, objects of many sizes; whatever fits is placed inside.
#[test]
fn poses_lie_inside_of_their_regions() {
    let mut tight = 0;
    for round in 0..120_u32 {
        let fraction = |step: u32| f64::from(round * step % 120) / 120.0;
        let size = [0.04 + 0.1 * fraction(7), 0.03 + 0.08 * fraction(11), 0.1];
        let shortest = size[0].min(size[1]) + 0.011;
        let region = [size[0].max(size[1]) + 0.011 + 0.2 * fraction(17), shortest + 0.1 * fraction(13)];
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 6.0 * fraction(1));
        let place = Pose::from_parts(Translation3::new(5.0, -1.0, 0.6), turn);
        let scene = Scene::new(1).table("from", WIDE).fixed("big", [2.0, 2.0, 0.6], Pose::translation(5.0, -1.0, 0.3));
        let scene = scene.region("to", FixedId(1), place, region).object("m", Shape::Box { size }, "from", [0.0, 0.0]);
        let problem = scene.moves(1, "m", "from", "to").0;
        let all = candidates(&stage(&problem, u64::from(round)), &job(0, 0, 100, vec![]));
        assert_eq!(all.len(), 32, "nothing is in the way of any sample: round {round}");
        all.iter().for_each(|candidate| assert_sound(&problem, candidate));
        tight += usize::from(region[1] < shortest + 0.01);
    }
    assert!(tight > 5, "{tight}");
}

#[test]
fn objects_in_regions_that_touch_keep_apart() {
    // Two strips side by side: a box on the common border of one hangs over neither, but boxes on both sides may touch.
    let mut scene = Scene::new(2).table("from", WIDE).fixed("desk", [1.0, 1.0, 0.6], Pose::translation(4.0, 0.0, 0.3));
    scene = scene.region("left", FixedId(1), Pose::translation(3.96, 0.0, 0.6), [0.08, 0.1]);
    scene = scene.region("right", FixedId(1), Pose::translation(4.03, 0.0, 0.6), [0.08, 0.1]);
    scene.0.settings.region_margin = 0.0;
    let scene = scene.carton("x", "from", [0.0, 0.0]).carton("y", "from", [0.2, 0.0]);
    let problem = scene.moves(1, "x", "from", "left").moves(2, "y", "from", "right").0;
    for seed in 0..20 {
        let all = candidates(&stage(&problem, seed), &job(0, 0, 50, vec![]));
        all.iter().for_each(|candidate| assert_sound(&problem, candidate));
        assert!(!all.is_empty() && all.len() < 1024, "seed {seed}");
    }
}

#[test]
fn what_blocks_every_sample_is_named() {
    let scene = Scene::new(1).table("from", WIDE).table("to", ONE_SLOT);
    let scene = scene.fixed("lid", [0.5, 0.5, 0.02], Pose::translation(2.0, 0.0, 0.7));
    let problem = scene.carton("m", "from", [0.0, 0.0]).moves(1, "m", "from", "to").0;
    let report = common::failure(&problem);
    assert_eq!(report.soundness, Soundness::Soft { level: 0 });
    let collision = Cause::Collision { first: BodyRef::Object("m".into()), second: BodyRef::Fixed("lid".into()) };
    let unplaced = Cause::NoPlacement { object: "m".into(), region: "to".into() };
    assert_eq!(report.causes, [(collision, 32), (unplaced, 1)]);
}

/// Objects that half of the robots bring from tables to one region `mid`, and the others from there to `to`.
fn passing(objects: usize, robots: usize, mid: [f64; 2], samples: u32) -> Problem {
    let mut scene = Scene::new(2 * robots).table("from", [0.9, 0.9]).table("mid", mid).table("to", [0.9, 0.9]);
    let names: Vec<String> = (0..objects).map(|i| format!("m{i}")).collect();
    for (i, name) in names.iter().enumerate() {
        scene = scene.carton(name, "from", [0.12 * (i % 6) as f64 - 0.3, 0.15 * (i / 6) as f64 - 0.3]);
    }
    for (leg, way) in [["from", "mid"], ["mid", "to"]].into_iter().enumerate() {
        for robot in 0..robots {
            let mine = names.iter().skip(robot).step_by(robots);
            scene = mine.fold(scene, |scene, name| scene.moves(1 + leg * robots + robot, name, way[0], way[1]));
        }
    }
    scene.0.levels.placements = samples;
    scene.0
}

#[test]
fn sixteen_hops_of_128_samples_are_placed_with_little_work() {
    for region in [WIDE, [0.4, 0.2], [0.3, 0.17]] {
        let problem = passing(8, 2, region, 128);
        let outcome = ask(&stage(&problem, 0), &job(0, 0, 20, vec![])).unwrap();
        let Ok(Answer::Placements(found)) = &outcome.result else { panic!("{region:?}: {outcome:?}") };
        assert_eq!(found.len(), 20);
        found.iter().for_each(|candidate| assert_sound(&problem, candidate));
        assert!(found.iter().all(|candidate| candidate.orders.is_empty()));
        assert!(outcome.work < 120_000, "{region:?}: {} work units", outcome.work);
    }
}

#[test]
fn regions_too_small_for_all_at_once_are_passed_in_turn() {
    // Objects, robots on each side, region, least orders; 0.16 by 0.1 has room for two.
    let cases = [(8, 4, ONE_SLOT, 7), (8, 2, ONE_SLOT, 7), (8, 4, [0.16, 0.1], 3), (8, 1, [0.25, 0.12], 1)];
    for (objects, robots, region, orders) in cases {
        let problem = passing(objects, robots, region, 32);
        let outcome = ask(&stage(&problem, 0), &job(0, 0, 1, vec![])).unwrap();
        let Ok(Answer::Placements(found)) = &outcome.result else { panic!("{region:?}: {outcome:?}") };
        assert_sound(&problem, &found[0]);
        assert_eq!(found[0].orders.len(), orders, "{objects} objects in {region:?}");
        assert!(outcome.work < 1_000_000, "{objects} objects in {region:?}: {} work units", outcome.work);
    }
}

/// Here the least number of orders is out of reach of an exhaustive search.
#[test]
fn regions_far_too_small_for_all_at_once_are_passed_in_turn_within_the_budget() {
    for (objects, robots, region) in [(16, 2, [0.3, 0.17]), (16, 2, ONE_SLOT), (24, 2, [0.4, 0.2])] {
        let problem = passing(objects, robots, region, 32);
        let outcome = ask(&stage(&problem, 0), &job(0, 0, 3, vec![])).unwrap();
        let Ok(Answer::Placements(found)) = &outcome.result else { panic!("{region:?}: {outcome:?}") };
        assert_eq!(found.len(), 3);
        found.iter().for_each(|candidate| assert_sound(&problem, candidate));
        assert!((1..objects).contains(&found[0].orders.len()), "{:?}", found[0].orders);
        assert!(outcome.work < 2_500_000, "{objects} objects in {region:?}: {} work units", outcome.work);
    }
}

#[test]
fn jobs_that_make_no_sense_are_refused_or_answered() {
    let problem = shipped("t05_tiny_region");
    let stage = stage(&problem, 0);
    for (level, count) in [(u32::MAX, 1), (64, 1), (12, 1), (0, u32::MAX)] {
        assert!(matches!(ask(&stage, &job(level, 0, count, vec![])), Err(Interrupted::Unfit(_))), "{level} {count}");
    }
    let unknown = Occupancy { object: ObjectId(99), hop: 1 };
    let far = Event::new(PairId(9_999_999), Point::Grasp);
    let nogoods = vec![
        vec![Literal::Pose { occupancy: unknown, sample: 0 }],
        vec![Literal::Pose { occupancy: Occupancy { object: ObjectId(0), hop: 1 }, sample: u32::MAX }],
        vec![Literal::Order { before: far, after: far }],
        vec![Literal::Alternative { pair: PairId(0), index: 0 }],
    ];
    assert_eq!(candidates(&stage, &job(0, 0, 1, nogoods)), candidates(&stage, &job(0, 0, 1, vec![])));
    // Nothing at all is forbidden together: everything is.
    assert!(ask(&stage, &job(0, 0, 1, vec![vec![]])).unwrap().result.is_err());
    let start = Literal::Pose { occupancy: Occupancy { object: ObjectId(0), hop: 0 }, sample: 0 };
    assert!(ask(&stage, &job(0, 0, 1, vec![vec![start]])).unwrap().result.is_err());
    let mode = contract::BlockersJob {
        robot: model::RobotId(0),
        holding: model::Holding { object: ObjectId(0), grasp: model::GraspId(0) },
        reach: contract::Reach {
            stand: vec![],
            at_object: vec![],
            approach: vec![],
            lift: vec![],
            lift_up: 0,
            support: FixedId(0),
        },
        standing: vec![],
    };
    let foreign = contract::Job { request: Request::Blockers(mode), budget: 1 };
    assert!(matches!(ask(&stage, &foreign), Err(Interrupted::Unfit(_))));
}

#[test]
fn a_cancelled_job_has_no_outcome() {
    let problem = shipped("t05_tiny_region");
    let job = job(0, 0, 1, vec![]);
    let id = JobId(contract::Digest([0; 32]));
    let products = MemoryProducts::default();
    let mut context = JobContext::new(id, &job, &products, Arc::new(AtomicBool::new(true)));
    assert_eq!(stage(&problem, 0).refine(&job, &mut context), Err(Interrupted::Cancelled));
}
