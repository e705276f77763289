//! Members as processes: shared memory by iceoryx2. The only file that names it.
//!
//! Rules that this file keeps, each learnt the hard way: a root folder and a prefix of its own for every run; the
//! supervisor creates every service, with every limit explicit, and holds them; others only open, with retries; no safe
//! overflow; a reader that takes nothing is given up after a while, and dead nodes are cleaned up meanwhile; events are
//! only hints; only the supervisor cleans up, and before it does, it removes what a death has left half made, on which
//! iceoryx2 would wait for ever. One wake-up event for each role, not for each topic: a member waits for one thing, and a process opens
//! few ports.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use ::iceoryx2::node::NodeState;
use ::iceoryx2::port::listener::{Listener, ListenerWaitError};
use ::iceoryx2::port::notifier::Notifier;
use ::iceoryx2::port::publisher::Publisher;
use ::iceoryx2::port::subscriber::Subscriber;
use ::iceoryx2::port::{BackpressureAction, BackpressureInfo, LoanError, SendError};
use ::iceoryx2::prelude::{
    AllocationStrategy, BackpressureStrategy, CallbackProgression, Config, FileName, LogLevel, Node, NodeBuilder,
    NodeName, PortFactory as _, SemanticString as _, ServiceName, SignalHandlingMode, ipc_threadsafe, set_log_level,
};
use ::iceoryx2::service::port_factory::{event, publish_subscribe};

use crate::orphans;
use crate::{Bus, BusFault, Clock, Connection, Envelope, Inbox, MemberId, Outbox, Parcel, RealTime, Role, Topic};

type Ipc = ipc_threadsafe::Service;
/// The envelope as iceoryx2's user header: words, so that it is aligned.
type Header = [u64; Envelope::BYTES / 8];
type Service = publish_subscribe::PortFactory<Ipc, [u8], Header>;
type Wake = event::PortFactory<Ipc>;
type Reader = Subscriber<Ipc, [u8], Header>;

/// Message parts that a reader has room for, of each writer.
const ROOM: usize = 256;
/// The same where parts are large.
const ROOM_FOR_BULK: usize = 64;
/// Size of a part (bytes).
const PART_BYTES: usize = 16 << 10;
/// The same where messages are large.
const BULK_PART_BYTES: usize = 128 << 10;
/// Messages that a reader may look at while others arrive.
const BORROWED: usize = 2;
/// A reader that takes nothing for this long is given up.
const PATIENCE: Duration = Duration::from_secs(5);
/// A reader that was given up gets nothing it has no room for, for this long.
const GIVEN_UP_FOR: Duration = Duration::from_secs(5);
/// Pause between two attempts to deliver.
const RETRY_PAUSE: Duration = Duration::from_micros(100);
/// Dead nodes are looked for this often while a delivery waits.
const CLEAN_AGAIN: Duration = Duration::from_millis(100);
/// Opening is tried for this long: the services may be in the making.
const OPEN_FOR: Duration = Duration::from_secs(3);

/// Where a run's shared memory is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Iceoryx2Place {
    /// Folder for nodes and services, only this run's.
    pub root: PathBuf,
    /// What the names of this run's shared memory begin with.
    pub prefix: String,
    /// Name of the run.
    pub run: String,
}

/// A bus between processes.
pub struct Iceoryx2 {
    shared: Arc<Shared>,
    clock: Arc<RealTime>,
    /// The supervisor holds all services as long as the run lasts.
    held: Option<Held>,
}

struct Held {
    _services: Vec<Service>,
    _wakes: Vec<Wake>,
}

/// What outboxes need to open ports later.
struct Shared {
    node: Mutex<Node<Ipc>>,
    config: Config,
    run: String,
    /// Whether this process cleans up after the dead.
    cleans: bool,
}

