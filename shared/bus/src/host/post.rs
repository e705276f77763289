//! The supervisor at its connection.

use std::time::Duration;

use super::HostCore;
use crate::{
    BusFault, Clock, Connection, GarbageTally, MemberId, Message, Outgoing, Receiver, RunKey, SendError, Sender, Topic,
};

/// The supervisor's side of a run on a bus; whoever owns it calls [`Host::attend`] again and again.
pub struct Host {
    /// Its state.
    pub core: HostCore,
    receiver: Receiver,
    sender: Sender,
    clock: std::sync::Arc<dyn Clock>,
    undelivered: u64,
}

impl Host {
    /// Hosts a run.
    #[must_use]
    pub fn new(connection: Connection, run: RunKey, core: HostCore) -> Self {
        Self {
            core,
            receiver: Receiver::new(connection.inbox, run),
            sender: Sender::new(connection.outbox, run, MemberId::SUPERVISOR),
            clock: connection.clock,
            undelivered: 0,
        }
    }

    /// Waits for messages for at most `longest`, takes those that have come, and sends what is due.
    ///
    /// # Errors
    /// [`BusFault::Broken`].
    pub fn attend(&mut self, longest: Duration) -> Result<(), BusFault> {
        self.receiver.wait(longest)?;
        self.drain()
    }

    /// Takes the messages that have come, and sends what is due.
    ///
    /// # Errors
    /// [`BusFault::Broken`].
    pub fn drain(&mut self) -> Result<(), BusFault> {
        while let Some(incoming) = self.receiver.receive()? {
            self.core.hear(self.clock.now(), incoming);
        }
        self.core.tick(self.clock.now());
        self.flush()
    }

    /// Sends what is due.
    ///
    /// # Errors
    /// [`BusFault::Broken`].
    pub fn flush(&mut self) -> Result<(), BusFault> {
        for message in self.core.take_outgoing() {
            self.send(&message)?;
        }
        Ok(())
    }

    /// Tells everybody that the run is over.
    ///
    /// # Errors
    /// [`BusFault::Broken`].
    pub fn shut_down(&mut self) -> Result<(), BusFault> {
        self.send(&Outgoing::plain(Topic::Shutdown, Message::Shutdown))
    }

    fn send(&mut self, outgoing: &Outgoing) -> Result<(), BusFault> {
        match self.sender.send(outgoing) {
            Err(SendError::Bus(fault @ BusFault::Broken(_))) => Err(fault),
            // Whoever misses it asks again.
            Err(_) => {
                self.undelivered += 1;
                Ok(())
            }
            Ok(()) => Ok(()),
        }
    }

    /// Time of the bus.
    #[must_use]
    pub fn now(&self) -> Duration {
        self.clock.now()
    }

    /// What was refused on arrival.
    #[must_use]
    pub fn garbage(&self) -> &GarbageTally {
        self.receiver.garbage()
    }

    /// Messages for which a reader had no room.
    #[must_use]
    pub fn undelivered(&self) -> u64 {
        self.undelivered
    }
}
