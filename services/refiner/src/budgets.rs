//! Work units that each kind of job may spend at a level.

use contract::{Composition, Job, Request, SearchOptions, WorkKind};
use model::Levels;

/// Budgets of a run, doubled from level to level.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Budgets<'a> {
    options: &'a SearchOptions,
    level: u32,
    expansions: u64,
}

impl<'a> Budgets<'a> {
    pub(crate) fn at(levels: &Levels, level: u32, options: &'a SearchOptions) -> Self {
        Self { options, level, expansions: u64::from(levels.expansions) }
    }

    /// A job with the budget of its kind.
    pub(crate) fn job(self, request: Request) -> Job {
        let units: u64 = match &request {
            Request::Placement(_) | Request::Hop(_) | Request::Samples(_) => 4_000_000,
            Request::Transition(_) => 200_000,
            Request::Blockers(_) | Request::GraspBlockers(_) => 10_000,
            Request::Piece(_) | Request::Mode(_) => 50_000,
            Request::Compose(job) => match job.composition {
                Composition::Drrt { .. } => self.expansions,
                // A repair is a small part of the whole: it should not cost what the whole may.
                Composition::Repair { .. } => self.expansions.div_ceil(8),
                Composition::CommitMode { .. }
                | Composition::Assemble { .. }
                | Composition::Synchronous { .. }
                | Composition::Passages { .. } => 4_000_000,
            },
        };
        let budget = capped(self.options, &request, units << self.level.min(16));
        Job { request, budget }
    }
}

/// No job may spend more than the whole run: it would only be later that the limit is seen to be exceeded.
pub(crate) fn capped(options: &SearchOptions, request: &Request, units: u64) -> u64 {
    let of_stage = options.limit(WorkKind::Stage(request.stage()));
    let of_drrt = if request.is_drrt() { options.limit(WorkKind::Drrt) } else { None };
    of_stage.into_iter().chain(of_drrt).fold(units, u64::min)
}
