//! Cycles, areas, sizes.

use model::{GivenOrdering, ObjectId, PairId, Point, Problem, Shape};
use plan::{Certificate, Cover, CycleArc, CycleOrigin, Exclusion, PairPoint, Stay};

use super::{corrupt, elsewhere, proven, refused};
use crate::fixture::{OBJECT, add_object, add_pair, add_table, problem};
use crate::robots::gantry;

/// Room for one object with 5 mm to the border, not for two (m), and what is within that border (m²).
const ONE_SLOT: [f64; 2] = [0.08, 0.06];
const ONE_SLOT_AREA: f64 = 0.07 * 0.05;
/// What one object covers (m²).
const COVERED: f64 = OBJECT[0] * OBJECT[1];

fn robots(count: usize) -> Problem {
    problem((0..count).map(|i| gantry(&format!("g{}", i + 1), [0.0, i as f64 - 1.0, 0.75])).collect())
}

fn at(pair: &str, point: Point) -> PairPoint {
    PairPoint { pair: pair.to_owned(), point }
}

fn arc(before: (&str, Point), after: (&str, Point), origin: CycleOrigin) -> CycleArc {
    CycleArc { before: at(before.0, before.1), after: at(after.0, after.1), origin }
}

fn cover(object: &str, placed_by: Option<&str>) -> Cover {
    Cover {
        stay: Stay { object: object.to_owned(), placed_by: placed_by.map(str::to_owned) },
        area_m2: COVERED * (1.0 - 1e-9),
    }
}

fn exclusion(region: &str, first: Cover, second: Cover) -> Exclusion {
    Exclusion { region: region.to_owned(), region_area_m2: ONE_SLOT_AREA * (1.0 + 1e-9), stays: [first, second] }
}

const EXCLUDED: CycleOrigin = CycleOrigin::Excluded { exclusion: 0 };

/// The place for one object must be cleared by g2 before g1 puts the new one there; the problem says the opposite.
fn contradiction() -> (Problem, Certificate) {
    let mut problem = robots(2);
    let (a, b) = (add_table(&mut problem, "A", -1.0, 0.0), add_table(&mut problem, "B", 1.0, 0.0));
    let tiny = add_table(&mut problem, "tiny", 0.0, 0.0);
    problem.regions[tiny.index()].size = ONE_SLOT;
    let new = add_object(&mut problem, "new", -1.0, 0.0, a);
    let old = add_object(&mut problem, "old", 0.0, 0.0, tiny);
    let brings = add_pair(&mut problem, 0, new, a, tiny);
    let clears = add_pair(&mut problem, 1, old, tiny, b);
    problem.orderings.push(GivenOrdering { before: (brings, Point::Release), after: (clears, Point::Grasp) });
    let certificate = Certificate::Cycle {
        exclusions: vec![exclusion("tiny", cover("old", None), cover("new", Some("g1.1")))],
        cycles: vec![vec![
            arc(("g1.1", Point::Release), ("g2.1", Point::Grasp), CycleOrigin::Given),
            arc(("g2.1", Point::Grasp), ("g1.1", Point::Release), EXCLUDED),
        ]],
    };
    (problem, certificate)
}

/// One robot shall swap two objects between two places for one each.
fn swap() -> (Problem, Certificate) {
    let mut problem = robots(1);
    let (a, b) = (add_table(&mut problem, "A", -1.0, 0.0), add_table(&mut problem, "B", 1.0, 0.0));
    problem.regions.iter_mut().for_each(|region| region.size = ONE_SLOT);
    let (x, y) = (add_object(&mut problem, "x", -1.0, 0.0, a), add_object(&mut problem, "y", 1.0, 0.0, b));
    add_pair(&mut problem, 0, x, a, b);
    add_pair(&mut problem, 0, y, b, a);
    let certificate = Certificate::Cycle {
        exclusions: vec![exclusion("B", cover("y", None), cover("x", Some("g1.1")))],
        cycles: vec![vec![
            arc(("g1.1", Point::Release), ("g1.2", Point::Grasp), CycleOrigin::Robot),
            arc(("g1.2", Point::Grasp), ("g1.1", Point::Release), EXCLUDED),
        ]],
    };
    (problem, certificate)
}

