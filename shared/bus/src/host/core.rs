//! The supervisor's side of the bus without threads and clock: members, statement, store, deaths, and the end.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use contract::{Digest, JobId, LedgerEntry, Outcome, ProblemStatement, StageKind};
use model::RobotId;

use super::Store;
use crate::{
    CONTRACT_VERSION, Committed, Garbage, GarbageTally, Gone, HEARTBEAT, Hello, Incoming, MemberId, Message, Outgoing,
    Role, SearchEnd, Topic, Want,
};

/// The statement is not repeated more often than this.
const STATEMENT_AGAIN: Duration = HEARTBEAT;
/// A wanted product may still be on its way to the store for this long.
const ON_ITS_WAY: Duration = Duration::from_millis(300);

/// A member that has been started.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Expected {
    /// Name for people.
    pub name: String,
    /// What it does.
    pub role: Role,
    /// The robot it is there for.
    pub robot: Option<RobotId>,
}

/// Something worth telling the user.
#[derive(Clone, Debug, PartialEq)]
pub enum Note {
    /// All members have joined.
    Ready {
        /// How many.
        members: usize,
    },
    /// A job was answered.
    Answered {
        /// Stage.
        stage: StageKind,
        /// Job.
        job: JobId,
        /// What was answered.
        outcome: Box<Outcome>,
        /// From the worker's beginning to its answer, as seen from here.
        took: Duration,
    },
    /// The search committed an entry.
    Committed(LedgerEntry),
    /// A member is of no use: it speaks another contract, or runs another implementation than its stage's first.
    Unfit {
        /// Name.
        name: String,
        /// Why.
        why: String,
    },
}

/// Why a run cannot go on.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum HostFault {
    /// A stage gave two different outcomes for one job.
    #[error("stage {stage} gave two different outcomes for job {job:?}")]
    Nondeterministic {
        /// Stage.
        stage: StageKind,
        /// Job.
        job: JobId,
    },
    /// A refiner that came back committed something else.
    #[error("the search that came back differs from itself at entry {index} of the ledger")]
    Diverged {
        /// Entry.
        index: u64,
    },
    /// A member cannot take part.
    #[error("{name} cannot take part: {why}")]
    Unfit {
        /// Name.
        name: String,
        /// Why.
        why: String,
    },
}

struct Member {
    expected: Expected,
    hello: Option<Hello>,
    heard: Duration,
    started: Option<(JobId, Duration)>,
}

/// State of the supervisor's side.
pub struct HostCore {
    statement: ProblemStatement,
    fixed: Option<Arc<ProblemStatement>>,
    statement_sent: Option<Duration>,
    statement_wanted: bool,
    members: BTreeMap<MemberId, Member>,
    store: Store,
    missing: Vec<(Digest, Duration)>,
    deaths: BTreeMap<JobId, u32>,
    ledger: Vec<LedgerEntry>,
    end: Option<SearchEnd>,
    fault: Option<HostFault>,
    garbage: GarbageTally,
    notes: Vec<Note>,
    out: Vec<Outgoing>,
}

impl HostCore {
    /// A run of a statement, whose implementations are still to be fixed.
    #[must_use]
    pub fn new(statement: ProblemStatement) -> Self {
        Self {
            statement,
            fixed: None,
            statement_sent: None,
            statement_wanted: false,
            members: BTreeMap::new(),
            store: Store::default(),
            missing: Vec::new(),
            deaths: BTreeMap::new(),
            ledger: Vec::new(),
            end: None,
            fault: None,
            garbage: GarbageTally::default(),
            notes: Vec::new(),
            out: Vec::new(),
        }
    }

    /// A member has been started.
    pub fn expect(&mut self, now: Duration, member: MemberId, expected: Expected) {
        self.members.insert(member, Member { expected, hello: None, heard: now, started: None });
    }

