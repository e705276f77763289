//! What a worker remembers. Losing it costs time, never correctness.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;

use contract::{Digest, JobId, Outcome};

/// Answers kept.
const MAX_ANSWERS: usize = 1 << 16;
/// Bytes of products kept.
const MAX_PRODUCT_BYTES: usize = 512 << 20;

/// Answers given, so that a job that is offered twice is worked on once.
#[derive(Default)]
pub(crate) struct Answers {
    by_job: BTreeMap<JobId, Outcome>,
    oldest_first: VecDeque<JobId>,
}

impl Answers {
    pub(crate) fn get(&self, job: &JobId) -> Option<&Outcome> {
        self.by_job.get(job)
    }

    pub(crate) fn keep(&mut self, job: JobId, outcome: Outcome) {
        if self.by_job.insert(job, outcome).is_none() {
            self.oldest_first.push_back(job);
        }
        if self.oldest_first.len() > MAX_ANSWERS
            && let Some(oldest) = self.oldest_first.pop_front()
        {
            self.by_job.remove(&oldest);
        }
    }
}

/// Products made or received. What is dropped can be had again from the store.
#[derive(Default)]
pub(crate) struct ProductMemo {
    by_digest: BTreeMap<Digest, Arc<[u8]>>,
    oldest_first: VecDeque<Digest>,
    bytes: usize,
    absent: BTreeSet<Digest>,
}

impl ProductMemo {
    pub(crate) fn get(&self, digest: &Digest) -> Option<Arc<[u8]>> {
        self.by_digest.get(digest).cloned()
    }

    pub(crate) fn keep(&mut self, digest: Digest, bytes: Arc<[u8]>) {
        self.absent.remove(&digest);
        let added = bytes.len();
        if self.by_digest.insert(digest, bytes).is_none() {
            self.oldest_first.push_back(digest);
            self.bytes += added;
        }
        while self.bytes > MAX_PRODUCT_BYTES && self.oldest_first.len() > 1 {
            let dropped = self.oldest_first.pop_front().and_then(|oldest| self.by_digest.remove(&oldest));
            self.bytes -= dropped.map_or(0, |bytes| bytes.len());
        }
    }

    /// The store does not have it.
    pub(crate) fn set_absent(&mut self, digest: Digest) {
        self.absent.insert(digest);
    }

    /// Whether the store has said so since the last time of asking.
    pub(crate) fn take_absent(&mut self, digest: &Digest) -> bool {
        self.absent.remove(digest)
    }
}
