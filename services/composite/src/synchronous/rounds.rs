//! The planner of rounds: whether some robots can do their next units together while the others idle, and how fast.

use std::collections::BTreeMap;

use contract::{CauseTally, JobContext};
use plan::Cause;

use super::evasion::{Leg, leg};
use super::sequence::{Done, Rounds, Sequence, Stop, after};
use super::team::Team;
use super::unit::{Around, Unit, UnitJob};
use crate::TimedMove;
use crate::commit::causes_of;
use crate::sipp::Blocker;

/// Orders of planning that are tried for one round: all of four robots.
const ORDERS: usize = 24;
/// Lengths up to this apart (s) count as equal.
const EQUAL_S: f64 = 1e-9;

/// Units that are done at the same time.
#[derive(Clone, Debug)]
pub(super) struct Round {
    /// In order of robots.
    pub units: Vec<Unit>,
    /// Until the last of them is over (s).
    pub length_s: f64,
}

/// A robot whose turn it is to be planned, and what it has done already to make room.
type Turn<'a> = (usize, Option<&'a Leg>);

/// What planning a round in one order came to.
enum Planned {
    Round(Round),
    /// It takes longer than a known one.
    Longer,
    /// No way for the robot planned as the so many-th, counted from 0.
    Stuck(usize),
}

/// Plans rounds, and remembers them.
pub(super) struct RoundPlanner<'a, 'c, 'j> {
    team: &'a Team<'a>,
    context: &'c mut JobContext<'j>,
    rounds: BTreeMap<(Done, Vec<usize>), Option<Round>>,
    /// Why rounds were impossible.
    causes: CauseTally,
}

impl<'a, 'c, 'j> RoundPlanner<'a, 'c, 'j> {
    pub fn new(team: &'a Team<'a>, context: &'c mut JobContext<'j>) -> Self {
        Self { team, context, rounds: BTreeMap::new(), causes: CauseTally::default() }
    }

    /// The rounds of a sequence, all of which have been planned.
    pub fn rounds_of(mut self, sequence: &Sequence) -> Vec<Round> {
        let mut done = vec![0; self.team.modes.len()];
        let mut rounds = Vec::new();
        for robots in sequence {
            rounds.extend(self.rounds.remove(&(done.clone(), robots.clone())).flatten());
            done = after(&done, robots);
        }
        rounds
    }

    /// Why there is no sequence.
    pub fn causes(self) -> CauseTally {
        let mut causes = self.causes;
        if causes.clone().ranked().is_empty() {
            // The orderings alone leave no sequence of rounds.
            let problem = self.team.scene.problem();
            let moving = problem.robots.iter().zip(&self.team.modes).filter(|(_, modes)| !modes.is_empty());
            causes.count(Cause::Deadlock { robots: moving.map(|(robot, _)| robot.name.clone()).collect() });
        }
        causes
    }

    fn plan(&mut self, done: &[u32], robots: &[usize]) -> Result<Option<Round>, Stop> {
        if let Some((robot, in_the_way)) = self.collision_after(done, robots)? {
            self.blame(done, robot, &[in_the_way]);
            return Ok(None);
        }
        let around = self.around(done, robots)?;
        let least_s = robots.iter().map(|robot| self.least_s(*robot, done[*robot])).fold(0.0, f64::max);
        let mut best: Option<Round> = None;
        for order in self.orders(done, robots) {
            let limit_s = best.as_ref().map_or(f64::INFINITY, |best| best.length_s);
            let order: Vec<Turn<'_>> = order.iter().map(|robot| (*robot, None)).collect();
            match self.plan_in_order(done, &order, around.clone(), limit_s)? {
                Planned::Round(round) => best = Some(round),
                Planned::Longer => {}
                // Alone among those that idle; the others can only be in the way.
                Planned::Stuck(0) => return Ok(None),
                Planned::Stuck(_) => {}
            }
            if best.as_ref().is_some_and(|best| best.length_s <= least_s + EQUAL_S) {
                break;
            }
        }
        if best.is_none() { self.plan_with_evasion(done, robots, &around) } else { Ok(best) }
    }

    /// The shortest round in which one robot first makes room for the others.
    fn plan_with_evasion(&mut self, done: &[u32], robots: &[usize], around: &Around) -> Result<Option<Round>, Stop> {
        let mut best: Option<Round> = None;
        for &evader in robots {
            let others: Vec<usize> = robots.iter().copied().filter(|robot| *robot != evader).collect();
            let Some(leg) = self.leg(done, evader, &others, around)? else { continue };
            let mut around = around.clone();
            around.robots[evader].clone_from(&leg.moves);
            let turns: Vec<Turn<'_>> =
                others.iter().map(|robot| (*robot, None)).chain([(evader, Some(&leg))]).collect();
            let limit_s = best.as_ref().map_or(f64::INFINITY, |best| best.length_s);
            if let Planned::Round(round) = self.plan_in_order(done, &turns, around, limit_s)? {
                best = Some(round);
            }
        }
        Ok(best)
    }

    /// How a robot gets out of the others' way, each of which alone would take its shortest.
    fn leg(&mut self, done: &[u32], evader: usize, others: &[usize], around: &Around) -> Result<Option<Leg>, Stop> {
        let mut ways = Vec::new();
        let mut standing = around.clone();
        for &robot in others {
            let alone = UnitJob { team: self.team, robot, done, around, leg: None }.plan(self.context)?;
            let Ok(alone) = alone else { return Ok(None) };
            ways.extend(alone.moves.iter().map(|step| step.travel));
            standing.robots[robot] = self.idle(robot, done);
        }
        leg(self.team, evader, done, &standing, &ways, self.context)
    }

