//! Rule V15: orderings without need.

use model::{Point, Problem};
use plan::{BodyRef, Cause, EventKind, Origin, PairPoint, Plan, PlanOrdering, SegmentKind};
use validation::Rule;

use crate::fixture::{Writer, accepted, add_object, add_pair, add_table, finish, problem, rejected, violations};
use crate::robots::gantry;
use crate::scenarios::{GRASP, TRAVEL, gantry_pair, relay};

const HOMES: [[f64; 3]; 2] = [[-0.5, -0.6, TRAVEL], [0.5, 0.6, TRAVEL]];

fn ordering(before: (&str, Point), after: (&str, Point), cause: Option<Cause>) -> PlanOrdering {
    let at = |(pair, point): (&str, Point)| PairPoint { pair: pair.to_owned(), point };
    PlanOrdering { before: at(before), after: at(after), origin: Origin::Discovered, cause }
}

fn overlap(leaves: &str, comes: &str) -> Cause {
    Cause::Overlap { region: "S".to_owned(), leaves: leaves.to_owned(), comes: comes.to_owned() }
}

fn in_the_way(robot: &str, pair: Option<&str>, object: &str) -> Cause {
    let blocking = vec![BodyRef::Object(object.to_owned())];
    Cause::NoPath { pair: pair.map(str::to_owned), robot: robot.to_owned(), blocking }
}

/// g2 takes the old object from S to B, then g1 brings the new one from A to S, `beside` (m) from where the old one was.
fn replacement(beside: f64) -> (Problem, Plan) {
    let mut problem = problem(vec![gantry("g1", HOMES[0]), gantry("g2", HOMES[1])]);
    let a = add_table(&mut problem, "A", -1.0, 0.0);
    let s = add_table(&mut problem, "S", 0.0, 0.0);
    let b = add_table(&mut problem, "B", 1.0, 0.0);
    let new = add_object(&mut problem, "new", -1.0, 0.0, a);
    let old = add_object(&mut problem, "old", 0.0, 0.0, s);
    let brings = add_pair(&mut problem, 0, new, a, s);
    let clears = add_pair(&mut problem, 1, old, s, b);
    let mut two = Writer::new(&problem, 1);
    gantry_pair(&mut two, clears, &HOMES[1], 0.0, 1.0);
    let mut one = Writer::new(&problem, 0);
    one.begin(Some(brings)).wait_until(two.time() + 0.1);
    gantry_pair(&mut one, brings, &HOMES[0], -1.0, beside);
    let mut plan = finish(&problem, vec![one, two]);
    let cause = Some(overlap("old", "new"));
    plan.orderings.push(ordering(("g2.1", Point::Grasp), ("g1.1", Point::Release), cause));
    (problem, plan)
}

/// g1 carries an object from A to B, at height `low` above S; then g2 brings another from D to S.
fn passage(low: f64) -> (Problem, Plan) {
    let mut problem = problem(vec![gantry("g1", HOMES[0]), gantry("g2", HOMES[1])]);
    let a = add_table(&mut problem, "A", -1.0, 0.0);
    let s = add_table(&mut problem, "S", 0.0, 0.0);
    let b = add_table(&mut problem, "B", 1.0, 0.0);
    let d = add_table(&mut problem, "D", 1.5, 0.0);
    let m1 = add_object(&mut problem, "m1", -1.0, 0.0, a);
    let m2 = add_object(&mut problem, "m2", 1.5, 0.0, d);
    let passes = add_pair(&mut problem, 0, m1, a, b);
    let fills = add_pair(&mut problem, 1, m2, d, s);
    let mut one = Writer::new(&problem, 0);
    one.begin(Some(passes)).go(SegmentKind::Reach, &[-1.0, 0.0, TRAVEL]).go(SegmentKind::Reach, &[-1.0, 0.0, GRASP]);
    one.grip(EventKind::Attach, -1.0, 0.0);
    one.go(SegmentKind::Retract, &[-1.0, 0.0, TRAVEL]).go(SegmentKind::Retract, &HOMES[0]);
    for (x, z) in [(-0.5, TRAVEL), (-0.5, low), (0.5, low), (0.5, TRAVEL), (1.0, TRAVEL), (1.0, GRASP)] {
        one.go(SegmentKind::Reach, &[x, 0.0, z]);
    }
    one.grip(EventKind::Detach, 1.0, 0.0);
    one.go(SegmentKind::Retract, &[1.0, 0.0, TRAVEL]).go(SegmentKind::Retract, &HOMES[0]);
    let mut two = Writer::new(&problem, 1);
    two.begin(Some(fills)).wait_until(one.time() + 0.1);
    gantry_pair(&mut two, fills, &HOMES[1], 1.5, 0.0);
    let mut plan = finish(&problem, vec![one, two]);
    let cause = Some(in_the_way("g1", Some("g1.1"), "m2"));
    plan.orderings.push(ordering(("g1.1", Point::Done), ("g2.1", Point::Release), cause));
    (problem, plan)
}

const LOW: f64 = GRASP + 0.05;

/// Applies one corruption to a plan whose orderings are needed, and expects V15 alone, for a reason that contains `why`.
#[track_caller]
fn corrupt((problem, mut plan): (Problem, Plan), why: &str, change: impl FnOnce(&mut Vec<PlanOrdering>)) {
    accepted(&problem, &plan);
    change(&mut plan.orderings);
    rejected(&problem, &plan, Rule::V15);
    let found = violations(&problem, &plan);
    assert!(found.iter().any(|violation| violation.message.contains(why)), "expected `{why}`: {found:?}");
}

#[test]
fn orderings_that_the_geometry_forces_are_accepted() {
    for (problem, plan) in [replacement(0.0), replacement(0.06), replacement(-0.061), passage(LOW)] {
        accepted(&problem, &plan);
    }
}

