//! The task plan's skeleton: events, the partial order on them, modes, and what may be present when.

mod event;
mod graph;
mod mode;
mod presence;

pub use event::Event;
pub use graph::{Arc, ArcOrigin, Checkpoint, Cycle, EventGraph};
pub use mode::{Mode, ModeId, ModeKind, Skeleton};
pub use presence::{Interval, Occupancy, Presence};
