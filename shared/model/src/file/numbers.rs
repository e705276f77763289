//! Checked numbers, poses and names.

use nalgebra::{Quaternion, Translation3, UnitQuaternion};

use super::at::At;
use super::syntax::PoseFile;
use crate::Pose;
use crate::problem_error::{FindingKind, Found, Source};

/// Greatest magnitude of any length, angle or speed; beyond it rounding eats the millimetres.
pub(crate) const GREATEST: f64 = 1.0e4;

/// Finite numbers of sensible size.
pub(crate) fn finite<const N: usize>(source: &Source, at: &At<[f64; N]>, what: &str) -> Found<[f64; N]> {
    match at.value.iter().find(|x| x.is_nan() || x.abs() > GREATEST) {
        None => Ok(at.value),
        Some(x) => Err(source
            .finding(at.span, FindingKind::BadNumber, format!("{what} contains {x}"))
            .help(format!("give finite numbers of magnitude at most {GREATEST}"))),
    }
}

/// One finite number of sensible size.
pub(crate) fn number(source: &Source, at: &At<f64>, what: &str) -> Found<f64> {
    finite(source, &At { value: [at.value], span: at.span }, what).map(|[x]| x)
}

/// Numbers above zero: sizes, speeds.
pub(crate) fn positive<const N: usize>(source: &Source, at: &At<[f64; N]>, what: &str) -> Found<[f64; N]> {
    let values = finite(source, at, what)?;
    match values.iter().find(|x| **x < LEAST_SIZE) {
        None => Ok(values),
        Some(x) => Err(source
            .finding(at.span, FindingKind::BadNumber, format!("{what} is {x}"))
            .help(format!("give at least {LEAST_SIZE}"))),
    }
}

/// Least size of anything: below it rounding is of the size's order.
const LEAST_SIZE: f64 = 1.0e-6;

/// One number above zero.
pub(crate) fn positive_number(source: &Source, at: &At<f64>, what: &str) -> Found<f64> {
    positive(source, &At { value: [at.value], span: at.span }, what).map(|[x]| x)
}

/// A least and a greatest value.
pub(crate) fn range(source: &Source, at: &At<[f64; 2]>, what: &str) -> Found<[f64; 2]> {
    let [low, high] = finite(source, at, what)?;
    if low < high {
        return Ok([low, high]);
    }
    Err(source
        .finding(at.span, FindingKind::BadNumber, format!("{what} runs from {low} down to {high}"))
        .help("give the least value first, then a greater one"))
}

/// A pose; the identity where nothing is given.
pub(crate) fn pose(source: &Source, at: Option<&At<PoseFile>>, what: &str) -> Found<Pose> {
    let Some(file) = at else { return Ok(Pose::identity()) };
    let [x, y, z] = file.xyz.as_ref().map_or(Ok([0.0; 3]), |xyz| finite(source, xyz, what))?;
    let rotation = match (&file.rpy, &file.quat_xyzw) {
        (None, None) => UnitQuaternion::identity(),
        (Some(rpy), None) => {
            let [roll, pitch, yaw] = finite(source, rpy, what)?;
            UnitQuaternion::from_euler_angles(roll, pitch, yaw)
        }
        (None, Some(quat)) => quaternion(source, quat, what)?,
        (Some(rpy), Some(quat)) => {
            return Err(source
                .finding(quat.span, FindingKind::BadNumber, format!("{what} has two orientations"))
                .note(source, rpy.span, "the other")
                .help("give either `rpy` or `quat_xyzw`"));
        }
    };
    Ok(Pose::from_parts(Translation3::new(x, y, z), rotation))
}

fn quaternion(source: &Source, at: &At<[f64; 4]>, what: &str) -> Found<UnitQuaternion<f64>> {
    let [x, y, z, w] = finite(source, at, what)?;
    let quaternion = Quaternion::new(w, x, y, z);
    // Files carry a few digits; beyond a permille it is more likely a mistake, such as w given first.
    if (quaternion.norm() - 1.0).abs() > 1.0e-3 {
        return Err(source
            .finding(
                at.span,
                FindingKind::BadNumber,
                format!("{what}: a quaternion of length {:.4}", quaternion.norm()),
            )
            .help("give a unit quaternion in the order x, y, z, w"));
    }
    Ok(UnitQuaternion::new_normalize(quaternion))
}

/// A name that can stand in an ordering, in a message and in a file name.
pub(crate) fn name<'a>(source: &Source, at: &'a At<String>, what: &str) -> Found<&'a str> {
    let good = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.');
    if !at.value.is_empty() && at.value.len() <= 100 && at.value.chars().all(good) {
        return Ok(&at.value);
    }
    Err(source
        .finding(at.span, FindingKind::BadName, format!("`{}` cannot name a {what}", at.value.escape_debug()))
        .help("use 1 to 100 letters, digits, `_`, `-` and `.`"))
}

/// Names of one kind, each with its place.
pub(crate) fn unique_names<'a>(
    source: &Source,
    names: impl Iterator<Item = &'a At<String>>,
    what: &str,
) -> Vec<Found<()>> {
    let mut seen = std::collections::BTreeMap::new();
    let mut results = Vec::new();
    for at in names {
        results.push(name(source, at, what).map(|_| ()));
        if let Some(first) = seen.insert(at.value.as_str(), at.span) {
            results.push(Err(source
                .finding(at.span, FindingKind::BadName, format!("two {what}s are called `{}`", at.value.escape_debug()))
                .note(source, first, "the first")
                .help("rename one of them")));
        }
    }
    results
}