    /// Takes a message.
    pub fn hear(&mut self, now: Duration, incoming: Incoming) {
        let Incoming { topic, sender, job, message } = incoming;
        let Some(member) = self.members.get_mut(&sender) else {
            return self.hear_stranger(topic, job, message);
        };
        member.heard = now;
        match message {
            Message::Hello(hello) => self.greet(now, sender, hello),
            Message::Started => member.started = job.map(|job| (job, now)),
            Message::Outcome(_) | Message::Declined(_) => {
                let begun =
                    member.started.take_if(|(started, _)| Some(*started) == job).map_or(now, |(_, begun)| begun);
                self.keep(topic, job, message, now.saturating_sub(begun));
            }
            Message::Product(bytes) => self.store.keep_product(bytes),
            Message::Want(want) => self.serve(now, &want),
            Message::Committed(committed) => self.commit(committed),
            Message::SearchEnd(end) => self.conclude(*end),
            _ => {}
        }
    }

    /// What a member that is gone has left behind still counts; nobody else is known.
    fn hear_stranger(&mut self, topic: Topic, job: Option<JobId>, message: Message) {
        match message {
            Message::Outcome(_) => self.keep(topic, job, message, Duration::ZERO),
            Message::Product(bytes) => self.store.keep_product(bytes),
            Message::Gone(_) => {}
            _ => self.garbage.count(Garbage::Claim),
        }
    }

    fn keep(&mut self, topic: Topic, job: Option<JobId>, message: Message, took: Duration) {
        let (Topic::Outcome(stage), Some(job), Message::Outcome(outcome)) = (topic, job, message) else { return };
        let known = self.store.outcome_count();
        if !self.store.keep_outcome(job, &outcome) {
            self.fault.get_or_insert(HostFault::Nondeterministic { stage, job });
        } else if self.store.outcome_count() > known {
            self.notes.push(Note::Answered { stage, job, outcome, took });
        }
    }

    fn greet(&mut self, now: Duration, sender: MemberId, hello: Hello) {
        let Some(member) = self.members.get_mut(&sender) else { return };
        if hello.role != member.expected.role {
            return self.garbage.count(Garbage::Claim);
        }
        if hello.contract_version != CONTRACT_VERSION {
            let why = format!("it speaks contract version {}, not {CONTRACT_VERSION}", hello.contract_version);
            self.fault.get_or_insert(HostFault::Unfit { name: member.expected.name.clone(), why });
            return;
        }
        let (first, lacks) = (member.hello.is_none(), hello.statement.is_none());
        member.hello = Some(hello);
        if first && self.fixed.is_some() {
            self.check_implementation(sender);
        }
        self.statement_wanted |= lacks && self.fixed.is_some();
        self.fix_statement();
        self.send_statement(now);
    }

    /// Once everybody is there: one implementation for each stage, that of its first member.
    fn fix_statement(&mut self) {
        if self.fixed.is_some() || self.members.is_empty() || self.members.values().any(|member| member.hello.is_none())
        {
            return;
        }
        let mut implementations: BTreeMap<StageKind, String> = BTreeMap::new();
        for hello in self.members.values().filter_map(|member| member.hello.as_ref()) {
            if let Role::Worker(stage) = hello.role {
                implementations.entry(stage).or_insert_with(|| hello.implementation.clone());
            }
        }
        self.statement.implementations.append(&mut implementations);
        self.fixed = Some(Arc::new(self.statement.clone()));
        self.statement_wanted = true;
        for member in self.members.keys().copied().collect::<Vec<_>>() {
            self.check_implementation(member);
        }
        self.notes.push(Note::Ready { members: self.members.len() });
    }

    fn check_implementation(&mut self, member: MemberId) {
        let hello = self.members.get(&member).and_then(|member| member.hello.as_ref());
        let (Some(hello), Some(statement)) = (hello, &self.fixed) else { return };
        let Role::Worker(stage) = hello.role else { return };
        let fixed = statement.implementation(stage);
        if hello.implementation != fixed {
            let why = format!("it runs {}, but this run's {stage} is {fixed}", hello.implementation);
            self.notes.push(Note::Unfit { name: hello.name.clone(), why });
        }
    }

    fn send_statement(&mut self, now: Duration) {
        let due = self.statement_sent.is_none_or(|sent| now >= sent + STATEMENT_AGAIN);
        if let Some(statement) = self.fixed.as_ref().filter(|_| self.statement_wanted && due) {
            self.statement_wanted = false;
            self.statement_sent = Some(now);
            self.out.push(Outgoing::plain(Topic::Problem, Message::Statement(statement.clone())));
        }
    }

