//! Ways for every robot to do its pairs: alternatives and mode roadmaps that fit together.
//!
//! Each robot's cheapest chain of alternatives is looked at, lazily: what is not known of a mode is taken for the best,
//! and asked for only where the cheapest chain leads (as LazySP does with edges, Dellin and Srinivasa, ICAPS 2016).

use std::collections::BTreeSet;

use contract::{Decision, LedgerEntry, StageKind};
use model::{PairId, RobotId};
use skeleton::Mode;

use crate::around::Around;
use crate::candidate::{Candidate, Modes};
use crate::chain::{Chain, Cost};
use crate::conflict::{Conflict, Stuck};
use crate::known::{Ends, ModeAnswer};
use crate::search::Search;

/// Ways of a mode that are looked at before it is believed that a pose is in every one of them.
const LOOKS_FOR_A_FREE_WAY: usize = 12;

/// What stands about everywhere under the present orderings.
pub(crate) struct Scene {
    /// About each mode of each robot.
    modes: Vec<Vec<Around>>,
    /// About the two events of each pair.
    pub(crate) events: Vec<[Around; 2]>,
}

impl Scene {
    pub(crate) fn about(&self, mode: &Mode) -> &Around {
        &self.modes[mode.id.robot.index()][mode.id.step as usize]
    }
}

