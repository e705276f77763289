//! Large products, garbage, and supervisors that were killed.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use bus::{Bus as _, Envelope, Iceoryx2, Kind, MemberId, Note, Role, RunKey};
use contract::{Digest, JobId};
use launch::set::SetEvent;
use launch::set::run_folder::{self, RunFolder};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

use crate::fixtures::command;
use crate::set::{ToySet, is_alive, leftovers, reference, reference_with};
use crate::watchdog::Watchdog;

#[test]
fn products_of_many_megabytes_pass_between_processes() {
    let _watchdog = Watchdog::start("large");
    // Each piece has eight megabytes.
    let vertices = 330_000;
    let end = ToySet::new().setting("piece-vertices", &vertices.to_string()).end();
    assert_eq!(end.search.ledger, reference_with(0, vertices));
}

#[test]
fn garbage_on_every_topic_is_counted_and_changes_nothing() {
    let _watchdog = Watchdog::start("garbage");
    let mut run_name = String::new();
    let mut strangers = Vec::new();
    let end = ToySet::new().run(&mut |event| match event {
        SetEvent::Begun { run } => run_name = run,
        SetEvent::Note(Note::Ready { .. }) => {
            let bus = Iceoryx2::open(&run_folder::find(&run_name).unwrap(), "stranger").unwrap();
            for role in Role::all() {
                let mut connection = bus.join(role, MemberId(77)).unwrap();
                for topic in role.writes() {
                    for header in bad_headers(RunKey::of_name(&run_name)) {
                        connection.outbox.send(topic, &header, &[0xff; 24]).unwrap();
                    }
                }
                strangers.push(connection);
            }
        }
        // They stay: what a writer says and leaves before anybody looks is lost.
        SetEvent::Note(Note::Committed(_)) => strangers.iter_mut().for_each(drain),
        _ => {}
    });
    let end = end.unwrap();
    assert_eq!(end.search.ledger, reference(0));
    assert!(end.refused > 0);
}

/// A stranger that reads must not let its room fill up.
fn drain(stranger: &mut bus::Connection) {
    while stranger.inbox.receive().unwrap().is_some() {}
}

fn bad_headers(run: RunKey) -> Vec<Envelope> {
    let body = [0xff; 24];
    let job = Some(JobId(Digest([7; 32])));
    // A shutdown with a body is garbage, too.
    let whole = |kind: Kind, sequence| Envelope::whole(kind as u32, run, job, MemberId(77), sequence, &body);
    let every_kind = Kind::ALL.into_iter().zip(1..).map(|(kind, sequence)| whole(kind, sequence));
    let broken = Envelope { checksum: 0, ..whole(Kind::Started, 100) };
    let stranger = Envelope { run: 0, ..whole(Kind::Started, 101) };
    every_kind.chain([broken, stranger]).collect()
}

/// A supervisor in a process of its own, at work.
struct Supervisor {
    process: Child,
    children: Vec<u32>,
    run: String,
}

fn supervisor_at_work(set: &ToySet) -> Supervisor {
    let log = set.troubles.path().join("log");
    let words = command(&["set", set.troubles.path().to_str().unwrap(), log.to_str().unwrap()]);
    let process =
        Command::new(&words[0]).args(&words[1..]).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let lines = await_ready(&log);
    let children = lines.iter().filter_map(|line| line.strip_prefix("started ")?.parse().ok()).collect();
    let run = format!("mrtamp-{:x}-", process.id());
    Supervisor { process, children, run }
}

fn await_ready(log: &Path) -> Vec<String> {
    loop {
        let lines: Vec<String> = std::fs::read_to_string(log).unwrap_or_default().lines().map(str::to_owned).collect();
        if lines.iter().any(|line| line == "ready") {
            return lines;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn the_processes_of_a_supervisor_that_is_killed_go_with_it_and_the_next_start_sweeps() {
    let _watchdog = Watchdog::start("killed supervisor");
    let set = ToySet::new().setting("labour-placement", "18446744073709551615");
    let Supervisor { mut process, children, run } = supervisor_at_work(&set);
    assert_eq!(children.len(), 6);
    assert!(children.iter().all(|child| is_alive(*child)));
    process.kill().unwrap();
    process.wait().unwrap();
    while children.iter().any(|child| is_alive(*child)) {
        std::thread::sleep(Duration::from_millis(10));
    }
    assert!(!leftovers(std::slice::from_ref(&run)).is_empty(), "nobody has swept yet");
    let next = RunFolder::create().unwrap();
    assert_eq!(leftovers(&[run]), Vec::<String>::new());
    drop(next);
}

#[test]
fn a_supervisor_that_is_told_to_stop_takes_everything_with_it() {
    let _watchdog = Watchdog::start("stopped supervisor");
    let set = ToySet::new().setting("labour-placement", "18446744073709551615");
    let Supervisor { mut process, children, run } = supervisor_at_work(&set);
    kill(Pid::from_raw(process.id() as i32), Signal::SIGTERM).unwrap();
    process.wait().unwrap();
    assert!(children.iter().all(|child| !is_alive(*child)));
    assert_eq!(leftovers(&[run]), Vec::<String>::new());
}
