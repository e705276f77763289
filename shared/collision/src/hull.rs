//! Convex hulls of point sets.

use model::Pose;
use nalgebra::{Point3, Vector3};
use parry3d_f64::math::Vector;
use parry3d_f64::transformation::try_convex_hull;

/// How far a point may lie outside a computed hull, as a fraction of the set's size, before the hull is distrusted.
const HULL_TOLERANCE: f64 = 1e-9;

/// Corners that span a hull (m).
#[derive(Clone, Debug)]
pub(crate) struct Corners {
    /// About the middle of their bounds.
    pub corners: Vec<Vector3<f64>>,
    /// That middle, in the frame of the points given.
    pub middle: Point3<f64>,
    /// Half the edges of their bounds.
    pub half: Vector3<f64>,
}

/// The corners that span the hull of `points`.
///
/// # Errors
/// A sentence, when there is no point or one is not finite.
pub(crate) fn corners(points: &[Point3<f64>]) -> Result<Corners, String> {
    if points.is_empty() {
        return Err("a hull needs points".into());
    }
    if !points.iter().all(|p| p.coords.iter().all(|c| c.is_finite())) {
        return Err("every point of a hull must be finite".into());
    }
    let (least, greatest) = points.iter().fold((points[0], points[0]), |(low, high), p| (low.inf(p), high.sup(p)));
    let middle = nalgebra::center(&least, &greatest);
    let all: Vec<Vector3<f64>> = points.iter().map(|p| p - middle).collect();
    let half = all.iter().fold(Vector3::zeros(), |most: Vector3<f64>, p| most.sup(&p.abs()));
    let corners = reduced(&all, half.norm() * HULL_TOLERANCE).unwrap_or(all);
    Ok(Corners { corners, middle, half })
}

/// The points that matter, when the hull's faces can be trusted to enclose all; flat sets keep every point.
fn reduced(points: &[Vector3<f64>], tolerance: f64) -> Option<Vec<Vector3<f64>>> {
    let as_given: Vec<Vector> = points.iter().map(|p| Vector::new(p.x, p.y, p.z)).collect();
    let (corners, faces) = try_convex_hull(&as_given).ok()?;
    for face in &faces {
        let [a, b, c] = face.map(|i| corners[i as usize]);
        let normal = (b - a).cross(c - a).try_normalize()?;
        if !as_given.iter().all(|p| (*p - a).dot(normal) <= tolerance) {
            return None;
        }
    }
    let enough = faces.len() >= 4;
    enough.then(|| corners.iter().map(|p| Vector3::new(p.x, p.y, p.z)).collect())
}

/// The surface of a hull, for drawing it.
#[derive(Clone, Debug, Default)]
pub struct HullSurface {
    /// Corners (m).
    pub corners: Vec<Point3<f64>>,
    /// Three corners each, counter-clockwise seen from outside.
    pub faces: Vec<[u32; 3]>,
}

impl HullSurface {
    /// What it encloses (m³).
    fn volume(&self) -> f64 {
        let corners = |face: &[u32; 3]| face.map(|corner| self.corners[corner as usize].coords);
        self.faces.iter().map(corners).map(|[a, b, c]| a.cross(&b).dot(&c) / 6.0).sum()
    }
}

/// The surface of the hull of points that span a volume; `None` for flat or non-finite sets.
#[must_use]
pub fn hull_surface(points: &[Point3<f64>]) -> Option<HullSurface> {
    let size = corners(points).ok()?.half.norm();
    let as_given: Vec<Vector> = points.iter().map(|p| Vector::new(p.x, p.y, p.z)).collect();
    let (corners, faces) = try_convex_hull(&as_given).ok()?;
    let surface = HullSurface { corners: corners.iter().map(|p| Point3::new(p.x, p.y, p.z)).collect(), faces };
    // A flat set has a surface too: the same faces on both sides.
    (surface.volume() > HULL_TOLERANCE * size.powi(3)).then_some(surface)
}

/// The farthest corner in a direction; the origin if there is none.
pub(crate) fn support(corners: &[Vector3<f64>], direction: &Vector3<f64>) -> Vector3<f64> {
    let mut farthest = Vector3::zeros();
    let mut most = f64::MIN;
    for corner in corners {
        let along = corner.dot(direction);
        if along > most {
            most = along;
            farthest = *corner;
        }
    }
    farthest
}

/// Greatest coordinate of the corners along a direction.
pub(crate) fn extent(corners: &[Vector3<f64>], direction: &Vector3<f64>) -> f64 {
    corners.iter().fold(f64::MIN, |most, corner| most.max(corner.dot(direction)))
}

/// `pose`, with its origin moved to a point of its own frame.
pub(crate) fn shifted(pose: &Pose, origin: &Point3<f64>) -> Pose {
    pose * nalgebra::Translation3::from(origin.coords)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_inside_a_cube_are_dropped_and_its_corners_kept() {
        let mut points: Vec<Point3<f64>> =
            (0..8).map(|i| Point3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1))).collect();
        points.push(Point3::new(0.5, 0.4, 0.3));
        points.push(Point3::new(0.1, 0.9, 0.5));
        let Corners { corners, middle, half } = corners(&points).unwrap();
        assert_eq!(corners.len(), 8);
        assert_eq!(middle, Point3::new(0.5, 0.5, 0.5));
        assert_eq!(half, Vector3::new(0.5, 0.5, 0.5));
    }

    #[test]
    fn faces_of_a_hull_look_outwards_and_enclose_its_volume() {
        let mut points: Vec<Point3<f64>> =
            (0..8).map(|i| Point3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1))).collect();
        points.push(Point3::new(0.5, 0.5, 2.0));
        let surface = hull_surface(&points).unwrap();
        assert!((surface.volume() - 4.0 / 3.0).abs() < 1e-12, "a cube and a pyramid of height 1 on it");
        let inside = Vector3::new(0.5, 0.5, 0.5);
        for face in &surface.faces {
            let [a, b, c] = face.map(|corner| surface.corners[corner as usize].coords);
            assert!((b - a).cross(&(c - a)).dot(&(a - inside)) > 0.0);
        }
        assert!(hull_surface(&points[..4]).is_none(), "a square has no volume");
    }

    #[test]
    fn a_flat_set_keeps_every_point() {
        let flat: Vec<Point3<f64>> = (0..9).map(|i| Point3::new(f64::from(i % 3), f64::from(i / 3), 1.0)).collect();
        let Corners { corners, half, .. } = corners(&flat).unwrap();
        let reach = extent(&corners, &Vector3::new(1.0, 1.0, 0.0));
        assert!((reach - 2.0).abs() < 1e-12 && half.z.abs() < 1e-12);
    }
}
