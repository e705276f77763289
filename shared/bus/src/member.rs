//! Who takes part in a run.

use contract::StageKind;
use serde::{Deserialize, Serialize};

/// One start of a process or thread that takes part in a run. Numbers are never used twice in a run: what comes back
/// after a death is another member.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct MemberId(pub u32);

impl MemberId {
    /// The supervisor.
    pub const SUPERVISOR: MemberId = MemberId(0);
}

/// What a member does in a run; it decides which topics it reads and writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Role {
    /// Owns the run: services, store, problem.
    Supervisor,
    /// Searches.
    Refiner,
    /// Answers the jobs of one stage.
    Worker(StageKind),
}

impl Role {
    /// All roles.
    #[must_use]
    pub fn all() -> Vec<Role> {
        let mut roles = vec![Role::Supervisor, Role::Refiner];
        roles.extend(StageKind::ALL.map(Role::Worker));
        roles
    }

    /// Name as in service names.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Role::Supervisor => "supervisor",
            Role::Refiner => "refiner",
            Role::Worker(stage) => stage.name(),
        }
    }
}

/// Which run a message belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RunKey(pub u64);

impl RunKey {
    /// The key of the run of this name.
    #[must_use]
    pub fn of_name(name: &str) -> Self {
        let digest = contract::Digest::of("mrtamp run", &[name.as_bytes()]);
        Self(first_u64(&digest.0))
    }
}

/// The first eight bytes of a digest as a little-endian number.
pub(crate) fn first_u64(digest: &[u8; 32]) -> u64 {
    digest[..8].iter().rev().fold(0, |value, byte| value << 8 | u64::from(*byte))
}
