//! Parts of motions: cells, swept volumes, conflicts between robots.

mod common;

use collision::{AllowedContacts, Geometry, Holding, Motion, Standing, Sweep};
use common::*;
use model::{GraspId, ObjectId, Problem, RobotId, Shape};
use nalgebra::Point3;

const R1: RobotId = RobotId(0);
const R2: RobotId = RobotId(1);
const NOTHING: AllowedContacts = AllowedContacts { touch: None, support: None };

/// Points of a shape: its corners, the ends of its axis, or its rims.
fn of_shape(shape: &Shape) -> Vec<Point3<f64>> {
    let Shape::Cylinder { radius, length } = shape else {
        return shape.support_points();
    };
    let rim = |i: u32| {
        let bearing = f64::from(i / 2) * 0.7;
        let side = if i.is_multiple_of(2) { 0.5 } else { -0.5 };
        Point3::new(radius * bearing.cos(), radius * bearing.sin(), length * side)
    };
    (0..18).map(rim).collect()
}

/// Such points of every body of the robot and its load, rounding left out.
fn points(problem: &Problem, motion: &Motion, share: f64) -> Vec<Point3<f64>> {
    let robot = problem.robot(motion.robot);
    let q = along(motion, share);
    let grasp = motion.holding.map(|h| (h.object, problem.movable[h.object.index()].grasp(motion.robot, h.grasp)));
    let opening = grasp.map_or(robot.end_effector.max_opening, |(_, grasp)| grasp.opening);
    let poses = kinematics::link_poses(robot, &q, opening);
    let links = robot.links.iter().zip(&poses).flat_map(|(link, pose)| link.bodies.iter().map(move |b| (*pose, b)));
    let hand = poses[robot.end_effector.parent_link.index()];
    let load = grasp.map(|(object, grasp)| (hand * grasp.link_from_object, &problem.movable[object.index()].body));
    let bodies = links.chain(load);
    bodies
        .flat_map(|(pose, body)| {
            let place = move |p: Point3<f64>| pose * body.owner_from_shape * p;
            of_shape(&body.shape).into_iter().map(place)
        })
        .collect()
}

#[test]
fn within_a_cell_no_point_gets_further_than_the_reach_from_the_middle() {
    let problem = mobile_problem();
    let geometry = Geometry::new(&problem).unwrap();
    let mut tightest: f64 = 0.0;
    for seed in 0..400 {
        let mut random = Random(seed);
        let motion = random_motion(&geometry, R1, &mut random);
        let reach = random.between(0.01, 0.2);
        let cells = geometry.cells(&motion, reach);
        for cell in [0, cells / 2, cells - 1] {
            let share = |part: f64| (f64::from(cell) + part) / f64::from(cells);
            let middle = points(&problem, &motion, share(0.5));
            let growth = geometry.sweep(&motion, cell, cells).growth();
            for part in [0.0, 0.2, 0.6, 1.0] {
                let there = points(&problem, &motion, share(part));
                let moved = middle.iter().zip(&there).fold(0.0, |most: f64, (a, b)| most.max((a - b).norm()));
                assert!(moved <= reach, "seed {seed}: {moved} m in cell {cell} of {cells}, reach {reach} m");
                assert!(moved <= growth + 1e-12, "seed {seed}: {moved} m, the sweep grows by {growth} m");
                tightest = tightest.max(moved / reach);
            }
        }
    }
    assert!(tightest > 0.9, "cells are needlessly small: at most {tightest} of the reach was used");
}

#[test]
fn a_drive_is_cut_by_its_length_and_standing_still_is_one_cell() {
    let geometry = Geometry::new(&mobile_problem()).unwrap();
    let from = vec![0.0, 0.0, 0.3, 0.1, 0.3, 0.5, 0.0, 0.4, 0.0];
    let mut to = from.clone();
    let still = Motion { robot: R1, holding: None, from: from.clone(), to: to.clone(), allowed: NOTHING };
    assert_eq!(geometry.cells(&still, 0.05), 1);
    (to[0], to[1]) = (3.0, 4.0);
    let drive = Motion { to, ..still };
    assert_eq!(geometry.cells(&drive, 0.05), 50, "5 m in cells of 0.1 m");
    assert_eq!(geometry.cells(&drive, 2.5), 1);
    assert_eq!(geometry.cells(&drive, 0.0), 25_000, "no finer than 0.1 mm");
}