impl Iceoryx2 {
    /// Makes the bus of a run: all services, with room for the members that `seats` counts by role.
    ///
    /// # Errors
    /// [`BusFault::Broken`].
    pub fn create(place: &Iceoryx2Place, seats: &BTreeMap<Role, usize>) -> Result<Self, BusFault> {
        let mut bus = Self::join_as_node(place, "supervisor", true)?;
        let node = bus.shared.node();
        // Whoever dies holds its places until it has been cleaned up, and its successor comes meanwhile.
        let places = |takes_part: &dyn Fn(Role) -> bool| {
            2 * seats.iter().filter(|(role, _)| takes_part(**role)).map(|(_, count)| count).sum::<usize>() + 8
        };
        let everybody = places(&|_| true);
        let mut services = Vec::new();
        for topic in Topic::all() {
            let service = node
                .service_builder(&bus.shared.name(&topic.name())?)
                .publish_subscribe::<[u8]>()
                .user_header::<Header>()
                .enable_safe_overflow(false)
                .history_size(0)
                .subscriber_max_buffer_size(if topic.is_bulky() { ROOM_FOR_BULK } else { ROOM })
                .subscriber_max_borrowed_samples(BORROWED)
                .max_subscribers(places(&|role| role.reads().contains(&topic)))
                .max_publishers(everybody)
                .max_nodes(everybody)
                .create()
                .map_err(broken(&format!("topic {}", topic.name())))?;
            services.push(service);
        }
        let mut wakes = Vec::new();
        for role in Role::all() {
            let wake = node
                .service_builder(&bus.shared.wake_name(role)?)
                .event()
                .max_notifiers(everybody)
                .max_listeners(places(&|other| other == role))
                .max_nodes(everybody)
                .event_id_max_value(1)
                .create()
                .map_err(broken("wake-up"))?;
            wakes.push(wake);
        }
        drop(node);
        bus.held = Some(Held { _services: services, _wakes: wakes });
        Ok(bus)
    }

    /// Opens the bus of a run that somebody else has made.
    ///
    /// # Errors
    /// [`BusFault::Broken`].
    pub fn open(place: &Iceoryx2Place, name: &str) -> Result<Self, BusFault> {
        Self::join_as_node(place, name, false)
    }

    fn join_as_node(place: &Iceoryx2Place, name: &str, cleans: bool) -> Result<Self, BusFault> {
        // Faults are values here; what the library prints beside them helps nobody.
        set_log_level(LogLevel::Fatal);
        let config = config(&place.root, &place.prefix)?;
        let node = NodeBuilder::new()
            .name(&NodeName::new(name).map_err(broken("name"))?)
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Ipc>()
            .map_err(broken("node"))?;
        let shared = Arc::new(Shared { node: Mutex::new(node), config, run: place.run.clone(), cleans });
        Ok(Self { shared, clock: Arc::new(RealTime::start()), held: None })
    }

    /// Frees what dead processes hold. To be called after every death.
    pub fn clean_up(&self) {
        clean_up(&self.shared.config);
    }

    /// Whether this is the one that holds the services.
    #[must_use]
    pub fn is_owner(&self) -> bool {
        self.held.is_some()
    }
}

impl Bus for Iceoryx2 {
    fn join(&self, role: Role, _: MemberId) -> Result<Connection, BusFault> {
        let listener = self.shared.open_wake(role)?.listener_builder().create().map_err(broken("listener"))?;
        let mut readers = Vec::new();
        for topic in role.reads() {
            let reader = self.shared.open_topic(topic)?.subscriber_builder().create().map_err(broken("reader"))?;
            readers.push((topic, reader));
        }
        let mut outbox = IpcOutbox::new(self.shared.clone(), true);
        let mut pulse = IpcOutbox::new(self.shared.clone(), false);
        for topic in role.writes() {
            let of_the_pulse = topic == Topic::Presence && role != Role::Supervisor;
            if of_the_pulse { &mut pulse } else { &mut outbox }.writer(topic)?;
        }
        Ok(Connection {
            inbox: Box::new(IpcInbox::new(listener, readers)),
            outbox: Box::new(outbox),
            pulse: Box::new(pulse),
            clock: self.clock.clone() as Arc<dyn Clock>,
        })
    }
}

