//! Forward kinematics and distances of the tests' own, to check robots and scenes against.

use model::{Body, JointMotion, JointValue, Pose, Robot, Shape};
use nalgebra::{Point3, Translation3, Unit, UnitQuaternion, Vector3};

/// Pose of every link in the root link's frame; the base coordinates of `q` are not applied.
pub fn root_from_links(robot: &Robot, q: &[f64], opening: f64) -> Vec<Pose> {
    let mut poses = vec![Pose::identity(); robot.links.len()];
    for joint in &robot.joints {
        let value = joint_value(robot, &joint.value, q, opening);
        let motion = match &joint.motion {
            JointMotion::Fixed => Pose::identity(),
            JointMotion::Revolute { axis } => {
                let axis = Unit::new_normalize(Vector3::from(*axis));
                Pose::from_parts(Translation3::identity(), UnitQuaternion::from_axis_angle(&axis, value))
            }
            JointMotion::Prismatic { axis } => Pose::from(Vector3::from(*axis) * value),
        };
        poses[joint.child.index()] = poses[joint.parent.index()] * joint.parent_from_joint * motion;
    }
    poses
}

fn joint_value(robot: &Robot, value: &JointValue, q: &[f64], opening: f64) -> f64 {
    match value {
        JointValue::Coordinate(coordinate) => q[coordinate.index()],
        JointValue::Finger { scale } => scale * opening,
        JointValue::Mimic { of, multiplier, offset } => {
            multiplier * joint_value(robot, &robot.joints[of.index()].value, q, opening) + offset
        }
        JointValue::Constant(value) => *value,
    }
}

/// Greatest distance of a body from the z axis.
pub fn reach_from_axis(pose: &Pose, body: &Body) -> f64 {
    let pose = pose * body.owner_from_shape;
    let ring = |radius: f64, z: f64| {
        (0..720).map(move |i| {
            let angle = f64::from(i).to_radians() / 2.0;
            Point3::new(radius * angle.cos(), radius * angle.sin(), z)
        })
    };
    let points: Vec<Point3<f64>> = match &body.shape {
        Shape::Cylinder { radius, length } => ring(*radius, length / 2.0).chain(ring(*radius, -length / 2.0)).collect(),
        shape => shape.support_points(),
    };
    let rounding = body.shape.rounding();
    points.iter().map(|p| pose * p).map(|p| p.x.hypot(p.y) + rounding).fold(0.0, f64::max)
}

/// Distance between two bodies by alternating projections; 0 where they touch. Errs to the large side by about 0.1 mm.
pub fn distance(pose_a: &Pose, a: &Body, pose_b: &Pose, b: &Body) -> f64 {
    let (pose_a, pose_b) = (pose_a * a.owner_from_shape, pose_b * b.owner_from_shape);
    let mut q = Point3::from(pose_b.translation.vector);
    let mut least = f64::MAX;
    for _ in 0..2000 {
        let p = pose_a * nearest(&a.shape, &(pose_a.inverse() * q));
        q = pose_b * nearest(&b.shape, &(pose_b.inverse() * p));
        least = (p - q).norm();
    }
    least
}

/// The point of a shape nearest to `p`.
fn nearest(shape: &Shape, p: &Point3<f64>) -> Point3<f64> {
    let toward = |centre: Point3<f64>, radius: f64| {
        let away = p - centre;
        if away.norm() <= radius { *p } else { centre + away.normalize() * radius }
    };
    match shape {
        Shape::Box { size } => Point3::from([0, 1, 2].map(|i| p[i].clamp(-size[i] / 2.0, size[i] / 2.0))),
        Shape::Sphere { radius } => toward(Point3::origin(), *radius),
        Shape::Capsule { radius, length } => {
            toward(Point3::new(0.0, 0.0, p.z.clamp(-length / 2.0, length / 2.0)), *radius)
        }
        Shape::Cylinder { radius, length } => {
            let across = p.x.hypot(p.y);
            let shrink = if across > *radius { radius / across } else { 1.0 };
            Point3::new(p.x * shrink, p.y * shrink, p.z.clamp(-length / 2.0, length / 2.0))
        }
        Shape::Hull { .. } => *p,
    }
}
