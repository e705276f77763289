//! Agreement with the oracle on random toys.

use contract::{EdgeKind, RandomStream, StageKind, VertexId};
use skeleton::{Occupancy, Skeleton};

use super::super::{composite_roadmap::CompositeRoadmap, meter::Meter, search::Search, start::Start};
use super::brute;
use super::stepper::replay;
use super::toy::{Dice, Order, Place, Places, Table, Task, Toy, configuration, edge, problem, roadmap};
use crate::CommittedMotion;
use model::Point;

const BUDGET: u64 = 200_000;

/// A robot's own places joined at random, other edges and numbers in each mode; conflicts, blockers and hits at random.
pub fn tables(seed: u64) -> Toy {
    let mut dice = Dice::new(seed);
    let robots = 2 + dice.below(2);
    let places = if robots == 2 { 3 + dice.below(6) } else { 3 + dice.below(3) };
    let objects = 1 + dice.below(2);
    let tasks: Vec<Task> = (0..1 + dice.below(3)).map(|_| (dice.below(robots), dice.below(objects))).collect();
    let starts: Vec<usize> = (0..robots).map(|_| dice.below(places)).collect();
    let (problem, skeleton) = with_orders(&mut dice, &starts, &tasks, objects);
    let possible: Vec<Occupancy> = skeleton.occupancies().collect();
    let blocked = [0.0, 0.05, 0.2][dice.below(3)];
    let mut roadmaps = Vec::new();
    for robot in 0..robots {
        let mut here = starts[robot];
        let mut own = Vec::new();
        for step in 0..skeleton.modes[robot].len() {
            let last = step + 1 == skeleton.modes[robot].len();
            let there = if last { starts[robot] } else { dice.below(places) };
            // Vertex v stands for place (v + shift) mod places.
            let shift = dice.below(places);
            let vertex = |place: usize| (place + places - shift) % places;
            let vertices = (0..places).map(|v| configuration((v + shift) % places, false)).collect();
            let mut edges = Vec::new();
            for a in 1..places {
                let joined = dice.below(a);
                for b in 0..a {
                    if b == joined || dice.chance(0.15) {
                        let duration = 0.5 + dice.below(8) as f64 / 4.0;
                        let blockers = (0..possible.len() as u32).filter(|_| dice.chance(blocked)).collect();
                        edges.push(edge(a, b, EdgeKind::Base, duration, blockers));
                    }
                }
            }
            own.push(roadmap(robot, step, vertices, edges, vertex(here), vertex(there), possible.clone()));
            here = there;
        }
        roadmaps.push(own);
    }
    let (rate, salt) = ([0.02, 0.1, 0.2, 0.4][dice.below(4)], dice.below(1 << 30) as u64);
    let random = move |key: &[usize], rate: f64| {
        Dice::new(key.iter().fold(salt, |hash, x| hash.wrapping_mul(1_000_003).wrapping_add(*x as u64 + 1)))
            .chance(rate)
    };
    let conflict = move |a: Place, b: Place| random(&[a.0, a.1 as usize, a.2, a.3, b.0, b.1 as usize, b.2, b.3], rate);
    let hit = move |a: Place, o: Occupancy| random(&[a.0, a.2, o.object.index(), o.hop as usize], 0.3);
    let table = Table { conflict: Box::new(conflict), hit: Box::new(hit) };
    Toy { statement: statement(problem, seed), skeleton, roadmaps, table }
}

fn statement(problem: model::Problem, seed: u64) -> contract::ProblemStatement {
    contract::ProblemStatement::new(problem, seed, contract::CompositeMethod::Drrt)
}

/// A problem with up to two random orderings between grasps and releases that contradict nothing.
fn with_orders(dice: &mut Dice, starts: &[usize], tasks: &[Task], objects: usize) -> (model::Problem, Skeleton) {
    let mut orders: Vec<Order> = Vec::new();
    // The hops of an object and the orders of robots may already contradict one another; then hop order wins.
    let mut made = problem(starts, tasks, objects, &orders, 0.5);
    let mut skeleton = Skeleton::of_problem(&made).unwrap();
    for _ in 0..dice.below(3) {
        let mut any = || (dice.below(tasks.len()), [Point::Grasp, Point::Release][dice.below(2)]);
        let order = (any(), any());
        orders.push(order);
        let more = problem(starts, tasks, objects, &orders, 0.5);
        match Skeleton::of_problem(&more) {
            Ok(longer) => (made, skeleton) = (more, longer),
            Err(_) => {
                orders.pop();
            }
        }
    }
    (made, skeleton)
}

