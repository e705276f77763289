//! Meshes mean their convex hulls, wherever they lie.

mod support;

use model::{Problem, Shape};
use support::meshes::{DAE, TETRAHEDRON, cube_obj, load, load_as_blob, stl};
use support::{URDF, render};

fn blob(problem: &Problem) -> Vec<[f64; 3]> {
    let body = &problem.fixed.last().map(|object| object.bodies[0].shape.clone());
    let Some(Shape::Hull { points }) = body else { return Vec::new() };
    let mut points: Vec<[f64; 3]> = points.iter().map(|p| [p.x, p.y, p.z]).collect();
    points.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    points
}

#[test]
fn an_obj_cube_becomes_its_eight_corners_and_is_scaled() {
    let problem =
        load_as_blob(("scenes/cube.obj", cube_obj().as_bytes()), "{file: cube.obj, scale: [0.1, 0.2, 0.3]}").unwrap();
    let corners = blob(&problem);
    assert_eq!(corners.len(), 8);
    for (i, corner) in corners.iter().enumerate() {
        let side = |bit: usize| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        let expected = [0.1 * side(2), 0.2 * side(1), 0.3 * side(0)];
        assert!((0..3).all(|axis| (corner[axis] - expected[axis]).abs() < 1e-7), "{corner:?} {expected:?}");
    }
}

#[test]
fn stl_and_collada_files_are_read() {
    let tetrahedron = vec![[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
    let stl = load_as_blob(("scenes/t.stl", stl(&TETRAHEDRON).as_bytes()), "{file: t.stl}").unwrap();
    assert_eq!(blob(&stl), tetrahedron);
    let dae = load_as_blob(("scenes/t.dae", DAE.as_bytes()), "{file: t.dae}").unwrap();
    assert_eq!(blob(&dae), tetrahedron);
}

#[test]
fn package_meshes_are_found_beside_the_ancestors_of_the_urdf() {
    let cylinder = "<cylinder radius=\"0.3\" length=\"0.53\"/>";
    for place in ["robots/my_robot/meshes/base.obj", "my_robot/meshes/base.obj"] {
        let mesh = "<mesh filename=\"package://my_robot/meshes/base.obj\" scale=\"0.2 0.2 0.2\"/>";
        let problem = load((place, cube_obj().as_bytes()), URDF, cylinder, mesh).unwrap();
        let root = &problem.robots[0].links[0];
        assert!(matches!(&root.bodies[0].shape, Shape::Hull { points } if points.len() == 8), "{place}");
    }
}

#[test]
fn a_package_may_be_the_folder_that_holds_the_urdf() {
    let mesh = "<mesh filename=\"package://robots/base.obj\" scale=\"0.2 0.2 0.2\"/>";
    let cylinder = "<cylinder radius=\"0.3\" length=\"0.53\"/>";
    assert!(load(("robots/base.obj", cube_obj().as_bytes()), URDF, cylinder, mesh).is_ok());
}

#[test]
fn meshes_that_mean_no_hull_are_refused() {
    let flat = stl(&[TETRAHEDRON[0], TETRAHEDRON[0]]);
    let greedy = DAE.replace("count=\"12\"", "count = '4000000000'");
    let dangling = DAE.replace("id=\"a\"", "id=\"b\"");
    let far = stl(&[TETRAHEDRON[0], [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0e9]]]);
    let cases = [
        ("scenes/m.stl", flat.as_str(), "{file: m.stl}"),
        ("scenes/m.stl", far.as_str(), "{file: m.stl}"),
        ("scenes/m.stl", "solid", "{file: m.stl}"),
        ("scenes/m.dae", greedy.as_str(), "{file: m.dae}"),
        ("scenes/m.dae", dangling.as_str(), "{file: m.dae}"),
        ("scenes/m.glb", "glTF", "{file: m.glb}"),
        ("scenes/m.obj", "v 0 0 0\nf 1 2 3\n", "{file: m.obj}"),
        ("scenes/m.obj", cube_obj().as_str(), "{file: n.obj}"),
        ("scenes/m.obj", cube_obj().as_str(), "{file: m.obj, scale: [1, 1, .nan]}"),
    ]
    .map(|(path, text, shape)| {
        let error = load_as_blob((path, text.as_bytes()), shape).map(|_| ()).unwrap_err();
        assert!(error.findings().iter().all(|finding| finding.line().is_some()));
        render(&error)
    });
    insta::with_settings!({omit_expression => true}, { insta::assert_snapshot!(cases.join("\n\n")) });
}
