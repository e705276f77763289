//! Vertices of a COLLADA scene in metres: nodes' transforms and the file's unit applied.
//!
//! `<up_axis>` is not: URDF tools take a mesh's axes as its link's whatever it says, as RViz does.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use nalgebra::{Matrix4, Point3, Rotation3, Unit, Vector3};
use roxmltree::{Document, Node, ParsingOptions};

use super::xml::{child, children};

/// Most nodes of one document.
const MAX_NODES: u32 = 4_000_000;
/// Deepest nesting of instances of nodes within each other.
const MAX_DEPTH: usize = 64;
/// Most vertices of a scene, every instance counted.
const MAX_VERTICES: usize = 4_000_000;
/// Most nodes that are visited.
const MAX_VISITS: usize = 100_000;

/// The vertices that a file's scene uses (m); of a file without a scene, those of all its geometries.
///
/// # Errors
/// A sentence.
pub(super) fn vertices(bytes: &[u8]) -> Result<Vec<Point3<f64>>, String> {
    let text = std::str::from_utf8(bytes).map_err(|error| error.to_string())?;
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text.trim_start_matches('\u{FEFF}'), options)
        .map_err(|error| format!("not XML: {error}"))?;
    let root = document.root_element();
    let by_id = document.descendants().filter_map(|node| Some((node.attribute("id")?, node))).collect();
    let mut scene = Scene { by_id, geometries: BTreeMap::new(), vertices: Vec::new(), visits: 0 };
    let metres = Matrix4::new_scaling(unit(root)?);
    let shown = child(root, "scene").and_then(|scene| child(scene, "instance_visual_scene"));
    match shown {
        Some(instance) => scene.children_of(scene.target(instance, "visual_scene")?, metres, 0)?,
        None => {
            for geometry in document.descendants().filter(|node| node.has_tag_name_of("geometry")) {
                scene.geometry(geometry, &metres)?;
            }
        }
    }
    Ok(scene.vertices)
}

/// Metres in the file's unit.
fn unit(root: Node<'_, '_>) -> Result<f64, String> {
    let unit = child(root, "asset").and_then(|asset| child(asset, "unit")).and_then(|unit| unit.attribute("meter"));
    let Some(text) = unit else { return Ok(1.0) };
    match text.trim().parse::<f64>() {
        Ok(metres) if metres.is_finite() && metres > 0.0 => Ok(metres),
        _ => Err(format!("its unit is {text:?} metres")),
    }
}

/// Compares local names: files differ in whether they declare the namespace.
trait LocalName {
    fn has_tag_name_of(&self, name: &str) -> bool;
}

impl LocalName for Node<'_, '_> {
    fn has_tag_name_of(&self, name: &str) -> bool {
        self.is_element() && self.tag_name().name() == name
    }
}

struct Scene<'a, 'i> {
    by_id: BTreeMap<&'a str, Node<'a, 'i>>,
    /// Vertices of the geometries met so far, by where they stand in the file.
    geometries: BTreeMap<usize, Vec<Point3<f64>>>,
    vertices: Vec<Point3<f64>>,
    visits: usize,
}

