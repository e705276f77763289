//! A plan file and its problem, as the commands that look at plans take them.

use std::path::{Path, PathBuf};

use contract::{CompositeMethod, ProblemStatement};
use miette::Report;
use model::Problem;
use plan::{Plan, PlanFileError};

use crate::exit::BadInput;
use crate::packages::PackageArgs;
use crate::problem_source;

/// A plan with its problem.
#[derive(Debug)]
pub struct PlanWithProblem {
    /// Plan.
    pub plan: Plan,
    /// Problem.
    pub problem: Problem,
}

/// Reads a plan and its problem; without `problem`, the built-in scene of the plan's name.
///
/// # Errors
/// Bad input: a file that cannot be read, or a problem that is not the plan's.
pub fn load(plan: &Path, problem: Option<&Path>, packages: &PackageArgs) -> miette::Result<PlanWithProblem> {
    let bytes = problem_source::read_file(plan)?;
    let read = plan::read_plan(&bytes).map_err(|error| unreadable(plan, &error, "plan"))?;
    let problem = load_problem(&read.problem, &read.provenance.problem_digest, plan, problem, packages)?;
    Ok(PlanWithProblem { plan: read, problem })
}

/// The problem of a plan or failure file: the one named, else the built-in scene of that name.
///
/// # Errors
/// Bad input, also when its digest is another than the file's.
pub fn load_problem(
    name: &str,
    digest: &str,
    file: &Path,
    named: Option<&Path>,
    packages: &PackageArgs,
) -> miette::Result<Problem> {
    let path = named.map_or_else(|| PathBuf::from(name), Path::to_path_buf);
    let problem = problem_source::load_with(Some(&path), packages)?;
    // Seed and method are no part of the problem's digest.
    let statement = ProblemStatement::new(problem, 0, CompositeMethod::default());
    if statement.problem_digest().hex() != digest {
        return Err(Report::new(BadInput {
            message: format!("{} was made from another problem than {}", file.display(), path.display()),
            help: Some("name the problem as it was with --problem".to_owned()),
        }));
    }
    Ok(statement.problem)
}

/// A file that is not of its format.
#[must_use]
pub fn unreadable(path: &Path, error: &PlanFileError, format: &str) -> Report {
    Report::new(BadInput {
        message: format!("{}: {error}", path.display()),
        help: Some(format!("`mrtamp schema {format}` prints what a {format} looks like")),
    })
}

/// Makes the folder of results and sees that files can be written there, before any work is done for them.
///
/// # Errors
/// Bad input: why they cannot.
pub fn refuse_unwritable(folder: &Path) -> miette::Result<()> {
    let refuse = |path: &Path, why: String| {
        let message = format!("{}: {why}", path.display());
        Report::new(BadInput { message, help: Some("name a folder that can be written with --out DIR".to_owned()) })
    };
    std::fs::create_dir_all(folder).map_err(|error| refuse(folder, format!("no such folder can be made: {error}")))?;
    for name in ["plan.json", "plan.html", "failure.json", "failure.html"] {
        let path = folder.join(name);
        if path.is_dir() {
            return Err(refuse(&path, "is a folder, where a result is to be written".to_owned()));
        }
    }
    // As `write_whole` would: permissions, read-only and full disks are only known by trying.
    let trial = folder.join(format!(".trial.{}.unfinished", std::process::id()));
    let written = std::fs::write(&trial, b"mrtamp").and_then(|()| std::fs::remove_file(&trial));
    written.map_err(|error| refuse(folder, format!("no file can be written there: {error}")))
}

/// Writes a file whole or not at all: aside first, then renamed.
///
/// # Errors
/// When it cannot be written.
pub fn write_whole(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let unfinished = folder.join(format!(".{name}.unfinished"));
    std::fs::write(&unfinished, bytes)?;
    std::fs::rename(&unfinished, path)
}
