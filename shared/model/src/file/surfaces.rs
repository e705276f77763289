//! Level top surfaces of fixed objects, on which regions lie and objects stand.

use nalgebra::{Point3, Vector3};

use crate::{Body, FixedObject, Pose, Region, Shape};

/// Slack for points on a border (m).
const BORDER: f64 = 1.0e-6;
/// Cosine above which a face counts as level.
const LEVEL: f64 = 1.0 - 1.0e-9;
/// Points along each side at which a region is probed.
const PROBES: u32 = 21;

/// A level top surface, in world coordinates.
#[derive(Clone, Debug)]
pub(crate) struct Surface {
    pub height: f64,
    outline: Outline,
}

#[derive(Clone, Debug)]
enum Outline {
    /// Corners of a convex polygon, counter-clockwise.
    Polygon(Vec<[f64; 2]>),
    Disc {
        centre: [f64; 2],
        radius: f64,
    },
}

impl Surface {
    /// Whether a point lies above or below the surface, its border included.
    pub(crate) fn contains(&self, [x, y]: [f64; 2]) -> bool {
        match &self.outline {
            Outline::Disc { centre, radius } => (x - centre[0]).hypot(y - centre[1]) <= radius + BORDER,
            Outline::Polygon(corners) => (0..corners.len()).all(|i| {
                let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
                let along = [b[0] - a[0], b[1] - a[1]];
                let side = along[0] * (y - a[1]) - along[1] * (x - a[0]);
                side >= -BORDER * along[0].hypot(along[1])
            }),
        }
    }
}

/// The level top surfaces of a fixed object, body by body.
pub(crate) fn surfaces(object: &FixedObject) -> Vec<Surface> {
    object.bodies.iter().filter_map(|body| surface(&object.world_from_object, body)).collect()
}

fn surface(world_from_object: &Pose, body: &Body) -> Option<Surface> {
    let world_from_shape = world_from_object * body.owner_from_shape;
    match &body.shape {
        Shape::Box { .. } | Shape::Hull { .. } => {
            let corners: Vec<Point3<f64>> =
                body.shape.support_points().iter().map(|point| world_from_shape * point).collect();
            top_polygon(&corners)
        }
        Shape::Cylinder { radius, length } => {
            let axis = world_from_shape.rotation * Vector3::z();
            if axis.z.abs() < LEVEL {
                return None;
            }
            let centre = world_from_shape.translation.vector;
            let outline = Outline::Disc { centre: [centre.x, centre.y], radius: *radius };
            Some(Surface { height: centre.z + length / 2.0, outline })
        }
        Shape::Sphere { .. } | Shape::Capsule { .. } => None,
    }
}

/// The convex polygon of the highest points.
fn top_polygon(points: &[Point3<f64>]) -> Option<Surface> {
    let height = points.iter().map(|p| p.z).reduce(f64::max)?;
    let mut top: Vec<[f64; 2]> = points.iter().filter(|p| p.z >= height - BORDER).map(|p| [p.x, p.y]).collect();
    top.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let mut corners = half_hull(top.iter().copied());
    corners.extend(half_hull(top.iter().rev().copied()));
    (corners.len() >= 3).then_some(Surface { height, outline: Outline::Polygon(corners) })
}

/// One side of a planar hull (monotone chain), without its last point.
fn half_hull(points: impl Iterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
    let mut chain: Vec<[f64; 2]> = Vec::new();
    for p in points {
        while let [.., a, b] = chain[..] {
            if (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0.0 {
                break;
            }
            chain.pop();
        }
        chain.push(p);
    }
    chain.pop();
    chain
}

/// Whether surfaces at a region's height cover all of it (probed on a grid that includes the border).
pub(crate) fn covers(surfaces: &[Surface], region: &Region, tolerance: f64) -> bool {
    let height = region.world_from_region.translation.z;
    let level: Vec<&Surface> = surfaces.iter().filter(|s| (s.height - height).abs() <= tolerance).collect();
    let along = |i: u32, size: f64| (f64::from(i) / f64::from(PROBES - 1) - 0.5) * size;
    (0..PROBES * PROBES).all(|i| {
        let probe = Point3::new(along(i % PROBES, region.size[0]), along(i / PROBES, region.size[1]), 0.0);
        let probe = region.world_from_region * probe;
        level.iter().any(|surface| surface.contains([probe.x, probe.y]))
    })
}

#[cfg(test)]
mod tests {
    use nalgebra::{Translation3, UnitQuaternion};

    use super::*;

    fn object(shape: Shape, roll: f64) -> FixedObject {
        let pose =
            Pose::from_parts(Translation3::new(1.0, 2.0, 3.0), UnitQuaternion::from_euler_angles(roll, 0.0, 0.0));
        let bodies = vec![Body { owner_from_shape: Pose::identity(), shape }];
        FixedObject { name: String::new(), world_from_object: pose, bodies }
    }

    #[test]
    fn a_box_on_its_side_offers_the_face_that_is_up() {
        let surface = &surfaces(&object(Shape::Box { size: [1.0, 2.0, 4.0] }, std::f64::consts::FRAC_PI_2))[0];
        assert!((surface.height - 4.0).abs() < 1e-12);
        assert!(surface.contains([1.5, 4.0]) && surface.contains([0.5, 0.0]));
        assert!(!surface.contains([1.501, 2.0]) && !surface.contains([1.0, 4.001]));
    }

    #[test]
    fn tilted_boxes_and_round_tops_offer_nothing() {
        assert!(surfaces(&object(Shape::Box { size: [1.0; 3] }, 0.1)).is_empty());
        assert!(surfaces(&object(Shape::Sphere { radius: 1.0 }, 0.0)).is_empty());
        assert!(surfaces(&object(Shape::Cylinder { radius: 1.0, length: 1.0 }, 1.0)).is_empty());
    }

    #[test]
    fn an_upright_cylinder_offers_a_disc_at_its_top() {
        let surface = &surfaces(&object(Shape::Cylinder { radius: 0.5, length: 1.0 }, std::f64::consts::PI))[0];
        assert!((surface.height - 3.5).abs() < 1e-12);
        assert!(surface.contains([1.35, 2.35]) && !surface.contains([1.36, 2.36]));
    }

    #[test]
    fn a_region_may_lie_across_two_flush_boxes_but_not_across_a_gap() {
        let region = |size| Region {
            name: String::new(),
            world_from_region: Pose::translation(1.0, 2.0, 3.5),
            size,
            support: crate::FixedId(0),
        };
        let mut table = object(Shape::Box { size: [1.0; 3] }, 0.0);
        let second = Body { owner_from_shape: Pose::translation(1.0, 0.0, 0.0), ..table.bodies[0].clone() };
        table.bodies.push(second);
        assert!(covers(&surfaces(&table), &region([0.9, 0.9]), 1e-3));
        assert!(!covers(&surfaces(&table), &region([1.2, 0.9]), 1e-3));
        let wide = Region { world_from_region: Pose::translation(1.5, 2.0, 3.5), ..region([2.0, 1.0]) };
        assert!(covers(&surfaces(&table), &wide, 1e-3));
        table.bodies[1].owner_from_shape = Pose::translation(1.3, 0.0, 0.0);
        assert!(!covers(&surfaces(&table), &wide, 1e-3));
    }
}
