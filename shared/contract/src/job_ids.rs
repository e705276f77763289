//! Identities of the jobs of one statement, with the digests of what jobs read computed once.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use crate::scope::Scope;
use crate::{Digest, Job, JobId, ProblemStatement, encode_canonical};

/// Tells jobs their identities. A statement may be large; [`Job::id`] digests it anew for every job, this does not.
#[derive(Debug)]
pub struct JobIds {
    statement: Arc<ProblemStatement>,
    scopes: Mutex<BTreeMap<Scope, Digest>>,
}

impl JobIds {
    /// Identities of the jobs of `statement`.
    #[must_use]
    pub fn new(statement: Arc<ProblemStatement>) -> Self {
        Self { statement, scopes: Mutex::new(BTreeMap::new()) }
    }

    /// The identity of a job, equal to [`Job::id`]. `None`: it names a pair, robot or object that the problem does not
    /// have.
    #[must_use]
    pub fn of(&self, job: &Job) -> Option<JobId> {
        let scope = Scope::of(&self.statement.problem, &job.request)?;
        let digest = match self.scopes.lock() {
            Ok(mut scopes) => *scopes.entry(scope).or_insert_with(|| scope.digest(&self.statement.problem)),
            Err(_) => scope.digest(&self.statement.problem),
        };
        Some(job.id_in(&self.statement, Some(digest)))
    }
}

impl Job {
    pub(crate) fn id_in(&self, statement: &ProblemStatement, scope: Option<Digest>) -> JobId {
        let scope = scope.map_or([0; 32], |digest| digest.0);
        JobId(Digest::of(
            "mrtamp job",
            &[
                statement.implementation(self.stage()).as_bytes(),
                &statement.seed.to_le_bytes(),
                &scope,
                &encode_canonical(self),
            ],
        ))
    }
}
