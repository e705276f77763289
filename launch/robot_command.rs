//! `mrtamp robot`: what a robot's files say, and a starting SRDF.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use miette::{Context, IntoDiagnostic, Report};
use model::{Files, LinkId, PackageFiles, Robot, RobotTree, load_robot, read_urdf};

use crate::exit::{self, BadInput};
use crate::packages::PackageArgs;
use crate::robot_report::{self, Draft, Entries, Pairs, RobotReport, Survey, srdf_text};

/// Arguments of `mrtamp robot`.
#[derive(Args, Debug)]
pub struct RobotArgs {
    /// URDF file.
    pub urdf: PathBuf,
    /// SRDF file; without it groups, end effector and a folded configuration are guessed.
    #[arg(long, value_name = "FILE")]
    pub srdf: Option<PathBuf>,
    /// Where ROS packages lie.
    #[command(flatten)]
    pub packages: PackageArgs,
    /// Writes what is guessed as a starting SRDF. No existing file is touched.
    #[arg(long, value_name = "FILE", conflicts_with = "srdf")]
    pub write_srdf: Option<PathBuf>,
    /// The starting SRDF gets a planar virtual joint: a base that drives.
    #[arg(long, conflicts_with = "srdf")]
    pub planar_base: bool,
    /// Random configurations looked at.
    #[arg(long, value_name = "NUMBER", default_value_t = 10_000)]
    pub samples: u64,
    /// Results for programs.
    #[arg(long)]
    pub json: bool,
}

/// Shows a robot.
///
/// # Errors
/// A report for the user.
pub fn run(args: &RobotArgs) -> miette::Result<ExitCode> {
    if let Some(path) = args.write_srdf.as_deref().filter(|path| path.exists()) {
        return Err(exists(path));
    }
    let (report, srdf) = look_at(args)?;
    if args.json {
        println!("{}", serde_json::to_string_pretty(&report).into_diagnostic()?);
    } else {
        print!("{}", robot_report::text(&report));
    }
    if let (Some(path), Some(srdf)) = (&args.write_srdf, &srdf) {
        write_new(path, srdf)?;
        eprintln!("Written: {}", path.display());
    } else if srdf.is_some() {
        eprintln!(
            "Groups, end effector and home are guessed; --write-srdf FILE writes them down, --srdf FILE takes yours."
        );
    }
    Ok(ExitCode::from(exit::SOLVED))
}

/// The report of a robot and, where it has no SRDF, the one that is guessed.
///
/// # Errors
/// A report for the user.
pub fn look_at(args: &RobotArgs) -> miette::Result<(RobotReport, Option<String>)> {
    let (files, urdf) = (args.packages.files(), args.urdf.to_string_lossy());
    if let Some(srdf) = &args.srdf {
        return Ok((of_files(&files, &urdf, &srdf.to_string_lossy(), args.samples)?, None));
    }
    let (report, srdf) = guessed(&files, &urdf, args)?;
    Ok((report, Some(srdf)))
}

fn of_files(files: &PackageFiles, urdf: &str, srdf: &str, samples: u64) -> miette::Result<RobotReport> {
    let robot = load_robot(files, urdf, srdf)?;
    let tree = read_urdf(files, urdf)?;
    let survey = Survey::of(&robot, samples).map_err(unusable)?;
    let at_home = robot_report::touching_at_home(&robot, &survey).map_err(unusable)?;
    let pairs = Pairs::of(&survey, &at_home, &robot.disabled_pairs);
    Ok(RobotReport::of(&robot, &tree, None, &survey, &pairs))
}

/// The report of a robot without an SRDF, and the SRDF that is guessed for it.
fn guessed(files: &PackageFiles, urdf: &str, args: &RobotArgs) -> miette::Result<(RobotReport, String)> {
    let tree = read_urdf(files, urdf)?;
    let draft = Draft::of(&tree).ok_or_else(|| {
        Report::new(BadInput {
            message: format!("{urdf}: no joint moves, so there is no arm"),
            help: Some("give a URDF with at least one revolute, continuous or prismatic joint".to_owned()),
        })
    })?;
    let file_name = args.urdf.file_stem().unwrap_or_default().to_string_lossy();
    let mut entries = Entries { planar_base: args.planar_base, ..Entries::default() };
    entries.home = arm_joints(&tree, &draft);
    let drafted = |entries: &Entries| -> miette::Result<(Robot, String)> {
        let text = srdf_text(&file_name, &tree, &draft, entries);
        let with_draft = WithDraft { files, path: GUESSED, text: &text };
        Ok((load_robot(&with_draft, urdf, GUESSED)?, text))
    };
    let (robot, _) = drafted(&entries)?;
    let survey = Survey::of(&robot, args.samples).map_err(unusable)?;
    if let Some(home) = robot_report::folded(&robot, survey.hopeless(), draft.tool).map_err(unusable)? {
        entries.home.iter_mut().zip(home).for_each(|((_, value), folded)| *value = folded);
    }
    let (robot, _) = drafted(&entries)?;
    let at_home = robot_report::touching_at_home(&robot, &survey).map_err(unusable)?;
    let pairs = Pairs::of(&survey, &at_home, &[]);
    entries.pairs.clone_from(&pairs.not_tested);
    let (robot, text) = drafted(&entries)?;
    Ok((RobotReport::of(&robot, &tree, Some(&draft), &survey, &pairs), text))
}

/// Joints of the draft's arm, from the root, at the value within their limits that is nearest to 0.
fn arm_joints(tree: &RobotTree, draft: &Draft) -> Vec<(String, f64)> {
    let above = |link: LinkId| tree.joint_of(link);
    let chain = std::iter::successors(above(draft.arm_tip), |joint| above(joint.parent));
    let moving = chain.filter(|joint| joint.motion != model::JointMotion::Fixed && !joint.mimics);
    let mut joints: Vec<(String, f64)> =
        moving.map(|joint| (joint.name.clone(), 0.0_f64.clamp(joint.lower, joint.upper))).collect();
    joints.reverse();
    joints
}

/// Name under which faults of our own SRDF would be told.
const GUESSED: &str = "guessed.srdf";

/// Files, and one that is nowhere yet.
struct WithDraft<'a> {
    files: &'a PackageFiles,
    path: &'a str,
    text: &'a str,
}

impl Files for WithDraft<'_> {
    fn read(&self, path: &str) -> std::io::Result<Vec<u8>> {
        if path == self.path { Ok(self.text.as_bytes().to_vec()) } else { self.files.read(path) }
    }

    fn package_folders(&self, name: &str) -> Vec<String> {
        self.files.package_folders(name)
    }
}

fn unusable(error: collision::GeometryError) -> Report {
    Report::new(BadInput::new(error.to_string()))
}

fn exists(path: &Path) -> Report {
    Report::new(BadInput {
        message: format!("{} exists already", path.display()),
        help: Some("name a new file: none is overwritten".to_owned()),
    })
}

/// Writes a file that must not be there yet.
fn write_new(path: &Path, text: &str) -> miette::Result<()> {
    match std::fs::File::create_new(path).and_then(|mut file| file.write_all(text.as_bytes())) {
        Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => Err(exists(path)),
        written => written.into_diagnostic().wrap_err_with(|| format!("{} cannot be written", path.display())),
    }
}
