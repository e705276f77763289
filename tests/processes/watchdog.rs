//! Ends a test that hangs.

use std::sync::mpsc::{Sender, channel};
use std::time::Duration;

/// Ends the whole test program if it is not dropped in time: a test that hangs has failed.
pub struct Watchdog(#[allow(dead_code)] Sender<()>);

impl Watchdog {
    /// Watches for two minutes.
    pub fn start(test: &'static str) -> Self {
        let (sender, receiver) = channel::<()>();
        std::thread::spawn(move || {
            if receiver.recv_timeout(Duration::from_secs(120)) == Err(std::sync::mpsc::RecvTimeoutError::Timeout) {
                eprintln!("{test} hangs");
                std::process::exit(101);
            }
        });
        Self(sender)
    }
}
