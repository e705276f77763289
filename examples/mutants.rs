//! Loads many mutants of a problem and its robots' files, plans some that are accepted for a moment, and prints counts:
//! `cargo run --release --example mutants -- [COUNT] [FIRST_SEED] [PLANNED]` (120000, 0, 300). Exit code 1: a panic, or one
//! that took longer than 5 s.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a tool for developers")]

#[path = "../shared/model/tests/support/mod.rs"]
mod support;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use contract::{CompositeMethod, ProblemStatement};
use launch::progress::{Progress, Show};
use model::{FindingKind, Problem, ProblemError, load_problem_with_places};
use support::mutants::{Random, mutant};
use support::{PROBLEM, SRDF, URDF, good};

/// No mutant may take longer.
const AT_MOST: Duration = Duration::from_secs(5);
/// Time for planning one that is accepted.
const PLANNING: Duration = Duration::from_millis(200);

#[derive(Default)]
struct Counts {
    tried: u64,
    behind_parsers: u64,
    accepted: u64,
    colliding: u64,
    planned: u64,
    panics: u64,
    slow: u64,
    slowest: (Duration, u64),
}

impl Counts {
    /// Loads the mutant of one seed; the problem if it is accepted.
    fn load(&mut self, seed: u64) -> Option<Problem> {
        let mut random = Random(seed);
        let path = [PROBLEM, PROBLEM, URDF, SRDF][random.below(4)];
        let mut files = good();
        let text = String::from_utf8_lossy(&files.0[path]).into_owned();
        files.0.insert(path.to_owned(), mutant(&mut random, &text));
        let began = Instant::now();
        let loaded = catch_unwind(|| {
            let loaded = load_problem_with_places(&files, PROBLEM);
            let clear = loaded
                .as_ref()
                .is_ok_and(|(problem, places)| launch::start_check::refuse_collisions(problem, places).is_ok());
            (loaded, clear)
        });
        let took = began.elapsed();
        self.tried += 1;
        self.slowest = self.slowest.max((took, seed));
        self.slow += u64::from(took > AT_MOST);
        let Ok((loaded, clear)) = loaded else {
            println!("mutant {seed} of {path}: a panic");
            self.panics += 1;
            return None;
        };
        self.behind_parsers += u64::from(loaded.as_ref().err().is_none_or(is_behind_parsers));
        self.accepted += u64::from(loaded.is_ok());
        self.colliding += u64::from(loaded.is_ok() && !clear);
        loaded.ok().filter(|_| clear).map(|(problem, _)| problem)
    }

    /// Plans for a moment.
    fn plan(&mut self, seed: u64, problem: Problem) {
        let statement = Arc::new(ProblemStatement::new(problem, seed, CompositeMethod::default()));
        let (progress, never) = (Progress::new(statement.clone(), Show::Nothing), Arc::new(AtomicBool::new(false)));
        let began = Instant::now();
        let run = || drop(launch::in_process::run(&statement, Some(PLANNING), &never, &progress));
        if catch_unwind(AssertUnwindSafe(run)).is_err() {
            println!("mutant {seed}: a panic while planning");
            self.panics += 1;
        }
        if began.elapsed() > AT_MOST {
            println!("mutant {seed}: planned for {:?} with {PLANNING:?} given", began.elapsed());
            self.slow += 1;
        }
        self.planned += 1;
    }
}

fn is_behind_parsers(error: &ProblemError) -> bool {
    error.findings().iter().all(|finding| finding.kind() != FindingKind::Malformed)
}

fn main() -> ExitCode {
    let argument = |index: usize, default: u64| {
        std::env::args()
            .nth(index)
            .map_or(default, |text| text.parse().unwrap_or_else(|_| panic!("{text:?} is no number")))
    };
    let (count, first, planned) = (argument(1, 120_000), argument(2, 0), argument(3, 300));
    let mut counts = Counts::default();
    for seed in first..first + count {
        let accepted = counts.load(seed);
        // Spread over the whole run.
        if let Some(problem) = accepted.filter(|_| counts.planned * count < (seed - first) * planned) {
            counts.plan(seed, problem);
        }
    }
    let percent = |part: u64| 100.0 * part as f64 / counts.tried.max(1) as f64;
    println!("mutants         {}", counts.tried);
    println!("behind parsers  {} ({:.1} %)", counts.behind_parsers, percent(counts.behind_parsers));
    println!(
        "accepted        {} ({:.1} %), of which {} start in collision",
        counts.accepted,
        percent(counts.accepted),
        counts.colliding
    );
    println!("planned         {} for {PLANNING:?} each", counts.planned);
    println!("slowest         {:?} (seed {})", counts.slowest.0, counts.slowest.1);
    println!("panics          {}, longer than {AT_MOST:?} {}", counts.panics, counts.slow);
    ExitCode::from(u8::from(counts.panics + counts.slow > 0))
}
