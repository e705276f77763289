//! A worker's side of the bus without threads and clock: messages in, messages out, and what to work on next.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use contract::{
    Answer, Digest, Job, JobId, JobIds, Offer, Outcome, ProblemStatement, ProductRef, Refusal, StageKind,
    encode_canonical,
};

use super::memo::{Answers, ProductMemo};
use crate::{
    Garbage, GarbageTally, Heartbeat, Hello, Incoming, JobOffer, MemberId, Message, Outgoing, Retirement, Topic,
};

/// Order of offers: later refiners' after earlier ones', then by number.
type OfferNumber = (MemberId, u64);

/// State of one worker.
pub struct WorkerCore {
    me: MemberId,
    stage: StageKind,
    hello: Hello,
    known: Option<(Arc<ProblemStatement>, JobIds)>,
    refiner: Option<MemberId>,
    queue: Vec<Queued>,
    computing: Option<Computing>,
    answers: Answers,
    products: ProductMemo,
    done: u64,
    over: bool,
    garbage: GarbageTally,
    out: Vec<Outgoing>,
}

struct Queued {
    id: JobId,
    job: Job,
    number: OfferNumber,
    speculative: bool,
}

struct Computing {
    id: JobId,
    number: OfferNumber,
    cancelled: Arc<AtomicBool>,
    /// Offered again after it was cancelled.
    again: Option<Queued>,
}

impl WorkerCore {
    /// A worker of one stage; `hello` introduces it.
    #[must_use]
    pub fn new(me: MemberId, stage: StageKind, hello: Hello) -> Self {
        let out = vec![Outgoing::plain(Topic::Presence, Message::Hello(hello.clone()))];
        Self {
            me,
            stage,
            hello,
            known: None,
            refiner: None,
            queue: Vec::new(),
            computing: None,
            answers: Answers::default(),
            products: ProductMemo::default(),
            done: 0,
            over: false,
            garbage: GarbageTally::default(),
            out,
        }
    }

    /// Takes a message.
    pub fn hear(&mut self, incoming: Incoming) {
        match incoming.message {
            Message::Statement(statement) => self.learn(statement),
            Message::Offer(offer) => self.take_offer(incoming.sender, incoming.job, *offer),
            Message::Retirement(retirement) => self.retire(incoming.sender, &retirement),
            Message::Product(bytes) => self.products.keep(Digest::of_product(&bytes), bytes),
            Message::Absent(digest) => self.products.set_absent(digest),
            Message::Shutdown => self.end(),
            // Others are spoken to on the same topics.
            _ => {}
        }
    }

    fn learn(&mut self, statement: Arc<ProblemStatement>) {
        let digest = statement_digest(&statement);
        match self.hello.statement {
            None => {
                self.hello.statement = Some(digest);
                self.known = Some((statement.clone(), JobIds::new(statement)));
                self.out.push(Outgoing::plain(Topic::Presence, Message::Hello(self.hello.clone())));
            }
            Some(known) if known == digest => {}
            Some(_) => self.garbage.count(Garbage::Claim),
        }
    }

    fn take_offer(&mut self, sender: MemberId, claimed: Option<JobId>, offer: JobOffer) {
        if offer.to != self.me || self.refiner.is_some_and(|refiner| sender < refiner) {
            return;
        }
        let Some((_, ids)) = &self.known else { return };
        let Some(id) = ids.of(&offer.job).filter(|id| Some(*id) == claimed && offer.job.stage() == self.stage) else {
            self.garbage.count(Garbage::Claim);
            return;
        };
        if self.refiner != Some(sender) {
            // What an earlier refiner wanted is offered again if it still counts.
            self.refiner = Some(sender);
            self.queue.clear();
        }
        if !self.answer_again(id, offer.afresh) {
            let number = (sender, offer.number);
            self.enqueue(Queued { id, job: offer.job, number, speculative: offer.speculative });
        }
    }

    /// Repeats a known answer. `false`: the job has to be worked on.
    fn answer_again(&mut self, id: JobId, with_product: bool) -> bool {
        let Some(outcome) = self.answers.get(&id).cloned() else { return false };
        if with_product && let Some(product) = product_of(&outcome) {
            let Some(bytes) = self.products.get(&product.digest) else { return false };
            self.out.push(Outgoing::about(id, Topic::Product, Message::Product(bytes)));
        }
        self.out.push(Outgoing::about(id, Topic::Outcome(self.stage), Message::Outcome(Box::new(outcome))));
        true
    }

    fn enqueue(&mut self, queued: Queued) {
        if let Some(computing) = self.computing.as_mut().filter(|computing| computing.id == queued.id) {
            if computing.cancelled.load(Ordering::Relaxed) {
                computing.again = Some(queued);
            } else {
                computing.number = queued.number;
            }
            return;
        }
        self.queue.retain(|waiting| waiting.id != queued.id);
        self.queue.push(queued);
    }

