//! What the search is to do when a stage fails, and how much it may work: said by a problem, a launch file or a user.

use std::num::NonZeroU64;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Most times as many samples as a level has that a stage may ask for when it fails.
const MOST_TIMES: u32 = 256;

/// What is done when a stage fails (paper Sec. III). Written `stop`, `backtrack`, `backtrack:no_causes` or
/// `more:FACTOR:LIMIT`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum FailurePolicy {
    /// The first failure ends the run.
    Stop,
    /// The stage before it chooses anew; placement, which has none before it, goes to the next level.
    Backtrack {
        /// Whether it is told what the failure depends on.
        causes: bool,
    },
    /// The same question is asked again with `factor` times as many samples, up to `limit` times; then as `Backtrack`.
    More {
        /// A power of two: samples double from level to level.
        factor: u32,
        /// How often.
        limit: u32,
    },
}

impl Default for FailurePolicy {
    fn default() -> Self {
        Self::Backtrack { causes: true }
    }
}

impl FailurePolicy {
    /// Whether the stage before is told what a failure depends on.
    #[must_use]
    pub fn tells_causes(self) -> bool {
        self != Self::Backtrack { causes: false }
    }

    /// For each time that the question is asked again, how often its samples are doubled.
    pub fn doublings(self) -> impl Iterator<Item = u32> + use<> {
        let (factor, limit) = match self {
            Self::More { factor, limit } => (factor, limit),
            Self::Stop | Self::Backtrack { .. } => (1, 0),
        };
        (1..=limit).map(move |time| time * factor.ilog2())
    }
}

/// Why a word is no policy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PolicyError {
    /// None of the words.
    #[error("`{0}` is no policy: stop, backtrack, backtrack:no_causes or more:FACTOR:LIMIT is expected")]
    Unknown(String),
    /// Numbers out of range.
    #[error(
        "`{0}`: FACTOR is a power of two from 2 on, LIMIT 1 or more, and FACTOR to the power LIMIT at most {MOST_TIMES}"
    )]
    OutOfRange(String),
}

impl FromStr for FailurePolicy {
    type Err = PolicyError;

    fn from_str(word: &str) -> Result<Self, PolicyError> {
        match word {
            "stop" => return Ok(Self::Stop),
            "backtrack" => return Ok(Self::Backtrack { causes: true }),
            "backtrack:no_causes" => return Ok(Self::Backtrack { causes: false }),
            _ => {}
        }
        let unknown = || PolicyError::Unknown(word.to_owned());
        let (factor, limit) = word.strip_prefix("more:").and_then(|rest| rest.split_once(':')).ok_or_else(unknown)?;
        let number = |digits: &str| digits.parse::<u32>().map_err(|_| unknown());
        let (factor, limit) = (number(factor)?, number(limit)?);
        let sensible = factor >= 2 && factor.is_power_of_two() && limit >= 1;
        if !sensible || factor.checked_pow(limit).is_none_or(|times| times > MOST_TIMES) {
            return Err(PolicyError::OutOfRange(word.to_owned()));
        }
        Ok(Self::More { factor, limit })
    }
}

impl TryFrom<String> for FailurePolicy {
    type Error = PolicyError;

    fn try_from(word: String) -> Result<Self, PolicyError> {
        word.parse()
    }
}

impl From<FailurePolicy> for String {
    fn from(policy: FailurePolicy) -> Self {
        policy.to_string()
    }
}

impl std::fmt::Display for FailurePolicy {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Stop => f.write_str("stop"),
            Self::Backtrack { causes: true } => f.write_str("backtrack"),
            Self::Backtrack { causes: false } => f.write_str("backtrack:no_causes"),
            Self::More { factor, limit } => write!(f, "more:{factor}:{limit}"),
        }
    }
}

impl schemars::JsonSchema for FailurePolicy {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "FailurePolicy".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "description": "What is done when a stage fails: `stop` ends the run; `backtrack` lets the stage before it choose anew (placement goes to the next level), told what the failure depends on or not; `more:FACTOR:LIMIT` asks again with FACTOR times as many samples, up to LIMIT times, then backtracks.",
            "type": "string",
            "pattern": "^(stop|backtrack|backtrack:no_causes|more:[0-9]+:[0-9]+)$"
        })
    }
}

/// A time in seconds, finite and not negative.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "f64", into = "f64")]
pub struct Seconds(f64);

impl TryFrom<f64> for Seconds {
    type Error = String;

    fn try_from(seconds: f64) -> Result<Self, String> {
        let sensible = (0.0..=1.0e9).contains(&seconds);
        sensible.then_some(Self(seconds)).ok_or_else(|| format!("{seconds} s: give 0 to 1e9 seconds"))
    }
}

