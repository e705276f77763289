//! The search's side of the bus without threads and clock: which job is offered to whom, and what has come of it.

mod assign;
mod fits;
mod flights;
mod roster;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use contract::{AskFault, Digest, Foresight, Job, JobId, JobIds, Outcome, ProblemStatement, ProductRef, Refusal};

use crate::worker::statement_digest;
use crate::{Garbage, GarbageTally, Incoming, Kept, MemberId, Message, Outgoing, Topic, Want};
use flights::Flights;
use roster::Roster;

/// Workers that may die on one job before it is given up (design: K).
pub const POISON_DEATHS: u32 = 3;
/// How often one product may be made again.
const REMAKES: u32 = 8;
/// A request to the store is repeated after this long.
const WANT_AGAIN: Duration = Duration::from_millis(200);

/// State of asking.
pub struct Dispatcher {
    statement: Arc<ProblemStatement>,
    statement_digest: Digest,
    ids: JobIds,
    /// Jobs that may be in work before they are asked for.
    speculation: usize,
    roster: Roster,
    jobs: BTreeMap<JobId, Job>,
    outcomes: BTreeMap<JobId, Outcome>,
    /// Jobs that can have no outcome, and why. It counts once the search asks for one.
    hopeless: BTreeMap<JobId, AskFault>,
    flights: Flights,
    asked: Vec<JobId>,
    listed: Vec<JobId>,
    foresight: Foresight,
    /// Jobs that lack products, with the makers of these.
    lacking: BTreeMap<JobId, BTreeSet<JobId>>,
    /// Jobs whose products have to be published again, with how often that has happened.
    remade: BTreeMap<JobId, u32>,
    remaking: BTreeSet<JobId>,
    recovery: Recovery,
    fetching: Option<Fetching>,
    last_number: u64,
    news: bool,
    poison: Option<Job>,
    garbage: GarbageTally,
    out: Vec<Outgoing>,
}

/// Outcomes of the run so far, as they come from the store.
#[derive(Default)]
struct Recovery {
    batches: BTreeSet<u32>,
    complete: bool,
    wanted: Option<Duration>,
}

/// A product that the search itself wants.
struct Fetching {
    product: ProductRef,
    bytes: Option<Arc<[u8]>>,
    wanted: Option<Duration>,
}

impl Dispatcher {
    /// Asks about one statement, with at most `speculation` jobs in work that nobody has asked for.
    #[must_use]
    pub fn new(statement: Arc<ProblemStatement>, speculation: usize) -> Self {
        Self {
            statement_digest: statement_digest(&statement),
            ids: JobIds::new(statement.clone()),
            statement,
            speculation,
            roster: Roster::default(),
            jobs: BTreeMap::new(),
            outcomes: BTreeMap::new(),
            hopeless: BTreeMap::new(),
            flights: Flights::default(),
            asked: Vec::new(),
            listed: Vec::new(),
            foresight: Foresight::nothing(),
            lacking: BTreeMap::new(),
            remade: BTreeMap::new(),
            remaking: BTreeSet::new(),
            recovery: Recovery::default(),
            fetching: None,
            last_number: 0,
            news: false,
            poison: None,
            garbage: GarbageTally::default(),
            out: Vec::new(),
        }
    }

    /// Identity of a job.
    #[must_use]
    pub fn job_id(&self, job: &Job) -> JobId {
        self.ids.of(job).unwrap_or_else(|| job.id(&self.statement))
    }

    /// The search asks; [`Dispatcher::answer`] tells when all is answered.
    pub fn ask(&mut self, jobs: &[Job]) {
        self.asked = jobs.iter().map(|job| self.register(job)).collect();
    }

    /// The search asks no more.
    pub fn forget_asked(&mut self) {
        self.asked.clear();
    }

    /// The search tells what it may ask for next.
    pub fn foresee(&mut self, foresight: Foresight) {
        self.foresight = foresight;
        self.news = true;
    }