impl Candidate<'_> {
    /// Roadmaps of all modes, alternatives chosen to fit.
    pub(crate) fn ways(&mut self, search: &mut Search<'_>) -> Result<Modes, Stuck> {
        let robots: Vec<RobotId> = self.problem.robot_ids().collect();
        loop {
            let scene = self.ways_of(search, &robots)?;
            let failed = self.failed_together.get(&self.chosen).filter(|failed| self.hold(&failed.orders));
            match failed.cloned() {
                None => return Ok(self.answers(&scene)),
                Some(conflict) => self.meet_again(conflict)?,
            }
        }
    }

    /// Chooses alternatives of some robots' pairs until a roadmap of every mode between them is known.
    pub(crate) fn ways_of(&mut self, search: &mut Search<'_>, robots: &[RobotId]) -> Result<Scene, Stuck> {
        loop {
            let scene = self.scene();
            self.choose(search, &scene, robots)?;
            let pairs: Vec<PairId> = robots.iter().flat_map(|robot| self.served_pairs(*robot)).collect();
            if self.ask_blockers(search, &pairs)? {
                continue;
            }
            let modes = robots.iter().flat_map(|robot| self.served_modes(*robot));
            let unknown: Vec<Mode> = modes.filter(|mode| self.present_way(&scene, mode).is_none()).collect();
            if unknown.is_empty() {
                return Ok(scene);
            }
            self.looks = self.looks.saturating_sub(unknown.len() as u32);
            if self.looks == 0 {
                return Err(self.given_up(StageKind::Roadmap, Conflict::default()));
            }
            self.look(search, &scene, &unknown)?;
        }
    }

    /// Fails if every alternative of a pair is blocked.
    pub(crate) fn has_alternative(&mut self, search: &mut Search<'_>, pair: PairId) -> Result<(), Stuck> {
        let scene = self.scene();
        loop {
            let is_open = |number: &usize| self.cost(pair, *number, &scene.events[pair.index()]).is_some();
            let Some(open) = (0..self.offered[pair.index()].len()).find(is_open) else {
                return Err(Stuck::Failed(self.dead_end(&scene, &[pair])));
            };
            self.chosen[pair.index()] = open;
            if !self.ask_blockers(search, &[pair])? {
                return Ok(());
            }
        }
    }

    fn scene(&self) -> Scene {
        let about = |modes: &Vec<Mode>| modes.iter().map(|mode| self.around_mode(mode)).collect();
        Scene {
            modes: self.skeleton.modes.iter().map(about).collect(),
            events: (0..self.problem.pairs.len()).map(|pair| self.around_events(PairId::at(pair))).collect(),
        }
    }

    fn present_way(&self, scene: &Scene, mode: &Mode) -> Option<&ModeAnswer> {
        self.known(mode).way(self.present_ends(mode), scene.about(mode))
    }

    fn answers(&self, scene: &Scene) -> Modes {
        let way = |mode: &Mode| self.present_way(scene, mode).cloned();
        self.skeleton.modes.iter().map(|modes| modes.iter().filter_map(way).collect()).collect()
    }

    /// A robot's pairs of which it is known where their objects stand before and after: its first ones.
    pub(crate) fn served_pairs(&self, robot: RobotId) -> Vec<PairId> {
        let is_served = |pair: &PairId| !self.offered[pair.index()].is_empty();
        self.problem.pairs_of_robot(robot).take_while(is_served).collect()
    }

    /// The modes between them.
    fn served_modes(&self, robot: RobotId) -> Vec<Mode> {
        let pairs = self.served_pairs(robot);
        let is_whole = pairs.len() == self.problem.pairs_of_robot(robot).count();
        let modes = self.skeleton.modes[robot.index()].iter();
        modes.filter(|mode| mode.pair.map_or(is_whole, |pair| pairs.contains(&pair))).copied().collect()
    }

    /// The pairs whose alternatives decide where a mode begins and where it ends.
    pub(crate) fn pairs_at_ends(&self, mode: &Mode) -> [Option<PairId>; 2] {
        let before = mode.begins.map(|event| event.pair);
        [before, mode.pair]
    }

    pub(crate) fn present_ends(&self, mode: &Mode) -> Ends {
        self.pairs_at_ends(mode).map(|pair| pair.map(|pair| self.chosen[pair.index()]))
    }

    /// Chooses the cheapest alternatives of each robot, as far as is known.
    fn choose(&mut self, search: &mut Search<'_>, scene: &Scene, robots: &[RobotId]) -> Result<(), Stuck> {
        let mut dead_ends = Vec::new();
        for robot in robots.iter().copied() {
            let pairs = self.served_pairs(robot);
            let chain = self.chain(scene, robot, &pairs);
            for (pair, alternatives) in pairs.iter().zip(&chain.alternatives) {
                let is_open = |number: &usize| alternatives[*number].is_some();
                self.open[pair.index()] = (0..alternatives.len()).filter(is_open).collect();
            }
            match chain.best() {
                Ok(best) => {
                    for (pair, number) in pairs.into_iter().zip(best) {
                        self.decide(search, pair, number);
                    }
                }
                Err(run) => {
                    let conflict = self.dead_end(scene, &pairs[run.clone()]);
                    let is_one = run.start() == run.end() && search.policy(StageKind::Transition).tells_causes();
                    dead_ends.push(match pairs.get(*run.start()).filter(|_| is_one) {
                        Some(pair) => self.generalise(search, scene, *pair, conflict)?,
                        None => conflict,
                    });
                }
            }
        }
        // The fewer orderings a failure rests on, the farther back it leads.
        dead_ends.sort_by_key(|conflict| (self.tried_orders(conflict), conflict.orders.len(), conflict.choices.len()));
        let mut dead_ends = dead_ends.into_iter();
        let Some(first) = dead_ends.next() else { return Ok(()) };
        let others: Vec<Conflict> = dead_ends.filter(|other| self.tried_orders(other) == 0).collect();
        search.aside.extend(others);
        Err(Stuck::Failed(first))
    }

    /// Commits that a pair is done in another way than before.
    fn decide(&mut self, search: &mut Search<'_>, pair: PairId, number: usize) {
        let before = std::mem::replace(&mut self.chosen[pair.index()], number);
        if before == number {
            return;
        }
        let index = |number: usize| self.offered[pair.index()].get(number).map_or(0, |alternative| alternative.index);
        let [given_up, index] = [before, number].map(index);
        if let Some(because) = self.because[pair.index()].take() {
            let decision = Decision::Alternative { pair, index: given_up };
            search.backtrack(StageKind::Transition, decision, Some(because));
        }
        search.commit(LedgerEntry::Decided(Decision::Alternative { pair, index }));
    }

    /// All alternatives of a robot's pairs with what is known of them.
    fn chain(&self, scene: &Scene, robot: RobotId, pairs: &[PairId]) -> Chain {
        let modes = self.served_modes(robot);
        let mut chain = Chain::default();
        for (at, pair) in pairs.iter().enumerate() {
            let around = &scene.events[pair.index()];
            chain
                .alternatives
                .push((0..self.offered[pair.index()].len()).map(|i| self.cost(*pair, i, around)).collect());
            if let Some(before) = at.checked_sub(1).map(|before| pairs[before]) {
                let free = vec![Some(Cost::default()); self.offered[pair.index()].len()];
                chain.steps.push(vec![free; self.offered[before.index()].len()]);
            }
        }
        for mode in &modes {
            self.add_mode(scene, mode, pairs, &mut chain);
        }
        chain
    }

    /// What an alternative costs, modes apart.
    fn cost(&self, pair: PairId, number: usize, around: &[Around; 2]) -> Option<Cost> {
        let blocked = self.blocked[pair.index()][number].iter();
        let ends = || blocked.clone().flat_map(|blocked| blocked.by.iter().zip(around));
        if ends().any(|(by, around)| !by.is_disjoint(&around.certain)) {
            return None;
        }
        let possible = ends().flat_map(|(by, around)| by.intersection(&around.possible));
        Some(Cost {
            penalties: self.penalties.get(&(pair, number)).copied().unwrap_or(0),
            obstructions: 0,
            possible: possible.collect::<BTreeSet<_>>().len() as u32,
            rank: number as u32,
        })
    }

    /// What is known of a mode, added to the alternatives and steps it belongs to.
    fn add_mode(&self, scene: &Scene, mode: &Mode, pairs: &[PairId], chain: &mut Chain) {
        let around = scene.about(mode);
        let layers = self.pairs_at_ends(mode).map(|pair| pairs.iter().position(|other| Some(*other) == pair));
        let known = self.known(mode);
        let obstructed = |answer: &ModeAnswer| self.first_to_order(mode, &answer.in_the_way).is_some();
        let of_known: Vec<Ends> =
            known.ways(around).filter(|(_, answer)| obstructed(answer)).map(|(ends, _)| ends).collect();
        if of_known.len() < LOOKS_FOR_A_FREE_WAY {
            of_known.into_iter().for_each(|ends| obstruct(chain, layers, ends, |_| true));
        } else {
            // Enough was looked at to take what is not known for obstructed.
            let free = |ends: Ends| known.way(ends, around).is_some_and(|answer| !obstructed(answer));
            obstruct(chain, layers, [None, None], |ends| !free(ends));
        }
        for no_way in self.no_ways_now(mode, around) {
            close(chain, layers, no_way.ends);
        }
    }
}