/// Two objects pass through a place for one; whichever goes first, another given order is in the way.
fn neither_way() -> (Problem, Certificate) {
    let mut problem = robots(2);
    let (a, b) = (add_table(&mut problem, "A", -1.0, 0.0), add_table(&mut problem, "B", 1.0, 0.0));
    let tiny = add_table(&mut problem, "tiny", 0.0, 0.0);
    problem.regions[tiny.index()].size = ONE_SLOT;
    let x = add_object(&mut problem, "x", -1.05, 0.0, a);
    let y = add_object(&mut problem, "y", -0.95, 0.05, a);
    let bring_x = add_pair(&mut problem, 0, x, a, tiny);
    let clear_x = add_pair(&mut problem, 0, x, tiny, b);
    let bring_y = add_pair(&mut problem, 1, y, a, tiny);
    let clear_y = add_pair(&mut problem, 1, y, tiny, b);
    problem.orderings = vec![
        GivenOrdering { before: (bring_y, Point::Release), after: (clear_x, Point::Start) },
        GivenOrdering { before: (bring_x, Point::Release), after: (clear_y, Point::AtPick) },
    ];
    let certificate = Certificate::Cycle {
        exclusions: vec![exclusion("tiny", cover("x", Some("g1.1")), cover("y", Some("g2.1")))],
        cycles: vec![
            vec![
                arc(("g1.2", Point::Grasp), ("g2.1", Point::Release), EXCLUDED),
                arc(("g2.1", Point::Release), ("g1.2", Point::Start), CycleOrigin::Given),
                arc(("g1.2", Point::Start), ("g1.2", Point::Grasp), CycleOrigin::Robot),
            ],
            vec![
                arc(("g2.2", Point::Grasp), ("g1.1", Point::Release), EXCLUDED),
                arc(("g1.1", Point::Release), ("g2.2", Point::AtPick), CycleOrigin::Given),
                arc(("g2.2", Point::AtPick), ("g2.2", Point::Grasp), CycleOrigin::Robot),
            ],
        ],
    };
    (problem, certificate)
}

fn cycles(certificate: &mut Certificate) -> (&mut Vec<Exclusion>, &mut Vec<Vec<CycleArc>>) {
    match certificate {
        Certificate::Cycle { exclusions, cycles } => (exclusions, cycles),
        other => panic!("another kind: {other:?}"),
    }
}

#[test]
fn cycles_that_hold_are_accepted() {
    for (problem, certificate) in [contradiction(), swap(), neither_way()] {
        proven(&problem, &certificate);
    }
}

#[test]
fn cycles_of_the_wrong_arcs_are_refused() {
    let (problem, certificate) = contradiction();
    let change = |why: &str, change: fn(&mut Vec<CycleArc>)| {
        corrupt(&problem, &certificate, why, |certificate| change(&mut cycles(certificate).1[0]));
    };
    change("need not come before", |arcs| arcs[0].origin = CycleOrigin::Object);
    change("need not come before", |arcs| arcs[0].origin = CycleOrigin::Robot);
    change("need not come before", |arcs| arcs[1].origin = CycleOrigin::Given);
    change("need not come before", |arcs| arcs[1].origin = CycleOrigin::Excluded { exclusion: 1 });
    change("not joined", |arcs| arcs[1].after.point = Point::Done);
    change("not joined", |arcs| arcs.truncate(1));
    change("no arcs", Vec::clear);
    change("no pair", |arcs| {
        arcs[0].after.pair = "g3.1".to_owned();
        arcs[1].before.pair = "g3.1".to_owned();
    });
    // The other way round would need the old object to come after the new one has left.
    change("need not come before", |arcs| {
        arcs.swap(0, 1);
        for arc in arcs {
            std::mem::swap(&mut arc.before, &mut arc.after);
        }
    });
    elsewhere(&problem, &certificate, "need not come before", |problem| problem.orderings.clear());
    corrupt(&problem, &certificate, "none of the cycles", |certificate| cycles(certificate).1.clear());
}

