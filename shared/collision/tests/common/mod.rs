//! Robots and scenes built in place, and an oracle that asks parry for the distance of every pair of bodies.
#![allow(dead_code, unused_imports, reason = "every test file uses its own part")]
#![allow(clippy::unwrap_used, reason = "its input is its own")]

mod oracle;
mod robots;

pub use oracle::{Oracle, Piece, least_distance};
pub use robots::{box_base, lift, mobile_arm, planar_2r, two_bars};

use collision::{AllowedContacts, Geometry, Holding, Motion};
use model::{
    Body, EndPolicy, FixedObject, Grasp, GraspFamily, GraspId, Levels, MovableObject, ObjectId, Pair, Pose, Problem,
    RegionId, Robot, RobotId, SearchSettings, Settings, Shape,
};
use nalgebra::{Point3, Translation3, UnitQuaternion, Vector3};

pub const CLEARANCE: f64 = 0.002;
/// parry's distances are trusted to this (m).
pub const PARRY: f64 = 2e-5;

/// SplitMix64: the tests' own numbers.
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub fn pick(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count - 1)
    }

    pub fn pose(&mut self, reach: f64) -> Pose {
        let xyz = [(); 3].map(|()| self.between(-reach, reach));
        let turn = UnitQuaternion::from_euler_angles(
            self.between(-3.0, 3.0),
            self.between(-1.5, 1.5),
            self.between(-3.0, 3.0),
        );
        Pose::from_parts(Translation3::new(xyz[0], xyz[1], xyz[2]), turn)
    }
}

pub fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::translation(x, y, z)
}

pub fn turned(x: f64, y: f64, z: f64, yaw: f64) -> Pose {
    Pose::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw))
}

pub fn boxed(pose: Pose, size: [f64; 3]) -> Body {
    Body { owner_from_shape: pose, shape: Shape::Box { size } }
}

pub fn body(pose: Pose, shape: Shape) -> Body {
    Body { owner_from_shape: pose, shape }
}

pub fn fixed(name: &str, world_from_object: Pose, bodies: Vec<Body>) -> FixedObject {
    FixedObject { name: name.into(), world_from_object, bodies }
}

pub fn movable(name: &str, shape: Shape, robots: usize, link_from_object: Pose) -> MovableObject {
    let grasp = Grasp { link_from_object, opening: 0.04, approach: [0.0, 0.0, 1.0], family: GraspFamily::Listed };
    MovableObject {
        name: name.into(),
        body: Body { owner_from_shape: Pose::identity(), shape },
        world_from_start: Pose::identity(),
        start_support: None,
        grasps: vec![vec![grasp]; robots],
    }
}

/// Every robot has something to do: one that has not is in the way of the others.
pub fn problem(robots: Vec<Robot>, fixed: Vec<FixedObject>, movable: Vec<MovableObject>) -> Problem {
    let end_policies = vec![EndPolicy::default(); robots.len()];
    let pairs = (0..robots.len()).map(pair_of).collect();
    Problem {
        name: "test".into(),
        robots,
        fixed,
        movable,
        regions: vec![],
        pairs,
        orderings: vec![],
        end_policies,
        settings: Settings { clearance: CLEARANCE, ..Settings::default() },
        levels: Levels::default(),
        search: SearchSettings::default(),
    }
}

/// A robot's only pair.
pub fn pair_of(robot: usize) -> Pair {
    Pair {
        name: format!("r{robot}.1"),
        robot: RobotId::at(robot),
        object: ObjectId(0),
        from: RegionId(0),
        to: RegionId(0),
        hop: 1,
    }
}

pub fn hull(points: &[[f64; 3]]) -> Shape {
    Shape::Hull { points: points.iter().map(|p| Point3::from(*p)).collect() }
}

