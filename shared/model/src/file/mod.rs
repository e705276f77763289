//! The problem file: from YAML to the resolved problem, or to findings that name file, line and remedy.

pub(crate) mod alone;
mod at;
mod coordinates;
mod cycle;
mod grasps;
mod hops;
mod names;
mod numbers;
mod parse;
mod placing;
mod robots;
mod scene;
mod settings;
mod start;
mod surfaces;
mod syntax;
mod task;
mod words;

use std::collections::BTreeSet;

use crate::problem_error::{FindingKind, Findings, Found, ProblemError, Source, Span};
use crate::{Files, FixedObject, Gate, GivenOrdering, MovableObject, Places, Problem, Region, Robot, Settings};

pub(crate) use names::did_you_mean;
pub(crate) use numbers::GREATEST;
pub(crate) use parse::{read_text, why_unread};

use at::At;
use syntax::{PoseFile, ProblemFile, RobotFile};

/// Most robots, and most objects and regions of each kind.
const MAX_ROBOTS: usize = 1_000;
const MAX_OBJECTS: usize = 10_000;
/// Most pairs, and most orderings.
const MAX_PAIRS: usize = 100_000;

/// Reads a problem file and everything that it names.
///
/// Poses, limits, names, the hops of objects and the orderings are checked; collisions at the start are not.
///
/// # Errors
/// What is wrong, with file, line and remedy: all findings of the first step that has any.
pub fn load_problem(files: &dyn Files, path: &str) -> Result<Problem, ProblemError> {
    load_problem_with_places(files, path).map(|(problem, _)| problem)
}

/// As [`load_problem`], with the places of its parts in the file.
///
/// # Errors
/// As [`load_problem`].
pub fn load_problem_with_places(files: &dyn Files, path: &str) -> Result<(Problem, Places), ProblemError> {
    let source = parse::read_text(files, path)?;
    let file = parse::parse(&source)?;
    check_counts(&source, &file)?;
    check_names(&source, &file)?;
    let settings = settings::settings(&source, file.settings.as_ref())?;
    let levels = settings::levels(&source, file.levels.as_ref())?;
    let mut scene = scene(files, &source, &file, &settings)?;
    let (pairs, orderings) = task(&source, &file, &scene, settings.gate)?;
    grasps(&source, &file, &pairs, &mut scene)?;
    supports(&source, &file, &pairs, &mut scene, &settings)?;
    let stem = path.rsplit('/').next().unwrap_or(path);
    let places = places(&source, &file);
    let problem = Problem {
        name: file.name.map_or_else(|| stem.split('.').next().unwrap_or(stem).to_owned(), |at| at.value),
        end_policies: file.robots.iter().map(|robot| robot.end).collect(),
        robots: scene.robots,
        fixed: scene.fixed,
        movable: scene.movable,
        regions: scene.regions,
        pairs: pairs.pairs,
        orderings,
        settings,
        levels,
        search: file.search,
    };
    Ok((problem, places))
}

fn places(source: &Source, file: &ProblemFile) -> Places {
    let pose = |at: &At<PoseFile>| at.xyz.as_ref().map_or(at.span, |xyz| xyz.span);
    let robot = |entry: &RobotFile| {
        let posed = || entry.pose.as_ref().map_or(entry.name.span, pose);
        entry.start.as_ref().map_or_else(posed, |start| start.span)
    };
    Places {
        source: source.clone(),
        robots: file.robots.iter().map(|entry| robot(entry)).collect(),
        fixed: file.fixed.iter().map(|entry| entry.pose.as_ref().map_or(entry.name.span, pose)).collect(),
        movable: file.movable.iter().map(|entry| pose(&entry.pose)).collect(),
    }
}

/// The JSON Schema of problem files.
#[must_use]
pub fn problem_schema() -> schemars::Schema {
    schemars::schema_for!(ProblemFile)
}

struct Scene {
    robots: Vec<Robot>,
    fixed: Vec<FixedObject>,
    movable: Vec<MovableObject>,
    regions: Vec<Region>,
}

fn check_counts(source: &Source, file: &ProblemFile) -> Found<()> {
    let counts = [
        ("robots", file.robots.len(), 1, MAX_ROBOTS, file.robots.span),
        ("fixed", file.fixed.len(), 0, MAX_OBJECTS, beyond(&file.fixed, MAX_OBJECTS)),
        ("movable", file.movable.len(), 0, MAX_OBJECTS, beyond(&file.movable, MAX_OBJECTS)),
        ("regions", file.regions.len(), 0, MAX_OBJECTS, beyond(&file.regions, MAX_OBJECTS)),
        ("orderings", file.orderings.len(), 0, MAX_PAIRS, beyond(&file.orderings, MAX_PAIRS)),
    ];
    for (key, count, least, most, span) in counts {
        if count < least || count > most {
            return Err(source
                .finding(span, FindingKind::TooLarge, format!("{count} entries in `{key}`"))
                .help(format!("give {least} to {most}")));
        }
    }
    Ok(())
}

/// The first entry beyond `most`.
fn beyond<T>(entries: &[At<T>], most: usize) -> Span {
    entries.get(most).map_or(Span { offset: 0, len: 0 }, |entry| entry.span)
}

