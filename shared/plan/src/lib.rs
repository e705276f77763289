//! The result: timed trajectories, attach and detach events, orderings, dependency arcs; or, without a plan, the causes.
//!
//! `plan.json` has the format `mrtamp-plan/1`, `failure.json` the format `mrtamp-failure/1`. Both are written with a
//! fixed field order and shortest round-trip numbers, so equal values give equal bytes.

mod certificate;
mod dependency;
mod failure;
mod file;
mod ordering;
mod provenance;
mod trajectory;

pub use certificate::{
    BaseMap, Certificate, Cover, CycleArc, CycleOrigin, Disc, Distance, DistanceLimit, Exclusion, GraspReason, PairEnd,
    RefutedGrasp, Stay,
};
pub use dependency::{Dependency, KnotRef};
pub use failure::{BodyRef, Cause, Failure, Reached, ResultKind, StageCount, StoppedBy};
pub use file::{FAILURE_FORMAT, PLAN_FORMAT, PlanFileError, read_failure, read_plan, write_failure, write_plan};
pub use ordering::{Origin, PairPoint, PlanOrdering};
pub use provenance::{LowerBound, Makespan, Provenance, SearchRecord};
pub use skeleton::ModeKind;
pub use trajectory::{Event, EventKind, Knot, PoseRecord, RobotTrajectory, Segment, SegmentKind};

use serde::{Deserialize, Serialize};

/// A plan that every robot can execute on its own clock.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Always [`PLAN_FORMAT`].
    pub format: String,
    /// Name of the problem.
    pub problem: String,
    /// One trajectory for each robot, in the problem's order.
    pub robots: Vec<RobotTrajectory>,
    /// Attach and detach events in order of time.
    pub events: Vec<Event>,
    /// Orderings between pairs, given and discovered.
    pub orderings: Vec<PlanOrdering>,
    /// Arcs that keep every delayed execution safe: `after.robot` may leave its knot only once `before.robot` has reached its.
    pub dependencies: Vec<Dependency>,
    /// When the work, and when all motion, is over.
    pub makespan: Makespan,
    /// A bound below which no makespan (task) of this problem can be, with what it is a bound on.
    pub lower_bound: LowerBound,
    /// What it was made from.
    pub provenance: Provenance,
}
