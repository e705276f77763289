//! What a stage is: jobs, outcomes, products, budgets, random streams; how the search asks, and how a worker serves.
//!
//! The search sees the outside only through [`AskStages`]; a stage sees it only through [`JobContext`]. Neither knows of
//! a bus. Equal jobs have equal identities and equal outcomes, however often and wherever they are worked on.

mod ask;
mod assignment;
mod codec;
mod direct;
mod job;
mod job_ids;
mod ledger;
mod outcome;
mod product;
mod random;
mod roadmap;
mod schedule;
mod scope;
mod serve;
mod stage;
mod statement;

pub use ask::{AskFault, AskStages, Foresight};
pub use assignment::{Alternative, Assignment, DiscoveredOrder, HopChoice, Placed, PlacementCandidate, Reach};
pub use codec::{CodecError, MAX_MESSAGE_BYTES, decode, encode, encode_canonical};
pub use direct::DirectCalls;
pub use job::{
    BlockersJob, ComposeJob, Composition, GraspBlockersJob, HopJob, Job, JobId, MOST_PLACEMENT_SAMPLES, ModeJob,
    Obstruction, PieceJob, PieceSpec, PlacementJob, Request, RoundChoice, SamplesJob, TransitionJob,
};
pub use job_ids::JobIds;
pub use ledger::{Decision, Ledger, LedgerEntry};
pub use outcome::{Answer, CauseTally, Choice, FailureReport, Literal, Nogood, Outcome, Soundness};
pub use product::{Digest, MemoryProducts, Product, ProductRef, Products};
pub use random::{RandomStream, SampleValues, halton};
pub use roadmap::{Edge, EdgeKind, ModeRoadmap, RoadmapPiece, VertexId};
pub use schedule::{Commitment, Move, Prefix, Tail};
pub use serve::{JobPort, Offer, Refusal, ServeFault, serve};
pub use stage::{Interrupted, JobContext, Stage, StageKind};
pub use statement::{CompositeMethod, Merge, ProblemStatement, SearchOptions, WorkKind};