fn check_names(source: &Source, file: &ProblemFile) -> Result<(), ProblemError> {
    let mut findings = Findings::default();
    let kinds = [
        numbers::unique_names(source, file.robots.iter().map(|entry| &entry.name), "robot"),
        numbers::unique_names(source, file.fixed.iter().map(|entry| &entry.name), "fixed object"),
        numbers::unique_names(source, file.movable.iter().map(|entry| &entry.name), "movable object"),
        numbers::unique_names(source, file.regions.iter().map(|entry| &entry.name), "region"),
        file.name.iter().map(|at| numbers::name(source, at, "problem").map(|_| ())).collect(),
    ];
    for found in kinds.into_iter().flatten() {
        findings.keep(found);
    }
    findings.end()
}

fn scene(files: &dyn Files, source: &Source, file: &ProblemFile, settings: &Settings) -> Result<Scene, ProblemError> {
    let mut findings = Findings::default();
    let mut scene = Scene { robots: Vec::new(), fixed: Vec::new(), movable: Vec::new(), regions: Vec::new() };
    for entry in &file.robots.value {
        scene.robots.extend(findings.keep(robots::robot(files, source, entry)));
    }
    for entry in &file.fixed {
        scene.fixed.extend(findings.keep(scene::fixed(files, source, entry)));
    }
    for entry in &file.movable {
        scene.movable.extend(findings.keep(scene::movable(files, source, entry)));
    }
    findings.end()?;
    let names = names::Names::new("fixed object", scene.fixed.iter().map(|object| object.name.as_str()));
    for entry in &file.regions {
        let region = scene::region(source, entry, &scene.fixed, &names, settings.support_tolerance);
        scene.regions.extend(findings.keep(region));
    }
    findings.end()?;
    Ok(scene)
}

/// Pairs with their hops, and orderings that do not contradict them.
fn task(
    source: &Source,
    file: &ProblemFile,
    scene: &Scene,
    gate: Gate,
) -> Result<(task::Pairs, Vec<GivenOrdering>), ProblemError> {
    let nouns = task::Nouns::of(&scene.robots, &scene.movable, &scene.regions);
    let mut pairs = task::pairs(source, &file.task, &nouns, MAX_PAIRS)?;
    let orderings = task::orderings(source, &file.orderings, &pairs)?;
    task::hops(source, &mut pairs, &nouns, &orderings)?;
    let gated = |ordering: GivenOrdering| ordering.gated(gate, &pairs.pairs, &scene.robots);
    cycle::refuse_cycle(source, &file.orderings, &pairs, &orderings, &gated)?;
    Ok((pairs, orderings))
}

fn grasps(source: &Source, file: &ProblemFile, pairs: &task::Pairs, scene: &mut Scene) -> Result<(), ProblemError> {
    let mut findings = Findings::default();
    for (index, (entry, robot)) in file.robots.iter().zip(&scene.robots).enumerate() {
        let carries = pairs.pairs.iter().any(|pair| pair.robot.index() == index);
        findings.keep(if carries { robots::check_opening(source, entry, robot) } else { Ok(()) });
    }
    findings.end()?;
    let mut carriers = vec![BTreeSet::new(); scene.movable.len()];
    for pair in &pairs.pairs {
        carriers[pair.object.index()].insert(pair.robot);
    }
    for ((entry, object), carriers) in file.movable.iter().zip(&mut scene.movable).zip(&carriers) {
        if let Some(grasps) = findings.keep(grasps::grasps(source, entry, object, &scene.robots, carriers)) {
            object.grasps = grasps;
        }
    }
    findings.end()?;
    task::check_grasps(source, pairs, &scene.robots, &scene.movable)
}

fn supports(
    source: &Source,
    file: &ProblemFile,
    pairs: &task::Pairs,
    scene: &mut Scene,
    settings: &Settings,
) -> Result<(), ProblemError> {
    let mut findings = Findings::default();
    let surfaces = placing::all_surfaces(&scene.fixed);
    let tolerance = settings.support_tolerance;
    let mut first_pairs: Vec<Option<usize>> = vec![None; scene.movable.len()];
    for (index, pair) in pairs.pairs.iter().enumerate().filter(|(_, pair)| pair.hop == 1) {
        first_pairs[pair.object.index()] = Some(index);
    }
    let mut supports = Vec::with_capacity(scene.movable.len());
    for (index, (entry, object)) in file.movable.iter().zip(&scene.movable).enumerate() {
        let under = placing::support(source, entry, object, &scene.fixed, &surfaces, tolerance);
        let support = under.and_then(|under| {
            let first = first_pairs[index].map(|pair| (&pairs.pairs[pair], pairs.spans[pair]));
            let by_region = placing::first_hop(source, entry, first, object, &scene.regions, tolerance)?;
            Ok(by_region.unwrap_or(under))
        });
        supports.push(findings.keep(support));
    }
    findings.end()?;
    for (object, support) in scene.movable.iter_mut().zip(supports) {
        object.start_support = support;
    }
    Ok(())
}
