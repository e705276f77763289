//! Swept volumes of parts of motions.

use nalgebra::Point3;

/// Every body of a robot and its load at the middle of a part of a motion, with the radius by which it must be grown to
/// cover the whole part.
#[derive(Clone, Debug)]
pub struct Sweep {
    least: Point3<f64>,
    greatest: Point3<f64>,
}

impl Sweep {
    /// Least and greatest corner in the world, clearance included (m).
    #[must_use]
    pub fn bounds(&self) -> (Point3<f64>, Point3<f64>) {
        (self.least, self.greatest)
    }
}
