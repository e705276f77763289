//! Rule V10: plans that keep their orderings, but not what the settings say that orderings mean.

use model::{EndPolicy, Gate, GivenOrdering, PairId, Point, Problem};
use nalgebra::Vector3;
use plan::{Event, EventKind, Plan, SegmentKind};
use validation::Rule;

use crate::fixture::{Writer, accepted, add_object, add_pair, add_table, finish, problem, rejected, violations};
use crate::mutations::{shift, turned};
use crate::robots::{ROVER_HAND, ROVER_REACH, rover};
use crate::scenarios::{GRASP, relay, side_by_side};

/// A plan that is valid while a robot may come as near as it likes: accepted where actions gate one another if it is `kept`,
/// else refused for that alone.
#[track_caller]
fn gated((mut problem, plan): (Problem, Plan), kept: bool, words: &str) {
    accepted(&problem, &plan);
    problem.settings.gate = Gate::Action;
    if kept {
        accepted(&problem, &plan);
        return;
    }
    rejected(&problem, &plan, Rule::V10);
    let found = violations(&problem, &plan);
    assert!(found.len() == 1 && found[0].message.contains(words), "expected `{words}`: {found:?}");
    assert!(found[0].to_string().starts_with("V10 gates and removals"), "{}", found[0]);
}

#[test]
fn a_fixed_arm_grasps_what_another_put_down_only_once_that_one_is_home() {
    for (late, kept) in [(-0.05, false), (-1e-3, false), (0.0, false), (2e-9, true), (0.01, true)] {
        let (problem, mut plan) = relay();
        plan.dependencies.clear();
        let done = plan.robots[0].knots.last().unwrap().t;
        let grasp = plan.events.iter().find(|event| event.robot == "g2").unwrap().t;
        shift(&mut plan, 1, 1, done + late - grasp);
        gated((problem, plan), kept, "done of g1.1");
    }
}

#[test]
fn what_the_problem_lists_is_gated_too() {
    // The first has brought its arm to carry before the second releases.
    for (late, kept) in [(-1e-3, true), (0.0, false), (1e-3, false)] {
        let (mut problem, mut plan) = side_by_side();
        let [first, second] = [0, 1].map(PairId::at);
        problem.orderings.push(GivenOrdering { before: (first, Point::Grasp), after: (second, Point::Release) });
        let carry = plan.robots[0].knots[carry_knot(&plan)].t;
        let release =
            plan.events.iter().find(|event| event.robot == "g2" && event.kind == EventKind::Detach).unwrap().t;
        shift(&mut plan, 0, 1, release - carry + late);
        gated((problem, plan), kept, "carry of g1.1");
    }
}

#[test]
fn a_base_comes_to_its_stand_only_once_the_earlier_action_is_completed() {
    for (late, kept) in [(-0.3, false), (-1e-3, false), (2e-9, true), (0.1, true)] {
        let (problem, mut plan) = relay_of_rovers();
        let done = plan.robots[0].knots.last().unwrap().t;
        // The second robot waits up to its first knot and has arrived at its next one.
        let dt = done + late - plan.robots[1].knots[2].t;
        shift(&mut plan, 1, 1, dt);
        gated((problem, plan), kept, "done of r1.1");
    }
}

/// Two rovers hand an object on over the table S, from opposite sides: the second waits at its start, drives to its stand,
/// grasps. Between the first's release and its folding there is time to drive up.
fn relay_of_rovers() -> (Problem, Plan) {
    let stand = ROVER_REACH + 0.3;
    let mut problem =
        problem(vec![rover("r1", [-stand, -3.0, 0.0]), rover("r2", [stand + 1.0, 0.0, std::f64::consts::PI])]);
    problem.end_policies = vec![EndPolicy::Stay; 2];
    let [a, s, b] = [("A", -3.0), ("S", 0.0), ("B", 3.0)].map(|(name, y)| add_table(&mut problem, name, 0.0, y));
    let m = add_object(&mut problem, "m1", 0.0, -3.0, a);
    let first = add_pair(&mut problem, 0, m, a, s);
    let second = add_pair(&mut problem, 1, m, s, b);
    let mut one = Writer::new(&problem, 0);
    rover_pair(&mut one, first, [-stand, 0.0], [-3.0, 0.0]);
    let mut two = Writer::new(&problem, 1);
    two.begin(Some(second)).wait_until(one.time());
    rover_pair(&mut two, second, [stand, std::f64::consts::PI], [0.0, 3.0]);
    let mut plan = finish(&problem, vec![one, two]);
    // The second hand comes from the other side.
    let by_r2 = &mut problem.movable[m.index()].grasps[1][0].link_from_object;
    *by_r2 = turned((*by_r2).into(), Vector3::z(), 180.0).into();
    for event in plan.events.iter_mut().filter(|event| event.robot == "r2") {
        event.link_from_object = (*by_r2).into();
    }
    (problem, plan)
}

/// A rover drives along x = `x` with one heading, from a pick beside (0, y) to a place beside (0, to).
fn rover_pair(writer: &mut Writer, pair: PairId, [x, yaw]: [f64; 2], [from, to]: [f64; 2]) {
    writer.begin(Some(pair));
    for (y, kind) in [(from, EventKind::Attach), (to, EventKind::Detach)] {
        let arm = |height: f64, reach: f64| [x, y, yaw, height, reach];
        writer.go(SegmentKind::Base, &arm(ROVER_HAND, 0.0));
        writer.go(SegmentKind::Reach, &arm(ROVER_HAND, 0.3)).go(SegmentKind::Reach, &arm(GRASP, 0.3));
        writer.grip(kind, 0.0, y);
        writer.go(SegmentKind::Retract, &arm(ROVER_HAND, 0.3)).go(SegmentKind::Retract, &arm(ROVER_HAND, 0.0));
    }
}

/// Where the first robot's arm is in its carry configuration.
fn carry_knot(plan: &Plan) -> usize {
    let is_release = |event: &&Event| event.robot == "g1" && event.kind == EventKind::Detach;
    let release = plan.events.iter().find(is_release).expect("a release");
    let retracts = plan.robots[0].segments.iter().filter(|segment| segment.kind == SegmentKind::Retract);
    retracts.map(|segment| segment.to).filter(|knot| *knot < release.knot).max().expect("a retract")
}
