//! Messages: one file for each edge, one encoding, one decoding.

mod ledger;
mod offer;
mod presence;
mod store;

pub use ledger::{BacktrackRequest, Committed, SearchEnd};
pub use offer::{JobOffer, Retirement};
pub use presence::{Gone, Heartbeat, Hello};
pub use store::{Kept, Want};

use std::borrow::Cow;
use std::sync::Arc;

use contract::{CodecError, Digest, Nogood, Outcome, ProblemStatement, Refusal, decode, encode};
use serde::{Serialize, de::DeserializeOwned};

use crate::finite::{NotFinite, check_finite, check_numbers};
use crate::{Role, Topic};

/// Everything that is said on the bus.
#[derive(Clone, Debug, PartialEq)]
pub enum Message {
    /// What every process works from.
    Statement(Arc<ProblemStatement>),
    /// A job for a worker.
    Offer(Box<JobOffer>),
    /// Work on the envelope's job begins: a death can be laid at its door.
    Started,
    /// The envelope's job is answered or has failed.
    Outcome(Box<Outcome>),
    /// The envelope's job has no outcome from this worker.
    Declined(Refusal),
    /// Bytes of a product.
    Product(Arc<[u8]>),
    /// A request to the store.
    Want(Want),
    /// The store does not have this product.
    Absent(Digest),
    /// Outcomes from the store.
    Kept(Kept),
    /// Which offers still count.
    Retirement(Retirement),
    /// A decision is revised.
    Backtrack(BacktrackRequest),
    /// A nogood was learnt.
    Nogood(Nogood),
    /// An entry of the committed log.
    Committed(Committed),
    /// The search is over.
    SearchEnd(Box<SearchEnd>),
    /// A member introduces itself.
    Hello(Hello),
    /// A member is alive.
    Heartbeat(Heartbeat),
    /// A member leaves of its own accord.
    Farewell,
    /// A member has gone.
    Gone(Gone),
    /// The run is over.
    Shutdown,
}

/// Kind of a message, as in the envelope.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs)]
pub enum Kind {
    Statement = 1,
    Offer = 2,
    Started = 3,
    Sample = 4,
    FailureReport = 5,
    Declined = 6,
    Product = 7,
    Want = 8,
    Absent = 9,
    Kept = 10,
    Retirement = 11,
    Backtrack = 12,
    Nogood = 13,
    Committed = 14,
    SearchEnd = 15,
    Hello = 16,
    Heartbeat = 17,
    Farewell = 18,
    Gone = 19,
    Shutdown = 20,
}

impl Kind {
    /// All kinds, in order of their numbers.
    pub const ALL: [Kind; 20] = [
        Kind::Statement,
        Kind::Offer,
        Kind::Started,
        Kind::Sample,
        Kind::FailureReport,
        Kind::Declined,
        Kind::Product,
        Kind::Want,
        Kind::Absent,
        Kind::Kept,
        Kind::Retirement,
        Kind::Backtrack,
        Kind::Nogood,
        Kind::Committed,
        Kind::SearchEnd,
        Kind::Hello,
        Kind::Heartbeat,
        Kind::Farewell,
        Kind::Gone,
        Kind::Shutdown,
    ];

    /// The kind of that number.
    #[must_use]
    pub fn of_number(number: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| *kind as u32 == number)
    }

    /// Whether messages of this kind belong on a topic.
    #[must_use]
    pub fn belongs_on(self, topic: Topic) -> bool {
        match self {
            Kind::Statement => topic == Topic::Problem,
            Kind::Offer => matches!(topic, Topic::Offer(_)),
            Kind::Started | Kind::Sample | Kind::FailureReport | Kind::Declined => matches!(topic, Topic::Outcome(_)),
            Kind::Product => matches!(topic, Topic::Product | Topic::Delivery),
            Kind::Want => topic == Topic::Want,
            Kind::Absent | Kind::Kept => topic == Topic::Delivery,
            Kind::Retirement => topic == Topic::Retirement,
            Kind::Backtrack => topic == Topic::Backtrack,
            Kind::Nogood => topic == Topic::Nogood,
            Kind::Committed | Kind::SearchEnd => topic == Topic::Ledger,
            Kind::Hello | Kind::Heartbeat | Kind::Farewell | Kind::Gone => topic == Topic::Presence,
            Kind::Shutdown => topic == Topic::Shutdown,
        }
    }
}

