//! Objects in the hand and contacts that are allowed.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

mod common;

use collision::{AllowedContacts, BodyName, Contact, Geometry, Holding, Motion, Standing};
use common::*;
use model::{FixedId, GraspId, LinkId, ObjectId, Pose, Problem, RobotId, Shape};

const R1: RobotId = RobotId(0);
const BRICK: ObjectId = ObjectId(0);
const NOTHING: AllowedContacts = AllowedContacts { touch: None, support: None };
const HOLDING: Option<Holding> = Some(Holding { object: BRICK, grasp: GraspId(0) });

/// The 2R arm in its plane, a cube of 0.2 m held 0.2 m beyond its tip, and a post.
fn reaching(post: Pose) -> Problem {
    let cube = movable("cube", Shape::Box { size: [0.2, 0.2, 0.2] }, 1, at(1.2, 0.0, 0.0));
    let post = fixed("post", post, vec![boxed(Pose::identity(), [0.1, 0.1, 1.0])]);
    problem(vec![planar_2r()], vec![post], vec![cube])
}

#[test]
fn the_load_is_where_the_hand_is() {
    // The cube's far face is at 2.3 m along the stretched arm.
    for (gap, touches) in [(0.0021, false), (0.0019, true)] {
        for bearing in [0.0f64, 0.7, -2.0] {
            let far = 2.3 + gap + 0.05;
            let geometry = Geometry::new(&reaching(turned(far * bearing.cos(), far * bearing.sin(), 0.0, bearing)));
            let geometry = geometry.unwrap();
            let q = [bearing, 0.0];
            assert_eq!(geometry.state_contact(R1, None, &q, NOTHING), None);
            let expected =
                Contact { first: BodyName::Held { robot: R1, object: BRICK }, second: BodyName::Fixed(FixedId(0)) };
            let found = geometry.state_contact(R1, HOLDING, &q, NOTHING);
            assert_eq!(found, touches.then_some(expected), "bearing {bearing}, gap {gap}");
        }
    }
}

#[test]
fn the_load_is_tested_against_the_arm_but_not_against_the_hand() {
    let mut folded = reaching(at(0.0, 0.0, 50.0));
    // Held at the root of the second link, the cube overlaps the first link's end and the second link.
    folded.movable[0].grasps[0][0].link_from_object = Pose::identity();
    let geometry = Geometry::new(&folded).unwrap();
    let upper = BodyName::Link { robot: R1, link: LinkId(1) };
    let expected = Contact { first: upper, second: BodyName::Held { robot: R1, object: BRICK } };
    assert_eq!(geometry.state_contact(R1, HOLDING, &[0.0, 0.0], NOTHING), Some(expected));
    folded.movable[0].grasps[0][0].link_from_object = at(0.5, 0.0, 0.0);
    let geometry = Geometry::new(&folded).unwrap();
    assert_eq!(geometry.state_contact(R1, HOLDING, &[0.0, 0.0], NOTHING), None, "it overlaps the hand only");
}

#[test]
fn fingers_close_to_the_opening_of_the_grasp() {
    // A post beside the open finger: the finger's outer face is at 0.005 + opening / 2 + 0.005 from the palm's middle.
    let mut mobile = mobile_problem();
    mobile.fixed = vec![fixed("post", at(0.1, 0.0, 0.0), vec![boxed(at(0.0, 0.041 + 0.05, 1.87), [0.01, 0.1, 0.03])])];
    let geometry = Geometry::new(&mobile).unwrap();
    let q = [0.0; 9];
    let open = geometry.state_contact(R1, None, &q, NOTHING);
    let left = BodyName::Link { robot: R1, link: LinkId(7) };
    assert_eq!(open, Some(Contact { first: left, second: BodyName::Fixed(FixedId(0)) }));
    let can = Some(Holding { object: ObjectId(1), grasp: GraspId(0) });
    assert_eq!(geometry.state_contact(R1, can, &q, NOTHING), None);
}

