//! One placement candidate: alternatives for its pairs, roadmaps for its modes, orderings, composite motion.

use std::collections::BTreeSet;

use contract::{
    Alternative, Answer, Assignment, Decision, DiscoveredOrder, Job, LedgerEntry, PlacementCandidate, ProductRef,
    Request, StageKind, TransitionJob,
};
use model::{GraspId, PairId, Pose, Problem, Standing};
use plan::Cause;
use skeleton::{Occupancy, Skeleton};

use crate::asking::misfit;
use crate::budgets::Budgets;
use crate::choice::PairChoice;
use crate::conflict::{Choice, Conflict, Stuck};
use crate::roadmaps::ModeAnswer;
use crate::search::Search;

/// Alternatives asked for each pair.
const ALTERNATIVES: u32 = 48;

/// How often all alternatives of some pair may be given up. As pairs take turns, two that exclude one another would open
/// one another's alternatives for ever.
const OPENINGS: u32 = 32;

/// Other ways to do a pair that are looked at before an ordering is added for it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Detour {
    /// How many were looked at.
    pub(crate) steps: u32,
    /// The alternative from which they began.
    pub(crate) from: usize,
}

/// The choices of one placement candidate.
#[derive(Clone)]
pub(crate) struct Candidate<'a> {
    pub(crate) problem: &'a Problem,
    pub(crate) level: u32,
    pub(crate) budgets: Budgets<'a>,
    /// The event graph holds every ordering of `orders`.
    pub(crate) skeleton: Skeleton,
    /// `poses[object][hop]`; while hops are placed one by one, only those of the first hops.
    pub(crate) poses: Vec<Vec<Pose>>,
    pub(crate) choices: Vec<PairChoice>,
    /// Discovered orderings: those of the placement, then those added since.
    pub(crate) orders: Vec<DiscoveredOrder>,
    /// Alternatives of each pair as the transition stage gave them.
    pub(crate) offered: Vec<Vec<Alternative>>,
    /// How each pair's detours stand.
    pub(crate) detours: Vec<Detour>,
    /// Pairs of which every alternative was given up.
    pub(crate) used_up: BTreeSet<PairId>,
    /// How often all alternatives of a pair were opened again.
    openings: u32,
    /// Failures whose causes are not known that are still allowed, among them all of composite motion.
    pub(crate) patience: u32,
}

/// Roadmaps of all modes, robot by robot.
pub(crate) type Modes = Vec<Vec<ModeAnswer>>;

/// The product of a plan and its makespan (s).
pub(crate) type Found = (ProductRef, f64);

impl<'a> Candidate<'a> {
    pub(crate) fn new(
        search: &Search<'a>,
        level: u32,
        budgets: Budgets<'a>,
        skeleton: Skeleton,
        placement: &PlacementCandidate,
    ) -> Self {
        let problem = search.problem();
        let pose_after = |pair: PairId| {
            let placed = placement.placements.iter().find(|placed| placed.pair == pair);
            placed.map(|placed| placed.world_from_object)
        };
        let poses = (0..problem.movable.len())
            .map(|m| {
                let hops = skeleton.hops[m].iter().filter_map(|pair| pose_after(*pair));
                std::iter::once(problem.movable[m].world_from_start).chain(hops).collect()
            })
            .collect();
        Self {
            problem,
            level,
            budgets,
            skeleton,
            poses,
            choices: vec![PairChoice::default(); problem.pairs.len()],
            orders: placement.orders.clone(),
            offered: vec![Vec::new(); problem.pairs.len()],
            detours: vec![Detour::default(); problem.pairs.len()],
            used_up: BTreeSet::new(),
            openings: 0,
            patience: search.statement.options.composite_failures,
        }
    }

