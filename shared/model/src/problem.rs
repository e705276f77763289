//! The whole problem, resolved and self-contained: no path, no unresolved name.

use serde::{Deserialize, Serialize};

use crate::{
    EndPolicy, FixedObject, GivenOrdering, Levels, MovableObject, ObjectId, Pair, PairId, Region, Robot, RobotId,
    SearchSettings, Settings,
};

/// Robots, scene, start, task plan and orderings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Problem {
    /// Name for messages.
    pub name: String,
    /// Robots.
    pub robots: Vec<Robot>,
    /// What never moves.
    pub fixed: Vec<FixedObject>,
    /// What is picked and placed.
    pub movable: Vec<MovableObject>,
    /// Workspace regions.
    pub regions: Vec<Region>,
    /// All pairs, robot by robot, in each robot's order.
    pub pairs: Vec<Pair>,
    /// Given orderings, beyond those that each robot's order and each object's hops imply.
    pub orderings: Vec<GivenOrdering>,
    /// End policy of each robot.
    pub end_policies: Vec<EndPolicy>,
    /// Distances, times and limits.
    pub settings: Settings,
    /// Sample counts.
    pub levels: Levels,
    /// How it is to be searched, unless a launch file or the user says otherwise.
    pub search: SearchSettings,
}

impl Problem {
    /// Pairs of one robot, in order.
    pub fn pairs_of_robot(&self, robot: RobotId) -> impl Iterator<Item = PairId> + '_ {
        (0..self.pairs.len()).filter(move |i| self.pairs[*i].robot == robot).map(PairId::at)
    }

    /// Pairs that move one object, in hop order (hop 1 first).
    #[must_use]
    pub fn hops_of_object(&self, object: ObjectId) -> Vec<PairId> {
        let mut hops: Vec<PairId> =
            (0..self.pairs.len()).filter(|i| self.pairs[*i].object == object).map(PairId::at).collect();
        hops.sort_by_key(|pair| self.pairs[pair.index()].hop);
        hops
    }

    /// What the problem's gate makes of an ordering.
    #[must_use]
    pub fn gated(&self, ordering: GivenOrdering) -> Option<GivenOrdering> {
        ordering.gated(self.settings.gate, &self.pairs, &self.robots)
    }

    /// The pair with this identifier.
    #[must_use]
    pub fn pair(&self, pair: PairId) -> &Pair {
        &self.pairs[pair.index()]
    }

    /// The robot with this identifier.
    #[must_use]
    pub fn robot(&self, robot: RobotId) -> &Robot {
        &self.robots[robot.index()]
    }

    /// All robot identifiers.
    pub fn robot_ids(&self) -> impl Iterator<Item = RobotId> + use<> {
        (0..self.robots.len()).map(RobotId::at)
    }
}
