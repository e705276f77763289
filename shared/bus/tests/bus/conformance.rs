//! What every transport has to do. Each test is written once and run for each transport.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::time::Duration;

use bus::{
    Bus, BusFault, CONTRACT_VERSION, Channels, Connection, Envelope, Expected, Garbage, Host, HostCore, Iceoryx2,
    Iceoryx2Place, Incoming, JobOffer, Kind, MemberId, Message, Outgoing, Receiver, Retirement, Role, RunKey, Sender,
    Topic, Worker,
};
use contract::{Digest, Job, JobId, Outcome, ProblemStatement, RandomStream, StageKind, serve};

use crate::set::{Seat, ToySet, hello, seats};
use crate::toy::{ToyStage, toy_statement, whole_log};
use crate::watchdog::Watchdog;

/// A transport under test, with a fresh run.
pub trait Transport {
    fn open() -> Self;
    fn bus(&self) -> Arc<dyn Bus>;
    fn run(&self) -> RunKey {
        RunKey::of_name("conformance")
    }
}

impl Transport for Channels {
    fn open() -> Self {
        // Small parts, so that large messages really are cut.
        Channels::with_part_bytes(100_000)
    }

    fn bus(&self) -> Arc<dyn Bus> {
        Arc::new(self.clone())
    }
}

/// Every member with a node of its own, as if it were a process.
pub struct Shared {
    owner: Iceoryx2,
    place: Iceoryx2Place,
    _root: tempfile::TempDir,
}

struct Nodes(Iceoryx2Place);

impl Bus for Nodes {
    fn join(&self, role: Role, member: MemberId) -> Result<Connection, BusFault> {
        Iceoryx2::open(&self.0, role.name())?.join(role, member)
    }
}

impl Transport for Shared {
    fn open() -> Self {
        let root = tempfile::Builder::new().prefix("mrtamp-test-").tempdir_in("/dev/shm").unwrap();
        let name = root.path().file_name().unwrap().to_str().unwrap().to_owned();
        let place = Iceoryx2Place { root: root.path().to_owned(), prefix: format!("{name}_"), run: name };
        let seats: BTreeMap<Role, usize> = Role::all().into_iter().map(|role| (role, 4)).collect();
        Self { owner: Iceoryx2::create(&place, &seats).unwrap(), place, _root: root }
    }

    fn bus(&self) -> Arc<dyn Bus> {
        Arc::new(Nodes(self.place.clone()))
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        self.owner.clean_up();
        for name in shared_memory_of(&self.place.prefix) {
            std::fs::remove_file(std::path::Path::new("/dev/shm").join(name)).unwrap();
        }
    }
}

fn shared_memory_of(prefix: &str) -> Vec<String> {
    let names = std::fs::read_dir("/dev/shm").unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    names.filter(|name| name.starts_with(prefix)).collect()
}

struct Ends {
    sender: Sender,
    receiver: Receiver,
}

fn join<T: Transport>(transport: &T, role: Role, member: u32) -> Ends {
    let Connection { inbox, outbox, .. } = transport.bus().join(role, MemberId(member)).unwrap();
    Ends {
        sender: Sender::new(outbox, transport.run(), MemberId(member)),
        receiver: Receiver::new(inbox, transport.run()),
    }
}

fn job(number: u64) -> JobId {
    JobId(Digest::of("job", &[&number.to_le_bytes()]))
}

/// Waits for a message that `pick` takes.
fn await_message<T>(receiver: &mut Receiver, mut pick: impl FnMut(Incoming) -> Option<T>) -> T {
    loop {
        while let Some(incoming) = receiver.receive().unwrap() {
            if let Some(found) = pick(incoming) {
                return found;
            }
        }
        receiver.wait(Duration::from_millis(20)).unwrap();
    }
}

