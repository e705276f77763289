//! Replay files: a job that killed its workers, with everything that it reads.

use bus::Store;
use contract::{Job, ProblemStatement};
use serde::{Deserialize, Serialize};

/// All that is needed to work on one job again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Replay {
    /// Statement of the run.
    pub statement: ProblemStatement,
    /// Job.
    pub job: Job,
    /// Bytes of the products that it reads.
    pub products: Vec<Vec<u8>>,
}

impl Replay {
    /// The replay of a job of a run.
    #[must_use]
    pub fn of_run(statement: &ProblemStatement, job: &Job, store: &Store) -> Self {
        let products = store.products_of(job).into_values().map(|bytes| bytes.to_vec()).collect();
        Self { statement: statement.clone(), job: job.clone(), products }
    }
}