/// Adds an obstruction to all alternatives and steps with these ends of which `is_obstructed`.
fn obstruct(chain: &mut Chain, layers: [Option<usize>; 2], ends: Ends, is_obstructed: impl Fn(Ends) -> bool) {
    let matches = |end: Option<usize>, number: usize| end.is_none_or(|end| end == number);
    let obstruct = |cost: &mut Option<Cost>, ends: Ends| {
        let obstructions = u32::from(is_obstructed(ends));
        *cost = cost.map(|cost| cost + Cost { obstructions, ..Cost::default() });
    };
    match layers {
        [Some(from), Some(to)] if from != to => {
            for (i, row) in chain.steps[from].iter_mut().enumerate().filter(|(i, _)| matches(ends[0], *i)) {
                for (j, cost) in row.iter_mut().enumerate().filter(|(j, _)| matches(ends[1], *j)) {
                    obstruct(cost, [Some(i), Some(j)]);
                }
            }
        }
        [first, second] => {
            let Some(layer) = first.or(second) else { return };
            let matching = |(i, _): &(usize, &mut Option<Cost>)| matches(ends[0].or(ends[1]), *i);
            for (i, cost) in chain.alternatives[layer].iter_mut().enumerate().filter(matching) {
                obstruct(cost, [first.map(|_| i), second.map(|_| i)]);
            }
        }
    }
}

/// Closes the step, or the alternatives, with these ends; without any, all alternatives of the pair that the mode leads to.
fn close(chain: &mut Chain, layers: [Option<usize>; 2], ends: Ends) {
    match (layers, ends) {
        ([Some(from), Some(to)], [Some(i), Some(j)]) if from != to => chain.steps[from][i][j] = None,
        ([from, to], [None, None]) => to.or(from).into_iter().for_each(|layer| chain.alternatives[layer].fill(None)),
        _ => {
            for (layer, end) in layers.into_iter().zip(ends) {
                if let (Some(layer), Some(i)) = (layer, end) {
                    chain.alternatives[layer][i] = None;
                }
            }
        }
    }
}
