//! Rule V16: a failure that is called proven carries a certificate that holds.
//!
//! Everything is re-computed from the problem. What a certificate claims is accepted only if it is so, never because the
//! planner says it; where a computation is approximate, it errs on the side of plans.

use model::Problem;
use plan::{Failure, ResultKind};

use crate::violation::{Rule, Violation};

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
        (ResultKind::InfeasibleProven, Some(_)) => say("certificates of this kind are not verified".to_owned()),
        (_, Some(_)) => say("it carries a certificate, but is not called proven".to_owned()),
        (_, None) => Ok(()),
    }
}
