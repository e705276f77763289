//! Robots of a problem: description files joined with what the problem says.

use nalgebra::Vector3;

use super::at::At;
use super::coordinates::plan_coordinates;
use super::names::did_you_mean;
use super::numbers::{pose, positive_number, range};
use super::parse::why_unread;
use super::start::{named_state, start};
use super::syntax::{BaseFile, RobotFile};
use crate::files::{folder, join};
use crate::locate::locate;
use crate::problem_error::{FindingKind, Found, Source};
use crate::urdf::{Description, describe};
use crate::{Coordinate, EndEffector, Files, LinkId, PlanarBase, Pose, Robot};

/// Resolves one robot.
pub(crate) fn robot(files: &dyn Files, source: &Source, file: &RobotFile) -> Found<Robot> {
    let described = describe(files, &find(files, source, &file.urdf)?, &find(files, source, &file.srdf)?)?;
    resolve(source, file, described)
}

/// The path of a file that the problem names, once it can be read.
fn find(files: &dyn Files, source: &Source, named: &At<String>) -> Found<String> {
    if named.value.trim_start().starts_with("package://") {
        return locate(files, source, named.span, "file", &named.value).map(|(path, _)| path);
    }
    let path = join(folder(&source.path), &named.value);
    match files.read(&path) {
        Ok(_) => Ok(path),
        Err(error) => Err(source
            .finding(named.span, FindingKind::Unreadable, format!("{path}: {}", why_unread(&error)))
            .help("give a path relative to the folder of this file, or `package://name/path`")),
    }
}

/// Joins the description files with what the problem says.
pub(crate) fn resolve(source: &Source, file: &RobotFile, described: Description) -> Found<Robot> {
    let world_from_base = pose(source, file.pose.as_ref(), "the robot's pose")?;
    let base = base(source, file, &described, &world_from_base)?;
    let base_coordinates = base.as_ref().map_or_else(Vec::new, |(_, coordinates)| coordinates.clone());
    let plan = plan_coordinates(&described, base_coordinates)?;
    let home = named_state(&described, &plan, "home")?;
    let home = home.ok_or_else(|| {
        described.srdf_source.finding(described.srdf.span, FindingKind::BadRobot, "no group state `home`").help(
            "add `<group_state name=\"home\" group=\"...\">`: the configuration of the arm in which the robot drives",
        )
    })?;
    let carry = named_state(&described, &plan, "carry")?.unwrap_or_else(|| home.clone());
    let start = start(source, file, &plan, base.is_some(), &home)?;
    Ok(Robot {
        name: file.name.value.clone(),
        world_from_base,
        end_effector: end_effector(source, file, &described, plan.max_opening)?,
        disabled_pairs: disabled_pairs(&described),
        joints: plan.joints,
        coordinates: plan.coordinates,
        base: base.map(|(base, _)| base),
        links: described.links,
        start,
        home,
        carry,
    })
}

/// The planar base and its three coordinates, if the SRDF declares one.
fn base(
    source: &Source,
    file: &RobotFile,
    described: &Description,
    world_from_base: &Pose,
) -> Found<Option<(PlanarBase, Vec<Coordinate>)>> {
    let planar = described.srdf.virtual_joint.as_ref().filter(|joint| joint.planar);
    match (planar, &file.base) {
        (None, None) => Ok(None),
        (None, Some(given)) => Err(source
            .finding(given.span, FindingKind::BadRobot, format!("`{}` has no planar base", file.name.value))
            .help(format!("remove `base`, or declare a planar virtual joint in {}", described.srdf_source.path))),
        (Some(_), None) => Err(source
            .finding(
                file.name.span,
                FindingKind::BadRobot,
                format!("`{}` has a planar base without limits", file.name.value),
            )
            .help("add `base: {x: [least, greatest], y: [least, greatest], speed: 0.8, yaw_rate: 1.5}`")),
        (Some(joint), Some(given)) => {
            let up = world_from_base.rotation * Vector3::z();
            if let Some(at) = file.pose.as_ref().filter(|_| up.z < 1.0 - 1.0e-9) {
                return Err(source
                    .finding(at.span, FindingKind::BadPlace, "a planar base on a slope")
                    .help("turn its pose about z only"));
            }
            limits(source, &joint.name, given).map(Some)
        }
    }
}

