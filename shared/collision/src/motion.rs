//! What is asked about: who holds what, straight motions, standing objects.

use model::{AllowedContacts, Configuration, Holding, RobotId};

/// A straight motion of one robot in configuration space, inside one holding state.
///
/// The configurations hold one value per coordinate (m or rad), angles unwrapped. Equal ends mean standing still.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Who moves.
    pub robot: RobotId,
    /// What it holds all the way.
    pub holding: Option<Holding>,
    /// First configuration.
    pub from: Configuration,
    /// Last configuration.
    pub to: Configuration,
    /// Contacts that do not count.
    pub allowed: AllowedContacts,
}
