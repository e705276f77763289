//! Plans problems by direct calls and prints what each kind of job cost, and what a new pose of one object costs the
//! roadmap stage:
//! `cargo run --release --example job_costs -- [-v] [SCENE | small:SEED | large:SEED]...` (figure1). `-v` tells every
//! composite job.

#![allow(clippy::unwrap_used, clippy::panic, clippy::expect_used, reason = "a tool for developers")]

#[allow(dead_code, reason = "tests use the rest")]
#[path = "../tests/ladder/generator.rs"]
mod generator;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use contract::{
    Answer, AskFault, AskStages, CompositeMethod, Composition, DirectCalls, Foresight, Job, JobId, Outcome, PieceSpec,
    ProblemStatement, Request, StageKind,
};
use generator::Size;
use launch::stages::{BusyTimes, own_stages};
use model::{DiskFiles, Problem, load_problem};
use refiner::{End, refine_plan};
use skeleton::ModeId;

/// Work units of one run.
const LIMIT: u64 = 400_000;

/// What one kind of job cost.
#[derive(Default)]
struct Cost {
    asked: u64,
    failed: u64,
    work: u64,
    seconds: f64,
}

struct Measured {
    calls: DirectCalls,
    /// Whether every composite job is told.
    tells: bool,
    costs: BTreeMap<&'static str, Cost>,
    work: u64,
    /// Every piece, and the last roadmap asked for each mode.
    pieces: Vec<Job>,
    modes: BTreeMap<ModeId, Job>,
}

impl AskStages for Measured {
    fn ask(&mut self, jobs: &[Job]) -> Result<Vec<Outcome>, AskFault> {
        jobs.iter().map(|job| self.answer(job)).collect()
    }

    fn foresee(&mut self, foresight: Foresight) {
        self.calls.foresee(foresight);
    }

    fn job_id(&self, job: &Job) -> JobId {
        self.calls.job_id(job)
    }
}

impl Measured {
    fn answer(&mut self, job: &Job) -> Result<Outcome, AskFault> {
        match &job.request {
            Request::Piece(_) => self.pieces.push(job.clone()),
            Request::Mode(mode) => drop(self.modes.insert(mode.mode, job.clone())),
            _ => {}
        }
        if self.work >= LIMIT {
            return Err(AskFault::TimeLimit);
        }
        let began = Instant::now();
        let outcome = self.calls.ask(std::slice::from_ref(job))?.pop().ok_or(AskFault::Cancelled)?;
        if self.tells {
            tell(job, &outcome);
        }
        let cost = self.costs.entry(kind(job)).or_default();
        cost.asked += 1;
        cost.failed += u64::from(outcome.result.is_err());
        cost.work += outcome.work;
        cost.seconds += began.elapsed().as_secs_f64();
        if job.stage() != StageKind::Placement {
            self.work += outcome.work;
        }
        Ok(outcome)
    }
}

fn tell(job: &Job, outcome: &Outcome) {
    let Request::Compose(compose) = &job.request else { return };
    let what = match &compose.composition {
        Composition::CommitMode { mode, clear_of, .. } => {
            format!("robot {} mode {}, clear of {} ways", mode.robot.0, mode.step, clear_of.len())
        }
        Composition::Drrt { prefix, .. } => format!("dRRT* from {}", if prefix.is_some() { "half way" } else { "0 s" }),
        Composition::Repair { mode, robots, .. } => {
            format!("robot {} mode {} repaired with {} others", mode.robot.0, mode.step, robots.len() - 1)
        }
        Composition::Passages { .. } => "passages".to_owned(),
        Composition::Assemble { .. } => "assembled".to_owned(),
        Composition::Synchronous { .. } => "scheduled in rounds".to_owned(),
    };
    match &outcome.result {
        Ok(Answer::Committed { event_s, tail_s, .. }) => println!("  {what}: {event_s:.2} s, tail {tail_s:.2} s"),
        Ok(_) => println!("  {what}"),
        Err(report) => println!("  {what} FAILED: {:?}", report.causes),
    }
}

