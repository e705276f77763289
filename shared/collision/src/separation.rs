//! Whether two placed solids keep a distance while both move by bounded amounts. "Clear" is always verified on a
//! separating axis with the solids' exact supports; GJK only proposes axes.

use nalgebra::Vector3;

use crate::gjk::{self, Closest};
use crate::solid::{Placed, Solid};

/// What is known of two solids.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Verdict {
    /// They stay at least the wanted distance apart however they move within their bounds.
    Clear,
    /// Where they are now they are nearer than the clearance.
    Contact,
    /// Neither; the axis is a promising one for a smaller motion.
    Unsure(Vector3<f64>),
}

/// How far apart two solids must be: the clearance, and more by what they may move from where they are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Need {
    /// Distance they must keep (m).
    pub clearance: f64,
    /// How far their points may move relative to each other, in any direction (m).
    pub spread: f64,
    /// Straight displacements (m) that each may make besides, to and fro.
    pub drifts: [Vector3<f64>; 2],
    /// Sum of the drifts' lengths (m).
    pub drift: f64,
}

impl Need {
    /// For solids that stand still.
    pub fn still(clearance: f64) -> Self {
        Self { clearance, spread: 0.0, drifts: [Vector3::zeros(); 2], drift: 0.0 }
    }

    /// For solids that move by at most `spread` relative to each other, and each along its drift.
    pub fn moving(clearance: f64, spread: f64, drifts: [Vector3<f64>; 2]) -> Self {
        Self { clearance, spread, drifts, drift: drifts[0].norm() + drifts[1].norm() }
    }

    /// Bound on the relative displacement (m).
    pub fn displacement(&self) -> f64 {
        self.spread + self.drift
    }

    /// Gap that suffices in any direction (m).
    fn anywhere(&self) -> f64 {
        self.clearance + self.displacement()
    }

    /// Gap that suffices along a unit axis (m): a drift counts only by its part along it.
    fn along(&self, axis: &Vector3<f64>) -> f64 {
        if self.drift > 0.0 {
            self.clearance + self.spread + self.drifts[0].dot(axis).abs() + self.drifts[1].dot(axis).abs()
        } else {
            self.clearance + self.spread
        }
    }
}

/// A solid and its pose.
pub(crate) type Posed<'a> = (&'a Solid, &'a Placed);

/// Whether the balls around two solids already prove them clear.
pub(crate) fn balls_clear(a: Posed<'_>, b: Posed<'_>, need: &Need) -> bool {
    let reach = a.0.radius + b.0.radius + need.anywhere();
    (b.1.center - a.1.center).norm_squared() >= reach * reach
}

/// Judges two solids. `hint` is an axis from the first to the second that once separated them, or nearly; zero if none.
pub(crate) fn judge(a: Posed<'_>, b: Posed<'_>, need: &Need, hint: &Vector3<f64>) -> Verdict {
    if balls_clear(a, b, need) || (*hint != Vector3::zeros() && axis_clears(a, b, need, hint)) {
        return Verdict::Clear;
    }
    let best = match boxes_clear(a, b, need) {
        None => return Verdict::Clear,
        Some(best) => best,
    };
    let margin = need.anywhere() + a.0.rounding + b.0.rounding;
    match gjk::closest(a, b, margin, &best) {
        Closest::Meeting => Verdict::Contact,
        Closest::Apart { axis, .. } if axis_clears(a, b, need, &axis) => Verdict::Clear,
        Closest::Apart { at_most, .. } if at_most - a.0.rounding - b.0.rounding < need.clearance => Verdict::Contact,
        Closest::Apart { axis, .. } => Verdict::Unsure(axis),
    }
}

/// Whether the gap along a unit axis from `a` to `b` suffices.
fn axis_clears(a: Posed<'_>, b: Posed<'_>, need: &Need, axis: &Vector3<f64>) -> bool {
    -b.0.extent(b.1, &-axis) - a.0.extent(a.1, axis) >= need.along(axis)
}

/// Tests the six face normals of the boxes around the two cores. `None` if one clears; else the one that came nearest
/// to it, pointing from the first solid to the second.
fn boxes_clear(a: Posed<'_>, b: Posed<'_>, need: &Need) -> Option<Vector3<f64>> {
    let between = b.1.center - a.1.center;
    let b_in_a = a.1.rotation.tr_mul(&b.1.rotation);
    let turned = b_in_a.abs();
    let along_a = a.1.rotation.tr_mul(&between);
    let along_b = b.1.rotation.tr_mul(&between);
    let extents_a = a.0.half + turned * b.0.half;
    let extents_b = b.0.half + turned.tr_mul(&a.0.half);
    let rounding = a.0.rounding + b.0.rounding;
    let mut best = (f64::MIN, Vector3::z());
    for (rotation, along, extents) in [(&a.1.rotation, along_a, extents_a), (&b.1.rotation, along_b, extents_b)] {
        for i in 0..3 {
            let axis: Vector3<f64> = rotation.column(i).into();
            let excess = along[i].abs() - extents[i] - rounding - need.along(&axis);
            if excess >= 0.0 {
                return None;
            }
            if excess > best.0 {
                best = (excess, axis * 1.0f64.copysign(along[i]));
            }
        }
    }
    Some(best.1)
}
