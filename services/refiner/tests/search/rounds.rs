//! Synchronous schedules as the search asks for them.

use contract::{
    Answer, CompositeMethod, Composition, Decision, Outcome, ProblemStatement, Request, RoundChoice, SearchOptions,
    Soundness,
};
use plan::Cause;
use refiner::End;

use crate::scripted::{Rule, Scripted, decisions, fails, relay, two_rounds};

#[test]
fn a_synchronous_schedule_is_assembled_with_its_rounds_and_where_there_is_none_an_alternative_is_revised() {
    for (composite, choice) in
        [(CompositeMethod::SyncGreedy, RoundChoice::Greedy), (CompositeMethod::SyncOpt, RoundChoice::Optimal)]
    {
        let statement = ProblemStatement { composite, ..relay() };
        let failures = std::cell::Cell::new(2);
        let rule: Rule = Box::new(move |request| match request {
            Request::Compose(job) if matches!(job.composition, Composition::Synchronous { .. }) => {
                let left = failures.replace(failures.get().max(1) - 1);
                let cause = Cause::Deadlock { robots: vec!["r1".into(), "r2".into()] };
                (left > 0).then(|| fails(cause, Soundness::Soft { level: 0 }))
            }
            _ => None,
        });
        let mut stages = Scripted::new(&statement, vec![rule]);
        let run = stages.run();
        assert!(matches!(run.end, End::Solved { .. }), "{:?}", run.end);
        let decided = decisions(&run.ledger);
        assert_eq!(decided.iter().filter(|d| **d == Decision::Synchronous(choice)).count(), 3);
        assert!(decided.iter().any(|d| matches!(d, Decision::Alternative { index: 1, .. })));
        assert_eq!(decided[decided.len() - 2..], two_rounds().map(Decision::Round));
        let assembled = stages.asked.iter().find_map(|job| match &job.request {
            Request::Compose(job) => match &job.composition {
                Composition::Assemble { rounds, .. } => Some(rounds.clone()),
                _ => None,
            },
            _ => None,
        });
        assert_eq!(assembled, Some(two_rounds().into()));
        assert!(!stages.asked.iter().any(|job| matches!(&job.request, Request::Compose(job)
            if matches!(job.composition, Composition::CommitMode { .. } | Composition::Drrt { .. }))));
    }
}

#[test]
fn of_two_plans_on_the_same_roadmaps_the_shorter_is_kept_and_one_is_enough() {
    let statement = ProblemStatement { composite: CompositeMethod::Shorter, ..relay() };
    let deadlock = || fails(Cause::Deadlock { robots: vec!["r1".into(), "r2".into()] }, Soundness::Soft { level: 0 });
    // Makespans mode by mode (by dRRT* here) and of the rounds without waits; none: it fails.
    let makespan_s = |by_drrt: Option<f64>, in_rounds: Option<f64>| {
        let of_rounds = std::cell::Cell::new(false);
        let rule: Rule = Box::new(move |request| {
            let Request::Compose(job) = request else { return None };
            match &job.composition {
                Composition::CommitMode { .. } | Composition::Repair { .. } => Some(deadlock()),
                Composition::Passages { .. } => None,
                Composition::Drrt { .. } => by_drrt.is_none().then(deadlock),
                Composition::Synchronous { .. } => {
                    of_rounds.set(true);
                    in_rounds.is_none().then(deadlock)
                }
                Composition::Assemble { prefix, rounds, .. } => {
                    assert!(rounds.is_empty());
                    let makespan_s = if of_rounds.get() { in_rounds } else { by_drrt }?;
                    Some(Outcome::answer(Answer::Plan { plan: *prefix, makespan_s }, 1))
                }
            }
        });
        let statement =
            ProblemStatement { options: SearchOptions { candidates: 1, ..statement.options }, ..statement.clone() };
        match Scripted::new(&statement, vec![rule]).run().end {
            End::Solved { makespan_s, .. } => Some(makespan_s),
            _ => None,
        }
    };
    assert_eq!(makespan_s(Some(5.0), Some(4.0)), Some(4.0));
    assert_eq!(makespan_s(Some(4.0), Some(5.0)), Some(4.0));
    assert_eq!(makespan_s(Some(6.0), None), Some(6.0));
    assert_eq!(makespan_s(None, Some(6.0)), Some(6.0));
    assert_eq!(makespan_s(None, None), None);
}
