//! Limits on work end a run at the same place every time, and what is known is kept.

use std::num::NonZeroU64;

use contract::{LedgerEntry, ProblemStatement, Request, StageKind, WorkKind};
use model::WorkLimits;
use plan::{Cause, ResultKind};
use refiner::{End, Refinement};

use crate::scripted::{Rule, Scripted, fails, no_path, relay, transfer_fails_with};
use contract::Soundness;

const KINDS: [WorkKind; 5] = [
    WorkKind::Stage(StageKind::Placement),
    WorkKind::Stage(StageKind::Transition),
    WorkKind::Stage(StageKind::Roadmap),
    WorkKind::Stage(StageKind::Composite),
    WorkKind::Drrt,
];

/// A run in which every stage fails a few times.
fn run(limited: Option<(WorkKind, u64)>) -> (ProblemStatement, Refinement) {
    let mut statement = relay();
    statement.composite = contract::CompositeMethod::Drrt;
    let units = |kind| limited.and_then(|(work, units)| NonZeroU64::new(units).filter(|_| work == kind));
    let [placement, transition, roadmap, composite, drrt] = KINDS.map(units);
    statement.options.limits = WorkLimits { placement, transition, roadmap, composite, drrt };
    let drrt_fails: Rule = Box::new(|request| match request {
        Request::Compose(job) if request.is_drrt() && job.assignment.grasps[1].0 == 0 => {
            Some(fails(no_path("y"), Soundness::Soft { level: 0 }))
        }
        _ => None,
    });
    let first: Rule = Box::new(|request| match request {
        Request::Transition(job) if job.level == 0 => Some(fails(no_path("z"), Soundness::Soft { level: 0 })),
        _ => None,
    });
    let refinement = Scripted::new(&statement, vec![first, transfer_fails_with(0, 0..1), drrt_fails]).run();
    (statement, refinement)
}

#[test]
fn a_run_ends_when_more_work_is_spent_than_allowed_and_keeps_what_is_known() {
    let (_, whole) = run(None);
    assert!(matches!(whole.end, End::Solved { .. }), "{:?}", whole.end);
    for kind in KINDS {
        let of_stage =
            |stage: &str| whole.stages.iter().find(|count| count.stage == stage).map_or(0, |count| count.work);
        let needed = match kind {
            WorkKind::Stage(stage) => of_stage(stage.name()),
            WorkKind::Drrt => of_stage("composite") - 1,
        };
        assert!(needed > 1, "{kind}");
        for units in 1..=needed {
            let (_, cut) = run(Some((kind, units)));
            if units == needed {
                assert!(matches!(cut.end, End::Solved { .. }), "{kind} needs {needed}, was given {units}");
                continue;
            }
            let End::Failed { result, causes, .. } = &cut.end else { panic!("{kind} {units}: {:?}", cut.end) };
            assert_eq!(*result, ResultKind::LimitReached);
            assert!(causes.contains(&(Cause::Budget { stage: kind.to_string() }, 1)), "{kind}: {causes:?}");
            let spent = units + 1;
            assert_eq!(cut.ledger.entries.last(), Some(&LedgerEntry::LimitReached { work: kind, spent }));
            let stage = match kind {
                WorkKind::Stage(stage) => stage,
                WorkKind::Drrt => StageKind::Composite,
            };
            let count = cut.stages.iter().find(|count| count.stage == stage.name()).unwrap();
            assert_eq!(count.work, spent, "{kind}");
            if stage > StageKind::Transition {
                assert!(causes.iter().any(|(cause, _)| *cause == no_path("z")), "{kind}: {causes:?}");
            }
        }
    }
}

#[test]
fn no_job_may_spend_more_than_the_limit() {
    let mut statement = relay();
    let limit = NonZeroU64::new(777);
    statement.options.limits =
        WorkLimits { placement: limit, transition: limit, roadmap: limit, composite: limit, drrt: NonZeroU64::new(5) };
    statement.composite = contract::CompositeMethod::Drrt;
    let mut stages = Scripted::new(&statement, Vec::new());
    stages.run();
    for job in &stages.asked {
        assert_eq!(job.budget, if job.request.is_drrt() { 5 } else { 777 });
    }
}
