//! The real planner over real processes: the same bytes as the reference mode, whatever runs or dies.

use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use contract::{CompositeMethod, ProblemStatement};
use launch::ending::finished_plan;
use launch::processes::{Members, run};
use launch::progress::{Progress, Show};
use launch::set::launch_file;

use crate::{certified, scene, scene_path};

/// No run of these tests takes this long; one that does hangs.
const WATCHDOG: Duration = Duration::from_secs(180);

const SMALL: [&str; 6] =
    ["t00_one_arm", "t01_one_robot", "t02_far_apart", "t03_relay", "t04_spacious_region", "t05_tiny_region"];

/// Bytes of the reference plan.
fn reference(name: &str, seed: u64) -> Vec<u8> {
    plan::write_plan(&certified(&scene(name), seed, CompositeMethod::Prioritised)).unwrap()
}

/// Starts the program on a scene.
fn start(name: &str, seed: u64, folder: &Path, more: &[&str]) -> Child {
    std::process::Command::new(env!("CARGO_BIN_EXE_mrtamp"))
        .arg("plan")
        .arg(scene_path(name))
        .args(["--seed", &seed.to_string(), "--out", "out"])
        .args(more)
        .current_dir(folder)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Waits for the end of a run; what it said and the plan it wrote.
fn finish(mut child: Child, folder: &Path) -> (String, Vec<u8>) {
    let pid = child.id();
    let watchdog = std::thread::spawn({
        let started = Instant::now();
        move || {
            while started.elapsed() < WATCHDOG && Path::new(&format!("/proc/{pid}")).exists() {
                std::thread::sleep(Duration::from_millis(50));
            }
            if started.elapsed() >= WATCHDOG {
                kill(pid);
            }
        }
    });
    let mut said = String::new();
    std::io::Read::read_to_string(&mut child.stderr.take().unwrap(), &mut said).unwrap();
    let status = child.wait().unwrap();
    watchdog.join().unwrap();
    assert!(status.success(), "{status}: {said}");
    (said, std::fs::read(folder.join("out/plan.json")).unwrap())
}

pub fn kill(pid: u32) {
    let pid = nix::unistd::Pid::from_raw(i32::try_from(pid).unwrap());
    let _ = nix::sys::signal::kill(pid, nix::sys::signal::Signal::SIGKILL);
}

/// Plans with processes in a fresh folder.
fn by_processes(name: &str, seed: u64, more: &[&str]) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    finish(start(name, seed, folder.path(), more), folder.path()).1
}

/// Plans with threads over channels.
fn by_channels(name: &str, seed: u64) -> Vec<u8> {
    let statement = Arc::new(ProblemStatement::new(scene(name), seed, CompositeMethod::Prioritised));
    let progress = Progress::new(statement.clone(), Show::Nothing);
    let stop = Arc::new(AtomicBool::new(false));
    let launch = launch_file::load(None).unwrap();
    let (end, _) = run(&statement, &launch, Members::Threads, Some(WATCHDOG), &stop, &progress).unwrap();
    let plan = finished_plan(&statement, &end.refinement.ledger, &end.plan.unwrap()).unwrap();
    plan::write_plan(&plan).unwrap()
}

fn launch_file_with(folder: &Path, text: &str) -> String {
    let path = folder.join("set.yaml");
    std::fs::write(&path, text).unwrap();
    path.to_string_lossy().into_owned()
}

#[test]
fn small_scenes_have_equal_bytes_by_direct_calls_channels_and_processes() {
    for name in SMALL {
        let expected = reference(name, 0);
        assert!(by_channels(name, 0) == expected, "{name} over channels");
        assert!(by_processes(name, 0, &[]) == expected, "{name} over processes");
    }
}

#[test]
fn plans_in_rounds_have_equal_bytes_by_direct_calls_and_over_processes() {
    for (method, name) in [(CompositeMethod::SyncOpt, "sync-opt"), (CompositeMethod::SyncGreedy, "sync-greedy")] {
        let expected = plan::write_plan(&certified(&scene("t05_tiny_region"), 0, method)).unwrap();
        let again = plan::write_plan(&certified(&scene("t05_tiny_region"), 0, method)).unwrap();
        assert!(again == expected, "{name}");
        assert!(by_processes("t05_tiny_region", 0, &["--composite", name]) == expected, "{name} over processes");
    }
}

#[test]
fn figure_1_has_equal_bytes_over_every_transport_and_with_one_or_three_roadmap_workers() {
    let folder = tempfile::tempdir().unwrap();
    let one = launch_file_with(folder.path(), "stages: {roadmap: {replicas: 1}}\n");
    for seed in 0..5 {
        let expected = reference("figure1", seed);
        assert!(by_channels("figure1", seed) == expected, "seed {seed} over channels");
        assert!(by_processes("figure1", seed, &[]) == expected, "seed {seed} over processes");
        assert!(by_processes("figure1", seed, &["--set", &one]) == expected, "seed {seed} with one roadmap worker");
    }
}