#[test]
fn only_touch_links_may_touch_only_the_object_named() {
    let mut two = reaching(at(0.0, 0.0, 50.0));
    two.movable.push(two.movable[0].clone());
    let geometry = Geometry::new(&two).unwrap();
    let q = [0.0, 0.0];
    let at_hand = Standing { object: BRICK, world_from_object: at(1.6, 0.0, 0.0) };
    let touch = AllowedContacts { touch: Some(BRICK), support: None };
    let hand = BodyName::Link { robot: R1, link: LinkId(2) };
    let contact = Some(Contact { first: hand, second: BodyName::Object(BRICK) });
    assert_eq!(geometry.state_hits(R1, None, &q, NOTHING, &at_hand), contact);
    assert_eq!(geometry.state_hits(R1, None, &q, touch, &at_hand), None);
    let other = AllowedContacts { touch: Some(ObjectId(1)), support: None };
    assert_eq!(geometry.state_hits(R1, None, &q, other, &at_hand), contact);
    let at_arm = Standing { object: BRICK, world_from_object: at(0.5, 0.0, 0.0) };
    let arm = BodyName::Link { robot: R1, link: LinkId(1) };
    let contact = Some(Contact { first: arm, second: BodyName::Object(BRICK) });
    assert_eq!(geometry.state_hits(R1, None, &q, touch, &at_arm), contact);
    // The same on motions and sweeps.
    let motion = Motion { robot: R1, holding: None, from: vec![-0.3, 0.0], to: vec![0.3, 0.0], allowed: touch };
    let beside = Standing { object: BRICK, world_from_object: at(1.7, 0.3, 0.0) };
    assert_eq!(geometry.motion_hits(&motion, &beside), None);
    assert!(!geometry.sweep_hits(&geometry.sweep(&motion, 0, 1), &beside));
    let strict = Motion { allowed: NOTHING, ..motion };
    assert!(geometry.motion_hits(&strict, &beside).is_some());
    assert!(geometry.sweep_hits(&geometry.sweep(&strict, 0, 1), &beside));
}

#[test]
fn the_load_never_hits_itself_but_hits_what_stands_in_its_way() {
    let mut two = reaching(at(0.0, 0.0, 50.0));
    two.movable.push(two.movable[0].clone());
    let geometry = Geometry::new(&two).unwrap();
    let q = [0.0, 0.0];
    let stand = |object| Standing { object, world_from_object: at(2.25, 0.0, 0.0) };
    assert_eq!(geometry.state_hits(R1, HOLDING, &q, NOTHING, &stand(BRICK)), None);
    let held = BodyName::Held { robot: R1, object: BRICK };
    let contact = Some(Contact { first: held, second: BodyName::Object(ObjectId(1)) });
    assert_eq!(geometry.state_hits(R1, HOLDING, &q, NOTHING, &stand(ObjectId(1))), contact);
    let touch = AllowedContacts { touch: Some(ObjectId(1)), support: None };
    assert_eq!(geometry.state_hits(R1, HOLDING, &q, touch, &stand(ObjectId(1))), contact, "the load may not touch");
}

/// A base carrying a crate of 0.2 m in front at table height, over a table top between two cheeks.
fn forklift() -> (Geometry, Vec<f64>) {
    let crate_ = movable("crate", Shape::Box { size: [0.2, 0.2, 0.2] }, 1, at(0.6, 0.0, 0.6));
    let table = vec![
        boxed(at(0.0, 0.0, -0.02), [0.5, 0.8, 0.04]),
        boxed(at(0.0, 0.3, 0.1), [0.5, 0.04, 0.2]),
        boxed(at(0.0, -0.3, 0.1), [0.5, 0.04, 0.2]),
    ];
    let shelf = vec![boxed(at(0.0, 0.0, -0.02), [0.2, 0.2, 0.04])];
    let fixed = vec![fixed("table", at(0.6, 0.0, 0.5), table), fixed("shelf", at(0.6, -2.0, 0.5), shelf)];
    let geometry = Geometry::new(&problem(vec![box_base("r")], fixed, vec![crate_])).unwrap();
    (geometry, vec![0.0, 0.0, 0.0])
}

