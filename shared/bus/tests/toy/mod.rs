//! A toy problem with toy stages and a toy search: all of the traffic of a run, none of the geometry.

mod problem;
mod search;
mod stages;

pub use problem::toy_statement;
pub use search::{ToyEnd, search, whole_log};
pub use stages::{ToyStage, toy_implementation};
