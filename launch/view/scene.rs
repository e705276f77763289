//! The scene as the page's scripts read it: kinematic trees, shapes, what stands where at the start.

use model::{Body, JointMotion, JointValue, Pose, Problem, Robot, Shape};
use serde::Serialize;

use crate::palette;

/// A pose: x, y, z (m), quaternion x, y, z, w.
type PoseNumbers = [f64; 7];

/// Robots and objects of a problem.
#[derive(Serialize)]
pub struct SceneData {
    robots: Vec<RobotData>,
    fixed: Vec<StandingData>,
    objects: Vec<StandingData>,
    regions: Vec<RegionData>,
    colours: Colours,
}

#[derive(Serialize)]
struct Colours {
    fixed: String,
    object: String,
    region: String,
}

#[derive(Serialize)]
struct RobotData {
    name: String,
    colour: String,
    /// World from the frame in which the base moves.
    base: PoseNumbers,
    /// Whether the first three coordinates are x, y and yaw of a planar base.
    planar: bool,
    coordinates: Vec<String>,
    start: Vec<f64>,
    links: Vec<LinkData>,
    /// Each after the joint that moves its parent.
    joints: Vec<JointData>,
    /// Parent link and pose of the tool frame in it.
    tool: (usize, PoseNumbers),
    max_opening: f64,
}

#[derive(Serialize)]
struct LinkData {
    name: String,
    bodies: Vec<BodyData>,
}

/// Joint value = `offset` + `factor` · (coordinate `coordinate`, or the opening if `opening`, or 0).
#[derive(Serialize)]
struct JointData {
    parent: usize,
    child: usize,
    pose: PoseNumbers,
    #[serde(skip_serializing_if = "Option::is_none")]
    turn: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    slide: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    coordinate: Option<usize>,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    opening: bool,
    factor: f64,
    offset: f64,
}

#[derive(Serialize)]
struct StandingData {
    name: String,
    pose: PoseNumbers,
    bodies: Vec<BodyData>,
}

#[derive(Serialize)]
struct RegionData {
    name: String,
    pose: PoseNumbers,
    size: [f64; 2],
}

#[derive(Serialize)]
struct BodyData {
    pose: PoseNumbers,
    #[serde(flatten)]
    shape: ShapeData,
}

/// Numbers as in [`Shape`] (m).
#[derive(Serialize)]
#[serde(rename_all = "snake_case")]
enum ShapeData {
    Box([f64; 3]),
    Sphere(f64),
    /// Radius, length.
    Cylinder([f64; 2]),
    /// Radius, length of the cylindrical part.
    Capsule([f64; 2]),
    /// Corners, and faces of three corners each; none for a hull without volume.
    Hull {
        corners: Vec<[f64; 3]>,
        faces: Vec<[u32; 3]>,
    },
}

impl SceneData {
    /// The scene of a problem.
    #[must_use]
    pub fn of(problem: &Problem) -> Self {
        let fixed = problem.fixed.iter().map(|object| StandingData {
            name: object.name.clone(),
            pose: pose(&object.world_from_object),
            bodies: bodies(&object.bodies),
        });
        let objects = problem.movable.iter().map(|object| StandingData {
            name: object.name.clone(),
            pose: pose(&object.world_from_start),
            bodies: bodies(std::slice::from_ref(&object.body)),
        });
        let regions = problem.regions.iter().map(|region| RegionData {
            name: region.name.clone(),
            pose: pose(&region.world_from_region),
            size: region.size,
        });
        Self {
            robots: problem.robots.iter().enumerate().map(|(index, robot)| robot_data(robot, index)).collect(),
            fixed: fixed.collect(),
            objects: objects.collect(),
            regions: regions.collect(),
            colours: Colours {
                fixed: palette::hex(palette::FIXED),
                object: palette::hex(palette::OBJECT),
                region: palette::hex(palette::REGION),
            },
        }
    }
}

