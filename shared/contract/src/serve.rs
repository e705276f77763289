//! The loop of every stage worker.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use serde::{Deserialize, Serialize};

use crate::{Interrupted, Job, JobContext, JobId, Outcome, ProductRef, Products, Stage};

/// A job that a worker has been offered.
#[derive(Clone, Debug)]
pub struct Offer {
    /// Identity.
    pub id: JobId,
    /// Job.
    pub job: Job,
    /// Set by the port when nobody wants the answer any more.
    pub cancelled: Arc<AtomicBool>,
}

/// Why a worker has no outcome for an offer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refusal {
    /// Cancelled as it was asked to be.
    Cancelled,
    /// A product can be had nowhere.
    Lacking(ProductRef),
    /// Not a job that this stage can answer.
    Unfit(String),
}

/// A worker's side of the bus. Its implementation goes on draining messages while the worker computes.
pub trait JobPort {
    /// Waits for the next offer. `None`: the run is over.
    ///
    /// # Errors
    /// [`ServeFault`] when the transport has failed.
    fn next_offer(&mut self) -> Result<Option<Offer>, ServeFault>;

    /// Says that work on a job begins, so that a death can be laid at its door.
    ///
    /// # Errors
    /// [`ServeFault`].
    fn started(&mut self, id: JobId) -> Result<(), ServeFault>;

    /// Publishes an outcome, or says why there is none.
    ///
    /// # Errors
    /// [`ServeFault`].
    fn answer(&mut self, id: JobId, answer: Result<Outcome, Refusal>) -> Result<(), ServeFault>;

    /// Where the products are.
    fn products(&self) -> Arc<dyn Products>;
}

/// Why a worker cannot go on.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ServeFault {
    /// The transport has failed.
    #[error("{0}")]
    Transport(String),
}

/// Works on offers until the run is over.
///
/// # Errors
/// [`ServeFault`] when the transport has failed.
pub fn serve(stage: &dyn Stage, port: &mut dyn JobPort) -> Result<(), ServeFault> {
    let products = port.products();
    while let Some(offer) = port.next_offer()? {
        port.started(offer.id)?;
        let mut context = JobContext::new(offer.id, &offer.job, products.as_ref(), offer.cancelled.clone());
        let answer = stage.refine(&offer.job, &mut context).map_err(|interrupted| match interrupted {
            Interrupted::Cancelled => Refusal::Cancelled,
            Interrupted::Lacking(product) => Refusal::Lacking(product),
            Interrupted::Unfit(reason) => Refusal::Unfit(reason),
        });
        port.answer(offer.id, answer)?;
    }
    Ok(())
}
