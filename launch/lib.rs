//! What the `mrtamp` program is made of: one module per subcommand, and the running of a set of processes.
//!
//! It is a library so that the integration tests can start sets with stages of their own.

pub mod bench_command;
mod bench_comparison;
mod bench_merged;
pub mod check_command;
pub mod ending;
pub mod exit;
pub mod explain;
pub mod export;
pub mod export_command;
pub mod in_process;
pub mod init_command;
pub mod packages;
pub mod palette;
pub mod plan_command;
pub mod playback;
pub mod problem_source;
pub mod processes;
pub mod progress;
pub mod provenance;
pub mod refine_command;
pub mod report;
pub mod result_file;
pub mod result_folder;
pub mod robot_command;
pub mod robot_report;
pub mod schema_command;
pub mod search_args;
pub mod set;
pub mod stage_command;
pub mod stages;
pub mod start_check;
pub mod view;
pub mod view_command;
pub mod words;
