//! A toy search: candidates, transitions, pieces, modes, commitments, with backtracking and foresight.

use contract::{
    Answer, AskFault, AskStages, Assignment, ComposeJob, Composition, Decision, Digest, Foresight, Job, Ledger,
    LedgerEntry, ModeJob, Nogood, Outcome, PieceJob, PieceSpec, PlacementJob, ProblemStatement, ProductRef, Request,
    Soundness, StageKind, TransitionJob, encode_canonical,
};
use model::{PairId, Pose, RobotId};
use skeleton::ModeId;

/// Candidates tried.
const CANDIDATES: u32 = 40;
/// Modes of each robot.
const STEPS: u32 = 3;

/// How the toy search ended.
pub type ToyEnd = Result<Option<ProductRef>, AskFault>;

/// The ledger and the end of a search by these means.
pub fn whole_log(statement: &ProblemStatement, stages: &mut dyn AskStages) -> (Ledger, ToyEnd) {
    search(statement, stages, &mut |_| ())
}

/// Searches; `observe` is told of every committed entry.
pub fn search(
    statement: &ProblemStatement,
    stages: &mut dyn AskStages,
    observe: &mut dyn FnMut(&LedgerEntry),
) -> (Ledger, ToyEnd) {
    let mut search = Search { statement, stages, observe, ledger: Ledger::default() };
    let end = search.run();
    (search.ledger, end)
}

struct Search<'a> {
    statement: &'a ProblemStatement,
    stages: &'a mut dyn AskStages,
    observe: &'a mut dyn FnMut(&LedgerEntry),
    ledger: Ledger,
}

