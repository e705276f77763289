//! Limits of a coordinate.

use std::f64::consts::TAU;

/// Rounding (rad or m) by which a value may pass a limit before it is set to the limit.
const SLACK: f64 = 1e-10;

/// Least and greatest value of a coordinate (rad or m); infinite where there is no limit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Range {
    pub lower: f64,
    pub upper: f64,
}

impl Range {
    /// The angle within the limits that equals `angle` up to whole turns and is nearest to `near` (rad).
    pub fn nearest_turn(&self, angle: f64, near: f64) -> Option<f64> {
        let (lower, upper) = (self.lower - SLACK, self.upper + SLACK);
        let mut value = angle + TAU * ((near - angle) / TAU).round();
        if value > upper {
            value -= TAU * ((value - upper) / TAU).ceil();
        } else if value < lower {
            value += TAU * ((lower - value) / TAU).ceil();
        }
        (value >= lower && value <= upper).then(|| self.nearest(value))
    }

    /// The value within the limits nearest to `value`.
    pub fn nearest(&self, value: f64) -> f64 {
        value.max(self.lower).min(self.upper)
    }

    /// The value at `fraction` of the range; where a side is unlimited, of `reach` on either side of zero.
    pub fn at(&self, fraction: f64, reach: f64) -> f64 {
        let lower = if self.lower.is_finite() { self.lower } else { self.upper.min(reach) - 2.0 * reach };
        let upper = if self.upper.is_finite() { self.upper } else { lower + 2.0 * reach };
        lower + fraction * (upper - lower)
    }
}
