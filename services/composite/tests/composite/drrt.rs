//! The composite search on discs, through the stage: free of contact in every sampled instant, and assembled.

use composite::Conflicts;
use contract::{Answer, Commitment, Composition, FailureReport, ModeRoadmap, Product, ProductRef};
use model::{RobotId, Standing};
use plan::Cause;
use skeleton::Occupancy;

use collision::{Geometry, Motion};

use crate::oracle::assert_free;
use crate::toys::{Dice, Errand, Toy, World, random_world};

/// Roadmaps of all modes, annotated as the roadmap stage does: poses that may be there block edges.
fn roadmaps(toy: &Toy) -> Vec<Vec<ProductRef>> {
    let geometry = std::sync::Arc::new(Geometry::new(toy.problem()).unwrap());
    let conflicts = Conflicts::new(geometry);
    let skeleton = toy.skeleton();
    let annotated = |mode: &skeleton::Mode| {
        let mut roadmap = toy.roadmap(mode.id);
        let may_be_there = |o: &Occupancy| skeleton.graph.may_overlap(skeleton.interval_of(*o), mode.interval());
        roadmap.possible = skeleton.occupancies().filter(may_be_there).collect();
        annotate(toy, &conflicts, &mut roadmap);
        toy.put(&Product::Mode(roadmap))
    };
    skeleton.modes.iter().map(|modes| modes.iter().map(annotated).collect()).collect()
}

fn annotate(toy: &Toy, conflicts: &Conflicts, roadmap: &mut ModeRoadmap) {
    let robot: RobotId = roadmap.mode.robot;
    for edge in &mut roadmap.edges {
        let end = |vertex: contract::VertexId| roadmap.vertices[vertex.index()].clone();
        let (from, to, allowed, holding) = (end(edge.a), end(edge.b), edge.allowed, roadmap.holding);
        let motion = Motion { robot, holding, from, to, allowed };
        let blocks = |o: &Occupancy| {
            let world_from_object = toy.assignment.poses[o.object.index()][o.hop as usize];
            conflicts.motion_hits(&motion, &Standing { object: o.object, world_from_object })
        };
        edge.blockers = (0..).zip(&roadmap.possible).filter(|(_, o)| blocks(o)).map(|(i, _)| i).collect();
    }
}

/// A prefix with all modes, or why there is none; also the work spent.
fn search(toy: &Toy, prefix: Option<ProductRef>, budget: u64) -> (Result<ProductRef, FailureReport>, u64) {
    let mut job = toy.job(Composition::Drrt { prefix, roadmaps: roadmaps(toy) });
    job.budget = budget;
    let outcome = toy.ask(&job).unwrap();
    let found = outcome.result.map(|answer| match answer {
        Answer::Committed { prefix, .. } => prefix,
        other => panic!("{other:?}"),
    });
    (found, outcome.work)
}

fn check(toy: &Toy, complete: ProductRef, name: &str) {
    assert!(toy.is_complete(Some(complete)), "{name}");
    let commitments: Vec<Commitment> = toy.commitments(complete);
    assert_free(toy, &commitments, name);
    let searched_s = commitments.iter().fold(0.0, |end: f64, c| end.max(c.event_s));
    let plan = toy.assemble(complete);
    assert!(plan.makespan.total_s <= searched_s + 1e-6, "{name}: {} after {searched_s}", plan.makespan.total_s);
}

#[test]
fn random_worlds_are_solved_without_contact_and_retimed_no_longer() {
    let (mut solved, mut spent) = (0, 0);
    for seed in 0..24 {
        let mut dice = Dice(seed);
        let (robots, errands) = [(2, 2), (3, 1), (3, 2), (4, 1)][seed as usize % 4];
        let toy = random_world(&mut dice, 7, 5, robots, errands).build();
        let (found, work) = search(&toy, None, 20_000);
        spent += work;
        match found {
            Ok(complete) => {
                check(&toy, complete, &format!("world {seed}"));
                solved += 1;
            }
            Err(report) => println!("world {seed}: {report:?}"),
        }
    }
    println!("{solved} of 24 with {spent} work units");
    assert!(solved >= 22, "{solved}");
}

#[test]
fn the_search_goes_on_after_modes_committed_one_by_one() {
    let mut went_on = 0;
    for seed in 0..6 {
        let toy = random_world(&mut Dice(100 + seed), 7, 5, 2, 2).build();
        let mut prefixes: Vec<Vec<Commitment>> = Vec::new();
        toy.commit_all(|commitments| prefixes.push(commitments.to_vec()));
        for commitments in prefixes {
            let name = format!("world {seed} after {}", commitments.len());
            let prefix = toy.put(&Product::Prefix(contract::Prefix { parent: None, commitments, tails: vec![] }));
            match search(&toy, Some(prefix), 20_000).0 {
                Ok(complete) => {
                    check(&toy, complete, &name);
                    went_on += 1;
                }
                Err(report) => println!("{name}: {report:?}"),
            }
        }
    }
    println!("{went_on} prefixes");
    assert!(went_on >= 40, "{went_on}");
}

/// A corridor of nine points and a tenth beside its left end. Robot 1 has work beyond the right end, robot 2 at the tenth
/// point, and each stands on the other's side.
fn swap(bay: bool) -> Toy {
    let mut world = World::grid(9, 1, 0.7);
    world.points.push([0.0, -0.8]);
    world.ways.push((0, 9));
    if bay {
        world.points.push([2.8, 0.8]);
        world.ways.push((4, 10));
    }
    world.starts = vec![1, 7];
    world.objects = vec![8, 9];
    world.errands =
        vec![Errand { robot: 0, object: 0, from: 8, to: 8 }, Errand { robot: 1, object: 1, from: 9, to: 9 }];
    world.build()
}

#[test]
fn discs_swap_the_ends_of_a_corridor_only_where_there_is_a_bay() {
    let toy = swap(true);
    let (found, _) = search(&toy, None, 20_000);
    check(&toy, found.unwrap(), "corridor with bay");
    let (found, _) = search(&swap(false), None, 200_000);
    let report = found.unwrap_err();
    let robots = vec!["r1".to_owned(), "r2".to_owned()];
    assert!(report.causes.iter().any(|(cause, _)| *cause == Cause::Deadlock { robots: robots.clone() }), "{report:?}");
    assert!(!report.causes.iter().any(|(cause, _)| matches!(cause, Cause::Budget { .. })), "{report:?}");
}

#[test]
fn equal_jobs_have_equal_outcomes() {
    let toy = || random_world(&mut Dice(7), 7, 5, 3, 1).build();
    let (first, second) = (search(&toy(), None, 20_000), search(&toy(), None, 20_000));
    assert_eq!(first.1, second.1);
    assert_eq!(first.0.unwrap(), second.0.unwrap());
}
