//! A failure as the page's scripts read it: what was tried, and causes with the bodies that they name.

use model::Problem;
use plan::{BodyRef, Cause, Certificate, Failure, PairPoint, ResultKind};
use serde::Serialize;

/// A failure in words and names.
#[derive(Serialize)]
pub struct FailureData {
    result: ResultKind,
    headline: &'static str,
    tried: Tried,
    causes: Vec<CauseData>,
    /// What to try, the most promising first.
    remedies: Vec<String>,
}

/// How far the search went, in words.
#[derive(Serialize)]
struct Tried {
    heading: String,
    lines: Vec<String>,
}

#[derive(Serialize)]
struct CauseData {
    group: Group,
    words: String,
    /// How often it was met; 0 for a proof.
    count: u64,
    /// What to highlight: `robot:<name>`, `link:<robot>/<link>`, `object:<name>`, `fixed:<name>`, `region:<name>`.
    bodies: Vec<String>,
}

/// What kind of cause it is: counts of different groups do not compare.
#[derive(Serialize)]
#[serde(rename_all = "snake_case")]
enum Group {
    /// What a certificate proves.
    Proof,
    /// Something of the task that could not be done.
    Task,
    /// A contact met while trying.
    Contact,
}

impl FailureData {
    /// A failure of a problem.
    #[must_use]
    pub fn of(problem: &Problem, failure: &Failure) -> Self {
        let proof = failure.certificate.iter().map(|certificate| CauseData {
            group: Group::Proof,
            words: crate::words::proof(certificate),
            count: 0,
            bodies: distinct(proof_bodies(problem, certificate)),
        });
        let causes = failure.causes.iter().map(|(cause, count)| CauseData {
            group: if matches!(cause, Cause::Collision { .. }) { Group::Contact } else { Group::Task },
            words: crate::words::cause(cause),
            count: *count,
            bodies: distinct(bodies(problem, cause)),
        });
        Self {
            result: failure.result,
            headline: crate::words::result(failure.result),
            tried: tried(problem, failure),
            causes: proof.chain(causes).collect(),
            remedies: crate::explain::remedies::of_failure(problem, failure),
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
    let mut lines: Vec<String> = failure.stopped_by.iter().map(crate::words::stopped_by).collect();
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
    let answered = if jobs == 1 { "1 job was answered".to_owned() } else { format!("{jobs} jobs were answered") };
    lines.push(format!("{answered}, {failures} with a failure"));
    lines.extend(failure.reached.map(crate::explain::reached_words));
    Tried { heading, lines }
}

fn bodies(problem: &Problem, cause: &Cause) -> Vec<String> {
    match cause {
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
    }
}

fn proof_bodies(problem: &Problem, certificate: &Certificate) -> Vec<String> {
    match certificate {
        Certificate::Cycle { exclusions, .. } => exclusions
            .iter()
            .flat_map(|exclusion| {
                let objects = exclusion.stays.iter().map(|cover| of("object", &cover.stay.object));
                objects.chain([of("region", &exclusion.region)]).collect::<Vec<_>>()
            })
            .collect(),
        Certificate::Area { region, stays, .. } => {
            let objects = stays.iter().map(|cover| of("object", &cover.stay.object));
            objects.chain([of("region", region)]).collect()
        }
        Certificate::ObjectTooLarge { object, region } => vec![of("object", object), of("region", region)],
        Certificate::Reach { robot, pair, region, .. } | Certificate::BaseDisconnected { robot, pair, region, .. } => {
            let pair = problem.pairs.iter().find(|known| known.name == *pair);
            let object = pair.map(|pair| of("object", &problem.movable[pair.object.index()].name));
            object.into_iter().chain([of("robot", robot), of("region", region)]).collect()
        }
        Certificate::NoCommonGrasp { pair, .. } => pair_bodies(problem, pair),
    }
}

fn distinct(mut names: Vec<String>) -> Vec<String> {
    names.sort();
    names.dedup();
    names
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
