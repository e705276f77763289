//! Meshes of the robots become their convex hulls.

use std::path::Path;
use std::time::Instant;

use model::{DiskFiles, PackageFiles, Robot, Shape, load_robot};
use nalgebra::{Point3, Vector3};

use crate::{launch_folder, package, panda, panda_urdf, ur5, ur5_urdf};

/// Vertices of a binary STL file.
fn stl_vertices(path: &Path) -> Vec<Point3<f64>> {
    let bytes = std::fs::read(path).unwrap();
    let count = u32::from_le_bytes(bytes[80..84].try_into().unwrap()) as usize;
    let number = |at: usize| f64::from(f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()));
    let corner = |i: usize| 84 + 50 * (i / 3) + 12 + 12 * (i % 3);
    (0..3 * count).map(|i| [0, 4, 8].map(|axis| number(corner(i) + axis)).into()).collect()
}

/// Points of the only body of a link.
fn hull<'a>(robot: &'a Robot, link: &str) -> &'a [Point3<f64>] {
    let link = robot.links.iter().find(|known| known.name == link).unwrap();
    match &link.bodies[..] {
        [body] => match &body.shape {
            Shape::Hull { points } => points,
            other => panic!("{} is {other:?}", link.name),
        },
        others => panic!("{} has {} bodies", link.name, others.len()),
    }
}

fn directions() -> impl Iterator<Item = Vector3<f64>> {
    // Fibonacci's sphere.
    (0..2_000).map(|i| {
        let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / 2_000.0;
        let turn = f64::from(i) * 2.399_963_229_728_653;
        let radius = (1.0 - z * z).sqrt();
        Vector3::new(radius * turn.cos(), radius * turn.sin(), z)
    })
}

fn reach(points: &[Point3<f64>], direction: &Vector3<f64>) -> f64 {
    points.iter().map(|p| p.coords.dot(direction)).fold(f64::MIN, f64::max)
}

fn meshes() -> Vec<(Robot, &'static str, std::path::PathBuf)> {
    let mut meshes = Vec::new();
    for i in 0..8 {
        let link = [
            "panda_link0",
            "panda_link1",
            "panda_link2",
            "panda_link3",
            "panda_link4",
            "panda_link5",
            "panda_link6",
            "panda_link7",
        ][i];
        let file = format!("robots/panda_description/meshes/collision/link{i}.stl");
        meshes.push((panda(), link, package().join(file)));
    }
    meshes.push((panda(), "panda_hand", package().join("robots/panda_description/meshes/collision/hand.stl")));
    let of_ur5 = [
        ("base_link", "base"),
        ("shoulder_link", "shoulder"),
        ("upper_arm_link", "upperarm"),
        ("forearm_link", "forearm"),
        ("wrist_1_link", "wrist1"),
        ("wrist_2_link", "wrist2"),
        ("wrist_3_link", "wrist3"),
    ];
    for (link, file) in of_ur5 {
        meshes.push((ur5(), link, package().join(format!("robots/ur_description/meshes/ur5/collision/{file}.stl"))));
    }
    meshes
}

#[test]
fn every_hull_reaches_as_far_as_its_mesh_in_all_directions_within_a_tenth_of_a_millimetre() {
    for (robot, link, file) in meshes() {
        let (all, corners) = (stl_vertices(&file), hull(&robot, link));
        println!("{link}: {} corners of {} triangles", corners.len(), all.len() / 3);
        assert!(corners.len() <= 250 && corners.len() * 4 < all.len(), "{link} has {} corners", corners.len());
        for direction in directions() {
            let missing = reach(&all, &direction) - reach(corners, &direction);
            assert!((-1e-6..1.1e-4).contains(&missing), "{link} along {direction}: {missing} m");
        }
    }
}

#[test]
fn a_robot_is_loaded_in_a_fraction_of_a_second() {
    for (name, load) in [("panda", panda as fn() -> Robot), ("ur5", ur5)] {
        let started = Instant::now();
        load();
        let elapsed = started.elapsed();
        println!("{name} is loaded in {:.1} ms", elapsed.as_secs_f64() * 1e3);
        assert!(elapsed.as_secs_f64() < 0.5, "{name}: {elapsed:?}");
    }
}

/// The makers' pictures of the links, COLLADA files with nested transforms, are about as large as the collision meshes.
#[test]
fn collada_meshes_of_the_same_links_have_about_the_same_hulls() {
    let folder = tempfile::tempdir().unwrap();
    let files = PackageFiles {
        packages: vec![("example-robot-data".to_owned(), package().to_string_lossy().into_owned())],
        search: Vec::new(),
    };
    for (urdf, srdf, links) in [
        (panda_urdf(), "panda.srdf", &["panda_link1", "panda_link4", "panda_hand"][..]),
        (ur5_urdf(), "ur5.srdf", &["upper_arm_link", "forearm_link", "wrist_1_link"][..]),
    ] {
        let srdf = launch_folder().join("robots").join(srdf);
        let load = |urdf: &Path| load_robot(&files, &urdf.to_string_lossy(), &srdf.to_string_lossy()).unwrap();
        let pictured = folder.path().join("pictured.urdf");
        let text = std::fs::read_to_string(&urdf).unwrap();
        std::fs::write(&pictured, text.replace("/collision/", "/visual/").replace(".stl", ".dae")).unwrap();
        let (drawn, collided) = (load(&pictured), load(&urdf));
        for link in links {
            for direction in [Vector3::x(), Vector3::y(), Vector3::z()].iter().flat_map(|axis| [*axis, -axis]) {
                let difference = reach(hull(&drawn, link), &direction) - reach(hull(&collided, link), &direction);
                assert!(difference.abs() < 0.01, "{link} along {direction}: {difference} m");
            }
        }
    }
}

#[test]
fn a_urdf_away_from_its_package_needs_to_be_told_where_it_lies() {
    let folder = tempfile::tempdir().unwrap();
    let urdf = folder.path().join("panda.urdf");
    std::fs::copy(panda_urdf(), &urdf).unwrap();
    let srdf = launch_folder().join("robots/panda.srdf").to_string_lossy().into_owned();
    let urdf = urdf.to_string_lossy().into_owned();
    let error = load_robot(&DiskFiles, &urdf, &srdf).unwrap_err();
    assert!(error.to_string().contains("no mesh package://example-robot-data"), "{error}");
    let parent = package().parent().unwrap().to_string_lossy().into_owned();
    let by_search = PackageFiles { packages: Vec::new(), search: vec![parent] };
    assert_eq!(load_robot(&by_search, &urdf, &srdf).unwrap(), panda());
}
