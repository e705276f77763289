//! The problem file as it is written. Doc comments here are the descriptions in its JSON Schema.

use schemars::JsonSchema;
use serde::Deserialize;

use super::at::At;
use super::words::{GraspsFile, PointFile, StartFile, TaskFile};
use crate::{EndPolicy, Levels, SearchSettings, Settings};

/// A problem for mrtamp: robots, scene, task plan. Units are m, rad, s; z is up; quaternions are x y z w.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "mrtamp problem")]
pub(crate) struct ProblemFile {
    /// Name for messages; the file's name where absent.
    pub name: Option<At<String>>,
    /// The robots.
    pub robots: At<Vec<At<RobotFile>>>,
    /// What never moves: walls, tables, shelves.
    #[serde(default)]
    pub fixed: Vec<At<FixedFile>>,
    /// What robots pick and place.
    #[serde(default)]
    pub movable: Vec<At<MovableFile>>,
    /// Rectangles on top of fixed objects where movable objects may stand.
    #[serde(default)]
    pub regions: Vec<At<RegionFile>>,
    /// The task plan: for each robot its pick-and-place pairs in order.
    pub task: At<TaskFile>,
    /// Orderings beyond those that each robot's order and each object's way imply.
    #[serde(default)]
    pub orderings: Vec<At<OrderingFile>>,
    /// Distances and times that differ from their defaults.
    pub settings: Option<At<Settings>>,
    /// Sample counts that differ from their defaults.
    pub levels: Option<At<Levels>>,
    /// What the search does when a stage fails, and how much it may work.
    #[serde(default)]
    pub search: SearchSettings,
}

/// A robot: its description files and what they do not say.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Robot")]
pub(crate) struct RobotFile {
    /// Unique name.
    pub name: At<String>,
    /// URDF file, relative to this file, or `package://name/path`.
    pub urdf: At<String>,
    /// SRDF file, relative to this file, or `package://name/path`.
    pub srdf: At<String>,
    /// Where the root link stands; for a planar base, the frame in which x, y and yaw are measured. Default: the world's origin.
    pub pose: Option<At<PoseFile>>,
    /// Limits and speeds of a planar base. Required if, and only if, the SRDF declares one.
    pub base: Option<At<BaseFile>>,
    /// Start configuration. Default `home`: base at x = y = yaw = 0, arm in the group state `home`.
    pub start: Option<At<StartFile>>,
    /// Link whose frame is the tool frame: origin between the fingers, z along the approach, y along the closing direction.
    /// It must be fixed to the end effector's parent link. Default: that parent link.
    pub tool: Option<At<String>>,
    /// Greatest opening between the fingers (m). Default: what the finger joints' limits allow. For a hand without sliding
    /// fingers, such as a suction cup, the greatest width of an object that it takes: then it must be given.
    pub max_opening: Option<At<f64>>,
    /// What the robot does after its last pair.
    #[serde(default)]
    pub end: EndPolicy,
}

/// Limits and speeds of a planar base.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Base")]
pub(crate) struct BaseFile {
    /// Least and greatest x (m).
    pub x: At<[f64; 2]>,
    /// Least and greatest y (m).
    pub y: At<[f64; 2]>,
    /// Greatest speed of translation (m/s).
    pub speed: At<f64>,
    /// Greatest yaw rate (rad/s).
    pub yaw_rate: At<f64>,
}

/// A pose: position, and orientation as roll-pitch-yaw or as a quaternion.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Pose")]
pub(crate) struct PoseFile {
    /// Position (m). Default: the origin.
    pub xyz: Option<At<[f64; 3]>>,
    /// Roll, pitch, yaw about the fixed axes x, y, z (rad).
    pub rpy: Option<At<[f64; 3]>>,
    /// Quaternion x, y, z, w.
    pub quat_xyzw: Option<At<[f64; 4]>>,
}

