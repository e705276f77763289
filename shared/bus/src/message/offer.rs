//! Refiner to workers: jobs, and which of them still count.

use contract::{Job, JobId};
use serde::{Deserialize, Serialize};

use crate::MemberId;

/// A job for one worker. The envelope has the job's identity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JobOffer {
    /// Number among the refiner's offers, from 1.
    pub number: u64,
    /// Whom it is for.
    pub to: MemberId,
    /// The search has not asked for it yet; what it has asked for goes first.
    pub speculative: bool,
    /// Its product was lost: it is to be published again, made anew if need be.
    pub afresh: bool,
    /// Job.
    pub job: Job,
}

/// Cancels offers: those up to a number, except the live ones.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Retirement {
    /// Number of the last offer that this covers.
    pub number: u64,
    /// Jobs that still count, ascending.
    pub live: Vec<JobId>,
}