#[test]
fn orderings_that_follow_from_others_are_without_need() {
    corrupt(replacement(0.0), "follows from the others", |orderings| orderings.push(orderings[0].clone()));
    corrupt(replacement(0.0), "follows from the others", |orderings| {
        orderings.push(ordering(("g2.1", Point::Start), ("g1.1", Point::Done), Some(overlap("old", "new"))));
    });
    corrupt(replacement(0.0), "follows from the others", |orderings| {
        orderings.push(ordering(("g1.1", Point::Grasp), ("g1.1", Point::Release), Some(overlap("new", "new"))));
    });
    // The hops of one object, and what the problem lists.
    let (mut problem, mut plan) = relay();
    let cause = Some(overlap("m1", "m1"));
    plan.orderings.push(ordering(("g1.1", Point::Release), ("g2.1", Point::Grasp), cause));
    rejected(&problem, &plan, Rule::V15);
    problem.orderings.clear();
    rejected(&problem, &plan, Rule::V15);
}

#[test]
fn objects_that_do_not_collide_need_no_ordering() {
    // The objects are 0.06 m wide; the planner keeps 2 mm between them.
    for beside in [0.063, 0.064, -0.064] {
        let (problem, plan) = replacement(beside);
        rejected(&problem, &plan, Rule::V15);
    }
    let change = |why: &str, change: fn(&mut PlanOrdering)| {
        corrupt(replacement(0.0), why, |orderings| change(&mut orderings[0]));
    };
    change("does not keep apart", |ordering| ordering.cause = Some(overlap("new", "old")));
    change("does not keep apart", |ordering| ordering.cause = Some(overlap("old", "old")));
    change("does not keep apart", |ordering| ordering.before.point = Point::Carry);
    change("does not keep apart", |ordering| ordering.after.point = Point::Done);
    change("does not keep apart", |ordering| match &mut ordering.cause {
        Some(Cause::Overlap { region, .. }) => *region = "B".to_owned(),
        other => panic!("{other:?}"),
    });
    change("has no cause", |ordering| ordering.cause = None);
    change("cannot be checked", |ordering| ordering.cause = Some(Cause::Budget { stage: "placement".to_owned() }));
}

#[test]
fn a_pose_that_a_robot_comes_nowhere_near_is_not_in_its_way() {
    for high in [TRAVEL, GRASP + 0.13] {
        let (problem, plan) = passage(high);
        rejected(&problem, &plan, Rule::V15);
    }
    let change = |why: &str, change: fn(&mut PlanOrdering)| {
        corrupt(passage(LOW), why, |orderings| change(&mut orderings[0]));
    };
    // On the way to the pick, and when it is done, the robot is elsewhere.
    change("comes nowhere near", |ordering| ordering.before.point = Point::Carry);
    change("comes nowhere near", |ordering| ordering.cause = Some(in_the_way("g1", None, "m2")));
    change("does not end the obstruction", |ordering| ordering.cause = Some(in_the_way("g1", Some("g1.1"), "m1")));
    change("does not end the obstruction", |ordering| ordering.cause = Some(in_the_way("g2", Some("g2.1"), "m2")));
    change("does not end the obstruction", |ordering| ordering.cause = Some(in_the_way("g1", Some("g2.1"), "m2")));
    change("does not end the obstruction", |ordering| ordering.after.point = Point::Done);
    change("unknown pair", |ordering| ordering.cause = Some(in_the_way("g1", Some("g1.9"), "m2")));
}

#[test]
fn what_is_called_given_must_be_given() {
    corrupt(replacement(0.0), "does not follow from the problem", |orderings| orderings[0].origin = Origin::Given);
    let (problem, mut plan) = relay();
    let mut given = ordering(("g1.1", Point::Release), ("g2.1", Point::Grasp), None);
    given.origin = Origin::Given;
    plan.orderings.push(given.clone());
    accepted(&problem, &plan);
    given.before.point = Point::Done;
    plan.orderings[0] = given;
    rejected(&problem, &plan, Rule::V15);
}

#[test]
fn where_removals_have_to_be_completed_nothing_is_placed_while_what_stood_there_is_carried_away() {
    let cases = [(-0.2, 0.0, false), (-1e-3, 0.0, false), (0.0, 0.0, false), (1e-3, 0.0, true), (-0.2, 0.064, true)];
    for (late, beside, kept) in cases {
        let (mut problem, mut plan) = replacement(beside);
        plan.orderings.clear();
        // The old object is held over the second robot's home until the new one has nearly come.
        let detach =
            |robot: &str| plan.events.iter().find(|e| e.robot == robot && e.kind == EventKind::Detach).unwrap();
        let (released, placed) = (detach("g2"), detach("g1").t);
        let retracts = plan.robots[1].segments.iter().filter(|segment| segment.kind == SegmentKind::Retract);
        let carry = retracts.map(|segment| segment.to).filter(|knot| *knot < released.knot).max().unwrap();
        let dt = placed - late - released.t;
        crate::mutations::shift(&mut plan, 1, carry + 1, dt);
        accepted(&problem, &plan);
        problem.settings.removal = model::Removal::Completed;
        let broken = crate::fixture::rules(&problem, &plan);
        assert_eq!(broken, if kept { vec![] } else { vec![Rule::V10] }, "{late} {beside}");
    }
}

#[test]
fn where_removals_have_to_be_completed_orderings_name_the_release() {
    let (mut problem, mut plan) = replacement(0.0);
    problem.settings.removal = model::Removal::Completed;
    rejected(&problem, &plan, Rule::V15);
    plan.orderings[0].before.point = Point::Release;
    accepted(&problem, &plan);
}
