//! Options of the search on the command line.

use std::num::NonZeroU64;
use std::str::FromStr;

use clap::Args;
use contract::{StageKind, WorkKind};
use model::{FailurePolicy, SearchSettings};

/// Options of the search. They win over the launch file's, and those over the problem's.
#[derive(Args, Clone, Debug, Default)]
pub struct SearchArgs {
    /// What a stage's failures lead to: stop, backtrack, backtrack:no_causes, or more:FACTOR:LIMIT. May be repeated.
    #[arg(long = "policy", value_name = "STAGE=POLICY")]
    pub policies: Vec<StagePolicy>,
    /// Work units of a stage, or of drrt, after which the run ends. May be repeated.
    #[arg(long = "limit", value_name = "STAGE=UNITS")]
    pub limits: Vec<WorkLimit>,
}

/// A stage's policy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StagePolicy(StageKind, FailurePolicy);

/// A limit on work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WorkLimit(WorkKind, NonZeroU64);

impl FromStr for StagePolicy {
    type Err = String;

    fn from_str(words: &str) -> Result<Self, String> {
        let (stage, policy) = words.split_once('=').ok_or("STAGE=POLICY is expected, such as transition=more:2:3")?;
        Ok(Self(stage_of(stage)?, policy.parse().map_err(|error: model::PolicyError| error.to_string())?))
    }
}

impl FromStr for WorkLimit {
    type Err = String;

    fn from_str(words: &str) -> Result<Self, String> {
        let (work, units) = words.split_once('=').ok_or("STAGE=UNITS is expected, such as composite=100000")?;
        let work = if work == "drrt" { WorkKind::Drrt } else { WorkKind::Stage(stage_of(work)?) };
        let units = units.parse().map_err(|_| format!("`{units}` is no whole number above 0"))?;
        Ok(Self(work, units))
    }
}

fn stage_of(name: &str) -> Result<StageKind, String> {
    let known = || StageKind::ALL.map(StageKind::name).join(", ");
    StageKind::of_name(name).ok_or_else(|| format!("no stage is called `{name}`; there are {}", known()))
}

impl std::fmt::Display for StagePolicy {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}={}", self.0, self.1)
    }
}

impl std::fmt::Display for WorkLimit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}={}", self.0, self.1)
    }
}

impl SearchArgs {
    /// The settings that were given; of several for one stage the last.
    #[must_use]
    pub fn settings(&self) -> SearchSettings {
        let mut settings = SearchSettings::default();
        for StagePolicy(stage, policy) in &self.policies {
            let slot = match stage {
                StageKind::Placement => &mut settings.policy.placement,
                StageKind::Transition => &mut settings.policy.transition,
                StageKind::Roadmap => &mut settings.policy.roadmap,
                StageKind::Composite => &mut settings.policy.composite,
            };
            *slot = Some(*policy);
        }
        for WorkLimit(work, units) in &self.limits {
            let slot = match work {
                WorkKind::Stage(StageKind::Placement) => &mut settings.limit.placement,
                WorkKind::Stage(StageKind::Transition) => &mut settings.limit.transition,
                WorkKind::Stage(StageKind::Roadmap) => &mut settings.limit.roadmap,
                WorkKind::Stage(StageKind::Composite) => &mut settings.limit.composite,
                WorkKind::Drrt => &mut settings.limit.drrt,
            };
            *slot = Some(*units);
        }
        settings
    }

    /// The arguments as words.
    #[must_use]
    pub fn to_arguments(&self) -> Vec<String> {
        let policies = self.policies.iter().flat_map(|policy| ["--policy".to_owned(), policy.to_string()]);
        let limits = self.limits.iter().flat_map(|limit| ["--limit".to_owned(), limit.to_string()]);
        policies.chain(limits).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_become_settings_and_words_again() {
        let args = SearchArgs {
            policies: ["transition=stop", "transition=more:2:3"].map(|words| words.parse().unwrap()).into(),
            limits: ["composite=100", "drrt=7"].map(|words| words.parse().unwrap()).into(),
        };
        let settings = args.settings();
        assert_eq!(settings.policy.transition, Some(FailurePolicy::More { factor: 2, limit: 3 }));
        assert_eq!(settings.policy.roadmap, None);
        let units = [settings.limit.composite, settings.limit.drrt, settings.limit.placement];
        assert_eq!(units.map(|limit| limit.map(NonZeroU64::get)), [Some(100), Some(7), None]);
        let words = args.to_arguments();
        assert_eq!(words[..4], ["--policy", "transition=stop", "--policy", "transition=more:2:3"]);
        assert_eq!(words[4..], ["--limit", "composite=100", "--limit", "drrt=7"]);
    }

    #[test]
    fn wrong_words_are_told() {
        for (words, told) in
            [("transition", "STAGE=POLICY"), ("motion=stop", "no stage"), ("roadmap=halt", "no policy")]
        {
            assert!(words.parse::<StagePolicy>().unwrap_err().contains(told), "{words}");
        }
        for (words, told) in [("composite=0", "above 0"), ("composite=1e5", "above 0"), ("dRRT=1", "no stage")] {
            assert!(words.parse::<WorkLimit>().unwrap_err().contains(told), "{words}");
        }
    }
}
