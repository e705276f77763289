//! Runs that a signal or a limit on time ends: what is known is written, and nothing else is lost or left.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use plan::{Failure, ResultKind, StoppedBy};
use serde_json::Value;

use crate::processes::{children, kill as kill_now, shared_memory_of};
use crate::scene_path;

/// No run of these tests takes this long; one that does hangs.
const WATCHDOG: Duration = Duration::from_secs(120);

/// The corridor in which two robots cannot pass, with so many samples that nobody waits for the end.
fn endless(folder: &Path) {
    let text = std::fs::read_to_string(scene_path("t19b_no_bay")).unwrap();
    let robots = format!("{}/launch/robots", env!("CARGO_MANIFEST_DIR"));
    let (scene, _) = text.split_once("\nlevels:").unwrap();
    let scene = scene.replace("../robots", &robots) + "\nlevels: {highest: 12, expansions: 4000000}\n";
    std::fs::write(folder.join("endless.yaml"), scene).unwrap();
}

fn start(folder: &Path, more: &[&str]) -> Child {
    endless(folder);
    std::fs::create_dir_all(folder.join("out")).unwrap();
    std::fs::write(folder.join("out/plan.json"), "an earlier plan").unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_mrtamp"));
    command.args(["plan", "endless.yaml", "--json", "--out", "out"]).args(more).current_dir(folder);
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Waits for the end; a run that hangs is killed.
fn ended(child: &mut Child) -> ExitStatus {
    let started = Instant::now();
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            return status;
        }
        if started.elapsed() > WATCHDOG {
            kill_now(child.id());
        }
        std::thread::sleep(Duration::from_millis(10));
    }
}

fn failure(folder: &Path) -> Failure {
    plan::read_failure(&std::fs::read(folder.join("out/failure.json")).unwrap()).unwrap()
}

/// What every run that was cut short leaves.
fn assert_cut_short(folder: &Path, status: ExitStatus, said: &str) -> Failure {
    assert_eq!(status.code(), Some(5), "{status}: {said}");
    let failure = failure(folder);
    assert_eq!(failure.result, ResultKind::LimitReached);
    assert!(std::fs::read_to_string(folder.join("out/failure.html")).unwrap().contains("a limit or a signal"));
    assert_eq!(std::fs::read(folder.join("out/plan.json")).unwrap(), b"an earlier plan");
    assert!(said.contains("Kept from an earlier run") && said.contains("What to try"), "{said}");
    failure
}

/// Sends a signal once the search has placed its objects and committed to a first motion.
fn interrupt(signal: Signal, more: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let mut child = start(folder.path(), more);
    let pid = child.id();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let started = Instant::now();
    let is_event = |line: &str, name: &str| {
        let event: Value = serde_json::from_str(line).unwrap();
        event["event"] == name
    };
    // The watchdog of `ended` watches from the signal on; until then every line may take its time.
    let (ended_by_itself, watched) = channel::<()>();
    std::thread::spawn(move || {
        if watched.recv_timeout(WATCHDOG) == Err(RecvTimeoutError::Timeout) {
            kill_now(pid);
        }
    });
    let known = lines.by_ref().map_while(Result::ok).find(|line| is_event(line, "committed"));
    assert!(known.is_some(), "no motion was committed within {:?}", started.elapsed());
    let workers = children(pid);
    assert_eq!(workers.is_empty(), more.contains(&"--in-process"));
    kill(Pid::from_raw(i32::try_from(pid).unwrap()), signal).unwrap();
    let last = lines.map_while(Result::ok).last().unwrap();
    let mut said = String::new();
    std::io::Read::read_to_string(&mut child.stderr.take().unwrap(), &mut said).unwrap();
    let failure = assert_cut_short(folder.path(), ended(&mut child), &said);
    drop(ended_by_itself);
    let result: Value = serde_json::from_str(&last).unwrap();
    assert_eq!((&result["event"], &result["result"]), (&"result".into(), &"limit_reached".into()));
    assert_eq!(failure.stopped_by, Some(StoppedBy::Signal));
    assert!(failure.reached.is_some_and(|reached| reached.candidates >= 1), "{:?}", failure.reached);
    let stages: Vec<&str> = failure.stages.iter().map(|stage| stage.stage.as_str()).collect();
    assert_eq!(stages, ["placement", "transition", "roadmap", "composite"]);
    assert!(failure.stages.iter().all(|stage| stage.jobs > 0));
    for (worker, ..) in workers {
        let stat = std::fs::read_to_string(format!("/proc/{worker}/stat")).unwrap_or_default();
        assert!(!stat.contains("mrtamp"), "{worker} is still there: {stat}");
    }
    assert!(shared_memory_of(pid).is_empty(), "{:?}", shared_memory_of(pid));
}

#[test]
fn an_interrupt_ends_a_run_in_one_process_with_what_is_known() {
    interrupt(Signal::SIGINT, &["--in-process"]);
}

#[test]
fn an_interrupt_ends_a_run_over_processes_with_what_is_known_and_leaves_nothing() {
    interrupt(Signal::SIGINT, &[]);
}

#[test]
fn termination_ends_a_run_like_an_interrupt() {
    interrupt(Signal::SIGTERM, &["--in-process"]);
    interrupt(Signal::SIGTERM, &[]);
}

#[test]
fn a_time_limit_ends_a_run_like_an_interrupt() {
    for more in [&["--in-process"][..], &[]] {
        let folder = tempfile::tempdir().unwrap();
        let mut child = start(folder.path(), &[more, &["--time-limit", "1"]].concat());
        let drained = child.stdout.take().unwrap();
        let reader = std::thread::spawn(move || BufReader::new(drained).lines().map_while(Result::ok).last());
        let status = ended(&mut child);
        let mut said = String::new();
        std::io::Read::read_to_string(&mut child.stderr.take().unwrap(), &mut said).unwrap();
        let failure = assert_cut_short(folder.path(), status, &said);
        assert_eq!(failure.stopped_by, Some(StoppedBy::TimeLimit { seconds: 1.0 }));
        let last: Value = serde_json::from_str(&reader.join().unwrap().unwrap()).unwrap();
        assert_eq!(last["result"], "limit_reached");
        assert!(shared_memory_of(child.id()).is_empty());
    }
}
