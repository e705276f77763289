//! Runs of a toy set over channels, in which things go wrong.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use bus::{Bus, BusFault, Channels, Connection, Envelope, MemberId, Outbox, Role, RunKey, Topic};
use contract::{AskFault, DirectCalls, Ledger, RandomStream, Stage, StageKind};

use crate::set::{Seat, ToySet, mortal};
use crate::toy::{ToyStage, toy_statement, whole_log};
use crate::watchdog::Watchdog;

/// The toy stages called directly: the oracle.
pub fn direct(seed: u64) -> DirectCalls {
    let stages: BTreeMap<StageKind, Box<dyn Stage>> =
        StageKind::ALL.map(|stage| (stage, Box::<ToyStage>::default() as Box<dyn Stage>)).into();
    DirectCalls::new(Arc::new(toy_statement(seed)), stages, Arc::default())
}

fn reference(seed: u64) -> Ledger {
    whole_log(&toy_statement(seed), &mut direct(seed)).0
}

fn set() -> ToySet {
    ToySet::new(Arc::new(Channels::default()), RunKey::of_name("runs"))
}

#[test]
fn the_toy_search_backtracks_and_solves() {
    let ledgers: Vec<Ledger> = (0..20).map(reference).collect();
    let has = |ledger: &Ledger, wanted: fn(&contract::LedgerEntry) -> bool| ledger.entries.iter().any(wanted);
    assert!(ledgers.iter().any(|ledger| has(ledger, |e| matches!(e, contract::LedgerEntry::Backtrack { .. }))));
    let solved = ledgers.iter().filter(|ledger| has(ledger, |e| matches!(e, contract::LedgerEntry::Solved { .. })));
    assert!(solved.count() > 10);
    assert_ne!(ledgers[0], ledgers[1]);
}

#[test]
fn the_depth_of_speculation_changes_what_is_done_and_not_what_is_committed() {
    let _watchdog = Watchdog::start("speculation");
    for seed in 0..6 {
        for speculation in [0, 1, 3, 100] {
            let run = ToySet { speculation, seed, ..set() }.run();
            assert_eq!(run.ledger, reference(seed), "seed {seed}, depth {speculation}");
        }
    }
}

#[test]
fn workers_that_die_at_work_come_back_and_nothing_is_lost() {
    let _watchdog = Watchdog::start("deaths");
    for stage in StageKind::ALL {
        let run = ToySet { stage: mortal(stage, 2), ..set() }.run();
        assert_eq!(run.deaths, 2, "{stage}");
        assert_eq!(run.ledger, reference(0), "{stage}");
    }
}

#[test]
fn the_third_death_on_one_job_ends_the_search_and_names_the_job() {
    let _watchdog = Watchdog::start("poison");
    let run = ToySet { stage: mortal(StageKind::Placement, 3), speculation: 0, ..set() }.run();
    let Err(AskFault::PoisonJob { stage, deaths, replay }) = run.end else { panic!("{:?}", run.end) };
    assert_eq!((stage, deaths), (StageKind::Placement, 3));
    let job = run.search_end.poison.unwrap();
    assert_eq!(job.stage(), StageKind::Placement);
    assert_eq!(replay, format!("placement-{:?}.job", job.id(&toy_statement(0)).0));
    assert!(run.ledger.entries.is_empty());
}

#[test]
fn when_no_worker_of_a_stage_is_left_the_search_is_told() {
    let _watchdog = Watchdog::start("no worker");
    let run = ToySet { stage: mortal(StageKind::Transition, 1), returns: false, ..set() }.run();
    assert_eq!(run.end, Err(AskFault::NoWorker { stage: StageKind::Transition }));
}

#[test]
fn a_robots_jobs_go_to_another_worker_when_its_own_has_gone() {
    let _watchdog = Watchdog::start("other worker");
    let run = ToySet { stage: mortal(StageKind::Roadmap, 1), returns: false, ..set() }.run();
    assert_eq!(run.deaths, 1);
    assert_eq!(run.ledger, reference(0));
}

