//! Work units that each kind of job may spend at a level.

use contract::{Job, Request};
use model::Levels;

/// Budgets of a run, doubled from level to level.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Budgets {
    level: u32,
    expansions: u64,
}

impl Budgets {
    pub(crate) fn at(levels: &Levels, level: u32) -> Self {
        Self { level, expansions: u64::from(levels.expansions) }
    }

    /// A job with the budget of its kind.
    pub(crate) fn job(self, request: Request) -> Job {
        let units: u64 = match &request {
            Request::Placement(_) => 4_000_000,
            Request::Transition(_) => 200_000,
            Request::Blockers(_) => 10_000,
            Request::Piece(_) | Request::Mode(_) => 50_000,
            Request::Compose(job) => match job.composition {
                contract::Composition::Drrt { .. } => self.expansions,
                contract::Composition::CommitMode { .. } | contract::Composition::Assemble { .. } => 4_000_000,
            },
        };
        Job { request, budget: units << self.level.min(16) }
    }
}
