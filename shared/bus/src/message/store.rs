//! Members and the run's store: requests, and what was kept.

use contract::{Digest, JobId, Outcome};
use serde::{Deserialize, Serialize};

/// A request to the store.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Want {
    /// Bytes of a product.
    Product(Digest),
    /// All outcomes of the run so far: of a refiner that has just come, or come back.
    Outcomes,
}

/// A batch of the outcomes that the store had when it was asked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    /// Which batch, from 0.
    pub batch: u32,
    /// Number of batches.
    pub batches: u32,
    /// Outcomes.
    pub outcomes: Vec<(JobId, Outcome)>,
}
