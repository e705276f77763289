//! The folder of results, and what becomes of those of earlier runs.
//!
//! A plan takes the place of an earlier one only when it is certified. A run that finds that there is none sets the
//! earlier plan aside under another name; a run that was cut short has found nothing out and leaves it where it is.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use miette::{Context, IntoDiagnostic};

use crate::result_file::write_whole;

/// Folder for `plan.json` or `failure.json`.
pub struct ResultFolder<'a>(pub &'a Path);

impl ResultFolder<'_> {
    /// Writes a file whole or not at all.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&self, name: &str, bytes: &[u8]) -> miette::Result<PathBuf> {
        let path = self.0.join(name);
        write_whole(&path, bytes)
            .into_diagnostic()
            .wrap_err_with(|| format!("{} cannot be written", path.display()))?;
        Ok(path)
    }

    /// Removes a file if it is there.
    ///
    /// # Errors
    /// When it is there and cannot be removed.
    pub fn remove(&self, name: &str) -> miette::Result<()> {
        let path = self.0.join(name);
        if_there(std::fs::remove_file(&path))
            .map(drop)
            .into_diagnostic()
            .wrap_err_with(|| format!("{} cannot be removed", path.display()))
    }

    /// Says that an earlier plan is still there.
    pub fn keep_earlier_plan(&self) {
        let plan = self.0.join("plan.json");
        if plan.exists() {
            eprintln!("Kept from an earlier run: {}", plan.display());
        }
    }

    /// Gives an earlier plan and its page another name.
    ///
    /// # Errors
    /// When they cannot be renamed.
    pub fn set_earlier_plan_aside(&self) -> miette::Result<()> {
        for (name, aside) in [("plan.json", "plan.previous.json"), ("plan.html", "plan.previous.html")] {
            let (path, aside) = (self.0.join(name), self.0.join(aside));
            let moved = if_there(std::fs::rename(&path, &aside))
                .into_diagnostic()
                .wrap_err_with(|| format!("{} cannot be renamed", path.display()))?;
            if moved {
                eprintln!("Set aside from an earlier run: {}", aside.display());
            }
        }
        Ok(())
    }
}

/// Whether a file was there.
fn if_there(done: std::io::Result<()>) -> std::io::Result<bool> {
    match done {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}