/// Processes whose parent is `parent`: pid, state letter and command line.
pub fn children(parent: u32) -> Vec<(u32, char, String)> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir("/proc").unwrap().flatten() {
        let Ok(pid) = entry.file_name().to_string_lossy().parse::<u32>() else { continue };
        let Ok(stat) = std::fs::read_to_string(entry.path().join("stat")) else { continue };
        let Some((_, rest)) = stat.rsplit_once(')') else { continue };
        let mut words = rest.split_whitespace();
        let state = words.next().and_then(|word| word.chars().next()).unwrap_or('?');
        if words.next() == Some(&parent.to_string()) {
            let line = std::fs::read(entry.path().join("cmdline")).unwrap_or_default();
            found.push((pid, state, String::from_utf8_lossy(&line).replace('\0', " ")));
        }
    }
    found
}

/// Kills the child whose command line contains `role` when it has been seen running `sightings` times.
fn kill_at_work(supervisor: u32, role: &str, sightings: u32) -> bool {
    let (mut seen, started) = (0, Instant::now());
    while started.elapsed() < WATCHDOG && Path::new(&format!("/proc/{supervisor}/exe")).exists() {
        for (pid, state, line) in children(supervisor) {
            if line.contains(role) && state == 'R' {
                seen += 1;
                if seen == sightings {
                    kill(pid);
                    return true;
                }
            }
        }
        std::thread::sleep(Duration::from_micros(300));
    }
    false
}

/// Kills a process of one role five times, each in a run of its own and later than before; every plan must be the same.
/// `later` sightings are added from round to round; a role with little work is killed at the first.
fn survives_kills(role: &str, later: u32) {
    let name = "t04_spacious_region";
    let expected = reference(name, 0);
    for round in 0..5 {
        let folder = tempfile::tempdir().unwrap();
        let child = start(name, 0, folder.path(), &[]);
        let killed = kill_at_work(child.id(), role, 1 + later * round);
        let (said, bytes) = finish(child, folder.path());
        assert!(killed && said.contains("has ended"), "round {round}: {role} was not killed at work\n{said}");
        assert!(bytes == expected, "round {round}: another plan after the death of {role}");
    }
}

#[test]
fn a_killed_placement_process_changes_no_byte() {
    survives_kills("stage placement", 0);
}

#[test]
fn a_killed_transition_process_changes_no_byte() {
    survives_kills("stage transition", 2);
}

#[test]
fn a_killed_roadmap_process_changes_no_byte() {
    survives_kills("stage roadmap", 2);
}

#[test]
fn a_killed_composite_process_changes_no_byte() {
    survives_kills("stage composite", 1);
}

#[test]
fn a_killed_refiner_changes_no_byte() {
    survives_kills(" refine ", 1);
}

/// Shared memory of the run that a supervisor owns: its process number is part of the run's name.
pub fn shared_memory_of(supervisor: u32) -> Vec<PathBuf> {
    let entries = std::fs::read_dir("/dev/shm").into_iter().flatten().flatten();
    let run = format!("mrtamp-{supervisor:x}-");
    entries.map(|entry| entry.path()).filter(|path| path.to_string_lossy().contains(&run)).collect()
}

#[test]
fn when_the_supervisor_is_killed_its_children_are_gone_within_two_seconds_and_the_next_start_sweeps() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = start("figure1", 0, folder.path(), &[]);
    let started = Instant::now();
    let mut workers = Vec::new();
    while workers.len() < 7 {
        assert!(started.elapsed() < WATCHDOG, "the set does not start");
        workers = children(child.id()).into_iter().map(|(pid, ..)| pid).collect();
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(300));
    let of_run = shared_memory_of(child.id());
    kill(child.id());
    child.wait().unwrap();
    let killed = Instant::now();
    let is_alive = |pid: &u32| {
        let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
        stat.rsplit_once(')').is_some_and(|(_, rest)| !rest.trim_start().starts_with(['Z', 'X']))
    };
    while workers.iter().any(is_alive) {
        assert!(killed.elapsed() < Duration::from_secs(2), "children outlive their supervisor");
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(!of_run.is_empty(), "the run had no shared memory to leave behind");
    by_processes("t00_one_arm", 0, &[]);
    let left = shared_memory_of(child.id());
    assert!(left.is_empty(), "the next start left {left:?}");
}

/// Exit code and result of the program on a scene; a run that hangs is ended by its own limit on time.
fn ending(scene: &Path, more: &[&str]) -> (Option<i32>, Vec<u8>) {
    let folder = tempfile::tempdir().unwrap();
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_mrtamp"))
        .arg("plan")
        .arg(scene)
        .args(["--out", "out", "--time-limit", "120"])
        .args(more)
        .current_dir(folder.path())
        .output()
        .unwrap();
    let file = ["plan.json", "failure.json"].map(|name| folder.path().join("out").join(name));
    let file = file.iter().find(|file| file.exists());
    let file = file.unwrap_or_else(|| panic!("{}: {}", scene.display(), String::from_utf8_lossy(&output.stderr)));
    (output.status.code(), std::fs::read(file).unwrap())
}

#[test]
fn every_rung_of_the_ladder_ends_with_the_same_bytes_over_processes_and_without() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("launch/scenes");
    let is_rung = |name: &str| name.starts_with('t') && name[1..].starts_with(|c: char| c.is_ascii_digit());
    let mut rungs: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    rungs.retain(|path| path.file_name().is_some_and(|name| is_rung(&name.to_string_lossy())));
    rungs.sort();
    assert!(rungs.len() >= 29, "{rungs:?}");
    for rung in rungs {
        assert!(ending(&rung, &[]) == ending(&rung, &["--in-process"]), "{}", rung.display());
    }
}
