//! Corruptions that make bodies meet: V11 and V12.

use model::{Problem, Shape};
use plan::{EventKind, Knot, Plan, SegmentKind};
use validation::Rule;

use super::{change, corrupt, shift};
use crate::fixture::{
    OBJECT, TOP, Writer, accepted, add_fixed, add_object, finish, rejected, report_makespan, violations,
};
use crate::robots::HAND_TO_OBJECT;
use crate::scenarios::{GRASP, TABLES, TRAVEL, relay, rover_round_wall, side_by_side, single};

/// Bottom of a held object while a gantry travels (m).
const CARRIED: f64 = TRAVEL - HAND_TO_OBJECT - OBJECT[2] / 2.0;

#[test]
fn v11_a_robot_comes_too_early() {
    // The second robot reaches into the shared table while the first is still above it.
    let (mut problem, plan) = relay();
    problem.orderings.clear();
    let (put, second) = (plan.events[1].t, plan.events[2].t);
    for after in [0.01, 0.2, 0.4] {
        let mut early = plan.clone();
        early.dependencies.clear();
        early.robots[1].knots[1].t = 1e-3;
        shift(&mut early, 1, 2, put + after - second);
        rejected(&problem, &early, Rule::V11);
        let found = violations(&problem, &early);
        let both = |v: &&validation::Violation| v.robots.len() == 2 && v.t.is_some_and(|t| t < put + 2.0);
        assert!(found.iter().any(|violation| both(&violation)), "{found:?}");
    }
}

#[test]
fn v11_a_wall_between_knots() {
    let rover = || rover_round_wall(model::EndPolicy::Stay);
    for thickness in [0.1, 1e-3, 1e-6] {
        // Between the home of the gantry and table A, and across the rover's way.
        change(single(), Rule::V11, |p| add_fixed(p, "wall", [1.0, thickness, 0.5], [-0.8, -0.3, 0.9]));
        change(rover(), Rule::V11, |p| add_fixed(p, "wall", [thickness, 1.0, 2.0], [0.7, 0.0, 1.0]));
    }
    // The shortest way to the second table leads through the wall.
    corrupt(rover(), Rule::V11, |plan| {
        let robot = &mut plan.robots[0];
        let drives: Vec<usize> = robot.segments.iter().filter(|s| s.kind == SegmentKind::Base).map(|s| s.to).collect();
        let middle = drives[1];
        let (before, after) = (robot.knots[middle - 1].q.clone(), robot.knots[middle + 1].q.clone());
        robot.knots[middle].q = before.iter().zip(&after).map(|(a, b)| f64::midpoint(*a, *b)).collect();
    });
}

#[test]
fn v11_a_held_object_grazes_a_shelf() {
    let shelf = |problem: &mut Problem, top: f64| {
        add_fixed(problem, "shelf", [0.1, 0.1, 0.02], [-0.75, -0.3, top - 0.01]);
    };
    for below in [1e-5, 1e-4, 1e-3] {
        let (mut problem, plan) = single();
        shelf(&mut problem, CARRIED - below);
        let verdict = accepted(&problem, &plan);
        let least = verdict.least_clearance.robot_fixed.expect("it comes close");
        assert!((least - below).abs() < 1e-6, "{least}, expected {below}");
        change(single(), Rule::V11, |problem| shelf(problem, CARRIED + below));
    }
    let (mut problem, plan) = single();
    shelf(&mut problem, CARRIED + 0.001);
    let found = violations(&problem, &plan);
    assert_eq!(
        (&found[0].robots[..], &found[0].objects[..]),
        (&["g1".to_owned()][..], &["m1".to_owned(), "shelf".to_owned()][..])
    );
    assert!(found[0].message.contains("m1 held by g1"), "{}", found[0].message);
}

#[test]
fn v11_other_objects_in_the_way() {
    let region = |i: u32| model::RegionId(i);
    // Where the first is put; under the way; beside where the first stands, in the way of a finger.
    change(single(), Rule::V11, |p| {
        add_object(p, "m2", TABLES[1] + 0.05, 0.0, region(1));
    });
    change(single(), Rule::V11, |p| {
        add_object(p, "m2", TABLES[0], 0.045, region(0));
    });
    change(single(), Rule::V11, |p| {
        add_object(p, "m2", TABLES[0] + 0.05, 0.0, region(0));
    });
    let (mut problem, plan) = single();
    add_object(&mut problem, "m2", TABLES[0], 0.095, region(0));
    accepted(&problem, &plan);
}

#[test]
fn v11_robots_and_their_own_links() {
    let grow = |problem: &mut Problem, edge: f64| {
        problem.robots[0].links[0].bodies[0].shape = Shape::Box { size: [edge, 0.3, 1.0] };
    };
    let (mut problem, plan) = rover_round_wall(model::EndPolicy::Stay);
    // The palm begins 0.21 in front of the middle.
    grow(&mut problem, 0.4198);
    accepted(&problem, &plan);
    for edge in [0.4202, 0.45, 0.5] {
        change(rover_round_wall(model::EndPolicy::Stay), Rule::V11, |problem| grow(problem, edge));
    }
    // The second gantry's column is widened until it meets the first's hand.
    change(side_by_side(), Rule::V11, |problem| {
        problem.robots[1].links[3].bodies[0].shape = Shape::Cylinder { radius: 1.55, length: 0.2 };
    });
}