fn kind(job: &Job) -> &'static str {
    match &job.request {
        Request::Placement(_) | Request::Hop(_) | Request::Samples(_) => "1 placement",
        Request::Transition(_) => "2 alternatives",
        Request::Blockers(_) => "2 blockers",
        Request::GraspBlockers(_) => "2 grasp blockers",
        Request::Piece(piece) if piece.spec == PieceSpec::Base => "3 base piece",
        Request::Piece(_) => "3 arm piece",
        Request::Mode(_) => "3 mode",
        Request::Compose(compose) => match compose.composition {
            Composition::CommitMode { .. } => "4 commit",
            Composition::Repair { .. } => "4 repair",
            Composition::Passages { .. } => "4 passages",
            Composition::Drrt { .. } => "4 dRRT*",
            Composition::Assemble { .. } => "4 assemble",
            Composition::Synchronous { .. } => "4 rounds",
        },
    }
}

fn problem(name: &str) -> Problem {
    let seeded = |seed: &str| seed.parse().expect("a seed");
    match name.split_once(':') {
        Some(("small", seed)) => generator::problem(Size::Small, seeded(seed)),
        Some(("large", seed)) => generator::problem(Size::Large, seeded(seed)),
        _ => load_problem(&DiskFiles, &format!("{}/launch/scenes/{name}.yaml", env!("CARGO_MANIFEST_DIR"))).unwrap(),
    }
}

fn measure(name: &str, tells: bool) {
    let seed = name.split_once(':').map_or(0, |(_, seed)| seed.parse().expect("a seed"));
    let statement = Arc::new(ProblemStatement::new(problem(name), seed, CompositeMethod::Prioritised));
    let stages = own_stages(&statement, &BusyTimes::default()).expect("usable geometry");
    let calls = DirectCalls::new(statement.clone(), stages, Arc::new(AtomicBool::new(false)));
    let mut measured =
        Measured { calls, tells, costs: BTreeMap::new(), work: 0, pieces: Vec::new(), modes: BTreeMap::new() };
    let began = Instant::now();
    let refinement = refine_plan(&statement, &mut measured, &mut |_| ());
    let end = match &refinement.end {
        End::Solved { makespan_s, .. } => format!("solved, {makespan_s:.2} s"),
        End::Failed { result, .. } => format!("{result:?}"),
        End::Fault(fault) => fault.to_string(),
    };
    println!("{name}: {end}, {:.2} s, {} units", began.elapsed().as_secs_f64(), measured.work);
    for (kind, Cost { asked, failed, work, seconds }) in &measured.costs {
        println!("  {kind:15} {asked:>6} asked {failed:>5} failed {work:>8} units {seconds:>8.3} s");
    }
    measure_new_pose(&mut measured, &statement);
}

/// Roadmaps of all modes, one object's first placement 3 cm aside: by the stage that knows the old ones, by one that has
/// their pieces only, and by one that has nothing.
fn measure_new_pose(measured: &mut Measured, statement: &Arc<ProblemStatement>) {
    let modes: Vec<Job> = measured.modes.values().map(moved).collect();
    if modes.is_empty() {
        return;
    }
    let timed = |jobs: &[Job], calls: &mut DirectCalls| {
        let began = Instant::now();
        calls.ask(jobs).unwrap();
        began.elapsed().as_secs_f64()
    };
    let fresh = || {
        let stages = own_stages(statement, &BusyTimes::default()).unwrap();
        DirectCalls::new(statement.clone(), stages, Arc::new(AtomicBool::new(false)))
    };
    let warm_s = timed(&modes, &mut measured.calls);
    let mut calls = fresh();
    let pieces_s = timed(&measured.pieces, &mut calls);
    let modes_s = timed(&modes, &mut calls);
    println!(
        "  a new pose in {} modes: {:.1} ms; with their pieces only {:.1} ms; from nothing {:.1} ms",
        modes.len(),
        1e3 * warm_s,
        1e3 * modes_s,
        1e3 * (pieces_s + modes_s)
    );
}

/// The job with the first placed object a little aside.
fn moved(job: &Job) -> Job {
    let mut job = job.clone();
    if let Request::Mode(mode) = &mut job.request {
        for obstruction in mode.certain.iter_mut().chain(&mut mode.possible) {
            if obstruction.occupancy.object.index() == 0 && obstruction.occupancy.hop == 1 {
                obstruction.standing.world_from_object.translation.vector.x += 0.03;
            }
        }
        // A roadmap of another level is another job, even where the object does not matter.
        mode.level += 1;
    }
    job
}

fn main() {
    let names: Vec<String> = std::env::args().skip(1).collect();
    let tells = names.first().is_some_and(|name| name == "-v");
    let names = &names[usize::from(tells)..];
    if names.is_empty() {
        measure("figure1", tells);
    }
    names.iter().for_each(|name| measure(name, tells));
}
