//! Causes, modes and results in a user's words.

use model::Problem;
use plan::{BodyRef, Cause, PairPoint, PlanOrdering, ResultKind};
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

/// How a search without a plan ended.
#[must_use]
pub fn result(result: ResultKind) -> &'static str {
    match result {
        ResultKind::InfeasibleProven => "There is no plan: proven.",
        ResultKind::SamplesExhausted => "No plan among the samples tried. That is no proof.",
        ResultKind::LimitReached => "No plan within the limit.",
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