#[test]
fn a_time_limit_ends_the_search_with_a_prefix_of_the_reference() {
    let _watchdog = Watchdog::start("limit");
    let stage = Arc::new(|seat: &Seat| {
        // The composite stage never ends.
        let endless = seat.role == Role::Worker(StageKind::Composite);
        ToyStage { labour: if endless { u64::MAX } else { 0 }, ..ToyStage::default() }
    });
    let run = ToySet { stage, time_limit: Some(Duration::from_millis(700)), ..set() }.run();
    assert_eq!(run.end, Err(AskFault::TimeLimit));
    let reference = reference(0);
    assert!(run.ledger.entries.len() < reference.entries.len());
    assert_eq!(run.ledger.entries, reference.entries[..run.ledger.entries.len()]);
}

#[test]
fn a_refiner_that_dies_and_comes_back_reaches_the_same_ledger() {
    let _watchdog = Watchdog::start("refiner");
    let reference = reference(0);
    for entry in [0, 7, reference.entries.len() as u64 / 2, reference.entries.len() as u64 - 1] {
        let run = ToySet { refiner_dies_at: Some(entry), ..set() }.run();
        assert_eq!((run.deaths, run.ledger), (1, reference.clone()), "died at entry {entry}");
    }
}

/// Channels on which a fault is put between every member and its outbox.
struct Faulty {
    inner: Channels,
    fault: Arc<Fault>,
}

/// What becomes of a message.
type Fault = dyn Fn(Topic, &Envelope) -> Passes + Send + Sync;

#[derive(Clone, Copy)]
enum Passes {
    Not,
    Once,
    Twice,
}

struct FaultyOutbox {
    inner: Box<dyn Outbox>,
    fault: Arc<Fault>,
}

impl Bus for Faulty {
    fn join(&self, role: Role, member: MemberId) -> Result<Connection, BusFault> {
        let Connection { inbox, outbox, pulse, clock } = self.inner.join(role, member)?;
        let faulty =
            |inner: Box<dyn Outbox>| Box::new(FaultyOutbox { inner, fault: self.fault.clone() }) as Box<dyn Outbox>;
        Ok(Connection { inbox, outbox: faulty(outbox), pulse: faulty(pulse), clock })
    }
}

impl Outbox for FaultyOutbox {
    fn send(&mut self, topic: Topic, header: &Envelope, part: &[u8]) -> Result<(), BusFault> {
        let times = match (self.fault)(topic, header) {
            Passes::Not => 0,
            Passes::Once => 1,
            Passes::Twice => 2,
        };
        (0..times).try_for_each(|_| self.inner.send(topic, header, part))
    }

    fn wake(&mut self, role: Role) {
        self.inner.wake(role);
    }

    fn part_bytes(&self, topic: Topic) -> usize {
        self.inner.part_bytes(topic)
    }
}

fn faulty(fault: impl Fn(Topic, &Envelope) -> Passes + Send + Sync + 'static) -> ToySet {
    let bus = Faulty { inner: Channels::default(), fault: Arc::new(fault) };
    ToySet::new(Arc::new(bus), RunKey::of_name("faulty"))
}

#[test]
fn messages_that_are_lost_or_doubled_cost_time_and_change_nothing() {
    let _watchdog = Watchdog::start("lossy");
    for seed in 0..3 {
        let stream = RandomStream::new(seed, StageKind::Placement, &[], "loss");
        let count = AtomicU32::new(0);
        let set = faulty(move |topic, _| {
            // Who starts and stops processes is not in doubt; everything else may be lost or doubled.
            let [chance] = stream.unit(u64::from(count.fetch_add(1, Ordering::Relaxed)));
            match topic {
                Topic::Shutdown => Passes::Once,
                _ if chance < 0.08 => Passes::Not,
                _ if chance < 0.16 => Passes::Twice,
                _ => Passes::Once,
            }
        });
        let run = ToySet { seed, ..set }.run();
        assert_eq!(run.ledger, reference(seed), "seed {seed}");
    }
}

#[test]
fn products_that_are_lost_are_made_again() {
    let _watchdog = Watchdog::start("lost products");
    let lost = AtomicU32::new(0);
    let lossy = faulty(move |topic, _| {
        let loses = topic == Topic::Product && lost.fetch_add(1, Ordering::Relaxed) < 3;
        if loses { Passes::Not } else { Passes::Once }
    });
    let run = ToySet { speculation: 0, ..lossy }.run();
    assert_eq!(run.ledger, reference(0));
    assert!(run.plan.is_some());
}
