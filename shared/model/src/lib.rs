//! Nouns of the world: robots, objects, regions, grasps, poses, and the problem file.
//!
//! Units are m, rad, s, kg; z is up. A transform is called `a_from_b`: it takes coordinates in frame
//! `b` to coordinates in frame `a`. Nothing here knows how a plan is found.
//!
//! [`load_problem`] reads a problem file and the robots and meshes that it names, through [`Files`], and resolves it into a
//! [`Problem`] without paths or names to look up, or into a [`ProblemError`] that says where what is wrong.

mod description;
mod file;
mod files;
mod grasp;
mod grasp_families;
mod holding;
mod ids;
mod locate;
mod places;
mod problem;
mod problem_error;
mod robot;
mod scene;
mod search;
mod settings;
mod shape;
mod task;
mod urdf;

pub use description::{RobotTree, TreeJoint, load_robot, read_urdf};
pub use file::{load_problem, load_problem_with_places, problem_schema};
pub use files::{DiskFiles, EmbeddedFiles, Files, PackageFiles};
pub use grasp::{Grasp, GraspFamily};
pub use holding::{AllowedContacts, Holding, Standing};
pub use ids::{CoordinateId, FixedId, GraspId, JointId, LinkId, ObjectId, PairId, RegionId, RobotId};
pub use places::{Misplaced, Part, Places};
pub use problem::Problem;
pub use problem_error::{Finding, FindingKind, ProblemError, Span};
pub use robot::{Coordinate, EndEffector, Joint, JointMotion, JointValue, Link, PlanarBase, Robot};
pub use scene::{FixedObject, MovableObject, Region};
pub use search::{FailurePolicy, Policies, PolicyError, SearchSettings, Seconds, WorkLimits};
pub use settings::{Gate, Levels, Removal, Settings};
pub use shape::{Body, Shape};
pub use task::{EndPolicy, GivenOrdering, Pair, Point};

/// A rigid transform in SE(3), metres and unit quaternion.
pub type Pose = nalgebra::Isometry3<f64>;
/// A configuration of one robot: one value per [`Coordinate`], in m or rad.
pub type Configuration = Vec<f64>;
