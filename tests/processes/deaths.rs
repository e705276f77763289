//! Processes that die, stop or panic at work.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use contract::{AskFault, RandomStream, StageKind, decode};
use launch::set::SetEvent;
use launch::set::replay::Replay;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

use crate::set::{ToySet, reference, toy_end};
use crate::toy::toy_statement;
use crate::watchdog::Watchdog;

#[test]
fn a_set_of_processes_commits_what_direct_calls_commit() {
    let _watchdog = Watchdog::start("processes");
    for seed in 0..3 {
        let end = ToySet { seed, ..ToySet::new() }.end();
        assert_eq!(end.search.ledger, reference(seed), "seed {seed}");
        assert_eq!((end.restarts, end.refused), (0, 0));
        assert_eq!(end.search.plan.is_some(), toy_end(&end).unwrap().is_some());
    }
}

#[test]
fn workers_that_are_killed_at_work_are_replaced_and_nothing_is_lost() {
    let _watchdog = Watchdog::start("killed workers");
    for stage in StageKind::ALL {
        let set = ToySet::new().trouble(&format!("kill-{stage}-1")).trouble(&format!("kill-{stage}-2"));
        let end = set.end();
        assert_eq!((end.restarts, set.troubles_left()), (2, 0), "{stage}");
        assert_eq!(end.search.ledger, reference(0), "{stage}");
    }
}

#[test]
fn workers_of_all_stages_may_be_killed_in_one_run() {
    let _watchdog = Watchdog::start("all killed");
    let set = StageKind::ALL.iter().fold(ToySet::new(), |set, stage| set.trouble(&format!("kill-{stage}-1")));
    let set = set.trouble("kill-refiner-at-9.").trouble("panic-composite");
    let end = set.end();
    assert_eq!((end.restarts, set.troubles_left()), (6, 0));
    assert_eq!(end.search.ledger, reference(0));
}

#[test]
fn a_refiner_that_is_killed_is_replaced_by_one_that_reaches_the_same_ledger() {
    let _watchdog = Watchdog::start("killed refiner");
    let reference = reference(0);
    for entry in [0, 7, reference.entries.len() / 2, reference.entries.len() - 1] {
        let set = ToySet::new().trouble(&format!("kill-refiner-at-{entry}."));
        let end = set.end();
        assert_eq!((end.restarts, set.troubles_left()), (1, 0), "killed at entry {entry}");
        assert_eq!(end.search.ledger, reference, "killed at entry {entry}");
    }
}

#[test]
fn a_refiner_that_is_killed_again_and_again_gets_there_all_the_same() {
    let _watchdog = Watchdog::start("killed refiners");
    let set = (0..6).fold(ToySet::new(), |set, time| set.trouble(&format!("kill-refiner-at-{}.", time * 4)));
    let end = set.end();
    assert_eq!((end.restarts, set.troubles_left()), (6, 0));
    assert_eq!(end.search.ledger, reference(0));
}

/// Kills processes of a set at moments of no meaning: while they start, wait, work, write.
struct Killer {
    victims: Arc<Mutex<Vec<u32>>>,
    thread: std::thread::JoinHandle<()>,
}

impl Killer {
    fn start(seed: u64, kills: u64) -> Self {
        let victims: Arc<Mutex<Vec<u32>>> = Arc::default();
        let known = victims.clone();
        let stream = RandomStream::new(seed, StageKind::Placement, &[], "kills");
        let thread = std::thread::spawn(move || {
            for index in 0..kills {
                let [pause, which] = stream.unit(index);
                std::thread::sleep(Duration::from_secs_f64(0.002 + 0.1 * pause));
                let mut known = known.lock().unwrap();
                let victim = (which * known.len() as f64) as usize;
                if victim < known.len() {
                    // It may have ended by itself.
                    let _ = kill(Pid::from_raw(known.swap_remove(victim) as i32), Signal::SIGKILL);
                }
            }
        });
        Self { victims, thread }
    }
}

