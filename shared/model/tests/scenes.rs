//! The scenes that come with the program.

mod support;

use model::{DiskFiles, FixedId, FixedObject, ObjectId, Pair, Problem, RegionId, RobotId, load_problem};
use nalgebra::Vector3;

fn scene(name: &str) -> miette::Result<Problem> {
    let path = format!("{}/../../launch/scenes/{name}.yaml", env!("CARGO_MANIFEST_DIR"));
    Ok(load_problem(&DiskFiles, &path)?)
}

/// The names of all scenes but the one whose robots are not part of this project; `tests/real_robots` has that.
fn names() -> Vec<String> {
    let folder = format!("{}/../../launch/scenes", env!("CARGO_MANIFEST_DIR"));
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .into_iter()
        .flatten()
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok()?.strip_suffix(".yaml").map(str::to_owned))
        .filter(|name| name != "two_real_arms")
        .collect();
    names.sort();
    names
}

#[test]
fn every_scene_loads() {
    let names = names();
    for name in &names {
        assert_eq!(&scene(name).unwrap().name, name);
    }
    assert!(names.len() >= 8, "{names:?}");
}

#[test]
fn figure_1_has_three_robots_four_objects_with_two_hops_each_and_sixteen_modes() {
    let problem = scene("figure1").unwrap();
    assert_eq!(problem.robots.len(), 3);
    assert_eq!(problem.pairs.len() * 2, 16);
    for object in (0..4).map(ObjectId::at) {
        let hops = problem.hops_of_object(object);
        let way: Vec<&str> = hops
            .iter()
            .flat_map(|pair| [problem.pair(*pair).from, problem.pair(*pair).to])
            .map(|region| problem.regions[region.index()].name.as_str())
            .collect();
        assert_eq!(way[1..], ["w3", "w3", "w4"]);
        assert_eq!(problem.pair(hops[0]).robot.index(), 0, "r1 carries every object first");
    }
    assert_eq!(problem.pairs[0].name, "r1.1");
    assert_eq!(problem.settings.grip_time, 0.0);
}

#[test]
fn objects_know_what_they_stand_on() {
    let problem = scene("figure1").unwrap();
    let supports: Vec<&str> = problem
        .movable
        .iter()
        .map(|object| object.start_support.map_or("", |FixedId(id)| problem.fixed[id as usize].name.as_str()))
        .collect();
    assert_eq!(supports, ["table_a", "table_a", "table_b", "table_b"]);
}

#[test]
fn the_cabinet_region_lies_on_its_floor_not_on_its_roof() {
    let problem = scene("figure1").unwrap();
    let w4 = problem.regions.iter().find(|region| region.name == "w4").unwrap();
    assert!((w4.world_from_region.translation.z - 0.6265).abs() < 1e-12);
}

#[test]
fn ten_thousand_objects_and_as_many_pairs_are_read() {
    let mut files = support::good();
    let mut text = String::from("robots:\n");
    for robot in 0..10 {
        text += &format!("  - {{name: r{robot}, urdf: ../robots/mm10.urdf, srdf: ../robots/mm10.srdf, tool: tool,\n");
        text += "     base: {x: [-9, 200], y: [-9, 200], speed: 1, yaw_rate: 1}}\n";
    }
    text += "fixed:\n  - {name: floor, shape: {box: [300, 300, 1]}, pose: {xyz: [0, 0, -0.5]}}\n";
    text += "regions:\n  - {name: hall, on: floor, size: [250, 250]}\nmovable:\n";
    for object in 0..10_000 {
        let (x, y) = (object / 100, object % 100);
        text += &format!("  - {{name: m{object}, shape: {{box: [0.1, 0.1, 0.1]}}, pose: {{xyz: [{x}, {y}, 0.05]}}}}\n");
    }
    text += "task:\n";
    for robot in 0..10 {
        text += &format!("  r{robot}:\n");
        for object in 0..1_000 {
            text += &format!("    - {{object: m{}, from: hall, to: hall}}\n", robot * 1_000 + object);
        }
    }
    files.0.insert(support::PROBLEM.to_owned(), text.into_bytes());
    let problem = load_problem(&files, support::PROBLEM).unwrap();
    assert_eq!((problem.movable.len(), problem.pairs.len()), (10_000, 10_000));
}

