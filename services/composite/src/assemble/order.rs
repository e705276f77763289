//! Which cell must be over before which other may begin.
//!
//! An arc `a → b` between cells of two robots says: b may begin only once a is over. In the plan: the robot of b may leave
//! the knot at which b begins only once the robot of a has reached the knot at which a ends.
//!
//! **The arcs keep every delayed execution safe.** Let the committed schedule be free of conflicts: no two cells, moving
//! or standing, that conflict overlap in time for longer than an instant. For every two cells of two robots that conflict
//! there is an arc, or a chain of arcs and cells, in the direction in which the schedule passes them. Take an execution
//! that keeps the arcs, however late, and suppose that at some time two robots A and B touch, A at configuration p and B
//! at q. Cells are closed, and the relation proves cells clear that do not conflict; so every cell that contains p
//! conflicts with every cell that contains q.
//!
//! * p inside of a cell a, q inside of a cell b. One is before the other, say a. B has left the beginning of b, so A has
//!   reached the end of a: not p.
//! * p at the knot between a and a', q inside of b. If a' were before b, A would have reached the end of a'. If b were
//!   before a, B would have reached the end of b. So the schedule passes a, then b, then a': there A stands at p while B
//!   goes through b, and since the schedule is free of conflicts standing at p does not conflict with b: they do not touch.
//! * p between a and a', q between b and b'. As before neither a' is before b nor b' before a, so the schedule passes
//!   both a and b before both a' and b'. As a and b conflict one of them, say a, is over before the other begins; then in
//!   the schedule A stands at p throughout b, and does not touch it, nor q, which belongs to b.
//!
//! Before its first and after its last cell a robot stands likewise. An object at one of its poses counts with the cells
//! that end with its release and its grasp: whatever would touch it is over before the release's cell begins, or begins
//! when the grasp's cell is over. (Mostly that follows from the hand and the object in it, which are there at the end of
//! those cells; but the assigned pose and the hand's may differ by a rounding.) At the knot of a grasp or release the
//! robot is in the state after it, so p belongs to the cell after it; the argument is the same. ∎
//!
//! Arcs that follow from others are left out, by vector clocks (Fidge 1988; Mattern 1989): cells are taken in the order
//! of the schedule, and each carries how many cells of every robot are known to be over when it begins.

use model::Standing;
use skeleton::Event;

use crate::Conflicts;

use super::cells::{Cell, RobotCells};

/// Times (s) up to this apart count as equal.
const EQUAL_S: f64 = 1e-9;

/// `before` must be over when `after` begins; each is robot and number of the cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct CellArc {
    pub before: (usize, usize),
    pub after: (usize, usize),
}

/// What orders cells beside their motions.
pub(crate) struct Reasons<'a> {
    pub conflicts: &'a Conflicts,
    /// The standing pose that a grasp ends, or a release begins.
    pub pose_of: &'a dyn Fn(Event) -> Option<Standing>,
    /// Orderings of events, as arcs between the cells that end with them, and barriers between rounds; sorted.
    pub events: Vec<CellArc>,
}

impl Reasons<'_> {
    /// Whether the earlier of two cells of two robots must be over before the later begins.
    fn binds(&self, (a, earlier): ((usize, usize), &Cell), (b, later): ((usize, usize), &Cell)) -> bool {
        self.conflicts.cells_conflict(&earlier.travel, earlier.cell, &later.travel, later.cell)
            || self.touches(earlier, later, model::Point::Grasp)
            || self.touches(later, earlier, model::Point::Release)
            || self.events.binary_search(&CellArc { before: a, after: b }).is_ok()
    }

    /// Whether `other` hits the pose that `cell` ends with.
    fn touches(&self, cell: &Cell, other: &Cell, point: model::Point) -> bool {
        let event = cell.event.filter(|event| event.point == point);
        let pose = event.and_then(|event| (self.pose_of)(event));
        pose.is_some_and(|pose| self.conflicts.cell_hits(&other.travel, other.cell, &pose))
    }
}

/// All cells in the order in which the schedule begins them: robot and number.
pub(crate) fn in_schedule(robots: &[RobotCells]) -> Vec<(usize, usize)> {
    let mut all: Vec<(usize, usize)> =
        robots.iter().enumerate().flat_map(|(r, robot)| (0..robot.cells.len()).map(move |c| (r, c))).collect();
    let begins_s = |(r, c): (usize, usize)| robots[r].cells[c].begins_s;
    all.sort_by(|a, b| begins_s(*a).total_cmp(&begins_s(*b)).then(a.cmp(b)));
    all
}

/// The arcs that are needed, none of which follows from others.
pub(crate) fn arcs(robots: &[RobotCells], reasons: &Reasons<'_>) -> Vec<CellArc> {
    let mut arcs = Vec::new();
    // How many cells of every robot are known to be over when a cell begins.
    let mut over: Vec<Vec<Vec<usize>>> = robots.iter().map(|robot| Vec::with_capacity(robot.cells.len())).collect();
    for (r, c) in in_schedule(robots) {
        let mut clock = over[r].last().cloned().unwrap_or_else(|| vec![0; robots.len()]);
        clock[r] = c;
        let later = &robots[r].cells[c];
        let mut found: Vec<(usize, usize)> = Vec::new();
        for (s, other) in robots.iter().enumerate().filter(|(s, _)| *s != r) {
            let past = other.cells.partition_point(|cell| cell.ends_s <= later.begins_s + EQUAL_S).min(over[s].len());
            let latest = (clock[s]..past).rev().find(|d| reasons.binds(((s, *d), &other.cells[*d]), ((r, c), later)));
            found.extend(latest.map(|d| (s, d)));
        }
        let known = |(s, d): (usize, usize), robot: usize| if robot == s { d + 1 } else { over[s][d][robot] };
        for &(s, d) in &found {
            let follows = found.iter().any(|other| other.0 != s && known(*other, s) > d);
            if !follows {
                arcs.push(CellArc { before: (s, d), after: (r, c) });
            }
        }
        for &before in &found {
            for (robot, count) in clock.iter_mut().enumerate() {
                *count = (*count).max(known(before, robot));
            }
        }
        over[r].push(clock);
    }
    arcs.sort_unstable();
    arcs
}

/// Earliest times under the arcs: for every cell when it begins and when it is over (s).
pub(crate) fn earliest(robots: &[RobotCells], arcs: &[CellArc]) -> Vec<Vec<(f64, f64)>> {
    let mut by_after: Vec<CellArc> = arcs.to_vec();
    by_after.sort_unstable_by_key(|arc| (arc.after, arc.before));
    let mut times: Vec<Vec<(f64, f64)>> = robots.iter().map(|robot| Vec::with_capacity(robot.cells.len())).collect();
    for (r, c) in in_schedule(robots) {
        let mut begins_s = times[r].last().map_or(0.0, |(_, ends_s)| *ends_s);
        let first = by_after.partition_point(|arc| arc.after < (r, c));
        for arc in by_after[first..].iter().take_while(|arc| arc.after == (r, c)) {
            let (s, d) = arc.before;
            begins_s = begins_s.max(times[s].get(d).map_or(0.0, |(_, ends_s)| *ends_s));
        }
        times[r].push((begins_s, begins_s + robots[r].cells[c].duration_s));
    }
    times
}
