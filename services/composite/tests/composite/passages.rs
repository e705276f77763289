//! Modes that another robot makes impossible wherever it is: what is told is never wrong.

use contract::{Answer, Composition, ModeRoadmap, Product, ProductRef, VertexId};
use model::RobotId;
use plan::Cause;
use skeleton::ModeId;

use crate::toys::{Dice, Errand, Toy, World, mode};

/// Robot 1 drives along a corridor of six points; robot 2 lives at points of its own beside it, and carries its object from
/// the first of them to the last.
fn beside(own: &[[f64; 2]]) -> Toy {
    let mut world = World::grid(6, 1, 0.7);
    let first = world.points.len();
    world.points.extend(own);
    world.ways.extend((1..own.len()).map(|i| (first + i - 1, first + i)));
    let last = world.points.len() - 1;
    world.starts = vec![0, first];
    world.objects = vec![5, first];
    world.errands =
        vec![Errand { robot: 0, object: 0, from: 5, to: 5 }, Errand { robot: 1, object: 1, from: first, to: last }];
    world.build()
}

fn roadmaps(toy: &Toy, edit: impl Fn(&mut ModeRoadmap)) -> Vec<Vec<ProductRef>> {
    let put = |mode: &skeleton::Mode| {
        let mut roadmap = toy.roadmap(mode.id);
        edit(&mut roadmap);
        toy.put(&Product::Mode(roadmap))
    };
    toy.skeleton().modes.iter().map(|modes| modes.iter().map(put).collect()).collect()
}

fn without_passage(toy: &Toy) -> Vec<(ModeId, RobotId)> {
    let job = toy.job(Composition::Passages { roadmaps: roadmaps(toy, |_| ()) });
    match toy.ask(&job).unwrap().result {
        Ok(Answer::NoPassage(modes)) => modes,
        other => panic!("{other:?}"),
    }
}

/// Whether there is composite motion: by the composite search, whose "no" is definite.
fn is_possible(toy: &Toy) -> bool {
    let outcome = toy.ask(&toy.job(Composition::Drrt { prefix: None, roadmaps: roadmaps(toy, |_| ()) })).unwrap();
    match outcome.result {
        Ok(_) => true,
        Err(report) => {
            let ran_out = report.causes.iter().any(|(cause, _)| matches!(cause, Cause::Budget { .. }));
            assert!(!ran_out, "{report:?}");
            false
        }
    }
}

#[test]
fn a_robot_that_is_in_the_way_wherever_it_is_leaves_no_passage_and_one_that_can_leave_does() {
    // Both of its points are nearer to the corridor than two radii.
    let blocked = without_passage(&beside(&[[1.75, 0.3], [1.95, 0.3]]));
    let r2 = RobotId::at(1);
    assert_eq!(blocked, [(mode(0, 0), r2), (mode(0, 2), r2)]);
    assert_eq!(without_passage(&beside(&[[1.75, 0.3], [1.75, 1.5]])), []);
}

#[test]
fn a_robot_without_work_is_in_the_way_where_it_stands() {
    let mut world = World::grid(6, 1, 0.7);
    world.points.push([1.75, 0.3]);
    world.starts = vec![0, 6];
    world.objects = vec![5];
    world.errands = vec![Errand { robot: 0, object: 0, from: 5, to: 5 }];
    let blocked = without_passage(&world.build());
    assert_eq!(blocked.first(), Some(&(mode(0, 0), RobotId::at(1))));
}

#[test]
fn where_a_mode_has_no_passage_there_is_no_composite_motion() {
    let (mut told, mut possible) = (0, 0);
    for seed in 0..60 {
        let mut dice = Dice(seed * 7919 + 5);
        let middle = 0.9 + 1.7 * dice.unit();
        let count = 1 + dice.below(3);
        let point = |dice: &mut Dice| [middle + 0.6 * dice.unit() - 0.3, 0.2 + 0.3 * dice.unit()];
        let own: Vec<[f64; 2]> = (0..count).map(|_| point(&mut dice)).collect();
        let toy = beside(&own);
        let blocked = without_passage(&toy);
        let is_possible = is_possible(&toy);
        assert!(blocked.is_empty() || !is_possible, "seed {seed}, {own:?}: {blocked:?}, but there is motion");
        told += usize::from(!blocked.is_empty());
        possible += usize::from(is_possible);
    }
    println!("no passage in {told} of 60, {possible} possible");
    assert!(told >= 10 && possible >= 10, "{told}, {possible}");
}

#[test]
fn a_goal_that_the_roadmap_does_not_reach_is_no_passage_either() {
    let toy = beside(&[[1.75, 1.5]]);
    let cut = |roadmap: &mut ModeRoadmap| {
        if roadmap.mode == mode(0, 0) {
            roadmap.edges.retain(|edge| edge.b != VertexId::at(5));
        }
    };
    let job = toy.job(Composition::Passages { roadmaps: roadmaps(&toy, cut) });
    let outcome = toy.ask(&job).unwrap();
    assert_eq!(outcome.result, Ok(Answer::NoPassage(vec![(mode(0, 0), RobotId::at(1))])));
}
