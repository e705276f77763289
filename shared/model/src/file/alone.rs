//! A robot that no problem names.

use std::sync::Arc;

use super::at::At;
use super::robots::resolve;
use super::syntax::{BaseFile, RobotFile};
use crate::problem_error::{Found, Source, Span};
use crate::urdf::describe;
use crate::{EndPolicy, Files, Robot};

/// Resolves a robot's two files with the least that a problem could say.
pub(crate) fn robot(files: &dyn Files, urdf_path: &str, srdf_path: &str) -> Found<Robot> {
    let described = describe(files, urdf_path, srdf_path)?;
    let file_name = urdf_path.rsplit('/').next().unwrap_or(urdf_path);
    let planar = described.srdf.virtual_joint.as_ref().is_some_and(|joint| joint.planar);
    let file = RobotFile {
        name: unwritten(file_name.split('.').next().unwrap_or(file_name).to_owned()),
        urdf: unwritten(urdf_path.to_owned()),
        srdf: unwritten(srdf_path.to_owned()),
        pose: None,
        base: planar.then(|| unwritten(base())),
        start: None,
        tool: None,
        max_opening: None,
        end: EndPolicy::default(),
    };
    // Nothing in this file is the user's, so nothing in it is told of.
    let source = Source { path: urdf_path.to_owned(), text: Arc::from("") };
    resolve(&source, &file, described)
}

fn base() -> BaseFile {
    let within = || unwritten([-10.0, 10.0]);
    BaseFile { x: within(), y: within(), speed: unwritten(1.0), yaw_rate: unwritten(1.0) }
}

fn unwritten<T>(value: T) -> At<T> {
    At { value, span: Span { offset: 0, len: 0 } }
}