impl From<Seconds> for f64 {
    fn from(seconds: Seconds) -> f64 {
        seconds.0
    }
}

impl schemars::JsonSchema for Seconds {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Seconds".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({ "type": "number", "minimum": 0, "maximum": 1.0e9 })
    }
}

/// What each stage's failures lead to; `backtrack` where nothing is said.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Policies {
    /// No placement is left.
    pub placement: Option<FailurePolicy>,
    /// No way to do a pair is left.
    pub transition: Option<FailurePolicy>,
    /// A robot finds no way.
    pub roadmap: Option<FailurePolicy>,
    /// The robots do not get past one another.
    pub composite: Option<FailurePolicy>,
}

/// Work units after which the run ends; unlimited where nothing is said.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WorkLimits {
    /// Of placement.
    pub placement: Option<NonZeroU64>,
    /// Of transition.
    pub transition: Option<NonZeroU64>,
    /// Of roadmap.
    pub roadmap: Option<NonZeroU64>,
    /// Of composite, dRRT* included.
    pub composite: Option<NonZeroU64>,
    /// Of dRRT* alone.
    pub drrt: Option<NonZeroU64>,
}

/// How a problem is to be searched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SearchSettings {
    /// What each stage's failures lead to.
    pub policy: Policies,
    /// Work units after which the run ends.
    pub limit: WorkLimits,
    /// Seconds after which the run ends.
    pub time_limit: Option<Seconds>,
}

impl SearchSettings {
    /// These settings; where they say nothing, those `beneath`.
    #[must_use]
    pub fn over(self, beneath: Self) -> Self {
        Self {
            policy: Policies {
                placement: self.policy.placement.or(beneath.policy.placement),
                transition: self.policy.transition.or(beneath.policy.transition),
                roadmap: self.policy.roadmap.or(beneath.policy.roadmap),
                composite: self.policy.composite.or(beneath.policy.composite),
            },
            limit: WorkLimits {
                placement: self.limit.placement.or(beneath.limit.placement),
                transition: self.limit.transition.or(beneath.limit.transition),
                roadmap: self.limit.roadmap.or(beneath.limit.roadmap),
                composite: self.limit.composite.or(beneath.limit.composite),
                drrt: self.limit.drrt.or(beneath.limit.drrt),
            },
            time_limit: self.time_limit.or(beneath.time_limit),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn policies_are_read_as_they_are_written() {
        for word in ["stop", "backtrack", "backtrack:no_causes", "more:2:3", "more:16:2"] {
            assert_eq!(word.parse::<FailurePolicy>().unwrap().to_string(), word);
        }
        for word in ["", "Stop", "more", "more:2", "more:2:x", "more:-2:1", "backtrack:causes", "more:2:3:4"] {
            assert!(matches!(word.parse::<FailurePolicy>(), Err(PolicyError::Unknown(_))), "{word}");
        }
        for word in ["more:1:1", "more:3:1", "more:2:0", "more:2:9", "more:512:1", "more:4294967295:2"] {
            assert!(matches!(word.parse::<FailurePolicy>(), Err(PolicyError::OutOfRange(_))), "{word}");
        }
    }

    #[test]
    fn more_samples_are_doublings_of_the_level() {
        let doublings = |word: &str| word.parse::<FailurePolicy>().unwrap().doublings().collect::<Vec<_>>();
        assert_eq!(doublings("more:2:3"), [1, 2, 3]);
        assert_eq!(doublings("more:4:2"), [2, 4]);
        assert!(doublings("stop").is_empty() && doublings("backtrack").is_empty());
    }

    #[test]
    fn what_is_said_above_wins_and_the_rest_shows_through() {
        let policy = |placement, transition| Policies { placement, transition, ..Policies::default() };
        let limit = |drrt| WorkLimits { drrt: NonZeroU64::new(drrt), ..WorkLimits::default() };
        let (stop, more) = (Some(FailurePolicy::Stop), Some(FailurePolicy::More { factor: 2, limit: 1 }));
        let above = SearchSettings { policy: policy(stop, None), limit: limit(5), time_limit: None };
        let time_limit = Seconds::try_from(3.0).ok();
        let beneath = SearchSettings { policy: policy(more, more), limit: limit(7), time_limit };
        assert_eq!(above.over(beneath), SearchSettings { policy: policy(stop, more), limit: limit(5), time_limit });
        assert!([-1.0, f64::NAN, f64::INFINITY].into_iter().all(|seconds| Seconds::try_from(seconds).is_err()));
    }
}
