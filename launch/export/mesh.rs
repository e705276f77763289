//! Triangles of convex shapes.

use std::f64::consts::{PI, TAU};

use model::{Body, Shape};
use nalgebra::{Point3, Vector3};

/// Corners on a full circle.
const ROUND: u32 = 32;
/// Bands of a hemisphere.
const BANDS: u32 = 8;

/// Triangles with a normal at each corner; counter-clockwise seen from outside.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Corners (m).
    pub positions: Vec<Point3<f64>>,
    /// Unit normals, one per corner.
    pub normals: Vec<Vector3<f64>>,
    /// Three corners per triangle.
    pub indices: Vec<u32>,
}

impl Mesh {
    /// The surface of a body in its owner's frame; empty for a hull without volume.
    #[must_use]
    pub fn of_body(body: &Body) -> Self {
        let mut mesh = Self::of_shape(&body.shape);
        for position in &mut mesh.positions {
            *position = body.owner_from_shape * *position;
        }
        for normal in &mut mesh.normals {
            *normal = (body.owner_from_shape.rotation * *normal).normalize();
        }
        mesh
    }

    fn of_shape(shape: &Shape) -> Self {
        match shape {
            Shape::Box { size } => box_mesh(Vector3::from(*size) / 2.0),
            Shape::Sphere { radius } => turned(&round(*radius, 0.0)),
            Shape::Capsule { radius, length } => turned(&round(*radius, length / 2.0)),
            Shape::Cylinder { radius, length } => cylinder(*radius, length / 2.0),
            Shape::Hull { points } => hull(points),
        }
    }

    fn triangle(&mut self, corners: [Point3<f64>; 3]) {
        let [a, b, c] = corners;
        let Some(normal) = (b - a).cross(&(c - a)).try_normalize(0.0) else { return };
        for corner in corners {
            self.indices.push(self.positions.len() as u32);
            self.positions.push(corner);
            self.normals.push(normal);
        }
    }
}

fn box_mesh(half: Vector3<f64>) -> Mesh {
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let mut normal = Vector3::zeros();
            normal[axis] = side;
            let first = mesh.positions.len() as u32;
            for (u, v) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                let mut corner = Point3::origin();
                corner[axis] = side * half[axis];
                corner[(axis + 1) % 3] = u * side * half[(axis + 1) % 3];
                corner[(axis + 2) % 3] = v * half[(axis + 2) % 3];
                mesh.positions.push(corner);
                mesh.normals.push(normal);
            }
            mesh.indices.extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
        }
    }
    mesh
}

/// A point of a profile: distance from the z axis and height (m), and the normal's parts in those directions.
type Profile = [f64; 4];

/// Profile of a sphere cut at the equator and drawn apart by `half` on either side.
fn round(radius: f64, half: f64) -> Vec<Profile> {
    let at = |angle: f64, shift: f64| {
        let (height, out) = angle.sin_cos();
        [radius * out, shift + radius * height, out, height]
    };
    let angle = |band: u32| f64::from(band) / f64::from(BANDS) * PI / 2.0;
    let lower = (0..=BANDS).map(|band| at(angle(band) - PI / 2.0, -half));
    let upper = (u32::from(half == 0.0)..=BANDS).map(|band| at(angle(band), half));
    lower.chain(upper).collect()
}

/// The surface that a profile, from the lowest point up, describes about z.
fn turned(profile: &[Profile]) -> Mesh {
    let mut mesh = Mesh::default();
    for [distance, height, out, up] in profile {
        for step in 0..=ROUND {
            // The last corner of a round is exactly the first.
            let (sine, cosine) = (f64::from(step % ROUND) / f64::from(ROUND) * TAU).sin_cos();
            mesh.positions.push(Point3::new(distance * cosine, distance * sine, *height));
            mesh.normals.push(Vector3::new(out * cosine, out * sine, *up).normalize());
        }
    }
    let width = ROUND + 1;
    for row in 0..profile.len() as u32 - 1 {
        for step in 0..ROUND {
            let (a, b) = (row * width + step, row * width + step + 1);
            let flat = |row: u32| profile[row as usize][0].abs() < 1e-12;
            if !flat(row) {
                mesh.indices.extend([a, b, b + width]);
            }
            if !flat(row + 1) {
                mesh.indices.extend([a, b + width, a + width]);
            }
        }
    }
    mesh
}

fn cylinder(radius: f64, half: f64) -> Mesh {
    turned(&[
        [0.0, -half, 0.0, -1.0],
        [radius, -half, 0.0, -1.0],
        [radius, -half, 1.0, 0.0],
        [radius, half, 1.0, 0.0],
        [radius, half, 0.0, 1.0],
        [0.0, half, 0.0, 1.0],
    ])
}

fn hull(points: &[Point3<f64>]) -> Mesh {
    let mut mesh = Mesh::default();
    if let Some(surface) = collision::hull_surface(points) {
        for face in surface.faces {
            mesh.triangle(face.map(|corner| surface.corners[corner as usize]));
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use model::Pose;

    use super::*;

    fn volume(shape: Shape) -> f64 {
        let mesh = Mesh::of_body(&Body { owner_from_shape: Pose::translation(0.3, -0.2, 0.9), shape });
        assert!(mesh.normals.iter().all(|normal| (normal.norm() - 1.0).abs() < 1e-12));
        mesh.indices
            .chunks(3)
            .map(|face| [0, 1, 2].map(|i| mesh.positions[face[i] as usize].coords))
            .map(|[a, b, c]| a.cross(&b).dot(&c) / 6.0)
            .sum()
    }

    fn assert_close(found: f64, exact: f64) {
        assert!(found > 0.97 * exact && found < exact * (1.0 + 1e-9), "{found} for {exact}");
    }

    #[test]
    fn meshes_enclose_the_volumes_of_their_shapes_with_faces_outwards() {
        let cube: Vec<_> =
            (0..8).map(|i| Point3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2))).collect();
        assert_close(volume(Shape::Box { size: [1.0, 2.0, 3.0] }), 6.0);
        assert_close(volume(Shape::Hull { points: cube }), 1.0);
        assert_close(volume(Shape::Sphere { radius: 0.5 }), PI / 6.0);
        assert_close(volume(Shape::Cylinder { radius: 0.5, length: 2.0 }), PI / 2.0);
        assert_close(volume(Shape::Capsule { radius: 0.5, length: 2.0 }), PI / 6.0 + PI / 2.0);
    }

    #[test]
    fn normals_look_the_same_way_as_their_triangles() {
        for shape in [Shape::Sphere { radius: 1.0 }, Shape::Capsule { radius: 0.1, length: 0.3 }] {
            let mesh = Mesh::of_shape(&shape);
            for face in mesh.indices.chunks(3) {
                let [a, b, c] = [0, 1, 2].map(|i| mesh.positions[face[i] as usize]);
                assert!((b - a).cross(&(c - a)).dot(&mesh.normals[face[0] as usize]) > 0.0);
            }
        }
    }
}
