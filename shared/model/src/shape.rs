//! Convex shapes and bodies. A mesh means its convex hull, for planner and checker alike.

use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use crate::Pose;

/// A convex shape about its own origin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Shape {
    /// Box with full edge lengths `size` (m).
    Box {
        /// Edge lengths along x, y, z (m).
        size: [f64; 3],
    },
    /// Sphere (m).
    Sphere {
        /// Radius (m).
        radius: f64,
    },
    /// Cylinder along z, centred (m).
    Cylinder {
        /// Radius (m).
        radius: f64,
        /// Full length along z (m).
        length: f64,
    },
    /// Capsule along z, centred; `length` is that of the cylindrical part (m).
    Capsule {
        /// Radius (m).
        radius: f64,
        /// Length of the cylindrical part along z (m).
        length: f64,
    },
    /// Convex hull of points that span a volume (m).
    Hull {
        /// Points whose hull is meant.
        points: Vec<Point3<f64>>,
    },
}

impl Shape {
    /// Axis-aligned bounds in the shape's own frame: least and greatest corner (m).
    #[must_use]
    pub fn bounds(&self) -> (Point3<f64>, Point3<f64>) {
        let symmetric = |x: f64, y: f64, z: f64| (Point3::new(-x, -y, -z), Point3::new(x, y, z));
        match self {
            Shape::Box { size: [x, y, z] } => symmetric(x / 2.0, y / 2.0, z / 2.0),
            Shape::Sphere { radius } => symmetric(*radius, *radius, *radius),
            Shape::Cylinder { radius, length } => symmetric(*radius, *radius, length / 2.0),
            Shape::Capsule { radius, length } => symmetric(*radius, *radius, length / 2.0 + radius),
            Shape::Hull { points } => {
                points.iter().fold((Point3::from([f64::MAX; 3]), Point3::from([f64::MIN; 3])), |(low, high), p| {
                    (low.inf(p), high.sup(p))
                })
            }
        }
    }

    /// Points whose convex hull, grown by [`Shape::rounding`], contains the shape (m). Used for bounds on motion and extent.
    #[must_use]
    pub fn support_points(&self) -> Vec<Point3<f64>> {
        match self {
            Shape::Sphere { .. } => vec![Point3::origin()],
            Shape::Capsule { length, .. } => {
                vec![Point3::new(0.0, 0.0, -length / 2.0), Point3::new(0.0, 0.0, length / 2.0)]
            }
            Shape::Hull { points } => points.clone(),
            Shape::Box { .. } | Shape::Cylinder { .. } => {
                let (low, high) = self.bounds();
                let pick = |high_side: usize, axis: usize| if high_side == 1 { high[axis] } else { low[axis] };
                (0..8).map(|i| Point3::new(pick(i & 1, 0), pick(i >> 1 & 1, 1), pick(i >> 2 & 1, 2))).collect()
            }
        }
    }

    /// Radius by which the hull of [`Shape::support_points`] is grown (m).
    #[must_use]
    pub fn rounding(&self) -> f64 {
        match self {
            Shape::Sphere { radius } | Shape::Capsule { radius, .. } => *radius,
            _ => 0.0,
        }
    }
}

/// A named shape placed in the frame of its owner (a link, a fixed object, a movable object).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// Takes the shape's own frame to the owner's.
    pub owner_from_shape: Pose,
    /// The shape.
    pub shape: Shape,
}
