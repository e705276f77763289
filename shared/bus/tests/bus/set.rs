//! A whole toy set over a bus, as threads: its ledger must be that of direct calls, whatever happens on the way.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use bus::{
    AskSettings, Bus, BusAsk, CONTRACT_VERSION, Expected, Hello, Host, HostCore, MemberId, Role, RunKey, SearchEnd,
    Worker,
};
use contract::{Ledger, Stage, StageKind, serve};
use model::RobotId;

use crate::toy::{ToyEnd, ToyStage, search, toy_implementation, toy_statement};

/// A member of a toy set.
#[derive(Clone)]
pub struct Seat {
    pub name: String,
    pub role: Role,
    pub robot: Option<RobotId>,
}

/// The seats of the toy problem.
pub fn seats() -> Vec<Seat> {
    let seat =
        |name: &str, role, robot: Option<usize>| Seat { name: name.to_owned(), role, robot: robot.map(RobotId::at) };
    vec![
        seat("refiner", Role::Refiner, None),
        seat("placement", Role::Worker(StageKind::Placement), None),
        seat("transition", Role::Worker(StageKind::Transition), None),
        seat("roadmap.r1", Role::Worker(StageKind::Roadmap), Some(0)),
        seat("roadmap.r2", Role::Worker(StageKind::Roadmap), Some(1)),
        seat("composite", Role::Worker(StageKind::Composite), None),
    ]
}

/// How a worker introduces itself.
pub fn hello(seat: &Seat) -> Hello {
    let implementation = match seat.role {
        Role::Worker(stage) => toy_implementation(stage),
        Role::Supervisor | Role::Refiner => "toy/1".to_owned(),
    };
    Hello {
        name: seat.name.clone(),
        role: seat.role,
        robot: seat.robot,
        implementation,
        contract_version: CONTRACT_VERSION,
        statement: None,
    }
}

/// What happens to a set on its way, and what came of it.
pub struct ToySet {
    pub bus: Arc<dyn Bus>,
    pub run: RunKey,
    pub speculation: usize,
    pub seed: u64,
    pub time_limit: Option<Duration>,
    /// Makes the stage of a seat.
    pub stage: Arc<dyn Fn(&Seat) -> ToyStage + Send + Sync>,
    /// Members come back when they have died.
    pub returns: bool,
    /// The first refiner dies when it commits this entry.
    pub refiner_dies_at: Option<u64>,
}

/// What a set has left.
pub struct ToyRun {
    pub ledger: Ledger,
    pub end: ToyEnd,
    pub plan: Option<Vec<u8>>,
    pub deaths: u32,
    pub search_end: SearchEnd,
}

impl ToySet {
    pub fn new(bus: Arc<dyn Bus>, run: RunKey) -> Self {
        let stage = Arc::new(|_: &Seat| ToyStage::default());
        Self { bus, run, speculation: 2, seed: 0, time_limit: None, stage, returns: true, refiner_dies_at: None }
    }

    /// Runs the set to the end of its search.
    pub fn run(&self) -> ToyRun {
        let connection = self.bus.join(Role::Supervisor, MemberId::SUPERVISOR).unwrap();
        let mut host = Host::new(connection, self.run, HostCore::new(toy_statement(self.seed)));
        let end: Arc<std::sync::Mutex<Option<(Ledger, ToyEnd)>>> = Arc::default();
        let mut running: Vec<(MemberId, Seat, JoinHandle<bool>)> = Vec::new();
        let mut next = 1;
        let mut deaths = 0;
        for seat in seats() {
            running.push(self.start(&mut host, &mut next, seat, &end));
        }
        let search_end = loop {
            host.attend(Duration::from_millis(10)).unwrap();
            if let Some(fault) = host.core.fault() {
                panic!("{fault}");
            }
            if let Some(end) = host.core.take_end() {
                break end;
            }
            while let Some(dead) = running.iter().position(|(_, _, thread)| thread.is_finished()) {
                let (member, seat, thread) = running.remove(dead);
                assert!(thread.join().is_err(), "{} left before the end", seat.name);
                deaths += 1;
                host.drain().unwrap();
                host.core.lose(member, self.returns);
                if self.returns {
                    running.push(self.start(&mut host, &mut next, seat, &end));
                }
                host.flush().unwrap();
            }
        };
        host.shut_down().unwrap();
        for (_, seat, thread) in running {
            assert!(thread.join().is_ok(), "{} failed", seat.name);
        }
        let (ledger, end) = end.lock().unwrap().take().unwrap();
        ToyRun { ledger, end, plan: search_end.plan.clone(), deaths, search_end }
    }

