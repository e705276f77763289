//! How long the search waits for the answer to a job that costs nothing: over channels, and over iceoryx2.
//!
//! `cargo run --release -p bus --example round_trip`

#![allow(clippy::unwrap_used, reason = "a tool for developers")]

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use bus::{
    AskSettings, Bus, BusAsk, CONTRACT_VERSION, Channels, Expected, Hello, Host, HostCore, Iceoryx2, Iceoryx2Place,
    MemberId, Role, RunKey, Worker,
};
use contract::{AskStages, Job, PlacementJob, Request, StageKind, serve};
use toy::{ToyStage, toy_implementation, toy_statement};

#[path = "../tests/toy/mod.rs"]
#[allow(dead_code, unused_imports, reason = "tests use the rest")]
mod toy;

const ROUNDS: u32 = 5000;

fn main() {
    let channels = Channels::default();
    measure("channels", &|_| Arc::new(channels.clone()) as Arc<dyn Bus>);
    let root = tempfile::Builder::new().prefix("mrtamp-").tempdir_in("/dev/shm").unwrap();
    let run = root.path().file_name().unwrap().to_str().unwrap().to_owned();
    let place = Iceoryx2Place { root: root.path().to_owned(), prefix: format!("{run}_"), run };
    let seats: BTreeMap<Role, usize> = Role::all().into_iter().map(|role| (role, 1)).collect();
    let owner = Arc::new(Iceoryx2::create(&place, &seats).unwrap());
    measure("iceoryx2", &|role| match role {
        Role::Supervisor => owner.clone() as Arc<dyn Bus>,
        _ => Arc::new(Iceoryx2::open(&place, role.name()).unwrap()),
    });
    drop(owner);
    for entry in std::fs::read_dir("/dev/shm").unwrap() {
        let path = entry.unwrap().path();
        if path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(&place.prefix)) {
            std::fs::remove_file(path).unwrap();
        }
    }
}

fn hello(role: Role) -> Hello {
    Hello {
        name: role.name().to_owned(),
        role,
        robot: None,
        implementation: toy_implementation(StageKind::Placement),
        contract_version: CONTRACT_VERSION,
        statement: None,
    }
}

fn measure(name: &str, bus: &dyn Fn(Role) -> Arc<dyn Bus>) {
    let run = RunKey::of_name("round trip");
    let join = |role, member| bus(role).join(role, MemberId(member)).unwrap();
    let mut host = Host::new(join(Role::Supervisor, 0), run, HostCore::new(toy_statement(0)));
    let worker_role = Role::Worker(StageKind::Placement);
    for (member, role) in [(1, Role::Refiner), (2, worker_role)] {
        let expected = Expected { name: role.name().to_owned(), role, robot: None };
        host.core.expect(host.now(), MemberId(member), expected);
    }
    let (refiner, worker) = (join(Role::Refiner, 1), join(worker_role, 2));
    let working = std::thread::spawn(move || {
        let hello = hello(worker_role);
        let mut worker = Worker::join(worker, run, MemberId(2), StageKind::Placement, hello, Arc::default()).unwrap();
        worker.statement().unwrap().unwrap();
        serve(&ToyStage::default(), &mut worker).unwrap();
    });
    let asking = std::thread::spawn(move || {
        let settings = AskSettings { speculation: 0, time_limit: None, stop: Arc::default() };
        let mut ask = BusAsk::join(refiner, run, MemberId(1), hello(Role::Refiner), settings).unwrap().unwrap();
        (0..ROUNDS).map(|first| ask_once(&mut ask, first)).collect::<Vec<Duration>>()
    });
    while !asking.is_finished() {
        host.attend(Duration::from_millis(20)).unwrap();
    }
    let mut times = asking.join().unwrap();
    host.shut_down().unwrap();
    working.join().unwrap();
    times.sort();
    let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize];
    println!("{name:>9}: p50 {:?}, p90 {:?}, p99 {:?} of {ROUNDS} jobs", at(0.5), at(0.9), at(0.99));
}

fn ask_once(ask: &mut BusAsk, first: u32) -> Duration {
    let request = Request::Placement(PlacementJob { level: 0, first, count: 1, nogoods: Vec::new() });
    let begun = Instant::now();
    ask.ask(&[Job { request, budget: 1 }]).unwrap();
    begun.elapsed()
}
