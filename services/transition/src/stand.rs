//! Stands: where the base may be while the hand is at an object.

use contract::{RandomStream, halton};
use kinematics::Reach;
use model::{Pose, Robot};

/// Stands for a hand target, by sample index: a ring round the target within reach, facing it within `facing` (rad).
///
/// A Halton sequence with a keyed shift (Cranley and Patterson, doi:10.1137/0713071), uniform over the ring's area.
pub(crate) struct StandSampler<'a> {
    robot: &'a Robot,
    centre: [f64; 2],
    inner: f64,
    outer: f64,
    facing: f64,
    shift: [f64; 3],
}

impl<'a> StandSampler<'a> {
    /// The ring for one pose of the end effector's parent link. `None`: it is out of reach at every stand.
    pub(crate) fn new(
        robot: &'a Robot,
        reach: &Reach,
        world_from_link: &Pose,
        facing: f64,
        random: &RandomStream,
    ) -> Option<Self> {
        let base_from_link = robot.world_from_base.inverse() * world_from_link;
        let up = base_from_link.translation.z - reach.root_from_shoulder.z;
        let offset = reach.root_from_shoulder.x.hypot(reach.root_from_shoulder.y);
        let flat = |distance: f64| (distance * distance - up * up).max(0.0).sqrt();
        if reach.greatest < up.abs() {
            return None;
        }
        let target = base_from_link.translation.vector;
        Some(Self {
            robot,
            centre: [target.x, target.y],
            inner: (flat(reach.least) - offset).max(0.0),
            outer: flat(reach.greatest) + offset,
            facing,
            shift: random.unit(0),
        })
    }

    /// Base coordinates of sample `index`, in the base's own frame; `None` where its limits exclude it.
    pub(crate) fn stand(&self, index: u64) -> Option<Vec<f64>> {
        let u: [f64; 3] = [2, 3, 5].map(|base| halton(index, base));
        let [around, out, turn] = std::array::from_fn(|i| (u[i] + self.shift[i]).fract());
        let angle = std::f64::consts::TAU * around;
        let radius = (self.inner.powi(2) + out * (self.outer.powi(2) - self.inner.powi(2))).sqrt();
        let (x, y) = (self.centre[0] + radius * angle.cos(), self.centre[1] + radius * angle.sin());
        let yaw = angle + std::f64::consts::PI + self.facing * (2.0 * turn - 1.0);
        let yaw = yaw.sin().atan2(yaw.cos());
        let within =
            |i: usize, value: f64| (self.robot.coordinates[i].lower..=self.robot.coordinates[i].upper).contains(&value);
        (within(0, x) && within(1, y)).then(|| vec![x, y, yaw])
    }
}
