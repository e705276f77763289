//! Runs that end otherwise than by a plan.

use std::sync::atomic::Ordering;
use std::time::Duration;

use bus::Note;
use contract::{AskFault, StageKind};
use launch::set::{RunFault, SetEvent};

use crate::fixtures::command;
use crate::set::{ToySet, reference, toy_end};
use crate::watchdog::Watchdog;

/// Work that never ends, but can be cancelled.
const ENDLESS: &str = "18446744073709551615";

fn yaml_list(words: &[String]) -> String {
    format!("[{}]", words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(", "))
}

#[test]
fn a_run_that_is_ended_by_signal_leaves_nothing() {
    let _watchdog = Watchdog::start("cancelled");
    let set = ToySet::new().setting("labour-composite", ENDLESS);
    let stop = set.stop.clone();
    let fault = set.run(&mut |event| {
        let composing = matches!(event, SetEvent::Note(Note::Answered { stage: StageKind::Roadmap, .. }));
        stop.fetch_or(composing, Ordering::Relaxed);
    });
    assert!(matches!(fault, Err(RunFault::Cancelled)));
}

#[test]
fn a_time_limit_ends_the_search_with_a_prefix_of_the_reference() {
    let _watchdog = Watchdog::start("limit");
    let set = ToySet { time_limit: Some(Duration::from_secs(2)), ..ToySet::new() };
    let end = set.setting("labour-composite", ENDLESS).end();
    assert_eq!(toy_end(&end), Err(AskFault::TimeLimit));
    let reference = reference(0);
    let entries = &end.search.ledger.entries;
    assert!(entries.len() < reference.entries.len());
    assert_eq!(*entries, reference.entries[..entries.len()]);
}

#[test]
fn a_program_that_does_not_exist_ends_the_run_with_its_name() {
    let _watchdog = Watchdog::start("no program");
    let set = ToySet::with("stages: { transition: { command: [/no/such/program] } }\n");
    let Err(RunFault::Spawn { name, program, .. }) = set.run(&mut |_| ()) else { panic!("no fault") };
    assert_eq!((name.as_str(), program.as_str()), ("transition", "/no/such/program"));
}

#[test]
fn a_required_program_that_fails_again_and_again_ends_the_run() {
    let _watchdog = Watchdog::start("lost");
    let leaves = yaml_list(&command(&["leave", "7"]));
    let set = ToySet::with(&format!("stages: {{ placement: {{ command: {leaves}, max_restarts: 2 }} }}\n"));
    let Err(RunFault::Lost { name, how, restarts }) = set.run(&mut |_| ()) else { panic!("no fault") };
    assert_eq!((name.as_str(), restarts), ("placement", 2));
    assert!(how.contains('7'), "{how}");
}

#[test]
fn a_program_that_leaves_in_good_order_is_not_started_again_on_failure_only() {
    let _watchdog = Watchdog::start("left");
    let leaves = yaml_list(&command(&["leave", "0"]));
    let set = ToySet::with(&format!("stages: {{ placement: {{ command: {leaves} }} }}\n"));
    let Err(RunFault::Lost { restarts, .. }) = set.run(&mut |_| ()) else { panic!("no fault") };
    assert_eq!(restarts, 0);
}

#[test]
fn a_worker_that_is_not_required_may_be_lost_as_long_as_another_is_left() {
    let _watchdog = Watchdog::start("not required");
    let launch = "stages: { transition: { replicas: 2, restart: never, required: false } }\n";
    let set = ToySet::with(launch).trouble("kill-transition");
    let end = set.end();
    assert_eq!((end.restarts, set.troubles_left()), (0, 0));
    assert_eq!(end.search.ledger, reference(0));
    let set = ToySet::with(launch).trouble("kill-transition-1").trouble("kill-transition-2");
    assert_eq!(toy_end(&set.end()), Err(AskFault::NoWorker { stage: StageKind::Transition }));
}

#[test]
fn the_statement_names_what_runs_and_not_what_was_assumed() {
    let _watchdog = Watchdog::start("implementation");
    let end = ToySet::new().trouble("other-composite").end();
    assert_eq!(end.statement.implementation(StageKind::Composite), "other/2");
    assert_eq!(end.statement.implementation(StageKind::Placement), "toy-placement/1");
    assert_ne!(end.search.ledger, reference(0), "another implementation's jobs are other jobs");
    assert!(toy_end(&end).is_ok());
}

#[test]
fn lines_come_with_the_name_of_who_said_them() {
    let _watchdog = Watchdog::start("lines");
    let set = ToySet::new().trouble("say-roadmap-hello from the roadmap");
    let mut names = Vec::new();
    let end = set.run(&mut |event| match event {
        SetEvent::Line { name, text } if text == "hello from the roadmap" => names.push(name),
        _ => {}
    });
    assert!(end.is_ok());
    assert!(names == ["roadmap.r1"] || names == ["roadmap.r2"], "{names:?}");
}