    /// Outcomes of all jobs asked for, in their order, once they are there; or why they never will be.
    #[must_use]
    pub fn answer(&self) -> Option<Result<Vec<Outcome>, AskFault>> {
        if let Some(fault) = self.asked.iter().find_map(|id| self.hopeless.get(id)) {
            return Some(Err(fault.clone()));
        }
        let mut open = self.asked.iter().filter(|id| !self.outcomes.contains_key(id)).peekable();
        if open.peek().is_none() {
            return Some(Ok(self.asked.iter().filter_map(|id| self.outcomes.get(id).cloned()).collect()));
        }
        let lost = open.filter_map(|id| self.jobs.get(id)).map(Job::stage).find(|stage| self.roster.has_lost(*stage));
        lost.map(|stage| Err(AskFault::NoWorker { stage }))
    }

    /// The search wants the bytes of a product; [`Dispatcher::fetched`] has them once they are there.
    pub fn fetch(&mut self, product: ProductRef) {
        self.fetching = Some(Fetching { product, bytes: None, wanted: None });
    }

    /// The bytes that were fetched; or why they never will be.
    #[must_use]
    pub fn fetched(&self) -> Option<Result<Arc<[u8]>, AskFault>> {
        let fetching = self.fetching.as_ref()?;
        match self.hopeless.get(&fetching.product.made_by) {
            Some(fault) => Some(Err(fault.clone())),
            None => fetching.bytes.clone().map(Ok),
        }
    }

    /// Whether the outcomes of the run so far have come from the store; until then nothing is offered.
    #[must_use]
    pub fn has_recovered(&self) -> bool {
        self.recovery.complete
    }

    /// The job on which workers died again and again, if the search has asked for it.
    #[must_use]
    pub fn poison(&self) -> Option<Job> {
        self.poison.clone()
    }

    /// What was refused because it contradicts what is known.
    #[must_use]
    pub fn garbage(&self) -> &GarbageTally {
        &self.garbage
    }

    /// Messages to be sent, in order.
    pub fn take_outgoing(&mut self) -> Vec<Outgoing> {
        std::mem::take(&mut self.out)
    }

    fn register(&mut self, job: &Job) -> JobId {
        let id = self.job_id(job);
        if self.jobs.insert(id, job.clone()).is_none()
            && let Some(outcome) = self.outcomes.get(&id)
            && let Some(reason) = fits::misfit(id, job, outcome)
        {
            self.hopeless.insert(id, AskFault::Refused { stage: job.stage(), reason });
        }
        id
    }

    /// Takes a message.
    pub fn hear(&mut self, now: Duration, incoming: Incoming) {
        let Incoming { topic, sender, job, message } = incoming;
        match (message, job) {
            (Message::Hello(hello), _) => {
                self.roster.hear(now, sender, &hello, (&self.statement, self.statement_digest));
            }
            (Message::Heartbeat(heartbeat), _) => {
                self.roster.hear(now, sender, &heartbeat.hello, (&self.statement, self.statement_digest));
                self.flights.beat(now, sender, &heartbeat.held);
            }
            (Message::Gone(gone), _) if sender == MemberId::SUPERVISOR => {
                self.roster.lose(&gone);
                self.flights.land_all_of(gone.member);
                if let Some((job, deaths)) = gone.died_on.filter(|(_, deaths)| *deaths >= POISON_DEATHS) {
                    self.poisoned(job, deaths);
                }
            }
            (Message::Started, Some(job)) => self.flights.started(sender, job),
            (Message::Outcome(outcome), Some(job)) => self.record(sender, topic, job, *outcome),
            (Message::Declined(refusal), Some(job)) => self.declined(sender, job, refusal),
            (Message::Kept(kept), _) => self.recover(kept),
            (Message::Product(bytes), _) => self.receive(bytes),
            (Message::Absent(digest), _) => self.absent(digest),
            (Message::Started | Message::Outcome(_) | Message::Declined(_), None) => self.garbage.count(Garbage::Claim),
            _ => {}
        }
    }

    fn poisoned(&mut self, id: JobId, deaths: u32) {
        let Some(job) = self.jobs.get(&id) else { return };
        let (stage, replay) = (job.stage(), format!("{}-{:?}.job", job.stage(), id.0));
        self.hopeless.insert(id, AskFault::PoisonJob { stage, deaths, replay });
        if self.asked.contains(&id) {
            self.poison = Some(job.clone());
        }
    }

