//! Every rung gives its planted answer.

use std::time::Instant;

use contract::{CompositeMethod, StageKind};
use plan::{BodyRef, Cause, Certificate, Plan, ResultKind};
use refiner::End;

use crate::facts::discovered;
use crate::run::{Run, run, verify};
use crate::rungs::{Expected, Last, Orders, Proof, RUNGS, Reason, Rung};
use crate::scene;

/// All rungs of a part of the table with all their seeds; every rung that does not hold is told.
fn climb<'a>(rungs: impl Iterator<Item = &'a Rung>, method: CompositeMethod, seeds: impl Fn(&Rung) -> u64) {
    let mut wrong = Vec::new();
    for rung in rungs {
        let problem = scene(rung.scene);
        for seed in 0..seeds(rung) {
            let began = Instant::now();
            let found = run(&problem, seed, method);
            println!(
                "{:28} seed {seed} {:9} work {:>8} {:>7.2} s",
                rung.scene,
                if found.plan.is_some() { "solved" } else { "no plan" },
                found.work,
                began.elapsed().as_secs_f64()
            );
            if let Err(why) = holds(rung, &problem, &found) {
                wrong.push(format!("{} with seed {seed}: {why}", rung.scene));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn holds(rung: &Rung, problem: &model::Problem, found: &Run) -> Result<(), String> {
    let kinds = [StageKind::Placement, StageKind::Transition, StageKind::Roadmap, StageKind::Composite];
    let lasts = [Last::Placement, Last::Transition, Last::Roadmap, Last::Composite];
    for (kind, last) in kinds.into_iter().zip(lasts) {
        let asked = found.asked(kind);
        if last > rung.last && asked > 0 {
            return Err(format!("{kind} was asked {asked} times"));
        }
    }
    match (&rung.expected, &found.end, &found.plan) {
        (Expected::Solved { orders, within, fact }, End::Solved { .. }, Some(plan)) => {
            validation::check_plan(problem, plan).map_err(|violations| format!("refused: {violations:?}"))?;
            fits(plan, orders, *within)?;
            fact.map_or(Ok(()), |fact| fact(plan))
        }
        (Expected::Exhausted(reason), End::Failed { result: ResultKind::SamplesExhausted, causes, .. }, _) => {
            let told = causes.iter().any(|(cause, _)| reason.is(cause));
            if told { Ok(()) } else { Err(format!("another reason: {causes:?}")) }
        }
        (Expected::Proven(proof), End::Failed { result: ResultKind::InfeasibleProven, certificate, .. }, _) => {
            let certificate = certificate.as_ref().ok_or("no certificate")?;
            verify(problem, certificate)?;
            if proof.is(certificate) { Ok(()) } else { Err(format!("another proof: {certificate:?}")) }
        }
        (_, end, _) => Err(format!("it ended otherwise: {end:?}")),
    }
}

fn fits(plan: &Plan, orders: &Orders, within: f64) -> Result<(), String> {
    let found = discovered(plan);
    let as_planted = match orders {
        Orders::Exactly(expected) => found == *expected,
        Orders::AtMost(most) => found.len() <= *most,
    };
    if !as_planted {
        return Err(format!("discovered {found:?}"));
    }
    let (task_s, bound_s) = (plan.makespan.task_s, plan.lower_bound.seconds);
    let is_short = bound_s <= task_s + 1e-9 && task_s <= within * bound_s;
    if is_short { Ok(()) } else { Err(format!("a makespan of {task_s} s over a bound of {bound_s} s")) }
}

impl Reason {
    fn is(&self, cause: &Cause) -> bool {
        match (self, cause) {
            (Reason::BlockedBy(name), Cause::NoPath { blocking, .. }) => {
                blocking.iter().any(|body| matches!(body, BodyRef::Object(object) if object == name))
            }
            (Reason::Deadlock(names), Cause::Deadlock { robots }) => robots == names,
            _ => false,
        }
    }
}

impl Proof {
    fn is(&self, certificate: &Certificate) -> bool {
        match (self, certificate) {
            (Proof::Cycle(name), Certificate::Cycle { exclusions, .. }) => {
                exclusions.iter().any(|exclusion| exclusion.region == *name)
            }
            (Proof::Area(names), Certificate::Area { stays, .. }) => {
                names.iter().all(|name| stays.iter().any(|cover| cover.stay.object == *name))
            }
            (Proof::NoCommonGrasp(name), Certificate::NoCommonGrasp { pair, .. }) => pair == name,
            (Proof::Reach(name), Certificate::Reach { region, .. })
            | (Proof::BaseDisconnected(name), Certificate::BaseDisconnected { region, .. }) => region == name,
            _ => false,
        }
    }
}

#[test]
fn rungs_at_even_places_give_their_planted_answers() {
    climb(RUNGS.iter().step_by(2), CompositeMethod::Prioritised, |rung| rung.seeds);
}

#[test]
fn rungs_at_odd_places_give_their_planted_answers() {
    climb(RUNGS.iter().skip(1).step_by(2), CompositeMethod::Prioritised, |rung| rung.seeds);
}

#[test]
fn small_rungs_give_their_planted_answers_by_the_composite_search_alone() {
    // The rungs up to t05 are climbed so in the tests of whole plans.
    climb(RUNGS.iter().filter(|rung| rung.drrt && rung.scene > "t06"), CompositeMethod::Drrt, |_| 1);
}