pub fn messages_of_one_sender_keep_their_order_and_none_is_lost<T: Transport>() {
    let _watchdog = Watchdog::start("order");
    let transport = T::open();
    let mut reader = join(&transport, Role::Refiner, 1);
    let mut writer = join(&transport, Role::Worker(StageKind::Transition), 2);
    let topic = Topic::Outcome(StageKind::Transition);
    let thread = std::thread::spawn(move || {
        for number in 0..20_000 {
            writer.sender.send(&Outgoing::about(job(number), topic, Message::Started)).unwrap();
        }
        writer
    });
    for number in 0..20_000 {
        let got = await_message(&mut reader.receiver, Some);
        assert_eq!((got.topic, got.sender, got.job), (topic, MemberId(2), Some(job(number))));
    }
    drop(thread.join().unwrap());
    assert_eq!(reader.receiver.garbage().total(), 0);
}

pub fn writers_do_not_disturb_one_another<T: Transport>() {
    let _watchdog = Watchdog::start("writers");
    let transport = T::open();
    let mut reader = join(&transport, Role::Refiner, 1);
    let threads: Vec<_> = (2..6)
        .map(|member| {
            let mut writer = join(&transport, Role::Worker(StageKind::Roadmap), member);
            std::thread::spawn(move || {
                for number in 0..1000 {
                    let started = Outgoing::about(job(number), Topic::Outcome(StageKind::Roadmap), Message::Started);
                    writer.sender.send(&started).unwrap();
                }
                writer
            })
        })
        .collect();
    let mut next = [0_u64; 6];
    for _ in 0..4000 {
        let got = await_message(&mut reader.receiver, Some);
        let next = &mut next[got.sender.0 as usize];
        assert_eq!(got.job, Some(job(*next)));
        *next += 1;
    }
    threads.into_iter().for_each(|thread| drop(thread.join().unwrap()));
}

pub fn large_products_arrive_whole<T: Transport>() {
    let _watchdog = Watchdog::start("large");
    let transport = T::open();
    let mut store = join(&transport, Role::Supervisor, 0);
    let mut later = join(&transport, Role::Worker(StageKind::Composite), 1);
    let mut maker = join(&transport, Role::Worker(StageKind::Roadmap), 2);
    let sizes = [0, 1, 99_999, 100_000, 100_001, 5 << 20, 24 << 20];
    let products: Vec<Arc<[u8]>> =
        sizes.iter().map(|size| (0..*size).map(|i: usize| (i * 31 % 251) as u8).collect()).collect();
    let sent = products.clone();
    let thread = std::thread::spawn(move || {
        for product in sent {
            maker.sender.send(&Outgoing::plain(Topic::Product, Message::Product(product))).unwrap();
        }
        maker
    });
    let reading = products.clone();
    let other = std::thread::spawn(move || {
        for product in &reading {
            let got = await_message(&mut later.receiver, Some);
            assert!(got.message == Message::Product(product.clone()), "{} bytes", product.len());
        }
    });
    for product in &products {
        let got = await_message(&mut store.receiver, Some);
        assert!(got.message == Message::Product(product.clone()), "{} bytes", product.len());
    }
    other.join().unwrap();
    drop(thread.join().unwrap());
}

pub fn messages_larger_than_allowed_are_not_sent<T: Transport>() {
    let transport = T::open();
    let mut maker = join(&transport, Role::Worker(StageKind::Roadmap), 2);
    let product: Arc<[u8]> = vec![0; contract::MAX_MESSAGE_BYTES + 1].into();
    assert!(maker.sender.send(&Outgoing::plain(Topic::Product, Message::Product(product))).is_err());
}

pub fn what_was_sent_before_a_reader_looked_arrives<T: Transport>() {
    let _watchdog = Watchdog::start("unlooked");
    let transport = T::open();
    let mut reader = join(&transport, Role::Supervisor, 0);
    let mut writer = join(&transport, Role::Worker(StageKind::Placement), 1);
    for number in 0..5 {
        let topic = Topic::Outcome(StageKind::Placement);
        writer.sender.send(&Outgoing::about(job(number), topic, Message::Started)).unwrap();
    }
    for number in 0..5 {
        assert_eq!(await_message(&mut reader.receiver, Some).job, Some(job(number)));
    }
}

