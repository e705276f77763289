//! Going on after a committed prefix.

use contract::{Commitment, Interrupted, Move};

use plan::Cause;

use super::stepper::replay;
use super::toy::{Places, Toy};

/// The first `count` commitments, each robot's last with a tail: what it did next until the last event among them.
fn cut(all: &[Commitment], count: usize) -> Vec<Commitment> {
    let mut done: Vec<Commitment> = all[..count].to_vec();
    let until_s = done.last().map_or(0.0, |c| c.event_s);
    for i in 0..count {
        let mode = done[i].mode;
        let next = all.iter().find(|c| c.mode.robot == mode.robot && c.mode.step == mode.step + 1);
        let is_last = !done[i + 1..].iter().any(|c| c.mode.robot == mode.robot);
        if let (Some(next), true) = (next, is_last) {
            let begun = next.moves.iter().filter(|m| m.begins_s < until_s);
            done[i].tail = begun.map(|m| Move { ends_s: m.ends_s.min(until_s), ..m.clone() }).collect();
        }
    }
    done
}

fn scene() -> Places {
    let mut edges: Vec<(usize, usize, f64)> = (1..7).map(|b| (b - 1, b, 1.0)).collect();
    edges.extend([(3, 7, 1.0), (1, 8, 1.5)]);
    let tasks = vec![(0, 0, 0, 4), (1, 1, 6, 2), (0, 1, 2, 5), (1, 0, 4, 1)];
    Places { edges, starts: vec![0, 6], tasks, objects: 2, orders: Vec::new(), blocks: Vec::new(), grip_time: 0.5 }
}

fn solved_after(toy: &Toy, done: &[Commitment]) -> Vec<Commitment> {
    toy.solve_after(done, 50_000).0.unwrap().unwrap_or_else(|report| panic!("{} done: {report:?}", done.len()))
}

#[test]
fn the_search_goes_on_from_every_prefix_once_both_robots_have_begun() {
    let mut cuts = 0;
    for seed in 0..6 {
        let toy = scene().toy(seed);
        let all = solved_after(&toy, &[]);
        for count in 0..all.len() {
            // A robot that has not begun stands at its start, so others' motion must not count on its having left.
            let has_begun = |robot: usize| all[..count].iter().any(|c| c.mode.robot.index() == robot);
            if count > 0 && !(has_begun(0) && has_begun(1)) {
                continue;
            }
            let done = cut(&all, count);
            let more = solved_after(&toy, &done);
            let mut whole: Vec<Commitment> =
                done.iter().map(|c| Commitment { tail: Vec::new(), ..c.clone() }).collect();
            whole.extend(more);
            replay(&toy, &whole).unwrap_or_else(|wrong| panic!("seed {seed}, {count} done: {wrong}"));
            cuts += 1;
        }
    }
    assert!(cuts >= 30, "{cuts}");
}

#[test]
fn a_prefix_with_all_modes_needs_nothing_more() {
    let toy = scene().toy(0);
    let all = solved_after(&toy, &[]);
    assert_eq!(solved_after(&toy, &all), []);
}

#[test]
fn a_robot_whose_return_is_committed_never_moves_again() {
    // Robot 0 is done and stands between robot 1 and its work; aside of it there is room.
    let edges = vec![(0, 1, 1.0), (1, 2, 1.0), (1, 3, 1.0)];
    let tasks = vec![(0, 0, 1, 1), (1, 1, 2, 0)];
    let scene = Places { edges, tasks, objects: 2, starts: vec![1, 0], ..scene() };
    let toy = scene.toy(0);
    let all = solved_after(&toy, &[]);
    let mut done: Vec<Commitment> = all.iter().filter(|c| c.mode.robot.index() == 0).cloned().collect();
    // As if robot 0 had been quick and had not had to move aside.
    for (i, c) in done.iter_mut().enumerate() {
        let (begins_s, ends_s) = (i as f64 * 2.0, (i + 1) as f64 * 2.0);
        let standing =
            Move { from: c.moves[0].from.clone(), to: c.moves[0].from.clone(), begins_s, ends_s, ..c.moves[0].clone() };
        (c.moves, c.event_s) = (vec![standing], ends_s);
    }
    let at_goal = |c: &mut Commitment, arm: f64| c.moves[0].to[3] = arm;
    done[..2].iter_mut().for_each(|c| at_goal(c, 1.0));
    done[2].moves[0].from[3] = 1.0;
    at_goal(&mut done[2], 0.0);
    let report = toy.solve_after(&done, 50_000).0.unwrap().unwrap_err();
    let robots = vec!["r0".to_owned(), "r1".to_owned()];
    assert!(report.causes.iter().any(|(cause, _)| *cause == Cause::Deadlock { robots: robots.clone() }), "{report:?}");
    assert!(!report.causes.iter().any(|(cause, _)| matches!(cause, Cause::Budget { .. })), "{report:?}");
}

#[test]
fn a_tail_that_leaves_the_roadmap_is_refused() {
    let toy = scene().toy(0);
    let all = solved_after(&toy, &[]);
    let mut done = cut(&all, 3);
    let last = done.last_mut().unwrap();
    let here = last.moves.last().unwrap().clone();
    let to = vec![0.5, 0.0, 0.0, 0.0];
    last.tail = vec![Move { from: here.to.clone(), to, begins_s: here.ends_s, ends_s: here.ends_s + 5.0, ..here }];
    assert!(matches!(toy.solve_after(&done, 1000).0, Err(Interrupted::Unfit(_))));
}
