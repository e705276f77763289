//! Launch files: which processes a run consists of.

use std::path::Path;

use contract::StageKind;
use miette::Report;
use model::SearchSettings;
use serde::de::{Error as _, Visitor};
use serde::{Deserialize, Deserializer};

use super::policy::{Policy, Restart};
use crate::exit::BadInput;

/// The default set.
const DEFAULT: &str = include_str!("../sets/default.yaml");
/// Most workers of one entry.
const MAX_REPLICAS: u32 = 64;

/// A set of processes.
#[derive(Clone, Debug, PartialEq, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LaunchFile {
    /// Jobs in work that nobody has asked for yet.
    pub speculation: usize,
    /// Workers.
    pub stages: Stages,
    /// The process that searches.
    pub refiner: RefinerEntry,
    /// What the search does when a stage fails, and how much it may work; wins over the problem's.
    pub search: SearchSettings,
}

impl Default for LaunchFile {
    fn default() -> Self {
        let (stages, refiner) = (Stages::default(), RefinerEntry::default());
        Self { speculation: 2, stages, refiner, search: SearchSettings::default() }
    }
}

/// Workers of each stage.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Stages {
    /// Placement.
    pub placement: StageEntry,
    /// Transition.
    pub transition: StageEntry,
    /// Roadmap.
    pub roadmap: StageEntry,
    /// Composite.
    pub composite: StageEntry,
}

impl Default for Stages {
    fn default() -> Self {
        let roadmap = StageEntry { replicas: Replicas::PerRobot, ..StageEntry::default() };
        let other = StageEntry::default;
        Self { placement: other(), transition: other(), roadmap, composite: other() }
    }
}

impl Stages {
    /// The entry of a stage.
    #[must_use]
    pub fn of(&self, stage: StageKind) -> &StageEntry {
        match stage {
            StageKind::Placement => &self.placement,
            StageKind::Transition => &self.transition,
            StageKind::Roadmap => &self.roadmap,
            StageKind::Composite => &self.composite,
        }
    }

    /// The entry of a stage.
    pub fn of_mut(&mut self, stage: StageKind) -> &mut StageEntry {
        match stage {
            StageKind::Placement => &mut self.placement,
            StageKind::Transition => &mut self.transition,
            StageKind::Roadmap => &mut self.roadmap,
            StageKind::Composite => &mut self.composite,
        }
    }
}

/// Workers of one stage.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StageEntry {
    /// Program and its first arguments; by default this program's own stage.
    pub command: Option<Vec<String>>,
    /// How many.
    pub replicas: Replicas,
    /// When a worker that has ended is started again.
    pub restart: Restart,
    /// How often within `restart_window`.
    pub max_restarts: u32,
    /// Seconds.
    pub restart_window: u32,
    /// Whether the run ends when a worker is given up.
    pub required: bool,
}

impl Default for StageEntry {
    fn default() -> Self {
        let Policy { restart, max_restarts, restart_window, required } = Policy::default();
        Self { command: None, replicas: Replicas::Count(1), restart, max_restarts, restart_window, required }
    }
}

impl StageEntry {
    /// Its restart policy.
    #[must_use]
    pub fn policy(&self) -> Policy {
        let Self { restart, max_restarts, restart_window, required, .. } = *self;
        Policy { restart, max_restarts, restart_window, required }
    }
}

/// The process that searches.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RefinerEntry {
    /// Program and its first arguments; by default this program's own refiner.
    pub command: Option<Vec<String>>,
    /// When it is started again after it has ended.
    pub restart: Restart,
    /// How often within `restart_window`.
    pub max_restarts: u32,
    /// Seconds.
    pub restart_window: u32,
}

impl Default for RefinerEntry {
    fn default() -> Self {
        let Policy { restart, max_restarts, restart_window, .. } = Policy::default();
        Self { command: None, restart, max_restarts, restart_window }
    }
}

impl RefinerEntry {
    /// Its restart policy. Without a refiner there is no run.
    #[must_use]
    pub fn policy(&self) -> Policy {
        let Self { restart, max_restarts, restart_window, .. } = *self;
        Policy { restart, max_restarts, restart_window, required: true }
    }
}

/// How many workers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Replicas {
    /// So many.
    Count(u32),
    /// One for each robot; it gets its robot's jobs.
    PerRobot,
}

