//! Levels of composite planning on toy worlds, through the whole search: what mode by mode commitment does, what it does
//! with robots that give way, what repairs do, and what is left to the composite search. Whether a world has a plan at all is told by an
//! exhaustive search of its composite states.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

#[allow(dead_code, reason = "tests of the stage use the rest")]
#[path = "../../services/composite/tests/composite/oracle.rs"]
mod oracle;
#[allow(dead_code, reason = "tests of the stage use the rest")]
#[path = "../../services/composite/tests/composite/toys.rs"]
mod toys;

use contract::{
    Alternative, Answer, AskFault, AskStages, CauseTally, CompositeMethod, Composition, Decision, Foresight, Job,
    JobId, Ledger, LedgerEntry, Outcome, Placed, PlacementCandidate, Product, ProductRef, Reach, Request, StageKind,
};
use model::{FixedId, GraspId, PairId};
use refiner::{End, refine_plan};
use toys::{Dice, Errand, Toy, World, at};

/// The stages of a toy world: one placement, one way to do each pair, its graph as every roadmap; composite is real.
struct ToyStages {
    toy: Toy,
    /// What the plan was assembled from.
    complete: Option<ProductRef>,
    /// Whether a repair may succeed.
    repairs: bool,
}

impl AskStages for ToyStages {
    fn ask(&mut self, jobs: &[Job]) -> Result<Vec<Outcome>, AskFault> {
        jobs.iter().map(|job| self.answer(job)).collect()
    }

    fn foresee(&mut self, _: Foresight) {}

    fn job_id(&self, job: &Job) -> JobId {
        job.id(&self.toy.statement)
    }
}

impl ToyStages {
    fn answer(&mut self, job: &Job) -> Result<Outcome, AskFault> {
        let unfit = |error: contract::Interrupted| AskFault::Refused { stage: job.stage(), reason: error.to_string() };
        let answer = match &job.request {
            Request::Placement(placement) if placement.first > 0 || !placement.nogoods.is_empty() => {
                return Ok(Outcome::soft_failure(CauseTally::default(), 0, 1));
            }
            Request::Placement(_) => Answer::Placements(vec![self.placement()]),
            Request::Hop(_) => {
                return Err(unfit(contract::Interrupted::Unfit("hops are placed all at once here".into())));
            }
            Request::Transition(transition) => Answer::Alternatives(vec![self.alternative(transition.pair)]),
            Request::Samples(_) => Answer::Samples(Vec::new()),
            Request::GraspBlockers(blockers) => Answer::Blocked(vec![false; blockers.standing.len()]),
            Request::Blockers(blockers) => Answer::Blocked(vec![false; blockers.standing.len()]),
            Request::Piece(_) => {
                Answer::Piece(ProductRef { digest: job.id(&self.toy.statement).0, made_by: self.job_id(job) })
            }
            Request::Mode(mode) => {
                let roadmap = self.toy.put(&Product::Mode(self.toy.roadmap(mode.mode)));
                Answer::Mode { roadmap, shortest_s: 0.0, in_the_way: vec![] }
            }
            Request::Compose(compose) => {
                if !self.repairs && matches!(compose.composition, Composition::Repair { .. }) {
                    return Ok(Outcome::soft_failure(CauseTally::default(), 0, 1));
                }
                if let Composition::Assemble { prefix, .. } = &compose.composition {
                    self.complete = Some(*prefix);
                }
                return self.toy.ask(job).map_err(unfit);
            }
        };
        Ok(Outcome::answer(answer, 1))
    }

    fn placement(&self) -> PlacementCandidate {
        let errands = &self.toy.world.errands;
        let placed = |(i, errand): (usize, &Errand)| Placed {
            pair: PairId::at(i),
            sample: 0,
            world_from_object: self.toy.world.stand_of(errand.to),
        };
        PlacementCandidate { index: 0, placements: errands.iter().enumerate().map(placed).collect(), orders: vec![] }
    }

    fn alternative(&self, pair: PairId) -> Alternative {
        let errand = self.toy.world.errands[pair.index()];
        let reach = |vertex: usize| {
            let q = at(self.toy.world.points[vertex], None);
            let (stand, way) = (q.clone(), vec![q.clone()]);
            Reach { stand, at_object: q, approach: way.clone(), lift: way, lift_up: 0, support: FixedId(0) }
        };
        Alternative { index: 0, grasp: GraspId(0), pick: reach(errand.from), place: reach(errand.to) }
    }
}

/// How the search went in one world.
struct Found {
    solved: bool,
    /// Whether mode by mode commitment ever came to a dead end.
    dead_end: bool,
    /// Whether a repair was tried.
    repaired: bool,
    /// Whether the composite search was asked.
    handed_over: bool,
}

