//! Members as threads of one process: crossbeam channels.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crossbeam::channel::{Receiver, RecvTimeoutError, Sender, unbounded};

use crate::{Bus, BusFault, Clock, Connection, Envelope, Inbox, MemberId, Outbox, Parcel, RealTime, Role, Topic};

/// A bus within one process. Readers have room without limit.
#[derive(Clone)]
pub struct Channels {
    readers: Arc<Mutex<Readers>>,
    clock: Arc<RealTime>,
    part_bytes: usize,
}

type Readers = BTreeMap<Topic, Vec<Sender<Arc<Parcel>>>>;

impl Default for Channels {
    fn default() -> Self {
        Self::with_part_bytes(1 << 20)
    }
}

impl Channels {
    /// A bus that cuts messages into parts of at most `part_bytes`.
    #[must_use]
    pub fn with_part_bytes(part_bytes: usize) -> Self {
        Self { readers: Arc::default(), clock: Arc::new(RealTime::start()), part_bytes }
    }
}

impl Bus for Channels {
    fn join(&self, role: Role, _: MemberId) -> Result<Connection, BusFault> {
        let (sender, receiver) = unbounded();
        let mut readers = lock(&self.readers);
        for topic in role.reads() {
            readers.entry(topic).or_default().push(sender.clone());
        }
        let outbox = || Box::new(ChannelOutbox { readers: self.readers.clone(), part_bytes: self.part_bytes });
        Ok(Connection {
            inbox: Box::new(ChannelInbox { receiver, ahead: None }),
            outbox: outbox(),
            pulse: outbox(),
            clock: self.clock.clone() as Arc<dyn Clock>,
        })
    }
}

struct ChannelInbox {
    receiver: Receiver<Arc<Parcel>>,
    ahead: Option<Arc<Parcel>>,
}

impl Inbox for ChannelInbox {
    fn receive(&mut self) -> Result<Option<Parcel>, BusFault> {
        let parcel = match self.ahead.take() {
            Some(parcel) => Some(parcel),
            None => self.receiver.try_recv().ok(),
        };
        Ok(parcel.map(Arc::unwrap_or_clone))
    }

    fn wait(&mut self, longest: Duration) -> Result<(), BusFault> {
        if self.ahead.is_none() {
            self.ahead = match self.receiver.recv_timeout(longest) {
                Ok(parcel) => Some(parcel),
                Err(RecvTimeoutError::Timeout) => None,
                Err(RecvTimeoutError::Disconnected) => return Err(BusFault::Broken("the bus is gone".to_owned())),
            };
        }
        Ok(())
    }
}

struct ChannelOutbox {
    readers: Arc<Mutex<Readers>>,
    part_bytes: usize,
}

impl Outbox for ChannelOutbox {
    fn send(&mut self, topic: Topic, header: &Envelope, part: &[u8]) -> Result<(), BusFault> {
        let parcel = Arc::new(Parcel { topic, header: header.to_bytes(), part: part.to_vec() });
        // Who has left is forgotten.
        if let Some(readers) = lock(&self.readers).get_mut(&topic) {
            readers.retain(|reader| reader.send(parcel.clone()).is_ok());
        }
        Ok(())
    }

    fn wake(&mut self, _: Role) {}

    fn part_bytes(&self, _: Topic) -> usize {
        self.part_bytes
    }
}

fn lock(readers: &Mutex<Readers>) -> MutexGuard<'_, Readers> {
    readers.lock().unwrap_or_else(PoisonError::into_inner)
}
