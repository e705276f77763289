//! What happens in a run, for programs: one JSON object a line on stdout.

use contract::{Decision, LedgerEntry, Outcome, StageKind};
use model::Problem;
use plan::{Cause, PairPoint};
use serde::Serialize;

use super::tally::first_cause;
use crate::words;

/// One line.
#[derive(Serialize)]
pub struct Line<'a> {
    #[serde(flatten)]
    event: Event<'a>,
    elapsed_s: f64,
}

impl<'a> Line<'a> {
    /// An event and when it happened, in seconds since the start.
    #[must_use]
    pub fn new(event: Event<'a>, elapsed_s: f64) -> Self {
        Self { event, elapsed_s }
    }
}

/// Something that happened.
#[derive(Debug, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Event<'a> {
    /// Planning begins.
    Start {
        /// Name of the problem.
        problem: &'a str,
        /// Seed.
        seed: u64,
    },
    /// A sample level is begun.
    Level {
        /// Level.
        level: u32,
    },
    /// A placement candidate is taken up.
    Placement {
        /// Its index at this level.
        candidate: u32,
    },
    /// A pair is done in another way.
    Alternative {
        /// Pair.
        pair: &'a str,
        /// Index of the way.
        index: u32,
    },
    /// An ordering is added.
    Ordering {
        /// What comes first.
        before: PairPoint,
        /// What comes later.
        after: PairPoint,
        /// Why.
        cause: &'a Cause,
        /// Why, in words.
        words: String,
    },
    /// The object of a pair is placed, where steps are merged.
    Hop {
        /// Pair.
        pair: &'a str,
        /// Sample.
        sample: u32,
        /// Number of orderings added for it.
        orderings: usize,
    },
    /// A mode is committed.
    Committed {
        /// Mode, such as `r1.2 transfer`.
        mode: String,
    },
    /// A mode that cannot be committed, and the robots in its way, are planned together.
    Repair {
        /// Mode, such as `r1.2 transfer`.
        mode: String,
    },
    /// The composite search takes over.
    CompositeSearch,
    /// A synchronous schedule is asked for.
    Synchronous,
    /// Modes of the next round of a synchronous schedule.
    Round {
        /// Modes, such as `r1.2 transfer`.
        modes: Vec<String>,
    },
    /// A combination of placements is excluded.
    Learnt {
        /// Why.
        #[serde(skip_serializing_if = "Option::is_none")]
        cause: Option<&'a Cause>,
        /// Why, in words.
        words: String,
    },
    /// A decision is taken back.
    Backtrack {
        /// Stage whose decision it was.
        stage: StageKind,
        /// Decision, in words.
        decision: String,
        /// Why.
        #[serde(skip_serializing_if = "Option::is_none")]
        cause: Option<&'a Cause>,
        /// Why, in words.
        words: String,
    },
    /// A job was answered with a failure.
    Job {
        /// Stage.
        stage: StageKind,
        /// Its first cause.
        #[serde(skip_serializing_if = "Option::is_none")]
        cause: Option<&'a Cause>,
        /// The same in words.
        words: String,
    },
    /// Something of note about processes or the checker, or a process's own words.
    Note {
        /// What.
        words: &'a str,
    },
    /// A stage that has failed is asked again with more samples.
    More {
        /// Stage.
        stage: StageKind,
        /// So many times as many.
        times: u32,
    },
    /// A stage has failed whose policy is to stop.
    Stopped {
        /// Stage.
        stage: StageKind,
    },
    /// A limit on work is exceeded.
    WorkLimit {
        /// Limited work.
        work: String,
        /// Work units spent.
        spent: u64,
    },
    /// The search has a plan; the checker comes next.
    Solved,
}

impl<'a> Event<'a> {
    /// The event of a committed entry, if it is one.
    #[must_use]
    pub fn of_entry(problem: &'a Problem, entry: &'a LedgerEntry) -> Option<Self> {
        Some(match entry {
            LedgerEntry::Decided(decision) => Self::of_decision(problem, decision),
            LedgerEntry::Backtrack { stage, decision, because } => Self::Backtrack {
                stage: *stage,
                decision: words::decision(problem, decision),
                cause: because.as_ref(),
                words: because.as_ref().map_or(String::new(), words::cause),
            },
            LedgerEntry::Learnt(nogood) => Self::Learnt {
                cause: nogood.cause.as_ref(),
                words: nogood.cause.as_ref().map_or(String::new(), words::cause),
            },
            LedgerEntry::Stopped { stage } => Self::Stopped { stage: *stage },
            LedgerEntry::LimitReached { work, spent } => Self::WorkLimit { work: work.to_string(), spent: *spent },
            LedgerEntry::Used { .. } => return None,
            LedgerEntry::Solved { .. } => Self::Solved,
        })
    }