    fn serve(&mut self, now: Duration, want: &Want) {
        match want {
            Want::Product(digest) => match self.store.product(digest) {
                Some(bytes) => self.out.push(Outgoing::plain(Topic::Delivery, Message::Product(bytes))),
                None => self.missing.push((*digest, now + ON_ITS_WAY)),
            },
            Want::Outcomes => {
                let kept = self.store.batches().into_iter();
                self.out.extend(kept.map(|kept| Outgoing::plain(Topic::Delivery, Message::Kept(kept))));
            }
        }
    }

    fn commit(&mut self, committed: Committed) {
        let known = usize::try_from(committed.index).ok().and_then(|index| self.ledger.get(index));
        match known {
            Some(entry) if *entry == committed.entry => {}
            Some(_) => {
                self.fault.get_or_insert(HostFault::Diverged { index: committed.index });
            }
            // What was missed is in the search's end.
            None if committed.index == self.ledger.len() as u64 => {
                self.notes.push(Note::Committed(committed.entry.clone()));
                self.ledger.push(committed.entry);
            }
            None => {}
        }
    }

    fn conclude(&mut self, end: SearchEnd) {
        let differs = self.ledger.iter().zip(&end.ledger.entries).position(|(known, new)| known != new);
        if let Some(index) = differs {
            self.fault.get_or_insert(HostFault::Diverged { index: index as u64 });
        }
        self.end.get_or_insert(end);
    }

    /// Does what is due.
    pub fn tick(&mut self, now: Duration) {
        self.fix_statement();
        self.send_statement(now);
        let store = &self.store;
        let out = &mut self.out;
        self.missing.retain(|(digest, until)| {
            let message = match store.product(digest) {
                Some(bytes) => Message::Product(bytes),
                None if now >= *until => Message::Absent(*digest),
                None => return true,
            };
            out.push(Outgoing::plain(Topic::Delivery, message));
            false
        });
    }

    /// A member has gone. `returns`: another one will be started in its place.
    pub fn lose(&mut self, member: MemberId, returns: bool) {
        let Some(lost) = self.members.remove(&member) else { return };
        let died_on = lost.started.map(|(job, _)| {
            let deaths = self.deaths.entry(job).or_insert(0);
            *deaths += 1;
            (job, *deaths)
        });
        let stage = match lost.expected.role {
            Role::Worker(stage) => Some(stage),
            Role::Supervisor | Role::Refiner => None,
        };
        let others = self.members.values().filter(|other| other.expected.role == lost.expected.role).count();
        let left = u32::try_from(others).unwrap_or(u32::MAX).saturating_add(u32::from(returns));
        self.out.push(Outgoing::plain(Topic::Presence, Message::Gone(Gone { member, stage, left, died_on })));
    }

    /// Members that have not been heard of for longer than `silence`.
    #[must_use]
    pub fn silent(&self, now: Duration, silence: Duration) -> Vec<MemberId> {
        self.members.iter().filter(|(_, member)| now > member.heard + silence).map(|(id, _)| *id).collect()
    }

    /// Messages to be sent, in order.
    pub fn take_outgoing(&mut self) -> Vec<Outgoing> {
        std::mem::take(&mut self.out)
    }

    /// What is worth telling.
    pub fn take_notes(&mut self) -> Vec<Note> {
        std::mem::take(&mut self.notes)
    }

    /// Why the run cannot go on.
    #[must_use]
    pub fn fault(&self) -> Option<&HostFault> {
        self.fault.as_ref()
    }

    /// The end of the search.
    pub fn take_end(&mut self) -> Option<SearchEnd> {
        self.end.take()
    }

    /// What the search has committed so far.
    #[must_use]
    pub fn ledger(&self) -> &[LedgerEntry] {
        &self.ledger
    }

    /// The statement with the implementations of this run, once all members have joined.
    #[must_use]
    pub fn fixed_statement(&self) -> Option<Arc<ProblemStatement>> {
        self.fixed.clone()
    }

    /// Outcomes and products.
    #[must_use]
    pub fn store(&self) -> &Store {
        &self.store
    }

    /// What was refused because it contradicts what is known.
    #[must_use]
    pub fn garbage(&self) -> &GarbageTally {
        &self.garbage
    }
}
