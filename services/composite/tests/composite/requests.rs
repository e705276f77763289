//! Answers are functions of their jobs; what is not a job of this stage is refused.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use composite::CompositeStage;
use contract::{
    Answer, Composition, Digest, Interrupted, Job, JobContext, JobId, PlacementJob, Prefix, Product, ProductRef,
    Request, Stage, VertexId,
};
use plan::Cause;

use crate::toys::{Dice, Toy, mode, random_world};

fn toy() -> Toy {
    random_world(&mut Dice(42), 8, 4, 3, 1).build()
}

fn unfit(answer: Result<contract::Outcome, Interrupted>, what: &str) {
    assert!(matches!(answer, Err(Interrupted::Unfit(_))), "{what}: {answer:?}");
}

#[test]
fn equal_jobs_have_equal_outcomes_in_any_order_and_in_any_stage() {
    let toy = toy();
    let jobs: Vec<Job> = (0..3).map(|robot| toy.commit_job(None, mode(robot, 0), |_| ())).collect();
    let first: Vec<_> = jobs.iter().map(|job| toy.ask(job).unwrap()).collect();
    let mut other = toy.world.clone().build();
    other.stage = CompositeStage::new(&toy.statement).unwrap();
    for job in jobs.iter().rev() {
        toy.ask(job).unwrap();
    }
    for (job, outcome) in jobs.iter().zip(&first).rev() {
        assert_eq!(toy.ask(job).unwrap(), *outcome);
        for product in job.products() {
            other.put(&toy.get(product));
        }
        assert_eq!(other.ask(job).unwrap(), *outcome);
    }
}

#[test]
fn a_product_that_cannot_be_had_is_named() {
    let toy = toy();
    let lost = ProductRef { digest: Digest([7; 32]), made_by: JobId(Digest([8; 32])) };
    let job = toy.commit_job(Some(lost), mode(0, 0), |_| ());
    assert_eq!(toy.ask(&job).unwrap_err(), Interrupted::Lacking(lost));
    let composition = Composition::CommitMode {
        prefix: None,
        mode: mode(0, 0),
        roadmap: lost,
        next_roadmap: Some(lost),
        clear_of: vec![],
    };
    assert_eq!(toy.ask(&toy.job(composition)).unwrap_err(), Interrupted::Lacking(lost));
}

#[test]
fn jobs_and_products_that_do_not_fit_are_refused() {
    let toy = toy();
    let (prefix, _) = toy.commit(None, mode(0, 0)).unwrap();
    unfit(toy.ask(&toy.commit_job(Some(prefix), mode(0, 0), |_| ())), "a mode that is committed");
    unfit(toy.ask(&toy.commit_job(None, mode(0, 1), |_| ())), "a mode that is not next");
    unfit(toy.ask(&toy.commit_job(None, mode(0, 0), |roadmap| roadmap.vertices[0].clear())), "no configuration");
    unfit(toy.ask(&toy.commit_job(None, mode(0, 0), |roadmap| roadmap.vertices[0][0] = f64::NAN)), "not finite");
    unfit(toy.ask(&toy.commit_job(None, mode(0, 0), |roadmap| roadmap.goal = VertexId(999))), "no vertex");
    unfit(toy.ask(&toy.commit_job(None, mode(0, 0), |roadmap| roadmap.edges[0].b = VertexId(999))), "no vertex");
    unfit(toy.ask(&toy.commit_job(None, mode(0, 0), |roadmap| roadmap.edges[0].duration_s = 0.01)), "too fast");
    unfit(toy.ask(&toy.commit_job(None, mode(0, 0), |roadmap| roadmap.start = roadmap.goal)), "starts elsewhere");
    unfit(toy.ask(&toy.commit_job(None, mode(0, 0), |roadmap| roadmap.mode = mode(1, 0))), "another mode's roadmap");
    let not_next = toy.put(&Product::Mode(toy.roadmap(mode(0, 0))));
    let composition = Composition::CommitMode {
        prefix: None,
        mode: mode(0, 0),
        roadmap: not_next,
        next_roadmap: None,
        clear_of: vec![],
    };
    unfit(toy.ask(&toy.job(composition)), "no next roadmap");
    unfit(toy.ask(&toy.job(Composition::Assemble { prefix, shortest_s: vec![], rounds: vec![] })), "not complete");
    let placement = PlacementJob { level: 0, first: 0, count: 1, nogoods: vec![] };
    unfit(toy.ask(&Job { request: Request::Placement(placement), budget: 1 }), "another stage's");
}