#[test]
fn bounds_hold_every_point_swept_with_the_clearance() {
    let problem = mobile_problem();
    let geometry = Geometry::new(&problem).unwrap();
    for seed in 0..300 {
        let mut random = Random(seed);
        let motion = random_motion(&geometry, R1, &mut random);
        let (least, greatest) = geometry.sweep(&motion, 0, 1).bounds();
        for share in [0.0, 0.25, 0.5, 0.75, 1.0] {
            for p in points(&problem, &motion, share) {
                let inside =
                    (0..3).all(|i| least[i] <= p[i] - CLEARANCE + 1e-9 && p[i] + CLEARANCE - 1e-9 <= greatest[i]);
                assert!(inside, "seed {seed}: {p} outside of {least} .. {greatest}");
            }
        }
    }
}

/// Two motions near each other, cut into cells, and one cell of each.
fn meeting(geometry: &Geometry, seed: u64) -> (Motion, Motion, [Sweep; 2], [(u32, u32); 2]) {
    let mut random = Random(seed);
    let a = random_motion(geometry, R1, &mut random);
    let mut b = random_motion(geometry, R2, &mut random);
    let reach = random.between(0.02, 0.15);
    let (cells_a, cells_b) = (geometry.cells(&a, reach), geometry.cells(&b, reach));
    let (i, j) = (random.pick(cells_a as usize) as u32, random.pick(cells_b as usize) as u32);
    // The second robot drives somewhere beside the first.
    let (at_a, at_b) = (along(&a, f64::from(i) / f64::from(cells_a)), along(&b, f64::from(j) / f64::from(cells_b)));
    let (bearing, distance) = (random.between(-3.1, 3.1), random.between(0.4, 1.4));
    for (k, offset) in [distance * bearing.cos(), distance * bearing.sin()].into_iter().enumerate() {
        let shift = at_a[k] + offset - at_b[k];
        b.from[k] += shift;
        b.to[k] += shift;
    }
    let sweeps = [geometry.sweep(&a, i, cells_a), geometry.sweep(&b, j, cells_b)];
    (a, b, sweeps, [(i, cells_a), (j, cells_b)])
}

#[test]
fn where_sweeps_do_not_conflict_no_two_sampled_configurations_touch() {
    const SAMPLES: u32 = 6;
    let problem = mobile_problem();
    let geometry = Geometry::new(&problem).unwrap();
    let oracle = Oracle(&problem);
    let (mut free, mut conflicts, mut unexplained) = (0, 0, 0);
    for seed in 0..1500 {
        let (a, b, [first, second], cells) = meeting(&geometry, seed);
        let pieces = |motion: &Motion, (cell, cells): (u32, u32), k: u32| {
            let part = f64::from(k) / f64::from(SAMPLES);
            oracle.robot(motion.robot, motion.holding, &along(motion, (f64::from(cell) + part) / f64::from(cells)))
        };
        let all = |motion: &Motion, cell| (0..=SAMPLES).map(|k| pieces(motion, cell, k)).collect::<Vec<_>>();
        let (all_a, all_b) = (all(&a, cells[0]), all(&b, cells[1]));
        let each = all_a.iter().flat_map(|a| all_b.iter().map(move |b| least_distance(a, b)));
        let least = each.fold(f64::MAX, f64::min);
        if geometry.sweeps_conflict(&first, &second) {
            conflicts += 1;
            unexplained += u32::from(least > 0.03);
        } else {
            free += 1;
            assert!(least >= CLEARANCE - PARRY, "seed {seed}: {least} m");
        }
        let reverse = geometry.sweeps_conflict(&second, &first);
        assert_eq!(reverse, geometry.sweeps_conflict(&first, &second), "seed {seed}: depends on who is asked first");
    }
    assert!(free > 200 && conflicts > 200, "{free} free, {conflicts} in conflict");
    assert!(unexplained * 20 < conflicts, "{unexplained} of {conflicts} conflicts between robots 3 cm apart");
}

#[test]
fn sweeps_and_motions_agree_on_standing_objects() {
    let problem = mobile_problem();
    let geometry = Geometry::new(&problem).unwrap();
    let oracle = Oracle(&problem);
    let mut counts = [0, 0];
    for seed in 0..1500 {
        let mut random = Random(seed);
        let motion = random_motion(&geometry, R1, &mut random);
        let middle = oracle.robot(R1, motion.holding, &along(&motion, 0.4));
        let near = middle[random.pick(middle.len())].pose.translation;
        let standing = Standing { object: ObjectId(1), world_from_object: near * random.pose(0.5) };
        let hits = geometry.motion_hits(&motion, &standing).is_some();
        assert_eq!(geometry.sweep_hits(&geometry.sweep(&motion, 0, 1), &standing), hits, "seed {seed}");
        counts[usize::from(hits)] += 1;
        let cells = geometry.cells(&motion, 0.05);
        let in_cell = |cell: &u32| geometry.sweep_hits(&geometry.sweep(&motion, *cell, cells), &standing);
        let least = |from: f64, to: f64| {
            let there = |k: u32| along(&motion, from + (to - from) * f64::from(k) / 60.0);
            let pieces = (0..=60).map(|k| oracle.robot(R1, motion.holding, &there(k)));
            pieces.map(|p| least_distance(&p, &[oracle.standing(&standing)])).fold(f64::MAX, f64::min)
        };
        // Whole and parts may differ only where bodies pass between once and 1.25 times the clearance.
        if let Some(cell) = (0..cells).find(in_cell) {
            let near = least(f64::from(cell) / f64::from(cells), f64::from(cell + 1) / f64::from(cells));
            assert!(near < 1.25 * CLEARANCE + 5e-4, "seed {seed}: {near} m in cell {cell} of {cells}");
        } else if hits {
            let near = least(0.0, 1.0);
            assert!(near > CLEARANCE - PARRY, "seed {seed}: {near} m, but free in all {cells} parts");
        }
    }
    assert!(counts[0] > 200 && counts[1] > 200, "{counts:?}");
}

