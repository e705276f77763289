//! Rule V16: a failure that is called proven carries a certificate that holds.
//!
//! Everything is re-computed from the problem. What a certificate claims is accepted only if it is so, never because the
//! planner says it; where a computation is approximate, it errs on the side of plans. What is proven is that no plan can
//! keep rules V1 to V13, their tolerances included.

mod arm;
mod cover;
mod named;
mod order;
mod places;
mod reach;
mod room;
mod targets;
mod wedge;

use model::{Grasp, Problem};
use plan::{Certificate, Failure, GraspReason, RefutedGrasp, ResultKind};

use crate::violation::{Rule, Violation};
use named::PairAt;

/// Checks a failure against its problem: a result that is called proven must have a certificate, and the certificate must
/// prove it. Other results claim nothing that could be checked, and must not carry one.
///
/// # Errors
/// What is wrong with it, at least one violation of [`Rule::V16`].
pub fn check_failure(problem: &Problem, failure: &Failure) -> Result<(), Vec<Violation>> {
    let say = |message: String| Err(vec![Violation::new(Rule::V16, message)]);
    if failure.problem != problem.name {
        return say(format!("the failure is of problem `{}`, not `{}`", failure.problem, problem.name));
    }
    match (failure.result, &failure.certificate) {
        (ResultKind::InfeasibleProven, None) => say("it is called proven, without a certificate".to_owned()),
        (ResultKind::InfeasibleProven, Some(certificate)) => check(problem, certificate).or_else(say),
        (_, Some(_)) => say("it carries a certificate, but is not called proven".to_owned()),
        (_, None) => Ok(()),
    }
}

fn check(problem: &Problem, certificate: &Certificate) -> Result<(), String> {
    match certificate {
        Certificate::Cycle { exclusions, cycles } => order::check_cycles(problem, exclusions, cycles),
        Certificate::Area { region, region_area_m2, stays, together } => {
            order::check_area(problem, region, *region_area_m2, stays, together)
        }
        Certificate::ObjectTooLarge { object, region } => check_too_large(problem, object, region),
        Certificate::Reach { robot, pair, end, region, distance, map } => {
            let at = PairAt::in_region(problem, robot, pair, *end, region)?;
            reach::check_distance(problem, &at, reach::grasps(problem, &at).iter(), distance, map.as_ref())
        }
        Certificate::NoCommonGrasp { robot, pair, grasps } => check_grasps(problem, robot, pair, grasps),
        Certificate::BaseDisconnected { robot, pair, end, region, from_m, shoulder_m, greatest_m, map } => {
            let at = PairAt::in_region(problem, robot, pair, *end, region)?;
            reach::check_disconnected(problem, &at, *from_m, *shoulder_m, *greatest_m, map)
        }
    }
}

fn check_too_large(problem: &Problem, object: &str, region: &str) -> Result<(), String> {
    let (object, region) = (named::object(problem, object)?, named::region(problem, region)?);
    if !problem.pairs.iter().any(|pair| (pair.object, pair.to) == (object, region)) {
        return Err("nobody brings the object there".to_owned());
    }
    room::check_too_large(problem, object.index(), region)
}

fn check_grasps(problem: &Problem, robot: &str, pair: &str, refuted: &[RefutedGrasp]) -> Result<(), String> {
    let pick = PairAt::of(problem, robot, pair, plan::PairEnd::Pick)?;
    let grasps = reach::grasps(problem, &pick);
    if !refuted.iter().map(|grasp| grasp.grasp as usize).eq(0..grasps.len()) {
        return Err(format!("the {} grasps of {pair} are not refuted one by one", grasps.len()));
    }
    for (refuted, grasp) in refuted.iter().zip(grasps) {
        let at = PairAt::of(problem, robot, pair, refuted.end)?;
        check_grasp(problem, &at, grasp, &refuted.reason).map_err(|why| format!("grasp {}: {why}", refuted.grasp))?;
    }
    Ok(())
}

fn check_grasp(problem: &Problem, at: &PairAt, grasp: &Grasp, reason: &GraspReason) -> Result<(), String> {
    match reason {
        GraspReason::OutOfReach { distance, map } => {
            reach::check_distance(problem, at, std::iter::once(grasp), distance, map.as_ref())
        }
        GraspReason::Blocked { by } => {
            let by = by.iter().map(|name| named::fixed(problem, name)).collect::<Result<Vec<_>, _>>()?;
            cover::check_blocked(problem, at, grasp, &by)
        }
    }
}
