//! Corrupted copies of valid plans are rejected, each for the rule it breaks and for no other.

use model::{Point, Problem};
use nalgebra::{UnitQuaternion, Vector3};
use plan::{Dependency, Event, EventKind, KnotRef, Origin, PairPoint, Plan, PlanOrdering, PoseRecord, SegmentKind};
use validation::Rule;

use crate::fixture::{accepted, add_pair, rejected, report_makespan, rules};
use crate::scenarios::{GRASP, relay, rover_round_wall, side_by_side, single};

mod gates;
mod geometry;

/// Moves all knots of one robot from `knot` on by `dt`, with its events.
pub fn shift(plan: &mut Plan, robot: usize, knot: usize, dt: f64) {
    let name = plan.robots[robot].name.clone();
    for later in &mut plan.robots[robot].knots[knot..] {
        later.t += dt;
    }
    for event in plan.events.iter_mut().filter(|event| event.robot == name) {
        event.t = plan.robots[robot].knots[event.knot].t;
    }
    plan.events.sort_by(|a, b| a.t.total_cmp(&b.t));
    report_makespan(plan);
}

/// Applies one corruption to a fresh copy of a valid plan, and expects `rule` alone.
#[track_caller]
pub fn corrupt((problem, mut plan): (Problem, Plan), rule: Rule, change: impl FnOnce(&mut Plan)) {
    accepted(&problem, &plan);
    change(&mut plan);
    rejected(&problem, &plan, rule);
}

/// Applies one change to the problem under a valid plan, and expects `rule` alone.
#[track_caller]
pub fn change((mut problem, plan): (Problem, Plan), rule: Rule, change: impl FnOnce(&mut Problem)) {
    accepted(&problem, &plan);
    change(&mut problem);
    rejected(&problem, &plan, rule);
}

fn turned(record: PoseRecord, about: Vector3<f64>, degrees: f64) -> PoseRecord {
    let pose = model::Pose::from(record);
    let turn = UnitQuaternion::new(about * degrees.to_radians());
    PoseRecord::from(model::Pose::from_parts(pose.translation, pose.rotation * turn))
}

#[test]
fn v1_malformed_trajectories() {
    corrupt(single(), Rule::V1, |plan| plan.robots[0].knots[3].t = plan.robots[0].knots[2].t);
    corrupt(single(), Rule::V1, |plan| plan.robots[0].knots[3].q[1] = f64::NAN);
    corrupt(single(), Rule::V1, |plan| plan.robots[0].knots[3].q.truncate(2));
    corrupt(single(), Rule::V1, |plan| plan.robots[0].knots.clear());
    corrupt(single(), Rule::V1, |plan| plan.robots[0].knots[0].t = -0.1);
    corrupt(single(), Rule::V1, |plan| plan.robots[0].joints.swap(0, 1));
    corrupt(single(), Rule::V1, |plan| drop(plan.robots[0].segments.remove(2)));
    corrupt(single(), Rule::V1, |plan| drop(plan.robots[0].segments.pop()));
    corrupt(single(), Rule::V1, |plan| plan.robots[0].segments[0].pair = Some("nobody's".to_owned()));
    corrupt(relay(), Rule::V1, |plan| plan.robots.swap(0, 1));
    corrupt(single(), Rule::V1, |plan| plan.format = "mrtamp-plan/2".to_owned());
    corrupt(single(), Rule::V1, |plan| plan.problem = "another".to_owned());
    corrupt(single(), Rule::V1, |plan| plan.makespan.task_s = f64::NAN);
}

#[test]
fn v2_another_start() {
    // Towards the first table, so that no speed is exceeded.
    corrupt(single(), Rule::V2, |plan| plan.robots[0].knots[0].q[0] -= 2e-9);
    corrupt(rover_round_wall(model::EndPolicy::Stay), Rule::V2, |plan| plan.robots[0].knots[0].q[0] += 0.01);
    change(rover_round_wall(model::EndPolicy::Stay), Rule::V2, |problem| problem.robots[0].start[1] += 1e-6);
    corrupt(single(), Rule::V2, |plan| plan.events[0].world_from_object.xyz[0] += 1e-6);
    corrupt(single(), Rule::V2, |plan| {
        let pose = &mut plan.events[0].world_from_object;
        *pose = turned(*pose, Vector3::z(), 0.1);
    });
}

