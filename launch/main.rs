//! The `mrtamp` program: command line, supervisor and every stage process in one binary.

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use launch::{
    bench_command, check_command, export_command, init_command, plan_command, refine_command, robot_command,
    schema_command, stage_command, view_command,
};

/// Multi-robot task and motion planning: refines a task plan into a plan that every robot executes on its own clock.
#[derive(Parser)]
#[command(name = "mrtamp", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Plans a problem.
    Plan(plan_command::PlanArgs),
    /// Plans one problem with several seeds and prints the figures.
    Bench(bench_command::BenchArgs),
    /// Checks a plan independently of the planner.
    Check(check_command::CheckArgs),
    /// Writes the page that shows a plan, or why there is none.
    View(view_command::ViewArgs),
    /// Writes a plan in another program's format.
    Export(export_command::ExportArgs),
    /// Shows what a robot's files say and suggests what they do not.
    Robot(robot_command::RobotArgs),
    /// Writes a commented problem to start from into a new folder.
    Init(init_command::InitArgs),
    /// Prints the JSON Schema of a file format.
    Schema(schema_command::SchemaArgs),
    /// Works on one stage of a run; started by the supervisor.
    Stage(stage_command::StageArgs),
    /// Searches in a run; started by the supervisor.
    Refine(refine_command::RefineArgs),
}

fn main() -> ExitCode {
    let ended = match Cli::parse().command {
        Command::Plan(args) => plan_command::run(&args),
        Command::Bench(args) => bench_command::run(&args),
        Command::Check(args) => check_command::run(&args),
        Command::View(args) => view_command::run(&args),
        Command::Export(args) => export_command::run(&args),
        Command::Robot(args) => robot_command::run(&args),
        Command::Init(args) => init_command::run(&args),
        Command::Schema(args) => schema_command::run(&args),
        Command::Stage(args) => stage_command::run(&args),
        Command::Refine(args) => refine_command::run(&args),
    };
    ended.unwrap_or_else(|report| {
        eprintln!("{report:?}");
        launch::exit::of_report(&report)
    })
}
