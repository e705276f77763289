//! Toy stages: pure functions of their jobs that fail now and then.

use contract::{
    Answer, CauseTally, Commitment, ComposeJob, Composition, Digest, Interrupted, Job, JobContext, ModeJob,
    ModeRoadmap, Outcome, PlacementCandidate, Prefix, Product, Request, RoadmapPiece, Stage, StageKind, VertexId,
};
use plan::Cause;

/// What toy workers say they are.
pub fn toy_implementation(stage: StageKind) -> String {
    format!("toy-{stage}/1")
}

/// A toy stage. Before each job it calls `trouble`, which may do as it likes to the thread or process it runs in.
pub struct ToyStage {
    /// Called with every job and its identity's first byte.
    pub trouble: Box<dyn Fn(&Job) + Send>,
    /// Size of every roadmap piece (configurations).
    pub piece_vertices: usize,
    /// Work of each job (digests): takes time, and polls for cancellation.
    pub labour: u64,
}

impl Default for ToyStage {
    fn default() -> Self {
        Self { trouble: Box::new(|_| ()), piece_vertices: 40, labour: 0 }
    }
}

impl Stage for ToyStage {
    fn refine(&self, job: &Job, context: &mut JobContext<'_>) -> Result<Outcome, Interrupted> {
        (self.trouble)(job);
        let mut luck = context.id().0;
        for _ in 0..self.labour {
            luck = Digest::of("labour", &[&luck.0]);
            context.spend(1)?;
        }
        let luck = u64::from(context.id().0.0[0]);
        match &job.request {
            Request::Placement(_) => {
                let candidate = |index| PlacementCandidate { index, placements: Vec::new(), orders: Vec::new() };
                let Request::Placement(job) = &job.request else { return Err(Interrupted::Unfit(String::new())) };
                let all = (job.first..job.first + job.count).map(candidate).collect();
                Ok(Outcome::answer(Answer::Placements(all), luck))
            }
            Request::Hop(_) => {
                let (choices, against, causes) = (Vec::new(), Vec::new(), Vec::new());
                Ok(Outcome::answer(Answer::Hop { choices, against, causes }, luck))
            }
            Request::Transition(job) if luck.is_multiple_of(4) => Ok(failure(&format!("pair {}", job.pair.0), luck)),
            Request::Transition(_) => Ok(Outcome::answer(Answer::Alternatives(Vec::new()), luck)),
            Request::Samples(_) => Ok(Outcome::answer(Answer::Samples(Vec::new()), luck)),
            Request::GraspBlockers(job) => Ok(Outcome::answer(Answer::Blocked(vec![false; job.standing.len()]), luck)),
            Request::Blockers(job) => Ok(Outcome::answer(Answer::Blocked(vec![false; job.standing.len()]), luck)),
            Request::Piece(job) => {
                let vertices = (0..self.piece_vertices).map(|i| vec![luck as f64, i as f64]).collect();
                let piece = RoadmapPiece { robot: job.robot, holding: job.holding, vertices, edges: Vec::new() };
                let product = context.publish(&Product::Piece(piece))?;
                Ok(Outcome::answer(Answer::Piece(product), luck))
            }
            Request::Mode(job) => glue(job, luck, context),
            Request::Compose(job) => compose(job, luck, context),
        }
    }
}

fn glue(job: &ModeJob, luck: u64, context: &JobContext<'_>) -> Result<Outcome, Interrupted> {
    let mut vertices = Vec::new();
    for part in [job.base, job.start_arm, job.goal_arm].into_iter().flatten() {
        match context.product(&part)? {
            Product::Piece(piece) => vertices.extend(piece.vertices),
            _ => return Err(Interrupted::Unfit("no piece".to_owned())),
        }
    }
    if luck.is_multiple_of(6) {
        return Ok(failure(&format!("mode {}", job.mode.step), luck));
    }
    let shortest_s = vertices.len() as f64;
    let roadmap = ModeRoadmap {
        mode: job.mode,
        holding: job.holding,
        cost_to_go_s: vec![f64::INFINITY; vertices.len()],
        vertices,
        edges: Vec::new(),
        start: VertexId(0),
        goal: VertexId(0),
        parking: Vec::new(),
        possible: Vec::new(),
    };
    let roadmap = context.publish(&Product::Mode(roadmap))?;
    Ok(Outcome::answer(Answer::Mode { roadmap, shortest_s, in_the_way: Vec::new() }, luck))
}

fn compose(job: &ComposeJob, luck: u64, context: &JobContext<'_>) -> Result<Outcome, Interrupted> {
    match &job.composition {
        Composition::CommitMode { prefix, mode, roadmap, .. } => {
            let Product::Mode(roadmap) = context.product(roadmap)? else {
                return Err(Interrupted::Unfit("no roadmap".to_owned()));
            };
            if luck.is_multiple_of(7) {
                return Ok(failure(&format!("commit {}", mode.step), luck));
            }
            let event_s = roadmap.vertices.len() as f64 + luck as f64;
            let commitment = Commitment {
                mode: *mode,
                holding: None,
                moves: Vec::new(),
                event_s,
                tail: Vec::new(),
                tail_holding: None,
            };
            let prefix = Prefix { parent: *prefix, commitments: vec![commitment], tails: Vec::new() };
            let prefix = context.publish(&Product::Prefix(prefix))?;
            Ok(Outcome::answer(Answer::Committed { prefix, event_s, tail_s: event_s }, luck))
        }
        Composition::Assemble { prefix, .. } => {
            let mut told = String::new();
            let mut next = Some(*prefix);
            while let Some(part) = next {
                let Product::Prefix(prefix) = context.product(&part)? else {
                    return Err(Interrupted::Unfit("no prefix".to_owned()));
                };
                prefix.commitments.iter().for_each(|made| told += &format!("{:?} at {}\n", made.mode, made.event_s));
                next = prefix.parent;
            }
            let makespan_s = told.len() as f64;
            let plan = context.publish(&Product::Plan(told.into_bytes()))?;
            Ok(Outcome::answer(Answer::Plan { plan, makespan_s }, luck))
        }
        Composition::Drrt { .. }
        | Composition::Repair { .. }
        | Composition::Synchronous { .. }
        | Composition::Passages { .. } => {
            Err(Interrupted::Unfit("no other composite planner among the toys".to_owned()))
        }
    }
}

fn failure(region: &str, work: u64) -> Outcome {
    let mut causes = CauseTally::default();
    causes.count(Cause::NoPlacement { object: "toy".to_owned(), region: region.to_owned() });
    Outcome::soft_failure(causes, 0, work)
}
