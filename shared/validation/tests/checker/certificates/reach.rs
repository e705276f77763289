//! Reach and maps.

use model::{EndPolicy, Problem};
use plan::{BaseMap, Certificate, Disc, Distance, DistanceLimit, PairEnd};

use super::{corrupt, elsewhere, proven, refused};
use crate::fixture::{add_fixed, add_object, add_pair, add_table, problem};
use crate::robots::{at, gantry, rover};
use crate::scenarios::{rover_round_wall, single};

/// Middle of the way that a rover's hand goes up and down (m): from there it is 0.35 m up and 0.25 m out at most, and slides
/// 0.35 m on.
const SHOULDER: [f64; 3] = [0.0, 0.0, 0.65];
/// No distance of a rover's hand from there is greater (m).
const GREATEST: f64 = 0.79;
/// A disc inside of the rover's square body, from 5 cm above the floor to 1.05 m.
const DISC: Disc = Disc { bottom_m: 0.06, top_m: 1.04, radius_m: 0.149 };

fn far(nearest_m: f64) -> Distance {
    Distance { shoulder_m: SHOULDER, limit: DistanceLimit::Far { greatest_m: GREATEST, nearest_m } }
}

fn reach(distance: Distance, map: Option<BaseMap>) -> Certificate {
    Certificate::Reach {
        robot: "r1".to_owned(),
        pair: "r1.1".to_owned(),
        end: PairEnd::Place,
        region: "B".to_owned(),
        distance,
        map,
    }
}

/// A rover shall place an object 20 m away; its base may go 5 m.
fn far_away() -> (Problem, Certificate) {
    let (mut problem, _) = rover_round_wall(EndPolicy::Return);
    problem.regions[1].world_from_region.translation.x = 20.0;
    (problem, reach(far(14.5), Some(BaseMap { cell_m: 0.1, discs: Vec::new() })))
}

/// A rover shall place an object in the middle of a counter 2 m deep that its base cannot pass.
fn deep_counter() -> (Problem, Certificate) {
    let mut problem = problem(vec![rover("r1", [-1.0, 0.0, 0.0])]);
    problem.robots[0].coordinates[0].upper = 2.9;
    let a = add_table(&mut problem, "A", -3.0, 0.0);
    let b = add_table(&mut problem, "B", 2.0, 0.0);
    add_fixed(&mut problem, "counter", [2.0, 12.0, 0.38], [2.0, 0.0, 0.19]);
    let m = add_object(&mut problem, "m1", -3.0, 0.0, a);
    add_pair(&mut problem, 0, m, a, b);
    (problem, reach(far(1.0), Some(BaseMap { cell_m: 0.03, discs: vec![DISC] })))
}

fn parts(certificate: &mut Certificate) -> (&mut Distance, &mut Option<BaseMap>) {
    match certificate {
        Certificate::Reach { distance, map, .. } => (distance, map),
        other => panic!("another kind: {other:?}"),
    }
}

fn map(certificate: &mut Certificate) -> &mut BaseMap {
    match certificate {
        Certificate::Reach { map: Some(map), .. } | Certificate::BaseDisconnected { map, .. } => map,
        other => panic!("no map: {other:?}"),
    }
}

#[test]
fn what_is_out_of_reach_is_accepted_as_proof() {
    for (problem, certificate) in [far_away(), deep_counter()] {
        proven(&problem, &certificate);
    }
}

#[test]
fn exaggerated_distances_are_refused() {
    let (problem, certificate) = far_away();
    let limit = |why: &str, limit: DistanceLimit| {
        corrupt(&problem, &certificate, why, |certificate| parts(certificate).0.limit = limit);
    };
    limit("as near as", DistanceLimit::Far { greatest_m: GREATEST, nearest_m: 15.5 });
    limit("as near as", DistanceLimit::Far { greatest_m: 14.0, nearest_m: 13.0 });
    limit("as near as", DistanceLimit::Far { greatest_m: GREATEST, nearest_m: f64::NAN });
    limit("as far as", DistanceLimit::Far { greatest_m: 0.77, nearest_m: 14.0 });
    limit("comes as near as", DistanceLimit::Near { least_m: 1.0, farthest_m: 0.9 });
    // Measured from below the floor the hand gets farther.
    corrupt(&problem, &certificate, "as far as", |certificate| parts(certificate).0.shoulder_m = [0.0, 0.0, -1.0]);
    corrupt(&problem, &certificate, "nowhere", |certificate| parts(certificate).0.shoulder_m[0] = f64::INFINITY);
    elsewhere(&problem, &certificate, "as near as", |problem| problem.robots[0].coordinates[0].upper = 19.0);
    elsewhere(&problem, &certificate, "as far as", |problem| problem.robots[0].coordinates[4].upper = 20.0);
    elsewhere(&problem, &certificate, "as near as", |problem| {
        problem.movable[0].grasps[0][0].link_from_object = at(15.0, 0.0, 0.0);
    });
}

