//! Three joints whose axes meet in a point: a rotation split into turns about three given axes.

use nalgebra::{UnitQuaternion, Vector3};

use crate::line::{angle_about, rotation};

/// Sine of the angle between first and third axis below which only the sum (or difference) of their turns is determined.
const ALIGNED: f64 = 1e-10;
/// Angle (rad) by which a rotation may lie out of reach of oblique axes before it is refused.
const SLACK: f64 = 1e-10;

/// Three axes through one point, consecutive ones not parallel: `rotation = turn(0, x) · turn(1, y) · turn(2, z)`.
#[derive(Clone, Debug)]
pub(crate) struct SphericalJoint {
    axes: [Vector3<f64>; 3],
    /// Angles (rad) between first and second, second and third axis.
    sides: [f64; 2],
    /// Dihedral angle (rad) at the second axis, from the first to the third, where the second turn is zero.
    phase: f64,
}

impl SphericalJoint {
    /// The joint with these unit axes, given where all turns are zero.
    pub fn new(axes: [Vector3<f64>; 3]) -> Self {
        let sides = [between(&axes[0], &axes[1]), between(&axes[1], &axes[2])];
        let phase = angle_about(&axes[1], &axes[0], &axes[2]);
        Self { axes, sides, phase }
    }

    /// The rotation of these turns (rad).
    pub fn compose(&self, turns: [f64; 3]) -> UnitQuaternion<f64> {
        rotation(&self.axes[0], turns[0]) * rotation(&self.axes[1], turns[1]) * rotation(&self.axes[2], turns[2])
    }

    /// The turns (rad, up to whole turns) that make up `whole`: two sets, the one with the positive dihedral angle first.
    ///
    /// Where first and third axis align, the first turn is `first_turn`, or, without one, first and third turn are equally
    /// great. None where oblique axes cannot make the rotation.
    pub fn split(&self, whole: &UnitQuaternion<f64>, first_turn: Option<f64>) -> Option<[[f64; 3]; 2]> {
        let third_after = whole * self.axes[2];
        let dihedral = self.dihedral(between(&self.axes[0], &third_after))?;
        Some([dihedral, -dihedral].map(|dihedral| {
            let second = dihedral - self.phase;
            let (first, third) = self.outer_turns(whole, &third_after, second, first_turn);
            [first, second, third]
        }))
    }

    /// First and third turn, given the second and where the third axis must point.
    fn outer_turns(
        &self,
        whole: &UnitQuaternion<f64>,
        third_after: &Vector3<f64>,
        second: f64,
        first_turn: Option<f64>,
    ) -> (f64, f64) {
        let tilt = rotation(&self.axes[1], second);
        let third_with = |first: f64| {
            let rest = tilt.inverse() * rotation(&self.axes[0], -first) * whole;
            2.0 * rest.imag().dot(&self.axes[2]).atan2(rest.w)
        };
        if self.axes[0].cross(third_after).norm() > ALIGNED {
            let first = angle_about(&self.axes[0], &(tilt * self.axes[2]), third_after);
            return (first, third_with(first));
        }
        let first = first_turn.unwrap_or_else(|| {
            let sense = self.axes[0].dot(third_after).signum();
            let sum = third_with(0.0);
            sense * 0.5 * (sum - std::f64::consts::TAU * (sum / std::f64::consts::TAU).round())
        });
        (first, third_with(first))
    }

    /// Dihedral angle (rad, 0..=π) at the second axis for which first and third axis are `opposite` (rad) apart.
    ///
    /// The half-angle formula of the spherical triangle; unlike the law of cosines it keeps its precision where axes align.
    fn dihedral(&self, opposite: f64) -> Option<f64> {
        let half = 0.5 * (self.sides[0] + self.sides[1] + opposite);
        let parts = [half - self.sides[0], half - self.sides[1], std::f64::consts::PI - half, half - opposite];
        if !parts.iter().all(|part| *part >= -SLACK) {
            return None;
        }
        let [a, b, c, d] = parts.map(|part| part.max(0.0).sin());
        Some(2.0 * (a * b).max(0.0).sqrt().atan2((c * d).max(0.0).sqrt()))
    }
}

/// Angle between two unit vectors (rad), precise also for small angles.
fn between(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}
