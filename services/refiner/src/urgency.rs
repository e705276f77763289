//! Modes committed in another order. Whoever is committed first has the right of way, and the earliest event first gives it to
//! short ways at the expense of those that the end of the plan waits for.
//!
//! So where the last release could be much earlier, modes are committed anew, the most urgent first: that from whose beginning
//! the longest way leads to the last release. What a mode lost in one order makes it so much longer in the next (squeaky wheel
//! optimisation, Joslin and Clements, doi:10.1613/jair.561). Nothing of this is decided: of all prefixes the search keeps
//! the one with the shortest plan.

use contract::{Answer, ProductRef, StageKind};
use skeleton::{Event, Mode, ModeId};

use crate::asking::misfit;
use crate::candidate::{Candidate, Modes};
use crate::commit::Round;
use crate::conflict::Halt;
use crate::give_way::GiveWay;
use crate::known::ModeAnswer;
use crate::search::Search;

/// How many other orders are tried.
const ORDERS: usize = 3;
/// By how much the last release may be later than if nobody were in anybody's way (as a share), without another order being
/// tried.
const GOOD_ENOUGH: f64 = 0.02;

/// A time (s) for each robot's modes.
type Times = Vec<Vec<f64>>;

fn of(times: &Times, mode: ModeId) -> f64 {
    times[mode.robot.index()][mode.step as usize]
}

impl Candidate<'_> {
    /// The prefix of a complete round, and those of other orders.
    pub(crate) fn in_other_orders(
        &self,
        search: &mut Search<'_>,
        modes: &Modes,
        give_way: &GiveWay,
        first: Round,
    ) -> Result<Vec<ProductRef>, Halt> {
        let mut lengths_s = self.least_s(modes);
        let bound_s = self.last_release_bound_s(&lengths_s);
        let mut last_release_s = self.last_release_s(&first);
        let mut prefixes: Vec<ProductRef> = first.prefixes.last().copied().into_iter().collect();
        for _ in 0..ORDERS {
            if last_release_s <= bound_s * (1.0 + GOOD_ENOUGH) {
                break;
            }
            let Some(round) = self.by_urgency(search, modes, give_way, &lengths_s)? else { break };
            prefixes.extend(round.prefixes.last().filter(|prefix| !prefixes.contains(prefix)));
            last_release_s = last_release_s.min(self.last_release_s(&round));
            self.lengthen(&mut lengths_s, &round);
        }
        Ok(prefixes)
    }

    /// A round in which the most urgent of the modes that can be committed is the next. `None`: it comes to a dead end.
    fn by_urgency(
        &self,
        search: &mut Search<'_>,
        modes: &Modes,
        give_way: &GiveWay,
        lengths_s: &Times,
    ) -> Result<Option<Round>, Halt> {
        let left_s = self.left_s(lengths_s);
        let mut round = Round::new(modes);
        while !self.is_complete(&round) {
            let urgency_s = |mode: &Mode| round.begin_s(mode.id) + of(lengths_s, mode.id) + of(&left_s, mode.id);
            let mut ready: Vec<(bool, f64, ModeId)> = self
                .ready_modes(&round.next, give_way)
                .iter()
                .map(|mode| (!give_way.is_given(mode.id), urgency_s(mode), mode.id))
                .collect();
            ready.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)).then(a.2.cmp(&b.2)));
            if !self.commit_first(search, modes, give_way, &mut round, ready.into_iter().map(|(.., mode)| mode))? {
                return Ok(None);
            }
        }
        Ok(Some(round))
    }

    /// Commits the first mode that can be. False: there is none.
    fn commit_first(
        &self,
        search: &mut Search<'_>,
        modes: &Modes,
        give_way: &GiveWay,
        round: &mut Round,
        ready: impl Iterator<Item = ModeId>,
    ) -> Result<bool, Halt> {
        for mode in ready {
            let job = self.commit_job(modes, round, give_way, mode);
            match search.ask_one(&job)?.result {
                Ok(Answer::Committed { prefix, event_s, .. }) => {
                    round.push(mode, prefix, event_s);
                    return Ok(true);
                }
                Ok(_) => return Err(misfit(StageKind::Composite).into()),
                Err(_) => {}
            }
        }
        Ok(false)
    }

    /// Least times of all modes, with the hand's pause before them.
    fn least_s(&self, modes: &Modes) -> Times {
        let pause_s = |mode: &Mode| if mode.begins.is_some() { self.problem.settings.grip_time } else { 0.0 };
        let of_robot = |(modes, answers): (&Vec<Mode>, &Vec<ModeAnswer>)| {
            modes.iter().zip(answers).map(|(mode, answer)| pause_s(mode) + answer.shortest_s).collect()
        };
        self.skeleton.modes.iter().zip(modes).map(of_robot).collect()
    }

    /// Modes that end with an event, and their events.
    fn with_events(&self) -> impl DoubleEndedIterator<Item = (ModeId, Event)> + '_ {
        self.skeleton.modes.iter().flatten().filter_map(|mode| Some((mode.id, mode.ends?)))
    }

    /// For each mode with an event, the longest way from there to the last release, if modes take so long.
    fn left_s(&self, lengths_s: &Times) -> Times {
        let mut left_s: Times = lengths_s.iter().map(|of_robot| vec![0.0; of_robot.len()]).collect();
        // The order on events has no cycle, so that this settles.
        loop {
            let before = left_s.clone();
            for (mode, event) in self.with_events().rev() {
                let (robot, next) = (mode.robot.index(), mode.step as usize + 1);
                let goes_on = self.skeleton.modes[robot].get(next).is_some_and(|next| next.ends.is_some());
                let own_s = if goes_on { lengths_s[robot][next] + left_s[robot][next] } else { 0.0 };
                let after = self.with_events().filter(|(_, later)| self.skeleton.graph.precedes(event, *later));
                left_s[robot][next - 1] = after.map(|(mode, _)| of(&left_s, mode)).fold(own_s, f64::max);
            }
            if left_s == before {
                return left_s;
            }
        }
    }

    /// Before when the last release cannot be, if modes take so long (s).
    fn last_release_bound_s(&self, lengths_s: &Times) -> f64 {
        let left_s = self.left_s(lengths_s);
        let first = self.with_events().filter(|(mode, _)| mode.step == 0);
        first.map(|(mode, _)| of(lengths_s, mode) + of(&left_s, mode)).fold(0.0, f64::max)
    }

    fn last_release_s(&self, round: &Round) -> f64 {
        self.with_events().map(|(mode, _)| round.event_s(mode)).fold(0.0, f64::max)
    }

    /// Adds to the lengths of modes what they lost to others in a round, so far as the last release had to wait for it.
    fn lengthen(&self, lengths_s: &mut Times, round: &Round) {
        let (left_s, last_release_s) = (self.left_s(lengths_s), self.last_release_s(round));
        for (mode, event) in self.with_events() {
            let before = self.with_events().filter(|(_, earlier)| self.skeleton.graph.precedes(*earlier, event));
            let undisturbed_s = round.begin_s(mode) + of(lengths_s, mode);
            let undisturbed_s = before.map(|(mode, _)| round.event_s(mode)).fold(undisturbed_s, f64::max);
            let spare_s = (last_release_s - round.event_s(mode) - of(&left_s, mode)).max(0.0);
            let lost_s = round.event_s(mode) - undisturbed_s - spare_s;
            lengths_s[mode.robot.index()][mode.step as usize] += lost_s.max(0.0);
        }
    }
}