impl Shared {
    fn node(&self) -> MutexGuard<'_, Node<Ipc>> {
        self.node.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn name(&self, topic: &str) -> Result<ServiceName, BusFault> {
        ServiceName::new(&format!("mrtamp/{}/{topic}", self.run)).map_err(broken("name"))
    }

    fn wake_name(&self, role: Role) -> Result<ServiceName, BusFault> {
        self.name(&format!("wake/{}", role.name()))
    }

    fn open_topic(&self, topic: Topic) -> Result<Service, BusFault> {
        let name = self.name(&topic.name())?;
        retry(|| {
            let node = self.node();
            node.service_builder(&name)
                .publish_subscribe::<[u8]>()
                .user_header::<Header>()
                .enable_safe_overflow(false)
                .open()
                .map_err(broken(&topic.name()))
        })
    }

    fn open_wake(&self, role: Role) -> Result<Wake, BusFault> {
        let name = self.wake_name(role)?;
        retry(|| self.node().service_builder(&name).event().open().map_err(broken("wake-up")))
    }
}

struct IpcInbox {
    listener: Listener<Ipc>,
    readers: Vec<(Topic, Reader)>,
    turn: usize,
    /// The last part from each writer on each topic: a part may be delivered again for the sake of another reader.
    last: BTreeMap<(Topic, u128), Header>,
}

impl IpcInbox {
    fn new(listener: Listener<Ipc>, readers: Vec<(Topic, Reader)>) -> Self {
        Self { listener, readers, turn: 0, last: BTreeMap::new() }
    }
}

impl Inbox for IpcInbox {
    fn receive(&mut self) -> Result<Option<Parcel>, BusFault> {
        let mut empty = 0;
        while empty < self.readers.len() {
            let (topic, reader) = &self.readers[self.turn];
            let Some(sample) = reader.receive().map_err(broken("reading"))? else {
                self.turn = (self.turn + 1) % self.readers.len();
                empty += 1;
                continue;
            };
            let (writer, header) = (sample.header().publisher_id().value(), *sample.user_header());
            if self.last.insert((*topic, writer), header) != Some(header) {
                let part = sample.payload().to_vec();
                return Ok(Some(Parcel { topic: *topic, header: header_bytes(&header), part }));
            }
        }
        Ok(None)
    }

    fn wait(&mut self, longest: Duration) -> Result<(), BusFault> {
        match self.listener.timed_wait(|_| (), longest) {
            // Whoever waits looks at everything afterwards.
            Ok(_) | Err(ListenerWaitError::InterruptSignal) => {}
            Err(_) => std::thread::sleep(longest),
        }
        Ok(())
    }
}

struct IpcOutbox {
    shared: Arc<Shared>,
    waits: bool,
    writers: BTreeMap<Topic, Writer>,
    wakers: BTreeMap<Role, Notifier<Ipc>>,
}

struct Writer {
    service: Service,
    port: Publisher<Ipc, [u8], Header>,
    patience: Option<Arc<Patience>>,
}

impl IpcOutbox {
    fn new(shared: Arc<Shared>, waits: bool) -> Self {
        Self { shared, waits, writers: BTreeMap::new(), wakers: BTreeMap::new() }
    }

    /// The port for a topic, opened when it is first used.
    fn writer(&mut self, topic: Topic) -> Result<&Writer, BusFault> {
        if !self.writers.contains_key(&topic) {
            let writer = self.open_writer(topic)?;
            self.writers.insert(topic, writer);
        }
        self.writers.get(&topic).ok_or(BusFault::Broken(String::new()))
    }

