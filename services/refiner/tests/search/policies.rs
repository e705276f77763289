//! What a stage's failure leads to, for every policy of every stage.

use contract::{Composition, Decision, LedgerEntry, Outcome, ProblemStatement, Request, Soundness, StageKind};
use model::FailurePolicy;
use plan::{Cause, ResultKind};
use refiner::{End, Refinement};

use crate::scripted::{Rule, Scripted, decisions, fails, no_path, relay, transfer_fails_with};

fn with_policy(stage: StageKind, policy: &str) -> ProblemStatement {
    let mut statement = relay();
    let policy: Option<FailurePolicy> = Some(policy.parse().unwrap());
    let policies = &mut statement.options.policies;
    match stage {
        StageKind::Placement => policies.placement = policy,
        StageKind::Transition => policies.transition = policy,
        StageKind::Roadmap => policies.roadmap = policy,
        StageKind::Composite => policies.composite = policy,
    }
    statement
}

fn cause(stage: StageKind) -> Cause {
    match stage {
        StageKind::Placement => Cause::NoPlacement { object: "o".into(), region: "w".into() },
        StageKind::Transition => Cause::NoCommonGrasp { pair: "p".into() },
        StageKind::Roadmap => no_path("x"),
        StageKind::Composite => Cause::Deadlock { robots: vec!["r1".into(), "r2".into()] },
    }
}

fn soft(cause: Cause) -> Outcome {
    fails(cause, Soundness::Soft { level: 0 })
}

/// Everything that a stage is asked fails, as long as `when` holds of the question.
fn failing(stage: StageKind, when: impl Fn(&Request) -> bool + 'static) -> Rule {
    Box::new(move |request| {
        let is_question = !matches!(request, Request::Blockers(_));
        (request.stage() == stage && is_question && when(request)).then(|| soft(cause(stage)))
    })
}

fn solved(run: &Refinement) -> bool {
    matches!(run.end, End::Solved { .. })
}

fn more(run: &Refinement) -> Vec<(StageKind, u32)> {
    let of = |decision| match decision {
        Decision::More { stage, times } => Some((stage, times)),
        _ => None,
    };
    decisions(&run.ledger).into_iter().filter_map(of).collect()
}

#[test]
fn a_stage_that_has_to_stop_ends_the_run_at_its_first_failure_with_its_causes() {
    for stage in StageKind::ALL {
        let statement = with_policy(stage, "stop");
        let mut stages = Scripted::new(&statement, vec![failing(stage, |_| true)]);
        let run = stages.run();
        let End::Failed { result, causes, .. } = &run.end else { panic!("{stage}: {:?}", run.end) };
        assert_eq!(*result, ResultKind::SamplesExhausted);
        assert_eq!(causes[..], [(cause(stage), 1)], "{stage}");
        assert_eq!(run.ledger.entries.last(), Some(&LedgerEntry::Stopped { stage }));
        let levels = decisions(&run.ledger).into_iter().filter(|d| matches!(d, Decision::Level(_))).count();
        assert_eq!((levels, stages.count(|request| matches!(request, Request::Placement(_)))), (1, 1), "{stage}");
        let later = stages.count(|request| request.stage() > stage);
        assert_eq!(later, 0, "{stage} failed and a later stage was asked");
    }
}

#[test]
fn transition_has_failed_too_where_every_alternative_was_given_up() {
    let statement = with_policy(StageKind::Transition, "stop");
    let mut stages = Scripted::new(&statement, vec![transfer_fails_with(0, 0..100)]);
    let run = stages.run();
    assert_eq!(run.ledger.entries.last(), Some(&LedgerEntry::Stopped { stage: StageKind::Transition }));
    let End::Failed { causes, .. } = run.end else { panic!("solved without a way") };
    assert_eq!(causes, [(no_path("x"), 3)]);
}

