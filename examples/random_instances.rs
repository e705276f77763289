//! Plans many random problems and prints a table:
//! `cargo run --release --example random_instances -- [SMALL] [LARGE] [FIRST_SEED] [WORK]` (900, 100, 0, 1000000). Those without a
//! plan are listed with their commonest cause. `-- text small|large SEED > launch/scenes/FILE.yaml` writes a problem.

#![allow(clippy::unwrap_used, clippy::panic, clippy::expect_used, reason = "a tool for developers")]

#[allow(dead_code, reason = "tests use the rest")]
#[path = "../tests/ladder/generator.rs"]
mod generator;
#[allow(dead_code, reason = "tests use the rest")]
#[path = "../tests/ladder/run.rs"]
mod run;

use std::time::Instant;

use contract::{AskFault, CompositeMethod};
use generator::Size;
use launch::words;
use plan::ResultKind;
use refiner::End;

/// Outcomes of one size.
#[derive(Default)]
struct Tally {
    solved: u64,
    proven: u64,
    exhausted: u64,
    limited: u64,
    refused: u64,
    faults: u64,
    times_s: Vec<f64>,
}

impl Tally {
    fn add(&mut self, size: Size, seed: u64, limit: u64) {
        let (problem, began) = (generator::problem(size, seed), Instant::now());
        let found = run::run_with(&problem, seed, CompositeMethod::Prioritised, limit, None);
        self.times_s.push(began.elapsed().as_secs_f64());
        if let End::Failed { result, causes, certificate } = &found.end {
            let cause = causes.first().map_or(String::new(), |(cause, _)| words::cause(cause));
            let proof = certificate.as_ref().map_or(cause, words::proof);
            println!("{size:?} {seed}: {result:?} after {} work units: {proof}", found.work);
            if let Some(Err(why)) = certificate.as_ref().map(|certificate| run::verify(&problem, certificate)) {
                println!("{size:?} {seed}: the checker refuses the certificate: {why}");
                self.refused += 1;
            }
        }
        match (&found.end, &found.plan) {
            (End::Solved { .. }, Some(plan)) => match validation::check_plan(&problem, plan) {
                Ok(_) => self.solved += 1,
                Err(violations) => {
                    println!("{size:?} {seed} is refused: {violations:?}");
                    self.refused += 1;
                }
            },
            (End::Failed { result: ResultKind::InfeasibleProven, .. }, _) => self.proven += 1,
            (End::Failed { result: ResultKind::SamplesExhausted, .. }, _) => self.exhausted += 1,
            (End::Failed { result: ResultKind::LimitReached, .. } | End::Fault(AskFault::TimeLimit), _) => {
                self.limited += 1
            }
            (end, _) => {
                println!("{size:?} {seed} ends in a fault: {end:?}");
                self.faults += 1;
            }
        }
    }

    fn print(&mut self, size: Size) {
        self.times_s.sort_by(f64::total_cmp);
        let at =
            |share: f64| self.times_s.get((share * self.times_s.len() as f64) as usize).copied().unwrap_or(f64::NAN);
        println!(
            "{:6} {:>6} {:>7} {:>7} {:>10} {:>8} {:>8} {:>7} {:>9.2} {:>9.2} {:>9.2}",
            format!("{size:?}"),
            self.times_s.len(),
            self.solved,
            self.proven,
            self.exhausted,
            self.limited,
            self.refused,
            self.faults,
            at(0.5),
            at(0.95),
            self.times_s.last().copied().unwrap_or(f64::NAN)
        );
    }
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    if let [mode, size, seed] = &words[..]
        && mode == "text"
    {
        let size = if size == "large" { Size::Large } else { Size::Small };
        return print!("{}", generator::text(size, seed.parse().expect("a seed")));
    }
    let mut numbers = words.iter().map(|word| word.parse().expect("a number"));
    let (small, large) = (numbers.next().unwrap_or(900), numbers.next().unwrap_or(100));
    let first: u64 = numbers.next().unwrap_or(0);
    let limit: u64 = numbers.next().unwrap_or(1_000_000);
    println!("size      runs  solved  proven  exhausted  limited  refused  faults  median s    95 % s     max s");
    for (size, count) in [(Size::Small, small), (Size::Large, large)] {
        let mut tally = Tally::default();
        (first..first + count).for_each(|seed| tally.add(size, seed, limit));
        tally.print(size);
    }
}
