//! Composite motion of one set of roadmaps: mode by mode with safe tails, then the composite search.

use std::collections::BTreeSet;

use contract::{
    Answer, ComposeJob, CompositeMethod, Composition, Decision, Job, LedgerEntry, ProductRef, Request, StageKind,
};
use model::PairId;
use plan::Cause;
use skeleton::{Event, Mode, ModeId};

use crate::asking::misfit;
use crate::candidate::{Candidate, Found, Modes};
use crate::conflict::{Choice, Conflict, Halt, Stuck};
use crate::search::Search;

/// A mode that could be committed next.
struct Ready {
    mode: ModeId,
    prefix: ProductRef,
    event_s: f64,
}

impl Candidate<'_> {
    /// A plan over the roadmaps.
    pub(crate) fn compose(&self, search: &mut Search<'_>, modes: &Modes) -> Result<Found, Stuck> {
        let prefix = match search.statement.composite {
            CompositeMethod::Drrt => self.drrt(search, modes, None, self.all_pairs())?,
            CompositeMethod::Prioritised => match self.commit_modes(search, modes)? {
                Committed::All(prefix) => prefix,
                Committed::Part(prefixes, conflict) => self.drrt_from(search, modes, &prefixes, conflict.choices)?,
            },
        };
        let shortest_s = modes.iter().map(|robot| robot.iter().map(|mode| mode.shortest_s).collect()).collect();
        let job = self.compose_job(Composition::Assemble { prefix, shortest_s });
        match search.ask_one(&job)?.result {
            Ok(Answer::Plan { plan, makespan_s }) => Ok((plan, makespan_s)),
            Ok(_) => Err(misfit(StageKind::Composite).into()),
            Err(report) => Err(Stuck::Failed(Conflict::of(self.all_pairs(), &report.causes, Some(search.id(&job))))),
        }
    }

    fn all_pairs(&self) -> BTreeSet<Choice> {
        (0..self.problem.pairs.len()).map(|pair| Choice::Alternative(PairId::at(pair))).collect()
    }

    /// Commits the mode whose event comes earliest, again and again, until all are committed or none can be.
    fn commit_modes(&self, search: &mut Search<'_>, modes: &Modes) -> Result<Committed, Halt> {
        let mut next = vec![0_usize; modes.len()];
        let mut prefixes: Vec<ProductRef> = Vec::new();
        loop {
            let prefix = prefixes.last().copied();
            let ready = self.ready_modes(&next);
            let left = self.skeleton.modes.iter().zip(&next).any(|(modes, next)| *next < modes.len());
            if let (false, Some(prefix)) = (left, prefix) {
                return Ok(Committed::All(prefix));
            }
            let jobs: Vec<Job> = ready.iter().map(|mode| self.commit_job(modes, prefix, mode.id)).collect();
            let mut best: Option<Ready> = None;
            let mut conflict = Conflict::default();
            for ((mode, job), outcome) in ready.iter().zip(&jobs).zip(search.ask(&jobs)?) {
                match outcome.result {
                    Ok(Answer::Committed { prefix, event_s, .. }) => {
                        if best.as_ref().is_none_or(|best| event_s < best.event_s) {
                            best = Some(Ready { mode: mode.id, prefix, event_s });
                        }
                    }
                    Ok(_) => return Err(misfit(StageKind::Composite).into()),
                    Err(report) => {
                        let own = mode.pair.or(mode.begins.map(|event| event.pair));
                        let pairs = own.into_iter().chain(self.pairs_at_fault(&report.causes, &next));
                        let choices = pairs.map(Choice::Alternative);
                        conflict.merge(Conflict::of(choices, &report.causes, Some(search.id(job))));
                    }
                }
            }
            let Some(best) = best else { return Ok(Committed::Part(prefixes, conflict)) };
            search.commit(LedgerEntry::Decided(Decision::Commit(best.mode)));
            next[best.mode.robot.index()] += 1;
            prefixes.push(best.prefix);
        }
    }

    /// Pairs that the robots named in causes are at.
    fn pairs_at_fault(&self, causes: &[(Cause, u64)], next: &[usize]) -> Vec<PairId> {
        let named = |name: &String| {
            causes.iter().any(|(cause, _)| matches!(cause, Cause::Deadlock { robots } if robots.contains(name)))
        };
        let at = |(robot, modes): (usize, &Vec<Mode>)| {
            let mode = modes.get(next[robot]).or(modes.last())?;
            mode.pair.or(mode.begins.map(|event| event.pair))
        };
        let robots = self.skeleton.modes.iter().enumerate();
        robots.filter(|(robot, _)| named(&self.problem.robots[*robot].name)).filter_map(at).collect()
    }

    /// Each robot's next mode, if every event that must come before its own is committed.
    fn ready_modes(&self, next: &[usize]) -> Vec<Mode> {
        let done = |event: &Event| {
            let robot = self.problem.pair(event.pair).robot.index();
            self.skeleton.modes[robot][..next[robot]].iter().any(|mode| mode.ends == Some(*event))
        };
        let is_ready = |mode: &Mode| {
            let Some(own) = mode.ends else { return true };
            let others = self.skeleton.modes.iter().flatten().filter_map(|mode| mode.ends);
            others.filter(|event| self.skeleton.graph.precedes(*event, own)).all(|event| done(&event))
        };
        self.skeleton
            .modes
            .iter()
            .zip(next)
            .filter_map(|(modes, next)| modes.get(*next))
            .filter(|mode| is_ready(mode))
            .copied()
            .collect()
    }

    fn commit_job(&self, modes: &Modes, prefix: Option<ProductRef>, mode: ModeId) -> Job {
        let of_robot = &modes[mode.robot.index()];
        let step = mode.step as usize;
        self.compose_job(Composition::CommitMode {
            prefix,
            mode,
            roadmap: of_robot[step].roadmap,
            next_roadmap: of_robot.get(step + 1).map(|next| next.roadmap),
        })
    }

    /// The composite search where commitment came to a dead end: from half way, then from the beginning.
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
        if let Some(half_way) = prefixes.get(prefixes.len() / 2) {
            match self.drrt(search, modes, Some(*half_way), between.clone()) {
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
        let roadmaps = modes.iter().map(|robot| robot.iter().map(|mode| mode.roadmap).collect()).collect();
        let job = self.compose_job(Composition::Drrt { prefix, roadmaps });
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

    fn compose_job(&self, composition: Composition) -> Job {
        self.budgets.job(Request::Compose(ComposeJob { assignment: self.assignment(), composition }))
    }
}

/// How far mode by mode commitment came.
enum Committed {
    /// All modes.
    All(ProductRef),
    /// The prefixes so far, shortest first, and why no mode could be committed after the last.
    Part(Vec<ProductRef>, Conflict),
}
