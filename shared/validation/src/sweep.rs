//! Continuous-time clearance by recursive bisection (rule V11's engine).
//!
//! On a stretch of time during which all joints move evenly, two bodies are apart if a gap that is proven at the middle
//! exceeds what both can move in half the stretch. Otherwise the stretch is halved. Bodies that overlap at some middle, or
//! cannot be proven apart by more than the resolution floor, have met.

use glamx::DVec3;

use crate::frame::Frame;
use crate::solid::{Separation, Solid};

/// Motion (m) below which a stretch of time is not halved again: closer bodies count as met.
const FLOOR: f64 = 1e-6;
/// Allowance (m) for rounding in kinematics and gaps.
const ROUNDING: f64 = 1e-9;

/// A body at an instant.
#[derive(Clone, Copy)]
pub(crate) struct Placed {
    /// Takes the shape's own frame to the world's.
    pub(crate) frame: Frame,
    /// Centre of its bounding sphere in the world.
    pub(crate) centre: DVec3,
    /// Bound on the speed of its points (m/s).
    pub(crate) speed: f64,
}

impl Placed {
    /// A body of an owner that stands at `owner`.
    pub(crate) fn still(solid: &Solid, owner: Frame) -> Self {
        Self { frame: owner * solid.owner_from_shape, centre: owner.point(solid.centre), speed: 0.0 }
    }
}

/// Two sides whose bodies may meet during one stretch of even motion.
pub(crate) trait Encounter {
    /// Places all bodies for an instant.
    fn place(&mut self, t: f64);
    /// The first body of a candidate as placed.
    fn first(&self, candidate: &Candidate) -> (&Solid, &Placed);
    /// The second body.
    fn second(&self, candidate: &Candidate) -> (&Solid, &Placed);
    /// Bound on how fast the distance of the two can change (m/s), as placed.
    fn closing_speed(&self, candidate: &Candidate) -> f64 {
        self.first(candidate).1.speed + self.second(candidate).1.speed
    }
}

/// A pair of bodies that is not yet proven apart.
#[derive(Clone, Copy)]
pub(crate) struct Candidate {
    /// Index on the first side.
    pub(crate) first: usize,
    /// Index on the second side.
    pub(crate) second: usize,
    /// Index of the pair's memory.
    pub(crate) slot: usize,
    /// How far the first body is raised before it is tested (m): what an allowed contact may overlap.
    pub(crate) lift: f64,
}

/// Two bodies have met.
pub(crate) struct Hit {
    pub(crate) candidate: Candidate,
    pub(crate) t: f64,
    /// Overlap (m); 0 for bodies that are merely not apart by the floor.
    pub(crate) depth: f64,
}

/// The search, with what it remembers of each pair from stretch to stretch.
pub(crate) struct Sweep {
    /// Last separating axis of each pair.
    axes: Vec<DVec3>,
    /// Pairs that have met are reported once.
    met: Vec<bool>,
    stack: Vec<Candidate>,
    pub(crate) hits: Vec<Hit>,
    pub(crate) least: Vec<f64>,
    pub(crate) tally: Tally,
}

/// Work done.
#[derive(Clone, Copy, Default)]
pub(crate) struct Tally {
    pub(crate) intervals: u64,
    pub(crate) pairs: u64,
    pub(crate) distances: u64,
}

enum Answer {
    Apart,
    Unsure { floor: bool },
    Met { depth: f64 },
}

impl Sweep {
    pub(crate) fn new(slots: usize) -> Self {
        Self {
            axes: vec![DVec3::ZERO; slots],
            met: vec![false; slots],
            stack: Vec::new(),
            hits: Vec::new(),
            least: vec![f64::INFINITY; slots],
            tally: Tally::default(),
        }
    }

    /// Forgets that the pairs with these slots have met: other bodies stand there now.
    pub(crate) fn renew(&mut self, slots: impl Iterator<Item = usize>) {
        slots.for_each(|slot| self.met[slot] = false);
    }

