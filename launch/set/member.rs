//! What stage processes and the refiner process have in common.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use bus::{Bus as _, BusFault, CONTRACT_VERSION, Connection, Hello, Iceoryx2, Iceoryx2Place, MemberId, Role, RunKey};
use clap::Args;
use contract::ServeFault;
use model::RobotId;
use nix::sys::signal::Signal;

use super::run_folder;

/// Time between being told to stop and being stopped.
const GRACE: Duration = Duration::from_secs(1);
/// The parent and the wish to stop are looked at this often.
const WATCH: Duration = Duration::from_millis(50);
/// Exit code of a process that did not stop by itself when it was told to.
const STOPPED: i32 = 143;

/// Arguments that the supervisor gives to every process of a run, whatever program it is.
#[derive(Args, Clone, Debug)]
pub struct MemberArgs {
    /// Run.
    #[arg(long, value_name = "ID")]
    pub run: String,
    /// Number of this process in the run.
    #[arg(long)]
    pub member: u32,
    /// Name for people.
    #[arg(long)]
    pub name: String,
    /// Number of the robot whose jobs it is there for.
    #[arg(long)]
    pub robot: Option<u32>,
    /// Process of the supervisor, without which this one ends.
    #[arg(long, value_name = "PID")]
    pub parent: Option<i32>,
}

impl MemberArgs {
    /// The arguments as words.
    #[must_use]
    pub fn words(&self) -> Vec<String> {
        let mut words = vec!["--run".to_owned(), self.run.clone(), "--member".to_owned(), self.member.to_string()];
        words.extend(["--name".to_owned(), self.name.clone()]);
        words.extend(self.robot.iter().flat_map(|robot| ["--robot".to_owned(), robot.to_string()]));
        words.extend(self.parent.iter().flat_map(|parent| ["--parent".to_owned(), parent.to_string()]));
        words
    }
}

/// Why a process of a run failed.
#[derive(Debug, thiserror::Error)]
pub enum MemberFault {
    /// There is no such run, or it cannot be joined.
    #[error("run {run} cannot be joined: {source}")]
    NoRun {
        /// Run.
        run: String,
        /// Why.
        source: io::Error,
    },
    /// The bus has failed.
    #[error(transparent)]
    Bus(#[from] BusFault),
    /// The bus has failed at work.
    #[error(transparent)]
    Serve(#[from] ServeFault),
    /// The stage cannot be set up for the problem.
    #[error("{0}")]
    Stage(String),
}

/// A process in a run.
pub struct Membership {
    args: MemberArgs,
    place: Iceoryx2Place,
    /// Set when it is to end.
    pub stop: Arc<AtomicBool>,
}

impl Membership {
    /// To be called first thing: from here on the process ends when it is told to, and when its supervisor is gone.
    ///
    /// # Errors
    /// [`MemberFault::NoRun`].
    pub fn begin(args: &MemberArgs) -> Result<Self, MemberFault> {
        let failed = |source: io::Error| MemberFault::NoRun { run: args.run.clone(), source };
        let stop = Arc::new(AtomicBool::new(false));
        for signal in [signal_hook::consts::SIGTERM, signal_hook::consts::SIGINT] {
            signal_hook::flag::register(signal, stop.clone()).map_err(failed)?;
        }
        if args.parent.is_some() {
            nix::sys::prctl::set_pdeathsig(Signal::SIGTERM).map_err(|error| failed(error.into()))?;
        }
        watch(args.parent, stop.clone()).map_err(failed)?;
        let place = run_folder::find(&args.run).map_err(failed)?;
        Ok(Self { args: args.clone(), place, stop })
    }

    /// Joins the bus.
    ///
    /// # Errors
    /// [`BusFault::Broken`].
    pub fn join(&self, role: Role) -> Result<Connection, BusFault> {
        Iceoryx2::open(&self.place, &self.args.name)?.join(role, self.id())
    }

    /// Number in the run.
    #[must_use]
    pub fn id(&self) -> MemberId {
        MemberId(self.args.member)
    }

    /// Key of the run.
    #[must_use]
    pub fn run(&self) -> RunKey {
        RunKey::of_name(&self.place.run)
    }

    /// How it introduces itself.
    #[must_use]
    pub fn hello(&self, role: Role, implementation: &str) -> Hello {
        Hello {
            name: self.args.name.clone(),
            role,
            robot: self.args.robot.map(RobotId),
            implementation: implementation.to_owned(),
            contract_version: CONTRACT_VERSION,
            statement: None,
        }
    }
}

/// Ends the process when its parent is gone or it was told to, and does not end by itself.
fn watch(parent: Option<i32>, stop: Arc<AtomicBool>) -> io::Result<()> {
    let is_orphan = move || parent.is_some_and(|parent| nix::unistd::getppid().as_raw() != parent);
    std::thread::Builder::new().name("watch".to_owned()).spawn(move || {
        while !(stop.load(Ordering::Relaxed) || is_orphan()) {
            std::thread::sleep(WATCH);
        }
        stop.store(true, Ordering::Relaxed);
        std::thread::sleep(GRACE);
        std::process::exit(STOPPED);
    })?;
    Ok(())
}