#[test]
fn reaches_of_something_else_are_refused() {
    let (problem, certificate) = far_away();
    let change = |why: &str, change: fn((&mut String, &mut String, &mut PairEnd, &mut String))| {
        corrupt(&problem, &certificate, why, |certificate| {
            if let Certificate::Reach { robot, pair, end, region, .. } = certificate {
                change((robot, pair, end, region));
            }
        });
    };
    change("no robot", |(robot, ..)| *robot = "r2".to_owned());
    change("no pair", |(_, pair, ..)| *pair = "r1.2".to_owned());
    change("does not end there", |(_, _, end, _)| *end = PairEnd::Pick);
    change("does not end there", |(.., region)| *region = "A".to_owned());
    change("as near as", |(_, _, end, region)| (*end, *region) = (PairEnd::Pick, "A".to_owned()));
    corrupt(&problem, &certificate, "no map", |certificate| *parts(certificate).1 = None);
}

#[test]
fn maps_that_block_too_much_are_refused() {
    let (problem, certificate) = deep_counter();
    let change = |why: &str, change: fn(&mut BaseMap)| {
        corrupt(&problem, &certificate, why, |certificate| change(map(certificate)));
    };
    change("holds a disc", |map| map.discs[0].radius_m = 0.151);
    change("holds a disc", |map| map.discs[0].top_m = 1.06);
    change("holds a disc", |map| map.discs[0].bottom_m = 0.04);
    change("holds a disc", |map| map.discs[0].radius_m = f64::NAN);
    change("as near as", |map| map.discs.clear());
    change("as near as", |map| map.cell_m = 0.3);
    change("cells", |map| map.cell_m = 1e-4);
    change("cells", |map| map.cell_m = f64::NAN);
    let narrower = |edge: f64| {
        move |problem: &mut Problem| problem.fixed[2].bodies[0].shape = model::Shape::Box { size: [2.0, edge, 0.38] }
    };
    // Past its end there is room to come nearer.
    elsewhere(&problem, &certificate, "as near as", narrower(1.0));
    // So low that the rover drives over it; so high that it drives under it.
    for z in [-0.33, 1.3] {
        elsewhere(&problem, &certificate, "as near as", |problem| {
            problem.fixed[2].world_from_object.translation.z = z;
            problem.fixed.remove(1);
        });
    }
    elsewhere(&problem, &certificate, "does not stand level", |problem| {
        let tilt = nalgebra::UnitQuaternion::from_axis_angle(&nalgebra::Vector3::x_axis(), 0.01);
        problem.robots[0].world_from_base.rotation = tilt;
    });
}

/// A fixed robot and a table that is too near, measured from a point 10 m behind it: its slides go 2 m each way.
fn too_near() -> (Problem, Certificate) {
    let mut problem = problem(vec![gantry("r1", [0.0, 0.0, 0.75])]);
    let a = add_table(&mut problem, "A", 0.0, 0.0);
    let b = add_table(&mut problem, "B", 5.0, 0.0);
    let m = add_object(&mut problem, "m1", 0.0, 0.0, a);
    add_pair(&mut problem, 0, m, a, b);
    let limit = DistanceLimit::Near { least_m: 5.9, farthest_m: 5.3 };
    (problem, reach(Distance { shoulder_m: [10.0, 0.0, 0.0], limit }, None))
}

#[test]
fn what_is_too_near_is_accepted_as_proof_and_exaggerations_are_refused() {
    let (problem, certificate) = too_near();
    proven(&problem, &certificate);
    let limit = |why: &str, least_m: f64, farthest_m: f64| {
        let limit = DistanceLimit::Near { least_m, farthest_m };
        corrupt(&problem, &certificate, why, |certificate| parts(certificate).0.limit = limit);
    };
    limit("comes as near as", 6.6, 5.3);
    limit("as far as", 5.9, 4.9);
    limit("as far as", 5.2, 5.3);
    elsewhere(&problem, &certificate, "comes as near as", |problem| problem.robots[0].coordinates[0].upper = 3.0);
    elsewhere(&problem, &certificate, "as far as", |problem| problem.regions[1].size = [2.0, 0.2]);
    corrupt(&problem, &certificate, "there is a map", |certificate| {
        *parts(certificate).1 = Some(BaseMap { cell_m: 0.1, discs: Vec::new() });
    });
}

