//! Discs about a base's yaw axis that the base contains.

use model::{Pose, Robot, Shape};
use nalgebra::{Point3, Vector3};
use plan::Disc;

use crate::hull::hull_surface;

/// Smallest disc worth knowing: radius and thickness (m).
const SMALLEST: f64 = 0.02;
/// What is left out at the rim (relative) and at top and bottom (m), for whoever measures otherwise.
const RIM: f64 = 2e-3;
const FACE: f64 = 1e-3;
/// Slices into which a mesh is cut.
const SLICES: u32 = 6;
/// Cosine of a tilt that counts as none.
const UPRIGHT: f64 = 1.0 - 1e-10;

/// One disc or more for each body of the links that no joint moves against the root.
pub(super) fn discs(robot: &Robot) -> Vec<Disc> {
    let still = vec![0.0; robot.coordinates.len()];
    let poses = kinematics::link_poses(robot, &still, 0.0);
    let rigid = |link: usize| {
        let mut at = model::LinkId::at(link);
        while let Some(joint) = robot.joint_of_link(at).map(|joint| &robot.joints[joint.index()]) {
            if joint.motion != model::JointMotion::Fixed {
                return false;
            }
            at = joint.parent;
        }
        true
    };
    let links = (0..robot.links.len()).filter(|link| rigid(*link));
    let discs = links.flat_map(|link| {
        let root_from_link = poses[0].inverse() * poses[link];
        robot.links[link]
            .bodies
            .iter()
            .flat_map(move |body| of_shape(&body.shape, &(root_from_link * body.owner_from_shape)))
    });
    discs.filter_map(trimmed).collect()
}

fn trimmed(disc: Disc) -> Option<Disc> {
    let Disc { bottom_m, top_m, radius_m } = disc;
    let trimmed = Disc { bottom_m: bottom_m + FACE, top_m: top_m - FACE, radius_m: radius_m * (1.0 - RIM) };
    (radius_m > SMALLEST && top_m - bottom_m > SMALLEST).then_some(trimmed)
}

fn of_shape(shape: &Shape, root_from_shape: &Pose) -> Vec<Disc> {
    let centre = root_from_shape.translation.vector;
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| root_from_shape.rotation * axis);
    let slice = |half: f64, radius_m: f64| Disc { bottom_m: centre.z - half, top_m: centre.z + half, radius_m };
    let about_z = axes[2].z.abs() >= UPRIGHT;
    match shape {
        Shape::Box { size } => {
            let Some(up) = (0..3).find(|i| axes[*i].z.abs() >= UPRIGHT) else { return Vec::new() };
            let room = |i: usize| size[i] / 2.0 - axes[i].dot(&centre.xy().push(0.0)).abs();
            let radius = (0..3).filter(|i| *i != up).map(room).fold(f64::INFINITY, f64::min);
            vec![slice(size[up] / 2.0, radius)]
        }
        Shape::Cylinder { radius, length } | Shape::Capsule { radius, length } if about_z => {
            vec![slice(length / 2.0, radius - centre.xy().norm())]
        }
        Shape::Hull { points } => {
            let points: Vec<Point3<f64>> = points.iter().map(|p| root_from_shape * p).collect();
            of_hull(&points)
        }
        Shape::Cylinder { .. } | Shape::Capsule { .. } | Shape::Sphere { .. } => Vec::new(),
    }
}

fn of_hull(points: &[Point3<f64>]) -> Vec<Disc> {
    let Some(surface) = hull_surface(points) else { return Vec::new() };
    let planes: Vec<(Vector3<f64>, f64)> = surface
        .faces
        .iter()
        .filter_map(|face| {
            let [a, b, c] = face.map(|corner| surface.corners[corner as usize]);
            let normal = (b - a).cross(&(c - a)).try_normalize(1e-12)?;
            Some((normal, normal.dot(&a.coords)))
        })
        .collect();
    let radius = |z: f64| {
        let room = planes.iter().map(|(normal, offset)| {
            let (left, slope) = (offset - normal.z * z, normal.xy().norm());
            if slope > 1e-9 { left / slope } else { f64::INFINITY }
        });
        room.fold(f64::INFINITY, f64::min)
    };
    let heights = || points.iter().map(|p| p.z);
    let (low, high) = (heights().fold(f64::MAX, f64::min), heights().fold(f64::MIN, f64::max));
    let cut = |i: u32| low + (high - low) * f64::from(i) / f64::from(SLICES);
    let slices = (0..SLICES).map(|i| (cut(i), cut(i + 1)));
    slices.map(|(bottom_m, top_m)| Disc { bottom_m, top_m, radius_m: radius(bottom_m).min(radius(top_m)) }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn discs_of_a_box_a_cylinder_and_a_mesh_of_the_box_are_about_the_yaw_axis() {
        let at = Pose::translation(0.1, 0.0, 0.5);
        let of = |shape: Shape| of_shape(&shape, &at);
        let [block] = of(Shape::Box { size: [0.6, 0.5, 0.4] })[..] else { panic!("one disc") };
        assert!((block.radius_m - 0.2).abs() < 1e-12 && (block.bottom_m - 0.3).abs() < 1e-12);
        let [round] = of(Shape::Cylinder { radius: 0.3, length: 0.4 })[..] else { panic!("one disc") };
        assert!((round.radius_m - 0.2).abs() < 1e-12 && (round.top_m - 0.7).abs() < 1e-12);
        let points = Shape::Box { size: [0.6, 0.5, 0.4] }.support_points();
        let mesh = of(Shape::Hull { points });
        assert_eq!(mesh.len(), SLICES as usize);
        assert!(mesh.iter().all(|disc| (disc.radius_m - 0.2).abs() < 1e-9), "{mesh:?}");
        assert!(of(Shape::Sphere { radius: 1.0 }).is_empty());
    }
}
