//! Meshes mean their convex hulls, wherever they lie.

mod support;

use model::{Problem, ProblemError, Shape, load_problem};
use support::{MemoryFiles, PROBLEM, URDF, good, render};

/// A cube of edge 2 with its centre at the origin, every corner repeated as triangles repeat them.
fn cube_obj() -> String {
    let mut text = String::from("o cube\n");
    for i in 0..8 {
        let side = |bit: i32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        text += &format!("v {} {} {}\n", side(0), side(1), side(2));
    }
    text += "v 0 0 0\nf 1 2 4 3\nf 5 6 8 7\nf 1 2 6 5\nf 3 4 8 7\nf 1 3 7 5\nf 2 4 8 6\nf 1 8 9\n";
    text
}

fn stl(triangles: &[[[f64; 3]; 3]]) -> String {
    let mut text = String::from("solid s\n");
    for triangle in triangles {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in triangle {
            text += &format!("vertex {x} {y} {z}\n");
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid s\n"
}

const TETRAHEDRON: [[[f64; 3]; 3]; 2] =
    [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]];

const DAE: &str = r##"<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="12">0 0 0 1 0 0 0 1 0 0 0 1</float_array>
<technique_common><accessor source="#a" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="2"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2 0 1 3</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"##;

/// The good problem with a mesh file and one change.
fn load(mesh: (&str, &str), path: &str, old: &str, new: &str) -> Result<Problem, ProblemError> {
    let MemoryFiles(mut files) = good();
    files.insert(mesh.0.to_owned(), mesh.1.as_bytes().to_vec());
    let text = String::from_utf8_lossy(&files[path]).replacen(old, new, 1);
    files.insert(path.to_owned(), text.into_bytes());
    load_problem(&MemoryFiles(files), PROBLEM)
}

/// The good problem with a mesh as the shape of one more fixed object.
fn load_as_blob(mesh: (&str, &str), shape: &str) -> Result<Problem, ProblemError> {
    load(
        mesh,
        PROBLEM,
        "movable:\n",
        &format!("  - {{name: blob, shape: {{mesh: {shape}}}, pose: {{xyz: [5, 5, 0]}}}}\nmovable:\n"),
    )
}

fn blob(problem: &Problem) -> Vec<[f64; 3]> {
    let body = &problem.fixed.last().map(|object| object.bodies[0].shape.clone());
    let Some(Shape::Hull { points }) = body else { return Vec::new() };
    let mut points: Vec<[f64; 3]> = points.iter().map(|p| [p.x, p.y, p.z]).collect();
    points.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    points
}

#[test]
fn an_obj_cube_becomes_its_eight_corners_and_is_scaled() {
    let problem = load_as_blob(("scenes/cube.obj", &cube_obj()), "{file: cube.obj, scale: [0.1, 0.2, 0.3]}").unwrap();
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
    let stl = load_as_blob(("scenes/t.stl", &stl(&TETRAHEDRON)), "{file: t.stl}").unwrap();
    assert_eq!(blob(&stl), tetrahedron);
    let dae = load_as_blob(("scenes/t.dae", DAE), "{file: t.dae}").unwrap();
    assert_eq!(blob(&dae), tetrahedron);
}

#[test]
fn package_meshes_are_found_beside_the_ancestors_of_the_urdf() {
    let cylinder = "<cylinder radius=\"0.3\" length=\"0.53\"/>";
    for place in ["robots/my_robot/meshes/base.obj", "my_robot/meshes/base.obj"] {
        let mesh = "<mesh filename=\"package://my_robot/meshes/base.obj\" scale=\"0.2 0.2 0.2\"/>";
        let problem = load((place, &cube_obj()), URDF, cylinder, mesh).unwrap();
        let root = &problem.robots[0].links[0];
        assert!(matches!(&root.bodies[0].shape, Shape::Hull { points } if points.len() == 8), "{place}");
    }
}

#[test]
fn a_package_may_be_the_folder_that_holds_the_urdf() {
    let mesh = "<mesh filename=\"package://robots/base.obj\" scale=\"0.2 0.2 0.2\"/>";
    let cylinder = "<cylinder radius=\"0.3\" length=\"0.53\"/>";
    assert!(load(("robots/base.obj", &cube_obj()), URDF, cylinder, mesh).is_ok());
}

#[test]
fn meshes_that_mean_no_hull_are_refused() {
    let flat = stl(&[TETRAHEDRON[0], TETRAHEDRON[0]]);
    let far = stl(&[TETRAHEDRON[0], [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0e9]]]);
    let cases = [
        ("scenes/m.stl", flat.as_str(), "{file: m.stl}"),
        ("scenes/m.stl", far.as_str(), "{file: m.stl}"),
        ("scenes/m.stl", "solid", "{file: m.stl}"),
        ("scenes/m.glb", "glTF", "{file: m.glb}"),
        ("scenes/m.obj", "v 0 0 0\nf 1 2 3\n", "{file: m.obj}"),
        ("scenes/m.obj", cube_obj().as_str(), "{file: n.obj}"),
        ("scenes/m.obj", cube_obj().as_str(), "{file: m.obj, scale: [1, 1, .nan]}"),
    ]
    .map(|(path, text, shape)| {
        let error = load_as_blob((path, text), shape).map(|_| ()).unwrap_err();
        assert!(error.findings().iter().all(|finding| finding.line().is_some()));
        render(&error)
    });
    insta::with_settings!({omit_expression => true}, { insta::assert_snapshot!(cases.join("\n\n")) });
}
