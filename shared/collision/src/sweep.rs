//! Swept volumes of parts of motions.

use model::{Configuration, RobotId};
use nalgebra::{Point3, Vector3};

use crate::mover::{Frame, Mover, Swept};
use crate::obstacle::Obstacle;
use crate::separation::{Need, balls_clear};
use crate::{AllowedContacts, Geometry, Holding, Motion, Standing};

/// Parts in which [`Geometry::cells`] bounds speeds.
const STRETCHES: u32 = 4;
/// Least reach (m) to which [`Geometry::cells`] cuts.
const LEAST_REACH: f64 = 1e-4;

/// Every body of a robot and its load at the middle of a part of a motion, with the radius by which it must be grown to
/// cover the whole part. It remembers the part, so that it can be cut finer.
#[derive(Clone, Debug)]
pub struct Sweep {
    pub(crate) robot: RobotId,
    pub(crate) holding: Option<Holding>,
    pub(crate) allowed: AllowedContacts,
    /// First configuration of the part.
    pub(crate) from: Configuration,
    /// Last configuration of the part.
    pub(crate) to: Configuration,
    pub(crate) bodies: Vec<Swept>,
    /// Half of the base's translation (m).
    pub(crate) drift: Vector3<f64>,
    least: Point3<f64>,
    greatest: Point3<f64>,
}

impl Sweep {
    /// Least and greatest corner in the world of everything swept, clearance included (m).
    #[must_use]
    pub fn bounds(&self) -> (Point3<f64>, Point3<f64>) {
        (self.least, self.greatest)
    }

    /// Whose motion it is a part of.
    #[must_use]
    pub fn robot(&self) -> RobotId {
        self.robot
    }

    /// The greatest radius (m) by which a body must be grown to cover the part.
    #[must_use]
    pub fn growth(&self) -> f64 {
        self.bodies.iter().fold(0.0, |most: f64, body| most.max(body.spread)) + self.drift.norm()
    }

    /// Whether it is a sweep of no motion, which could be anywhere.
    pub(crate) fn is_unbounded(&self) -> bool {
        self.least.x == f64::NEG_INFINITY
    }

    /// Whether its bounds and other bounds have nothing in common.
    pub(crate) fn is_apart(&self, least: &Vector3<f64>, greatest: &Vector3<f64>) -> bool {
        (0..3).any(|i| self.least[i] > greatest[i] || self.greatest[i] < least[i])
    }
}

impl Geometry {
    /// Number of equal cells (at least 1) into which a motion must be cut so that no point of the robot or its load
    /// moves further than `reach_m` (m, at least 0.1 mm) from where it is at its cell's middle.
    #[must_use]
    pub fn cells(&self, motion: &Motion, reach_m: f64) -> u32 {
        if motion.from == motion.to {
            return 1;
        }
        let mover = self.mover(motion.robot, motion.holding);
        let mut frame = Frame::default();
        let half = 0.5 / f64::from(STRETCHES);
        let mut most: f64 = 0.0;
        for i in 0..STRETCHES {
            mover.place(&motion.from, &motion.to, f64::from(2 * i + 1) * half, half, &mut frame);
            most = most.max(frame.pace + frame.drift.norm());
        }
        let cells = (f64::from(STRETCHES) * most / reach_m.max(LEAST_REACH) - 1e-9).ceil();
        if cells < f64::from(u32::MAX) { (cells as u32).max(1) } else { u32::MAX }
    }

    /// Conservative swept volume of part `[cell/cells, (cell+1)/cells]` of a motion.
    #[must_use]
    pub fn sweep(&self, motion: &Motion, cell: u32, cells: u32) -> Sweep {
        let share = |i: u32| f64::from(i) / f64::from(cells.max(1));
        let at = |s: f64| motion.from.iter().zip(&motion.to).map(|(a, b)| a + (b - a) * s).collect::<Configuration>();
        let mover = self.mover(motion.robot, motion.holding);
        self.sweep_between(&mover, motion.holding, motion.allowed, at(share(cell)), at(share(cell + 1)))
    }

    /// Swept volume of a straight motion.
    pub(crate) fn sweep_between(
        &self,
        mover: &Mover<'_>,
        holding: Option<Holding>,
        allowed: AllowedContacts,
        from: Configuration,
        to: Configuration,
    ) -> Sweep {
        let mut frame = Frame::default();
        mover.place(&from, &to, 0.5, 0.5, &mut frame);
        let (mut least, mut greatest) = (Vector3::repeat(f64::MAX), Vector3::repeat(f64::MIN));
        for (i, body) in frame.bodies.iter().enumerate() {
            let grown = frame.drift.abs().add_scalar(body.spread + self.clearance());
            let (low, high) = mover.solid(i).bounds(&body.placed);
            least = least.inf(&(low - grown));
            greatest = greatest.sup(&(high + grown));
        }
        if !frame.bodies.iter().all(|body| (body.placed.center.sum() + body.spread).is_finite()) {
            (least, greatest) = (Vector3::repeat(f64::NEG_INFINITY), Vector3::repeat(f64::INFINITY));
        }
        let (least, greatest) = (Point3::from(least), Point3::from(greatest));
        Sweep { robot: mover.id, holding, allowed, from, to, drift: frame.drift, bodies: frame.bodies, least, greatest }
    }

    /// Whether a robot or its load could come nearer than the clearance to a standing object anywhere in a part of a
    /// motion. `false` is a proof. The part's allowed contacts do not count.
    #[must_use]
    pub fn sweep_hits(&self, a: &Sweep, standing: &Standing) -> bool {
        let obstacle = self.obstacle(standing);
        if a.is_apart(&obstacle.least, &obstacle.greatest) || self.bodies_clear(a, &obstacle) {
            return false;
        }
        self.passage_hits(a.robot, a.holding, &a.from, &a.to, a.allowed, standing).is_some()
    }

    fn bodies_clear(&self, a: &Sweep, obstacle: &Obstacle) -> bool {
        let mover = self.mover(a.robot, a.holding);
        a.bodies.iter().enumerate().all(|(i, body)| {
            let need = Need::moving(self.clearance(), body.spread, [a.drift, Vector3::zeros()]);
            balls_clear((mover.solid(i), &body.placed), obstacle.posed(), &need)
        })
    }
}
