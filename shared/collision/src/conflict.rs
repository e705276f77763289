//! Whether two robots could meet within parts of their motions.

use nalgebra::Vector3;

use crate::mover::Mover;
use crate::separation::{Need, Verdict, balls_clear, judge};
use crate::{Geometry, Sweep};

/// How often each of the two parts may be halved.
const HALVINGS: usize = 3;
/// Displacement bound (m), as a part of the clearance, below which halving is given up.
const FLOOR: f64 = 0.25;

/// Two bodies, one of each robot, that bounds have not yet proven clear of each other.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    a: u16,
    b: u16,
    hint: Vector3<f64>,
}

/// A part of a motion and its halves' halves, made when needed. Halves of entry i are entries 2i + 1 and 2i + 2.
struct Parts<'a> {
    geometry: &'a Geometry,
    mover: Mover<'a>,
    whole: &'a Sweep,
    finer: Vec<Option<Sweep>>,
}

impl<'a> Parts<'a> {
    fn new(geometry: &'a Geometry, whole: &'a Sweep) -> Self {
        Self { geometry, mover: geometry.mover(whole.robot, whole.holding), whole, finer: Vec::new() }
    }

    fn get(&self, i: usize) -> &Sweep {
        if i == 0 { self.whole } else { self.finer.get(i).and_then(Option::as_ref).unwrap_or(self.whole) }
    }

    /// Makes sure that both halves of entry `i` exist.
    fn halve(&mut self, i: usize) {
        if self.finer.is_empty() {
            self.finer.resize(2 << HALVINGS, None);
        }
        if self.finer[2 * i + 1].is_some() {
            return;
        }
        let part = self.get(i);
        let (from, to) = (part.from.clone(), part.to.clone());
        let middle: Vec<f64> = from.iter().zip(&to).map(|(a, b)| (a + b) / 2.0).collect();
        let (holding, allowed) = (part.holding, part.allowed);
        let half = |from, to| Some(self.geometry.sweep_between(&self.mover, holding, allowed, from, to));
        let (first, second) = (half(from, middle.clone()), half(middle, to));
        self.finer[2 * i + 1] = first;
        self.finer[2 * i + 2] = second;
    }
}

/// A search for a proof that two parts are clear of each other.
struct Meeting<'a> {
    clearance: f64,
    a: Parts<'a>,
    b: Parts<'a>,
    /// Candidates of the entries on the way down, the deepest last.
    pairs: Vec<Candidate>,
}

impl Geometry {
    /// Whether two robots could come nearer than the clearance when one is anywhere in one sweep and the other anywhere
    /// in the other. `false` is a proof; `true` means that they touch somewhere, or that a few halvings proved nothing.
    /// A robot always conflicts with itself.
    #[must_use]
    pub fn sweeps_conflict(&self, a: &Sweep, b: &Sweep) -> bool {
        if a.robot == b.robot || a.is_unbounded() || b.is_unbounded() {
            return true;
        }
        let (least, greatest) = b.bounds();
        if a.is_apart(&least.coords, &greatest.coords) {
            return false;
        }
        let (a, b) = (Parts::new(self, a), Parts::new(self, b));
        let mut meeting = Meeting { clearance: self.clearance(), a, b, pairs: Vec::new() };
        meeting.collect();
        let all = meeting.pairs.len();
        meeting.conflict((0, 0), (0, 0), (0, all))
    }
}

impl Meeting<'_> {
    /// Notes the pairs that the balls around the bodies do not prove clear.
    fn collect(&mut self) {
        let (first, second) = (self.a.whole, self.b.whole);
        for (i, body) in first.bodies.iter().enumerate() {
            let a = (self.a.mover.solid(i), &body.placed);
            for (j, other) in second.bodies.iter().enumerate() {
                let b = (self.b.mover.solid(j), &other.placed);
                let need = Need::moving(self.clearance, body.spread + other.spread, [first.drift, second.drift]);
                if !balls_clear(a, b, &need) {
                    let (a, b) = (u16::try_from(i).unwrap_or(0), u16::try_from(j).unwrap_or(0));
                    self.pairs.push(Candidate { a, b, hint: Vector3::zeros() });
                }
            }
        }
    }

    /// Judges entries `at`, halved `depth` times each, for the candidates `[first, last)`.
    fn conflict(&mut self, at: (usize, usize), depth: (usize, usize), (first, last): (usize, usize)) -> bool {
        let kept = self.pairs.len();
        let Some(widest) = self.examine(at, (first, last)) else {
            return true;
        };
        if self.pairs.len() == kept {
            return false;
        }
        let range = (kept, self.pairs.len());
        let (can_a, can_b) = (depth.0 < HALVINGS, depth.1 < HALVINGS);
        if !(can_a || can_b) || widest.0.max(widest.1) <= self.clearance * FLOOR {
            return true;
        }
        let conflict = if can_a && (widest.0 >= widest.1 || !can_b) {
            self.a.halve(at.0);
            let halves = [2 * at.0 + 1, 2 * at.0 + 2];
            halves.into_iter().any(|half| self.conflict((half, at.1), (depth.0 + 1, depth.1), range))
        } else {
            self.b.halve(at.1);
            let halves = [2 * at.1 + 1, 2 * at.1 + 2];
            halves.into_iter().any(|half| self.conflict((at.0, half), (depth.0, depth.1 + 1), range))
        };
        self.pairs.truncate(kept);
        conflict
    }

    /// Appends those candidates that remain; answers the greatest displacement bound among them of either robot.
    /// `None` when two bodies touch where they are.
    fn examine(&mut self, at: (usize, usize), (first, last): (usize, usize)) -> Option<(f64, f64)> {
        let (part, other) = (self.a.get(at.0), self.b.get(at.1));
        let drifts = [part.drift, other.drift];
        let lengths = (part.drift.norm(), other.drift.norm());
        let mut widest: (f64, f64) = (0.0, 0.0);
        for k in first..last {
            let pair = self.pairs[k];
            let (i, j) = (usize::from(pair.a), usize::from(pair.b));
            let (body, obstacle) = (&part.bodies[i], &other.bodies[j]);
            let need = Need::moving(self.clearance, body.spread + obstacle.spread, drifts);
            let a = (self.a.mover.solid(i), &body.placed);
            let b = (self.b.mover.solid(j), &obstacle.placed);
            match judge(a, b, &need, &pair.hint) {
                Verdict::Clear => {}
                Verdict::Contact => return None,
                Verdict::Unsure(hint) => {
                    self.pairs.push(Candidate { hint, ..pair });
                    widest = (widest.0.max(body.spread + lengths.0), widest.1.max(obstacle.spread + lengths.1));
                }
            }
        }
        Some(widest)
    }
}