    /// Completes the candidate under its present orderings, revising alternatives and adding orderings on the way.
    pub(crate) fn settle(&mut self, search: &mut Search<'_>) -> Result<Found, Stuck> {
        self.drop_blocked(search, &self.every_pair())?;
        loop {
            let modes = self.roadmaps(search)?;
            let (stage, conflict) = match self.obstructed(&modes) {
                Some(obstructed) if self.detour(search, &obstructed) => continue,
                Some(obstructed) => match self.order(search, &obstructed) {
                    Ok(found) => return Ok(found),
                    Err(Stuck::Failed(conflict)) => (StageKind::Roadmap, conflict),
                    Err(fault) => return Err(fault),
                },
                None => match self.compose(search, &modes) {
                    Ok(found) => return Ok(found),
                    Err(Stuck::Failed(conflict)) => {
                        (StageKind::Composite, self.less_patient(StageKind::Composite, conflict)?)
                    }
                    Err(fault) => return Err(fault),
                },
            };
            self.fall_back(search, stage, conflict)?;
        }
    }

    /// Counts a failure whose causes are not known; when there were too many, the whole placement is given up.
    pub(crate) fn less_patient(&mut self, stage: StageKind, conflict: Conflict) -> Result<Conflict, Stuck> {
        self.patience = self.patience.saturating_sub(1);
        if self.patience > 0 { Ok(conflict) } else { Err(self.given_up(stage, conflict)) }
    }

    /// The placement is given up, although not everything was tried. This proves nothing about fewer choices than all.
    fn given_up(&mut self, stage: StageKind, mut conflict: Conflict) -> Stuck {
        self.patience = 0;
        conflict.choices = self.skeleton.occupancies().map(Choice::Pose).collect();
        conflict.causes.count(Cause::Budget { stage: stage.name().to_owned() });
        Stuck::Failed(conflict)
    }

    /// Asks for the alternatives of a pair.
    pub(crate) fn alternatives_job(&self, pair: PairId) -> Job {
        let [from, to] = [self.skeleton.picked(self.problem, pair), self.skeleton.placed(self.problem, pair)];
        self.budgets.job(Request::Transition(TransitionJob {
            pair,
            world_from_pick: self.pose(from),
            world_from_place: self.pose(to),
            level: self.level,
            first: 0,
            count: ALTERNATIVES,
        }))
    }

    pub(crate) fn every_pair(&self) -> Vec<PairId> {
        (0..self.problem.pairs.len()).map(PairId::at).collect()
    }

    /// Asks for the alternatives of pairs whose two poses are known. Of several failures the first is told, the others are
    /// laid aside: all can be learnt from.
    pub(crate) fn ask_alternatives(&mut self, search: &mut Search<'_>, pairs: &[PairId]) -> Result<(), Stuck> {
        let jobs: Vec<Job> = pairs.iter().map(|pair| self.alternatives_job(*pair)).collect();
        let mut conflicts = Vec::new();
        for ((pair, job), outcome) in pairs.iter().zip(&jobs).zip(search.ask(&jobs)?) {
            match outcome.result {
                Ok(Answer::Alternatives(alternatives)) => {
                    self.offered[pair.index()] = alternatives;
                    self.reopen(*pair);
                }
                Ok(_) => return Err(misfit(StageKind::Transition).into()),
                Err(report) => {
                    let at_fault = self.ends_at_fault(*pair, &report.causes);
                    let conflict = Conflict::of(at_fault, &report.causes, Some(search.id(job)));
                    conflicts.push(Conflict { under_any_orderings: true, ..conflict });
                }
            }
        }
        let mut conflicts = conflicts.into_iter();
        let first = conflicts.next();
        search.aside.extend(conflicts);
        first.map_or(Ok(()), |conflict| Err(Stuck::Failed(conflict)))
    }

    /// The poses that a failure of the transition stage depends on: one end if only that is out of reach, else both.
    fn ends_at_fault(&self, pair: PairId, causes: &[(Cause, u64)]) -> Vec<Choice> {
        let [from, to] = [self.skeleton.picked(self.problem, pair), self.skeleton.placed(self.problem, pair)];
        let pair = self.problem.pair(pair);
        let unreachable = |region: model::RegionId| {
            let name = &self.problem.regions[region.index()].name;
            causes.iter().any(|(cause, _)| matches!(cause, Cause::Unreachable { region, .. } if region == name))
        };
        match (pair.from != pair.to, unreachable(pair.from), unreachable(pair.to)) {
            (true, true, false) => vec![Choice::Pose(from)],
            (true, false, true) => vec![Choice::Pose(to)],
            _ => vec![Choice::Pose(from), Choice::Pose(to)],
        }
    }