#[test]
fn two_bases_driving_side_by_side_do_not_conflict() {
    let mut bases = problem(vec![box_base("r1"), box_base("r2")], vec![], vec![]);
    bases.robots[1].world_from_base = at(0.0, 0.45, 0.0);
    let geometry = Geometry::new(&bases).unwrap();
    let drive = |robot, from: f64, to: f64, side: f64| {
        let (from, to) = (vec![from, side, 0.0], vec![to, side, 0.0]);
        geometry.sweep(&Motion { robot, holding: None, from, to, allowed: NOTHING }, 0, 1)
    };
    // The boxes are 0.4 m wide and 5 cm apart; each drives 6 m past the other.
    assert!(!geometry.sweeps_conflict(&drive(R1, -3.0, 3.0, 0.0), &drive(R2, 3.0, -3.0, 0.0)));
    assert!(geometry.sweeps_conflict(&drive(R1, -3.0, 3.0, 0.0), &drive(R2, 3.0, -3.0, -0.0485)));
    assert!(!geometry.sweeps_conflict(&drive(R1, -3.0, 3.0, 0.0), &drive(R2, 3.0, -3.0, -0.0475)));
    assert!(geometry.sweeps_conflict(&drive(R1, 0.0, 0.0, 0.0), &drive(R1, 5.0, 5.0, 0.0)), "a robot and itself");
}

#[test]
fn two_arms_that_meet_only_at_the_end_of_both_parts_conflict() {
    for (gap, conflict) in [(0.0019, true), (0.5, false)] {
        let mut arms = problem(vec![planar_2r(), planar_2r()], vec![], vec![]);
        arms.robots[1].world_from_base = turned(4.0 + gap, 0.0, 0.0, std::f64::consts::PI);
        let geometry = Geometry::new(&arms).unwrap();
        let swing = |robot, to: f64| {
            let motion = Motion { robot, holding: None, from: vec![0.0, 0.0], to: vec![to, 0.0], allowed: NOTHING };
            geometry.sweep(&motion, 0, 1)
        };
        for (to_a, to_b) in [(0.6, 0.6), (0.6, -0.6), (2.0, 1.0), (-0.1, -0.9), (0.0, 0.5)] {
            assert_eq!(geometry.sweeps_conflict(&swing(R1, to_a), &swing(R2, to_b)), conflict, "{to_a} {to_b} {gap}");
        }
    }
}

#[test]
fn what_is_no_motion_conflicts_with_everything() {
    let geometry = Geometry::new(&mobile_problem()).unwrap();
    let at = |robot, x: f64| {
        let q = vec![x, 0.0, 0.0, 0.0, 0.3, 0.5, 0.0, 0.4, 0.0];
        Motion { robot, holding: None, from: q.clone(), to: q, allowed: NOTHING }
    };
    let far = geometry.sweep(&at(R2, 100.0), 0, 1);
    assert!(!geometry.sweeps_conflict(&geometry.sweep(&at(R1, 0.0), 0, 1), &far));
    let no_grasp = Some(Holding { object: ObjectId(0), grasp: GraspId(7) });
    let bad = [
        Motion { to: vec![f64::NAN; 9], ..at(R1, 0.0) },
        Motion { from: vec![0.0; 8], ..at(R1, 0.0) },
        Motion { holding: no_grasp, ..at(R1, 0.0) },
    ];
    for motion in bad {
        let sweep = geometry.sweep(&motion, 0, 1);
        assert!(geometry.sweeps_conflict(&sweep, &far), "{motion:?}");
        assert!(geometry.sweeps_conflict(&far, &sweep), "{motion:?}");
        assert!(geometry.cells(&motion, 0.1) >= 1);
        let standing = Standing { object: ObjectId(1), world_from_object: model::Pose::translation(50.0, 0.0, 0.0) };
        assert!(geometry.sweep_hits(&sweep, &standing), "{motion:?}");
    }
}
