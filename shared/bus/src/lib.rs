//! The bus: envelope, topics, messages, the run's store; the [`Bus`] trait and its transports.
//!
//! Transports ([`Channels`], [`Iceoryx2`]) move bytes between members and keep time. Above them nothing knows which one
//! it is: [`BusAsk`] is the search's way of asking over a bus, [`Worker`] a stage's way of being asked, [`Host`] the
//! supervisor's side with statement and store. The state of each is a plain value ([`Dispatcher`], [`WorkerCore`],
//! [`HostCore`]) that takes messages and gives messages; threads and clocks are around it, not in it.
//!
//! Any message may be garbage, lost, doubled or late. What is lost is asked for again; what comes twice says the same;
//! what is no message is counted ([`GarbageTally`]) and passed over.

mod ask;
mod channels;
mod dispatcher;
mod envelope;
mod finite;
mod garbage;
mod host;
mod iceoryx2;
mod link;
mod member;
mod message;
mod orphans;
mod parts;
mod real_time;
mod topic;
mod transport;
mod worker;

use std::time::Duration;

pub use ask::{Announcer, AskSettings, BusAsk};
pub use channels::Channels;
pub use dispatcher::{Dispatcher, POISON_DEATHS};
pub use envelope::{CONTRACT_VERSION, Envelope, checksum};
pub use finite::{NotFinite, check_finite, check_numbers};
pub use garbage::{Garbage, GarbageTally};
pub use host::{Expected, Host, HostCore, HostFault, Note, Store};
pub use iceoryx2::{Iceoryx2, Iceoryx2Place};
pub use link::{Incoming, Outgoing, Receiver, SendError, Sender};
pub use member::{MemberId, Role, RunKey};
pub use message::{
    BacktrackRequest, BodyError, Committed, Gone, Heartbeat, Hello, JobOffer, Kept, Kind, Message, Retirement,
    SearchEnd, Want,
};
pub use real_time::RealTime;
pub use topic::Topic;
pub use transport::{Bus, BusFault, Clock, Connection, Inbox, Outbox, Parcel};
pub use worker::{Worker, WorkerCore, statement_digest};

/// Members give a sign of life this often.
pub const HEARTBEAT: Duration = Duration::from_millis(100);