    /// Examines all `candidates` on the stretch `[a, b]`; `encounter` is placed at its middle.
    pub(crate) fn examine(
        &mut self,
        encounter: &mut impl Encounter,
        (a, b): (f64, f64),
        candidates: impl Iterator<Item = Candidate>,
    ) {
        self.tally.intervals += 1;
        let start = self.stack.len();
        for candidate in candidates {
            self.tally.pairs += 1;
            if !self.met[candidate.slot] && !self.spheres_apart(encounter, &candidate, (b - a) / 2.0) {
                self.stack.push(candidate);
            }
        }
        if self.stack.len() > start {
            self.descend(encounter, (a, b), start);
        }
        self.stack.truncate(start);
    }

    fn spheres_apart(&self, encounter: &impl Encounter, candidate: &Candidate, half: f64) -> bool {
        let ((solid, placed), (other, other_placed)) = (encounter.first(candidate), encounter.second(candidate));
        let reach = solid.radius + other.radius + candidate.lift + encounter.closing_speed(candidate) * half + ROUNDING;
        placed.centre.distance_squared(other_placed.centre) > reach * reach
    }

    /// Tests the candidates on the stack from `start` on, placed at the middle; halves the stretch for the unsure.
    fn descend(&mut self, encounter: &mut impl Encounter, (a, b): (f64, f64), start: usize) {
        let (middle, half, end) = (f64::midpoint(a, b), (b - a) / 2.0, self.stack.len());
        let finest = middle <= a || middle >= b;
        for i in start..end {
            let candidate = self.stack[i];
            if self.met[candidate.slot] {
                continue;
            }
            let depth = match self.test(encounter, &candidate, half) {
                Answer::Apart => continue,
                Answer::Unsure { floor } if !floor && !finest => {
                    self.stack.push(candidate);
                    continue;
                }
                Answer::Unsure { .. } => 0.0,
                Answer::Met { depth } => depth,
            };
            self.met[candidate.slot] = true;
            self.hits.push(Hit { candidate, t: middle, depth });
        }
        if self.stack.len() > end {
            for part in [(a, middle), (middle, b)] {
                encounter.place(f64::midpoint(part.0, part.1));
                self.descend(encounter, part, end);
            }
        }
        self.stack.truncate(end);
    }

    fn test(&mut self, encounter: &impl Encounter, candidate: &Candidate, half: f64) -> Answer {
        if self.spheres_apart(encounter, candidate, half) {
            return Answer::Apart;
        }
        let ((solid, placed), (other, other_placed)) = (encounter.first(candidate), encounter.second(candidate));
        let motion = encounter.closing_speed(candidate) * half;
        let mut frame = placed.frame;
        frame.origin.z += candidate.lift;
        let known = self.axes[candidate.slot];
        let axis =
            if known == DVec3::ZERO { (other_placed.centre - placed.centre).normalize_or(DVec3::Z) } else { known };
        let mut gap = solid.gap_along(&frame, other, &other_placed.frame, axis);
        if gap > motion + ROUNDING {
            return Answer::Apart;
        }
        self.tally.distances += 1;
        let separation = solid.separation(&frame, other, &other_placed.frame, axis);
        let mut overlap = matches!(separation, Separation::Touching);
        if let Separation::Apart(axis, distance) = separation {
            overlap = distance <= 0.0;
            self.axes[candidate.slot] = axis;
            self.least[candidate.slot] = self.least[candidate.slot].min(distance);
            gap = gap.max(solid.gap_along(&frame, other, &other_placed.frame, axis));
            if gap > motion + ROUNDING {
                return Answer::Apart;
            }
        }
        // A proven gap outweighs what the distance query says.
        if overlap && gap <= 0.0 {
            return Answer::Met { depth: solid.depth(&frame, other, &other_placed.frame) };
        }
        Answer::Unsure { floor: motion < FLOOR }
    }
}
