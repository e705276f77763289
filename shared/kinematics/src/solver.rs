//! Inverse kinematics for any robot.

use model::{Pose, Robot};
use std::f64::consts::TAU;

use crate::forward::world_from_root;
use crate::numeric::NumericArm;
use crate::reach::Reach;
use crate::srs::{SrsArm, greatest_difference};

/// The solver that fits a robot's arm.
#[derive(Clone, Debug)]
pub enum ArmSolver {
    /// Closed form.
    Srs(Box<SrsArm>),
    /// Damped least squares.
    Numeric(NumericArm),
}

impl ArmSolver {
    /// Closed form where the arm is of a known kind, else numeric.
    #[must_use]
    pub fn for_robot(robot: &Robot) -> Self {
        match SrsArm::recognise(robot) {
            Some(arm) => Self::Srs(Box::new(arm)),
            None => Self::Numeric(NumericArm::of(robot)),
        }
    }

    /// Arm configurations (coordinates after the base, within limits) that bring the end effector's parent link to
    /// `world_from_link` while the base stands at `base` (its leading coordinates; empty for a fixed base).
    ///
    /// `redundancy` in [0, 1) picks among the infinitely many: the swivel angle in turns where there is a closed form (then
    /// all branches, exact to 1e-9), else the seeds of the descent (then what was found, to 1e-6). Same arguments, same answer.
    #[must_use]
    pub fn solve(&self, robot: &Robot, base: &[f64], world_from_link: &Pose, redundancy: f64) -> Vec<Vec<f64>> {
        let root_from_link = world_from_root(robot, base).inverse() * world_from_link;
        match self {
            Self::Srs(arm) => arm.solve(&root_from_link, TAU * redundancy),
            Self::Numeric(arm) => arm.solve(&root_from_link, redundancy),
        }
    }

    /// The solution that continues `arm`: same swivel angle and nearest branch, or the descent from `arm`. None if there is
    /// none or a coordinate would change by more than `max_step` (rad or m).
    #[must_use]
    pub fn follow(
        &self,
        robot: &Robot,
        base: &[f64],
        world_from_link: &Pose,
        arm: &[f64],
        max_step: f64,
    ) -> Option<Vec<f64>> {
        let root_from_link = world_from_root(robot, base).inverse() * world_from_link;
        let next = match self {
            Self::Srs(solver) => solver.nearest(&root_from_link, arm),
            Self::Numeric(solver) => solver.nearest(&root_from_link, arm),
        }?;
        (greatest_difference(&next, arm) <= max_step).then_some(next)
    }

    /// How far the end effector's parent link is from the shoulder at least and at most: worked out at every call.
    #[must_use]
    pub fn reach(&self, robot: &Robot) -> Reach {
        Reach::of(robot)
    }
}
