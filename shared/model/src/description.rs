//! Robots by themselves, without a problem.

use crate::file::alone;
use crate::problem_error::ProblemError;
use crate::urdf::describe_urdf;
use crate::{Files, JointMotion, Link, LinkId, Pose, Robot};

/// A robot as its URDF alone describes it. Links and joints form a tree.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotTree {
    /// Links; the first is the root.
    pub links: Vec<Link>,
    /// Joints, each after the joint that moves its parent link.
    pub joints: Vec<TreeJoint>,
}

/// A joint of a [`RobotTree`].
#[derive(Clone, Debug, PartialEq)]
pub struct TreeJoint {
    /// Name.
    pub name: String,
    /// Parent link.
    pub parent: LinkId,
    /// Child link.
    pub child: LinkId,
    /// Takes the joint frame at zero to the parent link's frame.
    pub parent_from_joint: Pose,
    /// How the child moves in the joint frame.
    pub motion: JointMotion,
    /// Least value (rad or m); `-inf` for continuous joints, 0 for fixed ones.
    pub lower: f64,
    /// Greatest value (rad or m); `+inf` for continuous joints, 0 for fixed ones.
    pub upper: f64,
    /// Greatest speed (rad/s or m/s); 0 for fixed joints.
    pub velocity: f64,
    /// Whether it follows another joint.
    pub mimics: bool,
}

impl RobotTree {
    /// The joint that moves a link.
    #[must_use]
    pub fn joint_of(&self, link: LinkId) -> Option<&TreeJoint> {
        self.joints.iter().find(|joint| joint.child == link)
    }

    /// Joints that hang on a link.
    pub fn joints_below(&self, link: LinkId) -> impl Iterator<Item = &TreeJoint> {
        self.joints.iter().filter(move |joint| joint.parent == link)
    }
}

/// Reads a URDF with its meshes.
///
/// # Errors
/// What is wrong with it, with file, line and remedy.
pub fn read_urdf(files: &dyn Files, urdf_path: &str) -> Result<RobotTree, ProblemError> {
    let described = describe_urdf(files, urdf_path)?;
    let joint = |joint: crate::urdf::JointDescription| TreeJoint {
        name: joint.name,
        parent: joint.parent,
        child: joint.child,
        parent_from_joint: joint.parent_from_joint,
        motion: joint.motion,
        lower: joint.limit.lower,
        upper: joint.limit.upper,
        velocity: joint.limit.velocity,
        mimics: joint.mimic.is_some(),
    };
    Ok(RobotTree { links: described.links, joints: described.joints.into_iter().map(joint).collect() })
}

/// Reads a robot's two files as a problem that says nothing more of it would: it stands at the world's origin, the tool
/// frame is that of the end effector's parent link. It is named for its URDF file. A planar base may go 10 m either way,
/// at 1 m/s and 1 rad/s, since its limits are a problem's to say.
///
/// # Errors
/// What is wrong with them, with file, line and remedy.
pub fn load_robot(files: &dyn Files, urdf_path: &str, srdf_path: &str) -> Result<Robot, ProblemError> {
    Ok(alone::robot(files, urdf_path, srdf_path)?)
}
