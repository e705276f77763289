//! A robot's own links: which touch, and which never can.

mod common;

use collision::{AllowedContacts, BodyName, Contact, Geometry};
use common::*;
use model::{LinkId, RobotId};

const R1: RobotId = RobotId(0);
const NOTHING: AllowedContacts = AllowedContacts { touch: None, support: None };
const PARTS: usize = 20_000;

#[test]
fn own_contacts_are_all_pairs_of_links_of_which_a_state_names_one() {
    let mut problem = mobile_problem();
    problem.fixed.clear();
    let neighbours = problem.robots[0].disabled_pairs.split_off(1);
    let geometry = Geometry::new(&problem).unwrap();
    let (mut one, mut several) = (0, 0);
    for seed in 0..2000 {
        let q = random_configuration(problem.robot(R1), &mut Random(seed + 90_000));
        let contacts = geometry.own_contacts(R1, &q);
        let named = geometry.state_contact(R1, None, &q, NOTHING);
        one += usize::from(contacts.len() == 1);
        several += usize::from(contacts.len() > 1);
        assert!(contacts.iter().all(|(a, b)| a < b) && contacts.is_sorted(), "seed {seed}");
        match named {
            None => assert!(contacts.is_empty(), "seed {seed}"),
            Some(Contact { first: BodyName::Link { link: a, .. }, second: BodyName::Link { link: b, .. } }) => {
                assert!(contacts.contains(&(a.min(b), a.max(b))), "seed {seed}");
            }
            Some(contact) => panic!("seed {seed}: {contact:?}"),
        }
    }
    assert!(
        !neighbours.is_empty() && one + several > 200 && several > 5,
        "{one} with one contact, {several} with more"
    );
}

#[test]
fn bars_that_pass_each_other_are_proven_apart_and_bars_that_meet_are_not() {
    // The ends of the bars are square: their corners reach 1.25 mm farther than the bars are long.
    for (gap, apart) in [(0.1, true), (0.006, true), (0.004, false), (-0.05, false)] {
        let geometry = Geometry::new(&problem(vec![two_bars(gap)], vec![], vec![])).unwrap();
        let proven = geometry.links_never_touch(R1, (LinkId(1), LinkId(2)), PARTS);
        assert_eq!(proven, apart, "gap {gap}");
    }
}

/// Oracle: random configurations and openings.
#[test]
fn links_proven_apart_touch_in_no_random_configuration_at_any_opening() {
    let mut problem = mobile_problem();
    problem.fixed.clear();
    let robot = problem.robots[0].clone();
    let geometry = Geometry::new(&problem).unwrap();
    let all: Vec<(LinkId, LinkId)> = (0..robot.links.len())
        .flat_map(|i| (i + 1..robot.links.len()).map(move |j| (LinkId::at(i), LinkId::at(j))))
        .filter(|pair| !robot.disabled_pairs.contains(pair))
        .collect();
    let proven: Vec<_> = all.iter().filter(|pair| geometry.links_never_touch(R1, **pair, PARTS)).collect();
    assert!(proven.len() >= 8 && proven.len() < all.len(), "{} of {} pairs proven", proven.len(), all.len());
    for opening in [0.0, 0.02, 0.05, 0.08] {
        problem.robots[0].end_effector.max_opening = opening;
        let geometry = Geometry::new(&problem).unwrap();
        for seed in 0..3000 {
            let q = random_configuration(&robot, &mut Random(seed + 95_000));
            for contact in geometry.own_contacts(R1, &q) {
                assert!(!proven.contains(&&contact), "seed {seed}, opening {opening}: {contact:?} proven apart");
            }
        }
    }
}
