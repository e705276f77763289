//! What the supervisor keeps of a run: outcomes and products.

use std::collections::BTreeMap;
use std::sync::Arc;

use contract::{Digest, Job, JobId, Outcome, Product, decode};

use crate::Kept;

/// Outcomes in a batch for a refiner that comes back.
const BATCH: usize = 256;

/// Outcomes and products of a run.
#[derive(Default)]
pub struct Store {
    outcomes: BTreeMap<JobId, Outcome>,
    products: BTreeMap<Digest, Arc<[u8]>>,
}

impl Store {
    /// Keeps the first outcome of a job. `false`: a different one is kept already.
    pub(crate) fn keep_outcome(&mut self, job: JobId, outcome: &Outcome) -> bool {
        self.outcomes.entry(job).or_insert_with(|| outcome.clone()) == outcome
    }

    pub(crate) fn keep_product(&mut self, bytes: Arc<[u8]>) {
        self.products.entry(Digest::of_product(&bytes)).or_insert(bytes);
    }

    /// Bytes of a product.
    #[must_use]
    pub fn product(&self, digest: &Digest) -> Option<Arc<[u8]>> {
        self.products.get(digest).cloned()
    }

    /// Number of outcomes.
    #[must_use]
    pub fn outcome_count(&self) -> usize {
        self.outcomes.len()
    }

    /// All outcomes, in batches; at least one batch.
    pub(crate) fn batches(&self) -> Vec<Kept> {
        let all: Vec<(JobId, Outcome)> = self.outcomes.iter().map(|(job, outcome)| (*job, outcome.clone())).collect();
        let batches = all.len().div_ceil(BATCH).max(1);
        let counted = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        (0..batches)
            .map(|batch| Kept {
                batch: counted(batch),
                batches: counted(batches),
                outcomes: all[batch * BATCH..all.len().min((batch + 1) * BATCH)].to_vec(),
            })
            .collect()
    }

    /// The products that a job reads, with those that these build on, as far as they are kept.
    #[must_use]
    pub fn products_of(&self, job: &Job) -> BTreeMap<Digest, Arc<[u8]>> {
        let mut found = BTreeMap::new();
        let mut open: Vec<Digest> = job.products().into_iter().map(|product| product.digest).collect();
        while let Some(digest) = open.pop() {
            let Some(bytes) = self.products.get(&digest).filter(|_| !found.contains_key(&digest)) else { continue };
            if let Ok(Product::Prefix(prefix)) = decode::<Product>(bytes) {
                open.extend(prefix.parent.map(|parent| parent.digest));
            }
            found.insert(digest, bytes.clone());
        }
        found
    }
}
