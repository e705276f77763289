//! Robots for which plans can be written by hand: every joint slides, so that the hand's pose can be read off.

use model::{
    Body, Coordinate, CoordinateId, EndEffector, Grasp, GraspFamily, Joint, JointMotion, JointValue, Link, LinkId,
    PlanarBase, Pose, Robot, Shape,
};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

/// Distance from the hand's frame down to the centre of a held object (m).
pub const HAND_TO_OBJECT: f64 = 0.095;

/// A translation.
pub fn at(x: f64, y: f64, z: f64) -> Pose {
    Isometry3::translation(x, y, z)
}

/// A box of full edge lengths `size`, centred at `centre`.
pub fn block(size: [f64; 3], centre: [f64; 3]) -> Body {
    Body { owner_from_shape: at(centre[0], centre[1], centre[2]), shape: Shape::Box { size } }
}

/// A coordinate with symmetric limits.
pub fn coordinate(name: &str, limit: f64, velocity: f64) -> Coordinate {
    Coordinate { name: name.to_owned(), lower: -limit, upper: limit, velocity }
}

/// The grasp from above that the fixtures use.
pub fn top_grasp() -> Grasp {
    Grasp {
        link_from_object: at(0.0, 0.0, -HAND_TO_OBJECT),
        opening: 0.04,
        approach: [0.0, 0.0, -1.0],
        family: GraspFamily::Listed,
    }
}

/// Links and joints as they are added one after the other.
struct Builder {
    links: Vec<Link>,
    joints: Vec<Joint>,
}

impl Builder {
    fn new(root: Vec<Body>) -> Self {
        Self { links: vec![Link { name: "base".to_owned(), bodies: root }], joints: Vec::new() }
    }

    fn add(
        &mut self,
        name: &str,
        parent: usize,
        offset: Pose,
        motion: JointMotion,
        value: JointValue,
        bodies: Vec<Body>,
    ) -> usize {
        let child = self.links.len();
        self.links.push(Link { name: name.to_owned(), bodies });
        self.joints.push(Joint {
            name: format!("{name}_joint"),
            parent: LinkId::at(parent),
            child: LinkId::at(child),
            parent_from_joint: offset,
            motion,
            value,
        });
        child
    }

    fn slide(&mut self, name: &str, parent: usize, axis: [f64; 3], coordinate: usize, bodies: Vec<Body>) -> usize {
        let value = JointValue::Coordinate(CoordinateId::at(coordinate));
        self.add(name, parent, Pose::identity(), JointMotion::Prismatic { axis }, value, bodies)
    }

    /// A palm with two opposed fingers that point down and close along y.
    fn hand(&mut self, parent: usize) -> EndEffector {
        let palm = vec![block([0.08, 0.12, 0.03], [0.0; 3])];
        let fixed = JointValue::Constant(0.0);
        let hand = self.add("hand", parent, Pose::identity(), JointMotion::Fixed, fixed, palm);
        let finger = || vec![block([0.02, 0.01, 0.08], [0.0, 0.0, -0.055])];
        let slides = |y: f64| JointMotion::Prismatic { axis: [0.0, y, 0.0] };
        let left = JointValue::Finger { scale: 0.5 };
        let left = self.add("left_finger", hand, at(0.0, 0.005, 0.0), slides(1.0), left, finger());
        let of = model::JointId::at(self.joints.len() - 1);
        let right = JointValue::Mimic { of, multiplier: 1.0, offset: 0.0 };
        let right = self.add("right_finger", hand, at(0.0, -0.005, 0.0), slides(-1.0), right, finger());
        EndEffector {
            name: "hand".to_owned(),
            parent_link: LinkId::at(hand),
            link_from_tool: Isometry3::from_parts(
                nalgebra::Translation3::new(0.0, 0.0, -HAND_TO_OBJECT),
                UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI),
            ),
            links: [hand, left, right].map(LinkId::at).to_vec(),
            max_opening: 0.08,
        }
    }

    fn adjacent(&self) -> Vec<(LinkId, LinkId)> {
        let mut pairs: Vec<_> = self.joints.iter().map(|j| (j.parent.min(j.child), j.parent.max(j.child))).collect();
        pairs.sort_unstable();
        pairs
    }
}

/// Slides along x, y, z with its hand at (x, y, z) of the world; a column stands on its hand. Starts and drives home at `start`.
pub fn gantry(name: &str, start: [f64; 3]) -> Robot {
    let mut builder = Builder::new(Vec::new());
    let bridge = builder.slide("bridge", 0, [1.0, 0.0, 0.0], 0, Vec::new());
    let trolley = builder.slide("trolley", bridge, [0.0, 1.0, 0.0], 1, Vec::new());
    let column = vec![block([0.05, 0.05, 0.6], [0.0, 0.0, 0.33])];
    let column = builder.slide("column", trolley, [0.0, 0.0, 1.0], 2, column);
    let end_effector = builder.hand(column);
    Robot {
        name: name.to_owned(),
        world_from_base: Pose::identity(),
        disabled_pairs: builder.adjacent(),
        links: builder.links,
        joints: builder.joints,
        coordinates: vec![coordinate("x", 2.0, 1.0), coordinate("y", 2.0, 1.0), coordinate("z", 1.5, 0.5)],
        base: None,
        end_effector,
        start: start.to_vec(),
        home: start.to_vec(),
        carry: start.to_vec(),
    }
}

/// Height of a rover's hand when it drives (m).
pub const ROVER_HAND: f64 = 0.8;
/// Distance from the rover's middle to its hand when the arm is in (m); out, it is 0.3 farther.
pub const ROVER_REACH: f64 = 0.25;

/// Drives in the plane: coordinates x, y, yaw, height of the hand, reach. The hand hangs in front of a square body.
pub fn rover(name: &str, start: [f64; 3]) -> Robot {
    let mut builder = Builder::new(vec![block([0.3, 0.3, 1.0], [0.0, 0.0, 0.55])]);
    let mast = builder.slide("mast", 0, [0.0, 0.0, 1.0], 3, Vec::new());
    let arm = vec![block([0.4, 0.05, 0.05], [0.05, 0.0, 0.05])];
    let arm = builder.slide("arm", mast, [1.0, 0.0, 0.0], 4, arm);
    let wrist = JointValue::Constant(0.0);
    let wrist = builder.add("wrist", arm, at(ROVER_REACH, 0.0, 0.0), JointMotion::Fixed, wrist, Vec::new());
    let end_effector = builder.hand(wrist);
    let mut disabled_pairs = builder.adjacent();
    // The arm slides through the body.
    disabled_pairs.push((LinkId::at(0), LinkId::at(arm)));
    disabled_pairs.sort_unstable();
    let unbounded = |name: &str, velocity: f64| coordinate(name, f64::INFINITY, velocity);
    Robot {
        name: name.to_owned(),
        world_from_base: Pose::identity(),
        disabled_pairs,
        links: builder.links,
        joints: builder.joints,
        coordinates: vec![
            coordinate("base/x", 5.0, 0.8),
            coordinate("base/y", 5.0, 0.8),
            unbounded("base/yaw", 1.5),
            Coordinate { name: "height".to_owned(), lower: 0.3, upper: 1.0, velocity: 0.5 },
            Coordinate { name: "reach".to_owned(), lower: 0.0, upper: 0.35, velocity: 0.5 },
        ],
        base: Some(PlanarBase { speed: 0.8, yaw_rate: 1.5 }),
        end_effector,
        start: [&start[..], &[ROVER_HAND, 0.0]].concat(),
        home: vec![ROVER_HAND, 0.0],
        carry: vec![ROVER_HAND, 0.0],
    }
}
