//! Horizontal sections of convex bodies, never larger than the bodies: for proofs that something is in the way.

use std::f64::consts::TAU;

use glamx::{DVec2, DVec3};
use model::{Body, Shape};

use crate::frame::Frame;

/// Corners of the polygons that stand for the discs of a cylinder.
const ROUND: usize = 128;
/// Corners of those that stand for circles of latitude, and how many of them stand for a half sphere.
const LATITUDE: usize = 24;
const LATITUDES: usize = 6;

/// Points whose convex hull is inside of a body; where the body has corners, it is the body.
#[derive(Clone, Debug)]
pub(crate) struct Inside(Vec<DVec3>);

/// A convex polygon, counter-clockwise; fewer than three corners have no inside.
#[derive(Clone, Debug)]
pub(crate) struct Polygon(pub(crate) Vec<DVec2>);

impl Inside {
    /// Of a body whose owner stands at `frame`.
    pub(crate) fn of(body: &Body, frame: &Frame) -> Self {
        let placed = *frame * Frame::of(&body.owner_from_shape);
        let circle = |corners: usize, radius: f64, z: f64| {
            (0..corners).map(move |i| {
                let (sin, cos) = (TAU * i as f64 / corners as f64).sin_cos();
                DVec3::new(radius * cos, radius * sin, z)
            })
        };
        let dome = |radius: f64, z: f64, side: f64| {
            (0..=LATITUDES).flat_map(move |i| {
                let (sin, cos) = (TAU / 4.0 * i as f64 / LATITUDES as f64).sin_cos();
                circle(LATITUDE, radius * cos, z + side * radius * sin)
            })
        };
        let points: Vec<DVec3> = match &body.shape {
            Shape::Box { size } => (0..8)
                .map(|i| DVec3::from_array(std::array::from_fn(|k| if i >> k & 1 == 1 { 0.5 } else { -0.5 } * size[k])))
                .collect(),
            Shape::Cylinder { radius, length } => {
                [-0.5, 0.5].into_iter().flat_map(|end| circle(ROUND, *radius, end * length)).collect()
            }
            Shape::Sphere { radius } => [-1.0, 1.0].into_iter().flat_map(|side| dome(*radius, 0.0, side)).collect(),
            Shape::Capsule { radius, length } => {
                [-1.0, 1.0].into_iter().flat_map(|side| dome(*radius, side * length / 2.0, side)).collect()
            }
            Shape::Hull { points } => points.iter().map(|p| DVec3::new(p.x, p.y, p.z)).collect(),
        };
        Self(points.into_iter().map(|p| placed.point(p)).collect())
    }

    /// Least and greatest height (m).
    pub(crate) fn heights(&self) -> (f64, f64) {
        self.0.iter().fold((f64::MAX, f64::MIN), |(low, high), p| (low.min(p.z), high.max(p.z)))
    }

    /// What it covers at a height.
    pub(crate) fn section(&self, z: f64) -> Polygon {
        let below: Vec<DVec3> = self.0.iter().copied().filter(|p| p.z <= z).collect();
        let above: Vec<DVec3> = self.0.iter().copied().filter(|p| p.z >= z).collect();
        let crossing = |a: DVec3, b: DVec3| {
            let part = if b.z > a.z { ((z - a.z) / (b.z - a.z)).clamp(0.0, 1.0) } else { 0.0 };
            (a + (b - a) * part).truncate()
        };
        let points = below.iter().flat_map(|a| above.iter().map(move |b| crossing(*a, *b))).collect();
        Polygon::around(points)
    }
}

impl Polygon {
    /// The convex hull of points.
    pub(crate) fn around(mut points: Vec<DVec2>) -> Self {
        points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        points.dedup();
        if points.len() < 3 {
            return Self(points);
        }
        let mut corners = half_hull(points.iter());
        corners.extend(half_hull(points.iter().rev()));
        Self(corners)
    }

    fn edges(&self) -> impl Iterator<Item = (DVec2, DVec2)> + '_ {
        (0..self.0.len()).map(|i| (self.0[i], self.0[(i + 1) % self.0.len()]))
    }

    /// Area (m²).
    pub(crate) fn area(&self) -> f64 {
        self.edges().map(|(a, b)| a.perp_dot(b)).sum::<f64>() / 2.0
    }

    /// Distance of a point (m); 0 inside. A polygon without corners is infinitely far.
    pub(crate) fn distance(&self, p: DVec2) -> f64 {
        if self.0.len() >= 3 && self.edges().all(|(a, b)| (b - a).perp_dot(p - a) >= 0.0) {
            return 0.0;
        }
        self.edges().map(|(a, b)| to_segment(p, a, b)).fold(f64::INFINITY, f64::min)
    }

    /// Radius of the largest disc about a point (m); at most 0 if the point is not inside.
    pub(crate) fn radius_about(&self, p: DVec2) -> f64 {
        if self.0.len() < 3 {
            return 0.0;
        }
        self.edges().map(|(a, b)| (b - a).perp_dot(p - a) / (b - a).length()).fold(f64::INFINITY, f64::min)
    }

    /// The part on the inner side of a line: where `normal · p <= offset`.
    pub(crate) fn cut(&self, normal: DVec2, offset: f64) -> Self {
        let mut kept = Vec::new();
        for (a, b) in self.edges() {
            let (of_a, of_b) = (normal.dot(a) - offset, normal.dot(b) - offset);
            if of_a <= 0.0 {
                kept.push(a);
            }
            if of_a * of_b < 0.0 {
                kept.push(a + (b - a) * (of_a / (of_a - of_b)));
            }
        }
        Self(kept)
    }

    /// Least and greatest corner of the box around it (m).
    pub(crate) fn bounds(&self) -> (DVec2, DVec2) {
        self.0.iter().fold((DVec2::MAX, DVec2::MIN), |(low, high), p| (low.min(*p), high.max(*p)))
    }
}

/// Corners of the hull from the first of sorted points to the last, without the last; they turn left.
fn half_hull<'p>(points: impl Iterator<Item = &'p DVec2>) -> Vec<DVec2> {
    let mut corners: Vec<DVec2> = Vec::new();
    for p in points {
        while let [.., a, b] = corners[..] {
            if (b - a).perp_dot(*p - a) > 0.0 {
                break;
            }
            corners.pop();
        }
        corners.push(*p);
    }
    corners.pop();
    corners
}

fn to_segment(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let along = b - a;
    let part = if along == DVec2::ZERO { 0.0 } else { ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0) };
    p.distance(a + along * part)
}

#[cfg(test)]
mod tests;