#[test]
fn exclusions_that_are_none_are_refused() {
    let (problem, certificate) = contradiction();
    let change = |why: &str, change: fn(&mut Exclusion)| {
        corrupt(&problem, &certificate, why, |certificate| change(&mut cycles(certificate).0[0]));
    };
    change("covers less", |exclusion| exclusion.stays[0].area_m2 *= 1.01);
    change("covers less", |exclusion| exclusion.stays[1].area_m2 *= 1.01);
    change("m² within its margin", |exclusion| exclusion.region_area_m2 *= 0.99);
    change("no more than", |exclusion| exclusion.region_area_m2 *= 2.0);
    change("no more than", |exclusion| exclusion.stays[1].area_m2 /= 3.0);
    change("m² within its margin", |exclusion| exclusion.region = "A".to_owned());
    change("two stays of one object", |exclusion| exclusion.stays[1].stay = exclusion.stays[0].stay.clone());
    change("does not bring", |exclusion| exclusion.stays[0].stay.placed_by = Some("g2.1".to_owned()));
    elsewhere(&problem, &certificate, "m² within its margin", |problem| problem.regions[2].size = [0.12, 0.06]);
    // The old object stands beside the place, partly or wholly.
    for (x, size) in [(0.03, [0.08, 0.06]), (0.2, [0.08, 0.06])] {
        elsewhere(&problem, &certificate, "covers less", |problem| {
            problem.movable[1].world_from_start.translation.x += x;
            problem.regions[2].size = size;
        });
    }
    // The old object hangs above the place.
    elsewhere(&problem, &certificate, "no height in common", |problem| {
        problem.movable[1].world_from_start.translation.z += OBJECT[2];
    });
    elsewhere(&problem, &certificate, "covers less", |problem| {
        problem.movable[0].body.shape = Shape::Sphere { radius: 0.02 };
    });
}

#[test]
fn where_one_way_is_left_open_there_is_no_contradiction() {
    let (problem, certificate) = neither_way();
    for cycle in 0..2 {
        corrupt(&problem, &certificate, "none of the cycles", |certificate| {
            cycles(certificate).1.remove(cycle);
        });
    }
    // Two robots may swap what one cannot: both take before either gives.
    let (mut problem, certificate) = swap();
    problem.robots.push(gantry("g2", [0.0, 1.0, 0.75]));
    problem.pairs[1].robot = model::RobotId(1);
    refused(&problem, &certificate, "need not come before");
}

/// Three objects shall stay in a region for two.
fn crowd() -> (Problem, Certificate) {
    let mut problem = robots(3);
    let goal = add_table(&mut problem, "goal", 0.0, 0.0);
    problem.regions[goal.index()].size = [0.13, 0.06];
    let mut stays = Vec::new();
    for (i, x) in [-1.0, 1.0, -1.6].into_iter().enumerate() {
        let from = add_table(&mut problem, &format!("from {i}"), x, 0.0);
        let object = add_object(&mut problem, &format!("m{i}"), x, 0.0, from);
        add_pair(&mut problem, i, object, from, goal);
        stays.push(cover(&format!("m{i}"), Some(&format!("g{}.1", i + 1))));
    }
    let region_area_m2 = 0.12 * 0.05;
    (problem, Certificate::Area { region: "goal".to_owned(), region_area_m2, stays, together: Vec::new() })
}

