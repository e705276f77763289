//! Events: the time points of pairs.

use model::{PairId, Point, Problem};
use serde::{Deserialize, Serialize};

/// One time point of one pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Event {
    /// Pair.
    pub pair: PairId,
    /// Point.
    pub point: Point,
}

impl Event {
    /// The event of `pair` at `point`.
    #[must_use]
    pub fn new(pair: PairId, point: Point) -> Self {
        Self { pair, point }
    }

    /// G: the object is attached.
    #[must_use]
    pub fn grasp(pair: PairId) -> Self {
        Self::new(pair, Point::Grasp)
    }

    /// P: the object is detached.
    #[must_use]
    pub fn release(pair: PairId) -> Self {
        Self::new(pair, Point::Release)
    }

    /// Name as in messages, e.g. `grasp of r1.2`.
    #[must_use]
    pub fn describe(self, problem: &Problem) -> String {
        format!("{} of {}", self.point.name(), problem.pair(self.pair).name)
    }

    pub(crate) fn node(self) -> usize {
        self.pair.index() * Point::ALL.len() + self.point as usize
    }

    pub(crate) fn of_node(node: usize) -> Self {
        Self::new(PairId::at(node / Point::ALL.len()), Point::ALL[node % Point::ALL.len()])
    }
}
