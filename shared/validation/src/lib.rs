//! Independent checker of a finished plan.
//!
//! It shares no kinematics and no geometry with the planner: forward kinematics is written from the model, shapes are exact
//! (a mesh is its convex hull), distances come from parry and are proven by separating axes, and continuous time is covered
//! by bounds on motion and bisection. What it accepts holds at every instant, not at samples.
//!
//! [`Rule::V16`] is for failures, all others are for plans. Geometry (V11, V12) is examined only where the plan is well formed
//! and its events make sense (V1, V5, V8), V15 only where nothing else is wrong.

mod actor;
mod clearance;
mod contact;
mod dependency;
mod frame;
mod goal;
mod infeasible;
mod irredundant;
mod limits;
mod mechanism;
mod ordering;
mod points;
mod precedence;
#[cfg(test)]
mod random;
mod removal;
mod script;
mod section;
mod solid;
mod surroundings;
mod sweep;
mod timeline;
mod track;
mod violation;
mod windows;

pub use dependency::delayed_execution;
pub use infeasible::check_failure;
pub use violation::{LeastClearance, Rule, Verdict, Violation};

use model::Problem;
use plan::Plan;

use points::Points;
use script::Script;
use timeline::Timeline;

/// Checks a plan against its problem.
///
/// # Errors
/// Every broken rule that was found, at least one; in order of the rules.
pub fn check_plan(problem: &Problem, plan: &Plan) -> Result<Verdict, Vec<Violation>> {
    let script = Script::read(problem, plan)?;
    let (mut wrong, mut verdict) = (Vec::new(), Verdict::default());
    limits::check(&script, &mut wrong);
    dependency::check(plan, &mut wrong);
    if let Some(timeline) = Timeline::build(&script, &mut wrong) {
        let points = Points::compute(&script, &mut wrong);
        contact::check(&script, &timeline, &mut wrong);
        ordering::check(&script, &points, &mut wrong);
        removal::check(&script, &timeline, &mut wrong);
        goal::check_goal(&script, &timeline, &mut wrong);
        goal::check_makespan(&script, &points, &mut wrong);
        clearance::check(&script, &timeline, &mut verdict, &mut wrong);
        if wrong.is_empty() {
            irredundant::check(&script, &timeline, &points, &mut wrong);
        }
    }
    wrong.sort_by_key(|violation| violation.rule);
    if wrong.is_empty() { Ok(verdict) } else { Err(wrong) }
}
