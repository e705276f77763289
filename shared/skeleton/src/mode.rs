//! Modes: what a robot is doing between two of its events.

use model::{EndPolicy, ObjectId, PairId, Point, Problem, RobotId};
use serde::{Deserialize, Serialize};

use crate::{Cycle, Event, EventGraph, Interval, Occupancy};

/// Kind of a mode (paper Sec. II-B), with the closing return.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ModeKind {
    /// Empty hand, on the way to a grasp.
    Transit,
    /// Holding, on the way to a release.
    Transfer,
    /// Empty hand, on the way to the end configuration.
    Return,
}

/// A mode of a robot: `step` counts its modes from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct ModeId {
    /// Robot.
    pub robot: RobotId,
    /// Position in the robot's sequence of modes.
    pub step: u32,
}

/// A mode with its place in the task plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mode {
    /// Identity.
    pub id: ModeId,
    /// Kind.
    pub kind: ModeKind,
    /// The pair it serves; for a closing return none.
    pub pair: Option<PairId>,
    /// The event that begins it (none: the start of the plan).
    pub begins: Option<Event>,
    /// The event that ends it (none: the end of the plan).
    pub ends: Option<Event>,
}

impl Mode {
    /// The interval in which the robot may be anywhere in the mode: its roadmap is reversible.
    #[must_use]
    pub fn interval(&self) -> Interval {
        Interval { from: self.begins, to: self.ends }
    }

    /// Whether the robot holds the pair's object.
    #[must_use]
    pub fn is_holding(&self) -> bool {
        self.kind == ModeKind::Transfer
    }
}

/// Modes, occupancies and the event graph of a problem.
#[derive(Clone, Debug)]
pub struct Skeleton {
    /// The order on events.
    pub graph: EventGraph,
    /// Modes of each robot in order.
    pub modes: Vec<Vec<Mode>>,
    /// Pairs that move each object, in hop order.
    pub hops: Vec<Vec<PairId>>,
}

impl Skeleton {
    /// The skeleton of a problem with its given orderings.
    ///
    /// # Errors
    /// A cycle among the given orderings.
    pub fn of_problem(problem: &Problem) -> Result<Self, Cycle> {
        Ok(Self {
            graph: EventGraph::of_problem(problem)?,
            modes: problem.robot_ids().map(|robot| modes_of_robot(problem, robot)).collect(),
            hops: (0..problem.movable.len()).map(|m| problem.hops_of_object(ObjectId::at(m))).collect(),
        })
    }

    /// A mode by its identity.
    #[must_use]
    pub fn mode(&self, id: ModeId) -> &Mode {
        &self.modes[id.robot.index()][id.step as usize]
    }

    /// Every pose that any object takes: pose 0 is its start.
    pub fn occupancies(&self) -> impl Iterator<Item = Occupancy> + '_ {
        self.hops.iter().enumerate().flat_map(|(object, hops)| {
            (0..=hops.len()).map(move |hop| Occupancy { object: ObjectId::at(object), hop: hop as u32 })
        })
    }

    /// When a pose is occupied: from its release to the next grasp of the object.
    #[must_use]
    pub fn interval_of(&self, occupancy: Occupancy) -> Interval {
        let hops = &self.hops[occupancy.object.index()];
        let hop = occupancy.hop as usize;
        Interval {
            from: hop.checked_sub(1).map(|i| Event::release(hops[i])),
            to: hops.get(hop).map(|pair| Event::grasp(*pair)),
        }
    }

    /// The occupancy that a pair picks up.
    #[must_use]
    pub fn picked(&self, problem: &Problem, pair: PairId) -> Occupancy {
        let pair = problem.pair(pair);
        Occupancy { object: pair.object, hop: pair.hop - 1 }
    }

    /// The occupancy that a pair creates.
    #[must_use]
    pub fn placed(&self, problem: &Problem, pair: PairId) -> Occupancy {
        let pair = problem.pair(pair);
        Occupancy { object: pair.object, hop: pair.hop }
    }
}

fn modes_of_robot(problem: &Problem, robot: RobotId) -> Vec<Mode> {
    let mut modes: Vec<Mode> = Vec::new();
    let mut begins = None;
    let mut push = |kind, pair, begins, ends| {
        let id = ModeId { robot, step: modes.len() as u32 };
        modes.push(Mode { id, kind, pair, begins, ends });
    };
    for pair in problem.pairs_of_robot(robot) {
        let (grasp, release) = (Event::new(pair, Point::Grasp), Event::new(pair, Point::Release));
        push(ModeKind::Transit, Some(pair), begins, Some(grasp));
        push(ModeKind::Transfer, Some(pair), Some(grasp), Some(release));
        begins = Some(release);
    }
    if begins.is_some() {
        match problem.end_policies[robot.index()] {
            // Even a robot that stays brings its arm home: `done` of its last pair.
            EndPolicy::Return | EndPolicy::Stay => push(ModeKind::Return, None, begins, None),
        }
    }
    modes
}