/// As [`crowd`], but the first object is taken away again, after the others have come.
fn passing_crowd() -> (Problem, Certificate) {
    let (mut problem, mut certificate) = crowd();
    let (from, goal) = (problem.pairs[0].from, problem.pairs[0].to);
    let clears = add_pair(&mut problem, 0, ObjectId(0), goal, from);
    problem.pairs.sort_by_key(|pair| pair.robot);
    let by_name = |name: &str| PairId::at(problem.pairs.iter().position(|pair| pair.name == name).expect("a pair"));
    assert_eq!(clears.index(), 3);
    let ordering =
        |name: &str| GivenOrdering { before: (by_name(name), Point::Release), after: (by_name("g1.2"), Point::AtPick) };
    problem.orderings = vec![ordering("g2.1"), ordering("g3.1")];
    let together = [2, 3].map(|i| [at(&format!("g{i}.1"), Point::Release), at("g1.2", Point::Grasp)]);
    if let Certificate::Area { together: known, .. } = &mut certificate {
        known.extend(together);
    }
    (problem, certificate)
}

#[test]
fn objects_that_are_together_larger_than_their_region_are_accepted_as_proof() {
    for (problem, certificate) in [crowd(), passing_crowd()] {
        proven(&problem, &certificate);
    }
    // What stands there from the start counts as far as it is within.
    let (mut problem, mut certificate) = crowd();
    let stays = problem.pairs.pop().expect("a pair").object;
    problem.movable[stays.index()].world_from_start.translation.x = 0.03;
    if let Certificate::Area { stays, .. } = &mut certificate {
        stays[2].stay.placed_by = None;
    }
    proven(&problem, &certificate);
    problem.movable[stays.index()].world_from_start.translation.x = 0.05;
    refused(&problem, &certificate, "covers less");
}

#[test]
fn crowds_that_are_none_are_refused() {
    type Change = fn((&mut String, &mut f64, &mut Vec<Cover>, &mut Vec<[PairPoint; 2]>));
    let (problem, certificate) = passing_crowd();
    let change = |why: &str, change: Change| {
        corrupt(&problem, &certificate, why, |certificate| {
            if let Certificate::Area { region, region_area_m2, stays, together } = certificate {
                change((region, region_area_m2, stays, together));
            }
        });
    };
    change("no more than", |(_, _, stays, _)| stays.truncate(2));
    change("covers less", |(_, _, stays, _)| stays.iter_mut().for_each(|stay| stay.area_m2 *= 1.1));
    change("m² within its margin", |(_, area, ..)| *area *= 0.9);
    change("m² within its margin", |(region, ..)| *region = "from 0".to_owned());
    change("no region", |(region, ..)| *region = "nowhere".to_owned());
    change("two stays of one object", |(_, _, stays, _)| {
        let first = stays[0].clone();
        stays.push(first);
    });
    change("may have left before", |(.., together)| together.truncate(1));
    change("does not follow", |(.., together)| together[0].swap(0, 1));
    elsewhere(&problem, &certificate, "does not follow", |problem| problem.orderings.truncate(1));
    elsewhere(&problem, &certificate, "m² within its margin", |problem| problem.regions[0].size = [0.16, 0.06]);
    elsewhere(&problem, &certificate, "no height in common", |problem| {
        problem.movable[1].body.shape = Shape::Box { size: [0.06, 0.04, 0.0015] };
    });
}

/// A plank for a place that is shorter than it, whichever way it lies.
pub fn too_large() -> (Problem, Certificate) {
    let mut problem = robots(1);
    let (a, b) = (add_table(&mut problem, "A", -1.0, 0.0), add_table(&mut problem, "B", 1.0, 0.0));
    let plank = add_object(&mut problem, "plank", -1.0, 0.0, a);
    problem.movable[plank.index()].body.shape = Shape::Box { size: [0.15, 0.004, 0.12] };
    problem.regions[b.index()].size = [0.11, 0.11];
    add_pair(&mut problem, 0, plank, a, b);
    (problem, Certificate::ObjectTooLarge { object: "plank".to_owned(), region: "B".to_owned() })
}

