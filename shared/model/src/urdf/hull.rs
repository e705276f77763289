//! Corners of a convex hull (quickhull on an integer grid), to thin out a mesh's vertices.
//!
//! Meshes are full of points in one plane, on which rounding errors turn a quickhull's faces against each other. On the
//! grid every question of side is answered exactly, so that the faces always bound a convex body.

use std::collections::BTreeSet;

use nalgebra::Point3;

/// Step of the grid as a part of the extent. Meshes carry `f32`.
const STEP: f64 = 1.0e-6;
/// Points may lie this far (m) outside the hull of those that are kept: finely meshed curves have thousands of corners, and
/// every one of them costs time in every distance computation.
const TOLERANCE: f64 = 1.0e-4;

/// Why a set of points has no usable hull.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoHull {
    /// All points lie in a plane.
    Flat,
    /// More corners than wanted.
    TooMany,
}

/// A point on the grid; coordinates are at most 1 / [`STEP`], about 2^20.
type GridPoint = [i64; 3];

struct Face {
    corners: [usize; 3],
    /// Outward, not normalised; components below 2^42.
    normal: GridPoint,
    /// Height of the face's plane along the normal.
    offset: i128,
    /// What a height of one step of the grid above the plane amounts to along the normal.
    step: i128,
    /// Points above this face that no earlier face claims.
    outside: Vec<usize>,
}

impl Face {
    fn new(points: &[GridPoint], corners: [usize; 3]) -> Self {
        let [a, b, c] = corners.map(|i| points[i]);
        let (u, v) = (minus(b, a), minus(c, a));
        let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let step = normal.map(|x| x as f64).iter().fold(0.0_f64, |length, x| length.hypot(*x)) as i128;
        Self { corners, normal, offset: dot(normal, a), step, outside: Vec::new() }
    }

    /// Height above the plane, times the normal's length.
    fn height(&self, point: GridPoint) -> i128 {
        dot(self.normal, point) - self.offset
    }
}

fn minus(a: GridPoint, b: GridPoint) -> GridPoint {
    std::array::from_fn(|i| a[i] - b[i])
}

fn dot(a: GridPoint, b: GridPoint) -> i128 {
    (0..3).map(|i| i128::from(a[i]) * i128::from(b[i])).sum()
}

/// Points of `points` whose hull contains the others within 0.1 mm, or four millionths of the extent if that is more; at
/// most `most` of them.
pub(crate) fn extreme_points(points: &[Point3<f64>], most: usize) -> Result<Vec<Point3<f64>>, NoHull> {
    let step = STEP * extent(points);
    // Less than two steps may come from rounding to the grid.
    let tolerance = (TOLERANCE / step).max(2.0) as i128;
    let (points, grid) = distinct(points, step);
    let seed = simplex(&points, step).ok_or(NoHull::Flat)?;
    let mut faces = seed_faces(&grid, seed);
    distribute(&grid, &mut faces, 0, (0..grid.len()).collect(), tolerance);
    let mut corners = BTreeSet::from(seed);
    while let Some(far) = farthest_outside(&grid, &faces) {
        corners.insert(far);
        if corners.len() > most {
            return Err(NoHull::TooMany);
        }
        grow(&grid, &mut faces, far, tolerance);
    }
    Ok(corners.into_iter().map(|i| points[i]).collect())
}

/// The points without those that share a place on the grid with an earlier one, and their places.
fn distinct(points: &[Point3<f64>], step: f64) -> (Vec<Point3<f64>>, Vec<GridPoint>) {
    let Some(origin) = points.first().filter(|_| step > 0.0) else { return (Vec::new(), Vec::new()) };
    let place = |p: &Point3<f64>| [0, 1, 2].map(|i| ((p[i] - origin[i]) / step).round() as i64);
    let mut seen = BTreeSet::new();
    points.iter().map(|p| (*p, place(p))).filter(|(_, place)| seen.insert(*place)).unzip()
}

fn extent(points: &[Point3<f64>]) -> f64 {
    let Some(first) = points.first() else { return 0.0 };
    let (low, high) = points.iter().fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
    (high - low).norm()
}

/// Four points that span a volume, chosen far apart.
fn simplex(points: &[Point3<f64>], tolerance: f64) -> Option<[usize; 4]> {
    let farthest = |measure: &dyn Fn(&Point3<f64>) -> f64| {
        let best = (0..points.len()).max_by(|i, j| measure(&points[*i]).total_cmp(&measure(&points[*j])))?;
        (measure(&points[best]) > 10.0 * tolerance).then_some(best)
    };
    let first = (0..points.len()).min_by(|i, j| points[*i].x.total_cmp(&points[*j].x))?;
    let a = points[first];
    let second = farthest(&|p| (p - a).norm())?;
    let along = (points[second] - a).normalize();
    let third = farthest(&|p| (p - a).cross(&along).norm())?;
    let normal = along.cross(&(points[third] - a)).normalize();
    let fourth = farthest(&|p| (p - a).dot(&normal).abs())?;
    Some([first, second, third, fourth])
}

/// The faces of the first simplex, with outward normals.
fn seed_faces(points: &[GridPoint], seed: [usize; 4]) -> Vec<Face> {
    let others = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];
    let face = |(apex, [i, j, k]): (usize, [usize; 3])| {
        let face = Face::new(points, [seed[i], seed[j], seed[k]]);
        if face.height(points[seed[apex]]) > 0 { Face::new(points, [seed[i], seed[k], seed[j]]) } else { face }
    };
    others.into_iter().enumerate().map(face).collect()
}

