//! Pages that show a plan, or why there is none: one file each that opens from disk and asks the network for nothing.

mod failure_data;
mod html;
mod plan_data;
mod point_times;
mod scene;

use model::Problem;
use plan::{Failure, Plan, StageCount};
use serde::Serialize;

use crate::playback::{Mismatch, Playback};

/// Why there is no page.
#[derive(Debug, thiserror::Error)]
pub enum PageError {
    /// The plan is not one of this problem.
    #[error(transparent)]
    Mismatch(#[from] Mismatch),
    /// A number that JSON cannot hold.
    #[error("the page's data cannot be written: {0}")]
    Unwritable(#[from] serde_json::Error),
}

/// What a page shows; the scripts read it as JSON.
#[derive(Serialize)]
struct PageData<'a> {
    problem: &'a str,
    version: &'static str,
    scene: scene::SceneData,
    #[serde(skip_serializing_if = "Option::is_none")]
    plan: Option<plan_data::PlanData>,
    #[serde(skip_serializing_if = "Option::is_none")]
    failure: Option<failure_data::FailureData>,
    /// Work of each stage, if known.
    stages: &'a [StageCount],
    /// What the checker has against the plan.
    violations: &'a [String],
    provenance: &'a plan::Provenance,
}

/// The page of a plan that has been checked, with what the checker has against it.
///
/// # Errors
/// When the plan is of another problem.
pub fn plan_page(
    problem: &Problem,
    plan: &Plan,
    stages: &[StageCount],
    violations: &[String],
) -> Result<String, PageError> {
    let playback = Playback::new(problem, plan)?;
    let data = PageData {
        problem: &plan.problem,
        version: env!("CARGO_PKG_VERSION"),
        scene: scene::SceneData::of(problem),
        plan: Some(plan_data::PlanData::of(&playback)),
        failure: None,
        stages,
        violations,
        provenance: &plan.provenance,
    };
    Ok(html::page(&format!("{}: plan", plan.problem), &serde_json::to_string(&data)?))
}

/// The page of a failure: the scene at the start, and what was in the way.
///
/// # Errors
/// A number that JSON cannot hold.
pub fn failure_page(problem: &Problem, failure: &Failure) -> Result<String, PageError> {
    let data = PageData {
        problem: &failure.problem,
        version: env!("CARGO_PKG_VERSION"),
        scene: scene::SceneData::of(problem),
        plan: None,
        failure: Some(failure_data::FailureData::of(problem, failure)),
        stages: &failure.stages,
        violations: &[],
        provenance: &failure.provenance,
    };
    Ok(html::page(&format!("{}: no plan", failure.problem), &serde_json::to_string(&data)?))
}

#[cfg(test)]
mod tests;
