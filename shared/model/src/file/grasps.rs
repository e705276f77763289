//! Grasps of a problem, for each object and robot.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use super::at::At;
use super::names::Names;
use super::numbers::{finite, pose, positive_number};
use super::syntax::{GraspFile, MovableFile};
use super::words::GraspEntry;
use crate::grasp_families::{HandDepth, side_grasps, take_turns, top_grasps};
use crate::problem_error::{FindingKind, Found, Source};
use crate::{Grasp, GraspFamily, MovableObject, Robot, RobotId};

/// Most entries of a list of grasps.
const MAX_ENTRIES: usize = 10_000;

/// The grasps of one object, for each robot, in canonical order; none for robots that do not carry it.
///
/// The first robot's are worked out in any case, so that what is wrong with an object that nobody carries is told too.
pub(crate) fn grasps(
    source: &Source,
    file: &MovableFile,
    object: &MovableObject,
    robots: &[Robot],
    carriers: &BTreeSet<RobotId>,
) -> Found<Vec<Vec<Grasp>>> {
    let entries = file.grasps.as_ref().map(|at| at.value.0.as_slice());
    if let (Some(at), Some(entries)) = (&file.grasps, entries)
        && (entries.is_empty() || entries.len() > MAX_ENTRIES)
    {
        return Err(source
            .finding(at.span, FindingKind::TooLarge, format!("`{}` has {} grasps", object.name, entries.len()))
            .help(format!("give 1 to {MAX_ENTRIES}, or leave `grasps` out for both families")));
    }
    let names = Names::new("robot", robots.iter().map(|robot| robot.name.as_str()));
    let mut grasps = vec![Vec::new(); robots.len()];
    for (index, robot) in robots.iter().enumerate() {
        let carries = carriers.contains(&RobotId::at(index));
        if carries || index == 0 {
            let known = for_robot(source, entries, object, robot, &names)?;
            grasps[index] = if carries { known } else { Vec::new() };
        }
    }
    Ok(grasps)
}

fn for_robot(
    source: &Source,
    entries: Option<&[At<GraspEntry>]>,
    object: &MovableObject,
    robot: &Robot,
    robots: &Names<'_>,
) -> Found<Vec<Grasp>> {
    let depth = HandDepth::of(robot);
    let Some(entries) = entries else {
        return Ok(take_turns(vec![side_grasps(object, robot, depth), top_grasps(object, robot, depth)]));
    };
    let mut listed = Vec::new();
    let mut families = Vec::new();
    for entry in entries {
        match &entry.value {
            GraspEntry::Side => families.push(side_grasps(object, robot, depth)),
            GraspEntry::Top => families.push(top_grasps(object, robot, depth)),
            GraspEntry::One(file) => listed.extend(one(source, file, robot, robots)?),
        }
    }
    families.insert(0, listed);
    Ok(take_turns(families))
}

/// A listed grasp, if it is for this robot.
fn one(source: &Source, file: &GraspFile, robot: &Robot, robots: &Names<'_>) -> Found<Option<Grasp>> {
    let mut meant = file.robots.is_none();
    for name in file.robots.iter().flatten() {
        robots.find(source, name)?;
        meant |= robot.name == name.value;
    }
    let hand = &robot.end_effector;
    let link_from_object = pose(source, Some(&file.link_from_object), "a grasp")?;
    let opening = positive_number(source, &file.opening, "a grasp's opening")?;
    if meant && opening > hand.max_opening {
        return Err(source
            .finding(
                file.opening.span,
                FindingKind::BadNumber,
                format!("the hand of `{}` cannot open {opening} m", robot.name),
            )
            .help(format!("it opens {} m; limit the grasp to other robots with `robots`", hand.max_opening)));
    }
    let approach = match &file.approach {
        None => hand.link_from_tool.rotation * Vector3::z(),
        Some(at) => {
            Vector3::from(finite(source, at, "a grasp's approach")?).try_normalize(1.0e-6).ok_or_else(|| {
                source
                    .finding(at.span, FindingKind::BadNumber, "an approach without direction")
                    .help("give a direction such as [0, 0, 1]")
            })?
        }
    };
    let grasp = Grasp { link_from_object, opening, approach: approach.into(), family: GraspFamily::Listed };
    Ok(meant.then_some(grasp))
}