#[test]
fn the_load_may_touch_the_body_it_stands_on_and_no_other_body_of_its_support() {
    let (geometry, q) = forklift();
    let table = AllowedContacts { touch: None, support: Some(FixedId(0)) };
    let shelf = AllowedContacts { touch: None, support: Some(FixedId(1)) };
    let held = BodyName::Held { robot: R1, object: BRICK };
    let on_table = Some(Contact { first: held, second: BodyName::Fixed(FixedId(0)) });
    assert_eq!(geometry.state_contact(R1, HOLDING, &q, NOTHING), on_table);
    assert_eq!(geometry.state_contact(R1, HOLDING, &q, shelf), on_table);
    assert_eq!(geometry.state_contact(R1, HOLDING, &q, table), None);
    // Sliding 0.17 m sideways on the table is free, 0.18 m would bring the crate against a cheek.
    let slide = |y: f64| Motion { robot: R1, holding: HOLDING, from: q.clone(), to: vec![0.0, y, 0.0], allowed: table };
    assert_eq!(geometry.motion_contact(&slide(0.17)), None);
    assert_eq!(geometry.motion_contact(&slide(0.18)), on_table);
    assert_eq!(geometry.motion_contact(&Motion { allowed: NOTHING, ..slide(0.17) }), on_table);
}

#[test]
fn a_support_counts_by_where_the_motion_begins_or_ends() {
    let (geometry, q) = forklift();
    let mut lowered = geometry.problem().clone();
    // Held 5 cm lower the crate is sunk into the table: no support from above.
    lowered.movable[0].grasps[0][0].link_from_object = at(0.6, 0.0, 0.55);
    let table = AllowedContacts { touch: None, support: Some(FixedId(0)) };
    let sunk = Geometry::new(&lowered).unwrap();
    assert!(sunk.state_contact(R1, HOLDING, &q, table).is_some());
    // Held 1.5 mm above, nearer than the clearance: still standing on it.
    lowered.movable[0].grasps[0][0].link_from_object = at(0.6, 0.0, 0.6015);
    let hovering = Geometry::new(&lowered).unwrap();
    assert_eq!(hovering.state_contact(R1, HOLDING, &q, table), None);
    assert!(hovering.state_contact(R1, HOLDING, &q, NOTHING).is_some());
}

#[test]
fn lifting_off_and_setting_down_are_free_whichever_end_is_on_the_support() {
    let crate_ = movable("crate", Shape::Box { size: [0.2, 0.2, 0.2] }, 1, at(0.0, 0.0, 0.1));
    let table = fixed("table", at(0.0, 0.0, -0.02), vec![boxed(Pose::identity(), [0.5, 0.8, 0.04])]);
    let geometry = Geometry::new(&problem(vec![lift()], vec![table], vec![crate_])).unwrap();
    let support = |support| AllowedContacts { touch: None, support };
    let free = |from: f64, to: f64, allowed| {
        let motion = Motion { robot: R1, holding: HOLDING, from: vec![from], to: vec![to], allowed };
        geometry.motion_contact(&motion).is_none()
    };
    for (from, to) in [(0.0, 0.05), (0.05, 0.0), (0.0, 0.0)] {
        assert!(free(from, to, support(Some(FixedId(0)))), "{from} to {to}");
        assert!(!free(from, to, support(None)), "{from} to {to}");
    }
    assert!(free(0.003, 0.5, support(None)), "3 mm above");
    assert!(!free(0.05, -0.01, support(Some(FixedId(0)))), "set down 1 cm too deep");
    assert!(!free(0.5, -0.5, support(Some(FixedId(0)))), "through the table");
}
