//! A small problem in memory, to be broken in one place at a time.

// Every test file uses its own part of this.
#![allow(dead_code)]

pub mod frames;
pub mod meshes;
pub mod mutants;

use std::collections::BTreeMap;
use std::io;

use miette::{GraphicalReportHandler, GraphicalTheme};
use model::{Files, Problem, ProblemError, load_problem};

/// Files by path.
#[derive(Clone, Debug, Default)]
pub struct MemoryFiles(pub BTreeMap<String, Vec<u8>>);

impl Files for MemoryFiles {
    fn read(&self, path: &str) -> io::Result<Vec<u8>> {
        self.0.get(path).cloned().ok_or_else(|| io::Error::from(io::ErrorKind::NotFound))
    }
}

/// Path of the problem in [`good`].
pub const PROBLEM: &str = "scenes/small.yaml";
/// Paths of the robots in [`good`].
pub const URDF: &str = "robots/mm10.urdf";
pub const SRDF: &str = "robots/mm10.srdf";

const ROBOTS: [(&str, &str); 4] = [
    (URDF, include_str!("../../../../launch/robots/mm10.urdf")),
    (SRDF, include_str!("../../../../launch/robots/mm10.srdf")),
    ("robots/fa7.urdf", include_str!("../../../../launch/robots/fa7.urdf")),
    ("robots/fa7.srdf", include_str!("../../../../launch/robots/fa7.srdf")),
];

/// A problem in which everything is right.
pub fn good() -> MemoryFiles {
    let mut files: BTreeMap<String, Vec<u8>> =
        ROBOTS.iter().map(|(path, text)| ((*path).to_owned(), text.as_bytes().to_vec())).collect();
    files.insert(PROBLEM.to_owned(), include_bytes!("small.yaml").to_vec());
    MemoryFiles(files)
}

/// Loads the problem in [`good`] after one change to one file: the first `old` becomes `new`.
pub fn load_changed(path: &str, old: &str, new: &str) -> Result<Problem, ProblemError> {
    let mut files = good();
    let text = files.0.get(path).map(|bytes| String::from_utf8_lossy(bytes).into_owned()).unwrap_or_default();
    assert!(text.contains(old), "{path} does not contain {old:?}");
    files.0.insert(path.to_owned(), text.replacen(old, new, 1).into_bytes());
    load_problem(&files, PROBLEM)
}

/// A finding as printed on a terminal 90 columns wide, without colours.
pub fn render(error: &ProblemError) -> String {
    let mut text = String::new();
    let handler = GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor()).with_width(90);
    if handler.render_report(&mut text, error).is_err() {
        text.push_str("not rendered");
    }
    text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n")
}
