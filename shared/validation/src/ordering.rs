//! Rule V9: orderings between points, and, if the problem gates actions, between the actions that they belong to.

use model::{ObjectId, PairId, Point};

use crate::points::Points;
use crate::precedence::gates;
use crate::script::Script;
use crate::violation::{Rule, Violation};

/// Least time between two ordered points (s).
const STRICT: f64 = 1e-9;
/// What rounding of times of up to an hour may take off it (s).
const ROUNDING: f64 = 1e-12;

type Ordering = ((PairId, Point), (PairId, Point), &'static str);

/// Checks the orderings that robots, objects, problem and plan imply.
pub(crate) fn check(script: &Script, points: &Points, wrong: &mut Vec<Violation>) {
    let mut orderings = implied(script);
    orderings.extend(script.problem.orderings.iter().map(|given| (given.before, given.after, "given by the problem")));
    let gates: Vec<Ordering> =
        gates(script.problem).map(|(before, after)| (before, after, "gate of actions")).collect();
    orderings.extend(gates);
    for (i, listed) in script.plan.orderings.iter().enumerate() {
        match (script.pair_id(&listed.before.pair), script.pair_id(&listed.after.pair)) {
            (Some(before), Some(after)) => {
                orderings.push(((before, listed.before.point), (after, listed.after.point), "listed in the plan"));
            }
            _ => wrong.push(Violation::new(Rule::V9, format!("ordering {i} of the plan names an unknown pair"))),
        }
    }
    orderings.sort_by_key(|(before, after, _)| (*before, *after));
    orderings.dedup_by_key(|(before, after, _)| (*before, *after));
    wrong.extend(orderings.iter().filter_map(|ordering| broken(script, points, ordering)));
}

fn implied(script: &Script) -> Vec<Ordering> {
    let mut orderings = Vec::new();
    let mut chain = |pairs: &[PairId], from: &'static str| {
        let next = pairs.windows(2).map(|pair| ((pair[0], Point::Release), (pair[1], Point::Grasp), from));
        orderings.extend(next);
    };
    for robot in script.problem.robot_ids() {
        chain(&script.problem.pairs_of_robot(robot).collect::<Vec<_>>(), "the robot's order");
    }
    for object in 0..script.problem.movable.len() {
        chain(&script.problem.hops_of_object(ObjectId::at(object)), "the object's hops");
    }
    orderings
}

/// An ordering on a point that the plan does not have is broken, unless its pair is not executed at all (V13).
fn broken(script: &Script, points: &Points, ordering: &Ordering) -> Option<Violation> {
    let (before, after, origin) = *ordering;
    let words = |(pair, point): (PairId, Point)| format!("{} of {}", point.name(), script.pair_name(pair));
    let (message, t) = match (points.time(before.0, before.1), points.time(after.0, after.1)) {
        (Some(first), Some(second)) if second - first >= STRICT - ROUNDING => return None,
        (Some(first), Some(second)) => {
            let (before, after) = (words(before), words(after));
            (format!("{before} at {first} s is not before {after} at {second} s ({origin})"), Some(second))
        }
        (first, _) => {
            let missing = if first.is_none() { before } else { after };
            points.time(missing.0, Point::Release)?;
            (format!("the plan has no {}, which an ordering names ({origin})", words(missing)), None)
        }
    };
    let robot = |pair: PairId| script.robot_name(script.problem.pair(pair).robot);
    let mut violation = Violation::new(Rule::V9, message).robot(robot(before.0)).robot(robot(after.0));
    violation.t = t;
    Some(violation)
}
