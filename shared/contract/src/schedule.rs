//! Committed motion of the composite stage.

use model::{AllowedContacts, Configuration, Holding, RobotId};
use serde::{Deserialize, Serialize};
use skeleton::ModeId;

use crate::{EdgeKind, ProductRef};

/// One robot moves straight from one configuration to another, or (equal ends) stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Move {
    /// First configuration: exactly the previous move's last, unbounded coordinates never jump by whole turns.
    pub from: Configuration,
    /// Last configuration.
    pub to: Configuration,
    /// Time at `from` (s).
    pub begins_s: f64,
    /// Time at `to` (s).
    pub ends_s: f64,
    /// What moves.
    pub kind: EdgeKind,
    /// Contacts that are no collision.
    pub allowed: AllowedContacts,
}

/// The motion of one mode, and a way out of everybody's way afterwards.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Commitment {
    /// Mode.
    pub mode: ModeId,
    /// What the robot holds during `moves`.
    pub holding: Option<Holding>,
    /// From the end of the robot's previous commitment (or 0 s) to this mode's event, without gaps.
    pub moves: Vec<Move>,
    /// When the mode's event happens: the end of `moves` (s). The hand's pause is part of the next mode's moves.
    pub event_s: f64,
    /// Motion of the next mode to a place where the robot may stand for ever; replaced by the robot's next commitment.
    pub tail: Vec<Move>,
    /// What the robot holds during `tail`.
    pub tail_holding: Option<Holding>,
}

/// Commitments in the order in which they were made, on top of an earlier prefix.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Prefix {
    /// The prefix that this one extends.
    pub parent: Option<ProductRef>,
    /// What it adds.
    pub commitments: Vec<Commitment>,
    /// Tails that replace those of robots' last commitments, or of robots without any their standing at the start.
    pub tails: Vec<Tail>,
}

/// Motion of a robot's next mode, to a place where it may stand for ever; replaced by its next commitment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tail {
    /// Robot.
    pub robot: RobotId,
    /// From the event of the robot's last commitment (or 0 s) on, without gaps.
    pub moves: Vec<Move>,
}
