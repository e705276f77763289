//! Levels and placement candidates: the outer loops of the search.

use std::collections::{BTreeMap, BTreeSet};

use contract::{
    Answer, AskFault, AskStages, CauseTally, Decision, FailureReport, Job, JobId, Ledger, LedgerEntry, Literal,
    MOST_PLACEMENT_SAMPLES, Merge, Nogood, PlacementCandidate, PlacementJob, ProblemStatement, Request, SamplesJob,
    Soundness, StageKind, WorkKind,
};
use model::{FailurePolicy, PairId, Pose, Problem};
use plan::{Cause, Certificate, PairPoint, ResultKind, StageCount};
use skeleton::{Cycle, Skeleton};

use crate::asking::misfit;
use crate::budgets::Budgets;
use crate::candidate::{Candidate, Found};
use crate::conflict::{Choice, Conflict, Halt, Stuck};
use crate::generalise::{Lesson, Meeting, Table};
use crate::{End, Refinement};

/// State of one search.
pub(crate) struct Search<'a> {
    pub(crate) statement: &'a ProblemStatement,
    pub(crate) stages: &'a mut dyn AskStages,
    observe: &'a mut dyn FnMut(&LedgerEntry),
    ledger: Ledger,
    pub(crate) causes: CauseTally,
    /// Causes met since the present placement candidate was begun.
    pub(crate) met: CauseTally,
    /// Further conflicts of the present placement candidate than the one for which it is given up. They rest on no ordering
    /// that is only tried.
    pub(crate) aside: Vec<Conflict>,
    /// What the present placement candidate has shown of others.
    pub(crate) lessons: Vec<Lesson>,
    /// Level of the present candidate's placements.
    placement_level: u32,
    /// Samples of hops at that level, once asked for.
    samples: BTreeMap<PairId, Vec<(u32, Pose)>>,
    /// Which of them leave a hand no grasp, once asked for.
    pub(crate) tables: BTreeMap<Meeting, Table>,
    /// Tables from which lessons were drawn.
    pub(crate) taught: BTreeSet<Meeting>,
    pub(crate) used: BTreeSet<JobId>,
    pub(crate) counts: BTreeMap<StageKind, StageCount>,
    /// Work units spent on what may be limited.
    pub(crate) spent: BTreeMap<WorkKind, u64>,
    /// The pieces that were asked for, if they may be asked for again with more samples.
    pub(crate) pieces: BTreeMap<JobId, Job>,
}

/// How far one level came.
pub(crate) enum LevelEnd {
    Solved(Found),
    /// The stages after placement fail whatever is placed where, or as many candidates were tried as may be.
    Exhausted,
    /// There is no further candidate.
    NoPlacement(FailureReport),
}

impl<'a> Search<'a> {
    pub(crate) fn new(
        statement: &'a ProblemStatement,
        stages: &'a mut dyn AskStages,
        observe: &'a mut dyn FnMut(&LedgerEntry),
    ) -> Self {
        Self {
            statement,
            stages,
            observe,
            ledger: Ledger::default(),
            causes: CauseTally::default(),
            met: CauseTally::default(),
            aside: Vec::new(),
            lessons: Vec::new(),
            placement_level: 0,
            samples: BTreeMap::new(),
            tables: BTreeMap::new(),
            taught: BTreeSet::new(),
            used: BTreeSet::new(),
            counts: BTreeMap::new(),
            spent: BTreeMap::new(),
            pieces: BTreeMap::new(),
        }
    }

