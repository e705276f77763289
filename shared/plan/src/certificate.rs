//! Proofs that a problem has no plan, in the problem's own names.
//!
//! A certificate says how it can be verified, not that it was: `validation` re-computes every number with its own
//! mathematics and accepts none that claims more than is so. It speaks of all plans that keep the checker's rules, not of
//! what the planner's stages would find. Lengths are in m, areas in m².

use serde::{Deserialize, Serialize};

use crate::PairPoint;

/// Why no plan can exist.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Certificate {
    /// Objects that exclude one another in a region have to come one after the other; however they do, the orderings
    /// contradict one another.
    Cycle {
        /// Stays of which one must end before the other begins.
        exclusions: Vec<Exclusion>,
        /// Contradictions: whichever order is taken for each exclusion, all arcs of one of these hold. Each arc ends
        /// where the next begins, the last where the first does.
        cycles: Vec<Vec<CycleArc>>,
    },
    /// Objects that are in a region at the same time in every execution are together larger than it.
    Area {
        /// Region.
        region: String,
        /// Area within the region's margin.
        region_area_m2: f64,
        /// The stays, and what each covers of that area.
        stays: Vec<Cover>,
        /// The orderings that make every two stays overlap: one begins before the other ends. They follow from what the
        /// problem gives. Stays from the start or without an end need none.
        together: Vec<[PairPoint; 2]>,
    },
    /// An object does not fit into a region that it is brought to, at any yaw.
    ObjectTooLarge {
        /// Object.
        object: String,
        /// Region.
        region: String,
    },
    /// Wherever a robot may stand, and however it may hold the object, its hand is beyond what its arm can reach, for
    /// every pose that the object may have at this end of the pair.
    Reach {
        /// Robot.
        robot: String,
        /// Pair.
        pair: String,
        /// End of the pair.
        end: PairEnd,
        /// Region of that end.
        region: String,
        /// Distances of all grasps.
        distance: Distance,
        /// Where the base may stand; absent for a fixed base.
        map: Option<BaseMap>,
    },
    /// Every grasp that is listed for a pair is impossible at one of the pair's ends, for every pose that the object may
    /// have there.
    NoCommonGrasp {
        /// Robot.
        robot: String,
        /// Pair.
        pair: String,
        /// One entry for each grasp of the list, in its order.
        grasps: Vec<RefutedGrasp>,
    },
    /// From its start the robot's base cannot drive to any stand from which its arm could reach the object.
    BaseDisconnected {
        /// Robot.
        robot: String,
        /// Pair.
        pair: String,
        /// End of the pair.
        end: PairEnd,
        /// Region of that end.
        region: String,
        /// Where the base starts (x, y in the frame of the base's coordinates).
        from_m: [f64; 2],
        /// The shoulder in the frame of the robot's root link.
        shoulder_m: [f64; 3],
        /// Greatest distance of the hand's origin from the shoulder.
        greatest_m: f64,
        /// Where the base may stand.
        map: BaseMap,
    },
}

/// One of the two ends of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PairEnd {
    /// Where the object is taken from.
    Pick,
    /// Where it is brought to.
    Place,
}

/// An object standing somewhere: from the release of one pair, or from the start, until the next pair's grasp, or for ever.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stay {
    /// Object.
    pub object: String,
    /// The pair that put it there; none for its start pose.
    pub placed_by: Option<String>,
}

/// A stay, and how much it covers of a region.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cover {
    /// The stay.
    pub stay: Stay,
    /// Area that the object covers within the region's margin.
    pub area_m2: f64,
}

/// Two stays that cannot overlap: together they cover more than there is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Exclusion {
    /// Region.
    pub region: String,
    /// Area within the region's margin.
    pub region_area_m2: f64,
    /// The two stays.
    pub stays: [Cover; 2],
}

/// `before` comes strictly before `after`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CycleArc {
    /// What comes first.
    pub before: PairPoint,
    /// What comes later.
    pub after: PairPoint,
    /// Why.
    pub origin: CycleOrigin,
}

/// Where an arc of a cycle comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum CycleOrigin {
    /// Points of one robot, in its order.
    Robot,
    /// Consecutive hops of one object.
    Object,
    /// Listed in the problem.
    Given,
    /// The order taken for an exclusion: one stay ends before the other begins.
    Excluded {
        /// Which exclusion, counted from 0.
        exclusion: u32,
    },
}

/// How far the hand's origin is from the shoulder: where it would have to be, against what the arm allows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Distance {
    /// The shoulder: a point of the robot's root link, in that link's frame.
    pub shoulder_m: [f64; 3],
    /// The two distances.
    pub limit: DistanceLimit,
}

/// Which way the hand would be out of reach.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum DistanceLimit {
    /// Too far.
    Far {
        /// No configuration of the arm has the hand farther.
        greatest_m: f64,
        /// No pose, grasp and stand asks for it nearer.
        nearest_m: f64,
    },
    /// Too near.
    Near {
        /// No configuration of the arm has the hand nearer.
        least_m: f64,
        /// No pose, grasp and stand asks for it farther.
        farthest_m: f64,
    },
}

/// A map of the places where a base may stand: square cells over its limits, less those that fixed objects are proven
/// to block for every position in the cell and every yaw.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BaseMap {
    /// Edge length of a cell, at most.
    pub cell_m: f64,
    /// Discs about the yaw axis that the base contains.
    pub discs: Vec<Disc>,
}

/// A disc about the yaw axis that is inside of the base at every height of a slice; heights in the base's frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Disc {
    /// Where the slice begins.
    pub bottom_m: f64,
    /// Where it ends.
    pub top_m: f64,
    /// Radius.
    pub radius_m: f64,
}

/// Why one grasp does not serve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RefutedGrasp {
    /// Position in the list of the pair's object and robot, from 0.
    pub grasp: u32,
    /// The end at which it is impossible.
    pub end: PairEnd,
    /// Why.
    pub reason: GraspReason,
}

/// Why a grasp is impossible at one end of a pair.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum GraspReason {
    /// Wherever the robot may stand, its hand is out of reach.
    OutOfReach {
        /// Distances of this grasp.
        distance: Distance,
        /// Where the base may stand; absent for a fixed base.
        map: Option<BaseMap>,
    },
    /// At every pose the hand, open or closed round the object, or the object itself runs into a fixed object.
    Blocked {
        /// Fixed objects that are in the way at one pose or another.
        by: Vec<String>,
    },
}