/// A necessary condition, from the robots' dimensions alone: for every pick and place there is a stand, clear of all fixed
/// objects, whose shoulder is neither too near nor too far from the wrist of some grasp.
#[test]
fn every_region_of_the_feasible_scenes_can_be_reached_from_a_free_stand() {
    let names = ["figure1", "figure1_slots", "t00_one_arm", "t01_one_robot", "t02_far_apart", "t03_relay"];
    for name in names.into_iter().chain(["t04_spacious_region", "t05_tiny_region"]) {
        let problem = scene(name).unwrap();
        for pair in &problem.pairs {
            for region in [pair.from, pair.to] {
                let stands = free_stands(&problem, pair.robot, region);
                let reached = stands.iter().filter(|stand| can_reach(&problem, pair, region, stand)).count();
                assert!(reached > 0, "{name}: {} cannot reach {}", pair.name, problem.regions[region.index()].name);
            }
        }
    }
}

/// Shoulders (world, m) of stands on a grid of 5 cm round a region's centre, within limits and clear of fixed objects.
fn free_stands(problem: &Problem, robot: RobotId, region: RegionId) -> Vec<Vector3<f64>> {
    const SHOULDER: f64 = 0.89;
    const DISC: f64 = 0.302;
    let robot = problem.robot(robot);
    if robot.base.is_none() {
        return vec![robot.world_from_base.translation.vector + Vector3::z() * SHOULDER];
    }
    let centre = problem.regions[region.index()].world_from_region.translation.vector;
    let grid = (-24..=24).flat_map(|i| (-24..=24).map(move |j| Vector3::new(f64::from(i), f64::from(j), 0.0) * 0.05));
    let limits = &robot.coordinates;
    grid.map(|offset| Vector3::new(centre.x + offset.x, centre.y + offset.y, SHOULDER))
        .filter(|at| {
            (limits[0].lower..=limits[0].upper).contains(&at.x) && (limits[1].lower..=limits[1].upper).contains(&at.y)
        })
        .filter(|at| problem.fixed.iter().all(|object| distance_to_footprint(object, at) >= DISC))
        .collect()
}

/// Horizontal distance to an upright, axis-aligned object of boxes that reaches below 0.55 m.
fn distance_to_footprint(object: &FixedObject, at: &Vector3<f64>) -> f64 {
    let to_body = |body: &model::Body| {
        let centre = (object.world_from_object * body.owner_from_shape).translation.vector;
        let (low, high) = body.shape.bounds();
        if centre.z + low.z > 0.55 {
            return f64::MAX;
        }
        let beyond = |axis: usize| ((at[axis] - centre[axis]).abs() - high[axis]).max(0.0);
        beyond(0).hypot(beyond(1))
    };
    object.bodies.iter().map(to_body).fold(f64::MAX, f64::min)
}

/// Whether some grasp of the object, standing in the middle of the region, has its wrist within the arm's length.
fn can_reach(problem: &Problem, pair: &Pair, region: RegionId, shoulder: &Vector3<f64>) -> bool {
    const ARM: f64 = 0.80;
    let object = &problem.movable[pair.object.index()];
    let mut standing = problem.regions[region.index()].world_from_region;
    standing.translation.z += object.origin_height();
    object.grasps[pair.robot.index()].iter().any(|grasp| {
        // The parent link's frame lies in the wrist.
        let wrist = (standing * grasp.link_from_object.inverse()).translation.vector;
        let approach = standing.rotation * grasp.link_from_object.rotation.inverse() * Vector3::from(grasp.approach);
        let ahead = approach.z < -0.5 || approach.xy().dot(&(wrist - shoulder).xy()) > 0.0;
        ahead && (0.45..=ARM - 0.01).contains(&(wrist - shoulder).norm())
    })
}