fn limits(source: &Source, joint: &str, given: &BaseFile) -> Found<(PlanarBase, Vec<Coordinate>)> {
    let x = range(source, &given.x, "the base's x")?;
    let y = range(source, &given.y, "the base's y")?;
    let speed = positive_number(source, &given.speed, "the base's speed")?;
    let yaw_rate = positive_number(source, &given.yaw_rate, "the base's yaw rate")?;
    let coordinate = |name: &str, [lower, upper]: [f64; 2], velocity: f64| Coordinate {
        name: format!("{joint}/{name}"),
        lower,
        upper,
        velocity,
    };
    let yaw = [f64::NEG_INFINITY, f64::INFINITY];
    let coordinates = vec![coordinate("x", x, speed), coordinate("y", y, speed), coordinate("yaw", yaw, yaw_rate)];
    Ok((PlanarBase { speed, yaw_rate }, coordinates))
}

fn end_effector(source: &Source, file: &RobotFile, described: &Description, widest: f64) -> Found<EndEffector> {
    let entry = &described.srdf.end_effector;
    let max_opening = match &file.max_opening {
        None => widest,
        Some(at) => opening(source, at, widest)?,
    };
    let link_from_tool = match &file.tool {
        None => Pose::identity(),
        Some(at) => tool(source, at, described, entry.parent_link)?,
    };
    Ok(EndEffector {
        name: entry.name.clone(),
        parent_link: entry.parent_link,
        link_from_tool,
        links: entry.links.clone(),
        max_opening,
    })
}

fn opening(source: &Source, at: &At<f64>, widest: f64) -> Found<f64> {
    let opening = positive_number(source, at, "`max_opening`")?;
    if widest == 0.0 || opening <= widest + 1.0e-9 {
        return Ok(opening);
    }
    Err(source
        .finding(at.span, FindingKind::BadNumber, format!("the fingers cannot open {opening} m"))
        .help(format!("their joints' limits allow {widest:.4} m")))
}

/// Refuses a robot that carries objects with a hand of which nothing says how wide they may be.
pub(crate) fn check_opening(source: &Source, file: &RobotFile, robot: &Robot) -> Found<()> {
    if robot.end_effector.max_opening > 0.0 {
        return Ok(());
    }
    let message =
        format!("how wide an object the hand of `{}` takes is not known: it has no sliding fingers", robot.name);
    Err(source
        .finding(file.name.span, FindingKind::BadRobot, message)
        .help("add `max_opening` (m); a suction cup may take objects wider than itself"))
}

/// Pose of the tool link in the parent link, both on one rigid piece.
fn tool(source: &Source, at: &At<String>, described: &Description, parent: LinkId) -> Found<Pose> {
    let Some(tool) = described.link(at) else {
        return Err(source
            .finding(at.span, FindingKind::UnknownName, format!("the URDF has no link `{}`", at.value.escape_debug()))
            .help(did_you_mean(at, described.links.iter().map(|link| link.name.as_str()))));
    };
    let (root, root_from_tool) = described.rigid_root(tool);
    let (parent_root, root_from_parent) = described.rigid_root(parent);
    if root == parent_root {
        return Ok(root_from_parent.inverse() * root_from_tool);
    }
    let parent = &described.links[parent.index()].name;
    Err(source
        .finding(at.span, FindingKind::BadRobot, format!("`{}` moves relative to `{parent}`", at.value))
        .help(format!("the tool link must be fixed to `{parent}`, the parent link of the end effector")))
}

/// Pairs that are never tested: joined by a joint, on one rigid piece, or disabled by the SRDF.
fn disabled_pairs(described: &Description) -> Vec<(LinkId, LinkId)> {
    let mut pairs = described.srdf.disabled.clone();
    let ordered = |a: LinkId, b: LinkId| (a.min(b), a.max(b));
    pairs.extend(described.joints.iter().map(|joint| ordered(joint.parent, joint.child)));
    let roots: Vec<LinkId> = (0..described.links.len()).map(|link| described.rigid_root(LinkId::at(link)).0).collect();
    for one in 0..roots.len() {
        let same = (one + 1..roots.len()).filter(|other| roots[one] == roots[*other]);
        pairs.extend(same.map(|other| (LinkId::at(one), LinkId::at(other))));
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}
