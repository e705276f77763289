//! Prints how long the geometry's questions take (µs), on the tests' mobile arms and on figure 1.
#![allow(clippy::disallowed_methods, reason = "it measures")]
#![allow(clippy::unwrap_used, reason = "its input is its own")]

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;
use std::time::Instant;

use collision::{Geometry, Motion, Standing};
use common::*;
use model::{AllowedContacts, ObjectId, Problem, Robot, RobotId};

const R1: RobotId = RobotId(0);
const NOTHING: AllowedContacts = AllowedContacts { touch: None, support: None };

/// Mean time (µs) of one call over all inputs, the best of some rounds; answers `true` and `false` apart.
fn report<T>(name: &str, inputs: &[T], ask: impl Fn(&T) -> bool) {
    let (yes, no): (Vec<&T>, Vec<&T>) = inputs.iter().partition(|input| ask(input));
    for (answer, inputs) in [("contact", yes), ("clear", no)].into_iter().filter(|(_, inputs)| !inputs.is_empty()) {
        let mut best = f64::MAX;
        for _ in 0..7 {
            let start = Instant::now();
            for input in &inputs {
                black_box(ask(black_box(input)));
            }
            best = best.min(start.elapsed().as_secs_f64() * 1e6 / inputs.len() as f64);
        }
        println!("{name:<44} {answer:<8} {:>6} inputs {best:>9.2} us", inputs.len());
    }
}

fn motion(id: RobotId, from: Vec<f64>, to: Vec<f64>) -> Motion {
    Motion { robot: id, holding: None, from, to, allowed: NOTHING }
}

fn main() {
    println!("mobile arms among furniture");
    rates(&mobile_problem(), &[0.0, 0.9, -1.8, 0.0, 0.9, 0.0]);
    println!("figure 1");
    let problem = figure1();
    let home = problem.robots[0].home.clone();
    rates(&problem, &home);
}

fn rates(problem: &Problem, folded: &[f64]) {
    let geometry = Geometry::new(problem).unwrap();
    let robot = problem.robot(R1);
    let mut random = Random(1);
    let states: Vec<Vec<f64>> = (0..2000).map(|_| anywhere(robot, &mut random)).collect();
    report("forward kinematics only", &states, |q| kinematics::link_poses(robot, q, 0.08)[3].translation.z > 1e9);
    report("state_contact", &states, |q| geometry.state_contact(R1, None, q, NOTHING).is_some());
    let free = |m: &Motion| geometry.state_contact(R1, None, &m.from, NOTHING).is_none();
    let drives = states.iter().enumerate().map(|(i, state)| {
        let mut from = state.clone();
        from[3..].copy_from_slice(folded);
        let mut to = from.clone();
        let bearing = random.between(-3.1, 3.1);
        to[0] += 0.5 * bearing.cos();
        to[1] += 0.5 * bearing.sin();
        to[2] += if i % 2 == 0 { 0.0 } else { random.between(-0.5, 0.5) };
        motion(R1, from, to)
    });
    let drives: Vec<Motion> = drives.filter(free).collect();
    let (straight, turning): (Vec<_>, Vec<_>) = drives.into_iter().partition(|m| m.from[2] == m.to[2]);
    report("motion_contact, base drive 0.5 m", &straight, |m| geometry.motion_contact(m).is_some());
    report("motion_contact, base drive 0.5 m, turning", &turning, |m| geometry.motion_contact(m).is_some());
    let arms: Vec<Motion> = states.iter().map(|from| arm_motion(from, &mut random)).filter(free).collect();
    report("motion_contact, arm motion 0.5 rad", &arms, |m| geometry.motion_contact(m).is_some());
    with_standing(&geometry, &arms, &mut random);
    report("sweep", &arms, |m| geometry.sweep(m, 1, 4).growth() > 1e9);
    report("cells", &arms, |m| geometry.cells(m, 0.05) > 1_000_000);
    let pairs: Vec<_> = (0..3000)
        .map(|_| {
            let mut cell = |id, x, y| {
                let mut m = random_motion(&geometry, id, &mut random);
                let (dx, dy) = (x - m.from[0], y - m.from[1]);
                for q in [&mut m.from, &mut m.to] {
                    q[0] += dx;
                    q[1] += dy;
                }
                geometry.sweep(&m, 0, geometry.cells(&m, 0.05))
            };
            (cell(R1, 0.0, 0.0), cell(RobotId(1), 0.8, 0.3))
        })
        .collect();
    report("sweeps_conflict, reach 0.05 m, bases 0.85 m apart", &pairs, |(a, b)| geometry.sweeps_conflict(a, b));
}

/// Like [`random_configuration`], but the base anywhere within narrow limits.
fn anywhere(robot: &Robot, random: &mut Random) -> Vec<f64> {
    let mut q = random_configuration(robot, random);
    for (value, limits) in q.iter_mut().zip(&robot.coordinates).take(2).filter(|(_, c)| c.upper < 5.0) {
        *value = random.between(limits.lower, limits.upper);
    }
    q
}

fn arm_motion(from: &[f64], random: &mut Random) -> Motion {
    let step: Vec<f64> = (0..from.len()).map(|i| if i < 3 { 0.0 } else { random.between(-1.0, 1.0) }).collect();
    let length = step.iter().map(|d| d * d).sum::<f64>().sqrt();
    let to = from.iter().zip(&step).map(|(q, d)| q + d * 0.5 / length).collect();
    motion(R1, from.to_vec(), to)
}

fn with_standing(geometry: &Geometry, arms: &[Motion], random: &mut Random) {
    let robot = geometry.problem().robot(R1);
    let mut beside = |m: &Motion| {
        let hand = kinematics::link_poses(robot, &m.from, 0.08)[robot.end_effector.parent_link.index()];
        Standing { object: ObjectId(1), world_from_object: hand.translation * random.pose(0.5) }
    };
    let near: Vec<(Motion, Standing)> = arms.iter().map(|m| (m.clone(), beside(m))).collect();
    report("motion_hits, within 0.5 m of the hand", &near, |(m, s)| geometry.motion_hits(m, s).is_some());
    let swept: Vec<_> = near.iter().map(|(m, s)| (geometry.sweep(m, 0, 1), *s)).collect();
    report("sweep_hits, the same", &swept, |(a, s)| geometry.sweep_hits(a, s));
}
