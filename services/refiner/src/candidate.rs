//! One placement candidate: alternatives for its pairs, roadmaps for its modes, orderings, composite motion.

use std::collections::{BTreeMap, BTreeSet};

use contract::{
    Alternative, Answer, Assignment, DiscoveredOrder, Job, PlacementCandidate, ProductRef, Request, StageKind,
    TransitionJob,
};
use model::{GraspId, PairId, Pose, Problem, Standing};
use plan::Cause;
use skeleton::{Mode, Occupancy, Skeleton};

use crate::asking::misfit;
use crate::budgets::Budgets;
use crate::conflict::{Choice, Conflict, Stuck};
use crate::known::{Known, ModeAnswer};
use crate::reaches::Blocked;
use crate::search::Search;

/// Alternatives asked for each pair.
const ALTERNATIVES: u32 = 48;

/// Modes looked at for one candidate.
const LOOKS: u32 = 4096;

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
    /// The number of the sample that each of them is; 0 at a start.
    pub(crate) samples: Vec<Vec<u32>>,
    /// Discovered orderings: those of the placement, then those that are tried.
    pub(crate) orders: Vec<DiscoveredOrder>,
    /// How many of them are the placement's.
    pub(crate) placement_orders: usize,
    /// Alternatives of each pair as the transition stage gave them.
    pub(crate) offered: Vec<Vec<Alternative>>,
    /// What can be there at the two events of each pair.
    pub(crate) at_events: Vec<[Vec<Occupancy>; 2]>,
    /// What is in the way of each alternative, once asked for.
    pub(crate) blocked: Vec<Vec<Option<Blocked>>>,
    /// The alternative chosen of each pair, by its place among those offered.
    pub(crate) chosen: Vec<usize>,
    /// Alternatives of each pair that are not excluded.
    pub(crate) open: Vec<BTreeSet<usize>>,
    /// The last failure of each pair's present alternative.
    pub(crate) because: Vec<Option<Cause>>,
    /// What is known of each mode of each robot.
    pub(crate) known: Vec<Vec<Known>>,
    /// Orderings that cannot all be, with what that rests on.
    pub(crate) refuted: Vec<Conflict>,
    /// Choices for which a later stage has failed, and what that rests on.
    pub(crate) failed_together: BTreeMap<Vec<usize>, Conflict>,
    /// How often such failures were laid to an alternative.
    pub(crate) penalties: BTreeMap<(PairId, usize), u32>,
    /// How often each pair was the one to bear a penalty.
    pub(crate) turns: Vec<u32>,
    /// How often choices were met that had failed together.
    pub(crate) meetings: u32,
    /// Pairs that had no alternative left at some time.
    pub(crate) used_up: BTreeSet<PairId>,
    /// Modes that may still be looked at.
    pub(crate) looks: u32,
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
        let placed = |pair: &PairId| placement.placements.iter().find(|placed| placed.pair == *pair);
        let (mut poses, mut samples) = (Vec::new(), Vec::new());
        for (object, hops) in problem.movable.iter().zip(&skeleton.hops) {
            let placed = || hops.iter().filter_map(placed);
            let start = std::iter::once(object.world_from_start);
            poses.push(start.chain(placed().map(|placed| placed.world_from_object)).collect());
            samples.push(std::iter::once(0).chain(placed().map(|placed| placed.sample)).collect());
        }
        let pairs = problem.pairs.len();
        let nothing = |modes: &Vec<Mode>| modes.iter().map(|_| Known::default()).collect();
        Self {
            problem,
            level,
            budgets,
            known: skeleton.modes.iter().map(nothing).collect(),
            skeleton,
            poses,
            samples,
            orders: placement.orders.clone(),
            placement_orders: placement.orders.len(),
            offered: vec![Vec::new(); pairs],
            at_events: vec![[Vec::new(), Vec::new()]; pairs],
            blocked: vec![Vec::new(); pairs],
            chosen: vec![0; pairs],
            open: vec![BTreeSet::new(); pairs],
            because: vec![None; pairs],
            refuted: Vec::new(),
            failed_together: BTreeMap::new(),
            penalties: BTreeMap::new(),
            turns: vec![0; pairs],
            meetings: 0,
            used_up: BTreeSet::new(),
            looks: LOOKS,
            patience: search.statement.options.composite_failures,
        }
    }

    /// Completes the candidate under its present orderings, choosing alternatives and adding orderings on the way.
    pub(crate) fn settle(&mut self, search: &mut Search<'_>) -> Result<Found, Stuck> {
        loop {
            let modes = self.ways(search)?;
            if let Some(obstructed) = self.obstructed(&modes) {
                match self.order(search, &obstructed)? {
                    Some(found) => return Ok(found),
                    None => continue,
                }
            }
            match self.compose(search, &modes) {
                Err(Stuck::Failed(conflict)) => {
                    let conflict = self.less_patient(StageKind::Composite, conflict)?;
                    self.fall_back(search, StageKind::Composite, conflict)?;
                }
                ended => return ended,
            }
        }
    }

    /// There are more alternatives than before: what could not be may be now.
    pub(crate) fn begin_anew(&mut self) {
        self.used_up = BTreeSet::new();
        self.refuted = Vec::new();
        self.known.iter_mut().flatten().for_each(|known| known.assumed = Vec::new());
    }

    /// How many of the orderings that are only tried a conflict rests on.
    pub(crate) fn tried_orders(&self, conflict: &Conflict) -> usize {
        let tried = &self.orders[self.placement_orders..];
        tried.iter().filter(|order| conflict.orders.contains(&(order.before, order.after))).count()
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
                    self.note_events(*pair);
                    self.blocked[pair.index()] = vec![None; alternatives.len()];
                    self.offered[pair.index()] = alternatives;
                }
                Ok(_) => return Err(misfit(StageKind::Transition).into()),
                Err(report) => {
                    let poses = report.rests_on.unwrap_or_else(|| self.ends(*pair).to_vec());
                    conflicts.push(Conflict::of(poses, &report.causes, Some(search.id(job))));
                }
            }
        }
        let mut conflicts = conflicts.into_iter();
        let first = conflicts.next();
        search.aside.extend(conflicts);
        first.map_or(Ok(()), |conflict| Err(Stuck::Failed(conflict)))
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

    /// The number of the sample that a pose is.
    pub(crate) fn sample(&self, occupancy: Occupancy) -> u32 {
        self.samples[occupancy.object.index()][occupancy.hop as usize]
    }

    pub(crate) fn standing(&self, occupancy: Occupancy) -> Standing {
        Standing { object: occupancy.object, world_from_object: self.pose(occupancy) }
    }

    /// The chosen alternative of a pair.
    pub(crate) fn chosen(&self, pair: PairId) -> Result<&Alternative, Stuck> {
        let chosen = self.offered[pair.index()].get(self.chosen[pair.index()]);
        chosen.ok_or_else(|| Stuck::Failed(Conflict::default()))
    }

    pub(crate) fn assignment(&self) -> Assignment {
        let grasp = |pair: PairId| self.chosen(pair).map_or(GraspId(0), |chosen| chosen.grasp);
        Assignment {
            poses: self.poses.clone(),
            grasps: self.every_pair().into_iter().map(grasp).collect(),
            orders: self.orders.clone(),
        }
    }
}
