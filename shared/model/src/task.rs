//! The task plan: pairs, points, given orderings.

use serde::{Deserialize, Serialize};

use crate::{Gate, ObjectId, PairId, RegionId, Robot, RobotId};

/// One pick-and-place of one robot: the paper's abstract action (Sec. II-B), a transit and a transfer mode.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Pair {
    /// Name in files and messages, `<robot>.<number from 1>` unless the problem names it.
    pub name: String,
    /// Who.
    pub robot: RobotId,
    /// What.
    pub object: ObjectId,
    /// From where.
    pub from: RegionId,
    /// To where.
    pub to: RegionId,
    /// Which hop of the object this is, from 1: it takes the object from pose `hop - 1` to pose `hop`.
    pub hop: u32,
}

/// The seven time points t0…t6 of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Point {
    /// t0: the previous pair is done; the robot sets out empty-handed.
    Start,
    /// t1: the base has come to the pick stand for the last time before the grasp.
    AtPick,
    /// t2: the object is attached (G).
    Grasp,
    /// t3: the arm is in its carry configuration.
    Carry,
    /// t4: the base has come to the place stand for the last time before the release.
    AtPlace,
    /// t5: the object is detached (P).
    Release,
    /// t6: the arm is home again.
    Done,
}

impl Point {
    /// All points in order.
    pub const ALL: [Point; 7] =
        [Point::Start, Point::AtPick, Point::Grasp, Point::Carry, Point::AtPlace, Point::Release, Point::Done];

    /// Name as in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        ["start", "at_pick", "grasp", "carry", "at_place", "release", "done"][self as usize]
    }
}

/// An ordering the problem gives: `before` happens strictly before `after`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct GivenOrdering {
    /// What must come first.
    pub before: (PairId, Point),
    /// What must come later.
    pub after: (PairId, Point),
}

impl GivenOrdering {
    /// What a gate makes of an ordering between two robots: the action of `before` is completed before the robot of
    /// `after` comes to the stand of its action; a fixed arm, which is always there, before it grasps or releases.
    pub(crate) fn gated(self, gate: Gate, pairs: &[Pair], robots: &[Robot]) -> Option<Self> {
        let robot = |(pair, _): (PairId, Point)| pairs[pair.index()].robot;
        if gate == Gate::Grasp || robot(self.before) == robot(self.after) {
            return None;
        }
        let drives = robots[robot(self.after).index()].base.is_some();
        let completed = if self.before.1 <= Point::Carry { Point::Carry } else { Point::Done };
        let arrives = match (self.after.1 <= Point::Carry, drives) {
            (true, true) => Point::AtPick,
            (true, false) => Point::Grasp,
            (false, true) => Point::AtPlace,
            (false, false) => Point::Release,
        };
        Some(Self { before: (self.before.0, completed), after: (self.after.0, arrives) })
    }
}

/// What a robot does after its last pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum EndPolicy {
    /// Returns to its start configuration.
    #[default]
    Return,
    /// Stays at its last stand with the arm home.
    Stay,
}
