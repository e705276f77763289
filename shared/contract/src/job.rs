//! Jobs: small questions to stages, each a value that holds or names everything its answer depends on.

use model::{Configuration, Holding, PairId, Pose, RobotId, Standing};
use plan::PairEnd;
use serde::{Deserialize, Serialize};
use skeleton::{Event, ModeId, Occupancy};

use crate::scope::Scope;
use crate::{Assignment, Digest, Literal, Placed, ProblemStatement, ProductRef, Reach, StageKind};

/// Identity of a job: equal for equal questions to equal implementations under equal circumstances.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct JobId(pub Digest);

/// A question and the work that may be spent on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Job {
    /// Question.
    pub request: Request,
    /// Work units that may be spent.
    pub budget: u64,
}

/// What is asked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Request {
    /// Placement: candidates.
    Placement(PlacementJob),
    /// Transition: alternatives of a pair.
    Transition(TransitionJob),
    /// Transition: what standing objects block a reach.
    Blockers(BlockersJob),
    /// Roadmap: a piece.
    Piece(PieceJob),
    /// Roadmap: the glued roadmap of a mode.
    Mode(ModeJob),
    /// Composite.
    Compose(ComposeJob),
    /// Placement: choices for one hop.
    Hop(HopJob),
    /// Placement: the samples of one hop.
    Samples(SamplesJob),
    /// Transition: what standing objects leave no grasp at one end of a pair.
    GraspBlockers(GraspBlockersJob),
}

/// Most samples of one hop that a level may have.
pub const MOST_PLACEMENT_SAMPLES: u64 = 1 << 14;

/// Asks for `count` candidates from number `first` on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlacementJob {
    /// Sample level; one with more than [`MOST_PLACEMENT_SAMPLES`] is refused.
    pub level: u32,
    /// First candidate's index in the canonical enumeration.
    pub first: u32,
    /// Number of candidates.
    pub count: u32,
    /// Combinations of placements (and orders) that must not be offered.
    pub nogoods: Vec<Vec<Literal>>,
}

/// Asks for `count` choices for the hop of a pair from number `first` on, given what is placed: for searches that place
/// hop by hop. Hops that are neither placed nor asked for do not count.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HopJob {
    /// The pair that places.
    pub pair: PairId,
    /// Sample level.
    pub level: u32,
    /// Other hops that have their places.
    pub placed: Vec<Placed>,
    /// Orderings added for them.
    pub orders: Vec<(Event, Event)>,
    /// First choice's index in the canonical enumeration.
    pub first: u32,
    /// Number of choices.
    pub count: u32,
}

/// Asks for the samples of the hop of a pair.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SamplesJob {
    /// The pair that places.
    pub pair: PairId,
    /// Sample level.
    pub level: u32,
}

/// Asks which of the standing objects the hand alone cannot but touch at one end of a pair, whatever the grasp, the stand
/// and the arm: at the object and on the short ways off it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GraspBlockersJob {
    /// Pair.
    pub pair: PairId,
    /// Which end.
    pub end: PairEnd,
    /// Where the pair's object is there.
    pub world_from_object: Pose,
    /// Sample level: how many grasps count.
    pub level: u32,
    /// Objects that may stand there.
    pub standing: Vec<Standing>,
}

/// Asks for `count` alternatives of a pair from number `first` on. Only the robot, the object and fixed objects count.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TransitionJob {
    /// Pair.
    pub pair: PairId,
    /// Where the object is taken from.
    pub world_from_pick: Pose,
    /// Where it is brought.
    pub world_from_place: Pose,
    /// Sample level.
    pub level: u32,
    /// First alternative's index in the canonical enumeration.
    pub first: u32,
    /// Number of alternatives.
    pub count: u32,
}

/// Asks which of the standing objects block a reach, that is, its short ways `approach` and `lift`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BlockersJob {
    /// Robot.
    pub robot: RobotId,
    /// What it holds on `lift`; its object is the one touched on `approach`.
    pub holding: Holding,
    /// Reach.
    pub reach: Reach,
    /// Objects that may stand there.
    pub standing: Vec<Standing>,
}

