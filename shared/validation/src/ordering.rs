//! Rule V9: orderings between points; and V10, if the problem gates actions, between the actions that they belong to.

use model::{ObjectId, PairId, Point};

use crate::points::Points;
use crate::precedence::{At, gates};
use crate::script::Script;
use crate::violation::{Rule, Violation};

/// Least time between two ordered points (s).
const STRICT: f64 = 1e-9;
/// What rounding of times of up to an hour may take off it (s).
const ROUNDING: f64 = 1e-12;

struct Ordering {
    before: At,
    after: At,
    rule: Rule,
    /// Where it comes from, in words.
    origin: &'static str,
}

/// Checks the orderings that robots, objects, problem and plan imply.
pub(crate) fn check(script: &Script, points: &Points, wrong: &mut Vec<Violation>) {
    let of = |rule: Rule, origin: &'static str| move |(before, after)| Ordering { before, after, rule, origin };
    let mut orderings: Vec<Ordering> = implied(script).collect();
    let given = script.problem.orderings.iter().map(|given| (given.before, given.after));
    orderings.extend(given.map(of(Rule::V9, "given by the problem")));
    for (i, listed) in script.plan.orderings.iter().enumerate() {
        match (script.pair_id(&listed.before.pair), script.pair_id(&listed.after.pair)) {
            (Some(before), Some(after)) => {
                let ends = ((before, listed.before.point), (after, listed.after.point));
                orderings.push(of(Rule::V9, "listed in the plan")(ends));
            }
            _ => wrong.push(Violation::new(Rule::V9, format!("ordering {i} of the plan names an unknown pair"))),
        }
    }
    orderings.extend(gates(script.problem).map(of(Rule::V10, "gate of actions")));
    orderings.sort_by_key(|ordering| (ordering.before, ordering.after));
    orderings.dedup_by_key(|ordering| (ordering.before, ordering.after));
    wrong.extend(orderings.iter().filter_map(|ordering| broken(script, points, ordering)));
}

fn implied<'a>(script: &'a Script) -> impl Iterator<Item = Ordering> + 'a {
    let robots = script.problem.robot_ids();
    let robots = robots.map(|robot| (script.problem.pairs_of_robot(robot).collect::<Vec<_>>(), "the robot's order"));
    let objects = (0..script.problem.movable.len()).map(ObjectId::at);
    let objects = objects.map(|object| (script.problem.hops_of_object(object), "the object's hops"));
    robots.chain(objects).flat_map(|(pairs, origin)| {
        let next = |two: &[PairId]| {
            let (before, after) = ((two[0], Point::Release), (two[1], Point::Grasp));
            Ordering { before, after, rule: Rule::V9, origin }
        };
        pairs.windows(2).map(next).collect::<Vec<_>>()
    })
}

/// An ordering on a point that the plan does not have is broken, unless its pair is not executed at all (V13).
fn broken(script: &Script, points: &Points, ordering: &Ordering) -> Option<Violation> {
    let Ordering { before, after, rule, origin } = *ordering;
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
    let mut violation = Violation::new(rule, message).robot(robot(before.0)).robot(robot(after.0));
    violation.t = t;
    Some(violation)
}