    fn open_writer(&self, topic: Topic) -> Result<Writer, BusFault> {
        let service = self.shared.open_topic(topic)?;
        let builder = service
            .publisher_builder()
            .allocation_strategy(AllocationStrategy::Static)
            .initial_max_slice_len(self.part_bytes(topic))
            .max_loaned_samples(1);
        let cleans = self.shared.cleans.then(|| self.shared.config.clone());
        let patience = self.waits.then(|| Arc::new(Patience::new(cleans)));
        let builder = match patience.clone() {
            Some(patience) => builder
                .backpressure_strategy(BackpressureStrategy::RetryUntilDelivered)
                .set_backpressure_handler(move |info| patience.decide(info)),
            None => builder.backpressure_strategy(BackpressureStrategy::DiscardData),
        };
        let port = builder.create().map_err(broken("writer"))?;
        Ok(Writer { service, port, patience })
    }

    /// Delivers a part once to every reader that has room, or gets room while it waits.
    fn deliver(&mut self, topic: Topic, header: &Header, part: &[u8]) -> Result<Delivered, BusFault> {
        let writer = self.writer(topic)?;
        let mut sample = match writer.port.loan_slice_uninit(part.len()) {
            Ok(sample) => sample,
            Err(LoanError::OutOfMemory) => return Err(BusFault::Undelivered { topic }),
            Err(error) => return Err(broken("writing")(error)),
        };
        *sample.user_header_mut() = *header;
        match sample.write_from_slice(part).send() {
            Ok(readers) if readers >= writer.service.dynamic_config().number_of_subscribers() => Ok(Delivered::ToAll),
            Ok(_) => Ok(Delivered::ToSome),
            // One of the readers has died in the middle of something; the others have got it.
            Err(SendError::ConnectionCorrupted | SendError::UnableToDeliver | SendError::ConnectionError(_)) => {
                Err(BusFault::Undelivered { topic })
            }
            Err(error) => Err(broken("writing")(error)),
        }
    }
}

enum Delivered {
    ToAll,
    ToSome,
}

