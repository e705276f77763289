//! What has happened in a run so far, as an observer sees it: pure counting.

use contract::{Answer, CauseTally, Decision, FailureReport, Ledger, LedgerEntry, Outcome, StageKind};
use plan::{Cause, Reached, StageCount};

/// Work of one stage as it was observed.
#[derive(Clone, Debug, Default)]
pub struct StageTally {
    /// Jobs answered.
    pub jobs: u64,
    /// Jobs answered with a failure.
    pub failures: u64,
    /// Work units spent.
    pub work: u64,
    /// Placement candidates, alternatives, pieces and roadmaps, or prefixes answered.
    pub answers: u64,
    causes: CauseTally,
}

impl StageTally {
    /// The commonest cause of its failures: of what could not be done, or else of contacts.
    #[must_use]
    pub fn commonest(&self) -> Option<Cause> {
        let ranked = self.causes.clone().ranked();
        let first = ranked.iter().find(|(cause, _)| !is_contact(cause)).or(ranked.first());
        first.map(|(cause, _)| cause.clone())
    }
}

/// What has happened in a run so far.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    stages: [StageTally; 4],
    /// Causes of backtracking, which need not be causes of any one job.
    revised: CauseTally,
    reached: Option<Reached>,
    ledger: Ledger,
}

/// Whether a cause is a contact met while trying: counts of those do not compare with counts of others.
#[must_use]
pub fn is_contact(cause: &Cause) -> bool {
    matches!(cause, Cause::Collision { .. })
}

/// The cause that a report is best known by: what could not be done, or else a contact.
#[must_use]
pub fn first_cause(report: &FailureReport) -> Option<&Cause> {
    let causes = || report.causes.iter().map(|(cause, _)| cause);
    causes().find(|cause| !is_contact(cause)).or(causes().next())
}

impl Tally {
    /// A stage has answered.
    pub fn answered(&mut self, stage: StageKind, outcome: &Outcome) {
        let tally = &mut self.stages[stage as usize];
        tally.jobs += 1;
        tally.work += outcome.work;
        match &outcome.result {
            Err(report) => {
                tally.failures += 1;
                tally.causes.count_all(&report.causes);
            }
            Ok(Answer::Placements(list)) => tally.answers += list.len() as u64,
            Ok(Answer::Hop { choices, .. }) => tally.answers += choices.len() as u64,
            Ok(Answer::Alternatives(list)) => tally.answers += list.len() as u64,
            Ok(Answer::Blocked(_) | Answer::Samples(_) | Answer::NoPassage(_)) => {}
            Ok(
                Answer::Piece(_)
                | Answer::Mode { .. }
                | Answer::Committed { .. }
                | Answer::Plan { .. }
                | Answer::Repaired { .. }
                | Answer::Rounds { .. },
            ) => {
                tally.answers += 1;
            }
        }
    }

    /// The search has committed an entry.
    pub fn committed(&mut self, entry: &LedgerEntry) {
        if let LedgerEntry::Backtrack { because: Some(cause), .. } = entry {
            self.revised.count(cause.clone());
        }
        self.reached = reach(self.reached, entry);
        self.ledger.commit(entry.clone());
    }

    /// One stage.
    #[must_use]
    pub fn stage(&self, stage: StageKind) -> &StageTally {
        &self.stages[stage as usize]
    }

    /// How far the search is.
    #[must_use]
    pub fn reached(&self) -> Option<Reached> {
        self.reached
    }

    /// The committed log so far.
    #[must_use]
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// Work of every stage that has answered.
    #[must_use]
    pub fn counts(&self) -> Vec<StageCount> {
        let count = |stage: StageKind| {
            let StageTally { jobs, failures, work, .. } = *self.stage(stage);
            StageCount { stage: stage.name().to_owned(), jobs, failures, work }
        };
        StageKind::ALL.into_iter().map(count).filter(|count| count.jobs > 0).collect()
    }

    /// Causes met so far, most frequent first: those of failed jobs, then those that only backtracking names.
    #[must_use]
    pub fn causes(&self) -> Vec<(Cause, u64)> {
        let mut of_jobs = CauseTally::default();
        for stage in &self.stages {
            of_jobs.count_all(&stage.causes.clone().ranked());
        }
        let known = of_jobs.clone().ranked();
        let new = self.revised.clone().ranked().into_iter().filter(|(cause, _)| known.iter().all(|(k, _)| k != cause));
        of_jobs.count_all(&new.collect::<Vec<_>>());
        of_jobs.ranked()
    }
}

