//! States and standing objects.

mod common;

use collision::{AllowedContacts, BodyName, Contact, Geometry, Holding, Standing};
use common::*;
use model::{FixedId, GraspId, LinkId, ObjectId, Pose, Problem, RobotId, Shape};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

const R1: RobotId = RobotId(0);
const NOTHING: AllowedContacts = AllowedContacts { touch: None, support: None };

#[test]
fn a_sphere_beside_a_box_is_clear_from_exactly_the_clearance_on() {
    let ball = movable("ball", Shape::Sphere { radius: 0.1 }, 1, Pose::identity());
    let block = fixed("block", at(1.0, 0.0, 0.0), vec![boxed(Pose::identity(), [0.4, 0.4, 0.4])]);
    let geometry = Geometry::new(&problem(vec![box_base("r")], vec![block], vec![ball])).unwrap();
    let contact =
        |pose| geometry.standing_contact(&Standing { object: ObjectId(0), world_from_object: pose }, None).is_some();
    // Beside a face, an edge and a corner: the gap is the distance of the centres' offset less the radius.
    let directions = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [-1.0, 0.3, 0.0], [0.0, 0.0, -1.0]];
    for direction in directions.map(Vector3::from) {
        let outwards = direction.normalize();
        let nearest = Vector3::new(1.0, 0.0, 0.0) + direction.map(|d| if d == 0.0 { 0.0 } else { 0.2f64.copysign(d) });
        for (gap, expected) in [(0.0021, false), (0.002_000_01, false), (0.001_999_99, true), (0.001, true)] {
            let center = nearest + outwards * (0.1 + gap);
            assert_eq!(contact(Pose::from(Translation3::from(center))), expected, "{direction} {gap}");
        }
    }
}

#[test]
fn spheres_keep_the_difference_of_centres_and_radii() {
    let ball = |radius| movable("ball", Shape::Sphere { radius }, 1, Pose::identity());
    let geometry = Geometry::new(&problem(vec![box_base("r")], vec![], vec![ball(0.1), ball(0.03)])).unwrap();
    for seed in 0..200 {
        let mut random = Random(seed);
        let (center, direction) = (random.pose(5.0), random.pose(1.0).translation.vector.normalize());
        let a = Standing { object: ObjectId(0), world_from_object: center };
        for (gap, expected) in [(0.002_000_1, false), (0.001_999_9, true), (0.0, true), (-0.13, true)] {
            let away = Translation3::from(direction * (0.13 + gap));
            let b = Standing { object: ObjectId(1), world_from_object: away * center };
            assert_eq!(geometry.standings_collide(&a, &b), expected, "seed {seed}, gap {gap}");
        }
    }
}

#[test]
fn states_agree_with_parry_on_every_pair() {
    let problem = mobile_problem();
    let geometry = Geometry::new(&problem).unwrap();
    let oracle = Oracle(&problem);
    let (mut free, mut hit) = (0, 0);
    for seed in 0..4000 {
        let mut random = Random(seed);
        let q = random_configuration(problem.robot(R1), &mut random);
        let holding = random_holding(&problem, &mut random);
        let least = oracle.own_and_fixed(R1, holding, &q);
        match geometry.state_contact(R1, holding, &q, NOTHING) {
            None => {
                free += 1;
                assert!(least >= CLEARANCE - PARRY, "seed {seed}: called free at {least} m");
            }
            Some(contact) => {
                hit += 1;
                let names = contact.describe(&problem);
                assert!(least < CLEARANCE + PARRY, "seed {seed}: called contact of {names} at {least} m");
            }
        }
    }
    assert!(free > 300 && hit > 300, "{free} free, {hit} in contact: the test sees too little of either");
}

#[test]
fn a_contact_names_two_bodies_that_are_that_near() {
    let problem = mobile_problem();
    let geometry = Geometry::new(&problem).unwrap();
    let oracle = Oracle(&problem);
    for seed in 0..400 {
        let mut random = Random(seed + 70_000);
        let q = random_configuration(problem.robot(R1), &mut random);
        let holding = random_holding(&problem, &mut random);
        let Some(contact) = geometry.state_contact(R1, holding, &q, NOTHING) else { continue };
        let mut pieces = oracle.robot(R1, holding, &q);
        pieces.extend(oracle.fixed());
        let named = |name: BodyName| pieces.iter().filter(move |piece| piece.name == name);
        let least =
            named(contact.first).flat_map(|a| named(contact.second).map(|b| a.distance(b))).fold(f64::MAX, f64::min);
        assert!(least < CLEARANCE + PARRY, "seed {seed}: {contact:?} at {least} m");
    }
}

