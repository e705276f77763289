//! Straight motions in continuous time.

mod common;

use collision::{AllowedContacts, BodyName, Contact, Geometry, Motion, Standing};
use common::*;
use model::{Configuration, FixedId, LinkId, ObjectId, Pose, RobotId, Shape};

const R1: RobotId = RobotId(0);
const NOTHING: AllowedContacts = AllowedContacts { touch: None, support: None };

fn motion(from: &[f64], to: &[f64]) -> Motion {
    Motion { robot: R1, holding: None, from: from.to_vec(), to: to.to_vec(), allowed: NOTHING }
}

/// Least distance over the motion by dense sampling, the best samples searched more finely around; and how far the
/// answer may be from the true one, taking distances as Lipschitz between the finest samples.
fn least_along(motion: &Motion, distance: impl Fn(&Configuration) -> f64) -> f64 {
    const SAMPLES: u32 = 64;
    let at = |s: f64| distance(&along(motion, s));
    let mut best = (f64::MAX, 0.0);
    for i in 0..=SAMPLES {
        let s = f64::from(i) / f64::from(SAMPLES);
        let d = at(s);
        if d < best.0 {
            best = (d, s);
        }
    }
    let mut step = 1.0 / f64::from(SAMPLES);
    while step > 1e-6 && best.0 > 0.0 {
        step /= 2.0;
        for s in [best.1 - step, best.1 + step] {
            if (0.0..=1.0).contains(&s) {
                let d = at(s);
                if d < best.0 {
                    best = (d, s);
                }
            }
        }
    }
    best.0
}

#[test]
fn no_sample_of_a_free_motion_comes_nearer_than_the_clearance() {
    let problem = mobile_problem();
    let geometry = Geometry::new(&problem).unwrap();
    let oracle = Oracle(&problem);
    let (mut free, mut hit, mut unexplained) = (0, 0, 0);
    for seed in 0..1200 {
        let mut random = Random(seed);
        let motion = random_motion(&geometry, R1, &mut random);
        let least = || least_along(&motion, |q| oracle.own_and_fixed(R1, motion.holding, q));
        if geometry.motion_contact(&motion).is_none() {
            free += 1;
            let least = least();
            assert!(least >= CLEARANCE - PARRY, "seed {seed}: {least} m in {motion:?}");
        } else {
            hit += 1;
            // The sampled least may be a little above the true one, never below.
            unexplained += u32::from(hit % 8 == 0 && least() > 1.25 * CLEARANCE + PARRY);
        }
    }
    assert!(free > 100 && hit > 100, "{free} free, {hit} in contact");
    assert!(unexplained <= 1, "{unexplained} of {} contacts have no near sample", hit / 8);
}

#[test]
fn no_sample_of_a_motion_that_misses_an_object_comes_near_it() {
    let problem = mobile_problem();
    let geometry = Geometry::new(&problem).unwrap();
    let oracle = Oracle(&problem);
    let mut counts = [0, 0];
    for seed in 0..2500 {
        let mut random = Random(seed + 10_000);
        let motion = random_motion(&geometry, R1, &mut random);
        let free = ObjectId::at(random.pick(3));
        if motion.holding.is_some_and(|holding| holding.object == free) {
            continue;
        }
        let middle = oracle.robot(R1, motion.holding, &along(&motion, random.unit()));
        let near = middle[random.pick(middle.len())].pose.translation;
        let standing = Standing { object: free, world_from_object: near * random.pose(0.2) };
        let piece = [oracle.standing(&standing)];
        let least = least_along(&motion, |q| least_distance(&oracle.robot(R1, motion.holding, q), &piece));
        match geometry.motion_hits(&motion, &standing) {
            None => {
                counts[0] += 1;
                assert!(least >= CLEARANCE - PARRY, "seed {seed}: {least} m");
            }
            Some(contact) => {
                counts[1] += 1;
                assert_eq!(contact.second, BodyName::Object(free));
                assert!(least < 1.25 * CLEARANCE + 2e-4, "seed {seed}: {contact:?} but nothing within {least} m");
            }
        }
    }
    assert!(counts[0] > 200 && counts[1] > 200, "{counts:?}");
}