/// Few shared places, one robot each: who is where matters.
pub fn crowded(seed: u64) -> Toy {
    let mut dice = Dice::new(seed ^ 0xc0ffee);
    let robots = 2 + dice.below(2);
    let places = robots + 2 + dice.below(if robots == 2 { 5 } else { 3 });
    let mut edges = Vec::new();
    for a in 1..places {
        // A path with few branches and few cycles.
        let b = if dice.chance(0.7) { a - 1 } else { dice.below(a) };
        edges.push((a, b, 1.0 + dice.below(3) as f64 / 2.0));
        if dice.chance(0.15) {
            edges.push((a, dice.below(a), 1.5));
        }
    }
    let objects = 1 + dice.below(2);
    let mut tasks: Vec<(usize, usize, usize, usize)> = Vec::new();
    for _ in 0..1 + dice.below(3) {
        let (robot, object) = (dice.below(robots), dice.below(objects));
        let picked = tasks.iter().rfind(|task| task.1 == object).map(|task| task.3);
        tasks.push((robot, object, picked.unwrap_or_else(|| dice.below(places)), dice.below(places)));
    }
    let mut starts: Vec<usize> = (0..places).collect();
    (0..places).for_each(|i| starts.swap(i, dice.below(places)));
    starts.truncate(robots);
    let mut blocks = Vec::new();
    for object in 0..objects {
        for hop in 0..=tasks.iter().filter(|task| task.1 == object).count() {
            if dice.chance(0.2) {
                let occupancy = Occupancy { object: model::ObjectId::at(object), hop: hop as u32 };
                blocks.push((occupancy, dice.below(places)));
            }
        }
    }
    Places { edges, starts, tasks, objects, orders: Vec::new(), blocks, grip_time: 0.25 }.toy(seed)
}

/// Solvable, unsolvable, sum of cost over optimum, and how many were solved by the optimum.
#[derive(Default, Debug)]
struct Tally {
    solvable: usize,
    unsolvable: usize,
    ratios: f64,
    optimal: usize,
}

impl Tally {
    fn compare(&mut self, toy: &Toy, name: &str) {
        let optimum = brute::optimum(toy);
        match (toy.solve(BUDGET), optimum) {
            (Ok(commitments), Some(optimum)) => {
                let end = replay(toy, &commitments).unwrap_or_else(|wrong| panic!("{name}: {wrong}"));
                assert!(end >= optimum - 1e-9, "{name}: {end} is below the optimum {optimum}");
                self.solvable += 1;
                self.ratios += if optimum > 0.0 { end / optimum } else { 1.0 };
                self.optimal += usize::from(end <= optimum + 1e-9);
            }
            (Err(report), None) => {
                let budget = report.causes.iter().any(|(cause, _)| matches!(cause, plan::Cause::Budget { .. }));
                assert!(!budget, "{name}: {report:?}");
                self.unsolvable += 1;
            }
            (Ok(_), None) => panic!("{name}: solved, but there is no way"),
            (Err(report), Some(optimum)) => panic!("{name}: there is a way of {optimum} s, but {report:?}"),
        }
    }

    fn report(&self, what: &str) {
        let mean = self.ratios / self.solvable as f64;
        println!("{what}: {self:?}, mean cost over optimum {mean:.3}");
    }
}

/// Whether the search by chance alone finds a way, with work units spent and iterations.
fn by_chance(toy: &Toy, budget: u64) -> (bool, u64) {
    let problem = &toy.statement.problem;
    let roadmap = CompositeRoadmap::new(problem, &toy.skeleton, &toy.roadmaps).unwrap();
    let start = Start::after(&CommittedMotion::default(), &roadmap).unwrap();
    let root: Vec<(u32, VertexId)> = start.robots.iter().map(|robot| (robot.phase, robot.vertex)).collect();
    let random = RandomStream::new(toy.statement.seed, StageKind::Composite, &["toy"], "drrt");
    let mut search = Search::new(&roadmap, &toy.table, &root, random);
    let spent = toy.with_context(budget, |context| {
        let mut meter = Meter::new(context, budget);
        search.run(&mut meter).unwrap();
        meter.spent()
    });
    if let Some(solution) = search.solution {
        check_cost(&mut search, solution);
    }
    (search.solution.is_some(), spent)
}

/// However often the tree was rewired, a node's cost is the time of the way to it.
fn check_cost(search: &mut Search<'_, Table>, node: usize) {
    let mut state = search.tree.get(0).state.clone();
    let mut time_s = 0.0;
    for acts in search.tree.path_to(node) {
        let step = search.rules.checked_step(&state, &acts).unwrap();
        (state, time_s) = (step.to, time_s + step.duration_s);
    }
    assert_eq!(state, search.tree.get(node).state);
    assert!((time_s - search.tree.get(node).cost_s).abs() < 1e-9);
}

#[test]
fn chance_alone_finds_nearly_every_way_there_is() {
    let (mut ways, mut found, mut spent) = (0, 0, Vec::new());
    for seed in 0..500 {
        for toy in [tables(seed), crowded(seed)] {
            if brute::optimum(&toy).is_none() {
                continue;
            }
            ways += 1;
            let (is_found, units) = by_chance(&toy, 20_000);
            found += usize::from(is_found);
            spent.push(units);
        }
    }
    spent.sort_unstable();
    let at = |share: f64| spent[((spent.len() - 1) as f64 * share) as usize];
    println!("{found} of {ways} by chance; work units: median {}, 90 % {}, most {}", at(0.5), at(0.9), at(1.0));
    assert!(found as f64 >= 0.98 * ways as f64);
}

#[test]
fn random_tables_are_solved_exactly_when_there_is_a_way() {
    let mut tally = Tally::default();
    for seed in 0..500 {
        tally.compare(&tables(seed), &format!("tables({seed})"));
    }
    tally.report("tables");
    assert!(tally.solvable >= 50 && tally.unsolvable >= 50, "{tally:?}");
}

#[test]
fn crowded_places_are_solved_exactly_when_there_is_a_way() {
    let mut tally = Tally::default();
    for seed in 0..500 {
        tally.compare(&crowded(seed), &format!("crowded({seed})"));
    }
    tally.report("crowded");
    assert!(tally.solvable >= 50 && tally.unsolvable >= 50, "{tally:?}");
}