#[test]
fn states_and_standing_objects_agree_with_parry() {
    let problem = mobile_problem();
    let geometry = Geometry::new(&problem).unwrap();
    let oracle = Oracle(&problem);
    let mut counts = [0, 0];
    for seed in 0..6000 {
        let mut random = Random(seed);
        let q = random_configuration(problem.robot(R1), &mut random);
        let object = ObjectId::at(random.pick(3));
        let holding = random_holding(&problem, &mut random).filter(|holding| holding.object != object);
        let pieces = oracle.robot(R1, holding, &q);
        // Near some piece of the robot, so that both answers occur.
        let near = pieces[random.pick(pieces.len())].pose.translation;
        let standing = Standing { object, world_from_object: near * random.pose(0.15) };
        let least = least_distance(&pieces, &[oracle.standing(&standing)]);
        let hits = geometry.state_hits(R1, holding, &q, NOTHING, &standing).is_some();
        counts[usize::from(hits)] += 1;
        let agrees = if hits { least < CLEARANCE + PARRY } else { least >= CLEARANCE - PARRY };
        assert!(agrees, "seed {seed}: hits {hits} at {least} m");
    }
    assert!(counts[0] > 500 && counts[1] > 500, "{counts:?}");
}

#[test]
fn standing_objects_agree_with_parry_on_each_other_and_on_fixed_objects() {
    let problem = mobile_problem();
    let geometry = Geometry::new(&problem).unwrap();
    let oracle = Oracle(&problem);
    let mut counts = [0; 4];
    for seed in 0..6000 {
        let mut random = Random(seed);
        let near = random.pose(1.5);
        let mut standing = || {
            let object = ObjectId::at(random.pick(3));
            Standing { object, world_from_object: near.translation * random.pose(0.12) }
        };
        let (a, b) = (standing(), standing());
        let apart = oracle.standing(&a).distance(&oracle.standing(&b));
        let collide = geometry.standings_collide(&a, &b);
        assert!(if collide { apart < CLEARANCE + PARRY } else { apart >= CLEARANCE - PARRY }, "seed {seed}: {apart}");
        let least = least_distance(&[oracle.standing(&a)], &oracle.fixed());
        let contact = geometry.standing_contact(&a, None).is_some();
        assert!(if contact { least < CLEARANCE + PARRY } else { least >= CLEARANCE - PARRY }, "seed {seed}: {least}");
        counts[usize::from(collide)] += 1;
        counts[2 + usize::from(contact)] += 1;
    }
    assert!(counts.iter().all(|count| *count > 100), "{counts:?}");
}

#[test]
fn an_object_may_stand_on_the_shelf_but_not_touch_the_wall_of_the_same_cabinet() {
    let problem = mobile_problem();
    let geometry = Geometry::new(&problem).unwrap();
    let cabinet = &problem.fixed[1];
    let (brick, support) = (ObjectId(0), Some(FixedId(1)));
    let on_shelf = |x: f64, y: f64, above: f64| {
        let world_from_object = cabinet.world_from_object * at(x, y, 0.51 + 0.075 + above);
        geometry.standing_contact(&Standing { object: brick, world_from_object }, support)
    };
    assert_eq!(on_shelf(0.0, 0.0, 0.0), None);
    assert_eq!(on_shelf(0.0, 0.0, 0.0009), None);
    assert_eq!(on_shelf(0.0, 0.0, -0.0009), None);
    let shelf_or_wall = Some(Contact { first: BodyName::Object(brick), second: BodyName::Fixed(FixedId(1)) });
    assert_eq!(on_shelf(0.0, 0.0, -0.01), shelf_or_wall, "sunk into the shelf");
    // The wall's inner face is at y = 0.29, the brick's side 0.02 from its middle.
    assert_eq!(on_shelf(0.0, 0.2675, 0.0), None);
    assert_eq!(on_shelf(0.0, 0.2685, 0.0), shelf_or_wall, "1.5 mm from the wall");
    let without = Standing { object: brick, world_from_object: cabinet.world_from_object * at(0.0, 0.0, 0.585) };
    assert_eq!(geometry.standing_contact(&without, None), shelf_or_wall);
    assert_eq!(geometry.standing_contact(&without, Some(FixedId(0))), shelf_or_wall, "the table is not its support");
}

