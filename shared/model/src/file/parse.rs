//! From bytes to the problem file's structure.

use std::sync::Arc;

use serde_saphyr::{Error, Location, MessageFormatter, UserMessageFormatter};

use super::at::span_of;
use super::nearest::did_you_mean;
use super::syntax::ProblemFile;
use crate::Files;
use crate::files::{MAX_FILE_BYTES, too_large};
use crate::problem_error::{Finding, FindingKind, Found, Source, Span};

/// Reads a text file.
pub(crate) fn read_text(files: &dyn Files, path: &str) -> Found<Source> {
    let unreadable = |why: String| {
        Finding::of_file(path, FindingKind::Unreadable, why)
            .help("paths in a problem file are relative to that file; otherwise to where the program was started")
    };
    let bytes = files.read(path).map_err(|error| unreadable(error.to_string()))?;
    if bytes.len() > MAX_FILE_BYTES {
        return Err(unreadable(too_large(bytes.len() as u64)));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        Finding::of_file(path, FindingKind::Malformed, format!("byte {at} is not UTF-8")).help("save the file as UTF-8")
    })?;
    let text = Arc::from(text.strip_prefix('\u{FEFF}').unwrap_or(&text));
    Ok(Source { path: path.to_owned(), text })
}

/// Reads the structure of a problem file.
pub(crate) fn parse(source: &Source) -> Found<ProblemFile> {
    let options = serde_saphyr::options! {
        with_snippet: false,
        budget: serde_saphyr::budget! {
            max_events: 8_000_000,
            max_nodes: 4_000_000,
            max_documents: 1,
            max_depth: 32,
            enforce_alias_anchor_ratio: false,
        },
    };
    serde_saphyr::from_str_with_options(&source.text, options).map_err(|error| finding(source, error.without_snippet()))
}

fn finding(source: &Source, error: &Error) -> Box<Finding> {
    let span = error.location().as_ref().map_or(Span { offset: 0, len: 0 }, known_span);
    let finding = source.finding(span, FindingKind::Malformed, message(error));
    match help(error) {
        Some(help) => finding.help(help),
        None => finding,
    }
}

fn known_span(location: &Location) -> Span {
    span_of(location)
}

fn message(error: &Error) -> String {
    match error {
        Error::SerdeUnknownField { field, .. } => format!("unknown key `{field}`"),
        Error::SerdeUnknownVariant { variant, .. } => format!("unknown word `{variant}`"),
        Error::SerdeMissingField { field, .. } => format!("key `{field}` is missing"),
        Error::SerdeInvalidType { unexpected, expected, .. }
        | Error::SerdeInvalidValue { unexpected, expected, .. } => {
            format!("{unexpected} where {expected} is expected")
        }
        Error::SerdeInvalidLength { len, expected, .. } => format!("{len} values where {expected} is expected"),
        Error::AliasError { error, .. } => message(error),
        other => UserMessageFormatter.format_message(other).into_owned(),
    }
}

fn help(error: &Error) -> Option<String> {
    match error {
        Error::SerdeUnknownField { field, expected, .. }
        | Error::SerdeUnknownVariant { variant: field, expected, .. } => {
            Some(did_you_mean(field, expected.iter().copied()))
        }
        Error::SerdeMissingField { field, .. } => Some(format!("add `{field}:` to this entry")),
        Error::AliasError { error, .. } => help(error),
        _ => None,
    }
}