/// Why a body is no message.
#[derive(Debug, thiserror::Error)]
pub enum BodyError {
    /// Bytes that are no such value.
    #[error(transparent)]
    Codec(#[from] CodecError),
    /// A number that no message may have.
    #[error(transparent)]
    NotFinite(#[from] NotFinite),
    /// An answer labelled as failure, or a failure as answer.
    #[error("kind and content contradict one another")]
    WrongKind,
}

impl Message {
    /// Kind.
    #[must_use]
    pub fn kind(&self) -> Kind {
        match self {
            Message::Statement(_) => Kind::Statement,
            Message::Offer(_) => Kind::Offer,
            Message::Started => Kind::Started,
            Message::Outcome(outcome) if outcome.result.is_ok() => Kind::Sample,
            Message::Outcome(_) => Kind::FailureReport,
            Message::Declined(_) => Kind::Declined,
            Message::Product(_) => Kind::Product,
            Message::Want(_) => Kind::Want,
            Message::Absent(_) => Kind::Absent,
            Message::Kept(_) => Kind::Kept,
            Message::Retirement(_) => Kind::Retirement,
            Message::Backtrack(_) => Kind::Backtrack,
            Message::Nogood(_) => Kind::Nogood,
            Message::Committed(_) => Kind::Committed,
            Message::SearchEnd(_) => Kind::SearchEnd,
            Message::Hello(_) => Kind::Hello,
            Message::Heartbeat(_) => Kind::Heartbeat,
            Message::Farewell => Kind::Farewell,
            Message::Gone(_) => Kind::Gone,
            Message::Shutdown => Kind::Shutdown,
        }
    }

    /// Bytes of the body.
    ///
    /// # Errors
    /// [`CodecError`]: too large, or a value that the encoding cannot hold.
    pub fn to_body(&self) -> Result<Cow<'_, [u8]>, CodecError> {
        Ok(Cow::Owned(match self {
            Message::Product(bytes) if bytes.len() > contract::MAX_MESSAGE_BYTES => {
                return Err(CodecError::TooLarge(bytes.len()));
            }
            Message::Product(bytes) => return Ok(Cow::Borrowed(bytes)),
            Message::Statement(statement) => encode(&**statement)?,
            Message::Offer(offer) => encode(offer)?,
            Message::Outcome(outcome) => encode(outcome)?,
            Message::Declined(refusal) => encode(refusal)?,
            Message::Want(want) => encode(want)?,
            Message::Absent(digest) => encode(digest)?,
            Message::Kept(kept) => encode(kept)?,
            Message::Retirement(retirement) => encode(retirement)?,
            Message::Backtrack(backtrack) => encode(backtrack)?,
            Message::Nogood(nogood) => encode(nogood)?,
            Message::Committed(committed) => encode(committed)?,
            Message::SearchEnd(end) => encode(end)?,
            Message::Hello(hello) => encode(hello)?,
            Message::Heartbeat(heartbeat) => encode(heartbeat)?,
            Message::Gone(gone) => encode(gone)?,
            Message::Started | Message::Farewell | Message::Shutdown => Vec::new(),
        }))
    }

    /// The message of a kind and body.
    ///
    /// # Errors
    /// [`BodyError`]; never panics, whatever the bytes.
    pub fn of_body(kind: Kind, body: Vec<u8>) -> Result<Self, BodyError> {
        Ok(match kind {
            Kind::Statement => {
                // Limits may be infinite in a statement, but nothing may be NaN.
                let statement: ProblemStatement = decode(&body)?;
                check_numbers(&statement)?;
                Message::Statement(Arc::new(statement))
            }
            Kind::Offer => Message::Offer(Box::new(finite(&body)?)),
            Kind::Sample | Kind::FailureReport => {
                let outcome: Outcome = finite(&body)?;
                if outcome.result.is_ok() != (kind == Kind::Sample) {
                    return Err(BodyError::WrongKind);
                }
                Message::Outcome(Box::new(outcome))
            }
            Kind::Declined => Message::Declined(decode(&body)?),
            Kind::Product => Message::Product(body.into()),
            Kind::Want => Message::Want(decode(&body)?),
            Kind::Absent => Message::Absent(decode(&body)?),
            Kind::Kept => Message::Kept(finite(&body)?),
            Kind::Retirement => Message::Retirement(decode(&body)?),
            Kind::Backtrack => Message::Backtrack(finite(&body)?),
            Kind::Nogood => Message::Nogood(finite(&body)?),
            Kind::Committed => Message::Committed(finite(&body)?),
            Kind::SearchEnd => Message::SearchEnd(Box::new(finite(&body)?)),
            Kind::Hello => Message::Hello(decode(&body)?),
            Kind::Heartbeat => Message::Heartbeat(decode(&body)?),
            Kind::Gone => Message::Gone(decode(&body)?),
            Kind::Started => empty(&body, Message::Started)?,
            Kind::Farewell => empty(&body, Message::Farewell)?,
            Kind::Shutdown => empty(&body, Message::Shutdown)?,
        })
    }

    /// Roles that should look at once when this message arrives on a topic; the rest sees it on its timer.
    #[must_use]
    pub fn wakes(&self, topic: Topic) -> Vec<Role> {
        let readers = |topic: Topic| Role::all().into_iter().filter(move |role| role.reads().contains(&topic));
        match self {
            Message::Heartbeat(_) | Message::Committed(_) | Message::Started => Vec::new(),
            Message::Product(_) if topic == Topic::Product => Vec::new(),
            // The store keeps what it sees; nobody waits for that.
            Message::Outcome(_) | Message::Declined(_) => vec![Role::Refiner],
            _ => readers(topic).collect(),
        }
    }
}

fn finite<T: DeserializeOwned + Serialize>(body: &[u8]) -> Result<T, BodyError> {
    let value: T = decode(body)?;
    check_finite(&value)?;
    Ok(value)
}

fn empty(body: &[u8], message: Message) -> Result<Message, BodyError> {
    if body.is_empty() { Ok(message) } else { Err(CodecError::Trailing(body.len()).into()) }
}