/// A wall right across the rover's limits, between its start and the table that it shall bring an object to.
fn walled_off() -> (Problem, Certificate) {
    let (mut problem, _) = rover_round_wall(EndPolicy::Return);
    problem.fixed.retain(|fixed| fixed.name != "wall");
    add_fixed(&mut problem, "west wall", [7.0, 0.1, 1.0], [-2.5, 1.5, 0.5]);
    add_fixed(&mut problem, "east wall", [7.0, 0.1, 1.0], [4.5, 1.5, 0.5]);
    let certificate = Certificate::BaseDisconnected {
        robot: "r1".to_owned(),
        pair: "r1.1".to_owned(),
        end: PairEnd::Place,
        region: "B".to_owned(),
        from_m: [0.0, 0.0],
        shoulder_m: SHOULDER,
        greatest_m: GREATEST,
        map: BaseMap { cell_m: 0.05, discs: vec![DISC] },
    };
    (problem, certificate)
}

#[test]
fn a_base_that_is_walled_off_is_accepted_as_proof_and_so_is_one_before_a_narrow_gap() {
    let (problem, certificate) = walled_off();
    proven(&problem, &certificate);
    // The walls end at x = 1; a gap of 0.2 m is too narrow for a disc of 0.298 m, one of 0.4 m is not.
    let gap = |width: f64| {
        move |problem: &mut Problem| {
            problem.fixed.last_mut().expect("a wall").world_from_object.translation.x += width;
        }
    };
    let mut narrow = problem.clone();
    gap(0.2)(&mut narrow);
    proven(&narrow, &certificate);
    elsewhere(&problem, &certificate, "may drive", gap(0.4));
}

#[test]
fn connected_bases_and_exaggerated_maps_are_refused() {
    let (problem, certificate) = walled_off();
    corrupt(&problem, &certificate, "holds a disc", |certificate| map(certificate).discs[0].radius_m = 0.16);
    corrupt(&problem, &certificate, "may drive", |certificate| map(certificate).discs.clear());
    corrupt(&problem, &certificate, "may drive", |certificate| map(certificate).cell_m = 0.5);
    let change = |why: &str, change: fn((&mut [f64; 2], &mut f64, &mut PairEnd, &mut String))| {
        corrupt(&problem, &certificate, why, |certificate| {
            if let Certificate::BaseDisconnected { from_m, greatest_m, end, region, .. } = certificate {
                change((from_m, greatest_m, end, region));
            }
        });
    };
    change("does not start at", |(from, ..)| from[1] = 2.5);
    change("as far as", |(_, greatest, ..)| *greatest = 0.77);
    change("may drive", |(_, greatest, ..)| *greatest = 1.7);
    change("may drive", |(_, _, end, region)| (*end, *region) = (PairEnd::Pick, "A".to_owned()));
    // It reaches over the wall, drives over it, or starts behind it.
    elsewhere(&problem, &certificate, "may drive", |problem| {
        problem.regions[1].world_from_region.translation.y = 2.1;
    });
    elsewhere(&problem, &certificate, "may drive", |problem| {
        for wall in problem.fixed.iter_mut().filter(|fixed| fixed.name.ends_with("wall")) {
            wall.world_from_object.translation.z -= 0.95;
        }
    });
    elsewhere(&problem, &certificate, "cannot stand", |problem| {
        add_fixed(problem, "block", [1.0, 1.0, 1.0], [0.0, 0.0, 0.5]);
    });
    elsewhere(&problem, &certificate, "does not start at", |problem| problem.robots[0].start[1] = 3.0);
}

#[test]
fn a_feasible_problem_has_no_such_certificate() {
    let (problem, _) = rover_round_wall(EndPolicy::Return);
    for certificate in [far_away().1, deep_counter().1] {
        refused(&problem, &certificate, "as near as");
    }
    refused(&problem, &walled_off().1, "may drive");
    let (problem, _) = single();
    refused(&problem, &too_near().1, "no pair");
}