/// Asks for a roadmap piece: the robot and fixed objects only.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PieceJob {
    /// Robot.
    pub robot: RobotId,
    /// What it holds.
    pub holding: Option<Holding>,
    /// Sample level.
    pub level: u32,
    /// Which piece.
    pub spec: PieceSpec,
}

/// Kinds of pieces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum PieceSpec {
    /// The base drives with the arm in its drive configuration (`home` empty-handed, `carry` holding).
    Base,
    /// The arm moves between the drive configuration at a stand and an object.
    Arm {
        /// Base coordinates.
        stand: Vec<f64>,
        /// Way from the object outwards, at the object first: `Reach::approach` or `Reach::lift`, or one configuration.
        near: Vec<Configuration>,
        /// Number of leading motions of `near` on which the held object may touch `support`.
        lift_up: u32,
        /// What the object stands on.
        support: Option<model::FixedId>,
        /// The object just released or about to be grasped, where it stands (empty-handed): the hand may touch it on
        /// `near`; otherwise it is an obstacle.
        touch: Option<Standing>,
    },
}

/// A standing object that may or does obstruct a mode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Obstruction {
    /// Which pose of the object.
    pub occupancy: Occupancy,
    /// Object and pose.
    pub standing: Standing,
}

/// Asks for the glued roadmap of a mode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModeJob {
    /// Mode.
    pub mode: ModeId,
    /// What the robot holds.
    pub holding: Option<Holding>,
    /// Where the mode begins.
    pub start: Configuration,
    /// Where its event happens.
    pub goal: Configuration,
    /// Base piece (absent for a fixed base).
    pub base: Option<ProductRef>,
    /// Arm piece at the start (absent if the mode starts in the drive configuration).
    pub start_arm: Option<ProductRef>,
    /// Arm piece at the goal (absent if it ends in the drive configuration).
    pub goal_arm: Option<ProductRef>,
    /// Poses certainly present throughout: obstacles.
    pub certain: Vec<Obstruction>,
    /// Poses possibly present: annotations.
    pub possible: Vec<Obstruction>,
    /// Sample level, for connections.
    pub level: u32,
}

/// Asks the composite stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ComposeJob {
    /// Placements, grasps and orders that hold.
    pub assignment: Assignment,
    /// What is wanted.
    pub composition: Composition,
}

/// Kinds of composite jobs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Composition {
    /// Commit one mode after `prefix`.
    CommitMode {
        /// What is committed so far.
        prefix: Option<ProductRef>,
        /// The robot's next mode.
        mode: ModeId,
        /// Its roadmap.
        roadmap: ProductRef,
        /// The roadmap of the robot's mode after it, for the tail; absent after a closing return.
        next_roadmap: Option<ProductRef>,
        /// Roadmaps of other robots' modes on whose way the robot should not park: they have been stuck because of it.
        clear_of: Vec<ProductRef>,
    },
    /// Motion of some robots together until the event of a mode that could not be committed has happened, or its closing
    /// return is over. It begins when everybody rests after `prefix`; the other robots stay there.
    Repair {
        /// What is committed so far.
        prefix: Option<ProductRef>,
        /// The next mode of one of the robots.
        mode: ModeId,
        /// Who may move, in ascending order.
        robots: Vec<RobotId>,
        /// Roadmap of every mode of every robot.
        roadmaps: Vec<Vec<ProductRef>>,
    },
    /// The paper's multi-modal dRRT* for everything after `prefix`.
    Drrt {
        /// What is committed so far.
        prefix: Option<ProductRef>,
        /// Roadmap of every mode of every robot.
        roadmaps: Vec<Vec<ProductRef>>,
    },
    /// Retimed plan of a complete prefix, with its dependency arcs.
    Assemble {
        /// All modes committed.
        prefix: ProductRef,
        /// Least time of each mode on its roadmap, for the lower bound (s).
        shortest_s: Vec<Vec<f64>>,
        /// Modes round by round, if at the end of each round all robots of it wait for one another; empty: a robot waits
        /// only where the motion of another forces it.
        rounds: Vec<Vec<ModeId>>,
    },
    /// A synchronous schedule of all modes: rounds, in each of which a robot does one whole mode or idles.
    Synchronous {
        /// How rounds are chosen.
        choice: RoundChoice,
        /// Roadmap of every mode of every robot.
        roadmaps: Vec<Vec<ProductRef>>,
    },
    /// Modes that cannot be done, whatever one other robot does meanwhile: the others are looked at two by two.
    Passages {
        /// Roadmap of every mode of every robot.
        roadmaps: Vec<Vec<ProductRef>>,
    },
}

