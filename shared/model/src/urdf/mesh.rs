//! Meshes, which mean their convex hulls.

use std::io;

use nalgebra::{Point3, Vector3};

use super::collada;
use super::hull::{NoHull, extreme_points};
use super::xml::nested_too_deep;
use crate::locate::locate;
use crate::problem_error::{FindingKind, Found, Source, Span};
use crate::{Files, Shape};

/// Most points of a hull; every one of them costs time in every distance computation.
const MAX_HULL_POINTS: usize = 2_000;

/// The hull of a mesh that `owner` names at `span`, within 0.1 mm.
///
/// `reference` is found as [`locate`] does. `scale` multiplies the mesh's coordinates, which are metres but in a DAE
/// file that gives another unit.
pub(crate) fn load_hull(
    files: &dyn Files,
    owner: &Source,
    span: Span,
    reference: &str,
    scale: Vector3<f64>,
) -> Found<Shape> {
    let bad = |message: String| owner.finding(span, FindingKind::BadRobot, message);
    let (path, bytes) = locate(files, owner, span, "mesh", reference)?;
    let vertices = read_vertices(&path, &bytes).map_err(|why| {
        bad(format!("mesh {path}: {why}")).help("use an STL, OBJ or COLLADA (.dae) file that a viewer can open")
    })?;
    let mut points = Vec::new();
    for vertex in vertices {
        let point = Point3::from(vertex.coords.component_mul(&scale));
        if !point.iter().all(|x| x.abs() <= crate::file::GREATEST) {
            return Err(bad(format!("mesh {path} has a vertex at {point}"))
                .help("coordinates must be finite; if the mesh is in millimetres give a `scale` of 0.001"));
        }
        points.push(point);
    }
    let hull = extreme_points(&points, MAX_HULL_POINTS).map_err(|no_hull| match no_hull {
        NoHull::Flat => bad(format!("mesh {path} encloses no volume"))
            .help("a mesh means its convex hull; a flat one needs a box of some thickness instead"),
        NoHull::TooMany => bad(format!("the convex hull of mesh {path} has more than {MAX_HULL_POINTS} corners"))
            .help("simplify the mesh; a collision mesh needs a few hundred corners at most"),
    })?;
    Ok(Shape::Hull { points: hull })
}

/// Vertices of a mesh file, whatever its bytes.
fn read_vertices(path: &str, bytes: &[u8]) -> Result<Vec<Point3<f64>>, String> {
    if path.to_lowercase().ends_with(".dae") || bytes.windows(8).any(|window| window == b"<COLLADA") {
        if nested_too_deep(bytes).is_some() {
            return Err("its elements are nested too deep".to_owned());
        }
        return collada::vertices(bytes);
    }
    let read = || {
        // Materials are beside the point: their files are not looked for.
        let no_materials = |_: &std::path::Path| -> io::Result<Vec<u8>> { Ok(Vec::new()) };
        mesh_loader::Loader::default().load_from_slice_with_reader(bytes, path, no_materials)
    };
    // The readers are others' and files are anybody's: none may end the program.
    match std::panic::catch_unwind(read) {
        Ok(Ok(scene)) => {
            let vertices = scene.meshes.into_iter().flat_map(|mesh| mesh.vertices);
            Ok(vertices.map(|vertex| Point3::from(vertex.map(f64::from))).collect())
        }
        Ok(Err(error)) => Err(error.to_string().replace("{path:?}", "").trim_end().to_owned()),
        Err(_) => Err("a reference in it leads nowhere".to_owned()),
    }
}
