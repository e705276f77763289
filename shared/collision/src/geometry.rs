//! Geometry of one problem, built once.

use std::sync::Arc;

use model::{FixedId, Problem, RobotId};

use crate::{AllowedContacts, Contact, Holding, Motion, Standing, Sweep};

/// Why no geometry could be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GeometryError {
    /// A shape has no volume or a size that is not finite.
    #[error("{owner}: {reason}")]
    Shape {
        /// Whose shape.
        owner: String,
        /// What is wrong with it.
        reason: String,
    },
}

/// Shapes, bounds and kinematic chains of a problem. Immutable; share it between threads as you like.
#[derive(Debug)]
pub struct Geometry {
    problem: Arc<Problem>,
}

impl Geometry {
    /// Prepares every shape of the problem.
    ///
    /// # Errors
    /// When a shape is degenerate.
    pub fn new(problem: &Problem) -> Result<Self, GeometryError> {
        Ok(Self { problem: Arc::new(problem.clone()) })
    }

    /// The problem it was built from.
    #[must_use]
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// Robot and load against the robot itself and the fixed objects at one configuration.
    #[must_use]
    pub fn state_contact(
        &self,
        _robot: RobotId,
        _holding: Option<Holding>,
        _q: &[f64],
        _allowed: AllowedContacts,
    ) -> Option<Contact> {
        todo!()
    }

    /// Robot and load against a standing object at one configuration.
    #[must_use]
    pub fn state_hits(
        &self,
        _robot: RobotId,
        _holding: Option<Holding>,
        _q: &[f64],
        _allowed: AllowedContacts,
        _standing: &Standing,
    ) -> Option<Contact> {
        todo!()
    }

    /// A whole straight motion, in continuous time, against the robot itself and the fixed objects.
    #[must_use]
    pub fn motion_contact(&self, _motion: &Motion) -> Option<Contact> {
        todo!()
    }

    /// A whole straight motion, in continuous time, against a standing object.
    #[must_use]
    pub fn motion_hits(&self, _motion: &Motion, _standing: &Standing) -> Option<Contact> {
        todo!()
    }

    /// A standing object against the fixed objects, except the bodies of `support` on whose top it stands.
    #[must_use]
    pub fn standing_contact(&self, _standing: &Standing, _support: Option<FixedId>) -> Option<Contact> {
        todo!()
    }

    /// Whether two standing objects are nearer than the clearance.
    #[must_use]
    pub fn standings_collide(&self, _a: &Standing, _b: &Standing) -> bool {
        todo!()
    }

    /// Number of equal cells (at least 1) into which a motion must be cut so that no point of the robot or its load
    /// moves further than `reach_m` (m) from where it is at the cell's middle.
    #[must_use]
    pub fn cells(&self, _motion: &Motion, _reach_m: f64) -> u32 {
        todo!()
    }

    /// Conservative swept volume of part `[cell/cells, (cell+1)/cells]` of a motion.
    #[must_use]
    pub fn sweep(&self, _motion: &Motion, _cell: u32, _cells: u32) -> Sweep {
        todo!()
    }

    /// Whether two robots could come nearer than the clearance when one is anywhere in one sweep and the other anywhere
    /// in the other. `false` is a proof.
    #[must_use]
    pub fn sweeps_conflict(&self, _a: &Sweep, _b: &Sweep) -> bool {
        todo!()
    }

    /// Whether a robot or its load could come nearer than the clearance to a standing object. `false` is a proof.
    #[must_use]
    pub fn sweep_hits(&self, _a: &Sweep, _standing: &Standing) -> bool {
        todo!()
    }
}
