//! Meshes in memory.

use model::{Problem, ProblemError, load_problem};

use super::{MemoryFiles, PROBLEM, good};

/// A cube of edge 2 with its centre at the origin, every corner repeated as triangles repeat them.
pub fn cube_obj() -> String {
    let mut text = String::from("o cube\n");
    for i in 0..8 {
        let side = |bit: i32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        text += &format!("v {} {} {}\n", side(0), side(1), side(2));
    }
    text += "v 0 0 0\nf 1 2 4 3\nf 5 6 8 7\nf 1 2 6 5\nf 3 4 8 7\nf 1 3 7 5\nf 2 4 8 6\nf 1 8 9\n";
    text
}

/// An STL file in text form.
pub fn stl(triangles: &[[[f64; 3]; 3]]) -> String {
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

/// Two triangles that span a tetrahedron.
pub const TETRAHEDRON: [[[f64; 3]; 3]; 2] =
    [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]];

/// The same as a COLLADA file.
pub const DAE: &str = r##"<?xml version="1.0"?>
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
pub fn load(mesh: (&str, &[u8]), path: &str, old: &str, new: &str) -> Result<Problem, ProblemError> {
    let MemoryFiles(mut files) = good();
    files.insert(mesh.0.to_owned(), mesh.1.to_vec());
    let text = String::from_utf8_lossy(&files[path]).replacen(old, new, 1);
    files.insert(path.to_owned(), text.into_bytes());
    load_problem(&MemoryFiles(files), PROBLEM)
}

/// The good problem with a mesh as the shape of one more fixed object.
pub fn load_as_blob(mesh: (&str, &[u8]), shape: &str) -> Result<Problem, ProblemError> {
    load(
        mesh,
        PROBLEM,
        "movable:\n",
        &format!("  - {{name: blob, shape: {{mesh: {shape}}}, pose: {{xyz: [5, 5, 0]}}}}\nmovable:\n"),
    )
}
