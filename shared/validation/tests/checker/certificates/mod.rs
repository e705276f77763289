//! Rule V16: certificates that hold are accepted; wrong and exaggerated ones are not.

pub mod failure;
mod grasps;
mod order;
mod reach;

pub use failure::failure;

use model::Problem;
use plan::{Certificate, Failure, ResultKind};
use validation::{Rule, Violation, check_failure};

#[track_caller]
pub fn proven(problem: &Problem, certificate: &Certificate) {
    let verdict = check_failure(problem, &failure(problem, Some(certificate.clone())));
    assert_eq!(verdict, Ok(()));
}

/// Asserts that a certificate is refused, for a reason that contains `why`.
#[track_caller]
pub fn refused(problem: &Problem, certificate: &Certificate, why: &str) {
    let verdict = check_failure(problem, &failure(problem, Some(certificate.clone())));
    let violations: Vec<Violation> = verdict.expect_err("accepted");
    assert!(violations.iter().all(|violation| violation.rule == Rule::V16));
    let said = violations.iter().any(|violation| violation.message.contains(why));
    assert!(said, "expected `{why}`: {violations:?}");
}

/// Applies one change to a copy of a certificate that holds, and expects a refusal.
#[track_caller]
pub fn corrupt(problem: &Problem, certificate: &Certificate, why: &str, change: impl FnOnce(&mut Certificate)) {
    proven(problem, certificate);
    let mut certificate = certificate.clone();
    change(&mut certificate);
    refused(problem, &certificate, why);
}

/// Applies one change to a copy of the problem that a certificate holds of, and expects a refusal.
#[track_caller]
pub fn elsewhere(problem: &Problem, certificate: &Certificate, why: &str, change: impl FnOnce(&mut Problem)) {
    proven(problem, certificate);
    let mut problem = problem.clone();
    change(&mut problem);
    refused(&problem, certificate, why);
}

#[test]
fn only_a_result_that_is_called_proven_has_a_certificate() {
    let (problem, certificate) = order::too_large();
    let mut said = failure(&problem, None);
    assert!(check_failure(&problem, &said).is_err(), "proven without a certificate");
    for result in [ResultKind::SamplesExhausted, ResultKind::LimitReached] {
        said = Failure { result, ..failure(&problem, None) };
        assert_eq!(check_failure(&problem, &said), Ok(()));
        said.certificate = Some(certificate.clone());
        assert!(check_failure(&problem, &said).is_err(), "{result:?} with a certificate");
    }
    said = failure(&problem, Some(certificate));
    said.problem = "another".to_owned();
    assert!(check_failure(&problem, &said).is_err(), "of another problem");
}

#[test]
fn certificates_survive_the_file() {
    let (problem, certificate) = grasps::box_too_narrow();
    let said = failure(&problem, Some(certificate));
    let bytes = plan::write_failure(&said).expect("it can be written");
    assert_eq!(plan::read_failure(&bytes).expect("it can be read"), said);
}
