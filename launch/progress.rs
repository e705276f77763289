//! What is said on stderr while a plan is being made: one line for each event of note.

use std::sync::{Arc, Mutex};
use std::time::Instant;

use contract::{Answer, Decision, Job, LedgerEntry, Outcome, ProblemStatement, Request, StageKind};

/// Lines on stderr. Clones share one clock and one set of counters.
#[derive(Clone, Debug)]
pub struct Progress {
    statement: Arc<ProblemStatement>,
    started: Instant,
    quiet: bool,
    answered: Arc<Mutex<[u64; 4]>>,
}

impl Progress {
    /// Lines about one statement; none if `quiet`.
    #[must_use]
    pub fn new(statement: Arc<ProblemStatement>, quiet: bool) -> Self {
        Self { statement, started: Instant::now(), quiet, answered: Arc::default() }
    }

    /// Seconds since the start.
    #[must_use]
    pub fn elapsed_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// One line.
    pub fn say(&self, line: &str) {
        if !self.quiet {
            eprintln!("{:8.2} s  {line}", self.elapsed_s());
        }
    }

    /// A job was worked on.
    pub fn answered(&self, job: &Job, outcome: &Outcome) {
        if let Some(line) = self.line_of(job, outcome) {
            self.say(&format!("[{}] {line}", job.stage()));
        }
    }

    /// What is worth saying about a job that was worked on.
    #[must_use]
    pub fn line_of(&self, job: &Job, outcome: &Outcome) -> Option<String> {
        let stage = job.stage();
        let count = match self.answered.lock() {
            Ok(mut answered) => {
                answered[stage as usize] += 1;
                answered[stage as usize]
            }
            Err(_) => 0,
        };
        match &outcome.result {
            Err(report) => {
                let cause = report.causes.first().map_or(String::new(), |(cause, _)| crate::words::cause(cause));
                Some(format!("{} failed: {cause}", self.subject(job)))
            }
            Ok(Answer::Placements(_) | Answer::Alternatives(_)) => Some(self.subject(job)),
            Ok(_) if stage == StageKind::Roadmap && count.is_multiple_of(20) => Some(format!("{count} jobs answered")),
            Ok(_) => None,
        }
    }

    /// The search has committed to something.
    pub fn committed(&self, entry: &LedgerEntry) {
        let problem = &self.statement.problem;
        match entry {
            LedgerEntry::Decided(Decision::Level(level)) => self.say(&format!("[refiner] sample level {level}")),
            LedgerEntry::Decided(Decision::Placement(index)) => {
                self.say(&format!("[refiner] placement candidate {index}"));
            }
            LedgerEntry::Decided(Decision::Alternative { pair, index }) => {
                self.say(&format!("[refiner] {} in another way: alternative {index}", problem.pair(*pair).name));
            }
            LedgerEntry::Decided(Decision::Commit(mode)) => {
                self.say(&format!("[refiner] {} is committed", crate::words::mode(problem, *mode)));
            }
            LedgerEntry::Decided(Decision::Order(order)) => {
                let (before, after) = (order.before.describe(problem), order.after.describe(problem));
                let because = crate::words::cause(&order.cause);
                self.say(&format!("[refiner] ordering added: {before} before {after}: {because}"));
            }
            LedgerEntry::Decided(Decision::Drrt) => self.say("[refiner] the composite search takes over"),
            LedgerEntry::Backtrack { stage, because, .. } => {
                let because =
                    because.as_ref().map_or(String::new(), |cause| format!(": {}", crate::words::cause(cause)));
                self.say(&format!("[refiner] back to {stage}{because}"));
            }
            LedgerEntry::Decided(Decision::More { stage, times }) => {
                self.say(&format!("[refiner] {stage} is asked again with {times} times as many samples"));
            }
            LedgerEntry::Stopped { stage } => self.say(&format!("[refiner] {stage} has failed, the run stops")),
            LedgerEntry::LimitReached { work, spent } => {
                self.say(&format!("[refiner] {work} has spent {spent} work units, more than its limit"));
            }
            LedgerEntry::Used { .. } | LedgerEntry::Learnt(_) => {}
            LedgerEntry::Solved { .. } => self.say("[refiner] solved"),
        }
    }

    fn subject(&self, job: &Job) -> String {
        let problem = &self.statement.problem;
        match &job.request {
            Request::Placement(job) => format!("placements from candidate {}", job.first),
            Request::Transition(job) => format!("alternatives for {}", problem.pair(job.pair).name),
            Request::Blockers(job) => format!("objects in the way of {}", problem.robot(job.robot).name),
            Request::Piece(job) => format!("roadmap piece of {}", problem.robot(job.robot).name),
            Request::Mode(job) => format!("roadmap of {}", crate::words::mode(problem, job.mode)),
            Request::Compose(job) => match &job.composition {
                contract::Composition::CommitMode { mode, .. } => {
                    format!("motion of {}", crate::words::mode(problem, *mode))
                }
                contract::Composition::Drrt { .. } => "composite search".to_owned(),
                contract::Composition::Assemble { .. } => "retiming".to_owned(),
            },
        }
    }
}
