//! The conflict relation against discs.

use std::sync::Arc;

use collision::{Geometry, Motion};
use composite::{Conflicts, TimedMotion, TimedStanding};
use model::{AllowedContacts, GraspId, Holding, ObjectId, RobotId, Standing};

use crate::oracle::{Disc, overlap, robot_discs};
use crate::toys::{Dice, Errand, OBJECT, World};

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
