//! Asking over a bus: one thread tends the bus, the search runs in another.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use contract::{
    AskFault, AskStages, Foresight, Job, JobId, JobIds, Ledger, LedgerEntry, Outcome, ProblemStatement, ProductRef,
};

use crate::worker::{TICK, statement_digest};
use crate::{
    BacktrackRequest, BusFault, Clock, Committed, Connection, Dispatcher, HEARTBEAT, Heartbeat, Hello, Incoming,
    MemberId, Message, Outgoing, Receiver, RunKey, SearchEnd, SendError, Sender, Topic,
};

/// What the refiner is told at its start.
pub struct AskSettings {
    /// Jobs that may be in work before they are asked for.
    pub speculation: usize,
    /// Time after which asking ends with [`AskFault::TimeLimit`], from joining on.
    pub time_limit: Option<Duration>,
    /// Set by others to end asking with [`AskFault::Cancelled`].
    pub stop: Arc<AtomicBool>,
}

/// [`AskStages`] over a bus.
pub struct BusAsk {
    shared: Arc<Shared>,
    tender: Option<JoinHandle<()>>,
    statement: Arc<ProblemStatement>,
    ids: JobIds,
    deadline: Option<Duration>,
}

struct Shared {
    state: Mutex<State>,
    changed: Condvar,
    clock: Arc<dyn Clock>,
    stop: Arc<AtomicBool>,
    left: AtomicBool,
}

struct State {
    dispatcher: Dispatcher,
    sender: Sender,
    /// The end of the search, repeated until the run is over.
    end: Option<Outgoing>,
    over: bool,
    broken: Option<BusFault>,
    committed: u64,
}

impl BusAsk {
    /// Joins a run: waits for the statement, and takes over what the store has of the run. `None`: the run is over.
    ///
    /// # Errors
    /// [`BusFault::Broken`].
    pub fn join(
        connection: Connection,
        run: RunKey,
        me: MemberId,
        mut hello: Hello,
        settings: AskSettings,
    ) -> Result<Option<Self>, BusFault> {
        let Connection { inbox, outbox, pulse, clock } = connection;
        let mut receiver = Receiver::new(inbox, run);
        let mut pulse = Sender::new(pulse, run, me);
        let begun = clock.now();
        let arrival = Arrival { receiver: &mut receiver, pulse: &mut pulse, clock: &*clock, early: Vec::new() };
        let Some((statement, early)) = arrival.await_statement(&hello, &settings.stop)? else {
            return Ok(None);
        };
        let mut dispatcher = Dispatcher::new(statement.clone(), settings.speculation);
        early.into_iter().for_each(|incoming| dispatcher.hear(clock.now(), incoming));
        hello.statement = Some(statement_digest(&statement));
        let shared = Arc::new(Shared {
            state: Mutex::new(State {
                dispatcher,
                sender: Sender::new(outbox, run, me),
                end: None,
                over: false,
                broken: None,
                committed: 0,
            }),
            changed: Condvar::new(),
            clock,
            stop: settings.stop,
            left: AtomicBool::new(false),
        });
        let tended = shared.clone();
        let tender = std::thread::Builder::new()
            .name("bus".to_owned())
            .spawn(move || tended.tend(receiver, pulse, &hello))
            .map_err(|error| BusFault::Broken(error.to_string()))?;
        let deadline = settings.time_limit.map(|limit| begun + limit);
        let ids = JobIds::new(statement.clone());
        Ok(Some(Self { shared, tender: Some(tender), statement, ids, deadline }))
    }

    /// The statement.
    #[must_use]
    pub fn statement(&self) -> Arc<ProblemStatement> {
        self.statement.clone()
    }

    /// A handle that publishes what the search commits.
    #[must_use]
    pub fn announcer(&self) -> Announcer {
        Announcer(self.shared.clone())
    }

    /// Bytes of a product, from the store or made again.
    ///
    /// # Errors
    /// [`AskFault`].
    pub fn fetch(&mut self, product: ProductRef) -> Result<Arc<[u8]>, AskFault> {
        self.wait_for(|dispatcher| dispatcher.fetch(product), Dispatcher::fetched)
    }

    /// Tells the supervisor how the search ended, again and again until the run is over.
    pub fn conclude(&mut self, ledger: Ledger, conclusion: Vec<u8>, plan: Option<Vec<u8>>) {
        let poison = self.shared.state().dispatcher.poison();
        let end = SearchEnd { ledger, conclusion, plan, poison };
        let end = Outgoing::plain(Topic::Ledger, Message::SearchEnd(Box::new(end)));
        let mut state = self.shared.state();
        state.end = Some(end.clone());
        state.send(&end);
        while !(state.over || state.broken.is_some() || self.shared.stop.load(Ordering::Relaxed)) {
            state = self.shared.wait(state);
        }
    }

    /// Tells the dispatcher to do something, then waits for what comes of it.
    fn wait_for<T>(
        &mut self,
        begin: impl FnOnce(&mut Dispatcher),
        result: impl Fn(&Dispatcher) -> Option<Result<T, AskFault>>,
    ) -> Result<T, AskFault> {
        let mut state = self.shared.state();
        begin(&mut state.dispatcher);
        loop {
            if let Some(result) = result(&state.dispatcher) {
                return result;
            }
            if let Some(fault) = &state.broken {
                return Err(AskFault::Transport(fault.to_string()));
            }
            if state.over || self.shared.stop.load(Ordering::Relaxed) {
                return Err(AskFault::Cancelled);
            }
            let now = self.shared.clock.now();
            if self.deadline.is_some_and(|deadline| now >= deadline) {
                return Err(AskFault::TimeLimit);
            }
            state.dispatcher.tick(now);
            state.flush();
            if result(&state.dispatcher).is_none() {
                state = self.shared.wait(state);
            }
        }
    }
}

