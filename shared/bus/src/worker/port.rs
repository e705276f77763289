//! A worker with its two threads: one tends the bus, the other computes.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use contract::{Digest, JobId, JobPort, Offer, Outcome, ProblemStatement, Products, Refusal, ServeFault, StageKind};

use super::WorkerCore;
use crate::{
    BusFault, Clock, Connection, HEARTBEAT, Hello, MemberId, Message, Outgoing, Receiver, RunKey, SendError, Sender,
    Topic, Want,
};

/// The bus is looked at this often even if nobody wakes this member.
pub(crate) const TICK: Duration = Duration::from_millis(20);
/// A product is asked for again after this long.
const WANT_AGAIN: Duration = Duration::from_millis(200);
/// A product that has not come after this long is lacking.
const LACKING_AFTER: Duration = Duration::from_secs(2);

/// A worker on the bus: the [`JobPort`] of the thread that computes. A thread of its own tends the bus meanwhile.
pub struct Worker {
    shared: Arc<Shared>,
    tender: Option<JoinHandle<()>>,
}

struct Shared {
    core: Mutex<WorkerCore>,
    changed: Condvar,
    work: Mutex<Sender>,
    clock: Arc<dyn Clock>,
    stop: Arc<AtomicBool>,
    left: AtomicBool,
    crashed: AtomicBool,
    broken: Mutex<Option<BusFault>>,
}

impl Worker {
    /// Joins a run as a worker of `stage`. Setting `stop` ends it.
    ///
    /// # Errors
    /// [`BusFault::Broken`] if no thread can be had.
    pub fn join(
        connection: Connection,
        run: RunKey,
        me: MemberId,
        stage: StageKind,
        hello: Hello,
        stop: Arc<AtomicBool>,
    ) -> Result<Self, BusFault> {
        let Connection { inbox, outbox, pulse, clock } = connection;
        let shared = Arc::new(Shared {
            core: Mutex::new(WorkerCore::new(me, stage, hello)),
            changed: Condvar::new(),
            work: Mutex::new(Sender::new(outbox, run, me)),
            clock,
            stop,
            left: AtomicBool::new(false),
            crashed: AtomicBool::new(false),
            broken: Mutex::new(None),
        });
        let tended = shared.clone();
        let (receiver, pulse) = (Receiver::new(inbox, run), Sender::new(pulse, run, me));
        let tender = std::thread::Builder::new()
            .name("bus".to_owned())
            .spawn(move || tended.tend(receiver, pulse))
            .map_err(|error| BusFault::Broken(error.to_string()))?;
        Ok(Self { shared, tender: Some(tender) })
    }

    /// Waits for the statement. `None`: the run is over.
    ///
    /// # Errors
    /// [`ServeFault`] when the transport has failed.
    pub fn statement(&self) -> Result<Option<Arc<ProblemStatement>>, ServeFault> {
        self.shared.wait_for(|core| core.statement())
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.shared.crashed.store(std::thread::panicking(), Ordering::Relaxed);
        self.shared.left.store(true, Ordering::Release);
        if let Some(tender) = self.tender.take() {
            // A panic of the tender has already been reported by its thread.
            let _ = tender.join();
        }
    }
}

impl JobPort for Worker {
    fn next_offer(&mut self) -> Result<Option<Offer>, ServeFault> {
        self.shared.wait_for(WorkerCore::begin)
    }

    fn started(&mut self, id: JobId) -> Result<(), ServeFault> {
        self.shared.change(|core| core.started(id))
    }

    fn answer(&mut self, id: JobId, answer: Result<Outcome, Refusal>) -> Result<(), ServeFault> {
        self.shared.change(|core| core.finish(id, answer))
    }

    fn products(&self) -> Arc<dyn Products> {
        Arc::new(WorkerProducts(self.shared.clone()))
    }
}

/// Products through the bus: what is not here is asked of the store.
struct WorkerProducts(Arc<Shared>);

