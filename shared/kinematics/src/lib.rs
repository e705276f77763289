//! Forward and inverse kinematics of robots whose joints form a tree.
//!
//! Units are m and rad; a transform `a_from_b` takes coordinates in frame `b` to frame `a`. A configuration lists the
//! planned coordinates of a robot, a planar base's x, y and yaw first: then
//! `world_from_root = world_from_base · translation(x, y, 0) · rotation about z by yaw`.
//! The coordinates after the base's are called the arm.

mod descent;
mod drive;
mod elbow;
mod forward;
mod jacobian;
mod line;
mod numeric;
mod range;
mod reach;
mod serial;
mod solver;
mod spherical;
mod srs;

pub use forward::{chain, link_pose, link_poses, link_poses_into};
pub use jacobian::jacobian;
pub use numeric::NumericArm;
pub use reach::Reach;
pub use solver::ArmSolver;
pub use srs::SrsArm;