pub fn who_has_left_holds_nobody_up<T: Transport>() {
    let _watchdog = Watchdog::start("left");
    let transport = T::open();
    let mut reader = join(&transport, Role::Supervisor, 0);
    let leaver = join(&transport, Role::Refiner, 1);
    let mut writer = join(&transport, Role::Worker(StageKind::Placement), 2);
    let topic = Topic::Outcome(StageKind::Placement);
    writer.sender.send(&Outgoing::about(job(0), topic, Message::Started)).unwrap();
    drop(leaver);
    let thread = std::thread::spawn(move || {
        for number in 1..3000 {
            writer.sender.send(&Outgoing::about(job(number), topic, Message::Started)).unwrap();
        }
        writer
    });
    for number in 0..3000 {
        assert_eq!(await_message(&mut reader.receiver, Some).job, Some(job(number)));
    }
    drop(thread.join().unwrap());
}

/// A supervisor that runs in a thread until the test is over.
fn hosted<T: Transport>(transport: &T, expected: &[(u32, &Seat)]) -> Hosted {
    let connection = transport.bus().join(Role::Supervisor, MemberId::SUPERVISOR).unwrap();
    let mut host = Host::new(connection, transport.run(), HostCore::new(toy_statement(0)));
    for (member, seat) in expected {
        let (name, role, robot) = (seat.name.clone(), seat.role, seat.robot);
        host.core.expect(host.now(), MemberId(*member), Expected { name, role, robot });
    }
    let over = Arc::new(AtomicBool::new(false));
    let stop = over.clone();
    let thread = std::thread::spawn(move || {
        while !stop.load(Ordering::Relaxed) {
            host.attend(Duration::from_millis(5)).unwrap();
        }
        host
    });
    Hosted { over, thread: Some(thread) }
}

struct Hosted {
    over: Arc<AtomicBool>,
    thread: Option<std::thread::JoinHandle<Host>>,
}

impl Hosted {
    fn end(mut self) -> Host {
        self.over.store(true, Ordering::Relaxed);
        self.thread.take().unwrap().join().unwrap()
    }
}

pub fn late_joiners_get_the_statement<T: Transport>() {
    let _watchdog = Watchdog::start("late");
    let transport = T::open();
    let all = seats();
    let (early, late) = (&all[1], &all[5]);
    let host = hosted(&transport, &[(1, early), (9, late)]);
    let join = |member: u32, seat: &Seat| {
        let connection = transport.bus().join(seat.role, MemberId(member)).unwrap();
        let Role::Worker(stage) = seat.role else { panic!("no worker") };
        Worker::join(connection, transport.run(), MemberId(member), stage, hello(seat), Arc::default()).unwrap()
    };
    let (first, second) = (join(1, early), join(9, late));
    let statement = first.statement().unwrap().unwrap();
    assert_eq!(*second.statement().unwrap().unwrap(), *statement);
    drop(second);
    // The same seat again, long after the statement was published.
    std::thread::sleep(Duration::from_millis(150));
    let again = join(9, late);
    assert_eq!(*again.statement().unwrap().unwrap(), *statement);
    drop((first, again));
    assert_eq!(host.end().garbage().total(), 0);
}

fn toy_job(statement: &ProblemStatement) -> (JobId, Job) {
    let request = contract::PlacementJob { level: 0, first: 0, count: 1, nogoods: Vec::new() };
    let job = Job { request: contract::Request::Placement(request), budget: 1 };
    (job.id(statement), job)
}

