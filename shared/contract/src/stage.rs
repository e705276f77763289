//! The contract of a stage.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use serde::{Deserialize, Serialize};

use crate::{Digest, Job, JobId, Outcome, Product, ProductRef, Products, decode, encode};

/// The paper's four steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StageKind {
    /// Poses of objects (Sec. III-B).
    Placement,
    /// Grasps and transition configurations (Sec. III-C).
    Transition,
    /// Roadmaps of single robots (Sec. III-D).
    Roadmap,
    /// Composite motion (Sec. III-E).
    Composite,
}

impl StageKind {
    /// All stages in the paper's order.
    pub const ALL: [StageKind; 4] =
        [StageKind::Placement, StageKind::Transition, StageKind::Roadmap, StageKind::Composite];

    /// Name as in topics, files and messages.
    #[must_use]
    pub fn name(self) -> &'static str {
        ["placement", "transition", "roadmap", "composite"][self as usize]
    }

    /// The stage of that name.
    #[must_use]
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|stage| stage.name() == name)
    }
}

impl std::fmt::Display for StageKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// One step of plan refinement: a pure function of its job. Memory of a stage is only a memo.
pub trait Stage: Send {
    /// Answers a job.
    ///
    /// # Errors
    /// [`Interrupted`], which is no answer: the job was cancelled, lacks a product, or is not this stage's.
    fn refine(&self, job: &Job, context: &mut JobContext<'_>) -> Result<Outcome, Interrupted>;
}

/// Why a job has no outcome.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
pub enum Interrupted {
    /// Nobody wants the answer any more.
    #[error("cancelled")]
    Cancelled,
    /// A product can be had nowhere; its maker has to be asked again.
    #[error("lacks product {0:?}")]
    Lacking(ProductRef),
    /// The job cannot be worked on: not this stage's, out of range, or a product of the wrong kind.
    #[error("unfit job: {0}")]
    Unfit(String),
}

/// What a stage may see and do while it works on one job.
pub struct JobContext<'a> {
    id: JobId,
    budget: u64,
    spent: u64,
    products: &'a dyn Products,
    cancelled: Arc<AtomicBool>,
}

impl<'a> JobContext<'a> {
    /// The context of one job.
    #[must_use]
    pub fn new(id: JobId, job: &Job, products: &'a dyn Products, cancelled: Arc<AtomicBool>) -> Self {
        Self { id, budget: job.budget, spent: 0, products, cancelled }
    }

    /// Identity of the job.
    #[must_use]
    pub fn id(&self) -> JobId {
        self.id
    }

    /// Work units spent so far.
    #[must_use]
    pub fn spent(&self) -> u64 {
        self.spent
    }

    /// Work units that may still be spent.
    #[must_use]
    pub fn left(&self) -> u64 {
        self.budget.saturating_sub(self.spent)
    }

    /// Spends work units. `false`: the budget is used up, and the stage must come to its end with what it has.
    ///
    /// # Errors
    /// [`Interrupted::Cancelled`].
    pub fn spend(&mut self, units: u64) -> Result<bool, Interrupted> {
        if self.cancelled.load(Ordering::Relaxed) {
            return Err(Interrupted::Cancelled);
        }
        self.spent = self.spent.saturating_add(units);
        Ok(self.spent <= self.budget)
    }

    /// A product that the job names.
    ///
    /// # Errors
    /// [`Interrupted::Lacking`], or [`Interrupted::Unfit`] if its bytes are no product.
    pub fn product(&self, wanted: &ProductRef) -> Result<Product, Interrupted> {
        let bytes = self.products.get(&wanted.digest).ok_or(Interrupted::Lacking(*wanted))?;
        decode(&bytes).map_err(|error| Interrupted::Unfit(format!("product {:?}: {error}", wanted.digest)))
    }

    /// Publishes a product, before the outcome that names it.
    ///
    /// # Errors
    /// [`Interrupted::Unfit`] if it is too large to be a message.
    pub fn publish(&self, product: &Product) -> Result<ProductRef, Interrupted> {
        let bytes = encode(product).map_err(|error| Interrupted::Unfit(error.to_string()))?;
        let digest: Digest = self.products.put(bytes);
        Ok(ProductRef { digest, made_by: self.id })
    }
}