/// A shape about its own origin.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(rename = "Shape")]
pub(crate) enum ShapeFile {
    /// Full edge lengths along x, y, z (m).
    Box(At<[f64; 3]>),
    /// A sphere.
    Sphere(SphereFile),
    /// A cylinder along z, centred.
    Cylinder(CylinderFile),
    /// A capsule along z, centred.
    Capsule(CapsuleFile),
    /// The convex hull of a mesh.
    Mesh(MeshFile),
}

/// A sphere.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Sphere")]
pub(crate) struct SphereFile {
    /// Radius (m).
    pub radius: At<f64>,
}

/// A cylinder along z, centred.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Cylinder")]
pub(crate) struct CylinderFile {
    /// Radius (m).
    pub radius: At<f64>,
    /// Full height along z (m).
    pub height: At<f64>,
}

/// A capsule along z, centred.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Capsule")]
pub(crate) struct CapsuleFile {
    /// Radius (m).
    pub radius: At<f64>,
    /// Length of the cylindrical part, without the caps (m).
    pub length: At<f64>,
}

/// A mesh, which means its convex hull.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Mesh")]
pub(crate) struct MeshFile {
    /// STL, OBJ or DAE file, relative to this file, or `package://name/path`.
    pub file: At<String>,
    /// Factors along x, y, z. Default: 1.
    pub scale: Option<At<[f64; 3]>>,
}

/// One shape of several.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Part")]
pub(crate) struct PartFile {
    /// The shape.
    pub shape: At<ShapeFile>,
    /// Its pose in the object's frame. Default: the object's origin.
    pub pose: Option<At<PoseFile>>,
}

/// A fixed object: one shape, or several parts.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Fixed")]
pub(crate) struct FixedFile {
    /// Unique name.
    pub name: At<String>,
    /// Its shape, if it has one.
    pub shape: Option<At<ShapeFile>>,
    /// Its parts, if it has several.
    pub shapes: Option<At<Vec<At<PartFile>>>>,
    /// Pose in the world. Default: the world's origin.
    pub pose: Option<At<PoseFile>>,
}

/// A movable object. It stands upright: its z axis points up.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Movable")]
pub(crate) struct MovableFile {
    /// Unique name.
    pub name: At<String>,
    /// Its shape.
    pub shape: At<ShapeFile>,
    /// Pose in the world at the start.
    pub pose: At<PoseFile>,
    /// Ways to hold it: `side`, `top`, or a list of these and of single grasps. Default: both families.
    pub grasps: Option<At<GraspsFile>>,
}

/// One grasp.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Grasp")]
pub(crate) struct GraspFile {
    /// Pose of the object in the frame of the end effector's parent link.
    pub link_from_object: At<PoseFile>,
    /// Opening between the fingers while holding (m).
    pub opening: At<f64>,
    /// Direction of approach in the parent link's frame. Default: the tool frame's z axis.
    pub approach: Option<At<[f64; 3]>>,
    /// Robots that it is for. Default: all.
    pub robots: Option<Vec<At<String>>>,
}

/// A rectangle on a fixed object where movable objects may stand.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Region")]
pub(crate) struct RegionFile {
    /// Unique name.
    pub name: At<String>,
    /// The fixed object that it lies on.
    pub on: At<String>,
    /// Full edge lengths (m).
    pub size: At<[f64; 2]>,
    /// Centre in the fixed object's frame, x and y (m). Default: its origin.
    pub centre: Option<At<[f64; 2]>>,
    /// Angle about z in the fixed object's frame (rad).
    pub yaw: Option<At<f64>>,
    /// Height of the surface in the fixed object's frame (m). Default: its highest top surface.
    pub height: Option<At<f64>>,
}

/// One pick-and-place.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Pair")]
pub(crate) struct PairFile {
    /// The object.
    pub object: At<String>,
    /// Region where it is picked.
    pub from: At<String>,
    /// Region where it is placed.
    pub to: At<String>,
    /// Name for orderings and messages. Default: `<robot>.<number from 1>`.
    pub name: Option<At<String>>,
}

/// One point in time strictly before another.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Ordering")]
pub(crate) struct OrderingFile {
    /// What comes first.
    pub before: At<PointFile>,
    /// What comes later.
    pub after: At<PointFile>,
}
