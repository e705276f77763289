//! The scenes that come with the program.

mod support;

use model::{DiskFiles, FixedId, ObjectId, Problem, load_problem};

fn scene(name: &str) -> miette::Result<Problem> {
    let path = format!("{}/../../launch/scenes/{name}.yaml", env!("CARGO_MANIFEST_DIR"));
    Ok(load_problem(&DiskFiles, &path)?)
}

#[test]
fn every_scene_loads() {
    let folder = format!("{}/../../launch/scenes", env!("CARGO_MANIFEST_DIR"));
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter_map(|name| name.strip_suffix(".yaml").map(str::to_owned))
        .collect();
    names.sort();
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