#[test]
fn v3_joint_limits() {
    change(single(), Rule::V3, |problem| problem.robots[0].coordinates[0].lower = -1.0 + 1e-8);
    change(single(), Rule::V3, |problem| problem.robots[0].coordinates[2].lower = GRASP + 1e-8);
    change(rover_round_wall(model::EndPolicy::Stay), Rule::V3, |problem| problem.robots[0].coordinates[1].upper = 2.9);
    change(rover_round_wall(model::EndPolicy::Stay), Rule::V3, |problem| problem.robots[0].coordinates[2].upper = 3.0);
}

#[test]
fn v4_speed_limits() {
    for knot in [1, 2, 4, 5, 10] {
        corrupt(single(), Rule::V4, |plan| shift(plan, 0, knot, -1e-6));
    }
    let rover = || rover_round_wall(model::EndPolicy::Stay);
    corrupt(rover(), Rule::V4, |plan| shift(plan, 0, 1, -1e-3));
    // Both coordinates keep their limit; the norm does not.
    corrupt(rover(), Rule::V4, |plan| {
        let drive = plan.robots[0].segments.iter().rfind(|s| s.kind == SegmentKind::Base).map(|s| s.to);
        shift(plan, 0, drive.expect("it drives"), -0.01);
    });
    change(rover(), Rule::V4, |problem| {
        if let Some(base) = &mut problem.robots[0].base {
            base.yaw_rate = 1.0;
        }
    });
}

#[test]
fn v5_events_out_of_sequence() {
    let kinds = [EventKind::Detach, EventKind::Attach];
    corrupt(single(), Rule::V5, |plan| plan.events.iter_mut().zip(kinds).for_each(|(event, kind)| event.kind = kind));
    corrupt(single(), Rule::V5, |plan| plan.events.swap(0, 1));
    corrupt(single(), Rule::V5, |plan| plan.events[1].kind = EventKind::Attach);
    corrupt(single(), Rule::V5, |plan| drop(plan.events.remove(0)));
    corrupt(single(), Rule::V5, |plan| plan.events[0].t += 1e-12);
    corrupt(single(), Rule::V5, |plan| plan.events[0].knot = 99);
    corrupt(single(), Rule::V5, |plan| plan.events[0].link = "left_finger".to_owned());
    corrupt(single(), Rule::V5, |plan| plan.events[0].link_from_object.quat_xyzw[3] = 1.1);
    corrupt(side_by_side(), Rule::V5, |plan| plan.events[0].pair = "g2.1".to_owned());
    corrupt(side_by_side(), Rule::V5, |plan| plan.events[0].object = "m2".to_owned());
    corrupt(single(), Rule::V5, |plan| plan.events.extend(plan.events.clone()));
    // Says that it is done while the arm is still above the table.
    corrupt(single(), Rule::V5, |plan| {
        plan.robots[0].segments.last_mut().expect("it moves").kind = SegmentKind::Wait;
        report_makespan(plan);
    });
}

#[test]
fn v5_hops_out_of_order() {
    // The second hop's robot comes first, and finds the object on the wrong table; what it does there makes sense otherwise.
    let (mut problem, plan) = relay();
    accepted(&problem, &plan);
    for pair in &mut problem.pairs {
        pair.hop = 3 - pair.hop;
    }
    problem.orderings.clear();
    rejected(&problem, &plan, Rule::V5);
}

#[test]
fn v6_grasps() {
    // 3 mm off in the hand, and the object put down where it then is.
    corrupt(single(), Rule::V6, |plan| {
        plan.events.iter_mut().for_each(|event| event.link_from_object.xyz[0] += 0.003);
        plan.events[1].world_from_object.xyz[0] += 0.003;
    });
    corrupt(single(), Rule::V6, |plan| {
        for event in &mut plan.events {
            event.link_from_object = turned(event.link_from_object, Vector3::z(), 1.0);
        }
        plan.events[1].world_from_object = turned(plan.events[1].world_from_object, Vector3::z(), 1.0);
    });
    corrupt(single(), Rule::V6, |plan| plan.events.iter_mut().for_each(|event| event.opening = 0.045));
    // The hand closes 2 mm beside the object.
    corrupt(single(), Rule::V6, |plan| {
        for knot in [2, 3] {
            plan.robots[0].knots[knot].q[0] += 0.002;
        }
    });
    // Leaves 0.1 s too early after the attach.
    corrupt(single(), Rule::V6, |plan| shift(plan, 0, 3, -0.1));
    change(single(), Rule::V6, |problem| problem.movable[0].grasps[0].clear());
}

