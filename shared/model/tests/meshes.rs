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
    let beyond = DAE.replace("0 1 2 0 1 3", "0 1 2 0 1 4000000000");
    let dangling = DAE.replace("id=\"a\"", "id=\"b\"");
    let far = stl(&[TETRAHEDRON[0], [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0e9]]]);
    let cases = [
        ("scenes/m.stl", flat.as_str(), "{file: m.stl}"),
        ("scenes/m.stl", far.as_str(), "{file: m.stl}"),
        ("scenes/m.stl", "solid", "{file: m.stl}"),
        ("scenes/m.dae", beyond.as_str(), "{file: m.dae}"),
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

/// A cube of edge 2 about its origin, in a scene of nodes, in some unit.
fn dae_cube(asset: &str, nodes: &str) -> String {
    let corner = |i: i32| [0, 1, 2].map(|bit| if i >> bit & 1 == 1 { "1" } else { "-1" }).join(" ");
    let positions = (0..8).map(corner).collect::<Vec<_>>().join(" ");
    format!(
        r##"<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset>{asset}</asset>
<library_geometries><geometry id="cube"><mesh>
<source id="unused"><float_array id="ua" count="3">900 900 900</float_array></source>
<source id="p"><float_array id="a" count="30">{positions} 7 7 7 8 8 8</float_array>
<technique_common><accessor source="#a" count="10" stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<polylist count="4"><input semantic="VERTEX" source="#v" offset="1"/><input semantic="NORMAL" source="#unused" offset="0"/>
<vcount>3 3 3 3</vcount><p>0 0 0 1 0 2 0 3 0 4 0 5 0 6 0 7 0 0 0 3 0 5 0 6</p></polylist>
</mesh></geometry></library_geometries>
<library_nodes><node id="shared"><translate>0 0 10</translate><instance_geometry url="#cube"/></node></library_nodes>
<library_visual_scenes><visual_scene id="s">{nodes}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"##
    )
}

/// Corners of boxes, given by centre and edge lengths.
fn corners_of(boxes: &[([f64; 3], [f64; 3])]) -> Vec<[f64; 3]> {
    let mut corners: Vec<[f64; 3]> = Vec::new();
    for (centre, size) in boxes {
        corners.extend((0..8).map(|i: usize| {
            [0, 1, 2].map(|axis| centre[axis] + if i >> axis & 1 == 1 { size[axis] / 2.0 } else { -size[axis] / 2.0 })
        }));
    }
    corners
}

#[test]
fn a_collada_scene_is_read_in_metres_with_its_nodes_transforms() {
    const CM: &str = "<unit name=\"centimeter\" meter=\"0.01\"/><up_axis>Y_UP</up_axis>";
    let plain = "<node><instance_geometry url=\"#cube\"/></node>";
    let nested = "<node><translate>100 0 0</translate><rotate>0 0 1 90</rotate><scale>1 2 3</scale>\
        <node><matrix>1 0 0 10  0 1 0 0  0 0 1 0  0 0 0 1</matrix><instance_geometry url=\"#cube\"/></node></node>";
    let twice = "<node><instance_geometry url=\"#cube\"/></node><node><instance_node url=\"#shared\"/></node>";
    let cases = [
        ("metres, no unit said", "", plain, [0.0; 3], [2.0; 3]),
        ("centimetres; the axes stay, whichever is said to be up", CM, plain, [0.0; 3], [0.02; 3]),
        // Scaled by 1, 2, 3 from (10, 0, 0), turned by a quarter about z, moved.
        ("nested transforms", CM, nested, [1.0, 0.1, 0.0], [0.04, 0.02, 0.06]),
        ("a shared node, and a geometry used twice", "", twice, [0.0, 0.0, 5.0], [2.0, 2.0, 12.0]),
    ];
    for (name, asset, nodes, centre, size) in cases {
        let text = dae_cube(asset, nodes);
        let problem = load_as_blob(("scenes/c.dae", text.as_bytes()), "{file: c.dae}").unwrap();
        let (found, expected) = (blob(&problem), corners_of(&[(centre, size)]));
        assert_eq!(found.len(), 8, "{name}: {found:?}");
        // Rounding may order equal coordinates otherwise.
        for corner in &expected {
            let near = |other: &&[f64; 3]| (0..3).all(|axis| (corner[axis] - other[axis]).abs() < 1e-7);
            assert!(found.iter().any(|other| near(&other)), "{name}: no {corner:?} in {found:?}");
        }
    }
}

#[test]
fn collada_scenes_without_end_are_refused() {
    let endless = dae_cube("", "<node id=\"me\"><instance_node url=\"#me\"/></node>");
    let mut doubling = String::new();
    for level in 0..40 {
        let next = format!("<instance_node url=\"#n{}\"/>", level + 1);
        doubling += &format!("<node id=\"n{level}\">{next}{next}</node>");
    }
    let doubling = dae_cube("", &(doubling + "<node id=\"n40\"><instance_geometry url=\"#cube\"/></node>"));
    for (text, told) in
        [(endless, "without end"), (doubling, "without end"), (dae_cube("<unit meter=\"0\"/>", ""), "unit")]
    {
        let error = load_as_blob(("scenes/c.dae", text.as_bytes()), "{file: c.dae}").map(|_| ()).unwrap_err();
        assert!(render(&error).contains(told), "{}", render(&error));
    }
}
