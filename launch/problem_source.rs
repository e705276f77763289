//! Where a problem comes from: a file, or one of the scenes built into the program.

use std::path::Path;

use miette::Report;
use model::{EmbeddedFiles, Files, Problem, ProblemError, load_problem_with_places};

use crate::exit::BadInput;
use crate::packages::PackageArgs;
use crate::start_check::refuse_collisions;

macro_rules! embedded {
    ($($path:literal),* $(,)?) => { &[$(($path, include_bytes!($path))),*] };
}

/// Robots and scenes built into the program.
pub(crate) static BUILT_IN: EmbeddedFiles = EmbeddedFiles(embedded![
    "robots/mm10.urdf",
    "robots/mm10.srdf",
    "robots/mm10s.urdf",
    "robots/mm10s.srdf",
    "robots/fa7.urdf",
    "robots/fa7.srdf",
    "scenes/figure1.yaml",
    "scenes/figure1_slots.yaml",
    "scenes/figure1_tight.yaml",
    "scenes/figure1_wide.yaml",
    "scenes/t00_one_arm.yaml",
    "scenes/t01_one_robot.yaml",
    "scenes/t02_far_apart.yaml",
    "scenes/t03_relay.yaml",
    "scenes/t04_spacious_region.yaml",
    "scenes/t05_tiny_region.yaml",
    "scenes/t06_contradiction.yaml",
    "scenes/t07_three_in_two.yaml",
    "scenes/t08_off_diagonal.yaml",
    "scenes/t09_swap.yaml",
    "scenes/t10_swap_with_buffer.yaml",
    "scenes/t11_swap_without_buffer.yaml",
    "scenes/t12_deep_cabinet.yaml",
    "scenes/t13_occluded.yaml",
    "scenes/t14_blocked_for_ever.yaml",
    "scenes/t15_no_common_grasp.yaml",
    "scenes/t15b_regrasp.yaml",
    "scenes/t16_out_of_reach.yaml",
    "scenes/t17_walled_in.yaml",
    "scenes/t18_parked_in_the_door.yaml",
    "scenes/t19_passing_bay.yaml",
    "scenes/t19b_no_bay.yaml",
    "scenes/t20_dead_end.yaml",
    "scenes/t21_third_region.yaml",
    "scenes/t22_both_jambs.yaml",
    "scenes/t23_mixed_team.yaml",
    "scenes/t24_four_arms.yaml",
    "scenes/t25_stays_after_its_last.yaml",
    "scenes/t26_home_in_the_door.yaml",
]);

/// The scene that is planned when none is named.
const DEFAULT_SCENE: &str = "figure1";

/// Loads a problem: `named` is a file, or the name of a built-in scene; by default the paper's Figure 1.
///
/// # Errors
/// A report that names file, line and remedy; its exit code is that of bad input.
pub fn load(named: Option<&Path>) -> miette::Result<Problem> {
    load_with(named, &PackageArgs::default())
}

/// As [`load`], with ROS packages that the user names.
///
/// # Errors
/// A report that names file, line and remedy; its exit code is that of bad input.
pub fn load_with(named: Option<&Path>, packages: &PackageArgs) -> miette::Result<Problem> {
    let Some(path) = named else {
        return checked(&BUILT_IN, &scene(DEFAULT_SCENE));
    };
    let name = path.to_string_lossy();
    let built_in = BUILT_IN.0.iter().any(|(file, _)| *file == scene(&name));
    if built_in && !path.is_file() {
        return checked(&BUILT_IN, &scene(&name));
    }
    checked(&packages.files(), &name)
}

fn checked(files: &dyn Files, path: &str) -> miette::Result<Problem> {
    let (problem, places) = load_problem_with_places(files, path).map_err(report)?;
    refuse_collisions(&problem, &places)?;
    Ok(problem)
}

fn scene(name: &str) -> String {
    format!("scenes/{name}.yaml")
}

fn report(error: ProblemError) -> Report {
    Report::new(error)
}

/// Reads a file that the user names.
///
/// # Errors
/// Bad input.
pub fn read_file(path: &Path) -> miette::Result<Vec<u8>> {
    std::fs::read(path).map_err(|error| {
        Report::new(BadInput {
            message: format!("{} cannot be read: {error}", path.display()),
            help: Some("check the path and its permissions".to_owned()),
        })
    })
}