impl Outbox for IpcOutbox {
    fn send(&mut self, topic: Topic, header: &Envelope, part: &[u8]) -> Result<(), BusFault> {
        let header = header_words(header);
        let begun = Instant::now();
        loop {
            let delivered = self.deliver(topic, &header, part)?;
            let Some(patience) = self.writer(topic)?.patience.clone() else { return Ok(()) };
            if patience.take_given_up() {
                return Err(BusFault::Undelivered { topic });
            }
            if matches!(delivered, Delivered::ToAll) {
                return Ok(());
            }
            // A reader that has joined and not looked since has no room left, and iceoryx2 does not wait for it.
            if !patience.waits_for_unconnected(begun) {
                return Err(BusFault::Undelivered { topic });
            }
            Role::all().into_iter().filter(|role| role.reads().contains(&topic)).for_each(|role| self.wake(role));
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn wake(&mut self, role: Role) {
        if !self.wakers.contains_key(&role)
            && let Ok(service) = self.shared.open_wake(role)
            && let Ok(waker) = service.notifier_builder().create()
        {
            self.wakers.insert(role, waker);
        }
        if let Some(waker) = self.wakers.get(&role) {
            // Only a hint: readers look on a timer, too.
            let _ = waker.notify();
        }
    }

    fn part_bytes(&self, topic: Topic) -> usize {
        if topic.is_bulky() { BULK_PART_BYTES } else { PART_BYTES }
    }
}

/// How long a writer waits for readers that have no room.
struct Patience {
    /// With which dead nodes are cleaned up; none: somebody else does that.
    config: Option<Config>,
    state: Mutex<PatienceState>,
}

struct PatienceState {
    /// Readers that were given up, and until when.
    given_up: BTreeMap<u128, Instant>,
    /// Until when readers that have never looked are not waited for.
    unconnected_until: Option<Instant>,
    /// A reader was given up since the last time of asking.
    fresh: bool,
    cleaned: Instant,
}

impl Patience {
    fn new(config: Option<Config>) -> Self {
        let (given_up, cleaned) = (BTreeMap::new(), Instant::now());
        let state = PatienceState { given_up, unconnected_until: None, fresh: false, cleaned };
        Self { config, state: Mutex::new(state) }
    }

    fn state(&self) -> MutexGuard<'_, PatienceState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What to do about a reader without room.
    fn decide(&self, info: &BackpressureInfo) -> BackpressureAction {
        let now = Instant::now();
        let mut state = self.state();
        let hopeless = state.given_up.get(&info.receiver_port_id).is_some_and(|until| now < *until);
        if hopeless || info.elapsed_time > PATIENCE {
            state.given_up.insert(info.receiver_port_id, now + GIVEN_UP_FOR);
            state.fresh = true;
            return BackpressureAction::DiscardData;
        }
        drop(state);
        self.clean_up(info.elapsed_time);
        std::thread::sleep(RETRY_PAUSE);
        BackpressureAction::Retry
    }

    fn take_given_up(&self) -> bool {
        std::mem::take(&mut self.state().fresh)
    }

    /// Whether to wait on for a reader that has never looked.
    fn waits_for_unconnected(&self, begun: Instant) -> bool {
        let now = Instant::now();
        let mut state = self.state();
        if state.unconnected_until.is_some_and(|until| now < until) {
            return false;
        }
        if now > begun + PATIENCE {
            state.unconnected_until = Some(now + GIVEN_UP_FOR);
            return false;
        }
        drop(state);
        self.clean_up(now - begun);
        true
    }

    /// A reader that takes nothing may be dead.
    fn clean_up(&self, waited: Duration) {
        let Some(config) = self.config.as_ref().filter(|_| waited > CLEAN_AGAIN) else { return };
        let now = Instant::now();
        let mut state = self.state();
        if now > state.cleaned + CLEAN_AGAIN {
            state.cleaned = now;
            drop(state);
            clean_up(config);
        }
    }
}

fn config(root: &Path, prefix: &str) -> Result<Config, BusFault> {
    let mut config = Config::default();
    let root = root.as_os_str().as_encoded_bytes();
    config.global.set_root_path(&::iceoryx2::prelude::Path::new(root).map_err(broken("root"))?);
    config.global.prefix = FileName::new(prefix.as_bytes()).map_err(broken("prefix"))?;
    config.global.creation_timeout = Duration::from_secs(1);
    // The supervisor cleans up, when it knows that somebody has died.
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    config.global.service.cleanup_dead_nodes_on_open = false;
    Ok(config)
}

fn clean_up(config: &Config) {
    orphans::remove_unfinished(&config.global.prefix.to_string());
    // What cannot be cleaned up now is tried again at the next death, and goes with the root in the end.
    let _ = Node::<Ipc>::list(config, |state| {
        if let NodeState::Dead(dead) = state {
            let _ = dead.try_remove_stale_resources();
        }
        CallbackProgression::Continue
    });
}

fn retry<T>(mut open: impl FnMut() -> Result<T, BusFault>) -> Result<T, BusFault> {
    let begun = Instant::now();
    loop {
        match open() {
            Err(_) if begun.elapsed() < OPEN_FOR => std::thread::sleep(Duration::from_millis(5)),
            result => return result,
        }
    }
}

fn broken<E: Display>(what: &str) -> impl Fn(E) -> BusFault {
    move |error| BusFault::Broken(format!("{what}: {error}"))
}

fn header_words(header: &Envelope) -> Header {
    let bytes = header.to_bytes();
    std::array::from_fn(|word| {
        let mut eight = [0; 8];
        eight.copy_from_slice(&bytes[word * 8..word * 8 + 8]);
        u64::from_ne_bytes(eight)
    })
}

fn header_bytes(header: &Header) -> [u8; Envelope::BYTES] {
    let mut bytes = [0; Envelope::BYTES];
    for (eight, word) in bytes.chunks_exact_mut(8).zip(header) {
        eight.copy_from_slice(&word.to_ne_bytes());
    }
    bytes
}
