//! The form of plans.

use contract::{Answer, Composition, DiscoveredOrder};
use model::Point;
use plan::{BodyRef, Cause, EventKind, ModeKind, Plan, SegmentKind};
use skeleton::Event;

use crate::toys::{Dice, Errand, SPEED, Toy, World, random_world};

fn planned(toy: &Toy) -> Option<Plan> {
    let (prefix, _) = toy.commit_all(|_| ());
    prefix.filter(|prefix| toy.is_complete(Some(*prefix))).map(|prefix| toy.assemble(prefix))
}

fn relay() -> Toy {
    let mut world = World::grid(5, 3, 0.7);
    world.starts = vec![0, 4];
    world.objects = vec![5];
    world.errands =
        vec![Errand { robot: 0, object: 0, from: 5, to: 7 }, Errand { robot: 1, object: 0, from: 7, to: 13 }];
    (world.arms, world.grip_time) = (true, 0.5);
    world.build()
}

#[test]
fn waits_taken_out_never_make_a_plan_longer() {
    let mut shorter = 0;
    for seed in 0..25 {
        let mut dice = Dice(seed * 65_537 + 1);
        let (robots, errands) = (2 + dice.below(2), 1 + dice.below(2));
        let toy = random_world(&mut dice, 8, 4, robots, errands).build();
        let (prefix, _) = toy.commit_all(|_| ());
        let Some(prefix) = prefix.filter(|prefix| toy.is_complete(Some(*prefix))) else { continue };
        let (plan, commitments) = (toy.assemble(prefix), toy.commitments(prefix));
        for event in &plan.events {
            let pair = toy.problem().pairs.iter().position(|pair| pair.name == event.pair).unwrap();
            let robot = toy.problem().pairs[pair].robot;
            let before = toy.problem().pairs[..pair].iter().filter(|other| other.robot == robot).count();
            let step = 2 * before + usize::from(event.kind == EventKind::Detach);
            let mode = crate::toys::mode(robot.index(), step as u32);
            let committed_s = commitments.iter().find(|c| c.mode == mode).unwrap().event_s;
            assert!(event.t <= committed_s + 1e-9, "seed {seed}: {} s, committed at {committed_s} s", event.t);
            shorter += usize::from(event.t < committed_s - 0.01);
        }
        let committed_s = commitments.iter().flat_map(|c| &c.moves).fold(0.0, |end: f64, m| end.max(m.ends_s));
        assert!(plan.makespan.total_s <= committed_s + 1e-9, "seed {seed}");
    }
    println!("{shorter} events came earlier");
}

#[test]
fn knots_are_strictly_later_and_no_faster_than_the_robot_and_segments_cover_them() {
    for seed in 0..15 {
        let mut dice = Dice(seed * 997 + 77);
        let toy = random_world(&mut dice, 8, 4, 2, 2).build();
        let Some(plan) = planned(&toy) else { continue };
        for (robot, of_problem) in plan.robots.iter().zip(&toy.problem().robots) {
            assert_eq!(robot.knots[0].q, of_problem.start);
            assert_eq!(robot.knots[0].t, 0.0);
            for pair in robot.knots.windows(2) {
                let least = of_problem.duration(&pair[0].q, &pair[1].q);
                assert!(pair[1].t > pair[0].t && pair[1].t - pair[0].t >= least * (1.0 - 1e-9), "seed {seed}");
            }
            let mut reached = 0;
            for segment in &robot.segments {
                assert!(segment.from == reached && segment.to >= segment.from, "seed {seed}: {segment:?}");
                reached = segment.to;
                let stands = |k: usize| robot.knots[k].q == robot.knots[k + 1].q;
                let drives = |k: usize| robot.knots[k].q[..3] != robot.knots[k + 1].q[..3];
                assert!((segment.from..segment.to).all(|k| match segment.kind {
                    SegmentKind::Wait => stands(k),
                    SegmentKind::Base => drives(k),
                    SegmentKind::Reach | SegmentKind::Retract => !stands(k) && !drives(k),
                }));
            }
            assert_eq!(reached, robot.knots.len() - 1);
        }
    }
}

#[test]
fn objects_are_attached_where_they_stand_and_detached_where_they_are_assigned() {
    let toy = relay();
    let plan = planned(&toy).unwrap();
    let kinds: Vec<(EventKind, &str)> = plan.events.iter().map(|e| (e.kind, e.pair.as_str())).collect();
    let (attach, detach) = (EventKind::Attach, EventKind::Detach);
    assert_eq!(kinds, [(attach, "r1.1"), (detach, "r1.1"), (attach, "r2.1"), (detach, "r2.1")]);
    let poses = &toy.assignment.poses[0];
    for (event, pose) in plan.events.iter().zip([&poses[0], &poses[1], &poses[1], &poses[2]]) {
        assert_eq!(event.world_from_object, (*pose).into());
        let robot = plan.robots.iter().find(|robot| robot.name == event.robot).unwrap();
        assert_eq!(robot.knots[event.knot].t, event.t);
    }
    assert_eq!(plan.events[0].link_from_object, plan.events[1].link_from_object);
    assert_eq!(plan.events[2].link_from_object, plan.events[3].link_from_object);
}

