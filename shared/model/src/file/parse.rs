//! From bytes to the problem file's structure.

use std::sync::Arc;

use serde_saphyr::{Error, Location, MessageFormatter, UserMessageFormatter};

use super::at::span_of;
use super::names::did_you_mean;
use super::syntax::ProblemFile;
use crate::Files;
use crate::files::{MAX_FILE_BYTES, too_large};
use crate::problem_error::{Finding, FindingKind, Found, Source, Span};

/// Reads a text file.
pub(crate) fn read_text(files: &dyn Files, path: &str) -> Found<Source> {
    let unreadable = |why: String| {
        Finding::of_file(path, FindingKind::Unreadable, why)
            .help("give a path relative to where the program is started, or an absolute one")
    };
    let bytes = files.read(path).map_err(|error| unreadable(why_unread(&error)))?;
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

/// Why a file was not read, in the same words on every system.
pub(crate) fn why_unread(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".to_owned(),
        _ => error.to_string(),
    }
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
    let span = error.location().map_or(Span { offset: 0, len: 0 }, |location| place(source, &location));
    source.finding(span, FindingKind::Malformed, message(error)).help(help(error))
}

/// Bytes of a location; where it has none, from its line and column.
fn place(source: &Source, location: &Location) -> Span {
    if location.span().byte_offset().is_some() {
        return span_of(location);
    }
    let line = usize::try_from(location.line()).unwrap_or(1).saturating_sub(1);
    let column = usize::try_from(location.column()).unwrap_or(1).saturating_sub(1);
    let line_start: usize = source.text.split_inclusive('\n').take(line).map(str::len).sum();
    let rest = source.text.get(line_start..).unwrap_or_default();
    Span { offset: line_start + rest.chars().take(column).map(char::len_utf8).sum::<usize>(), len: 1 }
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
        Error::InvalidScalar { ty, .. } => format!("not a {}", ty.replace("floating point", "number")),
        Error::AliasError { error, .. } => message(error),
        other => UserMessageFormatter.format_message(other).into_owned(),
    }
}

fn help(error: &Error) -> String {
    match error {
        Error::SerdeUnknownField { field, expected, .. }
        | Error::SerdeUnknownVariant { variant: field, expected, .. } => did_you_mean(field, expected.iter().copied()),
        Error::SerdeMissingField { field, .. } => format!("add `{field}:` to this entry"),
        Error::SerdeInvalidLength { expected, .. } => format!("give {expected}"),
        Error::InvalidScalar { .. } => "give a number such as 0.25".to_owned(),
        Error::DuplicateMappingKey { .. } => "keep one of the two".to_owned(),
        Error::Budget { .. } => "split the problem: files may hold a few million values".to_owned(),
        Error::AliasError { error, .. } => help(error),
        other if message(other).contains("tab") => "indent with spaces".to_owned(),
        _ => "`mrtamp schema problem` describes every key".to_owned(),
    }
}
