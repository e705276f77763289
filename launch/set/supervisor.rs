//! The supervisor: owns a run, starts its processes, starts them again, and leaves nothing behind.

use std::path::Path;
use std::process::ExitStatus;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::{Duration, Instant};

use bus::{Bus as _, Host, HostCore, Iceoryx2, MemberId, Role, RunKey, SearchEnd};
use contract::ProblemStatement;
use nix::sys::signal::Signal;

use super::child::{ChildProcess, Said};
use super::launch_file::LaunchFile;
use super::member::MemberArgs;
use super::policy::Restarts;
use super::refine_process::RefineArgs;
use super::run_folder::RunFolder;
use super::seats::{Seat, count_by_role, seats};
use super::{RunFault, SetEnd, SetEvent, SetOptions};

/// Messages and processes are looked at at least this often.
const TICK: Duration = Duration::from_millis(20);
/// A process that says nothing for this long is killed: it is stopped, or hangs on the bus.
const SILENCE: Duration = Duration::from_secs(10);
/// Time that processes have to end by themselves.
const GRACE: Duration = Duration::from_millis(1500);
/// Time that the search has to notice its time limit.
const OVERDUE: Duration = Duration::from_secs(10);
/// Lines under way.
const LINES: usize = 4096;

/// Runs a statement with the processes of a launch file until its search is over.
///
/// # Errors
/// [`RunFault`]. Whatever happens, all processes have ended and nothing is left when this returns.
pub fn run_set(statement: ProblemStatement, launch: &LaunchFile, options: SetOptions<'_>) -> Result<SetEnd, RunFault> {
    let folder = RunFolder::create()?;
    let seats = seats(launch, &statement.problem);
    let bus = Iceoryx2::create(&folder.place(), &count_by_role(&seats))?;
    let connection = bus.join(Role::Supervisor, MemberId::SUPERVISOR)?;
    let host = Host::new(connection, RunKey::of_name(folder.name()), HostCore::new(statement));
    let (said, lines) = sync_channel(LINES);
    let mut supervisor = Supervisor {
        speculation: launch.speculation,
        program: std::env::current_exe()?,
        run: folder.name().to_owned(),
        host,
        bus,
        options,
        begun: Instant::now(),
        running: Vec::new(),
        next_member: 1,
        said: Some(said),
        lines,
        restarts: 0,
    };
    (supervisor.options.on_event)(SetEvent::Begun { run: folder.name().to_owned() });
    let ended = supervisor.start_all(seats).and_then(|()| supervisor.attend_until_end());
    supervisor.stop();
    ended.and_then(|search| SetEnd::of_host(&supervisor.host, search, supervisor.restarts))
    // The folder goes last: what is in it proves that somebody still owns what has not been removed yet.
}

struct Supervisor<'a> {
    speculation: usize,
    program: std::path::PathBuf,
    run: String,
    host: Host,
    bus: Iceoryx2,
    options: SetOptions<'a>,
    begun: Instant,
    running: Vec<Running>,
    next_member: u32,
    said: Option<SyncSender<Said>>,
    lines: Receiver<Said>,
    restarts: u32,
}

struct Running {
    seat: Seat,
    member: MemberId,
    process: ChildProcess,
    restarts: Restarts,
}

