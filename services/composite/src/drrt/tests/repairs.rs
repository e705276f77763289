//! Repairs of random toys agree with the oracle: there is motion exactly if the product of those who may move has some.

use contract::{Commitment, FailureReport};
use model::RobotId;
use plan::Cause;
use skeleton::ModeId;

use super::super::{Repaired, Together, repair_with};
use super::brute::{State, least_time};
use super::random::{crowded, tables};
use super::stepper::replay;
use super::toy::{Dice, Toy};
use crate::CommittedMotion;

const BUDGET: u64 = 400_000;

/// Where all robots rest.
fn rests(toy: &Toy, done: &CommittedMotion) -> State {
    let rest = |robot: usize| {
        let modes = &toy.roadmaps[robot];
        let id = RobotId::at(robot);
        let step = done.commitments.iter().filter(|c| c.mode.robot == id).count();
        let last_at = done.last(id).and_then(|last| last.moves.last());
        let at = done.tail(id).last().or(last_at).map_or(&toy.statement.problem.robots[robot].start, |m| &m.to);
        let Some(roadmap) = modes.get(step).or(modes.last()) else { return (0, 0) };
        (step.min(modes.len() - 1), roadmap.vertices.iter().position(|vertex| vertex == at).unwrap())
    };
    (0..toy.roadmaps.len()).map(rest).collect()
}

fn is_done(toy: &Toy, done: &CommittedMotion, robot: usize) -> bool {
    done.commitments.iter().filter(|c| c.mode.robot.index() == robot).count() == toy.roadmaps[robot].len()
}

#[derive(Default, Debug)]
struct Tally {
    repaired: usize,
    impossible: usize,
    /// Repairs for which others had events.
    further: usize,
    complete: usize,
}

impl Tally {
    /// Repairs one mode after another, each with some robots that may move, as far as it goes.
    fn repair_all(&mut self, toy: &Toy, dice: &mut Dice, name: &str) {
        let robots = toy.roadmaps.len();
        let mut done = CommittedMotion::default();
        for attempt in 0..12 {
            let open: Vec<usize> = (0..robots).filter(|robot| !is_done(toy, &done, *robot)).collect();
            let Some(robot) = (!open.is_empty()).then(|| open[dice.below(open.len())]) else { break };
            let movers: Vec<RobotId> =
                (0..robots).filter(|other| *other == robot || dice.chance(0.6)).map(RobotId::at).collect();
            let rest = rests(toy, &done);
            let step = rest[robot].0;
            let is_end = |state: &State| {
                let returned = toy.skeleton.modes[robot][step].ends.is_none();
                state[robot].0 > step || returned && state[robot].1 == toy.roadmaps[robot][step].goal.index()
            };
            let moves = |other: usize| movers.contains(&RobotId::at(other)) && !is_done(toy, &done, other);
            let least_s = least_time(toy, rest.clone(), moves, is_end);
            let mode = ModeId { robot: RobotId::at(robot), step: step as u32 };
            match (self.ask(toy, &done, Together { mode, robots: &movers }), least_s) {
                (Ok(repaired), Some(_)) => {
                    assert!(repaired.commitments.iter().any(|c| c.mode == mode), "{name}, {attempt}: not that mode");
                    let others = |c: &&Commitment| !movers.contains(&c.mode.robot);
                    assert!(!repaired.commitments.iter().any(|c| others(&c)), "{name}, {attempt}: others have events");
                    self.repaired += 1;
                    self.further += usize::from(repaired.commitments.len() > 1);
                    done.extend(repaired.commitments, repaired.tails);
                    let now = rests(toy, &done);
                    let stays = |other: &usize| movers.contains(&RobotId::at(*other)) || now[*other] == rest[*other];
                    assert!((0..robots).all(|other| stays(&other)), "{name}, {attempt}: {rest:?}, then {now:?}");
                }
                (Err(report), None) => {
                    let ran_out = report.causes.iter().any(|(cause, _)| matches!(cause, Cause::Budget { .. }));
                    assert!(!ran_out, "{name}, {attempt}: {report:?}");
                    self.impossible += 1;
                }
                (found, least_s) => panic!("{name}, {attempt}: {least_s:?} s by the oracle, but {found:?}"),
            }
        }
        if (0..robots).all(|robot| is_done(toy, &done, robot)) {
            let mut whole: Vec<Commitment> =
                done.commitments.into_iter().map(|c| Commitment { tail: Vec::new(), ..c }).collect();
            // Who is at its end already, returns in no time.
            whole.sort_by(|a, b| a.event_s.total_cmp(&b.event_s));
            replay(toy, &whole).unwrap_or_else(|wrong| panic!("{name}: {wrong}"));
            self.complete += 1;
        }
    }

    fn ask(&self, toy: &Toy, done: &CommittedMotion, together: Together<'_>) -> Result<Repaired, Box<FailureReport>> {
        let (statement, skeleton) = (&toy.statement, &toy.skeleton);
        toy.with_context(BUDGET, |context| {
            repair_with(statement, skeleton, done, &toy.roadmaps, together, &toy.table, context).unwrap()
        })
        .map_err(Box::new)
    }
}

#[test]
fn a_repair_is_found_exactly_when_the_robots_that_may_move_have_one() {
    let mut tally = Tally::default();
    for seed in 0..150 {
        tally.repair_all(&tables(seed), &mut Dice::new(seed), &format!("tables({seed})"));
        tally.repair_all(&crowded(seed), &mut Dice::new(seed), &format!("crowded({seed})"));
    }
    println!("{tally:?}");
    assert!(tally.repaired >= 200 && tally.impossible >= 200, "{tally:?}");
    assert!(tally.further >= 20 && tally.complete >= 50, "{tally:?}");
}