impl AskStages for BusAsk {
    fn ask(&mut self, jobs: &[Job]) -> Result<Vec<Outcome>, AskFault> {
        let outcomes = self.wait_for(|dispatcher| dispatcher.ask(jobs), Dispatcher::answer);
        self.shared.state().dispatcher.forget_asked();
        outcomes
    }

    fn foresee(&mut self, foresight: Foresight) {
        self.shared.state().dispatcher.foresee(foresight);
    }

    fn job_id(&self, job: &Job) -> JobId {
        self.ids.of(job).unwrap_or_else(|| job.id(&self.statement))
    }
}

impl Drop for BusAsk {
    fn drop(&mut self) {
        self.shared.left.store(true, Ordering::Relaxed);
        if let Some(tender) = self.tender.take() {
            // A panic of the tender has already been reported by its thread.
            let _ = tender.join();
        }
    }
}

/// Publishes what the search commits.
#[derive(Clone)]
pub struct Announcer(Arc<Shared>);

impl Announcer {
    /// Publishes the next entry of the ledger.
    pub fn committed(&self, entry: &LedgerEntry) {
        let mut state = self.0.state();
        let committed = Committed { index: state.committed, entry: entry.clone() };
        state.committed += 1;
        state.send(&Outgoing::plain(Topic::Ledger, Message::Committed(committed)));
        match entry {
            LedgerEntry::Learnt(nogood) => {
                state.send(&Outgoing::plain(Topic::Nogood, Message::Nogood(nogood.clone())));
            }
            LedgerEntry::Backtrack { stage, decision, because } => {
                let request = BacktrackRequest { stage: *stage, decision: decision.clone(), because: because.clone() };
                state.send(&Outgoing::plain(Topic::Backtrack, Message::Backtrack(request)));
            }
            LedgerEntry::Decided(_)
            | LedgerEntry::Used { .. }
            | LedgerEntry::Solved { .. }
            | LedgerEntry::Stopped { .. }
            | LedgerEntry::LimitReached { .. } => {}
        }
    }
}

impl State {
    fn flush(&mut self) {
        for message in self.dispatcher.take_outgoing() {
            self.send(&message);
        }
    }

    /// Sends; what a reader has no room for is offered again, wanted again or repeated.
    fn send(&mut self, outgoing: &Outgoing) {
        if let Err(SendError::Bus(fault @ BusFault::Broken(_))) = self.sender.send(outgoing) {
            self.broken = Some(fault);
        }
    }
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait<'a>(&self, state: MutexGuard<'a, State>) -> MutexGuard<'a, State> {
        self.changed.wait_timeout(state, TICK).unwrap_or_else(PoisonError::into_inner).0
    }

    fn tend(&self, mut receiver: Receiver, mut pulse: Sender, hello: &Hello) {
        if let Err(fault) = self.tend_until_left(&mut receiver, &mut pulse, hello) {
            self.state().broken = Some(fault);
            self.changed.notify_all();
        }
        let _ = pulse.send(&Outgoing::plain(Topic::Presence, Message::Farewell));
    }

    fn tend_until_left(&self, receiver: &mut Receiver, pulse: &mut Sender, hello: &Hello) -> Result<(), BusFault> {
        let mut next_beat = Duration::ZERO;
        while !self.left.load(Ordering::Relaxed) {
            let now = self.clock.now();
            {
                let mut state = self.state();
                while let Some(incoming) = receiver.receive()? {
                    if incoming.message == Message::Shutdown {
                        state.over = true;
                    }
                    state.dispatcher.hear(now, incoming);
                }
                state.dispatcher.tick(now);
                state.flush();
            }
            self.changed.notify_all();
            if now >= next_beat {
                next_beat = now + HEARTBEAT;
                let heartbeat = Heartbeat { hello: hello.clone(), held: Vec::new(), done: 0 };
                let _ = pulse.send(&Outgoing::plain(Topic::Presence, Message::Heartbeat(heartbeat)));
                let mut state = self.state();
                if let Some(end) = state.end.clone() {
                    state.send(&end);
                }
            }
            receiver.wait(TICK)?;
        }
        Ok(())
    }
}

/// Presence that came before the statement is kept up to this many messages.
const MAX_EARLY: usize = 4096;

/// The statement, and what was said of presence before it came.
type Arrived = (Arc<ProblemStatement>, Vec<Incoming>);

/// A refiner on its way in.
struct Arrival<'a> {
    receiver: &'a mut Receiver,
    pulse: &'a mut Sender,
    clock: &'a dyn Clock,
    early: Vec<Incoming>,
}

impl Arrival<'_> {
    /// Introduces the member until the statement comes. `None`: the run is over before it has begun.
    fn await_statement(mut self, hello: &Hello, stop: &AtomicBool) -> Result<Option<Arrived>, BusFault> {
        let mut next_hello = Duration::ZERO;
        while !stop.load(Ordering::Relaxed) {
            let now = self.clock.now();
            if now >= next_hello {
                next_hello = now + HEARTBEAT;
                let _ = self.pulse.send(&Outgoing::plain(Topic::Presence, Message::Hello(hello.clone())));
            }
            while let Some(incoming) = self.receiver.receive()? {
                match incoming.message {
                    Message::Statement(statement) => return Ok(Some((statement, self.early))),
                    Message::Shutdown => return Ok(None),
                    // Workers may have the statement, and say so, before it is seen here.
                    _ if incoming.topic == Topic::Presence && self.early.len() < MAX_EARLY => self.early.push(incoming),
                    _ => {}
                }
            }
            self.receiver.wait(TICK)?;
        }
        Ok(None)
    }
}
