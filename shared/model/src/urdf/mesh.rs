//! Meshes, which mean their convex hulls.

use std::io;

use nalgebra::{Point3, Vector3};

use super::hull::{NoHull, extreme_points};
use super::xml::nested_too_deep;
use crate::locate::locate;
use crate::problem_error::{FindingKind, Found, Source, Span};
use crate::{Files, Shape};

/// Most points of a hull; every one of them costs time in every distance computation.
const MAX_HULL_POINTS: usize = 2_000;

/// The hull of a mesh that `owner` names at `span`, within 0.1 mm.
///
/// `reference` is found as [`locate`] does. `scale` multiplies the mesh's coordinates. DAE units and axes are not applied.
pub(crate) fn load_hull(
    files: &dyn Files,
    owner: &Source,
    span: Span,
    reference: &str,
    scale: Vector3<f64>,
) -> Found<Shape> {
    let bad = |message: String| owner.finding(span, FindingKind::BadRobot, message);
    let (path, bytes) = locate(files, owner, span, "mesh", reference)?;
    let meshes = read_meshes(&path, &bytes).map_err(|why| {
        bad(format!("mesh {path}: {why}")).help("use an STL, OBJ or COLLADA (.dae) file that a viewer can open")
    })?;
    let mut points = Vec::new();
    for vertex in meshes.iter().flat_map(|mesh| &mesh.vertices) {
        let point = Point3::from(Vector3::from(vertex.map(f64::from)).component_mul(&scale));
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

/// Reads a mesh file, whatever its bytes.
fn read_meshes(path: &str, bytes: &[u8]) -> Result<Vec<mesh_loader::Mesh>, String> {
    let read = || {
        // Materials are beside the point: their files are not looked for.
        let no_materials = |_: &std::path::Path| -> io::Result<Vec<u8>> { Ok(Vec::new()) };
        mesh_loader::Loader::default().load_from_slice_with_reader(bytes, path, no_materials)
    };
    if path.to_lowercase().ends_with(".dae") || bytes.windows(8).any(|window| window == b"<COLLADA") {
        if announces_too_much(bytes) {
            return Err("it announces more values than it has bytes".to_owned());
        }
        if nested_too_deep(bytes).is_some() {
            return Err("its elements are nested too deep".to_owned());
        }
    }
    // The COLLADA reader panics on references to nothing, such as a source without its array.
    match std::panic::catch_unwind(read) {
        Ok(Ok(scene)) => Ok(scene.meshes),
        Ok(Err(error)) => Err(error.to_string().replace("{path:?}", "").trim_end().to_owned()),
        Err(_) => Err("a reference in it leads nowhere".to_owned()),
    }
}

/// Whether a `count` attribute exceeds what the file can hold. The COLLADA reader reserves as much memory as it is told.
fn announces_too_much(bytes: &[u8]) -> bool {
    const KEY: &[u8] = b"count";
    let skip = |byte: &u8| byte.is_ascii_whitespace() || matches!(byte, b'=' | b'"' | b'\'');
    bytes.windows(KEY.len()).enumerate().filter(|(_, window)| *window == KEY).any(|(at, _)| {
        let digits =
            bytes[at + KEY.len()..].iter().skip_while(|byte| skip(byte)).take_while(|byte| byte.is_ascii_digit());
        let count =
            digits.fold(0_usize, |count, digit| count.saturating_mul(10).saturating_add(usize::from(digit - b'0')));
        count > bytes.len()
    })
}
