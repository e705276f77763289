//! Identifiers. Each is the index of its noun in the list that owns it; none can stand for another.

use serde::{Deserialize, Serialize};

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        pub struct $name(pub u32);

        impl $name {
            /// The identifier of the element at `index`.
            #[must_use]
            pub fn at(index: usize) -> Self {
                Self(u32::try_from(index).unwrap_or(u32::MAX))
            }

            /// The position in the list that owns the element.
            #[must_use]
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }
    };
}

id!(
    /// A robot, in `Problem::robots`.
    RobotId
);
id!(
    /// A link, in `Robot::links`.
    LinkId
);
id!(
    /// A joint, in `Robot::joints`.
    JointId
);
id!(
    /// A planned coordinate, in `Robot::coordinates`: the index into a configuration.
    CoordinateId
);
id!(
    /// A fixed object, in `Problem::fixed`.
    FixedId
);
id!(
    /// A movable object, in `Problem::movable`.
    ObjectId
);
id!(
    /// A workspace region, in `Problem::regions`.
    RegionId
);
id!(
    /// A pick-and-place pair, in `Problem::pairs` (robot by robot, in each robot's order).
    PairId
);
id!(
    /// A grasp, in `MovableObject::grasps` of one robot.
    GraspId
);
