//! Prints how long the geometry's questions take (µs), on the tests' mobile arm among furniture.
#![allow(clippy::disallowed_methods, reason = "it measures")]
#![allow(clippy::unwrap_used, reason = "its input is its own")]

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;
use std::time::Instant;

use collision::{Geometry, Motion, Standing};
use common::*;
use model::{AllowedContacts, ObjectId, RobotId};

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
    let problem = mobile_problem();
    let geometry = Geometry::new(&problem).unwrap();
    let (r1, r2) = (RobotId(0), RobotId(1));
    let robot = problem.robot(r1);
    let mut random = Random(1);
    let states: Vec<Vec<f64>> = (0..2000).map(|_| random_configuration(robot, &mut random)).collect();
    report("forward kinematics only", &states, |q| kinematics::link_poses(robot, q, 0.08)[3].translation.z > 1e9);
    report("state_contact", &states, |q| geometry.state_contact(r1, None, q, NOTHING).is_some());
    let folded = [0.0, 0.9, -1.8, 0.0, 0.9, 0.0];
    let drives: Vec<Motion> = (0..1000)
        .map(|i| {
            let mut from = random_configuration(robot, &mut random);
            from[3..].copy_from_slice(&folded);
            let mut to = from.clone();
            let bearing = random.between(-3.1, 3.1);
            to[0] += 0.5 * bearing.cos();
            to[1] += 0.5 * bearing.sin();
            to[2] += if i % 2 == 0 { 0.0 } else { random.between(-0.5, 0.5) };
            motion(r1, from, to)
        })
        .collect();
    let free = |m: &Motion| geometry.state_contact(r1, None, &m.from, NOTHING).is_none();
    let (straight, turning): (Vec<_>, Vec<_>) = drives.into_iter().filter(free).partition(|m| m.from[2] == m.to[2]);
    report("motion_contact, base drive 0.5 m", &straight, |m| geometry.motion_contact(m).is_some());
    report("motion_contact, base drive 0.5 m, turning", &turning, |m| geometry.motion_contact(m).is_some());
    let arms: Vec<Motion> = (0..2000)
        .map(|_| {
            let from = random_configuration(robot, &mut random);
            let mut step: Vec<f64> = (0..9).map(|i| if i < 3 { 0.0 } else { random.between(-1.0, 1.0) }).collect();
            let length = step.iter().map(|d| d * d).sum::<f64>().sqrt();
            step.iter_mut().zip(&from).for_each(|(d, q)| *d = q + *d * 0.5 / length);
            motion(r1, from, step)
        })
        .filter(free)
        .collect();
    report("motion_contact, arm motion 0.5 rad", &arms, |m| geometry.motion_contact(m).is_some());
    let near: Vec<(Motion, Standing)> = arms
        .iter()
        .map(|m| {
            let tip = kinematics::link_poses(robot, &m.from, 0.08)[6].translation;
            (m.clone(), Standing { object: ObjectId(1), world_from_object: tip * random.pose(0.5) })
        })
        .collect();
    report("motion_hits, within 0.5 m of the hand", &near, |(m, s)| geometry.motion_hits(m, s).is_some());
    let swept: Vec<_> = near.iter().map(|(m, s)| (geometry.sweep(m, 0, 1), *s)).collect();
    report("sweep_hits, the same", &swept, |(a, s)| geometry.sweep_hits(a, s));
    report("sweep", &arms, |m| geometry.sweep(m, 1, 4).growth() > 1e9);
    report("cells", &arms, |m| geometry.cells(m, 0.05) > 1_000_000);
    let pairs: Vec<_> = (0..3000)
        .map(|_| {
            let mut cell = |id, shift: [f64; 2]| {
                let mut m = random_motion(&geometry, id, &mut random);
                for k in 0..2 {
                    let away = shift[k] - m.from[k];
                    m.from[k] += away;
                    m.to[k] += away;
                }
                let cells = geometry.cells(&m, 0.05);
                geometry.sweep(&m, 0, cells)
            };
            let a = cell(r1, [0.0, 0.0]);
            (a, cell(r2, [0.8, 0.3]))
        })
        .collect();
    report("sweeps_conflict, reach 0.05 m, bases 0.85 m apart", &pairs, |(a, b)| geometry.sweeps_conflict(a, b));
}
