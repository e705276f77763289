//! Named configurations and the start.

use super::at::At;
use super::coordinates::Plan;
use super::names::did_you_mean;
use super::numbers::number;
use super::syntax::RobotFile;
use super::words::StartFile;
use crate::problem_error::{FindingKind, Found, Source};
use crate::urdf::Description;
use crate::{Configuration, Coordinate};

/// Values may lie this far outside a limit: files carry a few digits (m or rad). They are moved onto it.
const ROUNDING: f64 = 1.0e-5;

/// The arm coordinates of a group state; `None` where there is no such state.
pub(crate) fn named_state(described: &Description, plan: &Plan, name: &str) -> Found<Option<Vec<f64>>> {
    let states: Vec<_> = described.srdf.states.iter().filter(|state| state.name == name).collect();
    let Some(first) = states.first() else { return Ok(None) };
    let bad = |message: String| described.srdf_source.finding(first.span, FindingKind::BadRobot, message);
    let mut values = Vec::with_capacity(plan.planned.len());
    for (coordinate, joint) in plan.coordinates[plan.base..].iter().zip(&plan.planned) {
        let said = states.iter().flat_map(|state| &state.values).find(|(position, _)| position == joint);
        let Some((_, value)) = said else {
            return Err(bad(format!("group state `{name}` says nothing of joint `{}`", coordinate.name))
                .help(format!("add `<joint name=\"{}\" value=\"...\"/>`", coordinate.name)));
        };
        let within = within(coordinate, *value).ok_or_else(|| {
            bad(format!("group state `{name}` has joint `{}` at {value}", coordinate.name)).help(limits(coordinate))
        })?;
        values.push(within);
    }
    Ok(Some(values))
}

/// The start configuration.
pub(crate) fn start(
    source: &Source,
    file: &RobotFile,
    plan: &Plan,
    has_base: bool,
    home: &[f64],
) -> Found<Configuration> {
    let mut start = vec![0.0; plan.base];
    start.extend_from_slice(home);
    let said: &[(At<String>, At<f64>)] = match file.start.as_ref().map(|at| &at.value) {
        Some(StartFile::Values(values)) => values,
        Some(StartFile::Home) | None => &[],
    };
    let place = file.start.as_ref().map_or(file.name.span, |at| at.span);
    let mut spans = vec![place; start.len()];
    let mut seen = vec![false; start.len()];
    for (name, value) in said {
        let index = coordinate(source, plan, has_base, name)?;
        if std::mem::replace(&mut seen[index], true) {
            return Err(source
                .finding(name.span, FindingKind::BadName, format!("`{}` is given twice", name.value.escape_debug()))
                .help("keep one of them"));
        }
        start[index] = number(source, value, "a start value")?;
        spans[index] = value.span;
    }
    for (index, coordinate) in plan.coordinates.iter().enumerate() {
        start[index] = within(coordinate, start[index]).ok_or_else(|| {
            let message = format!("`{}` starts with {} at {}", file.name.value, coordinate.name, start[index]);
            source.finding(spans[index], FindingKind::BadPlace, message).help(limits(coordinate))
        })?;
    }
    Ok(start)
}

/// The index of a coordinate; `x`, `y` and `yaw` are those of the base.
fn coordinate(source: &Source, plan: &Plan, has_base: bool, name: &At<String>) -> Found<usize> {
    let short = ["x", "y", "yaw"].iter().position(|short| has_base && *short == name.value);
    let full = || plan.coordinates.iter().position(|coordinate| coordinate.name == name.value);
    short.or_else(full).ok_or_else(|| {
        let base = if has_base { &["x", "y", "yaw"][..] } else { &[] };
        let joints = plan.coordinates[plan.base..].iter().map(|coordinate| coordinate.name.as_str());
        source
            .finding(
                name.span,
                FindingKind::UnknownName,
                format!("no coordinate is called `{}`", name.value.escape_debug()),
            )
            .help(did_you_mean(name, base.iter().copied().chain(joints)))
    })
}

fn within(coordinate: &Coordinate, value: f64) -> Option<f64> {
    let clamped = value.clamp(coordinate.lower, coordinate.upper);
    ((value - clamped).abs() <= ROUNDING).then_some(clamped)
}

fn limits(coordinate: &Coordinate) -> String {
    format!("`{}` must lie between {} and {}", coordinate.name, coordinate.lower, coordinate.upper)
}
