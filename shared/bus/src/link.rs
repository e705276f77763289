//! Typed ends of a connection: messages in, messages out.

use std::time::Duration;

use contract::{CodecError, JobId};

use crate::parts::{Assembler, cut};
use crate::{BusFault, Envelope, Garbage, GarbageTally, Inbox, MemberId, Message, Outbox, RunKey, Topic};

/// A message to be sent.
#[derive(Clone, Debug, PartialEq)]
pub struct Outgoing {
    /// Where.
    pub topic: Topic,
    /// The job that it is about.
    pub job: Option<JobId>,
    /// What.
    pub message: Message,
}

impl Outgoing {
    /// A message that is about no job.
    #[must_use]
    pub fn plain(topic: Topic, message: Message) -> Self {
        Self { topic, job: None, message }
    }

    /// A message about a job.
    #[must_use]
    pub fn about(job: JobId, topic: Topic, message: Message) -> Self {
        Self { topic, job: Some(job), message }
    }
}

/// A message that arrived.
#[derive(Clone, Debug, PartialEq)]
pub struct Incoming {
    /// Where.
    pub topic: Topic,
    /// From whom.
    pub sender: MemberId,
    /// The job that it is about.
    pub job: Option<JobId>,
    /// What.
    pub message: Message,
}

/// Why a message could not be sent.
#[derive(Debug, thiserror::Error)]
pub enum SendError {
    /// It is no message.
    #[error(transparent)]
    Codec(#[from] CodecError),
    /// The transport.
    #[error(transparent)]
    Bus(#[from] BusFault),
}

/// Sends messages of one member.
pub struct Sender {
    outbox: Box<dyn Outbox>,
    run: RunKey,
    me: MemberId,
    sequence: u64,
}

impl Sender {
    /// Sends through `outbox`.
    #[must_use]
    pub fn new(outbox: Box<dyn Outbox>, run: RunKey, me: MemberId) -> Self {
        Self { outbox, run, me, sequence: 0 }
    }

    /// Sends a message, and wakes those who should look at it at once.
    ///
    /// # Errors
    /// [`SendError`].
    pub fn send(&mut self, outgoing: &Outgoing) -> Result<(), SendError> {
        let body = outgoing.message.to_body()?;
        self.sequence += 1;
        let kind = outgoing.message.kind() as u32;
        let header = Envelope::whole(kind, self.run, outgoing.job, self.me, self.sequence, &body);
        let sent = cut(&header, &body, self.outbox.part_bytes(outgoing.topic))
            .try_for_each(|(header, part)| self.outbox.send(outgoing.topic, &header, part));
        for role in outgoing.message.wakes(outgoing.topic) {
            self.outbox.wake(role);
        }
        Ok(sent?)
    }
}

/// Receives messages.
pub struct Receiver {
    inbox: Box<dyn Inbox>,
    run: RunKey,
    assembler: Assembler,
    garbage: GarbageTally,
}

impl Receiver {
    /// Receives from `inbox`.
    #[must_use]
    pub fn new(inbox: Box<dyn Inbox>, run: RunKey) -> Self {
        Self { inbox, run, assembler: Assembler::default(), garbage: GarbageTally::default() }
    }

    /// The next message; what is none is counted and passed over.
    ///
    /// # Errors
    /// [`BusFault::Broken`].
    pub fn receive(&mut self) -> Result<Option<Incoming>, BusFault> {
        while let Some(parcel) = self.inbox.receive()? {
            let assembled = match self.assembler.take(parcel, self.run) {
                Ok(Some(assembled)) => assembled,
                Ok(None) => continue,
                Err(reason) => {
                    self.garbage.count(reason);
                    continue;
                }
            };
            match Message::of_body(assembled.kind, assembled.body) {
                Ok(message) => {
                    let (sender, job) = (MemberId(assembled.header.sender), assembled.header.job());
                    return Ok(Some(Incoming { topic: assembled.topic, sender, job, message }));
                }
                Err(_) => self.garbage.count(Garbage::Body),
            }
        }
        Ok(None)
    }

    /// Waits until something may have arrived, but no longer than `longest`.
    ///
    /// # Errors
    /// [`BusFault::Broken`].
    pub fn wait(&mut self, longest: Duration) -> Result<(), BusFault> {
        self.inbox.wait(longest)
    }

    /// What was refused so far.
    #[must_use]
    pub fn garbage(&self) -> &GarbageTally {
        &self.garbage
    }
}
