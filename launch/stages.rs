//! The four stages that this program has of its own.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use contract::{Interrupted, Job, JobContext, Outcome, ProblemStatement, Stage, StageKind};

/// This program's own stage of a kind.
///
/// # Errors
/// Why the problem's geometry cannot be used.
pub fn own_stage(kind: StageKind, statement: &ProblemStatement) -> miette::Result<Box<dyn Stage>> {
    let unusable = |error: &dyn std::fmt::Display| miette::miette!("stage {kind} cannot be set up: {error}");
    Ok(match kind {
        StageKind::Placement => Box::new(placement::PlacementStage::new(statement).map_err(|error| unusable(&error))?),
        StageKind::Transition => {
            Box::new(transition::TransitionStage::new(statement).map_err(|error| unusable(&error))?)
        }
        StageKind::Roadmap => Box::new(roadmap::RoadmapStage::new(statement).map_err(|error| unusable(&error))?),
        StageKind::Composite => Box::new(composite::CompositeStage::new(statement).map_err(|error| unusable(&error))?),
    })
}

/// All four, timed.
///
/// # Errors
/// Why the problem's geometry cannot be used.
pub fn own_stages(
    statement: &ProblemStatement,
    busy: &BusyTimes,
) -> miette::Result<BTreeMap<StageKind, Box<dyn Stage>>> {
    let timed = |kind| {
        let stage: Box<dyn Stage> = Box::new(Timed { stage: own_stage(kind, statement)?, kind, busy: busy.clone() });
        Ok((kind, stage))
    };
    StageKind::ALL.into_iter().map(timed).collect()
}

/// Time that each stage has worked on jobs.
#[derive(Clone, Debug, Default)]
pub struct BusyTimes(Arc<[AtomicU64; 4]>);

impl BusyTimes {
    /// Adds to a stage's time.
    pub fn add_us(&self, kind: StageKind, us: u64) {
        self.0[kind as usize].fetch_add(us, Ordering::Relaxed);
    }

    /// A stage's time (s).
    #[must_use]
    pub fn seconds(&self, kind: StageKind) -> f64 {
        self.0[kind as usize].load(Ordering::Relaxed) as f64 / 1e6
    }
}

/// A stage whose time is measured.
pub struct Timed {
    /// Stage.
    pub stage: Box<dyn Stage>,
    /// Its kind.
    pub kind: StageKind,
    /// Where the time is added up.
    pub busy: BusyTimes,
}

impl Stage for Timed {
    fn refine(&self, job: &Job, context: &mut JobContext<'_>) -> Result<Outcome, Interrupted> {
        let started = Instant::now();
        let result = self.stage.refine(job, context);
        self.busy.add_us(self.kind, u64::try_from(started.elapsed().as_micros()).unwrap_or(u64::MAX));
        result
    }
}
