//! The joint that sets the distance between shoulder and wrist.

use nalgebra::Point3;

use crate::line::{Line, angle_about};

/// Distance (m) by which a wrist may lie out of reach before it is refused.
const SLACK: f64 = 1e-10;

/// The elbow: shoulder and wrist seen along its axis.
#[derive(Clone, Debug)]
pub(crate) struct Elbow {
    /// The axis.
    pub line: Line,
    /// Distances (m) of shoulder and wrist centre from the axis.
    arms: [f64; 2],
    /// Distance (m) between shoulder and wrist centre along the axis.
    along: f64,
    /// Angle (rad) about the axis from shoulder to wrist centre where the joint's value is zero.
    phase: f64,
}

impl Elbow {
    /// The elbow between `shoulder` and `wrist`, given where all values are zero.
    pub fn new(line: Line, shoulder: &Point3<f64>, wrist: &Point3<f64>) -> Self {
        let (upper, lower) = (line.to(shoulder), line.to(wrist));
        Self {
            line,
            arms: [upper.norm(), lower.norm()],
            along: line.axis.dot(&(wrist - shoulder)),
            phase: angle_about(&line.axis, &upper, &lower),
        }
    }

    /// Least of the distances (m) of shoulder and wrist centre from the axis.
    pub fn least_arm(&self) -> f64 {
        self.arms[0].min(self.arms[1])
    }

    /// The joint's values (rad) that bring the wrist centre to `distance` (m) from the shoulder, that with the positive
    /// angle between the arms first; none if there is none.
    pub fn angles(&self, distance: f64) -> Option<[f64; 2]> {
        let [upper, lower] = self.arms;
        let across_squared = (distance - self.along) * (distance + self.along);
        if across_squared < -SLACK * distance {
            return None;
        }
        let across = across_squared.max(0.0).sqrt();
        let (folded, straight) = ((upper - lower).abs(), upper + lower);
        if !(across >= folded - SLACK && across <= straight + SLACK) {
            return None;
        }
        // Half-angle formula of the triangle: the law of cosines would lose half the digits at a straight elbow.
        let opposite = ((across - folded) * (across + folded)).max(0.0).sqrt();
        let adjacent = ((straight - across) * (straight + across)).max(0.0).sqrt();
        let angle = 2.0 * opposite.atan2(adjacent);
        Some([angle - self.phase, -angle - self.phase])
    }
}