#[test]
fn more_placements_are_asked_for_before_the_next_level_and_all_else_stays_at_its_own() {
    let statement = with_policy(StageKind::Placement, "more:4:2");
    let too_few = |request: &Request| matches!(request, Request::Placement(job) if job.level < 4);
    let mut stages = Scripted::new(&statement, vec![failing(StageKind::Placement, too_few)]);
    let run = stages.run();
    assert!(solved(&run), "{:?}", run.end);
    assert_eq!(more(&run), [(StageKind::Placement, 4), (StageKind::Placement, 16)]);
    let mut levels = Vec::new();
    for job in &stages.asked {
        match &job.request {
            Request::Placement(placement) => levels.push((placement.level, job.budget)),
            Request::Transition(transition) => assert_eq!(transition.level, 0),
            _ => {}
        }
    }
    let budget = levels[0].1;
    assert_eq!(levels, [(0, budget), (2, budget << 2), (4, budget << 4)]);
}

#[test]
fn more_grasps_are_asked_for_up_to_the_limit_and_then_another_placement() {
    let below =
        |level: u32| failing(StageKind::Transition, move |r| matches!(r, Request::Transition(j) if j.level < level));
    for (needed, placements) in [(1, 1), (2, 1), (3, 2)] {
        let mut statement = with_policy(StageKind::Transition, "more:2:2");
        statement.options.candidates = 1;
        let mut stages = Scripted::new(&statement, vec![below(needed)]);
        let run = stages.run();
        assert!(solved(&run));
        assert_eq!(stages.count(|request| matches!(request, Request::Placement(_))), placements, "level {needed}");
        let of_job = |job: &contract::Job| match &job.request {
            Request::Transition(transition) => Some((transition.level, transition.count, job.budget)),
            _ => None,
        };
        let asked: Vec<_> = stages.asked.iter().filter_map(of_job).collect();
        let (count, budget) = (asked[0].1, asked[0].2);
        assert!(asked.iter().all(|(level, _, b)| *b == budget << level));
        assert!(placements > 1 || asked.iter().all(|(level, c, _)| *c == count << level));
    }
}

#[test]
fn where_every_alternative_was_given_up_more_are_asked_for_and_only_new_ones_are_tried() {
    let statement = with_policy(StageKind::Transition, "more:2:1");
    let mut stages = Scripted::new(&statement, vec![transfer_fails_with(0, 0..3)]);
    let run = stages.run();
    assert!(solved(&run), "{:?}", run.end);
    assert_eq!(more(&run), [(StageKind::Transition, 2)]);
    assert_eq!(stages.count(|request| matches!(request, Request::Placement(_))), 1);
    // One pair of two is asked for again.
    assert_eq!(stages.count(|request| matches!(request, Request::Transition(job) if job.level == 1)), 1);
}

#[test]
fn a_roadmap_that_does_not_connect_is_asked_for_again_with_denser_pieces() {
    let statement = with_policy(StageKind::Roadmap, "more:2:3");
    let sparse = |request: &Request| matches!(request, Request::Mode(job) if job.mode.robot.0 == 0 && job.level < 2);
    let mut stages = Scripted::new(&statement, vec![failing(StageKind::Roadmap, sparse)]);
    let run = stages.run();
    assert!(solved(&run), "{:?}", run.end);
    assert!(!decisions(&run.ledger).iter().any(|decision| matches!(decision, Decision::Alternative { .. })));
    let asked = |level: u32| {
        let of_level = |job: &&contract::Job| matches!(&job.request, Request::Piece(piece) if piece.level == level);
        stages.asked.iter().filter(of_level).map(|job| job.id(&statement)).collect::<Vec<_>>()
    };
    assert!(!asked(1).is_empty() && !asked(2).is_empty() && asked(3).is_empty());
    for job in &stages.asked {
        let Request::Mode(mode) = &job.request else { continue };
        let pieces = [mode.base, mode.start_arm, mode.goal_arm].into_iter().flatten();
        let made_at = asked(mode.level);
        assert!(pieces.into_iter().all(|piece| made_at.contains(&piece.made_by)), "pieces of another level");
    }
}