    /// Revises the last pair that a conflict depends on; pairs that leave no alternative hand their conflicts on
    /// (conflict-directed backjumping, Prosser, doi:10.1111/j.1467-8640.1993.tb00310.x).
    pub(crate) fn revise(&mut self, search: &mut Search<'_>, mut conflict: Conflict) -> Result<(), Stuck> {
        while let Some(pair) = self.pair_to_revise(&conflict) {
            if self.leaves_detour(search, pair) {
                return Ok(());
            }
            conflict.choices.remove(&Choice::Alternative(pair));
            let because = conflict.first_cause();
            if let Some(given_up) = self.choices[pair.index()].chosen() {
                let decision = Decision::Alternative { pair, index: given_up.index };
                search.backtrack(StageKind::Transition, decision, because);
            }
            match self.choices[pair.index()].give_up(conflict) {
                Ok(next) => {
                    let index = next.index;
                    search.commit(LedgerEntry::Decided(Decision::Alternative { pair, index }));
                    return Ok(());
                }
                Err(all) => {
                    conflict = all;
                    self.used_up.insert(pair);
                    self.openings += 1;
                    if self.openings > OPENINGS {
                        return Err(self.given_up(StageKind::Transition, conflict));
                    }
                    conflict.choices.extend(self.ends(pair));
                    self.reopen(pair);
                }
            }
        }
        Err(Stuck::Failed(conflict))
    }

    /// The least often revised pair of the conflict, of several the last: pairs that block one another take turns.
    fn pair_to_revise(&self, conflict: &Conflict) -> Option<PairId> {
        let last = conflict.last_pair()?;
        let pairs = conflict.choices.iter().filter_map(|choice| match choice {
            Choice::Alternative(pair) => Some(*pair),
            Choice::Pose(_) => None,
        });
        let open = pairs.filter(|pair| self.choices[pair.index()].left().len() > 1);
        let turn = open.min_by_key(|pair| (self.choices[pair.index()].revisions, std::cmp::Reverse(*pair)));
        Some(turn.unwrap_or(last))
    }

    pub(crate) fn reopen(&mut self, pair: PairId) {
        let offered = self.offered[pair.index()].clone();
        self.choices[pair.index()].reopen(offered);
    }

    pub(crate) fn ends(&self, pair: PairId) -> [Choice; 2] {
        [self.skeleton.picked(self.problem, pair), self.skeleton.placed(self.problem, pair)].map(Choice::Pose)
    }

    /// Whether it is known where an object stands.
    pub(crate) fn is_placed(&self, occupancy: Occupancy) -> bool {
        (occupancy.hop as usize) < self.poses[occupancy.object.index()].len()
    }

    pub(crate) fn pose(&self, occupancy: Occupancy) -> Pose {
        self.poses[occupancy.object.index()][occupancy.hop as usize]
    }

    pub(crate) fn standing(&self, occupancy: Occupancy) -> Standing {
        Standing { object: occupancy.object, world_from_object: self.pose(occupancy) }
    }

    /// The chosen alternative of a pair.
    pub(crate) fn chosen(&self, pair: PairId) -> Result<&Alternative, Stuck> {
        self.choices[pair.index()].chosen().ok_or_else(|| Stuck::Failed(Conflict::default()))
    }

    pub(crate) fn assignment(&self) -> Assignment {
        let grasp = |choice: &PairChoice| choice.chosen().map_or(GraspId(0), |chosen| chosen.grasp);
        Assignment {
            poses: self.poses.clone(),
            grasps: self.choices.iter().map(grasp).collect(),
            orders: self.orders.clone(),
        }
    }
}
