//! The four stages that this program has of its own.

use std::collections::BTreeMap;

use contract::{ProblemStatement, Stage, StageKind};

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

/// All four.
///
/// # Errors
/// Why the problem's geometry cannot be used.
pub fn own_stages(statement: &ProblemStatement) -> miette::Result<BTreeMap<StageKind, Box<dyn Stage>>> {
    StageKind::ALL.into_iter().map(|kind| Ok((kind, own_stage(kind, statement)?))).collect()
}