#[test]
fn commitments_that_jump_or_overlap_in_time_are_refused() {
    let toy = toy();
    let (prefix, _) = toy.commit(None, mode(0, 0)).unwrap();
    let good = toy.commitments(prefix);
    let edits: [fn(&mut contract::Commitment); 7] = [
        |c| c.moves[0].to[0] += 0.1,
        |c| c.moves[0].begins_s += 0.1,
        |c| c.moves[0].to[0] = f64::INFINITY,
        |c| c.event_s += 1.0,
        |c| c.mode.robot.0 = 9,
        |c| c.holding = Some(model::Holding { object: model::ObjectId(77), grasp: model::GraspId(0) }),
        |c| c.tail_holding = Some(model::Holding { object: model::ObjectId(0), grasp: model::GraspId(9) }),
    ];
    for (i, edit) in edits.iter().enumerate() {
        let mut commitments = good.clone();
        edit(&mut commitments[0]);
        let bad = toy.put(&Product::Prefix(Prefix { parent: None, commitments, tails: vec![] }));
        unfit(toy.ask(&toy.commit_job(Some(bad), mode(1, 0), |_| ())), &format!("edit {i}"));
    }
}

#[test]
fn the_wrong_assignment_is_refused() {
    let mut toy = toy();
    toy.assignment.poses[0].pop();
    let (prefix, _) = toy.commit(None, mode(0, 0)).unwrap();
    unfit(toy.ask(&toy.commit_job(Some(prefix), mode(0, 1), |_| ())), "no pose to put the object");
    for pair in 0..3 {
        toy.assignment.grasps[pair] = model::GraspId(9);
    }
    let no_grasp = |roadmap: &mut contract::ModeRoadmap| {
        roadmap.holding.iter_mut().for_each(|holding| holding.grasp = model::GraspId(9));
    };
    unfit(toy.ask(&toy.commit_job(None, mode(1, 0), no_grasp)), "a grasp that is none");
    toy.assignment.grasps.clear();
    unfit(toy.ask(&toy.commit_job(Some(prefix), mode(0, 1), |_| ())), "no grasp");
}

#[test]
fn a_cancelled_job_has_no_outcome_and_a_used_up_budget_is_a_cause() {
    let toy = toy();
    let job = toy.commit_job(None, mode(0, 0), |_| ());
    let id = job.id(&toy.statement);
    let mut cancelled = JobContext::new(id, &job, &toy.products, Arc::new(AtomicBool::new(true)));
    assert_eq!(toy.stage.refine(&job, &mut cancelled).unwrap_err(), Interrupted::Cancelled);
    let outcome = toy.ask(&Job { budget: 1, ..job }).unwrap();
    let causes = outcome.result.unwrap_err().causes;
    assert_eq!(causes, [(Cause::Budget { stage: "composite".into() }, 1)]);
}

#[test]
fn the_answer_says_when_the_event_is_and_when_the_tail_is_over() {
    let toy = toy();
    let outcome = toy.ask(&toy.commit_job(None, mode(0, 0), |_| ())).unwrap();
    let Ok(Answer::Committed { prefix, event_s, tail_s }) = outcome.result else { panic!("{outcome:?}") };
    let commitments = toy.commitments(prefix);
    assert_eq!(commitments[0].event_s, event_s);
    assert_eq!(commitments[0].tail.last().map_or(event_s, |last| last.ends_s), tail_s);
    assert_eq!(commitments[0].moves.last().unwrap().ends_s, event_s);
}

#[test]
fn motion_that_meets_is_not_assembled() {
    let mut world = crate::toys::World::grid(5, 2, 0.7);
    world.ways.retain(|(a, b)| *b < 5 || b - a == 5);
    world.starts = vec![0, 4];
    world.objects = vec![9, 5];
    let errand = |robot, object, at| crate::toys::Errand { robot, object, from: at, to: at };
    world.errands = vec![errand(0, 0, 9), errand(1, 1, 5)];
    world.points.push([0.7, 5.0]);
    let toy = world.build();
    // Each robot alone in the world, then both together.
    let alone = |robot: usize| {
        let mut world = toy.world.clone();
        world.starts[1 - robot] = 10;
        let other = world.build();
        (0..3)
            .fold(None, |prefix, step| Some(other.commit(prefix, mode(robot, step)).unwrap().0))
            .map(|prefix| other.commitments(prefix))
    };
    let commitments = [alone(0).unwrap(), alone(1).unwrap()].concat();
    let prefix = toy.put(&Product::Prefix(Prefix { parent: None, commitments, tails: vec![] }));
    let shortest_s = vec![vec![0.0; 3]; 2];
    let outcome = toy.ask(&toy.job(Composition::Assemble { prefix, shortest_s, rounds: vec![] })).unwrap();
    let causes = outcome.result.unwrap_err().causes;
    assert!(matches!(causes[0].0, Cause::Collision { .. }), "{causes:?}");
}
