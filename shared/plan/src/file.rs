//! Reading and writing the two files.

use serde::{Serialize, de::DeserializeOwned};

use crate::{Failure, Plan};

/// Format tag of `plan.json`.
pub const PLAN_FORMAT: &str = "mrtamp-plan/1";
/// Format tag of `failure.json`.
pub const FAILURE_FORMAT: &str = "mrtamp-failure/1";

/// Why a file could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum PlanFileError {
    /// Not JSON of the expected form; the message has line and column.
    #[error("not a {format} file: {source}")]
    Malformed {
        /// Expected format.
        format: &'static str,
        /// What the reader said.
        source: serde_json::Error,
    },
    /// A format tag of another kind or version.
    #[error("format is `{found}`, expected `{expected}`")]
    Format {
        /// Tag in the file.
        found: String,
        /// Tag that this program writes.
        expected: &'static str,
    },
    /// A number that JSON cannot hold.
    #[error("cannot be written as {format}: {source}")]
    Unwritable {
        /// Format.
        format: &'static str,
        /// What the writer said.
        source: serde_json::Error,
    },
}

/// Bytes of `plan.json`.
///
/// # Errors
/// [`PlanFileError::Unwritable`].
pub fn write_plan(plan: &Plan) -> Result<Vec<u8>, PlanFileError> {
    write(plan, PLAN_FORMAT)
}

/// Reads `plan.json`.
///
/// # Errors
/// [`PlanFileError::Malformed`], [`PlanFileError::Format`].
pub fn read_plan(bytes: &[u8]) -> Result<Plan, PlanFileError> {
    let plan: Plan = read(bytes, PLAN_FORMAT)?;
    tagged(&plan.format, PLAN_FORMAT)?;
    Ok(plan)
}

/// Bytes of `failure.json`.
///
/// # Errors
/// [`PlanFileError::Unwritable`].
pub fn write_failure(failure: &Failure) -> Result<Vec<u8>, PlanFileError> {
    write(failure, FAILURE_FORMAT)
}

/// Reads `failure.json`.
///
/// # Errors
/// [`PlanFileError::Malformed`], [`PlanFileError::Format`].
pub fn read_failure(bytes: &[u8]) -> Result<Failure, PlanFileError> {
    let failure: Failure = read(bytes, FAILURE_FORMAT)?;
    tagged(&failure.format, FAILURE_FORMAT)?;
    Ok(failure)
}

fn write<T: Serialize>(value: &T, format: &'static str) -> Result<Vec<u8>, PlanFileError> {
    let mut bytes = serde_json::to_vec(value).map_err(|source| PlanFileError::Unwritable { format, source })?;
    bytes.push(b'\n');
    Ok(bytes)
}

fn read<T: DeserializeOwned>(bytes: &[u8], format: &'static str) -> Result<T, PlanFileError> {
    serde_json::from_slice(bytes).map_err(|source| PlanFileError::Malformed { format, source })
}

fn tagged(found: &str, expected: &'static str) -> Result<(), PlanFileError> {
    if found == expected { Ok(()) } else { Err(PlanFileError::Format { found: found.to_owned(), expected }) }
}
