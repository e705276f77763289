//! The dispatcher alone, in a time of its own.

use std::sync::Arc;
use std::time::Duration;

use bus::{
    Dispatcher, Gone, HEARTBEAT, Heartbeat, Hello, Incoming, JobOffer, Kept, MemberId, Message, Outgoing, Retirement,
    Role, Topic, statement_digest,
};
use contract::{
    Answer, AskFault, Digest, Foresight, Job, JobId, Outcome, PieceJob, PieceSpec, PlacementJob, ProblemStatement,
    ProductRef, Refusal, Request, StageKind,
};
use model::RobotId;

use crate::set::{hello, seats};
use crate::toy::toy_statement;

/// A dispatcher with the toy set's workers 1 to 5, and its clock.
struct Table {
    statement: Arc<ProblemStatement>,
    dispatcher: Dispatcher,
    now: Duration,
}

impl Table {
    fn new(speculation: usize) -> Self {
        let statement = Arc::new(toy_statement(0));
        let dispatcher = Dispatcher::new(statement.clone(), speculation);
        let mut table = Self { statement, dispatcher, now: Duration::ZERO };
        table.hear(0, Topic::Delivery, None, Message::Kept(Kept { batch: 0, batches: 1, outcomes: Vec::new() }));
        for member in 1..=5 {
            table.beat(member, &[]);
        }
        table
    }

    fn hello(&self, member: u32) -> Hello {
        Hello { statement: Some(statement_digest(&self.statement)), ..hello(&seats()[member as usize]) }
    }

    fn hear(&mut self, sender: u32, topic: Topic, job: Option<JobId>, message: Message) {
        self.dispatcher.hear(self.now, Incoming { topic, sender: MemberId(sender), job, message });
    }

    fn beat(&mut self, member: u32, held: &[JobId]) {
        let heartbeat = Heartbeat { hello: self.hello(member), held: held.to_vec(), done: 0 };
        self.hear(member, Topic::Presence, None, Message::Heartbeat(heartbeat));
    }

    /// All workers give a sign of life and hold these jobs; then time goes on by a heartbeat.
    fn all_beat(&mut self, held: &[JobId]) {
        self.now += HEARTBEAT;
        for member in 1..=5 {
            self.beat(member, held);
        }
    }

    fn sent(&mut self) -> Vec<Outgoing> {
        self.dispatcher.tick(self.now);
        self.dispatcher.take_outgoing().into_iter().filter(|sent| !matches!(sent.message, Message::Want(_))).collect()
    }

    fn offers(&mut self) -> Vec<JobOffer> {
        let offer = |sent: Outgoing| match sent.message {
            Message::Offer(offer) => Some(*offer),
            _ => None,
        };
        self.sent().into_iter().filter_map(offer).collect()
    }

    fn answer(&mut self, member: u32, job: &Job, outcome: Outcome) {
        let id = job.id(&self.statement);
        self.hear(member, Topic::Outcome(job.stage()), Some(id), Message::Outcome(Box::new(outcome)));
    }
}

fn placement(first: u32) -> Job {
    let request = Request::Placement(PlacementJob { level: 0, first, count: 1, nogoods: Vec::new() });
    Job { request, budget: 1 }
}

fn piece(robot: u32, level: u32) -> Job {
    let piece = PieceJob { robot: RobotId(robot), holding: None, level, spec: PieceSpec::Base };
    Job { request: Request::Piece(piece), budget: 1 }
}

fn placed(work: u64) -> Outcome {
    Outcome::answer(Answer::Placements(Vec::new()), work)
}

#[test]
fn a_robots_jobs_are_offered_to_its_worker() {
    let mut table = Table::new(0);
    table.dispatcher.ask(&[piece(1, 0), piece(0, 0), placement(0)]);
    let offers = table.offers();
    assert_eq!(offers.iter().map(|offer| offer.to.0).collect::<Vec<_>>(), [4, 3, 1]);
    assert_eq!(offers.iter().map(|offer| offer.number).collect::<Vec<_>>(), [1, 2, 3]);
    assert!(table.offers().is_empty());
}

#[test]
fn outcomes_come_back_in_the_order_of_the_jobs() {
    let mut table = Table::new(0);
    let jobs = [placement(0), placement(1)];
    table.dispatcher.ask(&jobs);
    table.answer(1, &jobs[1], placed(1));
    assert_eq!(table.dispatcher.answer(), None);
    table.answer(1, &jobs[0], placed(2));
    assert_eq!(table.dispatcher.answer(), Some(Ok(vec![placed(2), placed(1)])));
}

#[test]
fn an_offer_that_two_heartbeats_do_not_show_is_made_again() {
    let mut table = Table::new(0);
    let job = placement(0);
    let id = job.id(&table.statement);
    table.dispatcher.ask(std::slice::from_ref(&job));
    assert_eq!(table.offers().len(), 1);
    for _ in 0..5 {
        table.all_beat(&[id]);
        assert!(table.offers().is_empty(), "it is held");
    }
    table.all_beat(&[]);
    assert!(table.offers().is_empty(), "one heartbeat proves nothing");
    table.all_beat(&[]);
    let again = table.offers();
    assert_eq!((again.len(), again[0].number, &again[0].job), (1, 2, &job));
}