#[test]
fn a_piece_that_fails_is_asked_for_again() {
    let statement = with_policy(StageKind::Roadmap, "more:2:1");
    let sparse = |request: &Request| matches!(request, Request::Piece(job) if job.level == 0);
    let mut stages = Scripted::new(&statement, vec![failing(StageKind::Roadmap, sparse)]);
    assert!(solved(&stages.run()));
}

#[test]
fn the_composite_search_gets_a_greater_budget_if_its_budget_was_what_failed() {
    let budget = Cause::Budget { stage: "composite".into() };
    for (of_drrt, times_asked) in [(budget, 3), (cause(StageKind::Composite), 1)] {
        let mut statement = with_policy(StageKind::Composite, "more:2:2");
        statement.options.composite_failures = 1;
        statement.options.candidates = 1;
        statement.problem.levels.highest = 0;
        let composite_fails: Rule = Box::new(move |request| match request {
            Request::Compose(_) => Some(soft(of_drrt.clone())),
            _ => None,
        });
        let mut stages = Scripted::new(&statement, vec![composite_fails]);
        assert!(!solved(&stages.run()));
        let budgets: Vec<u64> = stages.asked.iter().filter(|job| job.request.is_drrt()).map(|job| job.budget).collect();
        let doubled: Vec<u64> = (0..times_asked).map(|i| budgets[0] << i).collect();
        assert_eq!(budgets, doubled);
    }
}

#[test]
fn without_causes_of_transition_placements_come_one_after_the_other() {
    for (policy, firsts, nogoods) in
        // Both pairs of each candidate fail: what each failure says is learnt.
        [("backtrack", vec![0, 0, 0], vec![0, 2, 4]), ("backtrack:no_causes", vec![0, 1, 2], vec![0; 3])]
    {
        let mut statement = with_policy(StageKind::Transition, policy);
        statement.options.candidates = 3;
        statement.problem.levels.highest = 0;
        let mut stages = Scripted::new(&statement, vec![failing(StageKind::Transition, |_| true)]);
        let run = stages.run();
        let asked: Vec<_> = stages
            .asked
            .iter()
            .filter_map(|job| match &job.request {
                Request::Placement(job) => Some((job.first, job.nogoods.len())),
                _ => None,
            })
            .collect();
        assert_eq!(asked, firsts.into_iter().zip(nogoods).collect::<Vec<_>>(), "{policy}");
        let learnt = run.ledger.entries.iter().filter(|entry| matches!(entry, LedgerEntry::Learnt(_))).count();
        assert_eq!(learnt == 0, policy == "backtrack:no_causes");
    }
}

#[test]
fn without_causes_of_roadmaps_or_composite_motion_pairs_that_are_not_at_fault_are_revised_too() {
    let rule = |stage| -> Rule {
        if stage == StageKind::Roadmap {
            return transfer_fails_with(0, 0..2);
        }
        // Robot 0 is in the way of itself, whatever the other does.
        Box::new(|request| match request {
            Request::Compose(job) if job.assignment.grasps[0].0 < 2 => match job.composition {
                Composition::CommitMode { mode, .. } if mode.robot.0 != 0 => None,
                Composition::Assemble { .. } | Composition::Synchronous { .. } => None,
                _ => Some(soft(Cause::Deadlock { robots: vec!["nobody".into()] })),
            },
            _ => None,
        })
    };
    for stage in [StageKind::Roadmap, StageKind::Composite] {
        for policy in ["backtrack", "backtrack:no_causes"] {
            let statement = with_policy(stage, policy);
            assert_eq!(statement.problem.pairs[0].robot.0, 0);
            let mut stages = Scripted::new(&statement, vec![rule(stage)]);
            let run = stages.run();
            assert!(solved(&run), "{stage} {policy} {:?}", run.end);
            let revised = decisions(&run.ledger).into_iter().filter_map(|decision| match decision {
                Decision::Alternative { pair, .. } => Some(pair.0),
                _ => None,
            });
            let others = revised.filter(|pair| *pair != 0).count();
            assert_eq!(others > 0, policy == "backtrack:no_causes", "{stage} {policy}");
        }
    }
}
