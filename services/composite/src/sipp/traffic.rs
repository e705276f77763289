//! Who else is where when, as one moving robot sees it.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

use model::{ObjectId, RobotId, Standing};

use crate::conflict::apart;
use crate::{Conflicts, TimedMove, TimedStanding, Timeline, Travel};

/// Gap in time (s) that is asked for between two that may not be somewhere at once.
const GAP_S: f64 = 1e-9;
/// Gap in time (s) that is taken beyond it, so that a motion planned next to another is still free when the other's turn
/// comes, whatever the rounding.
const SPARE_GAP_S: f64 = 1e-9;

/// Somebody in the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Blocker {
    Robot(RobotId),
    Object(ObjectId),
}

impl Blocker {
    pub fn robot(&self) -> Option<RobotId> {
        if let Self::Robot(robot) = self { Some(*robot) } else { None }
    }

    pub fn object(&self) -> Option<ObjectId> {
        if let Self::Object(object) = self { Some(*object) } else { None }
    }
}

/// A time in which nobody is in the way (s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SafeInterval {
    pub from_s: f64,
    pub until_s: f64,
}

impl SafeInterval {
    pub fn contains(&self, time_s: f64) -> bool {
        self.from_s <= time_s && time_s <= self.until_s
    }

    /// When to come into the interval at the earliest.
    pub fn entrance_s(&self) -> f64 {
        self.from_s + SPARE_GAP_S
    }
}

/// What comes near one motion at some time.
#[derive(Clone, Debug, Default)]
pub(crate) struct Nearby {
    moves: Vec<Vec<TimedMove>>,
    standings: Vec<TimedStanding>,
}

/// All other robots and the standing objects, from a time on.
pub(crate) struct Traffic<'a> {
    conflicts: &'a Conflicts,
    others: Vec<&'a [TimedMove]>,
    standings: Vec<TimedStanding>,
    since_s: f64,
    /// How often each was in the way, and whether for ever.
    blame: RefCell<BTreeMap<(bool, Blocker), u64>>,
}

impl<'a> Traffic<'a> {
    pub fn new(conflicts: &'a Conflicts, timeline: &'a Timeline, robot: RobotId, since_s: f64) -> Self {
        let others = timeline.robots.iter().filter(|other| other.robot != robot);
        let others = others.map(|other| other.moves_after(since_s)).collect();
        let standings = timeline.standings.iter().map(|(_, standing)| *standing).collect();
        Self::among(conflicts, others, standings, since_s)
    }

    /// Others by their moves, each without gaps.
    pub fn among(
        conflicts: &'a Conflicts,
        others: Vec<&'a [TimedMove]>,
        standings: Vec<TimedStanding>,
        since_s: f64,
    ) -> Self {
        Self { conflicts, others, standings, since_s, blame: RefCell::default() }
    }

    /// The object is put somewhere.
    pub fn put(&mut self, standing: Standing, time_s: f64) {
        self.standings.push(TimedStanding { standing, from_s: time_s, until_s: f64::INFINITY });
    }

    /// Who may stand in the way of a motion for ever: every other robot where it comes to its last standing, and every
    /// object where nobody is committed to take it.
    pub fn for_ever(&self, travel: &Travel) -> BTreeSet<Blocker> {
        let rests = self.others.iter().filter_map(|moves| moves.last());
        let hit = |rest: &&TimedMove| {
            (0..travel.cells).any(|cell| self.conflicts.cells_conflict(travel, cell, &rest.travel, 0))
        };
        let robots = rests.filter(hit).map(|rest| Blocker::Robot(rest.travel.robot));
        let stands = |standing: &&TimedStanding| {
            standing.until_s == f64::INFINITY
                && (0..travel.cells).any(|cell| self.conflicts.cell_hits(travel, cell, &standing.standing))
        };
        let objects = self.standings.iter().filter(stands).map(|standing| Blocker::Object(standing.standing.object));
        robots.chain(objects).collect()
    }

    /// Those in the way, most often first; only those for ever if there are any.
    pub fn blamed(&self) -> Vec<Blocker> {
        let blame = self.blame.borrow();
        let of = |ever: bool| {
            let mut some: Vec<(u64, Blocker)> =
                blame.iter().filter(|((e, _), _)| *e == ever).map(|((_, who), times)| (*times, *who)).collect();
            some.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
            some.into_iter().map(|(_, who)| who).collect::<Vec<_>>()
        };
        let for_ever = of(true);
        if for_ever.is_empty() { of(false) } else { for_ever }
    }

    fn blame(&self, who: Blocker, until_s: f64) {
        *self.blame.borrow_mut().entry((until_s == f64::INFINITY, who)).or_insert(0) += 1;
    }

