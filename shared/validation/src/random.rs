//! Random numbers, poses and bodies for tests, from SplitMix64.

use glamx::DVec3;
use model::{Body, Pose, Shape};
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion};

/// A stream of numbers fixed by its seed.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// In [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub(crate) fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }

    /// In a cube of half edge `reach`.
    pub(crate) fn vector(&mut self, reach: f64) -> [f64; 3] {
        [0; 3].map(|_| self.between(-reach, reach))
    }

    pub(crate) fn direction(&mut self) -> DVec3 {
        loop {
            let v = DVec3::from(self.vector(1.0));
            if (0.1..1.0).contains(&v.length()) {
                return v.normalize();
            }
        }
    }

    pub(crate) fn pose(&mut self, reach: f64) -> Pose {
        let [x, y, z] = self.vector(reach);
        let d = self.direction();
        let half = self.between(0.0, std::f64::consts::PI);
        let q = Quaternion::new(half.cos(), d.x * half.sin(), d.y * half.sin(), d.z * half.sin());
        Isometry3::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_quaternion(q))
    }

    /// Any of the five kinds, of about the given size (m).
    pub(crate) fn body(&mut self, size: f64) -> Body {
        let kind = self.below(5);
        let mut length = || self.between(0.2, 1.0) * size;
        let shape = match kind {
            0 => Shape::Box { size: [length(), length(), length()] },
            1 => Shape::Sphere { radius: length() / 2.0 },
            2 => Shape::Cylinder { radius: length() / 2.0, length: length() },
            3 => Shape::Capsule { radius: length() / 3.0, length: length() },
            _ => Shape::Hull { points: (0..12).map(|_| Point3::from(self.vector(size / 2.0))).collect() },
        };
        Body { owner_from_shape: self.pose(size / 2.0), shape }
    }
}