    /// Who would stand where when the round is over, if that cannot be: a robot, and who is in its way.
    fn collision_after(&self, done: &[u32], robots: &[usize]) -> Result<Option<(usize, Blocker)>, Stop> {
        let (team, conflicts) = (self.team, &self.team.scene.conflicts);
        let then = after(done, robots);
        let stands: Vec<_> = (0..then.len()).map(|robot| team.stand(robot, then[robot])).collect();
        for &robot in robots {
            let moved_before = |other: usize| other < robot && robots.contains(&other);
            for other in (0..stands.len()).filter(|other| *other != robot && !moved_before(*other)) {
                if conflicts.cells_conflict(&stands[robot], 0, &stands[other], 0) {
                    return Ok(Some((robot, Blocker::Robot(stands[other].robot))));
                }
            }
            let placed = team
                .next(robot, done)
                .map(|unit| team.scene.placed(team.assignment, &unit.mode))
                .transpose()?
                .flatten();
            if let Some(placed) = placed {
                let hits = |other: &usize| *other != robot && conflicts.cell_hits(&stands[*other], 0, &placed);
                if let Some(other) = (0..stands.len()).find(hits) {
                    return Ok(Some((robot, Blocker::Robot(stands[other].robot))));
                }
            }
        }
        Ok(None)
    }

    /// Those that idle, and the objects that stand.
    fn around(&self, done: &[u32], robots: &[usize]) -> Result<Around, Stop> {
        let moves = |robot: usize| if robots.contains(&robot) { Vec::new() } else { self.idle(robot, done) };
        Ok(Around { robots: (0..done.len()).map(moves).collect(), standings: self.team.standings(done)? })
    }

    fn idle(&self, robot: usize, done: &[u32]) -> Vec<TimedMove> {
        let travel = self.team.stand(robot, done[robot]);
        vec![TimedMove { travel, begins_s: 0.0, ends_s: f64::INFINITY }]
    }

    /// Orders in which to plan: who takes longest first, then all others in lexicographic order.
    fn orders(&self, done: &[u32], robots: &[usize]) -> Vec<Vec<usize>> {
        let mut first = robots.to_vec();
        first.sort_by(|a, b| self.least_s(*b, done[*b]).total_cmp(&self.least_s(*a, done[*a])).then(a.cmp(b)));
        let places: Vec<usize> = (0..first.len()).collect();
        let orders = std::iter::successors(Some(places), |places| next_permutation(places)).take(ORDERS);
        orders.map(|places| places.into_iter().map(|place| first[place]).collect()).collect()
    }

    fn plan_in_order(
        &mut self,
        done: &[u32],
        order: &[Turn<'_>],
        mut around: Around,
        limit_s: f64,
    ) -> Result<Planned, Stop> {
        let mut round = Round { units: Vec::new(), length_s: 0.0 };
        for (place, &(robot, leg)) in order.iter().enumerate() {
            let planned = UnitJob { team: self.team, robot, done, around: &around, leg }.plan(self.context)?;
            let planned = match planned {
                Ok(planned) => planned,
                Err(in_the_way) => {
                    self.blame(done, robot, &in_the_way);
                    return Ok(Planned::Stuck(place));
                }
            };
            round.length_s = round.length_s.max(planned.unit.ends_s);
            if round.length_s >= limit_s {
                return Ok(Planned::Longer);
            }
            around.robots[robot] = planned.moves;
            around.standings.extend(planned.placed);
            round.units.push(planned.unit);
        }
        round.units.sort_by_key(|unit| unit.mode);
        Ok(Planned::Round(round))
    }

    fn blame(&mut self, done: &[u32], robot: usize, in_the_way: &[Blocker]) {
        let Some(unit) = self.team.next(robot, done) else { return };
        let causes = causes_of(self.team.scene, &unit.mode, in_the_way);
        causes.into_iter().for_each(|cause| self.causes.count(cause));
    }
}

impl Rounds for RoundPlanner<'_, '_, '_> {
    fn units(&self) -> Done {
        self.team.modes.iter().map(|modes| modes.len() as u32).collect()
    }

    fn is_enabled(&self, done: &[u32], robot: usize) -> bool {
        self.team.needs.are_met(robot, done[robot], done)
    }

    fn least_s(&self, robot: usize, unit: u32) -> f64 {
        self.team.modes[robot][unit as usize].least_s()
    }

    fn length_s(&mut self, done: &[u32], robots: &[usize]) -> Result<Option<f64>, Stop> {
        let key = (done.to_vec(), robots.to_vec());
        if let Some(known) = self.rounds.get(&key) {
            return Ok(known.as_ref().map(|round| round.length_s));
        }
        let round = self.plan(done, robots)?;
        let length_s = round.as_ref().map(|round| round.length_s);
        self.rounds.insert(key, round);
        Ok(length_s)
    }

    fn spend(&mut self) -> Result<(), Stop> {
        spend(self.context)
    }
}

/// Spends one work unit.
pub(super) fn spend(context: &mut JobContext<'_>) -> Result<(), Stop> {
    if context.spend(1)? { Ok(()) } else { Err(Stop::Budget) }
}

/// The next permutation in lexicographic order.
fn next_permutation(places: &[usize]) -> Option<Vec<usize>> {
    let rises = places.windows(2).rposition(|pair| pair[0] < pair[1])?;
    let mut next = places.to_vec();
    let greater = next.iter().rposition(|place| *place > next[rises])?;
    next.swap(rises, greater);
    next[rises + 1..].reverse();
    Some(next)
}
