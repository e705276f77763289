//! Why there is no plan.

use model::FailurePolicy;
use serde::{Deserialize, Serialize};

use crate::{Certificate, PairPoint, Provenance};

/// The whole of `failure.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Failure {
    /// Always [`crate::FAILURE_FORMAT`].
    pub format: String,
    /// Name of the problem.
    pub problem: String,
    /// How the search ended.
    pub result: ResultKind,
    /// What ended the search before it had tried everything; absent if nothing did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stopped_by: Option<StoppedBy>,
    /// Causes with how often each was met, most frequent first.
    pub causes: Vec<(Cause, u64)>,
    /// The proof, if the result is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub certificate: Option<Certificate>,
    /// Work of each stage.
    pub stages: Vec<StageCount>,
    /// How far the search came; absent if it did not begin.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reached: Option<Reached>,
    /// What it was made from.
    pub provenance: Provenance,
}

/// How a search without a plan ended. Failing to find samples is never called a proof.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ResultKind {
    /// Proven, with a certificate that the checker has verified.
    InfeasibleProven,
    /// All samples up to the highest level were tried.
    SamplesExhausted,
    /// A limit on time or work ended the run.
    LimitReached,
}

/// What ends a search before it has tried everything.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum StoppedBy {
    /// A stage failed whose policy is to stop then.
    Policy {
        /// Stage.
        stage: String,
        /// Its policy.
        policy: FailurePolicy,
    },
    /// A limit on work.
    WorkLimit {
        /// The stage whose work is limited, or `drrt`.
        of: String,
        /// The limit (work units).
        limit: u64,
        /// Work units that were spent when it was noticed.
        spent: u64,
    },
    /// A limit on time.
    TimeLimit {
        /// The limit (s).
        seconds: f64,
    },
    /// Somebody outside, by a signal.
    Signal,
}

/// How far a search came before it ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Reached {
    /// Sample level at which it ended.
    pub level: u32,
    /// Placement candidates taken up at that level, the last one included.
    pub candidates: u32,
    /// Modes committed under the last candidate when it ended.
    pub committed: u32,
}

/// Work of one stage.
#[derive(Clone, Debug, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StageCount {
    /// Stage.
    pub stage: String,
    /// Jobs answered.
    pub jobs: u64,
    /// Jobs answered with a failure.
    pub failures: u64,
    /// Work units spent.
    pub work: u64,
}

/// A body that takes part in a collision, by its names in the problem.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum BodyRef {
    /// A link of a robot.
    Link {
        /// Robot name.
        robot: String,
        /// Link name.
        link: String,
    },
    /// An object in a robot's hand.
    Held {
        /// Robot name.
        robot: String,
        /// Object name.
        object: String,
    },
    /// A fixed object.
    Fixed(String),
    /// A standing movable object.
    Object(String),
}

impl std::fmt::Display for BodyRef {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            BodyRef::Link { robot, link } => write!(f, "{link} of {robot}"),
            BodyRef::Held { robot, object } => write!(f, "{object} held by {robot}"),
            BodyRef::Fixed(name) => write!(f, "fixed {name}"),
            BodyRef::Object(name) => write!(f, "{name}"),
        }
    }
}

/// One reason why something cannot be, naming who is at fault. Names are those of the problem.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Cause {
    /// Two bodies would touch.
    Collision {
        /// One body.
        first: BodyRef,
        /// The other.
        second: BodyRef,
    },
    /// Two standing poses of a region exclude one another, so one must be gone before the other comes.
    Overlap {
        /// Region.
        region: String,
        /// Object that has to leave first.
        leaves: String,
        /// Object that comes afterwards.
        comes: String,
    },
    /// An object finds no free place in a region.
    NoPlacement {
        /// Object.
        object: String,
        /// Region.
        region: String,
    },
    /// Orderings that contradict one another, in order round the cycle.
    Cycle {
        /// Points round the cycle.
        points: Vec<PairPoint>,
    },
    /// No configuration of the robot reaches an object where it stands.
    Unreachable {
        /// Robot.
        robot: String,
        /// Pair.
        pair: String,
        /// Object.
        object: String,
        /// Region where it stands.
        region: String,
    },
    /// No grasp serves both ends of a pair.
    NoCommonGrasp {
        /// Pair.
        pair: String,
    },
    /// A mode's roadmap does not connect its start with its goal.
    NoPath {
        /// Pair; absent for a closing return.
        pair: Option<String>,
        /// Robot.
        robot: String,
        /// Bodies whose removal would connect it, as far as known.
        blocking: Vec<BodyRef>,
    },
    /// Robots block one another.
    Deadlock {
        /// Robots.
        robots: Vec<String>,
    },
    /// A work budget ended before an answer.
    Budget {
        /// Stage.
        stage: String,
    },
}
