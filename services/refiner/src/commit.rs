//! Mode by mode commitment. Where it comes to a dead end, those who are in the way of a stuck mode learn to give way to
//! it, what they have done since is ripped up, and the modes are committed anew. Where nobody learns anything new, a dead end
//! is repaired (`repair`), and commitment goes on from there. A complete round may be followed by others (`urgency`).

use std::collections::{BTreeMap, BTreeSet};

use contract::{Answer, Composition, Decision, Job, LedgerEntry, ProductRef, StageKind};
use model::{FailurePolicy, PairId, RobotId};
use plan::{BodyRef, Cause};
use skeleton::{Event, Mode, ModeId};

use crate::asking::misfit;
use crate::candidate::{Candidate, Modes};
use crate::conflict::{Choice, Conflict, Halt};
use crate::give_way::GiveWay;
use crate::search::Search;

/// How often modes are committed anew before the composite search takes over.
const ROUNDS: usize = 8;

/// How far mode by mode commitment came.
pub(crate) enum Committed {
    /// All modes, in one order or several.
    All(Vec<ProductRef>),
    /// The prefixes of the round that came furthest, shortest first, and what the dead ends depend on.
    Part(Vec<ProductRef>, BTreeSet<Choice>),
    /// Robots that never move leave no way to one mode.
    Never(Conflict),
}

/// Whether robots that never move leave no way.
fn is_for_ever(causes: &[(Cause, u64)]) -> bool {
    let stands = |body: &BodyRef| matches!(body, BodyRef::Link { .. });
    let all = |cause: &Cause| {
        let Cause::NoPath { blocking, .. } = cause else { return false };
        !blocking.is_empty() && blocking.iter().all(stands)
    };
    !causes.is_empty() && causes.iter().all(|(cause, _)| all(cause))
}

/// A mode that was ready and could not be committed.
#[derive(Clone)]
pub(crate) struct Stranded {
    pub(crate) mode: ModeId,
    /// Robots in its way.
    pub(crate) by: Vec<RobotId>,
    /// Modes that have put objects in its way.
    releases: Vec<ModeId>,
    conflict: Conflict,
    /// Whether nobody in its way will ever move.
    for_ever: bool,
}

/// How rounds ended.
enum Rounds {
    /// With all modes.
    Complete(Round),
    /// Robots that never move leave no way to one mode.
    Never(Conflict),
    /// The round that came furthest, and the last one.
    DeadEnd(Vec<Round>),
}

/// One round of commitments.
#[derive(Clone, Default)]
pub(crate) struct Round {
    /// Each robot's next mode.
    pub(crate) next: Vec<usize>,
    pub(crate) prefixes: Vec<ProductRef>,
    /// Events of each robot's modes (s).
    events_s: Vec<Vec<f64>>,
    /// Each robot's next mode before each of the prefixes.
    pub(crate) before: Vec<Vec<usize>>,
    /// For modes that cannot be committed, how many prefixes there were when that began.
    pub(crate) stuck_since: BTreeMap<ModeId, usize>,
    /// At its dead end; empty if there is none.
    pub(crate) stranded: Vec<Stranded>,
    /// At a dead end where all that could be committed is held back: these modes, each for a robot.
    pub(crate) held_back: Vec<(ModeId, RobotId)>,
}

impl Round {
    pub(crate) fn new(modes: &Modes) -> Self {
        Self { next: vec![0; modes.len()], events_s: vec![Vec::new(); modes.len()], ..Self::default() }
    }

    pub(crate) fn push(&mut self, mode: ModeId, prefix: ProductRef, event_s: f64) {
        self.push_all(&[(mode, event_s)], prefix);
    }

    /// Several modes with their events, in one prefix.
    pub(crate) fn push_all(&mut self, modes: &[(ModeId, f64)], prefix: ProductRef) {
        self.before.push(self.next.clone());
        for (mode, event_s) in modes {
            self.next[mode.robot.index()] += 1;
            self.events_s[mode.robot.index()].push(*event_s);
        }
        self.prefixes.push(prefix);
    }