impl Supervisor<'_> {
    fn start_all(&mut self, seats: Vec<Seat>) -> Result<(), RunFault> {
        seats.into_iter().try_for_each(|seat| self.start(seat, Restarts::default()))
    }

    fn start(&mut self, seat: Seat, restarts: Restarts) -> Result<(), RunFault> {
        let member = MemberId(self.next_member);
        self.next_member += 1;
        let (command, arguments) = self.command_line(&seat, member);
        let Some(said) = self.said.clone() else { return Ok(()) };
        self.host.core.expect(self.host.now(), member, seat.expected());
        let process = ChildProcess::start(&seat.name, &command, &arguments, said).map_err(|source| {
            let program = command.first().cloned().unwrap_or_default();
            RunFault::Spawn { name: seat.name.clone(), program, source }
        })?;
        (self.options.on_event)(SetEvent::Started { name: seat.name.clone(), process: process.id() });
        self.running.push(Running { seat, member, process, restarts });
        Ok(())
    }

    /// Program with its first arguments, and the arguments that belong to the run.
    fn command_line(&self, seat: &Seat, member: MemberId) -> (Vec<String>, Vec<String>) {
        let own = |words: &[&str]| {
            let program = Path::new(&self.program).to_string_lossy().into_owned();
            [program].into_iter().chain(words.iter().map(|word| (*word).to_owned())).collect()
        };
        let args = MemberArgs {
            run: self.run.clone(),
            member: member.0,
            name: seat.name.clone(),
            robot: seat.robot.map(|robot| robot.0),
            parent: i32::try_from(std::process::id()).ok(),
        };
        match seat.role {
            Role::Worker(stage) => {
                let command = seat.command.clone().unwrap_or_else(|| own(&["stage", stage.name()]));
                (command, args.words())
            }
            Role::Refiner | Role::Supervisor => {
                let left = self.options.time_limit.map(|limit| limit.saturating_sub(self.begun.elapsed()));
                let time_limit = left.map(|left| left.as_secs_f64());
                let args = RefineArgs { member: args, speculation: self.speculation, time_limit };
                (seat.command.clone().unwrap_or_else(|| own(&["refine"])), args.words())
            }
        }
    }

    fn attend_until_end(&mut self) -> Result<SearchEnd, RunFault> {
        loop {
            self.host.attend(TICK)?;
            self.tell();
            if let Some(fault) = self.host.core.fault() {
                return Err(fault.clone().into());
            }
            if let Some(end) = self.host.core.take_end() {
                return Ok(end);
            }
            if self.options.stop.load(Ordering::Relaxed) {
                return Err(RunFault::Cancelled);
            }
            if self.options.time_limit.is_some_and(|limit| self.begun.elapsed() > limit + OVERDUE) {
                return Err(RunFault::Overdue);
            }
            for silent in self.host.core.silent(self.host.now(), SILENCE) {
                let hung = self.running.iter().filter(|running| running.member == silent);
                hung.for_each(|running| running.process.signal(Signal::SIGKILL));
            }
            self.replace_dead()?;
        }
    }

    /// Passes on what was said and what has happened.
    fn tell(&mut self) {
        for note in self.host.core.take_notes() {
            (self.options.on_event)(SetEvent::Note(note));
        }
        while let Ok(Said { name, text }) = self.lines.try_recv() {
            (self.options.on_event)(SetEvent::Line { name, text });
        }
    }

    fn replace_dead(&mut self) -> Result<(), RunFault> {
        let mut index = 0;
        while index < self.running.len() {
            match self.running[index].process.ended()? {
                None => index += 1,
                Some(status) => {
                    let dead = self.running.remove(index);
                    self.replace(dead, status)?;
                }
            }
        }
        Ok(())
    }

    fn replace(&mut self, dead: Running, status: ExitStatus) -> Result<(), RunFault> {
        let Running { seat, member, mut restarts, .. } = dead;
        // What it has said and done before its death counts; then what it held is freed.
        self.host.drain()?;
        self.bus.clean_up();
        let returns = restarts.allow(seat.policy, status.success(), self.begun.elapsed());
        self.host.core.lose(member, returns);
        self.host.flush()?;
        self.tell();
        let how = status.to_string();
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

    /// Ends all processes: asks, tells, kills.
    fn stop(&mut self) {
        // Whoever misses it is told by signal.
        let _ = self.host.shut_down();
        self.signal_all(Signal::SIGTERM);
        let killed_at = Instant::now() + GRACE;
        let mut killed = false;
        while self.still_running() {
            if !killed && Instant::now() >= killed_at {
                killed = true;
                self.signal_all(Signal::SIGKILL);
            }
            // Their last words are taken, so that nobody waits for room.
            let _ = self.host.attend(Duration::from_millis(1));
            self.tell();
        }
        self.said = None;
        let patience = Duration::from_millis(200);
        loop {
            match self.lines.recv_timeout(patience) {
                Ok(Said { name, text }) => (self.options.on_event)(SetEvent::Line { name, text }),
                Err(RecvTimeoutError::Disconnected | RecvTimeoutError::Timeout) => return,
            }
        }
    }

    fn signal_all(&self, signal: Signal) {
        self.running.iter().for_each(|running| running.process.signal(signal));
    }

    fn still_running(&mut self) -> bool {
        // A process whose state cannot be told is not waited for.
        self.running.retain_mut(|running| matches!(running.process.ended(), Ok(None)));
        !self.running.is_empty()
    }
}
