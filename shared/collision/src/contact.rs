//! Which bodies come too close to each other.

use model::{FixedId, LinkId, ObjectId, Problem, RobotId};
use plan::{BodyRef, Cause};
use serde::{Deserialize, Serialize};

/// Something that can be touched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum BodyName {
    /// A link of a robot.
    Link {
        /// Whose.
        robot: RobotId,
        /// Which.
        link: LinkId,
    },
    /// An object in a robot's hand.
    Held {
        /// Whose hand.
        robot: RobotId,
        /// Which object.
        object: ObjectId,
    },
    /// A fixed object.
    Fixed(FixedId),
    /// A standing movable object.
    Object(ObjectId),
}

impl BodyName {
    /// The name for a message, such as ``link `elbow` of `r1` ``.
    #[must_use]
    pub fn describe(&self, problem: &Problem) -> String {
        match *self {
            BodyName::Link { robot, link } => {
                let robot = problem.robot(robot);
                format!("link `{}` of `{}`", robot.links[link.index()].name, robot.name)
            }
            BodyName::Held { robot, object } => {
                format!("`{}` in the hand of `{}`", problem.movable[object.index()].name, problem.robot(robot).name)
            }
            BodyName::Fixed(fixed) => format!("`{}`", problem.fixed[fixed.index()].name),
            BodyName::Object(object) => format!("`{}`", problem.movable[object.index()].name),
        }
    }
}

/// Two bodies nearer than the clearance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Contact {
    /// The moving body (or, of two standing ones, the first asked about).
    pub first: BodyName,
    /// What it comes too close to.
    pub second: BodyName,
}

impl Contact {
    /// Both names, for a message.
    #[must_use]
    pub fn describe(&self, problem: &Problem) -> String {
        format!("{} and {}", self.first.describe(problem), self.second.describe(problem))
    }
}

impl BodyName {
    /// The body by its names in the problem.
    #[must_use]
    pub fn in_words_of(&self, problem: &Problem) -> BodyRef {
        let robot_name = |robot: RobotId| problem.robot(robot).name.clone();
        let object_name = |object: ObjectId| problem.movable[object.index()].name.clone();
        match *self {
            BodyName::Link { robot, link } => {
                BodyRef::Link { robot: robot_name(robot), link: problem.robot(robot).links[link.index()].name.clone() }
            }
            BodyName::Held { robot, object } => BodyRef::Held { robot: robot_name(robot), object: object_name(object) },
            BodyName::Fixed(fixed) => BodyRef::Fixed(problem.fixed[fixed.index()].name.clone()),
            BodyName::Object(object) => BodyRef::Object(object_name(object)),
        }
    }
}

impl Contact {
    /// The contact as a cause of failure.
    #[must_use]
    pub fn cause(&self, problem: &Problem) -> Cause {
        Cause::Collision { first: self.first.in_words_of(problem), second: self.second.in_words_of(problem) }
    }
}
