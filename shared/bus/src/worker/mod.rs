//! The worker's side of the bus.

mod core;
mod memo;
mod port;

pub(crate) use core::product_of;
pub use core::{WorkerCore, statement_digest};
pub(crate) use port::TICK;
pub use port::Worker;
