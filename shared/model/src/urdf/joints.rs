//! Joints of a URDF, checked.

use nalgebra::{Translation3, UnitQuaternion, Vector3};
use roxmltree::Node;

use super::tree::Tree;
use super::xml::{attribute, child, number, span};
use super::{JointDescription, Limit, Mimic};
use crate::problem_error::{FindingKind, Found, Source, Span};
use crate::{JointMotion, LinkId, Pose};

/// Checks what `urdf_rs` lets pass: limits, axes, types.
pub(crate) fn check(source: &Source, joints: &[Node<'_, '_>]) -> Found<()> {
    for joint in joints {
        let name = attribute(source, *joint, "name")?;
        match attribute(source, *joint, "type")? {
            "fixed" => {}
            "continuous" => {
                check_axis(source, *joint, name)?;
                check_velocity(source, *joint, name)?;
            }
            "revolute" | "prismatic" => {
                check_axis(source, *joint, name)?;
                check_bounds(source, *joint, name)?;
                check_velocity(source, *joint, name)?;
            }
            other => {
                return Err(source
                    .finding(span(source, *joint), FindingKind::BadRobot, format!("joint `{name}` is of type {other}"))
                    .help("use revolute, continuous, prismatic or fixed joints; declare a planar base as a virtual joint in the SRDF"));
            }
        }
    }
    Ok(())
}

fn check_axis(source: &Source, joint: Node<'_, '_>, name: &str) -> Found<()> {
    let Some(axis) = child(joint, "axis") else { return Ok(()) };
    let numbers = attribute(source, axis, "xyz")?.split_whitespace().filter_map(|text| text.parse::<f64>().ok());
    if numbers.map(f64::abs).fold(0.0, f64::max) > 1.0e-6 {
        return Ok(());
    }
    Err(source
        .finding(span(source, axis), FindingKind::BadRobot, format!("joint `{name}` has no axis"))
        .help("give a direction such as \"0 0 1\""))
}

fn limit<'a, 'i>(source: &Source, joint: Node<'a, 'i>, name: &str) -> Found<Node<'a, 'i>> {
    child(joint, "limit").ok_or_else(|| {
        source
            .finding(span(source, joint), FindingKind::BadRobot, format!("joint `{name}` has no `<limit>`"))
            .help("add `<limit lower=\"...\" upper=\"...\" velocity=\"...\" effort=\"...\"/>`")
    })
}

fn check_bounds(source: &Source, joint: Node<'_, '_>, name: &str) -> Found<()> {
    let limit = limit(source, joint, name)?;
    let (lower, upper) = (number(source, limit, "lower")?, number(source, limit, "upper")?);
    if lower < upper {
        return Ok(());
    }
    Err(source
        .finding(span(source, limit), FindingKind::BadRobot, format!("joint `{name}` runs from {lower} to {upper}"))
        .help("`lower` must be less than `upper`; make a joint that cannot move `fixed`"))
}

fn check_velocity(source: &Source, joint: Node<'_, '_>, name: &str) -> Found<()> {
    let limit = limit(source, joint, name)?;
    let velocity = number(source, limit, "velocity")?;
    if velocity > 0.0 {
        return Ok(());
    }
    Err(source
        .finding(span(source, limit), FindingKind::BadRobot, format!("joint `{name}` has velocity {velocity}"))
        .help("give the greatest speed in rad/s or m/s"))
}

/// The joints in the tree's order.
pub(crate) fn joints(
    source: &Source,
    tree: &Tree,
    nodes: &[Node<'_, '_>],
    read: &[urdf_rs::Joint],
) -> Found<Vec<JointDescription>> {
    let link_at = |position: usize| LinkId::at(tree.links.iter().position(|p| *p == position).unwrap_or(0));
    let joint_at = |name: &str| tree.joints.iter().position(|(joint, ..)| read[*joint].name == name);
    let mut joints = Vec::with_capacity(tree.joints.len());
    for (position, parent, child) in &tree.joints {
        let (joint, span) = (&read[*position], span(source, nodes[*position]));
        let mimic = match &joint.mimic {
            None => None,
            Some(mimic) => Some(Mimic {
                of: joint_at(mimic.joint.trim()).ok_or_else(|| unknown_leader(source, span, &mimic.joint, read))?,
                multiplier: mimic.multiplier.unwrap_or(1.0),
                offset: mimic.offset.unwrap_or(0.0),
            }),
        };
        joints.push(JointDescription {
            name: joint.name.trim().to_owned(),
            parent: link_at(*parent),
            child: link_at(*child),
            parent_from_joint: pose(&joint.origin),
            motion: motion(joint),
            limit: bounds(joint),
            mimic,
            span,
        });
    }
    resolve_mimic_chains(source, &mut joints)?;
    Ok(joints)
}

fn unknown_leader(source: &Source, span: Span, name: &str, read: &[urdf_rs::Joint]) -> Box<crate::Finding> {
    source
        .finding(span, FindingKind::UnknownName, format!("no joint is called `{name}`, which this one mimics"))
        .help(crate::file::did_you_mean(name, read.iter().map(|joint| joint.name.as_str())))
}

/// Makes every mimic joint follow one that mimics nothing.
fn resolve_mimic_chains(source: &Source, joints: &mut [JointDescription]) -> Found<()> {
    for follower in 0..joints.len() {
        let mut steps = 0;
        while let Some(mimic) = joints[follower].mimic.clone() {
            let Some(next) = joints[mimic.of].mimic.clone() else { break };
            steps += 1;
            if mimic.of == follower || steps > joints.len() {
                let message = format!("joint `{}` mimics itself", joints[follower].name);
                return Err(source
                    .finding(joints[follower].span, FindingKind::BadRobot, message)
                    .help("let it mimic a joint that is moved by a motor"));
            }
            joints[follower].mimic = Some(Mimic {
                of: next.of,
                multiplier: mimic.multiplier * next.multiplier,
                offset: mimic.multiplier * next.offset + mimic.offset,
            });
        }
    }
    Ok(())
}

/// A URDF pose; roll, pitch, yaw about fixed axes.
pub(crate) fn pose(origin: &urdf_rs::Pose) -> Pose {
    let [x, y, z] = origin.xyz.0;
    let [roll, pitch, yaw] = origin.rpy.0;
    Pose::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_euler_angles(roll, pitch, yaw))
}

fn motion(joint: &urdf_rs::Joint) -> JointMotion {
    let axis: [f64; 3] = Vector3::from(joint.axis.xyz.0).normalize().into();
    match joint.joint_type {
        urdf_rs::JointType::Revolute | urdf_rs::JointType::Continuous => JointMotion::Revolute { axis },
        urdf_rs::JointType::Prismatic => JointMotion::Prismatic { axis },
        _ => JointMotion::Fixed,
    }
}

fn bounds(joint: &urdf_rs::Joint) -> Limit {
    let limit = &joint.limit;
    match joint.joint_type {
        urdf_rs::JointType::Continuous => {
            Limit { lower: f64::NEG_INFINITY, upper: f64::INFINITY, velocity: limit.velocity }
        }
        urdf_rs::JointType::Revolute | urdf_rs::JointType::Prismatic => {
            Limit { lower: limit.lower, upper: limit.upper, velocity: limit.velocity }
        }
        _ => Limit { lower: 0.0, upper: 0.0, velocity: 0.0 },
    }
}
