//! Inverse kinematics of any chain by damped least squares from many seeds.

use model::{Pose, Robot};
use std::f64::consts::PI;

use crate::descent::descend;
use crate::reach::Reach;
use crate::serial::SerialChain;
use crate::srs::greatest_difference;

/// Seeds per value of the redundancy parameter.
const SEEDS: usize = 4;
/// Greatest number of steps from one seed.
const STEPS: usize = 60;
/// Greatest error (m or rad) of a solution.
const TOLERANCE: f64 = 1e-6;
/// Difference (rad or m) below which two solutions are the same.
const SAME: f64 = 1e-4;

/// A chain of any joints, also mimicking ones.
#[derive(Clone, Debug)]
pub struct NumericArm {
    chain: SerialChain,
    reach: Reach,
}

impl NumericArm {
    /// The chain that carries the robot's end effector.
    #[must_use]
    pub fn of(robot: &Robot) -> Self {
        Self { chain: SerialChain::of(robot), reach: Reach::of(robot) }
    }

    /// Solutions (coordinates after the base, within limits, 1e-6 m and rad) found from the seeds that `redundancy` in
    /// [0, 1) stands for, in the seeds' order. Finding none does not mean that there is none.
    #[must_use]
    pub fn solve(&self, root_from_link: &Pose, redundancy: f64) -> Vec<Vec<f64>> {
        let mut found: Vec<Vec<f64>> = Vec::new();
        if !redundancy.is_finite() || !self.reach.contains(root_from_link) {
            return found;
        }
        for attempt in 0..SEEDS {
            let mut arm = self.seed(redundancy, attempt);
            let fits = descend(&self.chain, root_from_link, &mut arm, STEPS) <= TOLERANCE;
            self.unwind(&mut arm);
            if fits && found.iter().all(|other| greatest_difference(other, &arm) > SAME) {
                found.push(arm);
            }
        }
        found
    }

    /// The solution downhill from `arm`.
    #[must_use]
    pub fn nearest(&self, root_from_link: &Pose, arm: &[f64]) -> Option<Vec<f64>> {
        let mut arm = arm.to_vec();
        let left = descend(&self.chain, root_from_link, &mut arm, STEPS);
        (left <= TOLERANCE).then_some(arm)
    }

    /// A point within the limits: a Weyl sequence over (redundancy, attempt), the square roots of primes its generators.
    fn seed(&self, redundancy: f64, attempt: usize) -> Vec<f64> {
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        let place = 1009.0 * redundancy + GOLDEN * attempt as f64;
        let mut arm = self.chain.rest.clone();
        let primes = (2_u32..).filter(|n| (2..*n).take_while(|d| d * d <= *n).all(|d| n % d != 0));
        for (joint, prime) in self.chain.joints.iter().zip(primes) {
            let fraction = (0.5 + place * f64::from(prime).sqrt()).fract();
            let unlimited = if joint.turns { PI } else { 1.0 };
            arm[joint.index] = self.chain.ranges[joint.index].at(fraction, unlimited);
        }
        arm
    }

    /// Takes whole turns off, as far as the limits allow.
    fn unwind(&self, arm: &mut [f64]) {
        for joint in self.chain.joints.iter().filter(|joint| joint.turns && joint.scale == 1.0) {
            let x = &mut arm[joint.index];
            *x = self.chain.ranges[joint.index].nearest_turn(*x, 0.0).unwrap_or(*x);
        }
    }
}
