//! One placement candidate: alternatives for its pairs, roadmaps for its modes, composite motion.

use contract::{
    Alternative, Answer, Assignment, Decision, LedgerEntry, PlacementCandidate, ProductRef, Request, StageKind,
    TransitionJob,
};
use model::{GraspId, ObjectId, PairId, Pose, Problem, Standing};
use plan::Cause;
use skeleton::{Occupancy, Skeleton};

use crate::budgets::Budgets;
use crate::roadmaps::ModeAnswer;
use crate::search::{Search, Stuck, failed, misfit};

/// Alternatives asked for each pair.
const ALTERNATIVES: u32 = 48;
/// Composite failures of one placement candidate after which it is given up.
const COMPOSITE_FAILURES: u32 = 8;

/// The choices of one placement candidate.
pub(crate) struct Candidate<'a> {
    pub(crate) problem: &'a Problem,
    pub(crate) level: u32,
    pub(crate) budgets: Budgets,
    pub(crate) skeleton: Skeleton,
    /// `poses[object][hop]`.
    pub(crate) poses: Vec<Vec<Pose>>,
    /// Alternatives left for each pair; the first is the present choice.
    pub(crate) alternatives: Vec<Vec<Alternative>>,
    /// How often each pair's alternative was given up.
    revisions: Vec<u32>,
    placement: &'a PlacementCandidate,
}

impl<'a> Candidate<'a> {
    pub(crate) fn new(
        problem: &'a Problem,
        level: u32,
        budgets: Budgets,
        skeleton: Skeleton,
        placement: &'a PlacementCandidate,
    ) -> Self {
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
        let alternatives = vec![Vec::new(); problem.pairs.len()];
        let revisions = vec![0; problem.pairs.len()];
        Self { problem, level, budgets, skeleton, poses, alternatives, revisions, placement }
    }

    /// Completes the candidate to a plan.
    pub(crate) fn complete(mut self, search: &mut Search<'_>) -> Result<(ProductRef, f64), Stuck> {
        self.ask_alternatives(search)?;
        for pair in 0..self.problem.pairs.len() {
            self.drop_blocked(search, PairId::at(pair))?;
        }
        for _ in 0..COMPOSITE_FAILURES {
            let modes = self.roadmaps(search)?;
            match self.compose(search, &modes) {
                Ok(plan) => return Ok(plan),
                Err(Blocked::Fault(fault)) => return Err(Stuck::Fault(fault)),
                Err(Blocked::Between(pairs, causes)) => {
                    let pair = self.least_revised(&pairs).ok_or_else(|| Stuck::Failed(causes.clone()))?;
                    self.next_alternative(search, pair, causes)?;
                }
            }
        }
        Err(Stuck::Failed(vec![(Cause::Budget { stage: StageKind::Composite.name().to_owned() }, 1)]))
    }

    fn ask_alternatives(&mut self, search: &mut Search<'_>) -> Result<(), Stuck> {
        let jobs: Vec<_> = (0..self.problem.pairs.len())
            .map(|i| {
                let pair = PairId::at(i);
                let [from, to] = [self.skeleton.picked(self.problem, pair), self.skeleton.placed(self.problem, pair)];
                self.budgets.job(Request::Transition(TransitionJob {
                    pair,
                    world_from_pick: self.pose(from),
                    world_from_place: self.pose(to),
                    level: self.level,
                    first: 0,
                    count: ALTERNATIVES,
                }))
            })
            .collect();
        for (i, outcome) in search.ask(&jobs)?.into_iter().enumerate() {
            match outcome.result {
                Ok(Answer::Alternatives(alternatives)) => self.alternatives[i] = alternatives,
                Ok(_) => return Err(misfit(StageKind::Transition).into()),
                Err(report) => return Err(failed(report)),
            }
        }
        Ok(())
    }

    /// Of pairs that block one another, the one revised least often so far that has another alternative.
    fn least_revised(&self, pairs: &[PairId]) -> Option<PairId> {
        let open = pairs.iter().filter(|pair| self.alternatives[pair.index()].len() > 1);
        open.min_by_key(|pair| self.revisions[pair.index()]).copied()
    }

    /// Gives up the present alternative of a pair for the next one.
    pub(crate) fn next_alternative(
        &mut self,
        search: &mut Search<'_>,
        pair: PairId,
        causes: Vec<(Cause, u64)>,
    ) -> Result<(), Stuck> {
        let left = &mut self.alternatives[pair.index()];
        if left.is_empty() {
            return Err(Stuck::Failed(causes));
        }
        let given_up = left.remove(0);
        self.revisions[pair.index()] += 1;
        search.backtrack(StageKind::Transition, Decision::Alternative { pair, index: given_up.index }, &causes);
        match left.first() {
            Some(next) => {
                let index = next.index;
                search.commit(LedgerEntry::Decided(Decision::Alternative { pair, index }));
                Ok(())
            }
            None => Err(Stuck::Failed(causes)),
        }
    }

    pub(crate) fn pose(&self, occupancy: Occupancy) -> Pose {
        self.poses[occupancy.object.index()][occupancy.hop as usize]
    }

    pub(crate) fn standing(&self, occupancy: Occupancy) -> Standing {
        Standing { object: occupancy.object, world_from_object: self.pose(occupancy) }
    }

    pub(crate) fn chosen(&self, pair: PairId) -> Result<&Alternative, Stuck> {
        self.alternatives[pair.index()].first().ok_or_else(|| Stuck::Failed(Vec::new()))
    }

    pub(crate) fn assignment(&self) -> Assignment {
        let grasp = |alternatives: &Vec<Alternative>| alternatives.first().map_or(GraspId(0), |chosen| chosen.grasp);
        Assignment {
            poses: self.poses.clone(),
            grasps: self.alternatives.iter().map(grasp).collect(),
            orders: self.placement.orders.clone(),
        }
    }

    /// Name of the object for messages.
    pub(crate) fn object_name(&self, object: ObjectId) -> String {
        self.problem.movable[object.index()].name.clone()
    }
}

/// Why composite motion was not found.
pub(crate) enum Blocked {
    /// Asking failed.
    Fault(contract::AskFault),
    /// One of these pairs should be done in another way.
    Between(Vec<PairId>, Vec<(Cause, u64)>),
}

impl From<contract::AskFault> for Blocked {
    fn from(fault: contract::AskFault) -> Self {
        Self::Fault(fault)
    }
}

/// Roadmaps of all modes, robot by robot.
pub(crate) type Modes = Vec<Vec<ModeAnswer>>;