/// A way of the hand about a table: (dx, dy, z).
type Way<'a> = &'a [[f64; 3]];

/// The single scenario with other ways of the hand: before and after the attach, before and after the detach.
fn single_with(before: Way, holding: Way, lowering: Way, after: Way) -> (Problem, Plan) {
    let (problem, _) = single();
    let home = problem.robots[0].start.clone();
    let mut writer = Writer::new(&problem, 0);
    writer.begin(Some(model::PairId(0)));
    for (x, kind) in [(TABLES[0], EventKind::Attach), (TABLES[1], EventKind::Detach)] {
        writer.go(SegmentKind::Reach, &[x, 0.0, TRAVEL]);
        let (lead, trail) = if kind == EventKind::Attach { (before, holding) } else { (lowering, after) };
        for [dx, dy, z] in lead {
            writer.go(SegmentKind::Reach, &[x + dx, *dy, *z]);
        }
        writer.go(SegmentKind::Reach, &[x, 0.0, GRASP]).grip(kind, x, 0.0);
        for [dx, dy, z] in trail {
            writer.go(SegmentKind::Retract, &[x + dx, *dy, *z]);
        }
        writer.go(SegmentKind::Retract, &[x, 0.0, TRAVEL]).go(SegmentKind::Retract, &home);
    }
    let plan = finish(&problem, vec![writer]);
    (problem, plan)
}

#[test]
fn v12_fingers_in_the_object_outside_the_window() {
    // Down beside the object, with a finger in it, up again, and then the real approach.
    let touch = [[0.0, 0.03, TRAVEL], [0.0, 0.03, GRASP], [0.0, 0.03, TRAVEL], [0.0, 0.0, TRAVEL]];
    let (problem, plan) = single_with(&touch, &[], &[], &[]);
    rejected(&problem, &plan, Rule::V12);
    let first = &violations(&problem, &plan)[0];
    assert!(first.message.contains("finger of g1 and m1") && first.t.is_some_and(|t| t < plan.events[0].t), "{first}");
    let (problem, plan) = single_with(&[], &[], &[], &[[0.0, 0.0, TRAVEL], touch[0], touch[1], touch[2]]);
    rejected(&problem, &plan, Rule::V12);
    // The palm pressed on the object, long before the grasp.
    let press = [[0.0, 0.0, GRASP - 0.03], [0.0, 0.0, TRAVEL]];
    let (problem, plan) = single_with(&press, &[], &[], &[]);
    rejected(&problem, &plan, Rule::V12);
    // The same within the window is allowed: 0.16 m before the attach.
    let (problem, plan) = single_with(&[[0.0, 0.03, GRASP + 0.05], [0.0, 0.03, GRASP]], &[], &[], &[]);
    accepted(&problem, &plan);
}

#[test]
fn v12_a_held_object_pressed_into_its_support() {
    // Right after the grasp; after it has been lifted; before it is put.
    let (problem, plan) = single_with(&[], &[[0.0, 0.0, GRASP - 0.01]], &[], &[]);
    rejected(&problem, &plan, Rule::V12);
    let (problem, plan) = single_with(&[], &[[0.0, 0.0, TRAVEL], [0.0, 0.0, GRASP - 0.0005]], &[], &[]);
    rejected(&problem, &plan, Rule::V12);
    // Dragged over the table for a while: allowed as long as it is low.
    let (problem, plan) = single_with(&[], &[[0.05, 0.0, GRASP]], &[], &[]);
    accepted(&problem, &plan);
    let (problem, plan) = single_with(&[], &[], &[[0.0, 0.0, GRASP - 0.01]], &[]);
    rejected(&problem, &plan, Rule::V12);
}

#[test]
fn v12_the_hand_of_another_robot_has_no_window() {
    // What is allowed to the robot that grasps is a collision for the other one.
    let (mut problem, plan) = side_by_side();
    accepted(&problem, &plan);
    problem.regions.push(problem.regions[1].clone());
    add_object(&mut problem, "m3", -1.0, 0.0, model::RegionId(1));
    problem.movable[2].world_from_start.translation.vector.x = -0.75;
    let mut wandering = plan.clone();
    let last = wandering.robots[0].knots.last().expect("it moves").clone();
    let way = [[-0.75, 0.0, TRAVEL], [-0.75, 0.03, GRASP], [-0.75, 0.0, TRAVEL], [-0.5, -0.6, TRAVEL]];
    for (i, q) in way.into_iter().enumerate() {
        let from = wandering.robots[0].knots.len() - 1;
        wandering.robots[0].knots.push(Knot { t: last.t + 2.0 * (i + 1) as f64, q: q.to_vec() });
        let closing =
            plan::Segment { from, to: from + 1, pair: None, mode: plan::ModeKind::Return, kind: SegmentKind::Reach };
        wandering.robots[0].segments.push(closing);
    }
    report_makespan(&mut wandering);
    problem.fixed.push(model::FixedObject {
        name: "stool".to_owned(),
        world_from_object: crate::robots::at(-0.75, 0.0, TOP / 2.0),
        bodies: vec![crate::robots::block([0.1, 0.1, TOP], [0.0; 3])],
    });
    problem.movable[2].start_support = Some(model::FixedId::at(problem.fixed.len() - 1));
    accepted(&problem, &plan);
    rejected(&problem, &wandering, Rule::V11);
}
