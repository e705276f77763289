//! Scenes with valid plans.

use model::{EndPolicy, GivenOrdering, Point, Problem};
use plan::{Dependency, EventKind, KnotRef, Plan, SegmentKind};

use crate::fixture::{OBJECT, TOP, Writer, add_fixed, add_object, add_pair, add_table, finish, problem};
use crate::robots::{HAND_TO_OBJECT, ROVER_HAND, ROVER_REACH, gantry, rover};

/// Height of a hand that holds a standing object (m).
pub const GRASP: f64 = TOP + OBJECT[2] / 2.0 + HAND_TO_OBJECT;
/// Height of a gantry's hand when it travels (m).
pub const TRAVEL: f64 = 0.75;
/// Where the tables are along x; y is 0.
pub const TABLES: [f64; 3] = [-1.0, 0.0, 1.0];

/// Pick at (x, 0) and place at (to, 0) by a gantry that starts at home and comes back.
pub fn gantry_pair(writer: &mut Writer, pair: model::PairId, home: &[f64], from: f64, to: f64) {
    writer.begin(Some(pair));
    for (x, kind) in [(from, EventKind::Attach), (to, EventKind::Detach)] {
        writer.go(SegmentKind::Reach, &[x, 0.0, TRAVEL]).go(SegmentKind::Reach, &[x, 0.0, GRASP]);
        writer.grip(kind, x, 0.0);
        writer.go(SegmentKind::Retract, &[x, 0.0, TRAVEL]).go(SegmentKind::Retract, home);
    }
}

/// One gantry moves one object from table A to table B.
pub fn single() -> (Problem, Plan) {
    let home = [-0.5, -0.6, TRAVEL];
    let mut problem = problem(vec![gantry("g1", home)]);
    let a = add_table(&mut problem, "A", TABLES[0], 0.0);
    let b = add_table(&mut problem, "B", TABLES[1], 0.0);
    let m = add_object(&mut problem, "m1", TABLES[0], 0.0, a);
    let pair = add_pair(&mut problem, 0, m, a, b);
    let mut writer = Writer::new(&problem, 0);
    gantry_pair(&mut writer, pair, &home, TABLES[0], TABLES[1]);
    let plan = finish(&problem, vec![writer]);
    (problem, plan)
}

/// Two gantries hand an object on: g1 from A to S, g2 from S to B; meanwhile g2 brings another from B to C. The second gantry
/// waits over its home until the first is home again, which an arc says.
pub fn relay() -> (Problem, Plan) {
    let (home1, home2) = ([-0.5, -0.6, TRAVEL], [0.5, 0.6, TRAVEL]);
    let mut problem = problem(vec![gantry("g1", home1), gantry("g2", home2)]);
    let a = add_table(&mut problem, "A", TABLES[0], 0.0);
    let s = add_table(&mut problem, "S", TABLES[1], 0.0);
    let b = add_table(&mut problem, "B", TABLES[2], 0.0);
    let m = add_object(&mut problem, "m1", TABLES[0], 0.0, a);
    let first = add_pair(&mut problem, 0, m, a, s);
    let second = add_pair(&mut problem, 1, m, s, b);
    problem.orderings.push(GivenOrdering { before: (first, Point::Release), after: (second, Point::Grasp) });
    let mut one = Writer::new(&problem, 0);
    gantry_pair(&mut one, first, &home1, TABLES[0], TABLES[1]);
    let mut two = Writer::new(&problem, 1);
    two.begin(Some(second)).wait_until(one.time() + 0.1);
    let arc = Dependency {
        before: KnotRef { robot: "g1".to_owned(), knot: one.knot() },
        after: KnotRef { robot: "g2".to_owned(), knot: two.knot() },
    };
    gantry_pair(&mut two, second, &home2, TABLES[1], TABLES[2]);
    let mut plan = finish(&problem, vec![one, two]);
    plan.dependencies.push(arc);
    (problem, plan)
}

/// Two gantries work at the same time at their own ends, g1 from A to A', g2 from B to B'. Nothing orders them.
pub fn side_by_side() -> (Problem, Plan) {
    let (home1, home2) = ([-0.5, -0.6, TRAVEL], [0.5, 0.6, TRAVEL]);
    let mut problem = problem(vec![gantry("g1", home1), gantry("g2", home2)]);
    let regions = [-1.5, -1.0, 1.0, 1.5].map(|x| add_table(&mut problem, &format!("at {x}"), x, 0.0));
    let m1 = add_object(&mut problem, "m1", -1.0, 0.0, regions[1]);
    let m2 = add_object(&mut problem, "m2", 1.0, 0.0, regions[2]);
    let p1 = add_pair(&mut problem, 0, m1, regions[1], regions[0]);
    let p2 = add_pair(&mut problem, 1, m2, regions[2], regions[3]);
    let mut writers = vec![Writer::new(&problem, 0), Writer::new(&problem, 1)];
    gantry_pair(&mut writers[0], p1, &home1, -1.0, -1.5);
    gantry_pair(&mut writers[1], p2, &home2, 1.0, 1.5);
    let plan = finish(&problem, writers);
    (problem, plan)
}

/// A rover drives round a wall from table A at (2, 0) to table B at (2, 3), and back to its start or stays.
pub fn rover_round_wall(policy: EndPolicy) -> (Problem, Plan) {
    let mut problem = problem(vec![rover("r1", [0.0, 0.0, 0.0])]);
    problem.end_policies[0] = policy;
    let a = add_table(&mut problem, "A", 2.0, 0.0);
    let b = add_table(&mut problem, "B", 2.0, 3.0);
    add_fixed(&mut problem, "wall", [1.6, 0.1, 1.0], [2.0, 1.5, 0.5]);
    let m = add_object(&mut problem, "m1", 2.0, 0.0, a);
    let pair = add_pair(&mut problem, 0, m, a, b);
    let stand = 2.0 - ROVER_REACH - 0.3;
    let drive = |x: f64, y: f64| [x, y, 0.0, ROVER_HAND, 0.0];
    let mut writer = Writer::new(&problem, 0);
    writer.begin(Some(pair)).go(SegmentKind::Base, &drive(stand, 0.0));
    for (y, kind) in [(0.0, EventKind::Attach), (3.0, EventKind::Detach)] {
        let arm = |height: f64, reach: f64| [stand, y, 0.0, height, reach];
        writer.go(SegmentKind::Reach, &arm(ROVER_HAND, 0.3)).go(SegmentKind::Reach, &arm(GRASP, 0.3));
        writer.grip(kind, 2.0, y);
        writer.go(SegmentKind::Retract, &arm(ROVER_HAND, 0.3)).go(SegmentKind::Retract, &arm(ROVER_HAND, 0.0));
        if kind == EventKind::Attach {
            // Once round: the angle is not wound back.
            let middle = [0.0, 1.5, std::f64::consts::PI, ROVER_HAND, 0.0];
            writer.go(SegmentKind::Base, &middle).go(SegmentKind::Base, &drive(stand, 3.0));
        }
    }
    if policy == EndPolicy::Return {
        let round = [0.0, 0.0, std::f64::consts::TAU, ROVER_HAND, 0.0];
        writer.begin(None).go(SegmentKind::Base, &drive(0.0, 3.0)).go(SegmentKind::Base, &round);
    }
    let plan = finish(&problem, vec![writer]);
    (problem, plan)
}
