//! A process of a set.

use std::io::{self, BufRead, BufReader, Read};
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::SyncSender;

use nix::sys::signal::{Signal, killpg};
use nix::unistd::Pid;

/// Longest line that is passed on (bytes).
const MAX_LINE: u64 = 4096;

/// A line that a process has said.
pub struct Said {
    /// Name of the process.
    pub name: String,
    /// What.
    pub text: String,
}

/// A running process, leader of a process group of its own: a Ctrl-C at the terminal is the supervisor's alone.
#[derive(Debug)]
pub struct ChildProcess {
    process: Child,
}

impl ChildProcess {
    /// Starts a program. Its lines go to `lines`, whether from its standard output or its standard error.
    ///
    /// # Errors
    /// When it cannot be started.
    pub fn start(name: &str, command: &[String], arguments: &[String], lines: SyncSender<Said>) -> io::Result<Self> {
        let Some((program, first)) = command.split_first() else { return Err(io::ErrorKind::InvalidInput.into()) };
        let (reader, writer) = io::pipe()?;
        let process = Command::new(program)
            .args(first)
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(writer.try_clone()?)
            .stderr(writer)
            .process_group(0)
            .spawn()?;
        let name = name.to_owned();
        std::thread::Builder::new().name(format!("lines of {name}")).spawn(move || pass_on(reader, &name, &lines))?;
        Ok(Self { process })
    }

    /// Process number.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.process.id()
    }

    /// How it has ended, if it has. From then on it gets no signals.
    ///
    /// # Errors
    /// When the system will not say.
    pub fn ended(&mut self) -> io::Result<Option<ExitStatus>> {
        self.process.try_wait()
    }

    /// Sends a signal to the process and to what it has started.
    pub fn signal(&self, signal: Signal) {
        // It may have ended a moment ago; its number is its own until `ended` has said so.
        if let Ok(group) = i32::try_from(self.process.id()) {
            let _ = killpg(Pid::from_raw(group), signal);
        }
    }
}

/// Passes lines on until the process and all that it has started have closed their output.
fn pass_on(output: impl Read, name: &str, lines: &SyncSender<Said>) {
    let mut output = BufReader::new(output);
    loop {
        let mut line = Vec::new();
        match (&mut output).take(MAX_LINE).read_until(b'\n', &mut line) {
            Ok(0) | Err(_) => return,
            Ok(_) => {}
        }
        let text = String::from_utf8_lossy(&line).trim_end().to_owned();
        if lines.send(Said { name: name.to_owned(), text }).is_err() {
            return;
        }
    }
}
