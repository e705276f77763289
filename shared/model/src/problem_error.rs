//! What is wrong with a problem file, where, and what to do about it.

use std::fmt;
use std::sync::Arc;

use miette::{Diagnostic, LabeledSpan, NamedSource, SourceCode};

/// A problem that cannot be used: one or more findings, each with its place and remedy.
#[derive(Clone, Debug)]
pub struct ProblemError {
    findings: Vec<Finding>,
}

/// The kind of a finding, for programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FindingKind {
    /// A file is missing or cannot be read.
    Unreadable,
    /// A file is not what its format asks for.
    Malformed,
    /// A name that nothing carries.
    UnknownName,
    /// A name that two things of one kind carry, or that cannot be a name.
    BadName,
    /// A number out of its range.
    BadNumber,
    /// Something stands where it cannot.
    BadPlace,
    /// Two bodies that overlap, or nearly, where they are at the start.
    StartCollision,
    /// A robot's URDF or SRDF does not describe a robot that can be planned for.
    BadRobot,
    /// Pairs that do not fit one another or the scene.
    BadTask,
    /// Orderings that contradict each other.
    CyclicOrder,
    /// More of something than is allowed.
    TooLarge,
}

impl FindingKind {
    /// Stable name, as printed before the message.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Unreadable => "unreadable",
            Self::Malformed => "malformed",
            Self::UnknownName => "unknown_name",
            Self::BadName => "bad_name",
            Self::BadNumber => "bad_number",
            Self::BadPlace => "bad_place",
            Self::StartCollision => "start_collision",
            Self::BadRobot => "bad_robot",
            Self::BadTask => "bad_task",
            Self::CyclicOrder => "cyclic_order",
            Self::TooLarge => "too_large",
        }
    }
}

/// One thing that is wrong.
#[derive(Clone)]
pub struct Finding {
    kind: FindingKind,
    message: String,
    help: Option<String>,
    labels: Vec<LabeledSpan>,
    source: Option<NamedSource<Arc<str>>>,
}

/// What a step of loading gives: a value, or the finding that stopped it.
pub(crate) type Found<T> = Result<T, Box<Finding>>;

/// Byte range in the text of one file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// First byte.
    pub offset: usize,
    /// Length in bytes.
    pub len: usize,
}

/// The text of one file, for messages.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    pub(crate) path: String,
    pub(crate) text: Arc<str>,
}

impl Source {
    /// A finding at one place of this file.
    pub(crate) fn finding(&self, span: Span, kind: FindingKind, message: impl Into<String>) -> Box<Finding> {
        Box::new(Finding {
            kind,
            message: message.into(),
            help: None,
            labels: vec![LabeledSpan::new_with_span(None, self.clip(self.widen(span)))],
            source: Some(NamedSource::new(&self.path, Arc::clone(&self.text))),
        })
    }

    /// A place that is only the start of something: up to the closing bracket, or else the rest of the line.
    fn widen(&self, span: Span) -> Span {
        let rest = self.text.get(span.offset..).unwrap_or_default();
        let line = rest.lines().next().unwrap_or_default();
        if span.len == 1 && line.starts_with(['[', '{']) {
            let mut depth = 0_usize;
            let closed = line.char_indices().find(|(_, c)| {
                match c {
                    '[' | '{' => depth += 1,
                    ']' | '}' => depth -= 1,
                    _ => {}
                }
                depth == 0
            });
            return Span { offset: span.offset, len: closed.map_or(1, |(end, _)| end + 1) };
        }
        if span.len == 0 { Span { offset: span.offset, len: line.trim_end().len() } } else { span }
    }

    /// Keeps a span inside the text and on character borders.
    fn clip(&self, span: Span) -> (usize, usize) {
        let mut start = span.offset.min(self.text.len());
        while !self.text.is_char_boundary(start) {
            start -= 1;
        }
        let mut end = span.offset.saturating_add(span.len).clamp(start, self.text.len());
        while !self.text.is_char_boundary(end) {
            end += 1;
        }
        (start, end - start)
    }
}