fn robot_data(robot: &Robot, index: usize) -> RobotData {
    let links = robot.links.iter().map(|link| LinkData { name: link.name.clone(), bodies: bodies(&link.bodies) });
    RobotData {
        name: robot.name.clone(),
        colour: palette::hex(palette::robot(index)),
        base: pose(&robot.world_from_base),
        planar: robot.base.is_some(),
        coordinates: robot.coordinates.iter().map(|coordinate| coordinate.name.clone()).collect(),
        start: robot.start.iter().copied().map(rounded).collect(),
        links: links.collect(),
        joints: (0..robot.joints.len()).map(|joint| joint_data(robot, joint)).collect(),
        tool: (robot.end_effector.parent_link.index(), pose(&robot.end_effector.link_from_tool)),
        max_opening: robot.end_effector.max_opening,
    }
}

fn joint_data(robot: &Robot, index: usize) -> JointData {
    let joint = &robot.joints[index];
    let (mut coordinate, mut opening, mut factor, mut offset) = (None, false, 1.0, 0.0);
    let mut value = &joint.value;
    // A chain of mimics is no longer than the list of joints.
    for _ in 0..=robot.joints.len() {
        match value {
            JointValue::Mimic { of, multiplier, offset: added } => {
                offset += factor * added;
                factor *= multiplier;
                value = &robot.joints[of.index()].value;
            }
            JointValue::Coordinate(id) => coordinate = Some(id.index()),
            JointValue::Finger { .. } => opening = true,
            JointValue::Constant(_) => {}
        }
    }
    match value {
        JointValue::Finger { scale } => factor *= scale,
        JointValue::Constant(constant) => offset += factor * constant,
        JointValue::Coordinate(_) | JointValue::Mimic { .. } => {}
    }
    let (turn, slide) = match joint.motion {
        JointMotion::Fixed => (None, None),
        JointMotion::Revolute { axis } => (Some(axis), None),
        JointMotion::Prismatic { axis } => (None, Some(axis)),
    };
    JointData {
        parent: joint.parent.index(),
        child: joint.child.index(),
        pose: pose(&joint.parent_from_joint),
        turn,
        slide,
        coordinate,
        opening,
        factor,
        offset,
    }
}

fn bodies(bodies: &[Body]) -> Vec<BodyData> {
    bodies.iter().map(|body| BodyData { pose: pose(&body.owner_from_shape), shape: shape(&body.shape) }).collect()
}

fn shape(shape: &Shape) -> ShapeData {
    match shape {
        Shape::Box { size } => ShapeData::Box(*size),
        Shape::Sphere { radius } => ShapeData::Sphere(*radius),
        Shape::Cylinder { radius, length } => ShapeData::Cylinder([*radius, *length]),
        Shape::Capsule { radius, length } => ShapeData::Capsule([*radius, *length]),
        Shape::Hull { points } => {
            let collision::HullSurface { corners, faces } = collision::hull_surface(points).unwrap_or_default();
            ShapeData::Hull { corners: corners.iter().map(|p| [p.x, p.y, p.z].map(rounded)).collect(), faces }
        }
    }
}

/// A pose to a micrometre; the quaternion to 1e-9, so that long links are placed as well.
pub fn pose(pose: &Pose) -> PoseNumbers {
    let (t, q) = (pose.translation.vector, pose.rotation.coords);
    let [x, y, z] = [t.x, t.y, t.z].map(rounded);
    let [qx, qy, qz, qw] = [q.x, q.y, q.z, q.w].map(|part| to_places(part, 1e9));
    [x, y, z, qx, qy, qz, qw]
}

/// To six places (1 µm, 1 µrad, 1 µs): a page is for eyes.
pub fn rounded(value: f64) -> f64 {
    to_places(value, 1e6)
}

fn to_places(value: f64, scale: f64) -> f64 {
    // Adding zero turns -0 into 0.
    (value * scale).round() / scale + 0.0
}
