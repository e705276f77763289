//! What a plan or failure was made from, and what ended a search early.

use std::collections::BTreeMap;
use std::num::NonZeroU64;
use std::time::Duration;

use clap::ValueEnum;
use contract::{
    AskFault, CompositeMethod, Ledger, LedgerEntry, Merge, ProblemStatement, SearchOptions, StageKind, WorkKind,
};
use model::FailurePolicy;
use plan::{Provenance, ResultKind, SearchRecord, StoppedBy};
use refiner::End;

use crate::in_process::RunEnd;
use crate::plan_command::{Composite, MergedSteps};

/// What a plan or failure was made from.
#[must_use]
pub fn provenance(statement: &ProblemStatement, ledger: &Ledger) -> Provenance {
    Provenance {
        problem_digest: statement.problem_digest().hex(),
        seed: statement.seed,
        implementations: StageKind::ALL
            .into_iter()
            .map(|stage| format!("{stage} {}", statement.implementation(stage)))
            .collect(),
        search: search_record(statement.composite, &statement.options),
        ledger_digest: ledger.digest().hex(),
    }
}

/// What differs from the defaults.
fn search_record(composite: CompositeMethod, options: &SearchOptions) -> SearchRecord {
    let default = SearchOptions::default();
    let composite = Some(composite)
        .filter(|method| *method != CompositeMethod::default())
        .and_then(|method| Composite::value_variants().iter().find(|known| CompositeMethod::from(**known) == method));
    let merge = Some(options.merge).filter(|merge| *merge != default.merge);
    let merge =
        merge.and_then(|merge| MergedSteps::value_variants().iter().find(|known| Merge::from(**known) == merge));
    let policies = StageKind::ALL.map(|stage| (stage, options.policy(stage)));
    let policies = policies.into_iter().filter(|(_, policy)| *policy != FailurePolicy::default());
    let limited = StageKind::ALL.map(WorkKind::Stage).into_iter().chain([WorkKind::Drrt]);
    let limits = limited.filter_map(|work| Some((work.to_string(), NonZeroU64::new(options.limit(work)?)?)));
    SearchRecord {
        composite: composite.map(|method| method.name().to_owned()),
        merge: merge.map(|merge| merge.name().to_owned()),
        policy: policies.map(|(stage, policy)| (stage.name().to_owned(), policy)).collect(),
        limit: limits.collect::<BTreeMap<_, _>>(),
        candidates: Some(options.candidates).filter(|candidates| *candidates != default.candidates),
        composite_failures: Some(options.composite_failures).filter(|most| *most != default.composite_failures),
    }
}

/// What ended a search without a plan before it had tried everything.
#[must_use]
pub fn stopped_by(statement: &ProblemStatement, run: &RunEnd, time_limit: Option<Duration>) -> Option<StoppedBy> {
    match (run.refinement.ledger.entries.last(), &run.refinement.end) {
        (Some(LedgerEntry::Stopped { stage }), _) => {
            Some(StoppedBy::Policy { stage: stage.name().to_owned(), policy: statement.options.policy(*stage) })
        }
        (Some(LedgerEntry::LimitReached { work, spent }), _) => {
            let limit = statement.options.limit(*work)?;
            Some(StoppedBy::WorkLimit { of: work.to_string(), limit, spent: *spent })
        }
        (_, End::Fault(AskFault::Cancelled)) => Some(StoppedBy::Signal),
        (_, End::Fault(AskFault::TimeLimit) | End::Failed { result: ResultKind::LimitReached, .. }) => {
            time_limit.map(|limit| StoppedBy::TimeLimit { seconds: limit.as_secs_f64() })
        }
        _ => None,
    }
}
