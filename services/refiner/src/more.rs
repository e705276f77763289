//! What a candidate does when the transition stage has no alternatives left, by the stage's policy.

use contract::{Alternative, Answer, LedgerEntry, StageKind};
use model::{FailurePolicy, PairId};

use crate::asking::misfit;
use crate::candidate::{Candidate, Found};
use crate::conflict::{Halt, Stuck};
use crate::search::Search;

impl Candidate<'_> {
    /// Completes the candidate to a plan. Where no alternatives are left, the transition stage has failed.
    pub(crate) fn complete(mut self, search: &mut Search<'_>) -> Result<Found, Stuck> {
        self.ask_alternatives(search, &self.every_pair())?;
        let mut more = search.policy(StageKind::Transition).doublings();
        loop {
            let conflict = match self.settle(search) {
                Err(Stuck::Failed(conflict)) => conflict,
                ended => return ended,
            };
            if self.patience == 0 {
                return Err(Stuck::Failed(conflict));
            }
            if search.policy(StageKind::Transition) == FailurePolicy::Stop {
                search.commit(LedgerEntry::Stopped { stage: StageKind::Transition });
                return Err(Halt::Stopped(conflict.causes.ranked()).into());
            }
            loop {
                let Some(doublings) = more.next() else { return Err(Stuck::Failed(conflict)) };
                if self.more_alternatives(search, doublings)? {
                    break;
                }
            }
        }
    }

    /// Asks for more alternatives of the pairs that have none left; whether there are any.
    fn more_alternatives(&mut self, search: &mut Search<'_>, doublings: u32) -> Result<bool, Stuck> {
        search.decide_more(StageKind::Transition, doublings);
        let pairs: Vec<PairId> = self.used_up.iter().copied().collect();
        let mut jobs = Vec::new();
        for pair in &pairs {
            jobs.extend(search.with_more(&self.alternatives_job(*pair), doublings)?);
        }
        let mut found = false;
        for (pair, outcome) in pairs.iter().zip(search.ask_once(&jobs)?) {
            match outcome.result {
                Ok(Answer::Alternatives(alternatives)) => {
                    let offered = &mut self.offered[pair.index()];
                    let known = |new: &Alternative| offered.iter().any(|old| is_same(old, new));
                    let new: Vec<Alternative> = alternatives.into_iter().filter(|new| !known(new)).collect();
                    found |= !new.is_empty();
                    offered.extend(new);
                    self.blocked[pair.index()].resize(offered.len(), None);
                }
                Ok(_) => return Err(misfit(StageKind::Transition).into()),
                Err(_) => {}
            }
        }
        if found {
            self.begin_anew();
        }
        Ok(found)
    }
}

/// Whether two alternatives, asked for at different levels, are one.
fn is_same(a: &Alternative, b: &Alternative) -> bool {
    (a.grasp, &a.pick, &a.place) == (b.grasp, &b.pick, &b.place)
}