fn search(world: &World, method: CompositeMethod, repairs: bool, name: &str) -> Found {
    let mut toy = world.clone().build();
    toy.statement.composite = method;
    toy.statement.problem.levels.highest = 0;
    let statement = toy.statement.clone();
    let mut stages = ToyStages { toy, complete: None, repairs };
    let refinement = refine_plan(&statement, &mut stages, &mut |_| ());
    let solved = match (&refinement.end, stages.complete) {
        (End::Solved { .. }, Some(complete)) => {
            oracle::assert_free(&stages.toy, &stages.toy.commitments(complete), name);
            true
        }
        (End::Failed { .. }, _) => false,
        (end, _) => panic!("{name}: {end:?}"),
    };
    let has = |wanted: &dyn Fn(&LedgerEntry) -> bool| has(&refinement.ledger, wanted);
    let is_dead_end = |entry: &LedgerEntry| {
        matches!(entry, LedgerEntry::Backtrack { stage: StageKind::Composite, decision: Decision::Commit(_), .. })
    };
    let is_drrt = |entry: &LedgerEntry| matches!(entry, LedgerEntry::Decided(Decision::Drrt));
    let is_repair = |entry: &LedgerEntry| matches!(entry, LedgerEntry::Decided(Decision::Repair(_)));
    Found { solved, dead_end: has(&is_dead_end), repaired: has(&is_repair), handed_over: has(&is_drrt) }
}

fn has(ledger: &Ledger, wanted: &dyn Fn(&LedgerEntry) -> bool) -> bool {
    ledger.entries.iter().any(wanted)
}

/// A corridor with bays. Robots are at home in the corridor, in one another's way, and have errands between bays.
fn narrow(dice: &mut Dice, robots: usize) -> World {
    let length = 5;
    let mut world = World::grid(length, 1, 0.7);
    for bay in 0..length {
        world.ways.push((bay, world.points.len()));
        world.points.push([bay as f64 * 0.7, if dice.below(2) == 0 { 0.7 } else { -0.7 }]);
    }
    let draw = |from: &mut Vec<usize>, dice: &mut Dice| from.swap_remove(dice.below(from.len()));
    let (mut homes, mut bays): (Vec<usize>, Vec<usize>) = ((0..length).collect(), (length..2 * length).collect());
    world.starts = (0..robots).map(|_| draw(&mut homes, dice)).collect();
    for robot in 0..robots {
        let from = draw(&mut bays, dice);
        let to = if robot == 0 { draw(&mut bays, dice) } else { from };
        world.errands.push(Errand { robot, object: robot, from, to });
        world.objects.push(from);
    }
    world
}

#[test]
fn worlds_where_commitment_comes_to_a_dead_end_are_planned_by_giving_way_and_by_repairs() {
    let (mut feasible, mut straight, mut given_way, mut repaired, mut handed_over) = (0, 0, 0, 0, 0);
    for seed in 0..60 {
        let world = narrow(&mut Dice(seed * 6151 + 17), 2);
        let name = format!("narrow {seed}");
        let possible = search(&world, CompositeMethod::Drrt, true, &name).solved;
        let found = search(&world, CompositeMethod::Prioritised, true, &name);
        assert_eq!(found.solved, possible, "{name}");
        feasible += usize::from(possible);
        straight += usize::from(found.solved && !found.dead_end);
        given_way += usize::from(found.solved && found.dead_end && !found.repaired && !found.handed_over);
        handed_over += usize::from(found.solved && found.handed_over);
        if found.solved && found.repaired && !found.handed_over {
            let without = search(&world, CompositeMethod::Prioritised, false, &name);
            assert!(without.solved && without.handed_over, "{name}: planned without a repair, too");
            repaired += 1;
        }
    }
    println!(
        "{feasible} of 60 can be planned: {straight} at once, {given_way} by giving way, {repaired} by repairs, \
         {handed_over} by dRRT*"
    );
    assert!(given_way >= 5 && repaired >= 6 && handed_over < repaired, "{given_way}, {repaired}, {handed_over}");
}

#[test]
fn an_object_that_would_shut_somebody_in_is_put_down_after_that_robot_has_come_out() {
    // Robot 1 works at the end of a corridor, at whose beginning robot 2 puts an object, from a place beside it.
    let mut world = World::grid(5, 1, 0.7);
    world.points.extend([[0.35, -1.8], [0.35, -1.0], [0.35, -0.25]]);
    world.ways.extend([(5, 6), (6, 7)]);
    world.starts = vec![0, 6];
    world.objects = vec![4, 5];
    world.errands =
        vec![Errand { robot: 0, object: 0, from: 4, to: 4 }, Errand { robot: 1, object: 1, from: 5, to: 7 }];
    let found = search(&world, CompositeMethod::Prioritised, true, "shut in");
    assert!(found.solved && found.dead_end, "the object never was in the way");
    assert!(!found.repaired && !found.handed_over, "giving way was not enough");
}
