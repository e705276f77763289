//! What is told while a plan is being made: bars on a terminal, lines elsewhere, events for programs.

pub mod bars;
pub mod events;
pub mod lines;
pub mod tally;

use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use contract::{Job, LedgerEntry, Outcome, ProblemStatement, StageKind};
use indicatif::ProgressDrawTarget;
use serde::Serialize;
use skeleton::Skeleton;

use crate::stages::BusyTimes;
use bars::Bars;
use events::{Event, Line};
use tally::Tally;

/// What lines of a stage process about its jobs begin with: they are shown only where there are no bars.
pub const ABOUT_A_JOB: &str = "job: ";

/// How progress is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Show {
    /// Not at all.
    Nothing,
    /// A line on stderr for each event of note.
    Lines,
    /// Live bars on stderr.
    Bars,
    /// A JSON object on stdout for each event.
    Events,
}

impl Show {
    /// Events for a program, bars for a user at a terminal, else lines.
    #[must_use]
    pub fn choose(json: bool) -> Self {
        let able = std::env::var_os("TERM").is_none_or(|term| term != "dumb");
        match (json, able && std::io::stderr().is_terminal()) {
            (true, _) => Self::Events,
            (false, true) => Self::Bars,
            (false, false) => Self::Lines,
        }
    }
}

/// A run's clock, its counts, and what is told of it. Clones share them.
#[derive(Clone, Debug)]
pub struct Progress(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    statement: Arc<ProblemStatement>,
    started: Instant,
    show: Show,
    bars: Option<Bars>,
    tally: Mutex<Tally>,
    busy: BusyTimes,
    nobody_reads: AtomicBool,
}

impl Progress {
    /// Progress with one statement.
    #[must_use]
    pub fn new(statement: Arc<ProblemStatement>, show: Show) -> Self {
        let started = Instant::now();
        let modes = Skeleton::of_problem(&statement.problem).map_or(0, |s| s.modes.iter().map(Vec::len).sum());
        let elapsed_s = move || started.elapsed().as_secs_f64();
        let bars = (show == Show::Bars).then(|| Bars::new(ProgressDrawTarget::stderr(), modes, elapsed_s).turning());
        let (tally, busy, nobody_reads) = Default::default();
        let progress = Self(Arc::new(Shared { statement, started, show, bars, tally, busy, nobody_reads }));
        progress.tell(|s| Event::Start { problem: &s.problem.name, seed: s.seed });
        progress.redraw();
        progress
    }

    /// Seconds since the start.
    #[must_use]
    pub fn elapsed_s(&self) -> f64 {
        self.0.started.elapsed().as_secs_f64()
    }

    /// Time that each stage has worked.
    #[must_use]
    pub fn busy(&self) -> &BusyTimes {
        &self.0.busy
    }

    /// What has happened so far.
    pub fn tally(&self) -> MutexGuard<'_, Tally> {
        self.0.tally.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Tells something of note.
    pub fn say(&self, line: &str) {
        let stamped = || format!("{:8.2} s  {line}", self.elapsed_s());
        match (self.0.show, &self.0.bars) {
            (Show::Lines, _) => eprintln!("{}", stamped()),
            (_, Some(bars)) => bars.print(&stamped()),
            (Show::Events, _) => self.tell(|_| Event::Note { words: line }),
            (Show::Nothing | Show::Bars, None) => {}
        }
    }

    /// A job was answered in this process.
    pub fn answered(&self, job: &Job, outcome: &Outcome) {
        self.noted(job.stage(), outcome);
        if self.0.show == Show::Lines {
            let count = self.tally().stage(job.stage()).jobs;
            if let Some(line) = lines::of_job(&self.0.statement.problem, job, outcome, count) {
                self.say(&format!("[{}] {line}", job.stage()));
            }
        }
    }

    /// A job was answered in a process that says itself what there is to say about it.
    pub fn noted(&self, stage: StageKind, outcome: &Outcome) {
        self.tally().answered(stage, outcome);
        if let Some(event) = Event::of_outcome(stage, outcome) {
            self.tell(|_| event);
        }
        self.redraw();
    }

    /// A process has said a line.
    pub fn heard(&self, name: &str, text: &str) {
        match text.strip_prefix(ABOUT_A_JOB) {
            Some(text) if self.0.show == Show::Lines => self.say(&format!("[{name}] {text}")),
            // Bars and events have it already.
            Some(_) => {}
            None => self.say(&format!("[{name}] {text}")),
        }
    }

    /// The search has committed to something.
    pub fn committed(&self, entry: &LedgerEntry) {
        self.tally().committed(entry);
        let shown = match self.0.show {
            Show::Lines => true,
            Show::Bars => lines::is_notable(entry),
            Show::Nothing | Show::Events => false,
        };
        let problem = &self.0.statement.problem;
        if let Some(line) = Some(()).filter(|()| shown).and_then(|()| lines::of_entry(problem, entry)) {
            self.say(&format!("[refiner] {line}"));
        }
        if let Some(event) = Event::of_entry(problem, entry) {
            self.tell(|_| event);
        }
        self.redraw();
    }

    /// The search is over: bars go away.
    pub fn finish(&self) {
        if let Some(bars) = &self.0.bars {
            bars.clear();
        }
    }

    /// Writes a line of JSON, if events are shown.
    pub fn emit(&self, line: &impl Serialize) {
        if self.0.show != Show::Events || self.0.nobody_reads.load(Ordering::Relaxed) {
            return;
        }
        let written = serde_json::to_string(line)
            .map_err(std::io::Error::from)
            .and_then(|line| writeln!(std::io::stdout().lock(), "{line}"));
        if let Err(error) = written {
            // Planning goes on: its files are what counts.
            self.0.nobody_reads.store(true, Ordering::Relaxed);
            eprintln!("no more events are written: {error}");
        }
    }

    fn tell<'a>(&'a self, event: impl FnOnce(&'a ProblemStatement) -> Event<'a>) {
        if self.0.show == Show::Events {
            self.emit(&Line::new(event(&self.0.statement), self.elapsed_s()));
        }
    }

    fn redraw(&self) {
        if let Some(bars) = &self.0.bars {
            bars.show(&self.tally(), |stage| self.0.busy.seconds(stage));
        }
    }
}