#[test]
fn heartbeats_that_were_under_way_before_the_offer_do_not_count_against_it() {
    let mut table = Table::new(0);
    table.dispatcher.ask(&[placement(0)]);
    assert_eq!(table.offers().len(), 1);
    for _ in 0..4 {
        table.beat(1, &[]);
    }
    assert!(table.offers().is_empty());
}

#[test]
fn what_a_worker_held_that_has_gone_is_offered_to_its_successor() {
    let mut table = Table::new(0);
    table.dispatcher.ask(&[piece(0, 0)]);
    assert_eq!(table.offers()[0].to, MemberId(3));
    let gone = Gone { member: MemberId(3), stage: Some(StageKind::Roadmap), left: 2, died_on: None };
    table.hear(0, Topic::Presence, None, Message::Gone(gone));
    let again = table.offers();
    assert_eq!((again.len(), again[0].to), (1, MemberId(4)), "the other robot's worker is alive");
}

#[test]
fn only_the_supervisor_can_say_that_somebody_has_gone() {
    let mut table = Table::new(0);
    table.dispatcher.ask(&[placement(0)]);
    assert_eq!(table.offers().len(), 1);
    let gone = Gone { member: MemberId(1), stage: Some(StageKind::Placement), left: 0, died_on: None };
    table.hear(2, Topic::Presence, None, Message::Gone(gone));
    assert_eq!(table.dispatcher.answer(), None);
}

#[test]
fn silent_workers_get_nothing() {
    let mut table = Table::new(0);
    table.now += HEARTBEAT * 30;
    table.beat(2, &[]);
    table.dispatcher.ask(&[placement(0)]);
    assert!(table.offers().is_empty());
    table.beat(1, &[]);
    assert_eq!(table.offers().len(), 1);
}

#[test]
fn workers_of_another_implementation_or_statement_get_nothing() {
    let mut table = Table::new(0);
    let other = Hello { implementation: "other/1".to_owned(), ..table.hello(1) };
    table.hear(1, Topic::Presence, None, Message::Hello(other));
    table.dispatcher.ask(&[placement(0)]);
    assert!(table.offers().is_empty());
    let other = Hello { statement: Some(Digest([0; 32])), ..table.hello(1) };
    table.hear(1, Topic::Presence, None, Message::Hello(other));
    assert!(table.offers().is_empty());
}

#[test]
fn two_different_outcomes_for_one_job_are_a_fault_and_two_equal_ones_are_not() {
    let mut table = Table::new(0);
    let jobs = [placement(0)];
    table.dispatcher.ask(&jobs);
    table.answer(1, &jobs[0], placed(1));
    table.answer(7, &jobs[0], placed(1));
    assert_eq!(table.dispatcher.answer(), Some(Ok(vec![placed(1)])));
    table.answer(8, &jobs[0], placed(2));
    assert_eq!(table.dispatcher.answer(), Some(Err(AskFault::Nondeterministic { stage: StageKind::Placement })));
}

#[test]
fn an_answer_that_belongs_to_another_question_is_a_fault() {
    let mut table = Table::new(0);
    table.dispatcher.ask(&[placement(0)]);
    table.answer(1, &placement(0), Outcome::answer(Answer::Blocked(Vec::new()), 0));
    assert!(matches!(table.dispatcher.answer(), Some(Err(AskFault::Refused { stage: StageKind::Placement, .. }))));
}

#[test]
fn an_answer_that_names_another_jobs_product_is_a_fault() {
    let mut table = Table::new(0);
    table.dispatcher.ask(&[piece(0, 0)]);
    let product = ProductRef { digest: Digest([1; 32]), made_by: JobId(Digest([2; 32])) };
    table.answer(3, &piece(0, 0), Outcome::answer(Answer::Piece(product), 0));
    assert!(matches!(table.dispatcher.answer(), Some(Err(AskFault::Refused { stage: StageKind::Roadmap, .. }))));
}

#[test]
fn what_the_store_kept_is_not_asked_again() {
    let statement = Arc::new(toy_statement(0));
    let (kept, open) = (placement(0), placement(1));
    let dispatcher = Dispatcher::new(statement.clone(), 0);
    let mut table = Table { statement, dispatcher, now: Duration::ZERO };
    table.beat(1, &[]);
    table.dispatcher.ask(&[kept.clone(), open.clone()]);
    assert!(table.offers().is_empty(), "nothing is offered before the store has been heard");
    let outcomes = vec![(kept.id(&table.statement), placed(5))];
    let batch = |batch, outcomes| Message::Kept(Kept { batch, batches: 2, outcomes });
    table.hear(0, Topic::Delivery, None, batch(1, outcomes));
    table.hear(0, Topic::Delivery, None, batch(1, Vec::new()));
    assert!(table.offers().is_empty(), "a batch is missing");
    table.hear(0, Topic::Delivery, None, batch(0, Vec::new()));
    assert_eq!(table.offers().into_iter().map(|offer| offer.job).collect::<Vec<_>>(), [open]);
}

