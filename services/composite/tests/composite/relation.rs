//! The conflict relation against discs.

use std::sync::Arc;

use collision::{Geometry, Motion};
use composite::{Conflicts, TimedMotion, TimedStanding};
use model::{
    AllowedContacts, Body, CoordinateId, GraspId, Holding, Joint, JointMotion, JointValue, Link, LinkId, ObjectId,
    Robot, RobotId, Shape, Standing,
};

use crate::oracle::{Disc, overlap, robot_discs};
use crate::toys::{Dice, Errand, OBJECT, World, disc};

fn conflicts() -> Conflicts {
    let mut world = World::grid(2, 1, 1.0);
    world.starts = vec![0, 1];
    world.objects = vec![0, 1];
    world.errands =
        vec![Errand { robot: 0, object: 0, from: 0, to: 1 }, Errand { robot: 1, object: 1, from: 1, to: 0 }];
    Conflicts::new(Arc::new(Geometry::new(&world.problem()).unwrap()))
}

fn random_motion(dice: &mut Dice, robot: usize) -> TimedMotion {
    let mut q = || vec![dice.unit() * 1.6, dice.unit() * 1.6, dice.unit() * 2.0 - 1.0];
    let from = q();
    let to = q();
    let to = if dice.below(4) == 0 { from.clone() } else { to };
    let holding = (dice.below(2) == 0).then(|| Holding { object: ObjectId::at(robot), grasp: GraspId(0) });
    let begins_s = dice.unit() * 2.0;
    let motion = Motion { robot: RobotId::at(robot), holding, from, to, allowed: AllowedContacts::default() };
    TimedMotion { motion, begins_s, ends_s: begins_s + 0.2 + dice.unit() * 2.0 }
}

fn discs_at(timed: &TimedMotion, t: f64, grown: f64) -> Vec<Disc> {
    let share = (t - timed.begins_s) / (timed.ends_s - timed.begins_s);
    let q: Vec<f64> = timed.motion.from.iter().zip(&timed.motion.to).map(|(a, b)| a + (b - a) * share).collect();
    let mut discs = robot_discs(timed.motion.robot.index(), &q, timed.motion.holding.is_some());
    discs.iter_mut().for_each(|disc| disc.radius += grown);
    discs
}

/// Whether two motions meet at a sampled time, if both are grown.
fn meet(a: &TimedMotion, b: &TimedMotion, grown: f64) -> bool {
    let (from, to) = (a.begins_s.max(b.begins_s), a.ends_s.min(b.ends_s));
    (1..1000)
        .map(|k| from + (to - from) * f64::from(k) / 1000.0)
        .any(|t| from < to && overlap(&[discs_at(a, t, grown), discs_at(b, t, grown)].concat()).is_some())
}

#[test]
fn motions_that_meet_conflict_and_motions_far_from_meeting_do_not() {
    let conflicts = conflicts();
    let (mut met, mut apart) = (0, 0);
    for seed in 0..600 {
        let mut dice = Dice(seed);
        let (a, b) = (random_motion(&mut dice, 0), random_motion(&mut dice, 1));
        let conflict = conflicts.moves_conflict(&a, &b);
        assert_eq!(conflict, conflicts.moves_conflict(&b, &a), "seed {seed}");
        if meet(&a, &b, 0.0) {
            met += 1;
            assert!(conflict, "seed {seed}: {a:?} and {b:?} meet");
        } else if !meet(&a, &b, 0.1) {
            apart += 1;
            assert!(!conflict, "seed {seed}: {a:?} and {b:?} keep 0.2 m apart");
        }
    }
    assert!(met > 100 && apart > 100, "{met} met, {apart} apart");
}

