//! What a user can try against each kind of cause.

use model::Problem;
use plan::{BodyRef, Cause, Certificate, Failure, PairEnd, PairPoint, ResultKind};

use crate::progress::tally::is_contact;

/// Causes that advice is given about.
const ADVISED: usize = 4;

/// Advice, the most promising first, none twice.
#[must_use]
pub fn of_failure(problem: &Problem, failure: &Failure) -> Vec<String> {
    let mut advice: Vec<String> = match &failure.certificate {
        Some(certificate) => vec![of_certificate(problem, certificate)],
        None => {
            let done = || failure.causes.iter().map(|(cause, _)| cause).filter(|cause| !is_contact(cause));
            // Where candidates were found, places are wanting only because those were excluded for the other causes.
            let lacks_place = |cause: &Cause| matches!(cause, Cause::NoPlacement { .. });
            let tried = failure.reached.is_some_and(|reached| reached.candidates > 0) && !done().all(lacks_place);
            let advised = done().filter(|cause| !(tried && lacks_place(cause))).take(ADVISED);
            let mut advice: Vec<String> = advised.map(|cause| of_cause(problem, cause)).collect();
            if advice.is_empty() {
                advice.extend(failure.causes.first().map(|(cause, _)| of_cause(problem, cause)));
            }
            advice
        }
    };
    let highest = problem.levels.highest;
    match failure.result {
        ResultKind::InfeasibleProven => {}
        ResultKind::SamplesExhausted => advice.push(format!(
            "other or more samples: another --seed, or `levels: {{highest: {}}}` in the problem (it is {highest})",
            highest + 1
        )),
        ResultKind::LimitReached => advice
            .push("more time or work (--time-limit, --limit): nothing that was met so far rules out a plan".to_owned()),
    }
    let mut seen = std::collections::BTreeSet::new();
    advice.retain(|words| seen.insert(words.clone()));
    advice
}

/// Advice against one cause.
#[must_use]
pub fn of_cause(problem: &Problem, cause: &Cause) -> String {
    match cause {
        Cause::Collision { first, second } => format!("more room between {first} and {second}"),
        Cause::Overlap { region, leaves, comes } => {
            format!("a larger {region}, or orderings under which {leaves} leaves before {comes} comes")
        }
        Cause::NoPlacement { object, region } => {
            format!("a larger {region}, or less in it while {object} comes: let something leave it first")
        }
        Cause::Cycle { points } => cycle(points),
        Cause::Unreachable { robot, pair, object, region } => unreachable(problem, robot, pair, object, region),
        Cause::NoCommonGrasp { pair } => no_common_grasp(problem, pair),
        Cause::NoPath { pair, robot, blocking } => no_path(problem, pair.as_deref(), robot, blocking),
        Cause::Deadlock { robots } => format!(
            "room for {} to pass one another: a bay or a wider way, starts and ends out of the way, or `orderings` that \
             let one go after the other",
            robots.join(" and ")
        ),
        Cause::Budget { stage } if stage == "composite" => {
            "more work for composite motion: a higher `levels: {expansions: …}` in the problem".to_owned()
        }
        Cause::Budget { stage } => format!("more work for {stage}: higher `levels` in the problem"),
    }
}

fn of_certificate(problem: &Problem, certificate: &Certificate) -> String {
    match certificate {
        Certificate::Cycle { exclusions, .. } => {
            let regions: std::collections::BTreeSet<&str> =
                exclusions.iter().map(|exclusion| exclusion.region.as_str()).collect();
            let regions: Vec<&str> = regions.into_iter().collect();
            format!(
                "a larger {}, a region to put something aside, or another order of some robot's pairs",
                regions.join(" or ")
            )
        }
        Certificate::Area { region, stays, .. } => {
            let names: Vec<&str> = stays.iter().map(|cover| cover.stay.object.as_str()).collect();
            format!("a larger {region}, or fewer of {} in it at one time", names.join(", "))
        }
        Certificate::ObjectTooLarge { object, region } => format!("a larger {region}, or another region for {object}"),
        Certificate::Reach { robot, pair, end, region, .. } => {
            let what = if *end == PairEnd::Pick { "take from" } else { "bring to" };
            format!("{region} (or {robot}) elsewhere, or another robot to {what} it in {pair}")
        }
        Certificate::NoCommonGrasp { pair, .. } => no_common_grasp(problem, pair),
        Certificate::BaseDisconnected { robot, region, pair, .. } => {
            format!("a way for the base of {robot} to {region}, or another robot for {pair}")
        }
    }
}

fn cycle(points: &[PairPoint]) -> String {
    let mut pairs: Vec<&str> = points.iter().map(|at| at.pair.as_str()).collect();
    pairs.dedup();
    format!("one of the orderings between {} less, or another order of some robot's pairs", pairs.join(", "))
}

fn unreachable(problem: &Problem, robot: &str, pair: &str, object: &str, region: &str) -> String {
    let drives = problem.robots.iter().any(|known| known.name == robot && known.base.is_some());
    let remedy = if drives {
        format!("room for {robot} to stand at {region}, or more `grasps` for {object}")
    } else {
        format!("the base of {robot} nearer to {region}, or more `grasps` for {object}")
    };
    format!("{remedy}, or another robot for {pair}")
}

fn no_common_grasp(problem: &Problem, pair: &str) -> String {
    let known = problem.pairs.iter().find(|known| known.name == pair);
    let object = known.map_or("its object", |pair| problem.movable[pair.object.index()].name.as_str());
    format!("more `grasps` for {object}, or two pairs instead of {pair}: put down on the way and taken again")
}

fn no_path(problem: &Problem, pair: Option<&str>, robot: &str, blocking: &[BodyRef]) -> String {
    let what = pair.map_or_else(|| format!("the return of {robot}"), str::to_owned);
    let objects: Vec<&str> = blocking.iter().filter_map(object_of).collect();
    if objects.is_empty() {
        let others: Vec<String> = blocking.iter().map(ToString::to_string).collect();
        let at = if others.is_empty() { String::new() } else { format!(" at {}", others.join(", ")) };
        return format!("a wider way for {robot} in {what}{at}, or more vertices: `levels: {{vertices: …}}`");
    }
    let advice: Vec<String> = objects.iter().map(|object| out_of_the_way(problem, object, &what)).collect();
    advice.join("; ")
}

fn object_of(body: &BodyRef) -> Option<&str> {
    match body {
        BodyRef::Object(name) | BodyRef::Held { object: name, .. } => Some(name),
        BodyRef::Link { .. } | BodyRef::Fixed(_) => None,
    }
}

/// An object is in the way of a pair: another pair may take it away, or nobody does.
fn out_of_the_way(problem: &Problem, object: &str, pair: &str) -> String {
    let moves = problem.pairs.iter().find(|p| problem.movable[p.object.index()].name == object && p.name != pair);
    match moves {
        Some(other) => {
            let other = &other.name;
            format!(
                "{object} is moved by {other}: order that before or after {pair}, such as `{{before: {other} done, after: {pair} start}}`"
            )
        }
        None => format!("nobody moves {object}: a pair that takes it away before {pair}, or another place for it"),
    }
}
