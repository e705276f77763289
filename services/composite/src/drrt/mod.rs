//! The paper's multi-modal dRRT* on the composite of all robots' mode roadmaps.

use contract::{Assignment, Interrupted, JobContext, Outcome, ProductRef};

use crate::Scene;

/// Answers a `Drrt` job.
///
/// # Errors
/// [`Interrupted`].
pub fn refine(
    _scene: &Scene,
    _assignment: &Assignment,
    _prefix: Option<ProductRef>,
    _roadmaps: &[Vec<ProductRef>],
    _context: &mut JobContext<'_>,
) -> Result<Outcome, Interrupted> {
    Err(Interrupted::Unfit("not written yet".into()))
}