#[test]
fn v7_placements() {
    let put = |change: fn(&mut Event)| move |plan: &mut Plan| change(&mut plan.events[1]);
    corrupt(single(), Rule::V7, put(|event| event.world_from_object.xyz[0] += 0.0011));
    corrupt(
        single(),
        Rule::V7,
        put(|event| event.world_from_object = turned(event.world_from_object, Vector3::z(), 0.3)),
    );
    corrupt(
        single(),
        Rule::V7,
        put(|event| event.world_from_object = turned(event.world_from_object, Vector3::y(), 0.01)),
    );
    corrupt(single(), Rule::V7, put(|event| event.link_from_object.xyz[2] += 1e-6));
    corrupt(single(), Rule::V7, put(|event| event.opening = 0.041));
    // Teleported between being put and being taken.
    corrupt(relay(), Rule::V7, |plan| plan.events[2].world_from_object.xyz[1] += 1e-12);
    // Leaves 0.1 s too early after the release.
    let knot = single().1.events[1].knot + 1;
    corrupt(single(), Rule::V7, |plan| shift(plan, 0, knot, -0.1));
    // The footprint of 0.06 × 0.04 needs the margin of 5 mm on all sides.
    for (size, fits) in [([0.0701, 0.2], true), ([0.0699, 0.2], false), ([0.2, 0.0501], true), ([0.2, 0.0499], false)] {
        let (mut problem, plan) = single();
        problem.regions[1].size = size;
        assert_eq!(rules(&problem, &plan), if fits { vec![] } else { vec![Rule::V7] }, "{size:?}");
    }
    change(single(), Rule::V7, |problem| problem.regions[1].world_from_region.translation.z -= 0.0011);
}

#[test]
fn v8_two_hands_on_one_object() {
    let (problem, plan) = relay();
    let (taken, put, second) = (plan.events[0].t, plan.events[1].t, plan.events[2].t);
    for attach in [put - 0.001, put - 1.0, taken + 0.001] {
        let (mut problem, mut plan) = (problem.clone(), plan.clone());
        problem.orderings.clear();
        plan.dependencies.clear();
        plan.robots[1].knots[1].t = 1e-3;
        shift(&mut plan, 1, 2, attach - second);
        // The wait before the work shrinks with it.
        rejected(&problem, &plan, Rule::V8);
    }
}

fn point(pair: &str, point: Point) -> PairPoint {
    PairPoint { pair: pair.to_owned(), point }
}

#[test]
fn v9_orderings_are_strict() {
    // Both robots do the same at the same time; the second is `late` behind the first.
    for at in [Point::AtPick, Point::Grasp, Point::Carry, Point::Release, Point::Done] {
        for (late, kept) in [(-1e-3_f64, false), (0.0, false), (2e-9, true), (1e-3, true)] {
            let (problem, mut plan) = side_by_side();
            shift(&mut plan, 1, 1, late.max(0.0));
            shift(&mut plan, 0, 1, (-late).max(0.0));
            let (before, after) = (point("g1.1", at), point("g2.1", at));
            plan.orderings.push(PlanOrdering { before, after, origin: Origin::Discovered, cause: None });
            // A fixed arm is at its pick from the start on.
            let kept = kept && at != Point::AtPick;
            // Kept or not, nothing calls for it.
            let broken = if kept { Rule::V15 } else { Rule::V9 };
            assert_eq!(rules(&problem, &plan), [broken], "{at:?} {late}");
        }
    }
}

