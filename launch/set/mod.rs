//! The running of a set: supervisor, stage processes and refiner process; or the same as threads.

pub mod child;
pub mod launch_file;
pub mod member;
pub mod policy;
pub mod refine_process;
pub mod replay;
pub mod run_folder;
pub mod seats;
pub mod stage_process;
pub mod supervisor;
pub mod threads;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use bus::{BusFault, Host, HostFault, Note, SearchEnd};
use contract::{AskStages, Ledger, LedgerEntry, ProblemStatement, ProductRef, encode};
use replay::Replay;

/// A search, as the refiner runs it: statement, whom to ask, whom to tell of every committed entry.
pub type Search<'a> =
    dyn Fn(&ProblemStatement, &mut dyn AskStages, &mut dyn FnMut(&LedgerEntry)) -> Searched + Send + Sync + 'a;

/// What a search leaves.
pub struct Searched {
    /// The committed log.
    pub ledger: Ledger,
    /// How it ended, encoded.
    pub conclusion: Vec<u8>,
    /// Its plan.
    pub plan: Option<ProductRef>,
}

/// How a set is run.
pub struct SetOptions<'a> {
    /// The search is ended after this long.
    pub time_limit: Option<Duration>,
    /// Set by others to end the run.
    pub stop: Arc<AtomicBool>,
    /// Told of everything of note.
    pub on_event: &'a mut dyn FnMut(SetEvent),
}

/// Something of note.
#[derive(Debug)]
pub enum SetEvent {
    /// The run has begun.
    Begun {
        /// Name of the run.
        run: String,
    },
    /// A process was started.
    Started {
        /// Name.
        name: String,
        /// Process.
        process: u32,
    },
    /// A process has ended before the run was over.
    Exited {
        /// Name.
        name: String,
        /// How.
        how: String,
        /// Whether it is started again.
        returns: bool,
    },
    /// A process has said something.
    Line {
        /// Name.
        name: String,
        /// What.
        text: String,
    },
    /// Something happened on the bus.
    Note(Note),
}

/// What a set leaves.
pub struct SetEnd {
    /// The statement with the implementations that ran.
    pub statement: Arc<ProblemStatement>,
    /// The end of the search.
    pub search: SearchEnd,
    /// Bytes of a replay file, if a job killed its workers.
    pub replay: Option<Vec<u8>>,
    /// How often something was started again.
    pub restarts: u32,
    /// Messages refused by the supervisor.
    pub refused: u64,
}

impl SetEnd {
    fn of_host(host: &Host, search: SearchEnd, restarts: u32) -> Result<Self, RunFault> {
        let core = &host.core;
        let never_begun = || BusFault::Broken("the search has ended before it had a statement".to_owned());
        let statement = core.fixed_statement().ok_or_else(never_begun)?;
        let replay = search.poison.as_ref().map(|job| Replay::of_run(&statement, job, core.store()));
        let refused = host.garbage().total() + core.garbage().total();
        Ok(Self { replay: replay.and_then(|replay| encode(&replay).ok()), search, restarts, refused, statement })
    }
}

/// Why a set has no end of its own.
#[derive(Debug, thiserror::Error)]
pub enum RunFault {
    /// The run's folder cannot be made.
    #[error("the run cannot be set up: {0}")]
    Setup(#[from] std::io::Error),
    /// A program cannot be started.
    #[error("{name} cannot be started: {program}: {source}")]
    Spawn {
        /// Name.
        name: String,
        /// Program.
        program: String,
        /// Why.
        source: std::io::Error,
    },
    /// A required process was lost for good.
    #[error("{name} is lost: {how}, after {restarts} restarts")]
    Lost {
        /// Name.
        name: String,
        /// How it ended.
        how: String,
        /// How often it was started again.
        restarts: u32,
    },
    /// The members cannot go on together.
    #[error(transparent)]
    Host(#[from] HostFault),
    /// The bus has failed.
    #[error(transparent)]
    Bus(#[from] BusFault),
    /// The user has ended the run.
    #[error("ended by signal")]
    Cancelled,
    /// The search did not end at its time limit.
    #[error("the search did not end at its time limit")]
    Overdue,
}
