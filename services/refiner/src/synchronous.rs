//! Synchronous schedules over one set of roadmaps: for comparison with asynchronous plans, and as a second way to one.

use contract::{Answer, Composition, Decision, Job, LedgerEntry, Outcome, ProductRef, RoundChoice, StageKind};
use skeleton::ModeId;

use crate::asking::misfit;
use crate::candidate::{Candidate, Found, Modes};
use crate::compose::roadmaps_of;
use crate::conflict::{Choice, Conflict, Stuck};
use crate::search::Search;

impl Candidate<'_> {
    /// A plan in rounds.
    pub(crate) fn in_rounds(
        &self,
        search: &mut Search<'_>,
        modes: &Modes,
        choice: RoundChoice,
    ) -> Result<Found, Stuck> {
        let job = self.rounds_job(search, modes, choice);
        let outcome = search.ask_one(&job)?;
        let rounds = self.rounds(search, &job, outcome);
        if let Err(Stuck::Failed(conflict)) = &rounds {
            search.backtrack(StageKind::Composite, Decision::Synchronous(choice), conflict.first_cause());
        }
        let (prefix, rounds) = rounds?;
        self.assemble(search, modes, prefix, rounds)
    }

    /// The shorter of two plans without rounds: mode by mode; and the motion of the optimal rounds, each robot on its own
    /// clock. So it is never longer than the plan in optimal rounds.
    pub(crate) fn shorter(&self, search: &mut Search<'_>, modes: &Modes) -> Result<Found, Stuck> {
        let mode_by_mode = match self.prioritised(search, modes) {
            Err(Stuck::Halted(halt)) => return Err(halt.into()),
            ended => ended,
        };
        let job = self.rounds_job(search, modes, RoundChoice::Optimal);
        // That there are no rounds is no failure of the stage here.
        let outcome = search.ask_once(std::slice::from_ref(&job))?.pop().ok_or_else(|| misfit(StageKind::Composite))?;
        let rounds = self.rounds(search, &job, outcome);
        let without_waits = rounds.and_then(|(prefix, _)| self.assemble(search, modes, prefix, Vec::new()));
        match (mode_by_mode, without_waits) {
            (_, Err(Stuck::Halted(halt))) => Err(halt.into()),
            (Ok(first), Ok(second)) => Ok(if second.1 < first.1 { second } else { first }),
            (Err(_), Ok(found)) | (Ok(found), Err(_)) => Ok(found),
            (Err(failed), Err(_)) => Err(failed),
        }
    }

    fn rounds_job(&self, search: &mut Search<'_>, modes: &Modes, choice: RoundChoice) -> Job {
        search.commit(LedgerEntry::Decided(Decision::Synchronous(choice)));
        self.compose_job(Composition::Synchronous { choice, roadmaps: roadmaps_of(modes) })
    }

    /// A prefix of all modes and its rounds. Where there is none, any choice might be at fault.
    fn rounds(
        &self,
        search: &mut Search<'_>,
        job: &Job,
        outcome: Outcome,
    ) -> Result<(ProductRef, Vec<Vec<ModeId>>), Stuck> {
        match outcome.result {
            Ok(Answer::Rounds { prefix, rounds, .. }) => {
                for round in &rounds {
                    search.commit(LedgerEntry::Decided(Decision::Round(round.clone())));
                }
                Ok((prefix, rounds))
            }
            Ok(_) => Err(misfit(StageKind::Composite).into()),
            Err(report) => {
                let mut choices = self.all_pairs();
                choices.extend(self.skeleton.occupancies().map(Choice::Pose));
                Err(Stuck::Failed(Conflict::of(choices, &report.causes, Some(search.id(job)))))
            }
        }
    }
}
