//! `mrtamp init`: a commented problem to start from.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use miette::{Context, IntoDiagnostic, Report};

use crate::exit::{self, BadInput};

/// Files of the new folder, but for the schema.
const FILES: [(&str, &str); 3] = [
    ("problem.yaml", include_str!("init/problem.yaml")),
    ("robots/mm10.urdf", include_str!("robots/mm10.urdf")),
    ("robots/mm10.srdf", include_str!("robots/mm10.srdf")),
];

/// Arguments of `mrtamp init`.
#[derive(Args, Debug)]
pub struct InitArgs {
    /// Folder to make.
    #[arg(default_value = "my-problem")]
    pub name: PathBuf,
}

/// Makes the folder with everything that planning needs.
///
/// # Errors
/// A report for the user; bad input where the folder is there already.
pub fn run(args: &InitArgs) -> miette::Result<ExitCode> {
    let folder = &args.name;
    make(folder)?;
    let schema = serde_json::to_string_pretty(&model::problem_schema()).into_diagnostic()?;
    for (path, text) in FILES.into_iter().chain([("problem.schema.json", schema.as_str())]) {
        let path = folder.join(path);
        write_new(&path, text).into_diagnostic().wrap_err_with(|| format!("{} cannot be written", path.display()))?;
        println!("{}", path.display());
    }
    eprintln!("Plan it: mrtamp plan {}", folder.join("problem.yaml").display());
    Ok(ExitCode::from(exit::SOLVED))
}

/// Makes the folder; an empty one may be there.
fn make(folder: &Path) -> miette::Result<()> {
    let is_empty = |folder: &Path| std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_none());
    if folder.exists() && !is_empty(folder) {
        return Err(Report::new(BadInput {
            message: format!("{} exists already", folder.display()),
            help: Some("name a new folder: nothing is overwritten".to_owned()),
        }));
    }
    std::fs::create_dir_all(folder.join("robots"))
        .into_diagnostic()
        .wrap_err_with(|| format!("{} cannot be made", folder.display()))
}

fn write_new(path: &Path, text: &str) -> std::io::Result<()> {
    std::fs::File::create_new(path)?.write_all(text.as_bytes())
}