#[test]
fn a_motion_hits_an_object_only_while_it_stands() {
    let conflicts = conflicts();
    let (mut hit, mut missed) = (0, 0);
    for seed in 0..600 {
        let mut dice = Dice(seed + 1000);
        let a = random_motion(&mut dice, 0);
        let (x, y) = (dice.unit() * 1.6, dice.unit() * 1.6);
        let world_from_object = nalgebra::Isometry3::translation(x, y, 0.2);
        let (from_s, until_s) = (dice.unit() * 3.0, 1.0 + dice.unit() * 3.0);
        let standing = Standing { object: ObjectId(1), world_from_object };
        let hits = conflicts.move_hits(&a, &TimedStanding { standing, from_s, until_s });
        let (from, to) = (a.begins_s.max(from_s), a.ends_s.min(until_s));
        let touches = |radius: f64| {
            let object = Disc { owner: ('m', 1), centre: [x, y], radius };
            let mut times = (1..1000).map(|k| from + (to - from) * f64::from(k) / 1000.0);
            from < to && times.any(|t| overlap(&[discs_at(&a, t, 0.0), vec![object]].concat()).is_some())
        };
        if touches(OBJECT) {
            hit += 1;
            assert!(hits, "seed {seed}");
        } else if !touches(OBJECT + 0.15) {
            missed += 1;
            assert!(!hits, "seed {seed}");
        }
    }
    assert!(hit > 50 && missed > 50, "{hit} hit, {missed} missed");
}

#[test]
fn the_object_in_the_hand_is_never_hit() {
    let conflicts = conflicts();
    let holding = Some(Holding { object: ObjectId(0), grasp: GraspId(0) });
    let q = vec![0.0, 0.0, 0.0];
    let motion = |holding| Motion {
        robot: RobotId(0),
        holding,
        from: q.clone(),
        to: q.clone(),
        allowed: AllowedContacts::default(),
    };
    let standing =
        |m| Standing { object: ObjectId(m), world_from_object: nalgebra::Isometry3::translation(0.35, 0.0, 0.2) };
    assert!(!conflicts.motion_hits(&motion(holding), &standing(0)));
    assert!(conflicts.motion_hits(&motion(holding), &standing(1)));
    assert!(!conflicts.motion_hits(&motion(None), &standing(1)));
}

/// A planar arm of two capsules, 0.5 m each, about a vertical axis at `x` (m).
fn planar_arm(name: &str, x: f64) -> Robot {
    let mut robot = disc(name, vec![0.0, 0.0, 0.0]);
    let along = nalgebra::UnitQuaternion::from_euler_angles(0.0, std::f64::consts::FRAC_PI_2, 0.0);
    let capsule = Body {
        owner_from_shape: nalgebra::Isometry3::from_parts([0.25, 0.0, 0.0].into(), along),
        shape: Shape::Capsule { radius: 0.04, length: 0.5 },
    };
    let joint = |name: &str, child: u32, x: f64, coordinate: u32| Joint {
        name: name.into(),
        parent: LinkId(child - 1),
        child: LinkId(child),
        parent_from_joint: nalgebra::Isometry3::translation(x, 0.0, 0.0),
        motion: JointMotion::Revolute { axis: [0.0, 0.0, 1.0] },
        value: JointValue::Coordinate(CoordinateId(coordinate)),
    };
    let link = |name: &str, bodies| Link { name: name.into(), bodies };
    robot.links = vec![link("foot", vec![]), link("upper", vec![capsule.clone()]), link("lower", vec![capsule])];
    robot.joints = vec![joint("shoulder", 1, 0.0, 0), joint("elbow", 2, 0.5, 1)];
    robot.coordinates.truncate(2);
    robot.base = None;
    robot.world_from_base = nalgebra::Isometry3::translation(x, 0.0, 0.3);
    robot.end_effector.parent_link = LinkId(2);
    robot.end_effector.links = vec![LinkId(2)];
    robot.disabled_pairs = vec![(LinkId(0), LinkId(1)), (LinkId(1), LinkId(2))];
    (robot.start, robot.home, robot.carry) = (vec![0.0; 2], vec![0.0; 2], vec![0.0; 2]);
    robot
}