impl Finding {
    /// A finding about a file as a whole.
    pub(crate) fn of_file(path: &str, kind: FindingKind, message: impl fmt::Display) -> Box<Self> {
        let message = format!("{path}: {message}");
        Box::new(Self { kind, message, help: None, labels: Vec::new(), source: None })
    }

    /// Adds the remedy.
    pub(crate) fn help(mut self: Box<Self>, help: impl Into<String>) -> Box<Self> {
        self.help = Some(help.into());
        self
    }

    /// Adds a remark at a second place of the same file.
    pub(crate) fn note(mut self: Box<Self>, source: &Source, span: Span, text: impl Into<String>) -> Box<Self> {
        self.labels.push(LabeledSpan::new_with_span(Some(text.into()), source.clip(source.widen(span))));
        self
    }

    /// Its kind.
    #[must_use]
    pub fn kind(&self) -> FindingKind {
        self.kind
    }

    /// Path of the file that it is about, if it has a place in one.
    #[must_use]
    pub fn path(&self) -> Option<&str> {
        self.source.as_ref().map(NamedSource::name)
    }

    /// Line (from 1) of the first place.
    #[must_use]
    pub fn line(&self) -> Option<usize> {
        let (source, label) = (self.source.as_ref()?, self.labels.first()?);
        let before = source.inner().get(..label.offset())?;
        Some(before.matches('\n').count() + 1)
    }
}

impl fmt::Debug for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {self}", self.kind.name())
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Finding {}

impl Diagnostic for Finding {
    fn code<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        Some(Box::new(format!("problem::{}", self.kind.name())))
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.help.as_ref().map(|help| Box::new(help) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.source.as_ref().map(|source| source as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        (!self.labels.is_empty()).then(|| Box::new(self.labels.iter().cloned()) as Box<dyn Iterator<Item = _>>)
    }
}

impl ProblemError {
    /// All findings, in file order; at least one.
    #[must_use]
    pub fn findings(&self) -> &[Finding] {
        &self.findings
    }
}

impl From<Box<Finding>> for ProblemError {
    fn from(finding: Box<Finding>) -> Self {
        Self { findings: vec![*finding] }
    }
}

impl fmt::Display for ProblemError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.findings.first().map_or(Ok(()), |first| first.fmt(f))
    }
}

impl std::error::Error for ProblemError {}

impl Diagnostic for ProblemError {
    fn code<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.findings.first()?.code()
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.findings.first()?.help()
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.findings.first()?.source_code()
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        self.findings.first()?.labels()
    }

    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        let rest = self.findings.get(1..)?;
        (!rest.is_empty()).then(|| Box::new(rest.iter().map(|f| f as &dyn Diagnostic)) as Box<dyn Iterator<Item = _>>)
    }
}

/// Findings of one step of loading: as many as there are, so that a user mends them in one go.
#[derive(Default)]
pub(crate) struct Findings(Vec<Finding>);

impl Findings {
    /// More than these are not told.
    const MOST: usize = 20;

    /// Keeps the finding of a failed step.
    pub(crate) fn keep<T>(&mut self, found: Found<T>) -> Option<T> {
        match found {
            Ok(value) => Some(value),
            Err(finding) => {
                // Robots that share a file share its faults.
                let told = |known: &Finding| {
                    (&known.message, known.path(), known.line()) == (&finding.message, finding.path(), finding.line())
                };
                if self.0.len() < Self::MOST && !self.0.iter().any(told) {
                    self.0.push(*finding);
                }
                None
            }
        }
    }

    /// Ends the step: an error if there was any finding.
    pub(crate) fn end(&mut self) -> Result<(), ProblemError> {
        if self.0.is_empty() { Ok(()) } else { Err(ProblemError { findings: std::mem::take(&mut self.0) }) }
    }
}
