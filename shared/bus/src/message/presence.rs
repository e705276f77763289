//! Who is there: members to supervisor and refiner, and supervisor to refiner.

use contract::{Digest, JobId, StageKind};
use model::RobotId;
use serde::{Deserialize, Serialize};

use crate::{MemberId, Role};

/// A member introduces itself: when it has joined, when it has got the statement, and now and then.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hello {
    /// Name for people, such as `roadmap.r1`.
    pub name: String,
    /// What it does.
    pub role: Role,
    /// The robot whose jobs it is there for; none: any.
    pub robot: Option<RobotId>,
    /// `name/version` of what it runs.
    pub implementation: String,
    /// Contract version that it speaks.
    pub contract_version: u32,
    /// Digest of the statement that it works from, once it has one.
    pub statement: Option<Digest>,
}

/// A member is alive.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Heartbeat {
    /// Who it is.
    pub hello: Hello,
    /// Jobs that it has taken and not answered.
    pub held: Vec<JobId>,
    /// Jobs answered so far.
    pub done: u64,
}

/// A member has gone; said by the supervisor, who knows.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Gone {
    /// Who.
    pub member: MemberId,
    /// Its stage, if it was a worker.
    pub stage: Option<StageKind>,
    /// Workers of that stage that are left or will come.
    pub left: u32,
    /// The job that it died on, and how many have died on that job so far.
    pub died_on: Option<(JobId, u32)>,
}
