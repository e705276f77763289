//! Nouns of the world: robots, objects, regions, grasps, poses, and the problem file.
//!
//! Units are m, rad, s, kg; z is up. A transform is called `a_from_b`: it takes coordinates in frame
//! `b` to coordinates in frame `a`. Nothing here knows how a plan is found.

mod grasp;
mod holding;
mod ids;
mod problem;
mod robot;
mod scene;
mod settings;
mod shape;
mod task;

pub use grasp::{Grasp, GraspFamily};
pub use holding::{AllowedContacts, Holding, Standing};
pub use ids::{CoordinateId, FixedId, GraspId, JointId, LinkId, ObjectId, PairId, RegionId, RobotId};
pub use problem::Problem;
pub use robot::{Coordinate, EndEffector, Joint, JointMotion, JointValue, Link, PlanarBase, Robot};
pub use scene::{FixedObject, MovableObject, Region};
pub use settings::{Levels, Settings};
pub use shape::{Body, Shape};
pub use task::{EndPolicy, GivenOrdering, Pair, Point};

/// A rigid transform in SE(3), metres and unit quaternion.
pub type Pose = nalgebra::Isometry3<f64>;
/// A configuration of one robot: one value per [`Coordinate`], in m or rad.
pub type Configuration = Vec<f64>;
