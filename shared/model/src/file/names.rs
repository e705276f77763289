//! Looking things up by name, with suggestions for misspelt names.

use std::collections::BTreeMap;

use super::at::At;
use crate::problem_error::{FindingKind, Found, Source};

/// All names of one kind.
pub(crate) struct Names<'a> {
    what: &'static str,
    index: BTreeMap<&'a str, usize>,
}

impl<'a> Names<'a> {
    /// `names` in the order of the list that owns what they name.
    pub(crate) fn new(what: &'static str, names: impl Iterator<Item = &'a str>) -> Self {
        Self { what, index: names.enumerate().map(|(index, name)| (name, index)).collect() }
    }

    /// The index of what `at` names.
    pub(crate) fn find(&self, source: &Source, at: &At<String>) -> Found<usize> {
        self.find_name(source, at, &at.value)
    }

    /// The index of what a part of `at` names.
    pub(crate) fn find_name<T>(&self, source: &Source, at: &At<T>, name: &str) -> Found<usize> {
        self.index.get(name).copied().ok_or_else(|| {
            let message = format!("no {} is called `{}`", self.what, name.escape_debug());
            let help = did_you_mean(name, self.index.keys().copied());
            source.finding(at.span, FindingKind::UnknownName, message).help(help)
        })
    }
}

/// A remedy for an unknown name: the nearest known one, or all of them where none is near.
pub(crate) fn did_you_mean<'a>(name: &str, known: impl Iterator<Item = &'a str> + Clone) -> String {
    match nearest(name, known.clone()) {
        Some(nearest) => format!("did you mean `{nearest}`?"),
        None => listed(known),
    }
}

/// The known name nearest to `name`, if it is near enough to be meant.
fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let lower = name.to_lowercase();
    let mut best: Option<(f64, &str)> = None;
    for candidate in known {
        let likeness = strsim::jaro_winkler(&lower, &candidate.to_lowercase());
        if likeness > 0.8 && best.is_none_or(|(most, _)| likeness > most) {
            best = Some((likeness, candidate));
        }
    }
    best.map(|(_, candidate)| candidate)
}

fn listed<'a>(known: impl Iterator<Item = &'a str>) -> String {
    const MOST: usize = 12;
    let names: Vec<&str> = known.collect();
    if names.is_empty() {
        return "there is none".to_owned();
    }
    let mut text = names.iter().take(MOST).map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    if names.len() > MOST {
        text.push_str(&format!(" and {} more", names.len() - MOST));
    }
    format!("there is {text}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_suggested_and_all_names_are_listed_where_none_is_near() {
        let known = ["table_a", "table_b", "shelf"];
        assert_eq!(did_you_mean("shel", known.into_iter()), "did you mean `shelf`?");
        assert_eq!(did_you_mean("TABLE_B", known.into_iter()), "did you mean `table_b`?");
        assert_eq!(did_you_mean("xyzzy", known.into_iter()), "there is `table_a`, `table_b`, `shelf`");
        assert_eq!(did_you_mean("x", [].into_iter()), "there is none");
    }
}
