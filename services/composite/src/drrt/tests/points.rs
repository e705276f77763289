//! Orderings on all points of pairs, checked on the finished schedule.

use contract::Commitment;
use model::Point;

use super::stepper::replay;
use super::toy::{Dice, Order, Places, place};

/// When a point of a pair is, as the checker of plans defines it: the arm is first folded after an event, the base has
/// come to stand until the next one but not before the arm is folded.
fn time_of(commitments: &[Commitment], robot: usize, position: usize, point: Point) -> f64 {
    let mode = |step: usize| {
        commitments.iter().find(|c| c.mode.robot.index() == robot && c.mode.step as usize == step).unwrap()
    };
    let begins = |step: usize| if step == 0 { 0.0 } else { mode(step - 1).event_s };
    let folded = |step: usize| {
        let first = mode(step).moves.iter().find(|m| m.to[3] == 0.0);
        if step == 0 { 0.0 } else { first.map_or(begins(step), |m| m.ends_s) }
    };
    let arrived = |step: usize| {
        let last = mode(step).moves.iter().rfind(|m| place(&m.from) != place(&m.to));
        last.map_or(begins(step), |m| m.ends_s).max(folded(step))
    };
    let pick = 2 * position;
    match point {
        Point::Start => folded(pick),
        Point::AtPick => arrived(pick),
        Point::Grasp => mode(pick).event_s,
        Point::Carry => folded(pick + 1),
        Point::AtPlace => arrived(pick + 1),
        Point::Release => mode(pick + 1).event_s,
        Point::Done => folded(pick + 2),
    }
}

/// A ring with a bay at each corner, two robots with two pairs each.
fn scene(orders: Vec<Order>) -> Places {
    let mut edges: Vec<(usize, usize, f64)> = (0..6).map(|a| (a, (a + 1) % 6, 1.0)).collect();
    edges.extend((0..6).map(|a| (a, a + 6, 1.0)));
    let tasks = vec![(0, 0, 6, 8), (0, 1, 9, 6), (1, 2, 10, 7), (1, 3, 11, 10)];
    Places { edges, starts: vec![0, 3], tasks, objects: 4, orders, blocks: Vec::new(), grip_time: 0.5 }
}

#[test]
fn every_ordering_between_points_of_two_robots_is_kept() {
    for (i, first) in Point::ALL.into_iter().enumerate() {
        for (j, second) in Point::ALL.into_iter().enumerate() {
            let order = ((1, first), (3, second));
            let toy = scene(vec![order]).toy((7 * i + j) as u64);
            let commitments = toy.solve(20_000).unwrap_or_else(|report| panic!("{order:?}: {report:?}"));
            replay(&toy, &commitments).unwrap_or_else(|wrong| panic!("{order:?}: {wrong}"));
            let (before, after) = (time_of(&commitments, 0, 1, first), time_of(&commitments, 1, 1, second));
            assert!(before + 1e-9 <= after, "{order:?}: {before} {after}");
        }
    }
}

#[test]
fn several_orderings_at_once_are_kept_or_found_to_be_too_many() {
    let (mut kept, mut refused) = (0, 0);
    for seed in 0..60 {
        let mut dice = Dice::new(seed);
        let point = |dice: &mut Dice| Point::ALL[1 + dice.below(6)];
        let mut orders: Vec<Order> = Vec::new();
        for _ in 0..3 {
            let (a, b) = ((dice.below(2), point(&mut dice)), (2 + dice.below(2), point(&mut dice)));
            let order = if dice.chance(0.5) { (a, b) } else { (b, a) };
            orders.push(order);
            if skeleton::Skeleton::of_problem(&super::toy::problem(
                &[0, 3],
                &[(0, 0), (0, 1), (1, 2), (1, 3)],
                4,
                &orders,
                0.5,
            ))
            .is_err()
            {
                orders.pop();
            }
        }
        let toy = scene(orders.clone()).toy(seed);
        match toy.solve(100_000) {
            Ok(commitments) => {
                replay(&toy, &commitments).unwrap_or_else(|wrong| panic!("seed {seed}, {orders:?}: {wrong}"));
                for ((p, first), (q, second)) in &orders {
                    let time = |pair: usize, point| time_of(&commitments, pair / 2, pair % 2, point);
                    let (before, after) = (time(*p, *first), time(*q, *second));
                    assert!(before + 1e-9 <= after, "seed {seed}, {orders:?}: {before} {after}");
                }
                kept += 1;
            }
            Err(report) => {
                println!("seed {seed}: {orders:?} {report:?}");
                refused += 1;
            }
        }
    }
    println!("{kept} kept, {refused} refused");
    assert!(kept >= 50, "{kept} kept, {refused} refused");
}
