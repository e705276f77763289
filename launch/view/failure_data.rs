//! A failure as the page's scripts read it: what was tried, and causes with the bodies that they name.

use model::Problem;
use plan::{BodyRef, Cause, Failure, PairPoint, ResultKind};
use serde::Serialize;

/// A failure in words and names.
#[derive(Serialize)]
pub struct FailureData {
    result: ResultKind,
    headline: &'static str,
    tried: Tried,
    causes: Vec<CauseData>,
}

/// How far the search went, in words.
#[derive(Serialize)]
struct Tried {
    heading: String,
    lines: Vec<String>,
}

#[derive(Serialize)]
struct CauseData {
    words: String,
    count: u64,
    /// Whether it is a contact met while trying, rather than something of the task that could not be done.
    contact: bool,
    /// What to highlight: `robot:<name>`, `link:<robot>/<link>`, `object:<name>`, `fixed:<name>`, `region:<name>`.
    bodies: Vec<String>,
}

impl FailureData {
    /// A failure of a problem.
    #[must_use]
    pub fn of(problem: &Problem, failure: &Failure) -> Self {
        let causes = failure.causes.iter().map(|(cause, count)| CauseData {
            words: crate::words::cause(cause),
            count: *count,
            contact: matches!(cause, Cause::Collision { .. }),
            bodies: bodies(problem, cause),
        });
        Self {
            result: failure.result,
            headline: crate::words::result(failure.result),
            tried: tried(problem, failure),
            causes: causes.collect(),
        }
    }
}

fn tried(problem: &Problem, failure: &Failure) -> Tried {
    let levels = &problem.levels;
    let grown = |count: u32| u64::from(count) << levels.highest.min(32);
    let heading = match (failure.result, levels.highest) {
        (ResultKind::SamplesExhausted, 0) => "The first level of samples alone (levels.highest is 0):".to_owned(),
        (ResultKind::SamplesExhausted, highest) => {
            format!("All levels of samples from 0 to {highest}, each with twice as many as the last; at the end")
        }
        (ResultKind::LimitReached, _) => "As much as the limit allowed:".to_owned(),
        (ResultKind::InfeasibleProven, _) => "As much as the proof needed:".to_owned(),
    };
    let mut lines = Vec::new();
    if failure.result == ResultKind::SamplesExhausted {
        lines.push(format!("{} placements for each hop of an object", grown(levels.placements)));
        lines.push(format!(
            "{} grasps and {} stands for each end of a pair",
            grown(levels.grasps),
            grown(levels.stands)
        ));
        lines.push(format!("{} vertices for each piece of a roadmap", grown(levels.vertices)));
    }
    let jobs: u64 = failure.stages.iter().map(|stage| stage.jobs).sum();
    let failures: u64 = failure.stages.iter().map(|stage| stage.failures).sum();
    lines.push(format!("{jobs} jobs answered, {failures} of them with a failure"));
    Tried { heading, lines }
}

fn bodies(problem: &Problem, cause: &Cause) -> Vec<String> {
    let mut named = match cause {
        Cause::Collision { first, second } => vec![body(first), body(second)],
        Cause::Overlap { region, leaves, comes } => {
            vec![of("region", region), of("object", leaves), of("object", comes)]
        }
        Cause::NoPlacement { object, region } => vec![of("object", object), of("region", region)],
        Cause::Cycle { points } => {
            points.iter().flat_map(|PairPoint { pair, .. }| pair_bodies(problem, pair)).collect()
        }
        Cause::Unreachable { robot, object, region, .. } => {
            vec![of("robot", robot), of("object", object), of("region", region)]
        }
        Cause::NoCommonGrasp { pair } => pair_bodies(problem, pair),
        Cause::NoPath { pair, robot, blocking } => {
            let mut named = pair.as_ref().map_or_else(|| vec![of("robot", robot)], |pair| pair_bodies(problem, pair));
            named.extend(blocking.iter().map(body));
            named
        }
        Cause::Deadlock { robots } => robots.iter().map(|robot| of("robot", robot)).collect(),
        Cause::Budget { .. } => Vec::new(),
    };
    named.sort();
    named.dedup();
    named
}

fn of(kind: &str, name: &str) -> String {
    format!("{kind}:{name}")
}

fn body(body: &BodyRef) -> String {
    match body {
        BodyRef::Link { robot, link } => format!("link:{robot}/{link}"),
        BodyRef::Held { object, .. } | BodyRef::Object(object) => of("object", object),
        BodyRef::Fixed(name) => of("fixed", name),
    }
}

fn pair_bodies(problem: &Problem, name: &str) -> Vec<String> {
    let Some(pair) = problem.pairs.iter().find(|pair| pair.name == name) else { return Vec::new() };
    vec![
        of("robot", &problem.robot(pair.robot).name),
        of("object", &problem.movable[pair.object.index()].name),
        of("region", &problem.regions[pair.from.index()].name),
        of("region", &problem.regions[pair.to.index()].name),
    ]
}