    /// When a robot may stand somewhere, in order of time.
    pub fn safe_intervals(&self, stand: &Travel) -> Vec<SafeInterval> {
        let mut unsafe_times: Vec<(f64, f64)> = Vec::new();
        for other in
            self.others.iter().flat_map(|moves| moves.iter()).filter(|m| !apart(&m.travel.bounds, &stand.bounds))
        {
            for cell in 0..other.travel.cells {
                let (from_s, to_s) = other.cell_times(cell);
                if to_s > self.since_s && self.conflicts.cells_conflict(stand, 0, &other.travel, cell) {
                    self.blame(Blocker::Robot(other.travel.robot), to_s);
                    unsafe_times.push((from_s, to_s));
                }
            }
        }
        for standing in self.standings.iter().filter(|standing| standing.until_s > self.since_s) {
            if self.conflicts.cell_hits(stand, 0, &standing.standing) {
                self.blame(Blocker::Object(standing.standing.object), standing.until_s);
                unsafe_times.push((standing.from_s, standing.until_s));
            }
        }
        unsafe_times.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let (mut safe, mut from_s) = (Vec::new(), self.since_s);
        for (begins_s, ends_s) in unsafe_times {
            if begins_s - GAP_S >= from_s {
                safe.push(SafeInterval { from_s, until_s: begins_s - GAP_S });
            }
            from_s = from_s.max(ends_s + GAP_S);
        }
        if from_s < f64::INFINITY {
            safe.push(SafeInterval { from_s, until_s: f64::INFINITY });
        }
        safe
    }

    /// Whatever comes near a motion.
    pub fn nearby(&self, travel: &Travel) -> Nearby {
        let near = |moves: &[TimedMove]| -> Vec<TimedMove> {
            moves.iter().filter(|other| !apart(&other.travel.bounds, &travel.bounds)).copied().collect()
        };
        let hit = |standing: &&TimedStanding| {
            standing.until_s > self.since_s
                && (0..travel.cells).any(|cell| self.conflicts.cell_hits(travel, cell, &standing.standing))
        };
        Nearby {
            moves: self.others.iter().map(|moves| near(moves)).filter(|moves| !moves.is_empty()).collect(),
            standings: self.standings.iter().filter(hit).copied().collect(),
        }
    }

    /// The earliest time in `[from_s, until_s]` at which a motion of `duration_s` may set out.
    pub fn earliest_departure(
        &self,
        travel: &Travel,
        nearby: &Nearby,
        duration_s: f64,
        (from_s, until_s): (f64, f64),
    ) -> Option<f64> {
        let mut departs_s = from_s;
        let mut free = 0;
        // Round and round the cells until all of them in turn are free at one time of departure.
        for cell in (0..travel.cells).cycle() {
            let offset = |i: u32| duration_s * (f64::from(i) / f64::from(travel.cells));
            while let Some(ends_s) = {
                let times = (departs_s + offset(cell), departs_s + offset(cell + 1));
                self.in_the_way(travel, cell, times, nearby)
            } {
                departs_s = ends_s + GAP_S + SPARE_GAP_S - offset(cell);
                free = 0;
                if departs_s > until_s || departs_s == f64::INFINITY {
                    return None;
                }
            }
            free += 1;
            if free == travel.cells {
                break;
            }
        }
        (departs_s <= until_s).then_some(departs_s)
    }

    /// Until when somebody is in the way of a cell that is travelled at these times (s).
    fn in_the_way(&self, travel: &Travel, cell: u32, (begins_s, ends_s): (f64, f64), nearby: &Nearby) -> Option<f64> {
        let (from_s, to_s) = (begins_s - GAP_S, ends_s + GAP_S);
        for moves in &nearby.moves {
            let first = moves.partition_point(|other| other.ends_s <= from_s);
            for other in moves[first..].iter().take_while(|other| other.begins_s < to_s) {
                for other_cell in other.cell_at(from_s)..other.travel.cells {
                    let (other_from_s, other_to_s) = other.cell_times(other_cell);
                    if other_from_s >= to_s {
                        break;
                    }
                    if other_to_s > from_s && self.conflicts.cells_conflict(travel, cell, &other.travel, other_cell) {
                        self.blame(Blocker::Robot(other.travel.robot), other_to_s);
                        return Some(other_to_s);
                    }
                }
            }
        }
        let standing = nearby.standings.iter().find(|standing| {
            standing.from_s < to_s
                && standing.until_s > from_s
                && self.conflicts.cell_hits(travel, cell, &standing.standing)
        })?;
        self.blame(Blocker::Object(standing.standing.object), standing.until_s);
        Some(standing.until_s)
    }

    /// When the last committed motion that an object standing somewhere would be in the way of is over, and whose it is.
    pub fn last_through(&self, standing: &Standing) -> Option<(f64, RobotId)> {
        let mut last: Option<(f64, RobotId)> = None;
        for other in self.others.iter().flat_map(|moves| moves.iter()) {
            for cell in 0..other.travel.cells {
                let (_, ends_s) = other.cell_times(cell);
                if last.is_none_or(|(so_far, _)| ends_s > so_far)
                    && self.conflicts.cell_hits(&other.travel, cell, standing)
                {
                    last = Some((ends_s, other.travel.robot));
                }
            }
        }
        last
    }
}