#[test]
fn v9_given_orderings_and_arrivals_of_a_base() {
    let rover = || rover_round_wall(model::EndPolicy::Stay);
    let first = model::PairId(0);
    let order = |before: Point, after: Point| model::GivenOrdering { before: (first, before), after: (first, after) };
    for pair in Point::ALL.windows(2) {
        let (mut problem, plan) = rover();
        problem.orderings.push(order(pair[0], pair[1]));
        accepted(&problem, &plan);
        change(rover(), Rule::V9, |problem| problem.orderings.push(order(pair[1], pair[0])));
    }
    change(relay(), Rule::V9, |problem| {
        problem.orderings[0] =
            model::GivenOrdering { before: (model::PairId(1), Point::Start), after: (model::PairId(0), Point::Start) };
    });
    corrupt(rover(), Rule::V9, |plan| {
        let (before, after) = (point("r1.1", Point::Start), point("r9.1", Point::Start));
        plan.orderings.push(PlanOrdering { before, after, origin: Origin::Discovered, cause: None });
    });
}

#[test]
fn v13_goals() {
    change(single(), Rule::V13, |problem| {
        let (from, to) = (model::RegionId(1), model::RegionId(0));
        add_pair(problem, 0, model::ObjectId(0), from, to);
    });
    let rover = || rover_round_wall(model::EndPolicy::Return);
    for (coordinate, off) in [(0, -0.01), (1, 0.01), (2, 0.01), (3, 2e-6)] {
        corrupt(rover(), Rule::V13, |plan| {
            let last = plan.robots[0].knots.last_mut().expect("it moves");
            last.q[coordinate] += off;
            // Time enough for the detour.
            last.t += 0.1;
            report_makespan(plan);
        });
    }
    corrupt(rover_round_wall(model::EndPolicy::Stay), Rule::V13, |plan| {
        let last = plan.robots[0].knots.last().expect("it moves").clone();
        let (from, to) = (plan.robots[0].knots.len() - 1, plan.robots[0].knots.len());
        plan.robots[0].knots.push(plan::Knot { t: last.t + 0.1, q: [&[last.q[0] - 0.01], &last.q[1..]].concat() });
        let closing = plan::Segment { from, to, pair: None, mode: plan::ModeKind::Return, kind: SegmentKind::Base };
        plan.robots[0].segments.push(closing);
        report_makespan(plan);
    });
    // Comes home with the object in its hand and never puts it down.
    corrupt(single(), Rule::V13, |plan| {
        let home = plan.robots[0].segments.iter().find(|s| plan.robots[0].knots[s.to].q == plan.robots[0].knots[0].q);
        let home = home.expect("it comes home").to;
        plan.robots[0].knots.truncate(home + 1);
        plan.robots[0].segments.truncate(home);
        plan.events.truncate(1);
        report_makespan(plan);
    });
}

#[test]
fn v14_makespans() {
    corrupt(single(), Rule::V14, |plan| plan.makespan.total_s += 2e-9);
    corrupt(single(), Rule::V14, |plan| plan.makespan.task_s -= 2e-9);
    corrupt(rover_round_wall(model::EndPolicy::Return), Rule::V14, |plan| plan.makespan.task_s = plan.makespan.total_s);
    corrupt(single(), Rule::V14, |plan| plan.lower_bound.seconds = plan.makespan.task_s + 1e-6);
}

#[test]
fn v17_dependency_arcs() {
    let arc = |before: (&str, usize), after: (&str, usize)| {
        let knot = |(robot, knot): (&str, usize)| KnotRef { robot: robot.to_owned(), knot };
        Dependency { before: knot(before), after: knot(after) }
    };
    for wrong in [
        arc(("g1", 99), ("g2", 1)),
        arc(("g3", 0), ("g2", 1)),
        arc(("g1", 0), ("g1", 1)),
        // The second robot leaves its first knot at 0.
        arc(("g1", 1), ("g2", 0)),
        arc(("g2", 2), ("g1", 3)),
    ] {
        corrupt(relay(), Rule::V17, |plan| plan.dependencies.push(wrong));
    }
    // The waiting robot leaves 0.2 s too early, while the arc still holds it.
    corrupt(relay(), Rule::V17, |plan| {
        plan.robots[1].knots[1].t -= 0.2;
        shift(plan, 1, 2, -0.2);
    });
}