#[test]
fn processes_may_be_killed_at_any_moment() {
    let _watchdog = Watchdog::start("any moment");
    for seed in 0..4 {
        let policy = "restart: always, max_restarts: 1000";
        let stages = StageKind::ALL.map(|stage| match stage {
            StageKind::Roadmap => format!("{stage}: {{ replicas: per_robot, {policy} }}"),
            _ => format!("{stage}: {{ {policy} }}"),
        });
        let launch = format!("stages: {{ {} }}\nrefiner: {{ {policy} }}\n", stages.join(", "));
        let set = StageKind::ALL
            .iter()
            .fold(ToySet::with(&launch), |set, stage| set.setting(&format!("labour-{stage}"), "20000"));
        let killer = Killer::start(seed, 25);
        let end = set
            .run(&mut |event| match event {
                SetEvent::Started { process, .. } => killer.victims.lock().unwrap().push(process),
                // Nobody is killed whose number may be another's already.
                SetEvent::Note(bus::Note::Committed(contract::LedgerEntry::Solved { .. })) => {
                    killer.victims.lock().unwrap().clear();
                }
                _ => {}
            })
            .unwrap();
        killer.victims.lock().unwrap().clear();
        killer.thread.join().unwrap();
        let reference = reference(0);
        match toy_end(&end) {
            Ok(_) => assert_eq!(end.search.ledger, reference, "seed {seed}"),
            // One and the same job may have had bad luck three times.
            Err(AskFault::PoisonJob { .. }) => {
                let entries = &end.search.ledger.entries;
                assert_eq!(*entries, reference.entries[..entries.len()], "seed {seed}");
            }
            Err(fault) => panic!("seed {seed}: {fault}"),
        }
    }
}

#[test]
fn a_worker_that_panics_is_replaced_and_its_last_words_are_passed_on() {
    let _watchdog = Watchdog::start("panic");
    let set = ToySet::new().trouble("panic-transition");
    let mut said = Vec::new();
    let end = set.run(&mut |event| {
        if let SetEvent::Line { name, text } = event {
            said.push((name, text));
        }
    });
    assert_eq!(end.unwrap().search.ledger, reference(0));
    let last_words = ("transition".to_owned(), "as the test wants it".to_owned());
    assert!(said.contains(&last_words), "{said:?}");
}

#[test]
fn a_worker_that_is_stopped_holds_nobody_up() {
    let _watchdog = Watchdog::start("stopped");
    let set = ToySet::new().trouble("stop-placement");
    let end = set.end();
    // Its job is offered to another worker; if the run lasts long enough, its silence is taken for death, too.
    assert!(end.restarts <= 1 && set.troubles_left() == 0, "{} restarts", end.restarts);
    assert_eq!(end.search.ledger, reference(0));
}

#[test]
fn a_job_that_kills_three_workers_ends_the_search_and_is_kept_with_all_it_reads() {
    let _watchdog = Watchdog::start("poison");
    let set = (0..3).fold(ToySet::with("speculation: 0\n"), |set, time| set.trouble(&format!("kill-composite-{time}")));
    let end = set.end();
    let Err(AskFault::PoisonJob { stage, deaths, replay: _ }) = toy_end(&end) else { panic!("{:?}", toy_end(&end)) };
    assert_eq!((stage, deaths), (StageKind::Composite, 3));
    let reference = reference(0);
    assert_eq!(end.search.ledger.entries, reference.entries[..end.search.ledger.entries.len()]);
    let replay: Replay = decode(&end.replay.unwrap()).unwrap();
    assert_eq!(replay.statement, toy_statement(0));
    let digests: Vec<_> = replay.products.iter().map(|bytes| contract::Digest::of_product(bytes)).collect();
    assert!(!replay.job.products().is_empty());
    assert!(replay.job.products().iter().all(|product| digests.contains(&product.digest)));
}