#[test]
fn an_object_that_fits_at_no_yaw_is_accepted_as_proof_and_one_that_fits_at_a_slant_is_not() {
    let (problem, certificate) = too_large();
    proven(&problem, &certificate);
    let shape = |size: [f64; 3]| move |problem: &mut Problem| problem.movable[0].body.shape = Shape::Box { size };
    // The diagonal within the margin is 0.1414 m.
    elsewhere(&problem, &certificate, "fits into B", shape([0.137, 0.004, 0.12]));
    elsewhere(&problem, &certificate, "fits into B", |problem| problem.regions[1].size = [0.16, 0.02]);
    elsewhere(&problem, &certificate, "not level", |problem| {
        let tilt = nalgebra::UnitQuaternion::from_axis_angle(&nalgebra::Vector3::x_axis(), 0.01);
        problem.regions[1].world_from_region.rotation = tilt;
    });
    corrupt(&problem, &certificate, "nobody brings", |certificate| {
        *certificate = Certificate::ObjectTooLarge { object: "plank".to_owned(), region: "A".to_owned() };
    });
    corrupt(&problem, &certificate, "no movable object", |certificate| {
        *certificate = Certificate::ObjectTooLarge { object: "table A".to_owned(), region: "B".to_owned() };
    });
    let mut round = problem.clone();
    round.movable[0].body.shape = Shape::Cylinder { radius: 0.0501, length: 0.1 };
    proven(&round, &certificate);
    round.movable[0].body.shape = Shape::Cylinder { radius: 0.0499, length: 0.1 };
    refused(&round, &certificate, "fits into B");
}

/// Two robots shall swap two objects between two places for one each.
fn swap_of_two() -> (Problem, Certificate) {
    let (mut problem, _) = swap();
    let [a, b] = [problem.pairs[0].from, problem.pairs[0].to];
    let mut of_two = robots(2);
    (of_two.regions, of_two.fixed) = (problem.regions.clone(), problem.fixed.clone());
    std::mem::swap(&mut of_two.movable, &mut problem.movable);
    let [x, y] = [0, 1].map(model::ObjectId::at);
    add_pair(&mut of_two, 0, x, a, b);
    add_pair(&mut of_two, 1, y, b, a);
    of_two.settings.removal = model::Removal::Completed;
    let certificate = Certificate::Cycle {
        exclusions: vec![
            exclusion("A", cover("x", None), cover("y", Some("g2.1"))),
            exclusion("B", cover("y", None), cover("x", Some("g1.1"))),
        ],
        cycles: vec![vec![
            arc(("g1.1", Point::Release), ("g2.1", Point::Release), EXCLUDED),
            arc(("g2.1", Point::Release), ("g1.1", Point::Release), CycleOrigin::Excluded { exclusion: 1 }),
        ]],
    };
    (of_two, certificate)
}

#[test]
fn two_robots_cannot_swap_where_removals_have_to_be_completed_and_can_where_not() {
    let (mut problem, certificate) = swap_of_two();
    proven(&problem, &certificate);
    problem.settings.removal = model::Removal::Grasp;
    refused(&problem, &certificate, "need not come before");
}

#[test]
fn gates_of_actions_are_arcs_of_cycles_only_where_the_problem_has_them() {
    let (mut problem, mut certificate) = contradiction();
    let [brings, clears] = [0, 1].map(model::PairId::at);
    problem.orderings = vec![GivenOrdering { before: (brings, Point::Release), after: (clears, Point::Carry) }];
    let gate = arc(("g1.1", Point::Done), ("g2.1", Point::Grasp), CycleOrigin::Given);
    let to_done = arc(("g1.1", Point::Release), ("g1.1", Point::Done), CycleOrigin::Robot);
    let excluded = arc(("g2.1", Point::Grasp), ("g1.1", Point::Release), EXCLUDED);
    cycles(&mut certificate).1[0] = vec![to_done, gate, excluded];
    refused(&problem, &certificate, "need not come before");
    problem.settings.gate = model::Gate::Action;
    proven(&problem, &certificate);
}