#[test]
fn a_wall_thinner_than_any_step_is_not_tunnelled() {
    // The 2R arm sweeps over 2.8 rad; a 1 mm wall stands somewhere in between, out at 1.9 m.
    for seed in 0..200 {
        let mut random = Random(seed);
        let bearing = random.between(-1.3, 1.3);
        let wall = boxed(turned(1.9 * bearing.cos(), 1.9 * bearing.sin(), 0.0, bearing), [0.05, 0.001, 1.0]);
        let wall = fixed("wall", Pose::identity(), vec![wall]);
        let geometry = Geometry::new(&problem(vec![planar_2r()], vec![wall], vec![])).unwrap();
        let expected =
            Contact { first: BodyName::Link { robot: R1, link: LinkId(2) }, second: BodyName::Fixed(FixedId(0)) };
        let sweep = motion(&[-1.5, 0.0], &[1.5, 0.0]);
        assert_eq!(geometry.motion_contact(&sweep), Some(expected), "seed {seed}: bearing {bearing}");
        let short = motion(&[-1.5, 0.0], &[bearing - 0.1, 0.0]);
        assert_eq!(geometry.motion_contact(&short), None, "seed {seed}: bearing {bearing}");
    }
}

#[test]
fn a_base_may_drive_past_a_wall_at_the_clearance_and_not_nearer() {
    for (gap, free) in [(0.0021, true), (0.0019, false), (0.0, false)] {
        let wall = fixed("wall", at(0.0, 0.2 + gap + 0.05, 0.5), vec![boxed(Pose::identity(), [20.0, 0.1, 1.0])]);
        let geometry = Geometry::new(&problem(vec![box_base("r")], vec![wall], vec![])).unwrap();
        let drive = motion(&[-4.0, 0.0, 0.0], &[4.0, 0.0, 0.0]);
        assert_eq!(geometry.motion_contact(&drive).is_none(), free, "gap {gap}");
    }
}

#[test]
fn a_base_that_turns_on_the_spot_needs_its_diagonal() {
    // 0.6 × 0.4 m: the corners pass at 0.36056 m from the middle.
    let radius = 0.3f64.hypot(0.2);
    for (distance, free) in [(radius + 0.0030, true), (radius + 0.0015, false), (radius - 0.01, false)] {
        let post = Shape::Cylinder { radius: 0.05, length: 1.0 };
        let post = fixed("post", at(0.0, distance + 0.05, 0.0), vec![body(Pose::identity(), post)]);
        let geometry = Geometry::new(&problem(vec![box_base("r")], vec![post], vec![])).unwrap();
        let turn = motion(&[0.0, 0.0, 0.0], &[0.0, 0.0, 6.5]);
        assert_eq!(geometry.motion_contact(&turn).is_none(), free, "{distance}");
    }
}

#[test]
fn two_arms_of_one_robot_that_meet_only_at_the_end_are_caught() {
    for (gap, free) in [(0.0019, false), (0.0055, true)] {
        let geometry = Geometry::new(&problem(vec![two_bars(gap)], vec![], vec![])).unwrap();
        for far in [0.3, 0.8, 2.9] {
            // The corners swing 1.25 mm wider than the ends, so that 5.5 mm between the ends leave 3 mm.
            for from in [[far, far], [-far, -far], [far, 0.0], [0.0, far], [far, -far]] {
                assert_eq!(geometry.motion_contact(&motion(&from, &[0.0, 0.0])).is_none(), free, "{gap} {from:?}");
                assert_eq!(geometry.motion_contact(&motion(&[0.0, 0.0], &from)).is_none(), free, "{gap} {from:?}");
            }
        }
    }
}

#[test]
fn driving_does_not_bring_a_folded_arm_against_itself() {
    let mut empty = mobile_problem();
    empty.fixed.clear();
    let geometry = Geometry::new(&empty).unwrap();
    let from = [0.0, 0.0, 0.0, 0.0, 0.3, 0.5, 0.0, 0.4, 0.0];
    let mut to = from;
    (to[0], to[1], to[2]) = (30.0, -20.0, 9.0);
    assert_eq!(geometry.motion_contact(&motion(&from, &to)), None);
}

#[test]
fn standing_still_is_judged_as_the_state_is() {
    let problem = mobile_problem();
    let geometry = Geometry::new(&problem).unwrap();
    for seed in 0..500 {
        let mut random = Random(seed);
        let q = random_configuration(problem.robot(R1), &mut random);
        let holding = random_holding(&problem, &mut random);
        let still = Motion { holding, ..motion(&q, &q) };
        assert_eq!(geometry.motion_contact(&still), geometry.state_contact(R1, holding, &q, NOTHING), "seed {seed}");
    }
}

#[test]
fn a_motion_and_its_reverse_get_the_same_answer() {
    let problem = mobile_problem();
    let geometry = Geometry::new(&problem).unwrap();
    for seed in 0..500 {
        let forth = random_motion(&geometry, R1, &mut Random(seed + 5_000));
        let back = Motion { from: forth.to.clone(), to: forth.from.clone(), ..forth.clone() };
        let (first, second) = (geometry.motion_contact(&forth), geometry.motion_contact(&back));
        assert_eq!(first.is_none(), second.is_none(), "seed {seed}");
    }
}
