//! Named numbers that a problem may override.

use serde::{Deserialize, Serialize};

/// When what an ordering puts first lets what it puts later go on (paper Sec. III-E, "until another robot's roadmap is
/// reached").
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Gate {
    /// As soon as the points themselves allow: where an object is handed on, its release lets the next grasp happen.
    #[default]
    Grasp,
    /// Only when the action of the first point is completed, its arm folded, may the robot of the later one come to the
    /// stand of its action (a fixed arm: grasp or release). An action is all from `start` to `carry`, or from there to `done`.
    Action,
}

/// When an object that is taken away leaves its place to others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Removal {
    /// When it is grasped.
    #[default]
    Grasp,
    /// When the action that takes it away is completed: when it is released elsewhere.
    Completed,
}

/// Distances, times and limits. Each has the documented default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Distance the planner keeps between bodies that may not touch (m).
    pub clearance: f64,
    /// Distance a footprint keeps from its region's border (m).
    pub region_margin: f64,
    /// How far a standing object's bottom may be from its support surface (m).
    pub support_tolerance: f64,
    /// Pause at grasp and at release, robot at rest (s).
    pub grip_time: f64,
    /// Straight way of the hand along the approach axis before a grasp and after a release (m).
    pub approach: f64,
    /// Straight way up after a grasp, and down before a release (m).
    pub lift: f64,
    /// How far the hand may leave the straight way (m).
    pub straightness: f64,
    /// Greatest angle between a stand pose's heading and the direction to the object (rad).
    pub facing: f64,
    /// When what an ordering puts first lets what it puts later go on.
    pub gate: Gate,
    /// When an object that is taken away leaves its place to others.
    pub removal: Removal,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            clearance: 0.002,
            region_margin: 0.005,
            support_tolerance: 0.001,
            grip_time: 0.5,
            approach: 0.10,
            lift: 0.05,
            straightness: 0.005,
            facing: std::f64::consts::FRAC_PI_3,
            gate: Gate::default(),
            removal: Removal::default(),
        }
    }
}

/// Numbers of samples at level 0; each doubles from level to level (science: prefix-monotone samples).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Levels {
    /// Placements for each hop.
    pub placements: u32,
    /// Grasps for each pair.
    pub grasps: u32,
    /// Stands for each end of a pair.
    pub stands: u32,
    /// Vertices of a roadmap piece.
    pub vertices: u32,
    /// Expansions of the composite search; planning a stuck mode together with those in its way may take an eighth as many.
    pub expansions: u32,
    /// Highest level tried before `SamplesExhausted`.
    pub highest: u32,
}

impl Default for Levels {
    fn default() -> Self {
        Self { placements: 32, grasps: 16, stands: 16, vertices: 64, expansions: 20_000, highest: 4 }
    }
}