/// How the rounds of a synchronous schedule are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum RoundChoice {
    /// One after the other, as many robots as can.
    Greedy,
    /// Such that their lengths add up to the least.
    Optimal,
}

impl Request {
    /// The stage that answers.
    #[must_use]
    pub fn stage(&self) -> StageKind {
        match self {
            Request::Placement(_) | Request::Hop(_) | Request::Samples(_) => StageKind::Placement,
            Request::Transition(_) | Request::Blockers(_) | Request::GraspBlockers(_) => StageKind::Transition,
            Request::Piece(_) | Request::Mode(_) => StageKind::Roadmap,
            Request::Compose(_) => StageKind::Composite,
        }
    }

    /// Whether dRRT* answers.
    #[must_use]
    pub fn is_drrt(&self) -> bool {
        matches!(self, Request::Compose(ComposeJob { composition: Composition::Drrt { .. }, .. }))
    }
}

impl Job {
    /// The stage that answers.
    #[must_use]
    pub fn stage(&self) -> StageKind {
        self.request.stage()
    }

    /// The one robot that the job is about, if there is one: roadmap jobs go to that robot's worker.
    #[must_use]
    pub fn robot(&self) -> Option<RobotId> {
        match &self.request {
            Request::Piece(piece) => Some(piece.robot),
            Request::Mode(mode) => Some(mode.mode.robot),
            Request::Blockers(blockers) => Some(blockers.robot),
            Request::Placement(_)
            | Request::Hop(_)
            | Request::Samples(_)
            | Request::Transition(_)
            | Request::GraspBlockers(_)
            | Request::Compose(_) => None,
        }
    }

    /// Products that the answer depends on.
    #[must_use]
    pub fn products(&self) -> Vec<ProductRef> {
        match &self.request {
            Request::Mode(job) => [job.base, job.start_arm, job.goal_arm].into_iter().flatten().collect(),
            Request::Compose(job) => match &job.composition {
                Composition::CommitMode { prefix, roadmap, next_roadmap, clear_of, .. } => {
                    let own = [*prefix, Some(*roadmap), *next_roadmap].into_iter().flatten();
                    own.chain(clear_of.iter().copied()).collect()
                }
                Composition::Drrt { prefix, roadmaps } | Composition::Repair { prefix, roadmaps, .. } => {
                    prefix.iter().chain(roadmaps.iter().flatten()).copied().collect()
                }
                Composition::Assemble { prefix, .. } => vec![*prefix],
                Composition::Synchronous { roadmaps, .. } | Composition::Passages { roadmaps } => {
                    roadmaps.iter().flatten().copied().collect()
                }
            },
            Request::Placement(_)
            | Request::Hop(_)
            | Request::Samples(_)
            | Request::Transition(_)
            | Request::Blockers(_)
            | Request::GraspBlockers(_)
            | Request::Piece(_) => Vec::new(),
        }
    }

    /// Digest of implementation, seed, the part of the problem that the stage reads, question and budget.
    #[must_use]
    pub fn id(&self, statement: &ProblemStatement) -> JobId {
        let scope = Scope::of(&statement.problem, &self.request).map(|scope| scope.digest(&statement.problem));
        self.id_in(statement, scope)
    }
}
