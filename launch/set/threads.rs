//! A set as threads of one process: the same search, workers and bus messages, over channels.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use bus::{AskSettings, Bus, CONTRACT_VERSION, Channels, Connection, Hello, Host, HostCore, MemberId, Role, RunKey};
use bus::{SearchEnd, Worker};
use contract::{ProblemStatement, Stage, StageKind, serve};

use super::launch_file::LaunchFile;
use super::member::MemberFault;
use super::policy::Restarts;
use super::refine_process::refine;
use super::seats::{Seat, seats};
use super::{RunFault, Search, SetEnd, SetEvent, SetOptions};

/// Messages and threads are looked at at least this often.
const TICK: Duration = Duration::from_millis(20);

/// Makes the stage of a worker.
pub type MakeStage = dyn Fn(StageKind, &ProblemStatement) -> Result<Box<dyn Stage>, String> + Send + Sync;

/// Runs a statement with the workers of a launch file as threads, until its search is over. A worker that panics is
/// started again like a process that dies.
///
/// # Errors
/// [`RunFault`].
pub fn run_channels(
    statement: ProblemStatement,
    launch: &LaunchFile,
    options: SetOptions<'_>,
    make_stage: Arc<MakeStage>,
    search: Arc<Search<'static>>,
) -> Result<SetEnd, RunFault> {
    let bus = Channels::default();
    let run = RunKey::of_name("threads");
    let seats = seats(launch, &statement.problem);
    let host = Host::new(bus.join(Role::Supervisor, MemberId::SUPERVISOR)?, run, HostCore::new(statement));
    let speculation = launch.speculation;
    let stop = Arc::new(AtomicBool::new(false));
    let parts = Parts { bus, run, make_stage, search, speculation, stop };
    let mut set = Set { parts, host, options, begun: Instant::now(), running: Vec::new(), next_member: 1, restarts: 0 };
    let ended = seats.into_iter().try_for_each(|seat| set.start(seat, Restarts::default()));
    let ended = ended.and_then(|()| set.attend_until_end());
    set.stop();
    ended.and_then(|search| SetEnd::of_host(&set.host, search, set.restarts))
}

/// What a new thread needs.
struct Parts {
    bus: Channels,
    run: RunKey,
    make_stage: Arc<MakeStage>,
    search: Arc<Search<'static>>,
    speculation: usize,
    stop: Arc<AtomicBool>,
}

struct Set<'a> {
    parts: Parts,
    host: Host,
    options: SetOptions<'a>,
    begun: Instant,
    running: Vec<Running>,
    next_member: u32,
    restarts: u32,
}

struct Running {
    seat: Seat,
    member: MemberId,
    thread: JoinHandle<Result<(), MemberFault>>,
    restarts: Restarts,
}

impl Parts {
    fn start(
        &self,
        seat: &Seat,
        member: MemberId,
        time_limit: Option<Duration>,
    ) -> Result<JoinHandle<Result<(), MemberFault>>, RunFault> {
        let connection = self.bus.join(seat.role, member)?;
        let hello = hello(seat);
        let thread = std::thread::Builder::new().name(seat.name.clone());
        let (run, stop) = (self.run, self.stop.clone());
        Ok(match seat.role {
            Role::Worker(kind) => {
                let make = self.make_stage.clone();
                thread.spawn(move || work(connection, run, member, kind, hello, stop, make.as_ref()))?
            }
            Role::Refiner | Role::Supervisor => {
                let settings = AskSettings { speculation: self.speculation, time_limit, stop };
                let search = self.search.clone();
                thread.spawn(move || refine(connection, run, member, hello, settings, search.as_ref()).map(drop))?
            }
        })
    }
}

fn hello(seat: &Seat) -> Hello {
    let implementation = match seat.role {
        Role::Worker(stage) => ProblemStatement::own_implementation(stage),
        Role::Refiner | Role::Supervisor => seat.name.clone(),
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

fn work(
    connection: Connection,
    run: RunKey,
    member: MemberId,
    kind: StageKind,
    hello: Hello,
    stop: Arc<AtomicBool>,
    make: &MakeStage,
) -> Result<(), MemberFault> {
    let mut worker = Worker::join(connection, run, member, kind, hello, stop)?;
    let Some(statement) = worker.statement()? else { return Ok(()) };
    let stage = make(kind, &statement).map_err(MemberFault::Stage)?;
    serve(stage.as_ref(), &mut worker)?;
    Ok(())
}

impl Set<'_> {
    fn start(&mut self, seat: Seat, restarts: Restarts) -> Result<(), RunFault> {
        let member = MemberId(self.next_member);
        self.next_member += 1;
        self.host.core.expect(self.host.now(), member, seat.expected());
        let left = self.options.time_limit.map(|limit| limit.saturating_sub(self.begun.elapsed()));
        let thread = self.parts.start(&seat, member, left)?;
        (self.options.on_event)(SetEvent::Started { name: seat.name.clone(), process: std::process::id() });
        self.running.push(Running { seat, member, thread, restarts });
        Ok(())
    }

    fn attend_until_end(&mut self) -> Result<SearchEnd, RunFault> {
        loop {
            self.host.attend(TICK)?;
            for note in self.host.core.take_notes() {
                (self.options.on_event)(SetEvent::Note(note));
            }
            if let Some(fault) = self.host.core.fault() {
                return Err(fault.clone().into());
            }
            if let Some(end) = self.host.core.take_end() {
                return Ok(end);
            }
            if self.options.stop.load(Ordering::Relaxed) {
                return Err(RunFault::Cancelled);
            }
            while let Some(dead) = self.running.iter().position(|running| running.thread.is_finished()) {
                let dead = self.running.remove(dead);
                self.replace(dead)?;
            }
        }
    }

    fn replace(&mut self, dead: Running) -> Result<(), RunFault> {
        let Running { seat, member, thread, mut restarts } = dead;
        let (succeeded, how) = match thread.join() {
            Ok(Ok(())) => (true, "left".to_owned()),
            Ok(Err(fault)) => (false, fault.to_string()),
            Err(_) => (false, "panicked".to_owned()),
        };
        self.host.drain()?;
        let returns = restarts.allow(seat.policy, succeeded, self.begun.elapsed());
        self.host.core.lose(member, returns);
        self.host.flush()?;
        (self.options.on_event)(SetEvent::Exited { name: seat.name.clone(), how: how.clone(), returns });
        if returns {
            self.restarts += 1;
            self.start(seat, restarts)
        } else if seat.policy.required {
            Err(RunFault::Lost { name: seat.name, how, restarts: restarts.total() })
        } else {
            Ok(())
        }
    }

    fn stop(&mut self) {
        self.parts.stop.store(true, Ordering::Relaxed);
        // Channels cannot fail; whoever misses it sees `stop`.
        let _ = self.host.shut_down();
        for running in self.running.drain(..) {
            // What it had to say in its end has been said on the bus.
            let _ = running.thread.join();
        }
    }
}
