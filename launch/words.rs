//! Causes, modes and results in a user's words.

use std::collections::BTreeSet;

use contract::{Decision, DiscoveredOrder};
use model::Problem;
use plan::{
    BodyRef, Cause, Certificate, Distance, DistanceLimit, PairEnd, PairPoint, PlanOrdering, ResultKind, StoppedBy,
};
use skeleton::ModeId;

/// A mode, e.g. `r1.2 transfer`.
#[must_use]
pub fn mode(problem: &Problem, mode: ModeId) -> String {
    let name = &problem.robot(mode.robot).name;
    match problem.pairs_of_robot(mode.robot).nth(mode.step as usize / 2) {
        Some(pair) => format!("{} {}", problem.pair(pair).name, ["transit", "transfer"][mode.step as usize % 2]),
        None => format!("{name} return"),
    }
}

/// A decision of the search.
#[must_use]
pub fn decision(problem: &Problem, decision: &Decision) -> String {
    match decision {
        Decision::Level(level) => format!("sample level {level}"),
        Decision::Placement(index) => format!("placement candidate {index}"),
        Decision::Alternative { pair, index } => {
            format!("{} in another way: alternative {index}", problem.pair(*pair).name)
        }
        Decision::Commit(committed) => format!("motion of {}", mode(problem, *committed)),
        Decision::Order(added) => format!("ordering {}", order(problem, added)),
        Decision::Repair(stuck) => format!("{} together with those in its way", mode(problem, *stuck)),
        Decision::Drrt => "the composite search takes over".to_owned(),
        Decision::Hop { pair, sample, .. } => format!("place {sample} for {}", problem.pair(*pair).name),
        Decision::Synchronous(_) => "rounds for all robots".to_owned(),
        Decision::Round(modes) => {
            let modes: Vec<String> = modes.iter().map(|id| mode(problem, *id)).collect();
            format!("round: {}", modes.join(", "))
        }
        Decision::More { stage, times } => format!("{stage} is asked again with {times} times as many samples"),
    }
}

/// A discovered ordering without its cause.
#[must_use]
pub fn order(problem: &Problem, order: &DiscoveredOrder) -> String {
    format!("{} before {}", order.before.describe(problem), order.after.describe(problem))
}

/// How a search without a plan ended.
#[must_use]
pub fn result(result: ResultKind) -> &'static str {
    match result {
        ResultKind::InfeasibleProven => "There is no plan: proven.",
        ResultKind::SamplesExhausted => "No plan among the samples tried. That is no proof.",
        ResultKind::LimitReached => "No plan so far: a limit or a signal ended the search.",
    }
}

/// What ended a search early.
#[must_use]
pub fn stopped_by(stopped_by: &StoppedBy) -> String {
    match stopped_by {
        StoppedBy::Policy { stage, policy } => format!("ended by the policy of {stage}, `{policy}`, when it failed"),
        StoppedBy::WorkLimit { of, limit, spent } => {
            format!("ended by the limit on work of {of}: {limit} units, {spent} were spent")
        }
        StoppedBy::TimeLimit { seconds } => format!("ended by the time limit: {seconds} s"),
        StoppedBy::Signal => "ended by a signal".to_owned(),
    }
}

/// A cause in one sentence.
#[must_use]
pub fn cause(cause: &Cause) -> String {
    match cause {
        Cause::Collision { first, second } => format!("{first} touches {second}"),
        Cause::Overlap { region, leaves, comes } => {
            format!("{comes} fits into {region} only once {leaves} has left")
        }
        Cause::NoPlacement { object, region } => format!("{object} finds no free place in {region}"),
        Cause::Cycle { points } => format!("orderings contradict one another: {}", cycle(points)),
        Cause::Unreachable { robot, pair, object, region } => {
            format!("{robot} cannot reach {object} in {region} ({pair})")
        }
        Cause::NoCommonGrasp { pair } => format!("no grasp serves both ends of {pair}"),
        Cause::NoPath { pair, robot, blocking } => {
            let what = pair.as_ref().map_or(format!("{robot} back"), |pair| format!("{robot} in {pair}"));
            if blocking.is_empty() {
                format!("no way for {what}")
            } else {
                format!("no way for {what}: {} in the way", list(blocking))
            }
        }
        Cause::Deadlock { robots } => format!("{} block one another", robots.join(" and ")),
        Cause::Budget { stage } => format!("the work budget of {stage} was used up"),
    }
}

/// What a certificate proves, in one sentence.
#[must_use]
pub fn proof(certificate: &Certificate) -> String {
    match certificate {
        Certificate::Cycle { exclusions, .. } => {
            let regions: BTreeSet<&str> = exclusions.iter().map(|exclusion| exclusion.region.as_str()).collect();
            let regions: Vec<&str> = regions.into_iter().collect();
            format!("whichever object comes first to {}, the orderings contradict one another", regions.join(" and "))
        }
        Certificate::Area { region, region_area_m2, stays, .. } => {
            let names: Vec<&str> = stays.iter().map(|cover| cover.stay.object.as_str()).collect();
            let covered: f64 = stays.iter().map(|cover| cover.area_m2).sum();
            let (covered, area) = (covered * 1e4, region_area_m2 * 1e4);
            format!("{} have to be in {region} together: {covered:.1} cm² where there are {area:.1}", names.join(", "))
        }
        Certificate::ObjectTooLarge { object, region } => format!("{object} does not fit into {region} at any yaw"),
        Certificate::Reach { robot, pair, end, region, distance, .. } => {
            format!("{robot} cannot reach {region} to {} in {pair}: {}", verb(*end), out_of_reach(distance))
        }
        Certificate::NoCommonGrasp { robot, pair, grasps } => {
            format!("each of the {} grasps of {robot} for {pair} is impossible at one of its ends", grasps.len())
        }
        Certificate::BaseDisconnected { robot, pair, end, region, .. } => {
            format!("{robot} cannot drive to any place from which it could {} in {region} ({pair})", verb(*end))
        }
    }
}

fn verb(end: PairEnd) -> &'static str {
    match end {
        PairEnd::Pick => "pick",
        PairEnd::Place => "place",
    }
}

fn out_of_reach(distance: &Distance) -> String {
    match distance.limit {
        DistanceLimit::Far { greatest_m, nearest_m } => {
            format!(
                "the hand would have to be {nearest_m:.3} m or more from the shoulder, the arm gets no farther than {greatest_m:.3} m"
            )
        }
        DistanceLimit::Near { least_m, farthest_m } => {
            format!(
                "the hand would have to be {farthest_m:.3} m or less from the shoulder, the arm gets no nearer than {least_m:.3} m"
            )
        }
    }
}

/// An ordering in one sentence.
#[must_use]
pub fn ordering(ordering: &PlanOrdering) -> String {
    let at = |point: &PairPoint| format!("{} of {}", point.point.name(), point.pair);
    let because = ordering.cause.as_ref().map_or(String::new(), |because| format!(": {}", cause(because)));
    format!("{} before {}{because}", at(&ordering.before), at(&ordering.after))
}

fn cycle(points: &[PairPoint]) -> String {
    let mut names: Vec<String> = points.iter().map(|at| format!("{} of {}", at.point.name(), at.pair)).collect();
    names.extend(names.first().cloned());
    names.join(" before ")
}

fn list(bodies: &[BodyRef]) -> String {
    bodies.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}
