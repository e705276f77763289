//! The paper's Figure 1, as shipped.

mod common;

use collision::{AllowedContacts, BodyName, Geometry, Holding, Motion, Standing};
use common::*;
use model::{GraspId, ObjectId, Problem, RobotId};

const NOTHING: AllowedContacts = AllowedContacts { touch: None, support: None };

fn standing_at_start(problem: &Problem) -> Vec<Standing> {
    let objects = problem.movable.iter().enumerate();
    objects.map(|(i, m)| Standing { object: ObjectId::at(i), world_from_object: m.world_from_start }).collect()
}

/// A place to drive from: the base anywhere within its limits, the arm as for driving.
fn random_drive(problem: &Problem, id: RobotId, random: &mut Random) -> Motion {
    let robot = problem.robot(id);
    let object = ObjectId::at(random.pick(8));
    let graspable = problem.movable.get(object.index()).is_some_and(|m| !m.grasps[id.index()].is_empty());
    let holding = graspable.then_some(Holding { object, grasp: GraspId(0) });
    let arm = if holding.is_some() { &robot.carry } else { &robot.home };
    let mut base = |i: usize| random.between(robot.coordinates[i].lower, robot.coordinates[i].upper);
    let (x, y) = (base(0), base(1));
    let mut from = vec![x, y, random.between(-3.0, 3.0)];
    let mut to = from.iter().map(|value| value + random.between(-0.5, 0.5)).collect::<Vec<_>>();
    from.extend(arm);
    to.extend(arm);
    Motion { robot: id, holding, from, to, allowed: NOTHING }
}

#[test]
fn everything_is_free_at_the_start() {
    let problem = figure1();
    let geometry = Geometry::new(&problem).unwrap();
    let objects = standing_at_start(&problem);
    for (i, a) in objects.iter().enumerate() {
        assert_eq!(geometry.standing_contact(a, problem.movable[i].start_support), None);
        assert!(geometry.standing_contact(a, None).is_some(), "it does stand on something");
        assert!(objects[i + 1..].iter().all(|b| !geometry.standings_collide(a, b)));
    }
    for id in problem.robot_ids() {
        let start = &problem.robot(id).start;
        let contact = geometry.state_contact(id, None, start, NOTHING);
        assert_eq!(contact.map(|contact| contact.describe(&problem)), None);
        assert!(objects.iter().all(|object| geometry.state_hits(id, None, start, NOTHING, object).is_none()));
    }
    let still = |id: RobotId| {
        let start = problem.robot(id).start.clone();
        geometry.sweep(&Motion { robot: id, holding: None, from: start.clone(), to: start, allowed: NOTHING }, 0, 1)
    };
    let still: Vec<_> = problem.robot_ids().map(still).collect();
    assert!(!geometry.sweeps_conflict(&still[0], &still[1]));
    assert!(!geometry.sweeps_conflict(&still[1], &still[2]));
    assert!(!geometry.sweeps_conflict(&still[0], &still[2]));
}

#[test]
fn every_grasp_at_home_touches_nothing_of_the_robot_but_the_hand() {
    let mut problem = figure1();
    problem.fixed.clear();
    let geometry = Geometry::new(&problem).unwrap();
    for id in problem.robot_ids() {
        let robot = problem.robot(id);
        let mut q = robot.start.clone();
        q[robot.base_len()..].copy_from_slice(&robot.carry);
        for (object, movable) in problem.movable.iter().enumerate() {
            for grasp in 0..movable.grasps[id.index()].len() {
                let holding = Some(Holding { object: ObjectId::at(object), grasp: GraspId::at(grasp) });
                let contact = geometry.state_contact(id, holding, &q, NOTHING);
                assert_eq!(contact.map(|contact| contact.describe(&problem)), None, "grasp {grasp}");
            }
        }
    }
}

#[test]
fn the_cabinet_carries_an_object_and_its_sides_do_not() {
    let problem = figure1();
    let geometry = Geometry::new(&problem).unwrap();
    let region = problem.regions.iter().find(|region| region.name == "w4").unwrap();
    let place = |x: f64, y: f64| {
        let world_from_object = region.world_from_region * at(x, y, 0.075);
        geometry.standing_contact(&Standing { object: ObjectId(0), world_from_object }, Some(region.support))
    };
    assert_eq!(place(0.0, 0.0), None);
    assert_eq!(place(-0.4, 0.02), None);
    // Inner faces: sides at ±0.47, back at 0.07. The object is 0.07 by 0.05.
    let cabinet = Some(BodyName::Fixed(region.support));
    assert_eq!(place(0.434, 0.0).map(|contact| contact.second), cabinet);
    assert_eq!(place(0.432, 0.0), None);
    assert_eq!(place(0.0, 0.044).map(|contact| contact.second), cabinet);
    assert_eq!(place(0.0, 0.042), None);
}

#[test]
fn drives_and_states_agree_with_parry() {
    let problem = figure1();
    let geometry = Geometry::new(&problem).unwrap();
    let oracle = Oracle(&problem);
    let mut counts = [0, 0];
    for seed in 0..600 {
        let mut random = Random(seed);
        let drive = random_drive(&problem, RobotId::at(random.pick(3)), &mut random);
        let states = (0..=12).map(|i| along(&drive, f64::from(i) / 12.0));
        let distances: Vec<f64> = states.map(|q| oracle.own_and_fixed(drive.robot, drive.holding, &q)).collect();
        let start = geometry.state_contact(drive.robot, drive.holding, &drive.from, NOTHING).is_some();
        let at_start = distances[0];
        assert!(if start { at_start < CLEARANCE + PARRY } else { at_start >= CLEARANCE - PARRY }, "seed {seed}");
        let contact = geometry.motion_contact(&drive).is_some();
        let least = distances.iter().copied().fold(f64::MAX, f64::min);
        counts[usize::from(contact)] += 1;
        // Between two samples lies a drive of 6 cm and a turn of 0.05 rad at most.
        assert!(if contact { least < 0.06 } else { least >= CLEARANCE - PARRY }, "seed {seed}: {least} m");
    }
    assert!(counts[0] > 100 && counts[1] > 100, "{counts:?}");
}
