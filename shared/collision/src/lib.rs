//! The planner's geometry: whether states and straight motions keep clear, and whether two motions could meet.
//!
//! Units are m and rad. Every answer "no contact" is a proof up to floating-point rounding: over continuous time, with
//! the clearance of the problem's settings kept. Answers "contact" are conservative by at most a fraction of it.

mod conflict;
mod contact;
mod continuous;
mod geometry;
mod gjk;
mod hand;
mod hull;
mod impossible;
mod motion;
mod mover;
mod obstacle;
mod own_links;
mod penetration;
mod robot_shape;
mod separation;
mod solid;
mod start;
mod sweep;

pub use contact::{BodyName, Contact};
pub use geometry::{Geometry, GeometryError};
pub use hull::{HullSurface, hull_surface};
pub use model::{AllowedContacts, Holding, Standing};
pub use motion::Motion;
pub use start::StartContact;
pub use sweep::Sweep;