    pub(crate) fn problem(&self) -> &'a Problem {
        &self.statement.problem
    }

    pub(crate) fn run(mut self) -> Refinement {
        let end = match self.levels() {
            Ok(Some((plan, makespan_s))) => {
                self.commit(LedgerEntry::Solved { plan: plan.digest });
                End::Solved { plan, makespan_s }
            }
            Ok(None) => self.failed(ResultKind::SamplesExhausted, None),
            Err(Halt::Proven(report)) => {
                self.causes.count_all(&report.causes);
                self.failed(ResultKind::InfeasibleProven, report.certificate)
            }
            Err(Halt::Stopped(causes)) => {
                self.causes.count_all(&causes);
                self.failed(ResultKind::SamplesExhausted, None)
            }
            Err(Halt::LimitReached(work)) => {
                self.met.count(Cause::Budget { stage: work.to_string() });
                self.cut_short()
            }
            Err(Halt::Fault(AskFault::TimeLimit)) => self.cut_short(),
            Err(Halt::Fault(fault)) => End::Fault(fault),
        };
        let stages = self.counts.into_values().collect();
        Refinement { ledger: self.ledger, end, stages }
    }

    fn failed(&mut self, result: ResultKind, certificate: Option<Certificate>) -> End {
        End::Failed { result, causes: std::mem::take(&mut self.causes).ranked(), certificate }
    }

    /// What was met on the way is all that is known.
    fn cut_short(&mut self) -> End {
        let met = std::mem::take(&mut self.met).ranked();
        self.causes.count_all(&met);
        self.failed(ResultKind::LimitReached, None)
    }

    fn levels(&mut self) -> Result<Option<Found>, Halt> {
        let skeleton = match Skeleton::of_problem(self.problem()) {
            Ok(skeleton) => skeleton,
            Err(cycle) => {
                self.causes.count(self.cycle_cause(&cycle));
                return Ok(None);
            }
        };
        for level in 0..=self.problem().levels.highest {
            self.commit(LedgerEntry::Decided(Decision::Level(level)));
            self.forget_samples();
            let end = match self.statement.options.merge {
                Merge::None => self.level(level, &skeleton)?,
                Merge::PlacementAndTransition | Merge::PlacementToRoadmap => self.level_hop_by_hop(level, &skeleton)?,
            };
            match end {
                LevelEnd::Solved(found) => return Ok(Some(found)),
                // No level can help.
                LevelEnd::NoPlacement(report) if report.soundness == Soundness::Hard => return Ok(None),
                LevelEnd::NoPlacement(_) | LevelEnd::Exhausted => {}
            }
            if self.policy(StageKind::Placement) == FailurePolicy::Stop {
                self.commit(LedgerEntry::Stopped { stage: StageKind::Placement });
                return Ok(None);
            }
        }
        Ok(None)
    }

    /// The candidates of a level; where there are no more, those of more samples, if the policy wants them.
    fn level(&mut self, level: u32, skeleton: &Skeleton) -> Result<LevelEnd, Halt> {
        let mut nogoods = Vec::new();
        let mut end = self.candidates([level, level], &mut nogoods, skeleton)?;
        for doublings in self.policy(StageKind::Placement).doublings() {
            let more_can_help = match &end {
                LevelEnd::NoPlacement(report) => report.soundness != Soundness::Hard,
                LevelEnd::Solved(_) | LevelEnd::Exhausted => false,
            };
            if !more_can_help {
                break;
            }
            self.decide_more(StageKind::Placement, doublings);
            end = self.candidates([level + doublings, level], &mut nogoods, skeleton)?;
        }
        Ok(end)
    }

    /// Candidates one after the other, placements at one level, all else at another; with causes, each failure excludes
    /// every candidate that shares its choices.
    fn candidates(
        &mut self,
        [of_placement, level]: [u32; 2],
        nogoods: &mut Vec<Vec<Literal>>,
        skeleton: &Skeleton,
    ) -> Result<LevelEnd, Halt> {
        let with_causes = self.policy(StageKind::Transition).tells_causes();
        for tried in 0..self.statement.options.candidates {
            let first = if with_causes { 0 } else { tried };
            let candidate = match self.next_candidate(of_placement, first, nogoods)? {
                Ok(candidate) => candidate,
                Err(report) => return Ok(LevelEnd::NoPlacement(report)),
            };
            self.commit(LedgerEntry::Decided(Decision::Placement(tried)));
            self.met = CauseTally::default();
            let conflict = match self.refine(level, skeleton, &candidate) {
                Ok(found) => return Ok(LevelEnd::Solved(found)),
                Err(Stuck::Halted(halt)) => return Err(halt),
                Err(Stuck::Failed(conflict)) => conflict,
            };
            self.met = CauseTally::default();
            self.causes.count_all(&conflict.causes.clone().ranked());
            self.backtrack(StageKind::Placement, Decision::Placement(tried), conflict.first_cause());
            if with_causes && !self.learn_all(level, conflict, &candidate, nogoods) {
                return Ok(LevelEnd::Exhausted);
            }
        }
        Ok(LevelEnd::Exhausted)
    }

    /// The next placement candidate, or why there is none. A failure that rests on nogoods is never a hard one.
    fn next_candidate(
        &mut self,
        level: u32,
        first: u32,
        nogoods: &[Vec<Literal>],
    ) -> Result<Result<PlacementCandidate, FailureReport>, Halt> {
        let most = (MOST_PLACEMENT_SAMPLES / u64::from(self.problem().levels.placements.max(1))).max(1).ilog2();
        let level = level.min(most);
        self.place_at(level);
        let job = PlacementJob { level, first, count: 1, nogoods: nogoods.to_vec() };
        let job = Budgets::at(&self.problem().levels, level, &self.statement.options).job(Request::Placement(job));
        match self.ask_one(&job)?.result {
            Ok(Answer::Placements(candidates)) => {
                let none = || FailureReport::soft(CauseTally::default(), level);
                Ok(candidates.into_iter().next().ok_or_else(none))
            }
            Ok(_) => Err(misfit(StageKind::Placement).into()),
            Err(mut report) => {
                self.causes.count_all(&report.causes);
                self.met = CauseTally::default();
                if !nogoods.is_empty() {
                    report.soundness = Soundness::Soft { level };
                }
                Ok(Err(report))
            }
        }
    }

    /// Numbers and poses of the samples of a pair's hop.
    pub(crate) fn samples_of(&mut self, pair: PairId) -> Result<Vec<(u32, Pose)>, Halt> {
        let level = self.placement_level;
        if let Some(known) = self.samples.get(&pair) {
            return Ok(known.clone());
        }
        let request = Request::Samples(SamplesJob { pair, level });
        let job = Budgets::at(&self.problem().levels, level, &self.statement.options).job(request);
        let samples = match self.ask_one(&job)?.result {
            Ok(Answer::Samples(samples)) => samples,
            Ok(_) => return Err(misfit(StageKind::Placement).into()),
            Err(_) => Vec::new(),
        };
        self.samples.insert(pair, samples.clone());
        Ok(samples)
    }

    /// Placements are from now on those of a level.
    pub(crate) fn place_at(&mut self, level: u32) {
        if self.placement_level != level {
            self.forget_samples();
        }
        self.placement_level = level;
    }

    /// What is known of samples counts for one level of grasps, too.
    fn forget_samples(&mut self) {
        (self.samples, self.tables, self.taught) = Default::default();
    }

    /// Learns from the conflict for which a candidate was given up and from those laid aside. False: one of them depends on
    /// nothing that placement chooses.
    fn learn_all(
        &mut self,
        level: u32,
        conflict: Conflict,
        candidate: &PlacementCandidate,
        nogoods: &mut Vec<Vec<Literal>>,
    ) -> bool {
        let others = std::mem::take(&mut self.aside);
        others.iter().for_each(|other| self.causes.count_all(&other.causes.clone().ranked()));
        for conflict in std::iter::once(conflict).chain(others) {
            let literals = literals_of(self.problem(), &conflict, candidate);
            if literals.is_empty() {
                return false;
            }
            self.learn(level, &conflict, &literals);
            nogoods.push(literals);
        }
        for Lesson { literals, cause, proof } in std::mem::take(&mut self.lessons) {
            if literals.is_empty() || nogoods.contains(&literals) {
                continue;
            }
            let (cause, soundness) = (Some(cause), Soundness::Soft { level });
            self.commit(LedgerEntry::Learnt(Nogood { literals: literals.clone(), cause, soundness, proof }));
            nogoods.push(literals);
        }
        true
    }

    pub(crate) fn learn(&mut self, level: u32, conflict: &Conflict, literals: &[Literal]) {
        let Some(proof) = conflict.proof else { return };
        self.commit(LedgerEntry::Learnt(Nogood {
            literals: literals.to_vec(),
            cause: conflict.first_cause(),
            soundness: Soundness::Soft { level },
            proof,
        }));
    }

    pub(crate) fn refine(
        &mut self,
        level: u32,
        skeleton: &Skeleton,
        candidate: &PlacementCandidate,
    ) -> Result<Found, Stuck> {
        self.aside.clear();
        self.lessons.clear();
        let budgets = Budgets::at(&self.problem().levels, level, &self.statement.options);
        let mut skeleton = skeleton.clone();
        for order in &candidate.orders {
            if let Err(cycle) = skeleton.graph.add(order.before, order.after, skeleton::ArcOrigin::Discovered) {
                let causes = [(self.cycle_cause(&cycle), 1)];
                let poses = skeleton.occupancies().map(Choice::Pose);
                let mut conflict = Conflict::of(poses, &causes, None);
                conflict.orders = candidate.orders.iter().map(|order| (order.before, order.after)).collect();
                return Err(Stuck::Failed(conflict));
            }
        }
        Candidate::new(self, level, budgets, skeleton, candidate).complete(self)
    }

    /// Commits a backtrack request.
    pub(crate) fn backtrack(&mut self, stage: StageKind, decision: Decision, because: Option<Cause>) {
        self.commit(LedgerEntry::Backtrack { stage, decision, because });
    }

    pub(crate) fn commit(&mut self, entry: LedgerEntry) {
        (self.observe)(&entry);
        self.ledger.commit(entry);
    }

    fn cycle_cause(&self, cycle: &Cycle) -> Cause {
        let point = |event: skeleton::Event| PairPoint {
            pair: self.problem().pair(event.pair).name.clone(),
            point: event.point,
        };
        Cause::Cycle { points: cycle.0.iter().map(|arc| point(arc.before)).collect() }
    }
}

/// What a conflict says about a placement candidate: the samples and orderings it rests on. Start poses are nobody's choice.
pub(crate) fn literals_of(problem: &Problem, conflict: &Conflict, candidate: &PlacementCandidate) -> Vec<Literal> {
    let mut literals = Vec::new();
    for choice in &conflict.choices {
        let Choice::Pose(occupancy) = *choice else { continue };
        let creates = |pair: model::PairId| {
            let pair = problem.pair(pair);
            (pair.object, pair.hop) == (occupancy.object, occupancy.hop)
        };
        let placed = candidate.placements.iter().find(|placed| creates(placed.pair));
        literals.extend(placed.map(|placed| Literal::Pose { occupancy, sample: placed.sample }));
    }
    literals.extend(conflict.orders.iter().map(|(before, after)| Literal::Order { before: *before, after: *after }));
    literals
}
