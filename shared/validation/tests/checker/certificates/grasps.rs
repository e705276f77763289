//! No grasp for both ends.

use model::{EndPolicy, Problem, Shape};
use plan::{BaseMap, Certificate, Distance, DistanceLimit, GraspReason, PairEnd, RefutedGrasp};

use super::{corrupt, elsewhere, proven};
use crate::fixture::{OBJECT, TOP, add_fixed};
use crate::robots::{HAND_TO_OBJECT, at, top_grasp};
use crate::scenarios::{TABLES, rover_round_wall, single};

fn blocked(grasp: u32, end: PairEnd, by: &[&str]) -> RefutedGrasp {
    let by = by.iter().map(|name| (*name).to_owned()).collect();
    RefutedGrasp { grasp, end, reason: GraspReason::Blocked { by } }
}

fn no_common(robot: &str, grasps: Vec<RefutedGrasp>) -> Certificate {
    Certificate::NoCommonGrasp { robot: robot.to_owned(), pair: format!("{robot}.1"), grasps }
}

/// Walls round table B's region, `free` apart (m) both ways, as high as the palm of a hand that holds.
fn add_box(problem: &mut Problem, free: f64) {
    problem.regions[1].size = [free, free];
    let (off, height) = (free / 2.0 + 0.02, 0.2);
    for (name, x, y) in [("east", off, 0.0), ("west", -off, 0.0)] {
        add_fixed(problem, name, [0.04, 0.4, height], [TABLES[1] + x, y, TOP + height / 2.0]);
    }
    for (name, x, y) in [("north", 0.0, off), ("south", 0.0, -off)] {
        add_fixed(problem, name, [free, 0.04, height], [TABLES[1] + x, y, TOP + height / 2.0]);
    }
}

/// The object fits into a box, but not the palm of 0.08 × 0.12 above it; at the other end nothing is in the way.
pub fn box_too_narrow() -> (Problem, Certificate) {
    let (mut problem, _) = single();
    add_box(&mut problem, 0.1);
    (problem, no_common("g1", vec![blocked(0, PairEnd::Place, &["east", "west", "north", "south"])]))
}

/// Two grasps from above, close and from higher up. Over the start hangs a board that only the higher hand runs into; in the
/// box there is no room for the close one.
fn board_and_box() -> (Problem, Certificate) {
    let (mut problem, _) = single();
    add_box(&mut problem, 0.1);
    let mut higher = top_grasp();
    higher.link_from_object = at(0.0, 0.0, -HAND_TO_OBJECT - 0.04);
    problem.movable[0].grasps[0].push(higher);
    let top = TOP + OBJECT[2] / 2.0 + HAND_TO_OBJECT + 0.03;
    add_fixed(&mut problem, "board", [0.3, 0.3, 0.02], [TABLES[0], 0.0, top + 0.01]);
    let grasps =
        vec![blocked(0, PairEnd::Place, &["east", "west", "north", "south"]), blocked(1, PairEnd::Pick, &["board"])];
    (problem, no_common("g1", grasps))
}

fn grasps(certificate: &mut Certificate) -> &mut Vec<RefutedGrasp> {
    match certificate {
        Certificate::NoCommonGrasp { grasps, .. } => grasps,
        other => panic!("another kind: {other:?}"),
    }
}

#[test]
fn grasps_that_are_blocked_at_one_end_are_accepted_as_proof() {
    for (problem, certificate) in [box_too_narrow(), board_and_box()] {
        proven(&problem, &certificate);
    }
}

