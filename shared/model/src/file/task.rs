//! The task plan: pairs by name, their hops, and given orderings.

use super::at::At;
use super::hops::number_hops;
use super::names::Names;
use super::syntax::{OrderingFile, PairFile};
use super::words::{PairList, PointFile, TaskFile};
use crate::problem_error::{FindingKind, Findings, Found, Source, Span};
use crate::{
    GivenOrdering, MovableObject, ObjectId, Pair, PairId, Point, ProblemError, Region, RegionId, Robot, RobotId,
};

/// Pairs, robot by robot, with their places in the file.
pub(crate) struct Pairs {
    pub pairs: Vec<Pair>,
    pub spans: Vec<Span>,
}

/// What pairs name.
pub(crate) struct Nouns<'a> {
    pub robots: &'a [Robot],
    pub movable: &'a [MovableObject],
    pub regions: &'a [Region],
    robot_names: Names<'a>,
    movable_names: Names<'a>,
    region_names: Names<'a>,
}

impl<'a> Nouns<'a> {
    pub(crate) fn of(robots: &'a [Robot], movable: &'a [MovableObject], regions: &'a [Region]) -> Self {
        Self {
            robots,
            movable,
            regions,
            robot_names: Names::new("robot", robots.iter().map(|robot| robot.name.as_str())),
            movable_names: Names::new("movable object", movable.iter().map(|object| object.name.as_str())),
            region_names: Names::new("region", regions.iter().map(|region| region.name.as_str())),
        }
    }
}

/// Resolves all pairs; hop numbers are given afterwards.
pub(crate) fn pairs(
    source: &Source,
    file: &At<TaskFile>,
    nouns: &Nouns<'_>,
    most: usize,
) -> Result<Pairs, ProblemError> {
    let mut findings = Findings::default();
    let mut by_robot: Vec<Option<&At<PairList>>> = vec![None; nouns.robots.len()];
    for (name, list) in &file.value.0 {
        let robot = findings.keep(nouns.robot_names.find(source, name));
        if let Some(robot) = robot {
            by_robot[robot] = Some(list);
        }
    }
    let mut pairs = Pairs { pairs: Vec::new(), spans: Vec::new() };
    for (robot, list) in by_robot.iter().enumerate() {
        for (number, entry) in list.iter().flat_map(|list| &list.value).enumerate() {
            if let Some(pair) = findings.keep(pair(source, entry, nouns, RobotId::at(robot), number + 1)) {
                pairs.pairs.push(pair);
                pairs.spans.push(entry.span);
            }
        }
    }
    findings.keep(unique(source, &pairs));
    findings.end()?;
    if pairs.pairs.is_empty() || pairs.pairs.len() > most {
        let message = if pairs.pairs.is_empty() {
            "the task is empty".to_owned()
        } else {
            format!("{} pairs", pairs.pairs.len())
        };
        let help = format!("give 1 to {most} pairs, such as `r1: [{{object: m1, from: w1, to: w2}}]`");
        return Err(source.finding(file.span, FindingKind::BadTask, message).help(help).into());
    }
    Ok(pairs)
}

fn pair(source: &Source, entry: &At<PairFile>, nouns: &Nouns<'_>, robot: RobotId, number: usize) -> Found<Pair> {
    let object = nouns.movable_names.find(source, &entry.object)?;
    let from = nouns.region_names.find(source, &entry.from)?;
    let to = nouns.region_names.find(source, &entry.to)?;
    let name = match &entry.name {
        Some(at) => super::numbers::name(source, at, "pair")?.to_owned(),
        None => format!("{}.{number}", nouns.robots[robot.index()].name),
    };
    Ok(Pair { name, robot, object: ObjectId::at(object), from: RegionId::at(from), to: RegionId::at(to), hop: 0 })
}

/// Checks that every robot can hold what it carries.
pub(crate) fn check_grasps(
    source: &Source,
    pairs: &Pairs,
    robots: &[Robot],
    movable: &[MovableObject],
) -> Result<(), ProblemError> {
    let mut findings = Findings::default();
    for (pair, span) in pairs.pairs.iter().zip(&pairs.spans) {
        let (robot, object) = (&robots[pair.robot.index()], &movable[pair.object.index()]);
        if object.grasps[pair.robot.index()].is_empty() {
            let message = format!("`{}` has no grasp for `{}`", robot.name, object.name);
            let opening = robot.end_effector.max_opening;
            let help = format!("its hand opens {opening} m; allow another family or list a grasp");
            findings.keep::<()>(Err(source.finding(*span, FindingKind::BadTask, message).help(help)));
        }
    }
    findings.end()
}

fn unique(source: &Source, pairs: &Pairs) -> Found<()> {
    let mut seen = std::collections::BTreeMap::new();
    for (pair, span) in pairs.pairs.iter().zip(&pairs.spans) {
        if let Some(other) = seen.insert(&pair.name, *span) {
            return Err(source
                .finding(*span, FindingKind::BadName, format!("two pairs are called `{}`", pair.name))
                .note(source, other, "the other")
                .help("give one of them another `name`"));
        }
    }
    Ok(())
}

/// Resolves given orderings.
pub(crate) fn orderings(
    source: &Source,
    file: &[At<OrderingFile>],
    pairs: &Pairs,
) -> Result<Vec<GivenOrdering>, ProblemError> {
    let mut findings = Findings::default();
    let mut orderings = Vec::with_capacity(file.len());
    let names = Names::new("pair", pairs.pairs.iter().map(|pair| pair.name.as_str()));
    let event = |at: &At<PointFile>| -> Found<(PairId, Point)> {
        Ok((PairId::at(names.find_name(source, at, &at.value.pair)?), at.value.point))
    };
    for ordering in file {
        let before = findings.keep(event(&ordering.before));
        let after = findings.keep(event(&ordering.after));
        if let (Some(before), Some(after)) = (before, after) {
            orderings.push(GivenOrdering { before, after });
        }
    }
    findings.end()?;
    Ok(orderings)
}

/// Numbers the hops of every object.
pub(crate) fn hops(
    source: &Source,
    pairs: &mut Pairs,
    nouns: &Nouns<'_>,
    orderings: &[GivenOrdering],
) -> Result<(), ProblemError> {
    let mut findings = Findings::default();
    let mut by_object: Vec<Vec<usize>> = vec![Vec::new(); nouns.movable.len()];
    for (index, pair) in pairs.pairs.iter().enumerate() {
        by_object[pair.object.index()].push(index);
    }
    for (object, own) in by_object.iter().enumerate().filter(|(_, own)| !own.is_empty()) {
        findings.keep(number_hops(source, pairs, nouns, ObjectId::at(object), own, orderings));
    }
    findings.end()
}