    fn start(
        &self,
        host: &mut Host,
        next: &mut u32,
        seat: Seat,
        end: &Arc<std::sync::Mutex<Option<(Ledger, ToyEnd)>>>,
    ) -> (MemberId, Seat, JoinHandle<bool>) {
        let member = MemberId(*next);
        *next += 1;
        host.core.expect(host.now(), member, Expected { name: seat.name.clone(), role: seat.role, robot: seat.robot });
        let connection = self.bus.join(seat.role, member).unwrap();
        let (run, started) = (self.run, seat.clone());
        let thread = match seat.role {
            Role::Worker(stage) => {
                let toy = (self.stage)(&seat);
                std::thread::spawn(move || work(connection, run, member, stage, &started, &toy))
            }
            Role::Refiner | Role::Supervisor => {
                let settings = AskSettings {
                    speculation: self.speculation,
                    time_limit: self.time_limit,
                    stop: Arc::new(AtomicBool::new(false)),
                };
                let end = end.clone();
                // The refiner is the first member.
                let dies_at = self.refiner_dies_at.filter(|_| member == MemberId(1));
                std::thread::spawn(move || refine(connection, run, member, &started, settings, &end, dies_at))
            }
        };
        (member, seat, thread)
    }
}

fn work(
    connection: bus::Connection,
    run: RunKey,
    member: MemberId,
    stage: StageKind,
    seat: &Seat,
    toy: &dyn Stage,
) -> bool {
    let mut worker =
        Worker::join(connection, run, member, stage, hello(seat), Arc::new(AtomicBool::new(false))).unwrap();
    if worker.statement().unwrap().is_some() {
        serve(toy, &mut worker).unwrap();
    }
    true
}

fn refine(
    connection: bus::Connection,
    run: RunKey,
    member: MemberId,
    seat: &Seat,
    settings: AskSettings,
    end: &std::sync::Mutex<Option<(Ledger, ToyEnd)>>,
    dies_at: Option<u64>,
) -> bool {
    let mut ask = BusAsk::join(connection, run, member, hello(seat), settings).unwrap().unwrap();
    let announcer = ask.announcer();
    let statement = ask.statement();
    let mut committed = 0;
    let (ledger, toy_end) = search(&statement, &mut ask, &mut |entry| {
        announcer.committed(entry);
        if dies_at == Some(committed) {
            std::panic::panic_any("killed by the test");
        }
        committed += 1;
    });
    let plan = match &toy_end {
        Ok(Some(plan)) => Some(ask.fetch(*plan).unwrap().to_vec()),
        _ => None,
    };
    *end.lock().unwrap() = Some((ledger.clone(), toy_end));
    ask.conclude(ledger, Vec::new(), plan);
    true
}

/// A stage that kills its thread on the first jobs of one stage, `times` in all.
pub fn mortal(stage: StageKind, times: u32) -> Arc<dyn Fn(&Seat) -> ToyStage + Send + Sync> {
    let left = Arc::new(AtomicU32::new(times));
    Arc::new(move |seat: &Seat| {
        let (left, mortal) = (left.clone(), seat.role == Role::Worker(stage));
        let trouble = move |_: &contract::Job| {
            let one_less = |left: u32| left.checked_sub(1);
            if mortal && left.fetch_update(Ordering::SeqCst, Ordering::SeqCst, one_less).is_ok() {
                std::panic::panic_any("killed by the test");
            }
        };
        ToyStage { trouble: Box::new(trouble), ..ToyStage::default() }
    })
}