pub fn a_job_offered_twice_is_worked_on_once<T: Transport>() {
    let _watchdog = Watchdog::start("twice");
    let transport = T::open();
    let seat = &seats()[1];
    let host = hosted(&transport, &[(1, seat)]);
    let runs = Arc::new(AtomicU32::new(0));
    let counted = runs.clone();
    let (bus, run) = (transport.bus(), transport.run());
    let introduced = hello(seat);
    let thread = std::thread::spawn(move || {
        let connection = bus.join(Role::Worker(StageKind::Placement), MemberId(1)).unwrap();
        let mut worker =
            Worker::join(connection, run, MemberId(1), StageKind::Placement, introduced, Arc::default()).unwrap();
        worker.statement().unwrap().unwrap();
        let trouble = move |_: &Job| {
            counted.fetch_add(1, Ordering::Relaxed);
        };
        let toy = ToyStage { trouble: Box::new(trouble), ..ToyStage::default() };
        serve(&toy, &mut worker).unwrap();
    });
    let mut refiner = join(&transport, Role::Refiner, 2);
    let statement = await_statement_of_all(&mut refiner.receiver);
    let (id, job) = toy_job(&statement);
    let mut outcomes: Vec<Outcome> = Vec::new();
    for number in 1..=3 {
        let offer = JobOffer { number, to: MemberId(1), speculative: false, afresh: false, job: job.clone() };
        let topic = Topic::Offer(StageKind::Placement);
        refiner.sender.send(&Outgoing::about(id, topic, Message::Offer(Box::new(offer)))).unwrap();
        outcomes.push(await_message(&mut refiner.receiver, |got| match got.message {
            Message::Outcome(outcome) if got.job == Some(id) => Some(*outcome),
            _ => None,
        }));
    }
    assert_eq!(runs.load(Ordering::Relaxed), 1);
    assert!(outcomes.iter().all(|outcome| *outcome == outcomes[0]));
    let mut host = host.end();
    host.shut_down().unwrap();
    thread.join().unwrap();
}

/// The statement, once the workers have it as well.
fn await_statement_of_all(receiver: &mut Receiver) -> Arc<ProblemStatement> {
    let (mut statement, mut ready) = (None, false);
    await_message(receiver, |got| {
        match got.message {
            Message::Statement(found) => statement = Some(found),
            Message::Heartbeat(heartbeat) => ready |= heartbeat.hello.statement.is_some(),
            _ => {}
        }
        statement.clone().filter(|_| ready)
    })
}

pub fn garbage_is_refused_with_a_reason_and_does_no_harm<T: Transport>() {
    let _watchdog = Watchdog::start("garbage");
    let transport = T::open();
    let mut reader = join(&transport, Role::Refiner, 1);
    let mut connection = transport.bus().join(Role::Worker(StageKind::Roadmap), MemberId(2)).unwrap();
    let topic = Topic::Outcome(StageKind::Roadmap);
    let good = |body: &[u8]| Envelope::whole(Kind::Started as u32, transport.run(), Some(job(1)), MemberId(2), 1, body);
    let whole = good(&[]);
    let part = Envelope { kind: Kind::Sample as u32, parts: 2, length: 20, ..good(&[7; 10]) };
    let bad = [
        (Garbage::Version, Envelope { contract_version: CONTRACT_VERSION + 1, ..whole }, vec![]),
        (Garbage::Run, Envelope { run: whole.run ^ 1, ..whole }, vec![]),
        (Garbage::Kind, Envelope { kind: 0, ..whole }, vec![]),
        (Garbage::Kind, Envelope { kind: u32::MAX, ..whole }, vec![]),
        (Garbage::Topic, Envelope { kind: Kind::Shutdown as u32, ..whole }, vec![]),
        (Garbage::Damaged, Envelope { checksum: whole.checksum ^ 1, ..whole }, vec![]),
        (Garbage::Damaged, Envelope { length: 5, ..whole }, vec![]),
        (Garbage::Damaged, Envelope { parts: 0, ..whole }, vec![]),
        (Garbage::Damaged, Envelope { reserved: 1, ..whole }, vec![]),
        (Garbage::TooLarge, Envelope { length: u64::MAX, ..whole }, vec![]),
        (Garbage::Torn, Envelope { part: 1, ..part }, vec![7; 10]),
        (Garbage::Body, good(&[1, 2, 3]), vec![1, 2, 3]),
        (Garbage::Body, Envelope { kind: Kind::Sample as u32, ..good(&[9; 40]) }, vec![9; 40]),
    ];
    for ((_, header, body), sequence) in bad.iter().zip(2..) {
        connection.outbox.send(topic, &Envelope { sequence, ..*header }, body).unwrap();
    }
    connection.outbox.send(topic, &whole, &[]).unwrap();
    assert_eq!(await_message(&mut reader.receiver, Some).message, Message::Started);
    for reason in bad.iter().map(|(reason, ..)| *reason) {
        let expected = bad.iter().filter(|(other, ..)| *other == reason).count() as u64;
        assert_eq!(reader.receiver.garbage().of(reason), expected, "{reason:?}");
    }
}