/// How far a search came whose ledger this is.
#[must_use]
pub fn reached(ledger: &Ledger) -> Option<Reached> {
    ledger.entries.iter().fold(None, reach)
}

/// A revision of any choice under which modes were committed takes their commitment back.
fn reach(before: Option<Reached>, entry: &LedgerEntry) -> Option<Reached> {
    let so_far = before.unwrap_or_default();
    match entry {
        LedgerEntry::Decided(Decision::Level(level)) => Some(Reached { level: *level, ..Reached::default() }),
        LedgerEntry::Decided(Decision::Placement(_)) => {
            Some(Reached { candidates: so_far.candidates + 1, committed: 0, ..so_far })
        }
        LedgerEntry::Decided(Decision::Commit(_)) => Some(Reached { committed: so_far.committed + 1, ..so_far }),
        LedgerEntry::Decided(Decision::Round(modes)) => {
            Some(Reached { committed: so_far.committed.saturating_add(modes.len() as u32), ..so_far })
        }
        LedgerEntry::Decided(Decision::Alternative { .. } | Decision::Order(_) | Decision::Synchronous(_)) => {
            before.map(|reached| Reached { committed: 0, ..reached })
        }
        _ => before,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use model::{PairId, RobotId};
    use skeleton::ModeId;

    fn decided(decision: Decision) -> LedgerEntry {
        LedgerEntry::Decided(decision)
    }

    #[test]
    fn how_far_a_search_came_is_read_from_its_decisions() {
        let commit = || decided(Decision::Commit(ModeId { robot: RobotId(0), step: 0 }));
        let mut tally = Tally::default();
        assert_eq!(tally.reached(), None);
        for entry in [decided(Decision::Level(0)), decided(Decision::Placement(0)), commit(), commit()] {
            tally.committed(&entry);
        }
        assert_eq!(tally.reached(), Some(Reached { level: 0, candidates: 1, committed: 2 }));
        tally.committed(&decided(Decision::Alternative { pair: PairId(0), index: 3 }));
        tally.committed(&commit());
        assert_eq!(tally.reached(), Some(Reached { level: 0, candidates: 1, committed: 1 }));
        tally.committed(&decided(Decision::Placement(1)));
        assert_eq!(tally.reached(), Some(Reached { level: 0, candidates: 2, committed: 0 }));
        tally.committed(&decided(Decision::Level(1)));
        assert_eq!(tally.reached(), Some(Reached { level: 1, candidates: 0, committed: 0 }));
        assert_eq!(reached(tally.ledger()), tally.reached());
    }

    #[test]
    fn causes_of_jobs_come_with_their_counts_and_those_of_backtracking_are_added_once() {
        let no_place = |object: &str| Cause::NoPlacement { object: object.to_owned(), region: "r".to_owned() };
        let mut causes = CauseTally::default();
        causes.count_all(&[(no_place("a"), 3)]);
        let mut tally = Tally::default();
        tally.answered(StageKind::Placement, &Outcome::soft_failure(causes, 0, 7));
        tally.answered(StageKind::Transition, &Outcome::answer(Answer::Alternatives(Vec::new()), 2));
        for object in ["a", "b"] {
            let decision = Decision::Placement(0);
            let because = Some(no_place(object));
            tally.committed(&LedgerEntry::Backtrack { stage: StageKind::Placement, decision, because });
        }
        assert_eq!(tally.causes(), [(no_place("a"), 3), (no_place("b"), 1)]);
        let counts: Vec<(String, u64, u64, u64)> =
            tally.counts().into_iter().map(|count| (count.stage, count.jobs, count.failures, count.work)).collect();
        assert_eq!(counts, [("placement".to_owned(), 1, 1, 7), ("transition".to_owned(), 1, 0, 2)]);
    }

    #[test]
    fn what_could_not_be_done_says_more_than_a_contact() {
        use plan::BodyRef;
        let contact =
            Cause::Collision { first: BodyRef::Object("a".to_owned()), second: BodyRef::Object("b".to_owned()) };
        let done = Cause::NoCommonGrasp { pair: "p".to_owned() };
        let mut causes = CauseTally::default();
        causes.count_all(&[(contact.clone(), 1000), (done.clone(), 1)]);
        let outcome = Outcome::soft_failure(causes, 0, 0);
        assert_eq!(first_cause(outcome.result.as_ref().unwrap_err()), Some(&done));
        let mut tally = Tally::default();
        tally.answered(StageKind::Transition, &outcome);
        assert_eq!(tally.stage(StageKind::Transition).commonest(), Some(done));
    }
}
