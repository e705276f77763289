//! What a blocked grasp says of samples that were not tried: if an object leaves the hand alone no grasp, it does so however
//! the pair is done otherwise, and so do others of its samples (nogoods over sets of values).

use std::collections::{BTreeMap, BTreeSet};

use contract::{Answer, GraspBlockersJob, Job, JobId, Literal, Request, StageKind};
use model::{PairId, Pose, Standing};
use plan::{Cause, PairEnd};
use skeleton::{Event, EventGraph, Mode, Occupancy, Presence};

use crate::around::instant;
use crate::asking::misfit;
use crate::candidate::Candidate;
use crate::conflict::{Choice, Conflict, Order, Stuck};
use crate::known::NoWay;
use crate::search::Search;
use crate::ways::Scene;

/// Most combinations of samples of which it is asked whether they leave a grasp; if there are more, only those with the
/// present sample of the pair's own object.
const MOST_COMBINATIONS: usize = 1 << 13;

/// Samples that cannot all be.
#[derive(Clone, Debug)]
pub(crate) struct Lesson {
    pub(crate) literals: Vec<Literal>,
    pub(crate) cause: Cause,
    pub(crate) proof: JobId,
}

/// One end of a pair, and an object that stands somewhere while the robot is at it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Meeting {
    pair: PairId,
    end: PairEnd,
    other: Occupancy,
}

/// For each sample of the pair's own object, those of the other one that leave no grasp.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    blocked: BTreeMap<u32, BTreeSet<u32>>,
    told_by: Option<JobId>,
}

impl Table {
    fn blocks(&self, own: u32, other: u32) -> bool {
        self.blocked.get(&own).is_some_and(|others| others.contains(&other))
    }
}

