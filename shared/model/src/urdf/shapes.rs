//! Collision bodies of a URDF's links.

use nalgebra::Vector3;
use roxmltree::Node;

use super::joints::pose;
use super::mesh::load_hull;
use super::tree::Tree;
use super::xml::{child, children, span};
use crate::problem_error::{FindingKind, Found, Source, Span};
use crate::{Body, Files, Link, Shape};

/// Least size of a body (m).
const LEAST_SIZE: f64 = 1.0e-6;

/// The links in the tree's order. Visual geometry is not read.
pub(crate) fn links(
    files: &dyn Files,
    source: &Source,
    tree: &Tree,
    nodes: &[Node<'_, '_>],
    read: &[urdf_rs::Link],
) -> Found<Vec<Link>> {
    let mut links = Vec::with_capacity(tree.links.len());
    for position in &tree.links {
        let (link, node) = (&read[*position], nodes[*position]);
        let mut bodies = Vec::with_capacity(link.collision.len());
        for (collision, at) in link.collision.iter().zip(children(node, "collision")) {
            // The innermost element: the primitive or mesh itself.
            let place = child(at, "geometry").and_then(|geometry| geometry.first_element_child()).unwrap_or(at);
            let shape = shape(files, source, &collision.geometry, span(source, place))?;
            bodies.push(Body { owner_from_shape: pose(&collision.origin), shape });
        }
        links.push(Link { name: link.name.trim().to_owned(), bodies });
    }
    Ok(links)
}

fn shape(files: &dyn Files, source: &Source, geometry: &urdf_rs::Geometry, span: Span) -> Found<Shape> {
    use urdf_rs::Geometry;
    let sizes: &[f64] = match geometry {
        Geometry::Box { size } => &size.0,
        Geometry::Cylinder { radius, length } => &[*radius, *length],
        Geometry::Capsule { radius, length } => &[*radius, *length],
        Geometry::Sphere { radius } => &[*radius],
        Geometry::Mesh { .. } => &[],
    };
    if let Some(size) = sizes.iter().find(|size| size.is_nan() || **size < LEAST_SIZE) {
        return Err(source
            .finding(span, FindingKind::BadRobot, format!("a collision body of size {size}"))
            .help("give sizes above zero, in metres"));
    }
    Ok(match geometry {
        Geometry::Box { size } => Shape::Box { size: size.0 },
        Geometry::Cylinder { radius, length } => Shape::Cylinder { radius: *radius, length: *length },
        Geometry::Capsule { radius, length } => Shape::Capsule { radius: *radius, length: *length },
        Geometry::Sphere { radius } => Shape::Sphere { radius: *radius },
        Geometry::Mesh { filename, scale } => {
            let scale = scale.map_or(Vector3::repeat(1.0), |scale| Vector3::from(scale.0));
            load_hull(files, source, span, filename, scale)?
        }
    })
}