impl<'a, 'i: 'a> Scene<'a, 'i> {
    fn children_of(
        &mut self,
        parent: Node<'a, 'i>,
        world_from_parent: Matrix4<f64>,
        depth: usize,
    ) -> Result<(), String> {
        for node in parent.children().filter(|child| child.has_tag_name_of("node")) {
            self.node(node, world_from_parent, depth + 1)?;
        }
        Ok(())
    }

    fn node(&mut self, node: Node<'a, 'i>, world_from_parent: Matrix4<f64>, depth: usize) -> Result<(), String> {
        self.visits += 1;
        if depth > MAX_DEPTH || self.visits > MAX_VISITS {
            return Err("its nodes are nested too deep, or without end".to_owned());
        }
        let world_from_node = world_from_parent * transform(node)?;
        for entry in node.children().filter(Node::is_element) {
            match entry.tag_name().name() {
                "instance_geometry" => self.geometry(self.target(entry, "geometry")?, &world_from_node)?,
                "instance_controller" => {
                    let controller = self.target(entry, "controller")?;
                    let skin = child(controller, "skin").or_else(|| child(controller, "morph"));
                    let skin = skin.ok_or("a controller has neither skin nor morph")?;
                    self.geometry(self.linked(skin, "source", "geometry")?, &world_from_node)?;
                }
                "instance_node" => self.node(self.target(entry, "node")?, world_from_node, depth + 1)?,
                _ => {}
            }
        }
        self.children_of(node, world_from_node, depth)
    }

    fn geometry(&mut self, geometry: Node<'a, 'i>, world_from_geometry: &Matrix4<f64>) -> Result<(), String> {
        let at = geometry.range().start;
        if !self.geometries.contains_key(&at) {
            let own = self.own_vertices(geometry)?;
            self.geometries.insert(at, own);
        }
        let own = self.geometries.get(&at).map_or(&[][..], Vec::as_slice);
        if own.len() > MAX_VERTICES - self.vertices.len() {
            return Err(format!("it has more than {MAX_VERTICES} vertices"));
        }
        self.vertices.extend(own.iter().map(|point| world_from_geometry.transform_point(point)));
        Ok(())
    }

    /// The vertices that a geometry's primitives use, in its own frame and unit.
    fn own_vertices(&self, geometry: Node<'a, 'i>) -> Result<Vec<Point3<f64>>, String> {
        let Some(mesh) = child(geometry, "mesh") else { return Ok(Vec::new()) };
        let (mut positions, mut used) = (BTreeMap::new(), BTreeMap::new());
        for primitive in mesh.children().filter(Node::is_element) {
            let inputs: Vec<_> = children(primitive, "input").collect();
            let named = |input: &&Node<'_, '_>| input.attribute("semantic") == Some("VERTEX");
            let Some(vertex) = inputs.iter().find(named) else { continue };
            let offset = |input: &Node<'_, '_>| input.attribute("offset").and_then(|text| text.trim().parse().ok());
            let stride = inputs.iter().filter_map(offset).max().unwrap_or(0_usize).saturating_add(1);
            let first = offset(vertex).unwrap_or(0);
            let vertices = self.target_of(vertex, "source", "vertices")?;
            let at = vertices.range().start;
            if let Entry::Vacant(entry) = positions.entry(at) {
                entry.insert(self.positions(vertices)?);
            }
            for indices in primitive.descendants().filter(|node| node.has_tag_name_of("p")) {
                for index in words(indices).skip(first).step_by(stride) {
                    let index: usize = index.parse().map_err(|_| format!("{index:?} where an index is expected"))?;
                    let point = positions.get(&at).and_then(|points| points.get(index));
                    used.insert((at, index), *point.ok_or_else(|| format!("there is no vertex {index}"))?);
                }
            }
        }
        Ok(used.into_values().collect())
    }

    fn positions(&self, vertices: Node<'a, 'i>) -> Result<Vec<Point3<f64>>, String> {
        let named = |input: &Node<'_, '_>| input.attribute("semantic") == Some("POSITION");
        let input = children(vertices, "input").find(named).ok_or("its vertices have no positions")?;
        let source = self.linked(input, "source", "source")?;
        let accessor = child(source, "technique_common").and_then(|technique| child(technique, "accessor"));
        let (array, number) = match accessor {
            Some(accessor) => {
                let number = |name: &str, default: usize| {
                    accessor
                        .attribute(name)
                        .map_or(Ok(default), |text| text.trim().parse())
                        .map_err(|_| name.to_owned())
                };
                let three = (number("offset", 0)?, number("stride", 1)?.max(3));
                (self.linked(accessor, "source", "float_array")?, three)
            }
            None => (child(source, "float_array").ok_or("its positions have no numbers")?, (0, 3)),
        };
        let (offset, stride) = number;
        let values = numbers(array)?;
        let points = values.get(offset..).unwrap_or_default().chunks(stride).filter(|chunk| chunk.len() >= 3);
        Ok(points.map(|chunk| Point3::new(chunk[0], chunk[1], chunk[2])).collect())
    }

    /// The element that `node` names by its `url`.
    fn target(&self, node: Node<'a, 'i>, tag: &str) -> Result<Node<'a, 'i>, String> {
        self.linked(node, "url", tag)
    }

    fn linked(&self, node: Node<'a, 'i>, attribute: &str, tag: &str) -> Result<Node<'a, 'i>, String> {
        self.target_of(&node, attribute, tag)
    }

    fn target_of(&self, node: &Node<'a, 'i>, attribute: &str, tag: &str) -> Result<Node<'a, 'i>, String> {
        let link = node.attribute(attribute).unwrap_or_default().trim();
        let found = link.strip_prefix('#').and_then(|id| self.by_id.get(id)).filter(|found| found.has_tag_name_of(tag));
        found.copied().ok_or_else(|| format!("a reference in it leads nowhere: no {tag} {link:?}"))
    }
}

/// Takes a node's frame to its parent's: its transforms, the first the outermost.
fn transform(node: Node<'_, '_>) -> Result<Matrix4<f64>, String> {
    let mut parent_from_node = Matrix4::identity();
    for step in node.children().filter(Node::is_element) {
        let tag = step.tag_name().name();
        let exactly = |count: usize| {
            let values = numbers(step)?;
            if values.len() == count { Ok(values) } else { Err(format!("`<{tag}>` has {} numbers", values.len())) }
        };
        parent_from_node *= match tag {
            "matrix" => Matrix4::from_row_slice(&exactly(16)?),
            "translate" => Matrix4::new_translation(&Vector3::from_row_slice(&exactly(3)?)),
            "scale" => Matrix4::new_nonuniform_scaling(&Vector3::from_row_slice(&exactly(3)?)),
            "rotate" => {
                let values = exactly(4)?;
                let axis = Unit::try_new(Vector3::new(values[0], values[1], values[2]), 1e-12);
                let axis = axis.ok_or("`<rotate>` has no axis")?;
                Rotation3::from_axis_angle(&axis, values[3].to_radians()).to_homogeneous()
            }
            "lookat" | "skew" => return Err(format!("`<{tag}>` is not read")),
            _ => continue,
        };
    }
    Ok(parent_from_node)
}

fn numbers(node: Node<'_, '_>) -> Result<Vec<f64>, String> {
    words(node).map(|word| word.parse().map_err(|_| format!("{word:?} where a number is expected"))).collect()
}

fn words<'a>(node: Node<'a, '_>) -> impl Iterator<Item = &'a str> {
    node.text().unwrap_or_default().split_ascii_whitespace()
}
