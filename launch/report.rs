//! The result of a run in figures: for programs as JSON, for users as a summary.

use contract::StageKind;
use plan::{Cause, Origin, Plan, StageCount, StoppedBy};
use serde::Serialize;

use crate::in_process::RunEnd;
use crate::stages::BusyTimes;

/// The result for programs: the last line of JSON on stdout.
#[derive(Serialize)]
pub struct Report<'a> {
    /// Always `result`.
    pub event: &'static str,
    /// How the run ended.
    pub result: &'a str,
    /// Name of the problem.
    pub problem: &'a str,
    /// Seed.
    pub seed: u64,
    /// The file that was written.
    pub file: String,
    /// Since the start (s).
    pub elapsed_s: f64,
    /// The plan, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plan: Option<PlanFigures>,
    /// What ended the search before it had tried everything, if anything did.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stopped_by: Option<&'a StoppedBy>,
    /// Causes with counts, if there is none.
    pub causes: &'a [(Cause, u64)],
    /// Each stage.
    pub stages: Vec<StageFigures<'a>>,
}

/// A plan in figures.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct PlanFigures {
    task_s: f64,
    total_s: f64,
    lower_bound_s: f64,
    given: usize,
    discovered: usize,
    arcs: usize,
}

/// A stage's work and time.
#[derive(Serialize)]
pub struct StageFigures<'a> {
    #[serde(flatten)]
    count: &'a StageCount,
    busy_s: f64,
}

impl PlanFigures {
    /// Figures of a plan.
    #[must_use]
    pub fn of(plan: &Plan) -> Self {
        let of_origin = |wanted: Origin| plan.orderings.iter().filter(|ordering| ordering.origin == wanted).count();
        Self {
            task_s: plan.makespan.task_s,
            total_s: plan.makespan.total_s,
            lower_bound_s: plan.lower_bound.seconds,
            given: of_origin(Origin::Given),
            discovered: of_origin(Origin::Discovered),
            arcs: plan.dependencies.len(),
        }
    }
}

/// Work and time of each stage.
#[must_use]
pub fn stage_figures<'a>(stages: &'a [StageCount], busy: &BusyTimes) -> Vec<StageFigures<'a>> {
    let busy_s = |name: &str| StageKind::of_name(name).map_or(0.0, |kind| busy.seconds(kind));
    stages.iter().map(|count| StageFigures { count, busy_s: busy_s(&count.stage) }).collect()
}

/// The summary of a solved run.
#[must_use]
pub fn summary(plan: &Plan, figures: &PlanFigures, run: &RunEnd, elapsed_s: f64) -> String {
    let mut text = format!(
        "\nCertified plan of {} in {elapsed_s:.1} s\n  makespan     {:.2} s for the task, {:.2} s in all\n  lower bound  {:.2} s \
         ({})\n  orderings    {} given, {} discovered\n  arcs         {} between robots\n",
        plan.problem,
        figures.task_s,
        figures.total_s,
        figures.lower_bound_s,
        plan.lower_bound.kind,
        figures.given,
        figures.discovered,
        figures.arcs,
    );
    for ordering in plan.orderings.iter().filter(|ordering| ordering.origin == Origin::Discovered) {
        text += &format!("    {}\n", crate::words::ordering(ordering));
    }
    for StageFigures { count, busy_s } in stage_figures(&run.refinement.stages, &run.busy) {
        text += &format!(
            "  {:<11}  {busy_s:.2} s, {} jobs, {} failed, {} work units\n",
            count.stage, count.jobs, count.failures, count.work
        );
    }
    text
}