#[test]
fn a_hand_pauses_after_its_events_and_the_retract_is_its_pairs() {
    let toy = relay();
    let plan = planned(&toy).unwrap();
    for event in &plan.events {
        let robot = plan.robots.iter().find(|robot| robot.name == event.robot).unwrap();
        let pause = &robot.knots[event.knot..=event.knot + 1];
        assert!(pause[0].q == pause[1].q && pause[1].t - pause[0].t >= 0.5 - 1e-12);
        let retract = robot.segments.iter().find(|s| s.kind == SegmentKind::Retract && s.from > event.knot).unwrap();
        assert_eq!(retract.pair.as_ref(), Some(&event.pair));
        assert_eq!(robot.knots[retract.to].q[3], 0.0);
    }
    let back = plan.robots[0].segments.last().unwrap();
    assert_eq!((back.pair.as_ref(), back.mode, back.kind), (None, ModeKind::Return, SegmentKind::Base));
}

#[test]
fn the_task_is_over_when_the_last_arm_is_folded_and_the_bound_holds() {
    let toy = relay();
    let (prefix, _) = toy.commit_all(|_| ());
    // Least times by hand: 0.7 m straight drives and a second for the hand.
    let (drive, hand) = (0.7 / SPEED, 1.0);
    let shortest_s = vec![
        vec![drive + hand, 2.0 * hand + 2.0 * drive, hand + 3.0 * drive],
        vec![3.0 * drive + hand, 2.0 * hand + 2.0 * drive, hand + 3.0 * drive],
    ];
    let job =
        toy.job(Composition::Assemble { prefix: prefix.unwrap(), shortest_s: shortest_s.clone(), rounds: vec![] });
    let Ok(Answer::Plan { plan, makespan_s }) = toy.ask(&job).unwrap().result else { panic!("no plan") };
    let contract::Product::Plan(bytes) = toy.get(plan) else { panic!("no plan") };
    let plan = plan::read_plan(&bytes).unwrap();
    let last = plan.events.last().unwrap();
    assert_eq!(plan.makespan.task_s, makespan_s);
    assert!((plan.makespan.task_s - (last.t + 0.5 + hand)).abs() < 1e-9, "{:?}", plan.makespan);
    assert!(plan.makespan.total_s > plan.makespan.task_s);
    // r1 picks, pauses, places; then r2 picks where it has been put, and places: each with its pause.
    let released = drive + hand + 0.5 + 2.0 * hand + 2.0 * drive;
    let bound = released + 0.5 + 2.0 * hand + 2.0 * drive + 0.5 + hand;
    assert_eq!(plan.lower_bound.kind, "assignment-roadmap");
    assert!((plan.lower_bound.seconds - bound).abs() < 1e-9, "{} s, by hand {bound} s", plan.lower_bound.seconds);
    assert!(plan.lower_bound.seconds <= plan.makespan.task_s);
}

#[test]
fn robots_far_apart_need_no_arc_and_never_wait() {
    let mut world = World::grid(3, 9, 0.7);
    world.starts = vec![0, 24];
    world.objects = vec![1, 25];
    world.errands =
        vec![Errand { robot: 0, object: 0, from: 1, to: 4 }, Errand { robot: 1, object: 1, from: 25, to: 22 }];
    let plan = planned(&world.build()).unwrap();
    assert_eq!(plan.dependencies, []);
    assert!(plan.robots.iter().flat_map(|robot| &robot.segments).all(|s| s.kind != SegmentKind::Wait));
}

#[test]
fn orderings_of_hops_are_listed_as_given() {
    let plan = planned(&relay()).unwrap();
    let listed: Vec<(&str, model::Point, &str, model::Point)> = plan
        .orderings
        .iter()
        .map(|o| (o.before.pair.as_str(), o.before.point, o.after.pair.as_str(), o.after.point))
        .collect();
    assert_eq!(listed, [("r1.1", model::Point::Release, "r2.1", model::Point::Grasp)]);
    assert!(plan.orderings.iter().all(|ordering| ordering.origin == plan::Origin::Given));
}

/// r2 brings m2 along a corridor in which m1 stands, until r1 takes it into a niche.
fn corridor_with_niche() -> Toy {
    let mut world = World::grid(5, 1, 0.7);
    world.points.push([1.4, 0.7]);
    world.ways.push((2, 5));
    (world.starts, world.objects) = (vec![5, 0], vec![2, 0]);
    world.errands =
        vec![Errand { robot: 0, object: 0, from: 2, to: 5 }, Errand { robot: 1, object: 1, from: 0, to: 4 }];
    world.arms = true;
    world.build()
}

#[test]
fn only_orderings_that_the_motion_needs_and_that_follow_from_no_others_are_listed() {
    let mut toy = corridor_with_niche();
    let order = |before: Event, after: Event, cause: Cause| DiscoveredOrder { before, after, cause };
    let in_the_way = |pair: &str, robot: &str, object: &str| Cause::NoPath {
        pair: Some(pair.into()),
        robot: robot.into(),
        blocking: vec![BodyRef::Object(object.into())],
    };
    let [first, second] = [0, 1].map(crate::toys::pair);
    let needed = order(Event::grasp(first), Event::new(second, Point::AtPlace), in_the_way("r2.1", "r2", "m1"));
    let overlap = Cause::Overlap { region: String::new(), leaves: "m1".into(), comes: "m2".into() };
    toy.assignment.orders = vec![
        // It follows from the next one.
        order(Event::grasp(first), Event::release(second), overlap),
        needed.clone(),
        // r1 comes nowhere near where m2 is brought.
        order(Event::new(first, Point::Done), Event::release(second), in_the_way("r1.1", "r1", "m2")),
    ];
    let plan = planned(&toy).unwrap();
    let listed: Vec<_> = plan.orderings.iter().map(|o| (o.before.point, o.after.point, o.cause.clone())).collect();
    assert_eq!(listed, [(Point::Grasp, Point::AtPlace, Some(needed.cause))]);
}
