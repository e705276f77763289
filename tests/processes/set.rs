//! A toy set of processes, and what it leaves.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use contract::{DirectCalls, Ledger, Stage, StageKind, decode};
use launch::set::launch_file::{LaunchFile, parse};
use launch::set::supervisor::run_set;
use launch::set::{RunFault, SetEnd, SetEvent, SetOptions};
use tempfile::TempDir;

use crate::fixtures::command;
use crate::toy::{ToyEnd, ToyStage, toy_statement, whole_log};

/// A launch file (with `text` for what is not default) whose programs are the toy ones.
pub fn toy_launch_file(troubles: &Path, text: &str) -> LaunchFile {
    let mut launch = parse(if text.is_empty() { "{}" } else { text }, "toy").unwrap();
    let troubles = troubles.to_str().unwrap();
    for stage in StageKind::ALL {
        launch.stages.of_mut(stage).command.get_or_insert_with(|| command(&["stage", stage.name(), troubles]));
    }
    launch.refiner.command.get_or_insert_with(|| command(&["refine", troubles]));
    launch
}

/// A toy set with a folder of troubles.
pub struct ToySet {
    pub troubles: TempDir,
    pub launch: String,
    pub seed: u64,
    pub time_limit: Option<Duration>,
    pub stop: Arc<AtomicBool>,
}

impl ToySet {
    pub fn new() -> Self {
        let troubles = tempfile::tempdir().unwrap();
        Self { troubles, launch: String::new(), seed: 0, time_limit: None, stop: Arc::default() }
    }

    /// With the non-default parts of a launch file.
    pub fn with(launch: &str) -> Self {
        Self { launch: launch.to_owned(), ..Self::new() }
    }

    /// Puts a trouble in the way.
    pub fn trouble(self, name: &str) -> Self {
        self.setting(name, "")
    }

    /// Sets a number for all processes.
    pub fn setting(self, name: &str, value: &str) -> Self {
        std::fs::write(self.troubles.path().join(name), value).unwrap();
        self
    }

    /// Troubles that have not happened.
    pub fn troubles_left(&self) -> usize {
        std::fs::read_dir(self.troubles.path()).unwrap().count()
    }

    /// Runs the set; `on_event` is told of everything.
    pub fn run(&self, on_event: &mut dyn FnMut(SetEvent)) -> Result<SetEnd, RunFault> {
        let mut runs = Vec::new();
        let mut processes = Vec::new();
        let mut watched = |event: SetEvent| {
            match &event {
                SetEvent::Begun { run } => runs.push(run.clone()),
                SetEvent::Started { process, .. } => processes.push(*process),
                _ => {}
            }
            on_event(event);
        };
        let options = SetOptions { time_limit: self.time_limit, stop: self.stop.clone(), on_event: &mut watched };
        let launch = toy_launch_file(self.troubles.path(), &self.launch);
        let end = run_set(toy_statement(self.seed), &launch, options);
        // Whatever has happened.
        assert_eq!(leftovers(&runs), Vec::<String>::new());
        let alive: Vec<u32> = processes.into_iter().filter(|process| is_alive(*process)).collect();
        assert!(alive.is_empty(), "processes {alive:?} are left");
        end
    }

    /// Runs the set to an end of its own, in silence.
    pub fn end(&self) -> SetEnd {
        self.run(&mut |_| ()).unwrap()
    }
}

/// How the toy search of a set ended.
pub fn toy_end(end: &SetEnd) -> ToyEnd {
    decode(&end.search.conclusion).unwrap()
}

/// The ledger by direct calls: the oracle.
pub fn reference(seed: u64) -> Ledger {
    reference_with(seed, ToyStage::default().piece_vertices)
}

/// The same with roadmap pieces of another size.
pub fn reference_with(seed: u64, piece_vertices: usize) -> Ledger {
    let toy = || Box::new(ToyStage { piece_vertices, ..ToyStage::default() }) as Box<dyn Stage>;
    let stages: BTreeMap<StageKind, Box<dyn Stage>> = StageKind::ALL.map(|stage| (stage, toy())).into();
    let statement = Arc::new(toy_statement(seed));
    whole_log(&statement, &mut DirectCalls::new(statement.clone(), stages, Arc::default())).0
}

/// What is left of runs in shared memory.
pub fn leftovers(runs: &[String]) -> Vec<String> {
    let names = std::fs::read_dir("/dev/shm").unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    names.filter(|name| runs.iter().any(|run| name.starts_with(run.as_str()))).collect()
}

/// Whether a process is there and no zombie.
pub fn is_alive(process: u32) -> bool {
    let Ok(stat) = std::fs::read_to_string(format!("/proc/{process}/stat")) else { return false };
    // After the name, which is in brackets and may contain anything.
    stat.rsplit(')').next().is_some_and(|rest| !rest.trim_start().starts_with('Z'))
}