#[test]
fn where_there_is_room_for_the_hand_the_proof_is_refused() {
    let (problem, certificate) = box_too_narrow();
    for free in [0.13, 0.125] {
        let (mut wide, _) = single();
        add_box(&mut wide, free);
        super::refused(&wide, &certificate, "has room");
    }
    // The walls end below the palm.
    elsewhere(&problem, &certificate, "has room", |problem| {
        problem.fixed.iter_mut().skip(2).for_each(|wall| wall.world_from_object.translation.z -= 0.1);
    });
    elsewhere(&problem, &certificate, "has room", |problem| {
        problem.fixed.retain(|wall| wall.name != "north");
        problem.fixed.push(problem.fixed[0].clone());
        problem.fixed.last_mut().expect("a body").name = "north".to_owned();
    });
    // A grasp that holds the object farther down the fingers, so that the palm stays above the walls.
    elsewhere(&problem, &certificate, "has room", |problem| {
        problem.movable[0].grasps[0][0].link_from_object = at(0.0, 0.0, -0.16);
    });
    // Of a mesh only a few points are looked at, and none of these is in the hand.
    elsewhere(&problem, &certificate, "has room", |problem| {
        let points = problem.fixed[2].bodies[0].shape.support_points();
        problem.fixed[2].bodies[0].shape = Shape::Hull { points };
    });
}

#[test]
fn incomplete_and_wrong_lists_are_refused() {
    let (problem, certificate) = board_and_box();
    let change = |why: &str, change: fn(&mut Vec<RefutedGrasp>)| {
        corrupt(&problem, &certificate, why, |certificate| change(grasps(certificate)));
    };
    change("one by one", |grasps| grasps.truncate(1));
    change("one by one", |grasps| grasps.swap(0, 1));
    change("one by one", |grasps| grasps[1].grasp = 0);
    change("grasp 0: ", |grasps| grasps[0].end = PairEnd::Pick);
    change("grasp 1: ", |grasps| grasps[1].end = PairEnd::Place);
    change("grasp 1: ", |grasps| grasps[1].reason = GraspReason::Blocked { by: vec!["table A".to_owned()] });
    change("no fixed object", |grasps| grasps[1].reason = GraspReason::Blocked { by: vec!["cloud".to_owned()] });
    change("grasp 0: ", |grasps| grasps[0].reason = GraspReason::Blocked { by: vec!["east".to_owned()] });
    elsewhere(&problem, &certificate, "one by one", |problem| {
        let third = problem.movable[0].grasps[0][0].clone();
        problem.movable[0].grasps[0].push(third);
    });
    elsewhere(&problem, &certificate, "grasp 1: ", |problem| {
        problem.fixed.last_mut().expect("the board").world_from_object.translation.x += 0.5;
    });
    elsewhere(&problem, &certificate, "no pair of g1", |problem| {
        problem.robots.push(crate::robots::gantry("g2", [0.0, 1.0, 0.75]));
        problem.pairs[0].robot = model::RobotId(1);
    });
}

/// One grasp out of reach at the far table, one blocked where the object stands.
#[test]
fn a_grasp_may_be_out_of_reach_at_one_end() {
    let (mut problem, _) = rover_round_wall(EndPolicy::Return);
    problem.regions[1].world_from_region.translation.x = 6.0;
    let mut long = top_grasp();
    long.link_from_object = at(0.0, 0.0, -HAND_TO_OBJECT - 0.3);
    problem.movable[0].grasps[0].push(long);
    let board = TOP + OBJECT[2] / 2.0 + HAND_TO_OBJECT + 0.3;
    add_fixed(&mut problem, "board", [0.3, 0.3, 0.02], [2.0, 0.0, board]);
    let limit = DistanceLimit::Far { greatest_m: 0.79, nearest_m: 0.96 };
    let distance = Distance { shoulder_m: [0.0, 0.0, 0.65], limit };
    let map = Some(BaseMap { cell_m: 0.1, discs: Vec::new() });
    let out = GraspReason::OutOfReach { distance, map };
    let refuted =
        vec![RefutedGrasp { grasp: 0, end: PairEnd::Place, reason: out }, blocked(1, PairEnd::Pick, &["board"])];
    let certificate = no_common("r1", refuted);
    proven_after_narrowing(&mut problem, &certificate);
}

/// With base limits of 4.8 m the table at 6 m is out of reach, with 5 m it may not be.
fn proven_after_narrowing(problem: &mut Problem, certificate: &Certificate) {
    super::refused(problem, certificate, "as near as");
    problem.robots[0].coordinates[0].upper = 4.8;
    proven(problem, certificate);
    corrupt(problem, certificate, "grasp 0: ", |certificate| grasps(certificate)[0].end = PairEnd::Pick);
}
