//! What the `mrtamp` program is made of: one module per subcommand, and the running of a set of processes.
//!
//! It is a library so that the integration tests can start sets with stages of their own.

pub mod bench_command;
pub mod check_command;
pub mod ending;
pub mod exit;
pub mod in_process;
pub mod plan_command;
pub mod problem_source;
pub mod progress;
pub mod schema_command;
pub mod stages;
pub mod words;
