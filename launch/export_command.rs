//! `mrtamp export`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use miette::{Context, IntoDiagnostic};

use crate::exit::{self, BadInput};
use crate::packages::PackageArgs;
use crate::playback::{Mismatch, Playback};
use crate::{export, result_file};

/// Arguments of `mrtamp export`.
#[derive(Args, Debug)]
pub struct ExportArgs {
    /// What to write.
    pub format: Format,
    /// Plan file.
    pub plan: PathBuf,
    /// Problem file (default: the built-in scene that the plan names).
    #[arg(long, value_name = "PROBLEM")]
    pub problem: Option<PathBuf>,
    /// File to write (default: beside the plan).
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Samples per second: of all rows of a table (default: the plan's knots), of held objects elsewhere (default: 30).
    #[arg(long, value_name = "HZ")]
    pub rate: Option<f64>,
    /// In a table, also the pose of every link.
    #[arg(long)]
    pub links: bool,
    /// Where ROS packages lie.
    #[command(flatten)]
    pub packages: PackageArgs,
}

/// Formats of other programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Animated binary glTF 2.0, for Blender and other viewers.
    Glb,
    /// One wide table: time, coordinates, poses of tools and objects.
    Csv,
    /// JSON with the fields of `trajectory_msgs/JointTrajectory` and `MultiDOFJointTrajectory`.
    Ros2,
}

impl Format {
    fn file_name(self) -> &'static str {
        match self {
            Format::Glb => "plan.glb",
            Format::Csv => "plan.csv",
            Format::Ros2 => "plan.ros2.json",
        }
    }
}

/// Greatest rate (Hz) that is taken.
const GREATEST_RATE: f64 = 10_000.0;

/// Exports.
///
/// # Errors
/// A report for the user.
pub fn run(args: &ExportArgs) -> miette::Result<ExitCode> {
    if args.rate.is_some_and(|rate| !(rate > 0.0 && rate <= GREATEST_RATE)) {
        return Err(BadInput::new(format!("--rate must lie above 0 and be at most {GREATEST_RATE} Hz")).into());
    }
    let loaded = result_file::load(&args.plan, args.problem.as_deref(), &args.packages)?;
    let playback = Playback::new(&loaded.problem, &loaded.plan)
        .map_err(|error: Mismatch| BadInput::new(format!("{}: {error}", args.plan.display())))?;
    let bytes = match args.format {
        Format::Glb => export::glb(&playback, args.rate).into_diagnostic()?,
        Format::Csv => export::csv(&playback, args.rate, args.links).into_bytes(),
        Format::Ros2 => export::ros2(&playback, args.rate).into_diagnostic()?.into_bytes(),
    };
    let out = args.out.clone().unwrap_or_else(|| args.plan.with_file_name(args.format.file_name()));
    result_file::write_whole(&out, &bytes)
        .into_diagnostic()
        .wrap_err_with(|| format!("{} cannot be written", out.display()))?;
    println!("{}", out.display());
    Ok(ExitCode::from(exit::SOLVED))
}