    fn retire(&mut self, sender: MemberId, retirement: &Retirement) {
        let last = (sender, retirement.number);
        let counts = |number: OfferNumber, id: &JobId| number > last || retirement.live.binary_search(id).is_ok();
        let topic = Topic::Outcome(self.stage);
        let out = &mut self.out;
        self.queue.retain(|queued| {
            let kept = counts(queued.number, &queued.id);
            if !kept {
                out.push(Outgoing::about(queued.id, topic, Message::Declined(Refusal::Cancelled)));
            }
            kept
        });
        if let Some(computing) = &mut self.computing
            && !counts(computing.number, &computing.id)
        {
            computing.cancelled.store(true, Ordering::Relaxed);
            computing.again = None;
        }
    }

    /// The offer to work on now: what the search has asked for first, then in the order of offering.
    pub fn begin(&mut self) -> Option<Offer> {
        let best = (0..self.queue.len()).min_by_key(|i| (self.queue[*i].speculative, self.queue[*i].number))?;
        let queued = self.queue.remove(best);
        let cancelled = Arc::new(AtomicBool::new(self.over));
        self.computing =
            Some(Computing { id: queued.id, number: queued.number, cancelled: cancelled.clone(), again: None });
        Some(Offer { id: queued.id, job: queued.job, cancelled })
    }

    /// Work on the offer begins.
    pub fn started(&mut self, id: JobId) {
        self.out.push(Outgoing::about(id, Topic::Outcome(self.stage), Message::Started));
    }

    /// Work on the offer has ended.
    pub fn finish(&mut self, id: JobId, answer: Result<Outcome, Refusal>) {
        let again = self.computing.take().and_then(|computing| computing.again);
        let topic = Topic::Outcome(self.stage);
        match answer {
            Ok(outcome) => {
                self.done += 1;
                self.answers.keep(id, outcome.clone());
                self.out.push(Outgoing::about(id, topic, Message::Outcome(Box::new(outcome))));
            }
            Err(refusal) => {
                self.out.push(Outgoing::about(id, topic, Message::Declined(refusal)));
                self.queue.extend(again);
            }
        }
    }

    /// Keeps a product; returns its digest and the message that publishes it.
    pub fn publish(&mut self, bytes: Vec<u8>) -> (Digest, Outgoing) {
        let digest = Digest::of_product(&bytes);
        let bytes: Arc<[u8]> = bytes.into();
        self.products.keep(digest, bytes.clone());
        let job = self.computing.as_ref().map(|computing| computing.id);
        (digest, Outgoing { topic: Topic::Product, job, message: Message::Product(bytes) })
    }

    /// A product, if it is here.
    #[must_use]
    pub fn product(&self, digest: &Digest) -> Option<Arc<[u8]>> {
        self.products.get(digest)
    }

    /// Whether the store has said that it lacks the product. It is forgotten with this call.
    pub fn take_absent(&mut self, digest: &Digest) -> bool {
        self.products.take_absent(digest)
    }

    /// Whether the work under way is wanted no more.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.over || self.computing.as_ref().is_some_and(|computing| computing.cancelled.load(Ordering::Relaxed))
    }

    /// No more work: the queue is dropped, and what is under way is cancelled.
    pub fn end(&mut self) {
        self.over = true;
        self.queue.clear();
        if let Some(computing) = &self.computing {
            computing.cancelled.store(true, Ordering::Relaxed);
        }
    }

    /// Whether the run is over.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.over
    }

    /// The statement, once it has arrived.
    #[must_use]
    pub fn statement(&self) -> Option<Arc<ProblemStatement>> {
        self.known.as_ref().map(|(statement, _)| statement.clone())
    }

    /// A sign of life; an introduction as long as there is no statement.
    #[must_use]
    pub fn heartbeat(&self) -> Outgoing {
        let message = if self.known.is_none() {
            Message::Hello(self.hello.clone())
        } else {
            let computing = self.computing.iter().map(|computing| computing.id);
            let held = computing.chain(self.queue.iter().map(|queued| queued.id)).collect();
            Message::Heartbeat(Heartbeat { hello: self.hello.clone(), held, done: self.done })
        };
        Outgoing::plain(Topic::Presence, message)
    }

    /// Messages to be sent, in order.
    pub fn take_outgoing(&mut self) -> Vec<Outgoing> {
        std::mem::take(&mut self.out)
    }

    /// What was refused because it contradicts what is known.
    #[must_use]
    pub fn garbage(&self) -> &GarbageTally {
        &self.garbage
    }
}

/// The product that an answer names.
pub(crate) fn product_of(outcome: &Outcome) -> Option<ProductRef> {
    match outcome.result.as_ref().ok()? {
        Answer::Piece(product) => Some(*product),
        Answer::Mode { roadmap, .. } => Some(*roadmap),
        Answer::Committed { prefix, .. } | Answer::Rounds { prefix, .. } | Answer::Repaired { prefix, .. } => {
            Some(*prefix)
        }
        Answer::Plan { plan, .. } => Some(*plan),
        Answer::Placements(_)
        | Answer::Hop { .. }
        | Answer::Samples(_)
        | Answer::Alternatives(_)
        | Answer::Blocked(_)
        | Answer::NoPassage(_) => None,
    }
}

/// Digest by which members know a statement.
#[must_use]
pub fn statement_digest(statement: &ProblemStatement) -> Digest {
    Digest::of("mrtamp statement", &[&encode_canonical(statement)])
}
