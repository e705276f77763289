//! What a transport has to offer.

use std::sync::Arc;
use std::time::Duration;

use crate::{Envelope, MemberId, Role, Topic};

/// A bus that members of one run can join.
///
/// Between one sender and one reader of a topic messages keep their order, and none is lost unless
/// [`BusFault::Undelivered`] says so or one of the two dies. Nothing is said about the order between topics.
pub trait Bus: Send + Sync {
    /// Joins the run: from now on everything written to the role's topics arrives.
    ///
    /// # Errors
    /// [`BusFault::Broken`].
    fn join(&self, role: Role, member: MemberId) -> Result<Connection, BusFault>;
}

/// A member's hold on the bus. Its parts may be used from different threads.
pub struct Connection {
    /// What arrives.
    pub inbox: Box<dyn Inbox>,
    /// Writes to every topic of the role. A slow reader makes it wait, for a while.
    pub outbox: Box<dyn Outbox>,
    /// Writes presence only, and never waits: what a reader has no room for is lost to it.
    pub pulse: Box<dyn Outbox>,
    /// Time.
    pub clock: Arc<dyn Clock>,
}

/// The reading end.
pub trait Inbox: Send {
    /// The next message part, if one has arrived.
    ///
    /// # Errors
    /// [`BusFault::Broken`].
    fn receive(&mut self) -> Result<Option<Parcel>, BusFault>;

    /// Waits until something may have arrived, but no longer than `longest`. It may return early for no reason.
    ///
    /// # Errors
    /// [`BusFault::Broken`].
    fn wait(&mut self, longest: Duration) -> Result<(), BusFault>;
}

/// The writing end.
pub trait Outbox: Send {
    /// Hands one message part to every reader of the topic.
    ///
    /// # Errors
    /// [`BusFault::Undelivered`] if a reader had no room for too long (others may have got it), [`BusFault::Broken`].
    fn send(&mut self, topic: Topic, header: &Envelope, part: &[u8]) -> Result<(), BusFault>;

    /// Tells members of a role that something has arrived. Only a hint: readers look on a timer, too.
    fn wake(&mut self, role: Role);

    /// Greatest size of a part on a topic (bytes).
    fn part_bytes(&self, topic: Topic) -> usize;
}

/// Time of a bus: real or simulated.
pub trait Clock: Send + Sync {
    /// Time since an origin of its own.
    fn now(&self) -> Duration;
}

/// One message part as it arrived; nothing in it has been checked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parcel {
    /// Where it arrived.
    pub topic: Topic,
    /// Bytes of the header.
    pub header: [u8; Envelope::BYTES],
    /// Bytes of the part.
    pub part: Vec<u8>,
}

/// Why a transport failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BusFault {
    /// A reader had no room for too long.
    #[error("a reader of {topic:?} did not take a message in time")]
    Undelivered {
        /// Topic.
        topic: Topic,
    },
    /// The transport cannot go on.
    #[error("{0}")]
    Broken(String),
}
