//! Corners of a convex hull (quickhull), to thin out a mesh's vertices.

use std::collections::BTreeSet;

use nalgebra::{Point3, Vector3};

/// A point this far outside the hull of the others, as a part of the extent, counts as a corner. Meshes carry `f32`.
const TOLERANCE: f64 = 1.0e-6;

/// Why a set of points has no usable hull.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoHull {
    /// All points lie in a plane.
    Flat,
    /// More corners than wanted.
    TooMany,
}

struct Face {
    corners: [usize; 3],
    normal: Vector3<f64>,
    offset: f64,
    /// Points above this face that no earlier face claims.
    outside: Vec<usize>,
}

impl Face {
    fn new(points: &[Point3<f64>], corners: [usize; 3]) -> Self {
        let [a, b, c] = corners.map(|i| points[i]);
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vector3::zeros);
        Self { corners, normal, offset: normal.dot(&a.coords), outside: Vec::new() }
    }

    fn height(&self, point: &Point3<f64>) -> f64 {
        self.normal.dot(&point.coords) - self.offset
    }
}

/// Points of `points` whose hull contains the others within a millionth of the extent; at most `most` of them.
pub(crate) fn extreme_points(points: &[Point3<f64>], most: usize) -> Result<Vec<Point3<f64>>, NoHull> {
    let points = distinct(points);
    let tolerance = TOLERANCE * extent(&points);
    let seed = simplex(&points, tolerance).ok_or(NoHull::Flat)?;
    let mut faces = seed_faces(&points, seed);
    distribute(&points, &mut faces, 0, (0..points.len()).collect(), tolerance);
    let mut corners = BTreeSet::from(seed);
    while let Some(far) = farthest_outside(&points, &faces) {
        corners.insert(far);
        if corners.len() > most {
            return Err(NoHull::TooMany);
        }
        grow(&points, &mut faces, far, tolerance);
    }
    Ok(corners.into_iter().map(|i| points[i]).collect())
}

/// The points without repetitions, in order of first appearance.
fn distinct(points: &[Point3<f64>]) -> Vec<Point3<f64>> {
    let mut seen = BTreeSet::new();
    // Adding zero turns -0 into 0.
    points.iter().filter(|p| seen.insert([p.x, p.y, p.z].map(|x| (x + 0.0).to_bits()))).copied().collect()
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
fn seed_faces(points: &[Point3<f64>], seed: [usize; 4]) -> Vec<Face> {
    let others = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];
    let face = |(apex, [i, j, k]): (usize, [usize; 3])| {
        let face = Face::new(points, [seed[i], seed[j], seed[k]]);
        if face.height(&points[seed[apex]]) > 0.0 { Face::new(points, [seed[i], seed[k], seed[j]]) } else { face }
    };
    others.into_iter().enumerate().map(face).collect()
}

/// Gives each point to the first face, from `first` on, that it lies above.
fn distribute(points: &[Point3<f64>], faces: &mut [Face], first: usize, candidates: Vec<usize>, tolerance: f64) {
    for candidate in candidates {
        let above = |face: &&mut Face| face.height(&points[candidate]) > tolerance;
        if let Some(face) = faces[first..].iter_mut().find(above) {
            face.outside.push(candidate);
        }
    }
}

/// The highest point above the first face that has any above it: certainly a corner.
fn farthest_outside(points: &[Point3<f64>], faces: &[Face]) -> Option<usize> {
    let face = faces.iter().find(|face| !face.outside.is_empty())?;
    let height = |i: &usize| face.height(&points[*i]);
    face.outside.iter().copied().max_by(|i, j| height(i).total_cmp(&height(j)))
}

/// Replaces the faces that see `apex` by a cone from their border to it.
fn grow(points: &[Point3<f64>], faces: &mut Vec<Face>, apex: usize, tolerance: f64) {
    let sees = |face: &Face| face.height(&points[apex]) > tolerance;
    let (seen, kept): (Vec<Face>, Vec<Face>) = std::mem::take(faces).into_iter().partition(sees);
    *faces = kept;
    let edges = |face: &Face| {
        let [a, b, c] = face.corners;
        [(a, b), (b, c), (c, a)]
    };
    let inner: BTreeSet<(usize, usize)> = seen.iter().flat_map(edges).collect();
    let first_new = faces.len();
    for (a, b) in seen.iter().flat_map(edges).filter(|(a, b)| !inner.contains(&(*b, *a))) {
        faces.push(Face::new(points, [a, b, apex]));
    }
    let orphans = seen.into_iter().flat_map(|face| face.outside).filter(|i| *i != apex).collect();
    distribute(points, faces, first_new, orphans, tolerance);
}

#[cfg(test)]
mod tests {
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
                prop_assert!((reach(&points) - reach(&hull)).abs() < 1e-5);
            }
        }
    }
}