#[test]
fn what_is_neither_asked_for_nor_foreseen_any_more_is_retired() {
    let mut table = Table::new(4);
    table.dispatcher.foresee(Foresight::list(vec![piece(0, 0), piece(1, 0)]));
    let offers = table.offers();
    assert!(offers.len() == 2 && offers.iter().all(|offer| offer.speculative));
    table.dispatcher.ask(&[placement(0)]);
    table.dispatcher.foresee(Foresight::list(vec![piece(1, 0)]));
    let retired = table.sent().into_iter().find_map(|sent| match sent.message {
        Message::Retirement(retirement) => Some(retirement),
        _ => None,
    });
    let mut live = vec![placement(0).id(&table.statement), piece(1, 0).id(&table.statement)];
    live.sort();
    assert_eq!(retired, Some(Retirement { number: 2, live }));
    assert!(table.sent().is_empty(), "it is said once");
}

#[test]
fn what_was_retired_and_is_wanted_again_is_offered_again_under_a_later_number() {
    let mut table = Table::new(4);
    table.dispatcher.foresee(Foresight::list(vec![piece(0, 0)]));
    assert_eq!(table.offers().len(), 1);
    table.dispatcher.foresee(Foresight::nothing());
    assert_eq!(table.sent().len(), 1);
    table.dispatcher.ask(&[piece(0, 0)]);
    let again = table.offers();
    assert_eq!((again.len(), again[0].number, again[0].speculative), (1, 2, false));
}

#[test]
fn a_lost_product_is_asked_of_its_maker_before_the_job_is_offered_again() {
    let mut table = Table::new(0);
    let maker = piece(0, 0);
    table.dispatcher.ask(std::slice::from_ref(&maker));
    let product = ProductRef { digest: Digest([1; 32]), made_by: maker.id(&table.statement) };
    let made = Outcome::answer(Answer::Piece(product), 0);
    assert_eq!(table.offers().len(), 1);
    table.answer(3, &maker, made.clone());
    let reader = piece(1, 9);
    let id = reader.id(&table.statement);
    table.dispatcher.ask(std::slice::from_ref(&reader));
    assert_eq!(table.offers().len(), 1);
    let lacking = Message::Declined(Refusal::Lacking(product));
    table.hear(4, Topic::Outcome(StageKind::Roadmap), Some(id), lacking);
    let offers = table.offers();
    assert_eq!((offers.len(), offers[0].afresh, &offers[0].job), (1, true, &maker));
    table.answer(3, &maker, made);
    let offers = table.offers();
    assert_eq!((offers.len(), offers[0].afresh, &offers[0].job), (1, false, &reader));
}

#[test]
fn speculation_keeps_to_its_depth_and_to_idle_workers() {
    let mut table = Table::new(2);
    let jobs: Vec<Job> = (0..5).map(|level| piece(0, level)).chain([piece(1, 0)]).collect();
    table.dispatcher.foresee(Foresight::list(jobs));
    // Two jobs may be in work, but both are the first robot's, whose worker takes one at a time.
    assert_eq!(table.offers().len(), 1);
    table.answer(3, &piece(0, 0), piece_of(&table.statement, 0));
    assert_eq!(table.offers().iter().map(|offer| offer.job.clone()).collect::<Vec<_>>(), [piece(0, 1)]);
}

fn piece_of(statement: &ProblemStatement, level: u32) -> Outcome {
    let product = ProductRef { digest: Digest([1; 32]), made_by: piece(0, level).id(statement) };
    Outcome::answer(Answer::Piece(product), 0)
}

#[test]
fn a_job_that_kills_its_workers_ends_the_search_only_if_the_search_asks_for_it() {
    let mut table = Table::new(4);
    let deadly = piece(0, 0);
    let id = deadly.id(&table.statement);
    table.dispatcher.foresee(Foresight::list(vec![deadly.clone()]));
    assert_eq!(table.offers().len(), 1);
    let gone = Gone { member: MemberId(3), stage: Some(StageKind::Roadmap), left: 2, died_on: Some((id, 3)) };
    table.hear(0, Topic::Presence, None, Message::Gone(gone));
    table.dispatcher.ask(&[placement(0)]);
    assert_eq!(table.offers().len(), 1, "the deadly job is foreseen no more");
    assert_eq!(table.dispatcher.answer(), None);
    assert_eq!(table.dispatcher.poison(), None);
    table.dispatcher.ask(std::slice::from_ref(&deadly));
    assert!(table.offers().is_empty());
    assert!(matches!(table.dispatcher.answer(), Some(Err(AskFault::PoisonJob { deaths: 3, .. }))));
    assert_eq!(table.dispatcher.poison(), Some(deadly));
}

#[test]
fn workers_and_refiner_are_told_apart() {
    let mut table = Table::new(0);
    let refiner = Hello { role: Role::Refiner, ..table.hello(1) };
    table.hear(9, Topic::Presence, None, Message::Hello(refiner));
    table.dispatcher.ask(&[placement(0)]);
    assert_eq!(table.offers()[0].to, MemberId(1));
}