pub fn random_garbage_on_every_topic_harms_nobody<T: Transport>() {
    let _watchdog = Watchdog::start("random garbage");
    for seed in 0..3 {
        let transport = T::open();
        let seat = &seats()[1];
        let host = hosted(&transport, &[(1, seat)]);
        let connection = transport.bus().join(seat.role, MemberId(1)).unwrap();
        let worker =
            Worker::join(connection, transport.run(), MemberId(1), StageKind::Placement, hello(seat), Arc::default())
                .unwrap();
        worker.statement().unwrap().unwrap();
        let stream = RandomStream::new(seed, StageKind::Placement, &[], "garbage");
        let mut strangers = Vec::new();
        for (role, member) in Role::all().into_iter().zip(20..) {
            let mut connection = transport.bus().join(role, MemberId(member)).unwrap();
            for (topic, index) in role.writes().into_iter().zip(0..) {
                send_garbage(&mut connection, topic, &stream, transport.run(), index);
            }
            // Who leaves before anybody has looked takes what it has said with it.
            strangers.push(connection);
        }
        // The worker still serves.
        let mut refiner = join(&transport, Role::Refiner, 99);
        let (id, job) = toy_job(&worker.statement().unwrap().unwrap());
        let offer = JobOffer { number: 1, to: MemberId(1), speculative: false, afresh: false, job };
        let topic = Topic::Offer(StageKind::Placement);
        refiner.sender.send(&Outgoing::about(id, topic, Message::Offer(Box::new(offer)))).unwrap();
        let thread = std::thread::spawn(move || {
            let mut worker = worker;
            serve(&ToyStage::default(), &mut worker)
        });
        await_message(&mut refiner.receiver, |got| (got.job == Some(id)).then_some(()));
        let mut host = host.end();
        host.shut_down().unwrap();
        thread.join().unwrap().unwrap();
        host.drain().unwrap();
        assert!(host.garbage().total() > 0, "seed {seed}");
    }
}

/// Messages with random headers, with random bodies under true headers, and with a member's numbers that are false.
fn send_garbage(connection: &mut Connection, topic: Topic, stream: &RandomStream, run: RunKey, index: u64) {
    for round in 0..60 {
        let mut values = stream.values(index * 1000 + round);
        let mut byte = || values.next_index(256) as u8;
        let body: Vec<u8> = (0..usize::from(byte())).map(|_| byte()).collect();
        let mut header = [0; Envelope::BYTES];
        header.iter_mut().for_each(|b| *b = byte());
        let random = Envelope::from_bytes(&header);
        let fitting: Vec<Kind> = Kind::ALL.into_iter().filter(|kind| kind.belongs_on(topic)).collect();
        // A true shutdown is no garbage, and neither is a product of any bytes.
        let kind = fitting[round as usize % fitting.len()];
        let header = match kind {
            Kind::Shutdown => random,
            _ if round % 3 == 0 => random,
            _ => Envelope::whole(kind as u32, run, Some(job(round)), MemberId(byte().into()), round, &body),
        };
        connection.outbox.send(topic, &header, &body).unwrap();
    }
}