/// A table with two legs, a cabinet with walls and a shelf, and one obstacle of each round kind.
pub fn furniture() -> Vec<FixedObject> {
    let legs = [boxed(at(-0.35, 0.0, -0.32), [0.06, 0.5, 0.6]), boxed(at(0.35, 0.0, -0.32), [0.06, 0.5, 0.6])];
    let mut table = vec![boxed(Pose::identity(), [0.8, 0.6, 0.04])];
    table.extend(legs);
    let cabinet = vec![
        boxed(at(0.0, 0.3, 0.5), [0.4, 0.02, 1.0]),
        boxed(at(0.0, -0.3, 0.5), [0.4, 0.02, 1.0]),
        boxed(at(0.0, 0.0, 0.5), [0.38, 0.58, 0.02]),
    ];
    let wedge =
        hull(&[[0.0, 0.0, 0.0], [0.4, 0.0, 0.0], [0.0, 0.4, 0.0], [0.4, 0.4, 0.1], [0.1, 0.1, 0.7], [0.3, 0.15, 0.6]]);
    let round = |radius, length| Shape::Cylinder { radius, length };
    vec![
        fixed("table", turned(1.2, 0.2, 0.62, 0.3), table),
        fixed("cabinet", turned(-1.1, 0.4, 0.0, -0.5), cabinet),
        fixed("pillar", at(0.3, 1.2, 0.5), vec![body(Pose::identity(), round(0.15, 1.0))]),
        fixed("lamp", at(0.2, -0.9, 1.1), vec![body(Pose::identity(), Shape::Sphere { radius: 0.2 })]),
        fixed(
            "rail",
            turned(-0.5, -1.0, 0.6, 0.8) * tilt(1.2),
            vec![body(Pose::identity(), Shape::Capsule { radius: 0.05, length: 0.9 })],
        ),
        fixed("wedge", turned(0.9, -1.0, 0.1, 2.0), vec![body(Pose::identity(), wedge)]),
    ]
}

pub fn tilt(angle: f64) -> Pose {
    Pose::from_parts(Translation3::identity(), UnitQuaternion::from_axis_angle(&Vector3::x_axis(), angle))
}

/// Two mobile arms among furniture, with a box, a can and a hull to carry.
pub fn mobile_problem() -> Problem {
    let in_hand = at(0.0, 0.0, 0.12);
    let gem = hull(&[[0.05, 0.0, 0.0], [-0.04, 0.03, 0.0], [-0.04, -0.03, 0.0], [0.0, 0.0, 0.09], [0.0, 0.01, -0.05]]);
    let movable = vec![
        movable("brick", Shape::Box { size: [0.04, 0.04, 0.15] }, 2, in_hand * tilt(1.57)),
        movable("can", Shape::Cylinder { radius: 0.03, length: 0.12 }, 2, in_hand),
        movable("gem", gem, 2, in_hand),
    ];
    problem(vec![mobile_arm("r1"), mobile_arm("r2")], furniture(), movable)
}

pub fn random_configuration(robot: &Robot, random: &mut Random) -> Vec<f64> {
    robot.coordinates.iter().map(|c| random.between(c.lower.max(-1.4), c.upper.min(1.4))).collect()
}

/// The shipped problem.
pub fn figure1() -> Problem {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../launch/scenes/figure1.yaml");
    model::load_problem(&model::DiskFiles, scene).unwrap()
}

/// Nothing, or one of the objects that every robot can hold.
pub fn random_holding(problem: &Problem, random: &mut Random) -> Option<Holding> {
    let pick = random.pick(problem.movable.len() + 1);
    let graspable = |i: usize| problem.movable[i].grasps.iter().all(|grasps| !grasps.is_empty());
    (pick > 0 && graspable(pick - 1)).then(|| Holding { object: ObjectId::at(pick - 1), grasp: GraspId(0) })
}

/// Of all sizes: small, arm only, base only, everything.
pub fn random_motion(geometry: &Geometry, id: RobotId, random: &mut Random) -> Motion {
    let problem = geometry.problem();
    let robot = problem.robot(id);
    let from = random_configuration(robot, random);
    let mut to = random_configuration(robot, random);
    let (scale, kind) = (random.between(0.05, 1.0), random.pick(3));
    for i in 0..to.len() {
        let frozen = (kind == 0 && i < 3) || (kind == 1 && i >= 3);
        to[i] = if frozen { from[i] } else { from[i] + (to[i] - from[i]) * scale };
    }
    let holding = random_holding(problem, random);
    Motion { robot: id, holding, from, to, allowed: AllowedContacts::default() }
}

pub fn along(motion: &Motion, share: f64) -> Vec<f64> {
    motion.from.iter().zip(&motion.to).map(|(a, b)| a + (b - a) * share).collect()
}