impl Search<'_> {
    fn run(&mut self) -> ToyEnd {
        for index in 0..CANDIDATES {
            self.foresee(index);
            self.ask(&[placement(index)])?;
            self.commit(LedgerEntry::Decided(Decision::Placement(index)));
            if let Some(plan) = self.candidate(index)? {
                self.commit(LedgerEntry::Solved { plan: plan.digest });
                return Ok(Some(plan));
            }
        }
        Ok(None)
    }

    /// What comes next if all goes well: the next candidate, and this one's transitions and pieces.
    fn foresee(&mut self, index: u32) {
        let pairs = self.statement.problem.pairs.len();
        let robots = self.statement.problem.robots.len();
        self.stages.foresee(Foresight {
            jobs: Box::new(move |_| {
                let transitions = (0..pairs).map(|pair| transition(index, pair));
                let pieces = (0..robots).flat_map(|robot| (0..STEPS).map(move |step| piece(index, robot, step)));
                transitions.chain(pieces).chain([placement(index + 1)]).collect()
            }),
        });
    }

    fn candidate(&mut self, index: u32) -> Result<Option<ProductRef>, AskFault> {
        let pairs = self.statement.problem.pairs.len();
        let transitions: Vec<Job> = (0..pairs).map(|pair| transition(index, pair)).collect();
        for (pair, outcome) in self.ask(&transitions)?.into_iter().enumerate() {
            if outcome.result.is_err() {
                let decision = Decision::Alternative { pair: PairId::at(pair), index };
                return self.back(StageKind::Placement, decision, &transitions[pair]);
            }
        }
        let mut roadmaps = Vec::new();
        for robot in 0..self.statement.problem.robots.len() {
            for step in 0..STEPS {
                match self.roadmap(index, robot, step)? {
                    Some(roadmap) => roadmaps.push((mode(robot, step), roadmap)),
                    None => return Ok(None),
                }
            }
        }
        self.compose(roadmaps)
    }

    fn roadmap(&mut self, index: u32, robot: usize, step: u32) -> Result<Option<ProductRef>, AskFault> {
        let piece = piece(index, robot, step);
        let Ok(Answer::Piece(base)) = self.ask_one(&piece)?.result else { return Ok(None) };
        let job = glued(robot, step, base);
        match self.ask_one(&job)?.result {
            Ok(Answer::Mode { roadmap, .. }) => Ok(Some(roadmap)),
            _ => self.back(StageKind::Transition, Decision::Commit(mode(robot, step)), &job),
        }
    }

    fn compose(&mut self, roadmaps: Vec<(ModeId, ProductRef)>) -> Result<Option<ProductRef>, AskFault> {
        let mut prefix = None;
        for (mode, roadmap) in roadmaps {
            let job = composed(Composition::CommitMode { prefix, mode, roadmap, next_roadmap: None, clear_of: vec![] });
            match self.ask_one(&job)?.result {
                Ok(Answer::Committed { prefix: longer, .. }) => prefix = Some(longer),
                _ => return self.back(StageKind::Roadmap, Decision::Commit(mode), &job),
            }
        }
        let Some(prefix) = prefix else { return Ok(None) };
        match self
            .ask_one(&composed(Composition::Assemble { prefix, shortest_s: Vec::new(), rounds: Vec::new() }))?
            .result
        {
            Ok(Answer::Plan { plan, .. }) => Ok(Some(plan)),
            _ => Ok(None),
        }
    }

    fn back<T>(&mut self, stage: StageKind, decision: Decision, proof: &Job) -> Result<Option<T>, AskFault> {
        let proof = self.stages.job_id(proof);
        let soundness = Soundness::Soft { level: 0 };
        self.commit(LedgerEntry::Learnt(Nogood { literals: Vec::new(), cause: None, soundness, proof }));
        self.commit(LedgerEntry::Backtrack { stage, decision, because: None });
        Ok(None)
    }

    fn ask_one(&mut self, job: &Job) -> Result<Outcome, AskFault> {
        let mut outcomes = self.ask(std::slice::from_ref(job))?;
        outcomes.pop().ok_or(AskFault::Cancelled)
    }

    fn ask(&mut self, jobs: &[Job]) -> Result<Vec<Outcome>, AskFault> {
        let outcomes = self.stages.ask(jobs)?;
        assert_eq!(jobs.len(), outcomes.len());
        for (job, outcome) in jobs.iter().zip(&outcomes) {
            let digest = Digest::of("toy outcome", &[&encode_canonical(outcome)]);
            let job = self.stages.job_id(job);
            self.commit(LedgerEntry::Used { job, outcome: digest });
        }
        Ok(outcomes)
    }

    fn commit(&mut self, entry: LedgerEntry) {
        (self.observe)(&entry);
        self.ledger.commit(entry);
    }
}

fn job(request: Request) -> Job {
    Job { request, budget: u64::MAX }
}

fn placement(index: u32) -> Job {
    job(Request::Placement(PlacementJob { level: 0, first: index, count: 1, nogoods: Vec::new() }))
}

fn transition(index: u32, pair: usize) -> Job {
    job(Request::Transition(TransitionJob {
        pair: PairId::at(pair),
        world_from_pick: Pose::identity(),
        world_from_place: Pose::translation(f64::from(index), 0.0, 0.0),
        level: 0,
        first: 0,
        count: 1,
    }))
}

fn piece(index: u32, robot: usize, step: u32) -> Job {
    let robot = RobotId::at(robot);
    job(Request::Piece(PieceJob { robot, holding: None, level: index * STEPS + step, spec: PieceSpec::Base }))
}

fn mode(robot: usize, step: u32) -> ModeId {
    ModeId { robot: RobotId::at(robot), step }
}

fn glued(robot: usize, step: u32, base: ProductRef) -> Job {
    job(Request::Mode(ModeJob {
        mode: mode(robot, step),
        holding: None,
        start: Vec::new(),
        goal: Vec::new(),
        base: Some(base),
        start_arm: None,
        goal_arm: None,
        certain: Vec::new(),
        level: 0,
        possible: Vec::new(),
    }))
}

fn composed(composition: Composition) -> Job {
    let assignment = Assignment { poses: Vec::new(), grasps: Vec::new(), orders: Vec::new() };
    job(Request::Compose(ComposeJob { assignment, composition }))
}
