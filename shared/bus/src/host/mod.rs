//! The supervisor's side of the bus: who is there, the statement, the run's store, and the end of the search.

mod core;
mod post;
mod store;

pub use core::{Expected, HostCore, HostFault, Note};
pub use post::Host;
pub use store::Store;