pub fn retired_jobs_are_dropped_and_those_offered_later_are_not<T: Transport>() {
    let _watchdog = Watchdog::start("retired");
    let transport = T::open();
    let seat = &seats()[1];
    let host = hosted(&transport, &[(1, seat)]);
    let connection = transport.bus().join(seat.role, MemberId(1)).unwrap();
    let worker =
        Worker::join(connection, transport.run(), MemberId(1), StageKind::Placement, hello(seat), Arc::default())
            .unwrap();
    let statement = worker.statement().unwrap().unwrap();
    let mut refiner = join(&transport, Role::Refiner, 2);
    let offered = |first: u32, number: u64| {
        let request = contract::PlacementJob { level: 0, first, count: 1, nogoods: Vec::new() };
        let job = Job { request: contract::Request::Placement(request), budget: 1 };
        let id = job.id(&statement);
        let offer = JobOffer { number, to: MemberId(1), speculative: false, afresh: false, job };
        Outgoing::about(id, Topic::Offer(StageKind::Placement), Message::Offer(Box::new(offer)))
    };
    let (stale, live, later) = (offered(0, 1), offered(1, 2), offered(2, 3));
    // Offers and retirements are different topics: the worker must have seen the one before the other is sent.
    for offer in [&stale, &live, &later] {
        refiner.sender.send(offer).unwrap();
    }
    await_message(&mut refiner.receiver, |got| match got.message {
        Message::Heartbeat(heartbeat) => (heartbeat.held.len() == 3).then_some(()),
        _ => None,
    });
    let retirement = Retirement { number: 2, live: vec![live.job.unwrap()] };
    refiner.sender.send(&Outgoing::plain(Topic::Retirement, Message::Retirement(retirement))).unwrap();
    let declined = await_message(&mut refiner.receiver, |got| match got.message {
        Message::Declined(_) => got.job,
        _ => None,
    });
    assert_eq!(Some(declined), stale.job);
    let thread = std::thread::spawn(move || {
        let mut worker = worker;
        serve(&ToyStage::default(), &mut worker)
    });
    let mut answered = Vec::new();
    while answered.len() < 2 {
        answered.push(await_message(&mut refiner.receiver, |got| match got.message {
            Message::Outcome(_) => got.job,
            _ => None,
        }));
    }
    assert_eq!(answered, [live.job.unwrap(), later.job.unwrap()]);
    let mut host = host.end();
    host.shut_down().unwrap();
    thread.join().unwrap().unwrap();
}

pub fn a_set_of_members_commits_what_direct_calls_commit<T: Transport>() {
    let _watchdog = Watchdog::start("set");
    let transport = T::open();
    let set = ToySet::new(transport.bus(), transport.run());
    let run = set.run();
    let (ledger, end) = whole_log(&toy_statement(0), &mut crate::runs::direct(0));
    assert!(end.as_ref().is_ok_and(Option::is_some), "the toy problem has a plan");
    assert_eq!(run.ledger, ledger);
    assert_eq!(run.end, end);
    assert_eq!(run.search_end.ledger, ledger);
    assert!(run.plan.is_some());
}

macro_rules! conformance {
    ($module:ident, $transport:ty: $($test:ident),* $(,)?) => {
        mod $module {
            $(#[test]
            fn $test() {
                super::$test::<$transport>();
            })*
        }
    };
}

macro_rules! conformance_of {
    ($($module:ident: $transport:ty),*) => {
        $(conformance!(
            $module, $transport:
            messages_of_one_sender_keep_their_order_and_none_is_lost,
            writers_do_not_disturb_one_another,
            large_products_arrive_whole,
            messages_larger_than_allowed_are_not_sent,
            what_was_sent_before_a_reader_looked_arrives,
            who_has_left_holds_nobody_up,
            late_joiners_get_the_statement,
            a_job_offered_twice_is_worked_on_once,
            garbage_is_refused_with_a_reason_and_does_no_harm,
            random_garbage_on_every_topic_harms_nobody,
            retired_jobs_are_dropped_and_those_offered_later_are_not,
            a_set_of_members_commits_what_direct_calls_commit,
        );)*
    };
}

conformance_of!(channels: bus::Channels, iceoryx2: super::Shared);

#[test]
fn members_that_leave_in_order_leave_one_small_file_of_shared_memory() {
    let _watchdog = Watchdog::start("leftovers");
    let transport = Shared::open();
    let run = ToySet::new(transport.bus(), transport.run()).run();
    assert!(run.end.is_ok());
    let root = transport.place.root.clone();
    let place = transport.place.clone();
    let Shared { .. } = &transport;
    assert!(shared_memory_of(&place.prefix).len() > 1, "the owner holds the services");
    drop(transport);
    assert!(!root.exists());
    assert!(shared_memory_of(&place.prefix).is_empty());
}
