//! Robots from URDF and SRDF files.
//!
//! `urdf_rs` reads the URDF, but it accepts almost anything and knows no lines; everything is therefore checked here first,
//! on the XML itself.

mod collada;
mod hull;
mod joints;
mod mesh;
mod shapes;
mod srdf;
mod tree;
mod xml;

use crate::file::read_text;
use crate::problem_error::{Finding, FindingKind, Found, Source, Span};
use crate::{Files, JointMotion, Link, LinkId, Pose};

pub(crate) use mesh::load_hull;
pub(crate) use srdf::Srdf;

/// Most links of one robot.
const MAX_LINKS: usize = 1_000;

/// A robot as its URDF and SRDF describe it.
pub(crate) struct Description {
    pub urdf: Source,
    pub srdf_source: Source,
    /// Links; the root first.
    pub links: Vec<Link>,
    /// Joints, each after the joint that moves its parent link.
    pub joints: Vec<JointDescription>,
    pub srdf: Srdf,
}

/// A joint before it is known whether it is planned.
pub(crate) struct JointDescription {
    pub name: String,
    pub parent: LinkId,
    pub child: LinkId,
    pub parent_from_joint: Pose,
    pub motion: JointMotion,
    /// Least and greatest value and greatest speed; infinite bounds for continuous joints, zero for fixed ones.
    pub limit: Limit,
    pub mimic: Option<Mimic>,
    pub span: Span,
}

/// Limits of a joint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limit {
    pub lower: f64,
    pub upper: f64,
    pub velocity: f64,
}

/// `multiplier` times another joint's value plus `offset`.
#[derive(Clone, Debug)]
pub(crate) struct Mimic {
    /// Position in [`Description::joints`].
    pub of: usize,
    pub multiplier: f64,
    pub offset: f64,
}

/// A robot as its URDF alone describes it.
pub(crate) struct UrdfDescription {
    pub urdf: Source,
    /// Links; the root first.
    pub links: Vec<Link>,
    /// Joints, each after the joint that moves its parent link.
    pub joints: Vec<JointDescription>,
}

/// Reads a robot's two files.
pub(crate) fn describe(files: &dyn Files, urdf_path: &str, srdf_path: &str) -> Found<Description> {
    let UrdfDescription { urdf, links, joints } = describe_urdf(files, urdf_path)?;
    let srdf_source = read_text(files, srdf_path)?;
    let srdf = srdf::srdf(&srdf_source, &links, &joints)?;
    Ok(Description { links, joints, srdf, srdf_source, urdf })
}

/// Reads a URDF with its meshes.
pub(crate) fn describe_urdf(files: &dyn Files, urdf_path: &str) -> Found<UrdfDescription> {
    let urdf = read_text(files, urdf_path)?;
    let document = xml::parse(&urdf, "URDF")?;
    let links: Vec<_> = xml::children(document.root_element(), "link").collect();
    let joints: Vec<_> = xml::children(document.root_element(), "joint").collect();
    if links.is_empty() || links.len() > MAX_LINKS {
        let message = format!("{} links", links.len());
        return Err(urdf
            .finding(xml::span(&urdf, document.root_element()), FindingKind::BadRobot, message)
            .help(format!("describe the robot by 1 to {MAX_LINKS} links")));
    }
    let tree = tree::tree(&urdf, &links, &joints)?;
    for node in links.iter().chain(&joints) {
        xml::check_numbers(&urdf, *node)?;
    }
    joints::check(&urdf, &joints)?;
    let read = urdf_rs::read_from_string(&urdf.text)
        .map_err(|error| Finding::of_file(urdf_path, FindingKind::BadRobot, error).help("mend the URDF"))?;
    if read.links.len() != links.len() || read.joints.len() != joints.len() {
        return Err(Finding::of_file(urdf_path, FindingKind::BadRobot, "two readers of URDF disagree about its links")
            .help("check the file with `check_urdf`"));
    }
    let joints = joints::joints(&urdf, &tree, &joints, &read.joints)?;
    let links = shapes::links(files, &urdf, &tree, &links, &read.links)?;
    Ok(UrdfDescription { links, joints, urdf: urdf.clone() })
}

impl Description {
    /// The link called `name`.
    pub(crate) fn link(&self, name: &str) -> Option<LinkId> {
        self.links.iter().position(|link| link.name == name).map(LinkId::at)
    }

    /// The joint that moves `link`.
    pub(crate) fn joint_of(&self, link: LinkId) -> Option<usize> {
        self.joints.iter().position(|joint| joint.child == link)
    }

    /// The topmost link that `link` is rigidly fixed to, and its pose there.
    pub(crate) fn rigid_root(&self, link: LinkId) -> (LinkId, Pose) {
        let (mut root, mut root_from_link) = (link, Pose::identity());
        while let Some(joint) = self.joint_of(root).map(|joint| &self.joints[joint]) {
            if joint.motion != JointMotion::Fixed {
                break;
            }
            root_from_link = joint.parent_from_joint * root_from_link;
            root = joint.parent;
        }
        (root, root_from_link)
    }
}