    /// The round as it was when there were so many prefixes.
    pub(crate) fn cut(&self, prefixes: usize) -> Self {
        let mut cut =
            Self { stranded: Vec::new(), held_back: Vec::new(), stuck_since: BTreeMap::new(), ..self.clone() };
        if let Some(next) = self.before.get(prefixes) {
            cut.next.clone_from(next);
            cut.events_s.iter_mut().zip(next).for_each(|(events_s, next)| events_s.truncate(*next));
            cut.prefixes.truncate(prefixes);
            cut.before.truncate(prefixes);
        }
        cut
    }

    /// When a committed mode's event is (s).
    pub(crate) fn event_s(&self, mode: ModeId) -> f64 {
        self.events_s[mode.robot.index()].get(mode.step as usize).copied().unwrap_or(0.0)
    }

    /// When a mode begins (s), if the one before it is committed.
    pub(crate) fn begin_s(&self, mode: ModeId) -> f64 {
        mode.step.checked_sub(1).map_or(0.0, |step| self.event_s(ModeId { step, ..mode }))
    }
}

impl Candidate<'_> {
    /// Commits modes, in rounds: at a dead end there is another, if somebody can give way who has not. Else the dead end of
    /// the round that came furthest is repaired, and rounds begin behind that.
    pub(crate) fn commit_modes(&self, search: &mut Search<'_>, modes: &Modes) -> Result<Committed, Halt> {
        let mut base = Round::new(modes);
        let mut give_way = GiveWay::default();
        let mut conflict = Conflict::default();
        loop {
            let dead_ends = match self.give_way_behind(search, modes, &base, &mut give_way, &mut conflict)? {
                Rounds::Complete(round) => {
                    return Ok(Committed::All(self.in_other_orders(search, modes, &give_way, round)?));
                }
                Rounds::Never(conflict) => return Ok(Committed::Never(conflict)),
                Rounds::DeadEnd(rounds) => rounds,
            };
            // Who has to stop at a failure hears it from the composite search.
            if base.prefixes.is_empty()
                && search.policy(StageKind::Composite) != FailurePolicy::Stop
                && let Some(conflict) = self.no_passage(search, modes)?
            {
                return Ok(Committed::Never(conflict));
            }
            let Some(repaired) = self.repair_one(search, modes, &base, &dead_ends)? else {
                let furthest = dead_ends.into_iter().map(|round| round.prefixes).next();
                return Ok(Committed::Part(furthest.unwrap_or_default(), conflict.choices));
            };
            base = repaired;
        }
    }

    /// Rounds from a base on, until nobody learns anything new.
    fn give_way_behind(
        &self,
        search: &mut Search<'_>,
        modes: &Modes,
        base: &Round,
        give_way: &mut GiveWay,
        conflict: &mut Conflict,
    ) -> Result<Rounds, Halt> {
        let mut furthest: Option<Round> = None;
        let mut last: Option<Round> = None;
        for _ in 0..ROUNDS {
            let round = self.round(search, modes, give_way, base.clone())?;
            if self.is_complete(&round) {
                return Ok(Rounds::Complete(round));
            }
            let mut learnt = false;
            for Stranded { mode, by, releases, conflict: because, for_ever } in &round.stranded {
                // Who has to stop at a failure hears it from the composite search.
                if *for_ever && search.policy(StageKind::Composite) != FailurePolicy::Stop {
                    return Ok(Rounds::Never(self.alone(*mode, because.clone())));
                }
                learnt |= give_way.learn(*mode, by);
                learnt |= give_way.learn_releases(*mode, releases);
                search.backtrack(StageKind::Composite, Decision::Commit(*mode), because.first_cause());
                conflict.merge(because.clone());
            }
            if furthest.as_ref().is_none_or(|known| round.prefixes.len() > known.prefixes.len()) {
                furthest = Some(round.clone());
            }
            last = Some(round);
            if !learnt {
                break;
            }
        }
        // In the last round everybody knows whom to give way to, which may keep it from coming far.
        let mut dead_ends: Vec<Round> = furthest.into_iter().chain(last).collect();
        dead_ends.dedup_by(|a, b| a.prefixes == b.prefixes);
        Ok(Rounds::DeadEnd(dead_ends))
    }

    pub(crate) fn is_complete(&self, round: &Round) -> bool {
        self.skeleton.modes.iter().zip(&round.next).all(|(modes, next)| *next == modes.len())
    }

    /// Goes on with a round: commits the mode whose event comes earliest, again and again, until all are committed or none
    /// can be. A mode that others give way to comes first.
    fn round(
        &self,
        search: &mut Search<'_>,
        modes: &Modes,
        give_way: &GiveWay,
        mut round: Round,
    ) -> Result<Round, Halt> {
        while !self.is_complete(&round) {
            let ready = self.ready_modes(&round.next, give_way);
            let job = |mode: &Mode| self.commit_job(modes, &round, give_way, mode.id);
            let jobs: Vec<Job> = ready.iter().map(job).collect();
            let mut best: Option<((bool, f64), ModeId, ProductRef)> = None;
            for ((mode, job), outcome) in ready.iter().zip(&jobs).zip(search.ask(&jobs)?) {
                match outcome.result {
                    Ok(Answer::Committed { prefix, event_s, .. }) => {
                        round.stuck_since.remove(&mode.id);
                        let rank = (!give_way.is_given(mode.id), event_s);
                        if best.is_none_or(|(least, ..)| rank < least) {
                            best = Some((rank, mode.id, prefix));
                        }
                    }
                    Ok(_) => return Err(misfit(StageKind::Composite).into()),
                    Err(report) => {
                        let by = self.robots_at_fault(&report.causes, mode.id.robot);
                        let releases = self.releases_at_fault(&report.causes, mode, &round.next);
                        let put = releases.iter().filter_map(|mode| self.skeleton.mode(*mode).pair);
                        let pairs = by.iter().filter_map(|robot| self.pair_at(*robot, &round.next)).chain(put);
                        let pairs = pairs.chain(self.pair_at(mode.id.robot, &round.next)).map(Choice::Alternative);
                        let conflict = Conflict::of(pairs, &report.causes, Some(search.id(job)));
                        let for_ever = is_for_ever(&report.causes);
                        round.stuck_since.entry(mode.id).or_insert(round.prefixes.len());
                        round.stranded.push(Stranded { mode: mode.id, by, releases, conflict, for_ever });
                    }
                }
            }
            let Some(((_, event_s), mode, prefix)) = best.filter(|_| !round.stranded.iter().any(|one| one.for_ever))
            else {
                if ready.is_empty() {
                    round.held_back = self.held_back(&round.next, give_way);
                }
                return Ok(round);
            };
            search.commit(LedgerEntry::Decided(Decision::Commit(mode)));
            round.push(mode, prefix, event_s);
            round.stranded.clear();
        }
        Ok(round)
    }

    /// The conflict of a mode that no other robot's choices can help: the pairs at its ends, and what stands about.
    fn alone(&self, mode: ModeId, mut conflict: Conflict) -> Conflict {
        let mode = self.skeleton.mode(mode);
        let pairs = mode.pair.into_iter().chain(mode.begins.map(|event| event.pair)).map(Choice::Alternative);
        conflict.choices = pairs.chain(self.skeleton.occupancies().map(Choice::Pose)).collect();
        conflict
    }

    /// Robots but `own` that the causes name and that have something to do.
    pub(crate) fn robots_at_fault(&self, causes: &[(Cause, u64)], own: RobotId) -> Vec<RobotId> {
        let named = |robot: &RobotId| {
            let name = &self.problem.robot(*robot).name;
            causes.iter().any(|(cause, _)| matches!(cause, Cause::Deadlock { robots } if robots.contains(name)))
        };
        let moves = |robot: &RobotId| !self.skeleton.modes[robot.index()].is_empty();
        self.problem.robot_ids().filter(|robot| *robot != own && moves(robot) && named(robot)).collect()
    }

    /// The committed modes that put the objects where the causes name them, so far as they need not come before the mode.
    fn releases_at_fault(&self, causes: &[(Cause, u64)], stuck: &Mode, next: &[usize]) -> Vec<ModeId> {
        let bodies = causes.iter().flat_map(|(cause, _)| match cause {
            Cause::NoPath { blocking, .. } => blocking.as_slice(),
            _ => &[],
        });
        let named = |body: &BodyRef, name: &String| matches!(body, BodyRef::Object(object) if object == name);
        let objects: Vec<usize> = bodies
            .filter_map(|body| self.problem.movable.iter().position(|object| named(body, &object.name)))
            .collect();
        let is_free = |mode: &Mode| {
            let comes_first = |event: Event| {
                let precedes = |later: Option<Event>| later.is_some_and(|l| self.skeleton.graph.precedes(event, l));
                precedes(stuck.ends) || precedes(stuck.begins)
            };
            mode.id.robot != stuck.id.robot && mode.ends.is_some_and(|event| !comes_first(event))
        };
        let release_of = |object: &usize| {
            let modes = self.skeleton.modes.iter().zip(next).flat_map(|(modes, next)| &modes[..*next]);
            let puts = |mode: &&Mode| {
                mode.is_holding() && mode.pair.map(|pair| self.problem.pair(pair).object.index()) == Some(*object)
            };
            let last = modes.filter(puts).max_by_key(|mode| mode.pair.map(|pair| self.problem.pair(pair).hop))?;
            is_free(last).then_some(last.id)
        };
        objects.iter().filter_map(release_of).collect()
    }

    /// The pair that a robot is at.
    fn pair_at(&self, robot: RobotId, next: &[usize]) -> Option<PairId> {
        let modes = &self.skeleton.modes[robot.index()];
        let mode = modes.get(next[robot.index()]).or(modes.last())?;
        mode.pair.or(mode.begins.map(|event| event.pair))
    }

    /// Each robot's next mode, if every event that must come before its own is committed, and nobody is given way to.
    pub(crate) fn ready_modes(&self, next: &[usize], give_way: &GiveWay) -> Vec<Mode> {
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
            .filter(|mode| is_ready(mode) && !give_way.holds_back(mode, next))
            .copied()
            .collect()
    }

    /// Modes that would be ready but for somebody whom they give way to.
    fn held_back(&self, next: &[usize], give_way: &GiveWay) -> Vec<(ModeId, RobotId)> {
        let ready = self.ready_modes(next, &GiveWay::default());
        let for_another = |mode: &Mode| Some((mode.id, give_way.before(mode.id, next)?.robot));
        ready.iter().filter_map(for_another).collect()
    }

    pub(crate) fn commit_job(&self, modes: &Modes, round: &Round, give_way: &GiveWay, mode: ModeId) -> Job {
        let of_robot = &modes[mode.robot.index()];
        let step = mode.step as usize;
        let clear_of = give_way.ways_before(mode.robot, &round.next);
        self.compose_job(Composition::CommitMode {
            prefix: round.prefixes.last().copied(),
            mode,
            roadmap: of_robot[step].roadmap,
            next_roadmap: of_robot.get(step + 1).map(|next| next.roadmap),
            // Where the mode ends, the next one begins.
            clear_of: clear_of
                .flat_map(|mode| modes[mode.robot.index()].iter().skip(mode.step as usize).take(2))
                .map(|answer| answer.roadmap)
                .collect(),
        })
    }
}