impl Products for WorkerProducts {
    fn get(&self, digest: &Digest) -> Option<Arc<[u8]>> {
        let begun = self.0.clock.now();
        let mut asked: Option<Duration> = None;
        loop {
            let now = self.0.clock.now();
            {
                let mut core = self.0.core();
                if let Some(bytes) = core.product(digest) {
                    return Some(bytes);
                }
                let hopeless = core.take_absent(digest) || core.is_cancelled() || now > begun + LACKING_AFTER;
                if asked.is_some() && hopeless {
                    return None;
                }
            }
            if asked.is_none_or(|asked| now > asked + WANT_AGAIN) {
                asked = Some(now);
                // Undelivered: it is asked for again, or is lacking in the end.
                let _ = self.0.send(&Outgoing::plain(Topic::Want, Message::Want(Want::Product(*digest))));
            }
            let core = self.0.core();
            if core.product(digest).is_none() {
                drop(self.0.changed.wait_timeout(core, TICK));
            }
        }
    }

    fn put(&self, bytes: Vec<u8>) -> Digest {
        let (digest, outgoing) = self.0.core().publish(bytes);
        // Undelivered: who needs it will want it, and in the end it is made again.
        let _ = self.0.send(&outgoing);
        digest
    }
}

impl Shared {
    fn core(&self) -> MutexGuard<'_, WorkerCore> {
        self.core.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until `take` finds something, or the run is over.
    fn wait_for<T>(&self, mut take: impl FnMut(&mut WorkerCore) -> Option<T>) -> Result<Option<T>, ServeFault> {
        let mut core = self.core();
        loop {
            if let Some(fault) = self.broken.lock().unwrap_or_else(PoisonError::into_inner).as_ref() {
                return Err(ServeFault::Transport(fault.to_string()));
            }
            if core.is_over() {
                return Ok(None);
            }
            if let Some(found) = take(&mut core) {
                return Ok(Some(found));
            }
            core = self.changed.wait_timeout(core, TICK).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    fn change(&self, change: impl FnOnce(&mut WorkerCore)) -> Result<(), ServeFault> {
        let outgoing = {
            let mut core = self.core();
            change(&mut core);
            core.take_outgoing()
        };
        outgoing
            .iter()
            .try_for_each(|message| self.send(message))
            .map_err(|fault| ServeFault::Transport(fault.to_string()))
    }

    /// Sends; a reader without room is no fault: what it misses is offered or wanted again.
    fn send(&self, outgoing: &Outgoing) -> Result<(), BusFault> {
        let sent = self.work.lock().unwrap_or_else(PoisonError::into_inner).send(outgoing);
        match sent {
            Err(SendError::Bus(fault @ BusFault::Broken(_))) => Err(fault),
            Ok(()) | Err(_) => Ok(()),
        }
    }

    fn tend(&self, mut receiver: Receiver, mut pulse: Sender) {
        let ended = self.tend_until_left(&mut receiver, &mut pulse);
        if let Err(fault) = ended {
            *self.broken.lock().unwrap_or_else(PoisonError::into_inner) = Some(fault);
            self.core().end();
            self.changed.notify_all();
        }
        if !self.crashed.load(Ordering::Relaxed) {
            let _ = pulse.send(&Outgoing::plain(Topic::Presence, Message::Farewell));
        }
    }

    fn tend_until_left(&self, receiver: &mut Receiver, pulse: &mut Sender) -> Result<(), BusFault> {
        let mut next_beat = Duration::ZERO;
        while !self.left.load(Ordering::Acquire) {
            let outgoing = self.drain(receiver)?;
            self.changed.notify_all();
            for message in outgoing {
                match message.topic {
                    Topic::Presence => drop(pulse.send(&message)),
                    _ => self.send(&message)?,
                }
            }
            let now = self.clock.now();
            if now >= next_beat {
                next_beat = now + HEARTBEAT;
                let beat = self.core().heartbeat();
                let _ = pulse.send(&beat);
            }
            receiver.wait(TICK)?;
        }
        Ok(())
    }

    fn drain(&self, receiver: &mut Receiver) -> Result<Vec<Outgoing>, BusFault> {
        let mut outgoing = Vec::new();
        while let Some(incoming) = receiver.receive()? {
            let mut core = self.core();
            core.hear(incoming);
            outgoing.extend(core.take_outgoing());
        }
        let mut core = self.core();
        if self.stop.load(Ordering::Relaxed) {
            core.end();
        }
        outgoing.extend(core.take_outgoing());
        Ok(outgoing)
    }
}
