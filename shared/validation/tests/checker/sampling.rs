//! What meets what at instants: kinematics of its own, and parry's own dispatch on parry's own shapes.

use model::{Body, JointMotion, JointValue, Pose, Problem, Robot, Shape};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use parry3d_f64::math::{Pose as ParryPose, Vector};
use parry3d_f64::query;
use parry3d_f64::shape::SharedShape;
use plan::{Knot, Plan};

/// Pose of a link, by walking up to the root.
pub fn link_pose(robot: &Robot, q: &[f64], opening: f64, link: usize) -> Pose {
    let Some(joint) = robot.joints.iter().position(|joint| joint.child.index() == link) else {
        let Some(_) = robot.base else { return robot.world_from_base };
        return robot.world_from_base
            * Translation3::new(q[0], q[1], 0.0)
            * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), q[2]);
    };
    let value = joint_value(robot, q, opening, joint);
    let joint = &robot.joints[joint];
    let moved = match joint.motion {
        JointMotion::Fixed => Pose::identity(),
        JointMotion::Revolute { axis } => Isometry3::rotation(Vector3::from(axis) * value),
        JointMotion::Prismatic { axis } => Translation3::from(Vector3::from(axis) * value).into(),
    };
    link_pose(robot, q, opening, joint.parent.index()) * joint.parent_from_joint * moved
}

fn joint_value(robot: &Robot, q: &[f64], opening: f64, joint: usize) -> f64 {
    match robot.joints[joint].value {
        JointValue::Coordinate(id) => q[id.index()],
        JointValue::Finger { scale } => scale * opening,
        JointValue::Mimic { of, multiplier, offset } => {
            multiplier * joint_value(robot, q, opening, of.index()) + offset
        }
        JointValue::Constant(value) => value,
    }
}

/// Parry's shape and its pose in the body's owner.
fn reference(body: &Body) -> (SharedShape, Pose) {
    let upright = Isometry3::rotation(Vector3::x() * std::f64::consts::FRAC_PI_2);
    let vector = |p: &Point3<f64>| Vector::new(p.x, p.y, p.z);
    match &body.shape {
        Shape::Box { size: [x, y, z] } => (SharedShape::cuboid(x / 2.0, y / 2.0, z / 2.0), body.owner_from_shape),
        Shape::Sphere { radius } => (SharedShape::ball(*radius), body.owner_from_shape),
        Shape::Cylinder { radius, length } => {
            (SharedShape::cylinder(length / 2.0, *radius), body.owner_from_shape * upright)
        }
        Shape::Capsule { radius, length } => {
            (SharedShape::capsule_y(length / 2.0, *radius), body.owner_from_shape * upright)
        }
        Shape::Hull { points } => {
            let points: Vec<Vector> = points.iter().map(vector).collect();
            (SharedShape::convex_hull(&points).expect("points span a volume"), body.owner_from_shape)
        }
    }
}

type Solid = (SharedShape, ParryPose);

fn placed(body: &Body, owner: Pose) -> Solid {
    let (shape, pose) = reference(body);
    (shape, ParryPose::from(owner * pose))
}

fn configuration(knots: &[Knot], t: f64) -> Vec<f64> {
    match knots.iter().position(|knot| knot.t > t) {
        None => knots[knots.len() - 1].q.clone(),
        Some(next) => {
            let (a, b) = (&knots[next - 1], &knots[next]);
            let s = (t - a.t) / (b.t - a.t);
            a.q.iter().zip(&b.q).map(|(a, b)| a * (1.0 - s) + b * s).collect()
        }
    }
}

/// Least distance over all pairs that may not meet, at some instants, for two robots of seven links of which the first
/// carries the only object between the only two events, and touches it with its links from the fourth on.
pub fn sampled_clearance(problem: &Problem, plan: &Plan, instants: impl Iterator<Item = f64>) -> f64 {
    let fixed: Vec<Solid> =
        problem.fixed.iter().map(|object| placed(&object.bodies[0], object.world_from_object)).collect();
    let (attach, detach) = (&plan.events[0], &plan.events[1]);
    let mut least = f64::INFINITY;
    for t in instants {
        let holds = attach.t <= t && t < detach.t;
        let pose = |robot: usize, link: usize| {
            let opening =
                if holds && robot == 0 { attach.opening } else { problem.robots[robot].end_effector.max_opening };
            link_pose(&problem.robots[robot], &configuration(&plan.robots[robot].knots, t), opening, link)
        };
        let object = match t {
            t if t < attach.t => Pose::from(attach.world_from_object),
            _ if holds => pose(0, 4) * Pose::from(attach.link_from_object),
            _ => Pose::from(detach.world_from_object),
        };
        let object = placed(&problem.movable[0].body, object);
        let robots = [0, 1].map(|robot| {
            let links = problem.robots[robot].links.iter().enumerate();
            links.map(|(i, link)| placed(&link.bodies[0], pose(robot, i))).collect::<Vec<Solid>>()
        });
        let mut meet = |a: &Solid, b: &Solid| {
            let distance = query::distance(&a.1, &*a.0, &b.1, &*b.0).expect("supported").distance;
            least = least.min(distance);
        };
        robots[0].iter().for_each(|a| robots[1].iter().chain(&fixed).for_each(|b| meet(a, b)));
        robots[1].iter().for_each(|a| fixed.iter().for_each(|b| meet(a, b)));
        robots.iter().for_each(|robot| meet(&robot[1], &robot[4]));
        robots[0][..4].iter().chain(&robots[1]).chain(&fixed).for_each(|b| meet(&object, b));
    }
    least
}
