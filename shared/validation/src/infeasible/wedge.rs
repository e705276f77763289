//! How deep two convex bodies are in one another, at least.
//!
//! Bodies are represented by polytopes inside of them. The depth of polytopes A and B is the least overlap along any
//! direction. It is met along a face normal of A or of B, or along one that is square to an edge of each. If the points of
//! A are then displaced by less than the depth, rigidly and however, A and B still meet: a direction that separated them
//! would have had less overlap before.

use glamx::{DMat3, DVec3};
use model::{Body, Shape};

use crate::frame::Frame;

/// Sides of the prism that stands for a cylinder; even.
const SIDES: usize = 12;
/// Allowance (m) for rounding, and for normals of edges that are parallel but for rounding.
const ROUNDING: f64 = 1e-5;

/// A polytope inside of a body, in the frame of the body's owner.
#[derive(Clone, Debug)]
pub(crate) struct Wedge {
    corners: Vec<DVec3>,
    /// Of opposite faces one.
    normals: Vec<DVec3>,
    /// Of parallel edges one.
    edges: Vec<DVec3>,
    /// Whether the faces are not known: then the corners are nothing but points of the body.
    mesh: bool,
    /// Farthest corner from the owner's origin, and from its z axis (m).
    pub(crate) reach: f64,
    pub(crate) swing: f64,
}

impl Wedge {
    pub(crate) fn of(body: &Body) -> Self {
        let (corners, normals, edges) = match &body.shape {
            Shape::Box { size } => block(DVec3::from(*size) / 2.0),
            Shape::Sphere { radius } => block(DVec3::splat(radius / 3.0_f64.sqrt())),
            Shape::Cylinder { radius, length } => prism(*radius, length / 2.0),
            Shape::Capsule { radius, length } => {
                let part = radius * std::f64::consts::FRAC_1_SQRT_2;
                prism(part, length / 2.0 + part)
            }
            Shape::Hull { points } => (points_within(points), Vec::new(), Vec::new()),
        };
        let mesh = matches!(body.shape, Shape::Hull { .. });
        let wedge = Self { corners, normals, edges, mesh, reach: 0.0, swing: 0.0 };
        wedge.placed(&Frame::of(&body.owner_from_shape))
    }

    /// The same in another frame.
    pub(crate) fn placed(&self, frame: &Frame) -> Self {
        let turned = |directions: &[DVec3]| directions.iter().map(|d| frame.rotation * *d).collect();
        let corners: Vec<DVec3> = self.corners.iter().map(|corner| frame.point(*corner)).collect();
        let farthest = |distance: fn(&DVec3) -> f64| corners.iter().map(distance).fold(0.0, f64::max);
        Self {
            normals: turned(&self.normals),
            edges: turned(&self.edges),
            mesh: self.mesh,
            reach: farthest(|corner| corner.length()),
            swing: farthest(|corner| corner.truncate().length()),
            corners,
        }
    }

    /// Depth of the overlap with another wedge in the same frame (m), at least; at most 0 if they are apart.
    pub(crate) fn depth(&self, other: &Wedge) -> f64 {
        match (self.mesh, other.mesh) {
            (false, false) => self.depth_of_polytopes(other),
            (true, false) => self.deepest_corner(other),
            (false, true) => other.deepest_corner(self),
            (true, true) => 0.0,
        }
    }

    /// A body is at least as deep in another as any of its points is.
    fn deepest_corner(&self, other: &Wedge) -> f64 {
        let depth = |corner: &DVec3| {
            let point = Self { corners: vec![*corner], normals: Vec::new(), edges: Vec::new(), ..other.clone() };
            point.depth_of_polytopes(other)
        };
        self.corners.iter().map(depth).fold(f64::NEG_INFINITY, f64::max)
    }

    fn depth_of_polytopes(&self, other: &Wedge) -> f64 {
        let square = self.edges.iter().flat_map(|a| other.edges.iter().map(move |b| a.cross(*b)));
        let square = square.filter(|n| n.length() > 1e-6).map(DVec3::normalize);
        let normals = self.normals.iter().chain(&other.normals).copied().chain(square);
        normals.map(|normal| self.overlap(other, normal)).fold(f64::INFINITY, f64::min) - ROUNDING
    }

    /// How far one would have to move along or against a direction to be clear of the other.
    fn overlap(&self, other: &Wedge, normal: DVec3) -> f64 {
        let range = |wedge: &Wedge| {
            let heights = wedge.corners.iter().map(|corner| corner.dot(normal));
            heights.fold((f64::MAX, f64::MIN), |(low, high), height| (low.min(height), high.max(height)))
        };
        let ((low, high), (other_low, other_high)) = (range(self), range(other));
        (high - other_low).min(other_high - low)
    }
}

type Parts = (Vec<DVec3>, Vec<DVec3>, Vec<DVec3>);

fn block(half: DVec3) -> Parts {
    let side = |i: usize, axis: usize| if i >> axis & 1 == 1 { 1.0 } else { -1.0 };
    let corners = (0..8).map(|i| half * DVec3::new(side(i, 0), side(i, 1), side(i, 2))).collect();
    let axes = vec![DVec3::X, DVec3::Y, DVec3::Z];
    (corners, axes.clone(), axes)
}

/// Points of a hull: its corners, and on the lines between them and their middle.
fn points_within(corners: &[nalgebra::Point3<f64>]) -> Vec<DVec3> {
    let corners: Vec<DVec3> = corners.iter().map(|p| DVec3::new(p.x, p.y, p.z)).collect();
    let middle = corners.iter().sum::<DVec3>() / corners.len().max(1) as f64;
    let parts = [0.0, 0.25, 0.5, 0.75, 1.0];
    corners.iter().flat_map(|corner| parts.map(|part| middle.lerp(*corner, part))).collect()
}

/// A prism about z whose long edges lie on a cylinder.
fn prism(radius: f64, half: f64) -> Parts {
    let at = |turn: f64| DMat3::from_rotation_z(std::f64::consts::TAU * turn / SIDES as f64) * DVec3::X;
    let corners = (0..SIDES).flat_map(|i| [-half, half].map(|z| (at(i as f64) * radius).with_z(z))).collect();
    let normals: Vec<DVec3> = (0..SIDES / 2).map(|i| at(i as f64 + 0.5)).chain([DVec3::Z]).collect();
    // An edge of the discs is square to its side's normal.
    let edges = normals.iter().map(|normal| if normal.z == 0.0 { DVec3::Z.cross(*normal) } else { DVec3::Z }).collect();
    (corners, normals, edges)
}

#[cfg(test)]
mod tests;
