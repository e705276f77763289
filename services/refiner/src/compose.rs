//! Composite motion of one set of roadmaps: mode by mode with safe tails, then the composite search; or in rounds.

use std::collections::BTreeSet;

use contract::{
    Answer, ComposeJob, CompositeMethod, Composition, Decision, Job, LedgerEntry, ProductRef, Request, RoundChoice,
    StageKind,
};
use model::PairId;
use skeleton::ModeId;

use crate::asking::misfit;
use crate::candidate::{Candidate, Found, Modes};
use crate::commit::Committed;
use crate::conflict::{Choice, Conflict, Stuck};
use crate::search::Search;

impl Candidate<'_> {
    /// A plan over the roadmaps.
    pub(crate) fn compose(&self, search: &mut Search<'_>, modes: &Modes) -> Result<Found, Stuck> {
        match search.statement.composite {
            CompositeMethod::Drrt => {
                let prefix = self.drrt(search, modes, None, self.all_pairs())?;
                self.assemble(search, modes, prefix, Vec::new())
            }
            CompositeMethod::Prioritised => self.prioritised(search, modes),
            CompositeMethod::Shorter => self.shorter(search, modes),
            CompositeMethod::SyncGreedy => self.in_rounds(search, modes, RoundChoice::Greedy),
            CompositeMethod::SyncOpt => self.in_rounds(search, modes, RoundChoice::Optimal),
        }
    }

    /// Mode by mode, with the composite search where that fails.
    pub(crate) fn prioritised(&self, search: &mut Search<'_>, modes: &Modes) -> Result<Found, Stuck> {
        let prefixes = match self.commit_modes(search, modes)? {
            Committed::All(prefixes) => prefixes,
            Committed::Never(conflict) => return Err(Stuck::Failed(conflict)),
            Committed::Part(prefixes, between) => vec![self.drrt_from(search, modes, &prefixes, between)?],
        };
        let mut shortest: Option<Found> = None;
        for prefix in prefixes {
            let found = self.assemble(search, modes, prefix, Vec::new())?;
            if shortest.is_none_or(|so_far| found.1 < so_far.1) {
                shortest = Some(found);
            }
        }
        shortest.ok_or_else(|| misfit(StageKind::Composite).into())
    }

    /// The plan of a complete prefix, with rounds if it has any.
    pub(crate) fn assemble(
        &self,
        search: &mut Search<'_>,
        modes: &Modes,
        prefix: ProductRef,
        rounds: Vec<Vec<ModeId>>,
    ) -> Result<Found, Stuck> {
        let shortest_s = modes.iter().map(|robot| robot.iter().map(|mode| mode.shortest_s).collect()).collect();
        let job = self.compose_job(Composition::Assemble { prefix, shortest_s, rounds });
        match search.ask_one(&job)?.result {
            Ok(Answer::Plan { plan, makespan_s }) => Ok((plan, makespan_s)),
            Ok(_) => Err(misfit(StageKind::Composite).into()),
            Err(report) => Err(Stuck::Failed(Conflict::of(self.all_pairs(), &report.causes, Some(search.id(&job))))),
        }
    }

    pub(crate) fn all_pairs(&self) -> BTreeSet<Choice> {
        (0..self.problem.pairs.len()).map(|pair| Choice::Alternative(PairId::at(pair))).collect()
    }

    /// The composite search where commitment came to a dead end: from there, from half way, then from the beginning.
    fn drrt_from(
        &self,
        search: &mut Search<'_>,
        modes: &Modes,
        prefixes: &[ProductRef],
        mut between: BTreeSet<Choice>,
    ) -> Result<ProductRef, Stuck> {
        if between.is_empty() {
            between = self.all_pairs();
        }
        let mut begins: Vec<ProductRef> =
            prefixes.last().into_iter().chain(prefixes.get(prefixes.len() / 2)).copied().collect();
        begins.dedup();
        for prefix in begins {
            match self.drrt(search, modes, Some(prefix), between.clone()) {
                Err(Stuck::Failed(_)) => {}
                ended => return ended,
            }
        }
        self.drrt(search, modes, None, between)
    }

    /// The composite search for everything after a prefix; where it fails, one of `between` should change.
    fn drrt(
        &self,
        search: &mut Search<'_>,
        modes: &Modes,
        prefix: Option<ProductRef>,
        mut between: BTreeSet<Choice>,
    ) -> Result<ProductRef, Stuck> {
        search.commit(LedgerEntry::Decided(Decision::Drrt));
        let job = self.compose_job(Composition::Drrt { prefix, roadmaps: roadmaps_of(modes) });
        match search.ask_one(&job)?.result {
            Ok(Answer::Committed { prefix, .. }) => Ok(prefix),
            Ok(_) => Err(misfit(StageKind::Composite).into()),
            Err(report) => {
                // All robots move among all poses: which of them matter is not known.
                between.extend(self.skeleton.occupancies().map(Choice::Pose));
                let conflict = Conflict::of(between, &report.causes, Some(search.id(&job)));
                search.backtrack(StageKind::Composite, Decision::Drrt, conflict.first_cause());
                Err(Stuck::Failed(conflict))
            }
        }
    }

    pub(crate) fn compose_job(&self, composition: Composition) -> Job {
        self.budgets.job(Request::Compose(ComposeJob { assignment: self.assignment(), composition }))
    }
}

/// Roadmap of every mode of every robot.
pub(crate) fn roadmaps_of(modes: &Modes) -> Vec<Vec<ProductRef>> {
    modes.iter().map(|robot| robot.iter().map(|mode| mode.roadmap).collect()).collect()
}