impl Candidate<'_> {
    /// The conflict of a pair without alternatives, resting on fewer choices if the hand alone shows it. What that shows of
    /// other samples is noted as lessons.
    pub(crate) fn generalise(
        &self,
        search: &mut Search<'_>,
        scene: &Scene,
        pair: PairId,
        conflict: Conflict,
    ) -> Result<Conflict, Stuck> {
        for (number, end) in [PairEnd::Pick, PairEnd::Place].into_iter().enumerate() {
            let Some(mode) = self.mode_to(pair, end) else { continue };
            let at_event = &scene.events[pair.index()][number].certain;
            for other in at_event.union(&scene.about(&mode).certain).copied() {
                let meeting = Meeting { pair, end, other };
                let is_own = other.object == self.problem.pair(pair).object;
                if is_own || !conflict.choices.contains(&Choice::Pose(other)) || !self.is_blocked(search, meeting)? {
                    continue;
                }
                let mut by_hand = if at_event.contains(&other) {
                    let mut why = Conflict::of([Choice::Pose(other)], &[], None);
                    why.orders = self.orders_keeping(other, instant(self.event(meeting)));
                    why
                } else {
                    self.why_certain(&mode, other)
                };
                by_hand.choices.insert(Choice::Pose(self.own(meeting)));
                by_hand.causes.count(self.blocked_by(pair, other));
                by_hand.proof = search.tables.get(&meeting).and_then(|table| table.told_by);
                self.teach(search, meeting)?;
                return Ok(by_hand);
            }
        }
        Ok(conflict)
    }

    /// A pose that is from now on to be reckoned with in a mode: if it leaves the hand no grasp at the mode's end, no
    /// alternative of the pair need be looked at.
    pub(crate) fn close_if_blocked(
        &mut self,
        search: &mut Search<'_>,
        mode: &Mode,
        other: Occupancy,
    ) -> Result<(), Stuck> {
        let Some(pair) = mode.pair else { return Ok(()) };
        let end = if mode.is_holding() { PairEnd::Place } else { PairEnd::Pick };
        let meeting = Meeting { pair, end, other };
        let tells_causes = search.policy(StageKind::Roadmap).tells_causes();
        if !tells_causes || other.object == self.problem.pair(pair).object || !self.is_blocked(search, meeting)? {
            return Ok(());
        }
        let Conflict { causes, .. } = Conflict::of([], &[(self.blocked_by(pair, other), 1)], None);
        let proof = search.tables.get(&meeting).and_then(|table| table.told_by);
        let choices = [Choice::Pose(self.own(meeting))].into();
        let (certain, orders) = ([other].into(), BTreeSet::new());
        self.known_mut(mode).no_ways.push(NoWay { ends: [None, None], certain, choices, orders, causes, proof });
        Ok(())
    }

    /// Whether the present samples leave the hand no grasp.
    fn is_blocked(&self, search: &mut Search<'_>, meeting: Meeting) -> Result<bool, Stuck> {
        let own = self.sample(self.own(meeting));
        let table = self.table(search, meeting)?;
        Ok(table.blocks(own, self.sample(meeting.other)))
    }

    /// Which samples leave the hand no grasp; asked for once.
    fn table(&self, search: &mut Search<'_>, meeting: Meeting) -> Result<Table, Stuck> {
        let own = self.own(meeting);
        let mine = self.samples_of(search, own)?;
        let others = self.samples_of(search, meeting.other)?;
        let row_by_row = mine.len() * others.len() > MOST_COMBINATIONS;
        let known = search.tables.get(&meeting);
        if let Some(table) = known.filter(|table| !row_by_row || table.blocked.contains_key(&self.sample(own))) {
            return Ok(table.clone());
        }
        let wanted = |(sample, _): &&(u32, Pose)| !row_by_row || *sample == self.sample(own);
        let rows: Vec<(u32, Job)> =
            mine.iter().filter(wanted).map(|(sample, pose)| (*sample, self.row(meeting, *pose, &others))).collect();
        let jobs: Vec<Job> = rows.iter().map(|(_, job)| job.clone()).collect();
        let mut table = known.cloned().unwrap_or_default();
        for ((sample, job), outcome) in rows.into_iter().zip(search.ask(&jobs)?) {
            let Ok(Answer::Blocked(blocked)) = outcome.result else { return Err(misfit(StageKind::Transition).into()) };
            let blocking = others.iter().zip(blocked).filter(|(_, blocked)| *blocked).map(|((sample, _), _)| *sample);
            table.blocked.insert(sample, blocking.collect());
            table.told_by = Some(search.id(&job));
        }
        search.tables.insert(meeting, table.clone());
        Ok(table)
    }

    fn row(&self, meeting: Meeting, own: Pose, others: &[(u32, Pose)]) -> Job {
        let standing = |pose: Pose| Standing { object: meeting.other.object, world_from_object: pose };
        self.budgets.job(Request::GraspBlockers(GraspBlockersJob {
            pair: meeting.pair,
            end: meeting.end,
            world_from_object: own,
            level: self.level,
            standing: others.iter().map(|(_, pose)| standing(*pose)).collect(),
        }))
    }

    /// Notes what a table excludes whatever the orderings: samples that are together there in every execution; or that
    /// block one another, whichever comes first.
    fn teach(&self, search: &mut Search<'_>, meeting: Meeting) -> Result<(), Stuck> {
        if !search.taught.insert(meeting) {
            return Ok(());
        }
        let (own, table) = (self.own(meeting), self.table(search, meeting)?);
        let reverse = match self.conditions(meeting).as_deref() {
            Some([]) => None,
            Some([(before, after)]) => match self.reverse(meeting) {
                Some(reverse) if self.conditions(reverse).as_deref() == Some(&[(*after, *before)]) => {
                    Some(self.table(search, reverse)?)
                }
                _ => return Ok(()),
            },
            _ => return Ok(()),
        };
        let Some(proof) = table.told_by else { return Ok(()) };
        for (mine, others) in &table.blocked {
            for sample in
                others.iter().filter(|sample| reverse.as_ref().is_none_or(|table| table.blocks(**sample, *mine)))
            {
                let samples = [(own, *mine), (meeting.other, *sample)];
                let cause = self.blocked_by(meeting.pair, meeting.other);
                search.lessons.push(Lesson { literals: literals(samples), cause, proof });
            }
        }
        Ok(())
    }

    /// The orderings that a meeting needs beyond the given ones; `None`: given orderings exclude it.
    fn conditions(&self, meeting: Meeting) -> Option<Vec<Order>> {
        let given = EventGraph::of_problem(self.problem).ok()?;
        let (event, stay) = (self.event(meeting), self.skeleton.interval_of(meeting.other));
        if given.presence(stay, instant(event)) == Presence::Never {
            return None;
        }
        let comes = stay.from.map(|from| (from, event));
        let goes = stay.to.map(|to| (event, to));
        Some(comes.into_iter().chain(goes).filter(|(before, after)| !given.precedes_or_is(*before, *after)).collect())
    }

    /// The meeting of the same two objects the other way round, if both are placed then.
    fn reverse(&self, meeting: Meeting) -> Option<Meeting> {
        let pair = self.creator(meeting.other).filter(|_| meeting.end == PairEnd::Place)?;
        Some(Meeting { pair, end: PairEnd::Place, other: self.own(meeting) })
    }

    /// Where the pair's own object is.
    fn own(&self, meeting: Meeting) -> Occupancy {
        match meeting.end {
            PairEnd::Pick => self.skeleton.picked(self.problem, meeting.pair),
            PairEnd::Place => self.skeleton.placed(self.problem, meeting.pair),
        }
    }

    fn event(&self, meeting: Meeting) -> Event {
        match meeting.end {
            PairEnd::Pick => Event::grasp(meeting.pair),
            PairEnd::Place => Event::release(meeting.pair),
        }
    }

    /// The mode in which a robot comes to an end of a pair.
    fn mode_to(&self, pair: PairId, end: PairEnd) -> Option<Mode> {
        let modes = &self.skeleton.modes[self.problem.pair(pair).robot.index()];
        modes.iter().find(|mode| mode.pair == Some(pair) && mode.is_holding() == (end == PairEnd::Place)).copied()
    }

    /// Numbers and poses of the samples that a pose may be; a start pose is the only one.
    fn samples_of(&self, search: &mut Search<'_>, occupancy: Occupancy) -> Result<Vec<(u32, Pose)>, Stuck> {
        match self.creator(occupancy) {
            Some(creator) => Ok(search.samples_of(creator)?),
            None => Ok(vec![(0, self.pose(occupancy))]),
        }
    }

    /// The pair that makes an object stand there; none for a start pose.
    fn creator(&self, occupancy: Occupancy) -> Option<PairId> {
        let hop = (occupancy.hop as usize).checked_sub(1)?;
        self.skeleton.hops[occupancy.object.index()].get(hop).copied()
    }
}

/// Samples as literals. Start poses are nobody's choice.
fn literals(samples: [(Occupancy, u32); 2]) -> Vec<Literal> {
    let chosen = samples.into_iter().filter(|(occupancy, _)| occupancy.hop > 0);
    chosen.map(|(occupancy, sample)| Literal::Pose { occupancy, sample }).collect()
}