#[test]
fn the_folded_arm_touches_itself_and_says_where() {
    let geometry = Geometry::new(&mobile_problem()).unwrap();
    let q = [0.0, 0.0, 0.0, 0.0, 2.2, 2.2, 0.0, 0.0, 0.0];
    let contact = geometry.state_contact(R1, None, &q, NOTHING).unwrap();
    assert!(matches!(contact.first, BodyName::Link { robot: R1, link: LinkId(0) }), "{contact:?}");
    let words = contact.describe(geometry.problem());
    assert!(words.starts_with("link `base` of `r1` and link `"), "{words}");
}

#[test]
fn what_is_no_configuration_is_never_called_free() {
    let geometry = Geometry::new(&mobile_problem()).unwrap();
    for bad in [vec![f64::NAN; 9], vec![0.0; 8], vec![f64::INFINITY; 9], vec![]] {
        assert!(geometry.state_contact(R1, None, &bad, NOTHING).is_some(), "{bad:?}");
        let holding = Some(Holding { object: ObjectId(0), grasp: GraspId(0) });
        let on_table = AllowedContacts { touch: None, support: Some(FixedId(0)) };
        assert!(geometry.state_contact(R1, holding, &bad, on_table).is_some(), "{bad:?}");
    }
    for (object, grasp) in [(0, 1), (3, 0)] {
        let holding = Some(Holding { object: ObjectId(object), grasp: GraspId(grasp) });
        assert!(geometry.state_contact(R1, holding, &[0.0; 9], NOTHING).is_some(), "object {object}, grasp {grasp}");
    }
    let turn = UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(f64::NAN, 0.0, 0.0, 0.0));
    let nowhere = Pose::from_parts(Translation3::new(f64::NAN, 0.0, 0.0), turn);
    let (here, nowhere) = (at(0.0, 0.0, 5.0), nowhere);
    let stand = |world_from_object| Standing { object: ObjectId(0), world_from_object };
    assert!(geometry.standings_collide(&stand(here), &stand(nowhere)));
    assert!(geometry.standing_contact(&stand(nowhere), None).is_some());
}

#[test]
fn degenerate_shapes_are_refused_by_name() {
    let mut bad = mobile_problem();
    bad.movable[1].body.shape = Shape::Sphere { radius: f64::NAN };
    assert!(Geometry::new(&bad).unwrap_err().to_string().contains("`can`"));
    let mut bad = mobile_problem();
    bad.robots[1].links[2].bodies[0].shape = Shape::Hull { points: vec![] };
    let message = Geometry::new(&bad).unwrap_err().to_string();
    assert!(message.contains("`upper`") && message.contains("`r2`"), "{message}");
}

/// Two boxes on wheels and a lift; the lift's post has a body, too.
fn company() -> Problem {
    let mut lift = lift();
    for link in &mut lift.links {
        link.bodies = vec![boxed(at(0.0, 0.0, 0.15), [0.2, 0.2, 0.3])];
    }
    lift.world_from_base = at(3.0, 0.0, 0.0);
    let mut idler = box_base("idler");
    idler.start = vec![-3.0, 0.0, 0.0];
    let mut problem = problem(vec![box_base("mover"), lift, idler], vec![], vec![]);
    problem.pairs.truncate(2);
    problem
}

#[test]
fn a_robot_without_pairs_and_the_post_of_an_arm_are_in_the_way_like_fixed_objects() {
    let problem = company();
    let geometry = Geometry::new(&problem).unwrap();
    let touched = |x: f64| geometry.state_contact(R1, None, &[x, 0.0, 0.0], NOTHING).map(|contact| contact.second);
    assert_eq!(touched(0.0), None);
    // The mover is 0.6 m long, the post 0.2 m.
    assert_eq!(touched(2.595), None);
    assert_eq!(touched(2.605), Some(BodyName::Link { robot: RobotId(1), link: LinkId(0) }));
    assert_eq!(touched(-2.395), None);
    assert_eq!(touched(-2.405), Some(BodyName::Link { robot: RobotId(2), link: LinkId(0) }));
    // Nobody is in his own way, and what moves is in nobody's.
    assert_eq!(geometry.state_contact(RobotId(2), None, &[-3.0, 0.0, 0.0], NOTHING), None);
    let mut busy = problem;
    busy.pairs.push(pair_of(2));
    busy.robots[1].links[0].bodies.clear();
    let geometry = Geometry::new(&busy).unwrap();
    for x in [3.0, -3.0] {
        assert_eq!(geometry.state_contact(R1, None, &[x, 0.0, 0.0], NOTHING), None, "{x}");
    }
}
