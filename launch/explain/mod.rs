//! Why there is no plan and what to try; why a plan is as it is.

pub mod plan_reasons;
pub mod remedies;

use std::fmt::Write as _;

use model::Problem;
use plan::{Cause, Failure, Reached};

use crate::progress::tally::is_contact;
use crate::words;

/// Causes of each group that are listed.
const LISTED: usize = 6;

/// Why there is no plan, in a user's words: how the search ended, what was tried, what was in the way, what to try.
#[must_use]
pub fn failure_text(problem: &Problem, failure: &Failure) -> String {
    let mut text = format!("{}\n", words::result(failure.result));
    if let Some(stopped_by) = &failure.stopped_by {
        text += &format!("  {}\n", words::stopped_by(stopped_by));
    }
    if let Some(certificate) = &failure.certificate {
        text += &format!("  {}\n", words::proof(certificate));
    }
    let reached = failure.reached.map_or(String::new(), |reached| format!(": {}", reached_words(reached)));
    text += &format!("What was tried{reached}\n");
    for count in &failure.stages {
        // Writing to text cannot fail.
        let _ = writeln!(text, "  {:<10} {:>6} jobs, {:>6} failed", count.stage, count.jobs, count.failures);
    }
    let (contacts, done): (Vec<_>, Vec<_>) = failure.causes.iter().partition(|(cause, _)| is_contact(cause));
    text += &listed("What could not be done, most frequent first", &done);
    text += &listed("What was touched while trying, most frequent first", &contacts);
    let remedies = remedies::of_failure(problem, failure);
    if !remedies.is_empty() {
        text += "What to try\n";
    }
    for remedy in remedies {
        text += &format!("  - {remedy}\n");
    }
    text
}

/// How far a search came.
#[must_use]
pub fn reached_words(reached: Reached) -> String {
    let counted = |count: u32, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
    let mut words =
        format!("up to sample level {}, there {}", reached.level, counted(reached.candidates, "placement candidate"));
    if reached.committed > 0 {
        words += &format!(", {} committed under the last", counted(reached.committed, "mode"));
    }
    words
}

fn listed(heading: &str, causes: &[&(Cause, u64)]) -> String {
    let mut text = if causes.is_empty() { String::new() } else { format!("{heading}\n") };
    for (cause, times) in causes.iter().take(LISTED) {
        let _ = writeln!(text, "  {times:>6} × {}", words::cause(cause));
    }
    if causes.len() > LISTED {
        let _ = writeln!(text, "         and {} more", causes.len() - LISTED);
    }
    text
}
