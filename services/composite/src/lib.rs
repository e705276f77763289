//! Composite motion (paper Sec. III-E): all robots together, each on its own clock.
//!
//! One relation decides everything here: whether two *cells* (equal parts of straight motions) of two robots could touch,
//! and whether a cell could touch a standing object ([`Conflicts`]). The search of single modes, the composite search and
//! the dependency arcs of the finished plan ask the same relation, so they agree.
//!
//! Times are in seconds, configurations in m and rad.

mod assemble;
mod commit;
pub mod conflict;
pub mod drrt;
mod passages;
mod points;
mod prefix;
mod repair;
pub mod scene;
mod sipp;
mod stage;
mod synchronous;
pub mod timeline;

pub use conflict::{Conflicts, TimedMotion, TimedStanding, Travel};
pub use prefix::{CommittedMotion, load_prefix};
pub use scene::{CompositeError, Scene};
pub use stage::CompositeStage;
pub use timeline::{RobotTimeline, TimedMove, Timeline};
