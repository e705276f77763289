//! The programs that the tests start: this test program itself, in another role.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::{Parser, Subcommand};
use contract::{AskStages, Job, LedgerEntry, ProblemStatement, Stage, StageKind, encode_canonical};
use launch::set::member::MemberArgs;
use launch::set::refine_process::RefineArgs;
use launch::set::supervisor::run_set;
use launch::set::{RunFault, Searched, SetEvent, SetOptions, refine_process, stage_process};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

use crate::set::toy_launch_file;
use crate::toy::{ToyStage, search, toy_implementation, toy_statement};

/// This program in a role.
#[derive(Parser)]
struct Cli {
    #[command(subcommand)]
    role: Role,
}

#[derive(Subcommand)]
enum Role {
    /// A worker with a toy stage.
    Stage {
        stage: String,
        /// Folder with troubles: files whose names say what happens, each once.
        troubles: PathBuf,
        #[command(flatten)]
        member: MemberArgs,
    },
    /// A refiner with the toy search.
    Refine {
        troubles: PathBuf,
        #[command(flatten)]
        args: RefineArgs,
    },
    /// A supervisor with a whole toy set. Writes what happens to `log`.
    Set { troubles: PathBuf, log: PathBuf },
    /// Ends at once.
    Leave {
        code: i32,
        #[command(flatten)]
        member: MemberArgs,
    },
}

/// Not only a test: it is how the programs of a toy set are started.
#[test]
fn this_program_plays_the_role_that_it_is_given() {
    let words: Vec<String> = std::env::args().collect();
    match words.iter().position(|word| word == "--") {
        Some(at) => std::process::exit(play(Cli::parse_from(&words[at..]).role)),
        None => assert!(Cli::try_parse_from(["--", "king"]).is_err()),
    }
}

/// How this program is started in a role.
pub fn command(role: &[&str]) -> Vec<String> {
    let program = std::env::current_exe().unwrap().into_os_string().into_string().unwrap();
    let test = "fixtures::this_program_plays_the_role_that_it_is_given";
    let first = [program.as_str(), "--exact", test, "--nocapture", "--"];
    first.into_iter().chain(role.iter().copied()).map(str::to_owned).collect()
}

fn play(role: Role) -> i32 {
    let played = match role {
        Role::Stage { stage, troubles, member } => {
            let kind = StageKind::of_name(&stage).unwrap();
            let implementation = if take(&troubles, &format!("other-{stage}")).is_some() {
                "other/2".to_owned()
            } else {
                toy_implementation(kind)
            };
            let make = |_: &ProblemStatement| Ok(Box::new(troubled_stage(kind, troubles.clone())) as Box<dyn Stage>);
            stage_process::run(&member, kind, &implementation, &make).map_err(|fault| fault.to_string())
        }
        Role::Refine { troubles, args } => {
            let search =
                |statement: &ProblemStatement, stages: &mut dyn AskStages, observe: &mut dyn FnMut(&LedgerEntry)| {
                    toy_search(&troubles, statement, stages, observe)
                };
            refine_process::run(&args, "toy-refiner/1", &search).map_err(|fault| fault.to_string())
        }
        Role::Set { troubles, log } => supervise(&troubles, &log).map_err(|fault| fault.to_string()),
        Role::Leave { code, .. } => return code,
    };
    match played {
        Ok(()) => 0,
        Err(fault) => {
            eprintln!("{fault}");
            1
        }
    }
}

/// Takes the first trouble that begins so; what is left of its name.
fn take(troubles: &Path, beginning: &str) -> Option<String> {
    let mut names: Vec<String> =
        std::fs::read_dir(troubles).ok()?.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    // Whoever removes it has it.
    names.into_iter().find_map(|name| {
        let rest = name.strip_prefix(beginning)?.to_owned();
        std::fs::remove_file(troubles.join(&name)).is_ok().then_some(rest)
    })
}

fn troubled_stage(kind: StageKind, troubles: PathBuf) -> ToyStage {
    let number = |name: &str| {
        let text = std::fs::read_to_string(troubles.join(name)).ok()?;
        text.parse::<u64>().ok()
    };
    let vertices = number("piece-vertices");
    let labour = number(&format!("labour-{kind}")).unwrap_or(0);
    let trouble = move |_: &Job| {
        if take(&troubles, &format!("kill-{kind}")).is_some() {
            signal_self(Signal::SIGKILL);
        }
        if take(&troubles, &format!("stop-{kind}")).is_some() {
            signal_self(Signal::SIGSTOP);
        }
        if take(&troubles, &format!("panic-{kind}")).is_some() {
            panic!("as the test wants it");
        }
        if let Some(words) = take(&troubles, &format!("say-{kind}-")) {
            eprintln!("{words}");
        }
    };
    let default = ToyStage::default();
    let piece_vertices = vertices.map_or(default.piece_vertices, |vertices| vertices as usize);
    ToyStage { trouble: Box::new(trouble), piece_vertices, labour }
}

fn signal_self(signal: Signal) {
    kill(Pid::this(), signal).unwrap();
}

fn toy_search(
    troubles: &Path,
    statement: &ProblemStatement,
    stages: &mut dyn AskStages,
    observe: &mut dyn FnMut(&LedgerEntry),
) -> Searched {
    let mut committed = 0;
    let (ledger, end) = search(statement, stages, &mut |entry| {
        observe(entry);
        if take(troubles, &format!("kill-refiner-at-{committed}.")).is_some() {
            signal_self(Signal::SIGKILL);
        }
        committed += 1;
    });
    let plan = end.as_ref().ok().copied().flatten();
    Searched { ledger, conclusion: encode_canonical(&end), plan }
}

/// A supervisor: its log has a line for every process it has started, and one when they are ready.
fn supervise(troubles: &Path, log: &Path) -> Result<(), RunFault> {
    let stop = Arc::new(AtomicBool::new(false));
    signal_hook::flag::register(signal_hook::consts::SIGTERM, stop.clone())?;
    let mut lines = String::new();
    let mut on_event = |event: SetEvent| {
        match event {
            SetEvent::Started { process, .. } => lines += &format!("started {process}\n"),
            SetEvent::Note(bus::Note::Ready { .. }) => lines += "ready\n",
            _ => return,
        }
        let unfinished = log.with_extension("unfinished");
        std::fs::write(&unfinished, &lines).unwrap();
        std::fs::rename(&unfinished, log).unwrap();
    };
    let options = SetOptions { time_limit: None, stop, on_event: &mut on_event };
    run_set(toy_statement(0), &toy_launch_file(troubles, ""), options).map(drop)
}
