//! A failure that is called proven.

use model::Problem;
use plan::{Certificate, FAILURE_FORMAT, Failure, Provenance, ResultKind, SearchRecord};

pub fn failure(problem: &Problem, certificate: Option<Certificate>) -> Failure {
    Failure {
        format: FAILURE_FORMAT.to_owned(),
        problem: problem.name.clone(),
        result: ResultKind::InfeasibleProven,
        stopped_by: None,
        causes: Vec::new(),
        certificate,
        stages: Vec::new(),
        reached: None,
        provenance: provenance(),
    }
}

/// Of a plan or failure that no planner made.
pub fn provenance() -> Provenance {
    Provenance {
        problem_digest: String::new(),
        seed: 0,
        implementations: Vec::new(),
        search: SearchRecord::default(),
        ledger_digest: String::new(),
    }
}