    fn of_decision(problem: &'a Problem, decision: &'a Decision) -> Self {
        match decision {
            Decision::Level(level) => Self::Level { level: *level },
            Decision::Placement(candidate) => Self::Placement { candidate: *candidate },
            Decision::Alternative { pair, index } => {
                Self::Alternative { pair: &problem.pair(*pair).name, index: *index }
            }
            Decision::Order(order) => {
                let point = |event: skeleton::Event| PairPoint {
                    pair: problem.pair(event.pair).name.clone(),
                    point: event.point,
                };
                Self::Ordering {
                    before: point(order.before),
                    after: point(order.after),
                    cause: &order.cause,
                    words: words::cause(&order.cause),
                }
            }
            Decision::Commit(mode) => Self::Committed { mode: words::mode(problem, *mode) },
            Decision::Repair(mode) => Self::Repair { mode: words::mode(problem, *mode) },
            Decision::Drrt => Self::CompositeSearch,
            Decision::Hop { pair, sample, orders } => {
                Self::Hop { pair: &problem.pair(*pair).name, sample: *sample, orderings: orders.len() }
            }
            Decision::Synchronous(_) => Self::Synchronous,
            Decision::Round(modes) => {
                Self::Round { modes: modes.iter().map(|mode| words::mode(problem, *mode)).collect() }
            }
            Decision::More { stage, times } => Self::More { stage: *stage, times: *times },
        }
    }

    /// The event of an answered job: failures alone are worth one.
    #[must_use]
    pub fn of_outcome(stage: StageKind, outcome: &'a Outcome) -> Option<Self> {
        let report = outcome.result.as_ref().err()?;
        let cause = first_cause(report);
        Some(Self::Job { stage, cause, words: cause.map_or(String::new(), words::cause) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use contract::{CauseTally, DiscoveredOrder};
    use model::{PairId, Point};
    use serde_json::{Value, json};

    fn value(event: Event<'_>) -> Value {
        serde_json::to_value(Line::new(event, 1.5)).unwrap()
    }

    #[test]
    fn an_event_is_one_object_with_its_name_its_parts_and_its_time() {
        let problem = crate::problem_source::load(Some(std::path::Path::new("t03_relay"))).unwrap();
        let level = LedgerEntry::Decided(Decision::Level(2));
        assert_eq!(
            value(Event::of_entry(&problem, &level).unwrap()),
            json!({"event": "level", "level": 2, "elapsed_s": 1.5})
        );
        let cause = Cause::NoCommonGrasp { pair: "p".to_owned() };
        let point = |pair: u32, point| skeleton::Event::new(PairId(pair), point);
        let order = DiscoveredOrder { before: point(0, Point::Grasp), after: point(1, Point::Release), cause };
        let ordering = LedgerEntry::Decided(Decision::Order(order));
        let found = value(Event::of_entry(&problem, &ordering).unwrap());
        assert_eq!(found["before"], json!({"pair": problem.pairs[0].name, "point": "grasp"}));
        assert_eq!(found["after"]["point"], "release");
        assert_eq!(found["cause"], json!({"no_common_grasp": {"pair": "p"}}));
        assert_eq!(found["words"], "no grasp serves both ends of p");
    }

    #[test]
    fn failed_jobs_alone_are_events() {
        let mut causes = CauseTally::default();
        causes.count(Cause::NoPlacement { object: "m1".to_owned(), region: "w".to_owned() });
        let failed = Outcome::soft_failure(causes, 0, 3);
        let found = value(Event::of_outcome(StageKind::Placement, &failed).unwrap());
        assert_eq!((&found["event"], &found["stage"]), (&json!("job"), &json!("placement")));
        assert_eq!(found["words"], "m1 finds no free place in w");
        let answered = Outcome::answer(contract::Answer::Placements(Vec::new()), 3);
        assert!(Event::of_outcome(StageKind::Placement, &answered).is_none());
    }
}