/// Points along both links, 1 cm apart.
fn arm_points(x: f64, q: &[f64]) -> Vec<[f64; 2]> {
    let elbow = [x + 0.5 * q[0].cos(), 0.5 * q[0].sin()];
    let lower = q[0] + q[1];
    let along = |k: i32| 0.01 * f64::from(k);
    let first = (0..=50).map(|k| [x + along(k) * q[0].cos(), along(k) * q[0].sin()]);
    let second = (0..=50).map(|k| [elbow[0] + along(k) * lower.cos(), elbow[1] + along(k) * lower.sin()]);
    first.chain(second).collect()
}

#[test]
fn arms_that_meet_conflict_and_arms_far_from_meeting_do_not() {
    let mut problem = World::grid(1, 1, 1.0).problem();
    problem.robots = vec![planar_arm("r1", 0.0), planar_arm("r2", 1.2)];
    let conflicts = Conflicts::new(Arc::new(Geometry::new(&problem).unwrap()));
    let (mut met, mut apart) = (0, 0);
    for seed in 0..200 {
        let mut dice = Dice(seed + 3000);
        let mut motion = |robot: usize, shift: f64| {
            let mut q = || vec![dice.unit() * 4.0 - 2.0 + shift, dice.unit() * 4.0 - 2.0];
            let (from, to) = (q(), q());
            let (robot, allowed) = (RobotId::at(robot), AllowedContacts::default());
            let motion = Motion { robot, holding: None, from, to, allowed };
            TimedMotion { motion, begins_s: 0.0, ends_s: 1.0 }
        };
        let (a, b) = (motion(0, 0.0), motion(1, std::f64::consts::PI));
        let at = |m: &Motion, t: f64| -> Vec<f64> { m.from.iter().zip(&m.to).map(|(a, b)| a + (b - a) * t).collect() };
        let nearest = (0..=50).map(|k| 0.02 * f64::from(k)).fold(f64::INFINITY, |least: f64, t| {
            let (p, q) = (arm_points(0.0, &at(&a.motion, t)), arm_points(1.2, &at(&b.motion, t)));
            p.iter().flat_map(|p| q.iter().map(move |q| (p[0] - q[0]).hypot(p[1] - q[1]))).fold(least, f64::min)
        });
        let conflict = conflicts.moves_conflict(&a, &b);
        if nearest < 0.08 {
            met += 1;
            assert!(conflict, "seed {seed}: {nearest} m");
        } else if nearest > 0.4 {
            apart += 1;
            assert!(!conflict, "seed {seed}: {nearest} m");
        }
    }
    assert!(met > 20 && apart > 10, "{met} met, {apart} apart");
}

#[test]
fn cells_are_the_same_in_both_directions_and_after_whole_turns() {
    let conflicts = conflicts();
    for seed in 0..200 {
        let mut dice = Dice(seed + 2000);
        let (a, b) = (random_motion(&mut dice, 0).motion, random_motion(&mut dice, 1).motion);
        let turned = |motion: &Motion, turns: f64| {
            let turn = |q: &Vec<f64>| vec![q[0], q[1], q[2] + turns * std::f64::consts::TAU];
            Motion { from: turn(&motion.to), to: turn(&motion.from), ..motion.clone() }
        };
        let (there, other) = (conflicts.travel(&a), conflicts.travel(&b));
        for turns in [0.0, 1.0, -3.0] {
            let back = conflicts.travel(&turned(&a, turns));
            assert_eq!(there.cells, back.cells, "seed {seed}");
            for i in 0..there.cells {
                for j in 0..other.cells {
                    assert_eq!(
                        conflicts.cells_conflict(&there, i, &other, j),
                        conflicts.cells_conflict(&other, j, &back, back.cells - 1 - i),
                        "seed {seed}, cells {i} and {j}, {turns} turns"
                    );
                }
            }
        }
    }
}