    fn record(&mut self, sender: MemberId, topic: Topic, id: JobId, outcome: Outcome) {
        let Topic::Outcome(stage) = topic else { return };
        self.flights.land(sender, id);
        if self.jobs.get(&id).is_some_and(|job| job.stage() != stage) {
            return self.garbage.count(Garbage::Claim);
        }
        match self.outcomes.get(&id) {
            Some(known) if *known != outcome => {
                self.hopeless.insert(id, AskFault::Nondeterministic { stage });
            }
            Some(_) => {}
            None => {
                let misfit = self.jobs.get(&id).and_then(|job| fits::misfit(id, job, &outcome));
                if let Some(reason) = misfit {
                    self.hopeless.insert(id, AskFault::Refused { stage, reason });
                }
                self.outcomes.insert(id, outcome);
                self.news = true;
            }
        }
        if self.remaking.remove(&id) {
            self.lacking.retain(|_, makers| {
                makers.remove(&id);
                !makers.is_empty()
            });
        }
    }

    fn declined(&mut self, sender: MemberId, id: JobId, refusal: Refusal) {
        if !self.flights.land(sender, id) {
            return;
        }
        match refusal {
            Refusal::Cancelled => {}
            Refusal::Lacking(product) => self.remake(id, product),
            Refusal::Unfit(reason) => {
                if let Some(stage) = self.jobs.get(&id).map(Job::stage) {
                    self.hopeless.insert(id, AskFault::Refused { stage, reason });
                }
            }
        }
    }

    /// The maker of a lost product is asked again, and `id` waits for it.
    fn remake(&mut self, id: JobId, product: ProductRef) {
        let maker = product.made_by;
        let times = self.remade.entry(maker).or_insert(0);
        *times += 1;
        if let Some(stage) = self.jobs.get(&id).map(Job::stage)
            && (*times > REMAKES || !self.jobs.contains_key(&maker))
        {
            let reason = format!("product {:?} can be had nowhere", product.digest);
            self.hopeless.insert(id, AskFault::Refused { stage, reason });
            return;
        }
        self.lacking.entry(id).or_default().insert(maker);
        self.remaking.insert(maker);
    }

    fn recover(&mut self, kept: Kept) {
        for (id, outcome) in kept.outcomes {
            self.outcomes.entry(id).or_insert(outcome);
        }
        self.recovery.batches.insert(kept.batch);
        self.recovery.complete |= self.recovery.batches.len() >= kept.batches as usize;
        self.news = true;
    }

    fn receive(&mut self, bytes: Arc<[u8]>) {
        if let Some(fetching) = &mut self.fetching
            && fetching.bytes.is_none()
            && Digest::of_product(&bytes) == fetching.product.digest
        {
            fetching.bytes = Some(bytes);
        }
    }

    fn absent(&mut self, digest: Digest) {
        let Some(product) = self.fetching.as_ref().map(|fetching| fetching.product) else { return };
        if product.digest == digest && !self.remaking.contains(&product.made_by) {
            // Its own maker waits for nothing but itself.
            self.remake(product.made_by, product);
            self.lacking.remove(&product.made_by);
        }
    }

    /// Requests to the store that are due.
    fn want(&mut self, now: Duration) {
        let due = |wanted: Option<Duration>| wanted.is_none_or(|wanted| now >= wanted + WANT_AGAIN);
        if !self.recovery.complete && due(self.recovery.wanted) {
            self.recovery.wanted = Some(now);
            self.out.push(Outgoing::plain(Topic::Want, Message::Want(Want::Outcomes)));
        }
        if let Some(fetching) = self.fetching.as_mut().filter(|fetching| fetching.bytes.is_none())
            && due(fetching.wanted)
            && !self.remaking.contains(&fetching.product.made_by)
        {
            fetching.wanted = Some(now);
            let want = Want::Product(fetching.product.digest);
            self.out.push(Outgoing::plain(Topic::Want, Message::Want(want)));
        }
    }
}