impl<'de> Deserialize<'de> for Replicas {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Words;
        impl Visitor<'_> for Words {
            type Value = Replicas;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                write!(f, "a number from 1 to {MAX_REPLICAS}, or per_robot")
            }

            fn visit_u64<E: serde::de::Error>(self, count: u64) -> Result<Replicas, E> {
                match u32::try_from(count) {
                    Ok(count @ 1..=MAX_REPLICAS) => Ok(Replicas::Count(count)),
                    _ => Err(E::invalid_value(serde::de::Unexpected::Unsigned(count), &self)),
                }
            }

            fn visit_i64<E: serde::de::Error>(self, count: i64) -> Result<Replicas, E> {
                self.visit_u64(u64::try_from(count).unwrap_or(0))
            }

            fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<Replicas, E> {
                match word.parse() {
                    Ok(count) => self.visit_u64(count),
                    Err(_) if word == "per_robot" => Ok(Replicas::PerRobot),
                    Err(_) => Err(E::invalid_value(serde::de::Unexpected::Str(word), &self)),
                }
            }
        }
        deserializer.deserialize_any(Words).map_err(D::Error::custom)
    }
}

impl schemars::JsonSchema for Replicas {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Replicas".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "description": "How many workers.",
            "anyOf": [
                { "type": "integer", "minimum": 1, "maximum": MAX_REPLICAS },
                { "const": "per_robot" }
            ]
        })
    }
}

/// Reads a launch file; by default the built-in one.
///
/// # Errors
/// A report that names file and line; its exit code is that of bad input.
pub fn load(path: Option<&Path>) -> miette::Result<LaunchFile> {
    match path {
        None => parse(DEFAULT, "default.yaml"),
        Some(path) => {
            let bytes = crate::problem_source::read_file(path)?;
            let name = path.to_string_lossy();
            let text = String::from_utf8(bytes)
                .map_err(|_| Report::new(BadInput::new(format!("{name} is not text in UTF-8"))))?;
            parse(&text, &name)
        }
    }
}

/// Reads the text of a launch file called `name`.
///
/// # Errors
/// A report that names file and line; its exit code is that of bad input.
pub fn parse(text: &str, name: &str) -> miette::Result<LaunchFile> {
    let file: LaunchFile = serde_saphyr::from_str(text).map_err(|error| {
        let options = serde_saphyr::render_options! { source_name: Some(name) };
        let located = serde_saphyr::miette::to_miette_report_with_options(&error, text, name, options);
        Report::new(BadInput { message: format!("launch file {located:?}"), help: None })
    })?;
    for stage in StageKind::ALL {
        check_command(file.stages.of(stage).command.as_ref(), name, stage.name())?;
    }
    check_command(file.refiner.command.as_ref(), name, "refiner")?;
    Ok(file)
}

fn check_command(command: Option<&Vec<String>>, file: &str, entry: &str) -> miette::Result<()> {
    if command.is_some_and(|words| words.first().is_none_or(String::is_empty)) {
        return Err(Report::new(BadInput {
            message: format!("{file}: {entry}: `command` is empty"),
            help: Some("name a program, or leave `command` out for this program's own".to_owned()),
        }));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_set_says_what_is_assumed_anyway() {
        assert_eq!(load(None).unwrap(), LaunchFile::default());
        assert_eq!(parse("{}", "x").unwrap(), LaunchFile::default());
    }

    #[test]
    fn entries_that_are_written_replace_those_that_are_assumed() {
        let text =
            "stages:\n  placement: { replicas: 3, required: false }\n  roadmap: { command: [a, b], restart: never }\n";
        let file = parse(text, "x").unwrap();
        assert_eq!(file.stages.placement.replicas, Replicas::Count(3));
        assert!(!file.stages.placement.required);
        let roadmap = &file.stages.roadmap;
        assert_eq!(
            (roadmap.command.as_deref(), roadmap.restart),
            (Some(&["a".to_owned(), "b".to_owned()][..]), Restart::Never)
        );
        assert_eq!(file.stages.composite, StageEntry::default());
    }

    #[test]
    fn mistakes_are_located() {
        let cases = [
            ("stages:\n  placment: {}\n", "placment", "set.yaml:2:3"),
            ("stages:\n  roadmap:\n    replicas: 0\n", "from 1 to 64", "set.yaml:3:15"),
            ("stages:\n  roadmap:\n    replicas: per_arm\n", "per_robot", "set.yaml:3:15"),
            ("stages:\n  roadmap:\n    restart: sometimes\n", "sometimes", "set.yaml:3:14"),
            ("refiner:\n  command: []\n", "command", "set.yaml"),
            ("search:\n  policy: {roadmap: halt}\n", "no policy", "set.yaml:2:21"),
            ("search:\n  limit: {drrt: 0}\n", "drrt", "set.yaml:2"),
            ("search:\n  time_limit: -1\n", "seconds", "set.yaml:2:15"),
        ];
        for (text, wrong, place) in cases {
            let report = parse(text, "set.yaml").unwrap_err();
            let said = format!("{report}");
            assert!(said.contains(wrong) && said.contains(place), "{text} gave {said}");
            assert!(report.is::<BadInput>());
        }
    }
}
