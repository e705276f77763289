//! Settings and levels within their ranges.

use super::at::At;
use crate::problem_error::{FindingKind, Found, Source, Span};
use crate::{Levels, Settings};

/// Settings of a problem; the defaults where nothing is said.
pub(crate) fn settings(source: &Source, file: Option<&At<Settings>>) -> Found<Settings> {
    let Some(at) = file else { return Ok(Settings::default()) };
    let s = &at.value;
    let ranges = [
        ("clearance", s.clearance, 0.0001, 1.0),
        ("region_margin", s.region_margin, 0.0, 1.0),
        ("support_tolerance", s.support_tolerance, 0.000_001, 0.1),
        ("grip_time", s.grip_time, 0.0, 1000.0),
        ("approach", s.approach, 0.0, 1.0),
        ("lift", s.lift, 0.0, 1.0),
        ("straightness", s.straightness, 0.0001, 1.0),
        ("facing", s.facing, 0.01, std::f64::consts::PI),
    ];
    for (key, value, least, greatest) in ranges {
        if !(least..=greatest).contains(&value) {
            return Err(out_of_range(source, at.span, key, &format!("{value}"), &format!("{least} to {greatest}")));
        }
    }
    Ok(s.clone())
}

/// Levels of a problem; the defaults where nothing is said.
pub(crate) fn levels(source: &Source, file: Option<&At<Levels>>) -> Found<Levels> {
    let Some(at) = file else { return Ok(Levels::default()) };
    let l = &at.value;
    let ranges = [
        ("placements", l.placements, 1, 1 << 16),
        ("grasps", l.grasps, 1, 1 << 16),
        ("stands", l.stands, 1, 1 << 16),
        ("vertices", l.vertices, 1, 1 << 20),
        ("expansions", l.expansions, 1, 1 << 30),
        ("highest", l.highest, 0, 12),
    ];
    for (key, value, least, greatest) in ranges {
        if !(least..=greatest).contains(&value) {
            return Err(out_of_range(source, at.span, key, &format!("{value}"), &format!("{least} to {greatest}")));
        }
    }
    Ok(l.clone())
}

fn out_of_range(source: &Source, block: Span, key: &str, value: &str, range: &str) -> Box<crate::Finding> {
    // The block's structs are shared with the resolved problem and carry no places; the key is sought in the text.
    let rest = source.text.get(block.offset..).unwrap_or_default();
    let span = rest.find(key).map_or(block, |at| Span { offset: block.offset + at, len: key.len() });
    source.finding(span, FindingKind::BadNumber, format!("`{key}` is {value}")).help(format!("give {range}"))
}