/// Gives each point to the first face, from `first` on, that it lies above by more than `tolerance` steps of the grid.
fn distribute(points: &[GridPoint], faces: &mut [Face], first: usize, candidates: Vec<usize>, tolerance: i128) {
    for candidate in candidates {
        let above = |face: &&mut Face| face.height(points[candidate]) > tolerance * face.step;
        if let Some(face) = faces[first..].iter_mut().find(above) {
            face.outside.push(candidate);
        }
    }
}

/// The highest point above the first face that has any above it: a corner, or as high as one.
fn farthest_outside(points: &[GridPoint], faces: &[Face]) -> Option<usize> {
    let face = faces.iter().find(|face| !face.outside.is_empty())?;
    face.outside.iter().copied().max_by_key(|i| face.height(points[*i]))
}

/// Replaces the faces that see `apex` by a cone from their border to it.
fn grow(points: &[GridPoint], faces: &mut Vec<Face>, apex: usize, tolerance: i128) {
    let mut seen: Vec<Face> = faces.extract_if(.., |face| face.height(points[apex]) > 0).collect();
    let edges = |face: &Face| {
        let [a, b, c] = face.corners;
        [(a, b), (b, c), (c, a)]
    };
    let inner: BTreeSet<(usize, usize)> = seen.iter().flat_map(edges).collect();
    let first_new = faces.len();
    for (a, b) in seen.iter().flat_map(edges).filter(|(a, b)| !inner.contains(&(*b, *a))) {
        faces.push(Face::new(points, [a, b, apex]));
    }
    let orphans = seen.iter_mut().flat_map(|face| std::mem::take(&mut face.outside)).filter(|i| *i != apex).collect();
    distribute(points, faces, first_new, orphans, tolerance);
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector3};
    use proptest::prelude::*;

    use super::*;

    fn cube() -> Vec<Point3<f64>> {
        (0..8).map(|i| Point3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1))).collect()
    }

    #[test]
    fn the_hull_of_a_subdivided_cube_has_eight_corners() {
        let mut points = Vec::new();
        for i in 0..11 {
            for j in 0..11 {
                let (u, v) = (f64::from(i) / 10.0, f64::from(j) / 10.0);
                points.extend(
                    [[u, v, 0.0], [u, v, 1.0], [u, 0.0, v], [u, 1.0, v], [0.0, u, v], [1.0, u, v]].map(Point3::from),
                );
            }
        }
        let mut hull = extreme_points(&points, 100).unwrap();
        hull.sort_by(|a, b| (a.z, a.y, a.x).partial_cmp(&(b.z, b.y, b.x)).unwrap());
        assert_eq!(hull, cube());
    }

    #[test]
    fn flat_and_empty_sets_have_no_hull() {
        let flat: Vec<_> = cube().into_iter().map(|p| Point3::new(p.x, p.y, p.x + p.y)).collect();
        assert_eq!(extreme_points(&flat, 100), Err(NoHull::Flat));
        assert_eq!(extreme_points(&[], 100), Err(NoHull::Flat));
        assert_eq!(extreme_points(&[Point3::origin(); 9], 100), Err(NoHull::Flat));
    }

    #[test]
    fn more_corners_than_wanted_are_told() {
        let angle = |i: u32| f64::from(i) * 0.1;
        let drum = (0..62).flat_map(|i| [0.0, 1.0].map(|z| Point3::new(angle(i).cos(), angle(i).sin(), z)));
        assert_eq!(extreme_points(&drum.collect::<Vec<_>>(), 100), Err(NoHull::TooMany));
    }

    /// Oracle: a cylinder's corners are its rims. A few points that are as high as a corner may join them.
    #[test]
    fn a_slanted_cylinder_with_many_points_on_its_ends_is_little_more_than_its_rims() {
        let turned = Rotation3::from_euler_angles(0.3, -0.8, 2.1);
        let (mut rims, mut others) = (Vec::new(), Vec::new());
        for i in 0..48 {
            let angle = std::f64::consts::TAU * f64::from(i) / 48.0;
            // As meshes carry them.
            let at = |radius: f64, z: f64| {
                (turned * Point3::new(radius * angle.cos(), radius * angle.sin(), z)).map(|x| f64::from(x as f32))
            };
            rims.extend([at(1.0, 0.0), at(1.0, 2.0)]);
            others.extend([at(0.7, 0.0), at(0.3, 0.0), at(0.5, 2.0), at(1.0, 0.9), at(1.0, 1.4)]);
        }
        let hull = extreme_points(&[others, rims.clone()].concat(), 400).unwrap();
        assert!(rims.iter().all(|p| hull.contains(p)));
        assert!(hull.len() < rims.len() * 5 / 4, "{} corners", hull.len());
    }

    proptest! {
        /// Oracle: support functions. In no direction does a point lie beyond the corners.
        #[test]
        fn the_corners_reach_as_far_as_the_points_in_every_direction(
            points in prop::collection::vec(prop::array::uniform3(-1.0..1.0f64), 8..200),
            directions in prop::collection::vec(prop::array::uniform3(-1.0..1.0f64), 50),
        ) {
            let points: Vec<_> = points.into_iter().map(Point3::from).collect();
            let hull = extreme_points(&points, 1000).unwrap();
            for direction in directions.into_iter().map(Vector3::from) {
                let reach = |points: &[Point3<f64>]| points.iter().map(|p| p.coords.dot(&direction)).fold(f64::MIN, f64::max);
                prop_assert!((reach(&points) - reach(&hull)).abs() < 1.1e-4);
            }
        }
    }
}
