//! Orders of commitment, with scripted events: who is committed second takes longer.

use std::cell::RefCell;
use std::collections::BTreeMap;

use contract::{Answer, Composition, Decision, Digest, JobId, Outcome, ProblemStatement, ProductRef, Request};
use refiner::End;
use skeleton::ModeId;

use crate::scripted::{Rule, Scripted, decisions, statement};

/// What a prefix holds: modes and their events (s), in order of commitment.
type Committed = Vec<(ModeId, f64)>;

/// A mode takes 1 s, but the transits of the two robots take `first_s` or `second_s`, by which of them is committed first. A
/// plan takes until its last release.
fn two_transits(first_s: [f64; 2], second_s: [f64; 2], pause_s: f64) -> Rule {
    let known: RefCell<BTreeMap<Digest, Committed>> = RefCell::default();
    Box::new(move |request| {
        let Request::Compose(job) = request else { return None };
        let before = |prefix: &ProductRef| known.borrow().get(&prefix.digest).cloned().unwrap_or_default();
        match &job.composition {
            Composition::CommitMode { prefix, mode, .. } => {
                let mut committed = prefix.as_ref().map(before).unwrap_or_default();
                let robot = mode.robot.index();
                let begin_s =
                    committed.iter().rfind(|(m, _)| m.robot == mode.robot).map(|(_, event_s)| event_s + pause_s);
                let other_is_first = committed.iter().any(|(m, _)| m.robot != mode.robot);
                let transit_s = if other_is_first { second_s[robot] } else { first_s[robot] };
                let event_s = begin_s.unwrap_or(0.0) + if mode.step == 0 { transit_s } else { 1.0 };
                committed.push((*mode, event_s));
                let digest = Digest::of("test prefix", &[&contract::encode_canonical(&committed)]);
                known.borrow_mut().insert(digest, committed);
                let prefix = ProductRef { digest, made_by: JobId(digest) };
                Some(Outcome::answer(Answer::Committed { prefix, event_s, tail_s: event_s }, 1))
            }
            Composition::Assemble { prefix, .. } => {
                let releases = before(prefix).into_iter().filter(|(mode, _)| mode.step == 1);
                let makespan_s = releases.map(|(_, event_s)| event_s).fold(0.0, f64::max);
                Some(Outcome::answer(Answer::Plan { plan: *prefix, makespan_s }, 1))
            }
            _ => None,
        }
    })
}

/// The makespan (s), and how many plans were assembled.
fn solve(statement: &ProblemStatement, first_s: [f64; 2], second_s: [f64; 2]) -> (f64, usize) {
    let rule = two_transits(first_s, second_s, statement.problem.settings.grip_time);
    let mut stages = Scripted::new(statement, vec![rule]);
    let run = stages.run();
    let End::Solved { makespan_s, .. } = run.end else { panic!("{:?}", run.end) };
    let commits = decisions(&run.ledger).into_iter().filter(|decision| matches!(decision, Decision::Commit(_)));
    assert_eq!(commits.count(), 6, "what other orders commit is no decision");
    let is_assembly = |request: &Request| matches!(request, Request::Compose(job) if matches!(job.composition, Composition::Assemble { .. }));
    (makespan_s, stages.count(is_assembly))
}

#[test]
fn where_the_first_to_arrive_makes_the_other_late_the_other_goes_first_and_the_shorter_plan_is_kept() {
    // Two robots with an errand each. Both alike as far as least times tell: what the second lost has to be learnt.
    let statement = statement("t09_swap");
    let rest_s = statement.problem.settings.grip_time + 1.0;
    let earliest_first_s = 10.0 + rest_s;
    let (makespan_s, assembled) = solve(&statement, [1.0, 2.0], [3.0, 10.0]);
    assert!((makespan_s - (3.0 + rest_s)).abs() < 1e-9, "{makespan_s} s, {earliest_first_s} s by the earliest event");
    assert!(assembled >= 2);
    // The other way round nothing is lost by the earliest event first, but for what cannot be helped.
    let (makespan_s, _) = solve(&statement, [1.0, 2.0], [30.0, 3.0]);
    assert!((makespan_s - (3.0 + rest_s)).abs() < 1e-9, "{makespan_s} s");
}

#[test]
fn where_nobody_loses_time_no_other_order_is_tried() {
    assert_eq!(solve(&statement("t09_swap"), [1.0; 2], [1.0; 2]).1, 1);
}
