//! Animated binary glTF 2.0.
//!
//! The root node turns z-up to glTF's y-up. Below it stand the links of each robot as a tree of nodes with their joints'
//! motion, regions and fixed objects, and the movable objects with tracks in the world frame, so that nothing changes
//! its parent. All tracks share one animation.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_1_SQRT_2;

use model::{Body, ObjectId, Pose, RobotId, Shape};
use nalgebra::{Point3, UnitQuaternion};
use serde_json::{Value, json};

use super::glb_buffer::{Buffer, Use};
use super::mesh::Mesh;
use super::object_times;
use crate::palette;
use crate::playback::{Playback, sorted};

/// Greatest change of a coordinate between two keys (rad), so that the short way round is the planned one.
const GREATEST_TURN: f64 = std::f64::consts::FRAC_PI_2;
/// Change (m; of a unit quaternion) below which a node counts as still.
const STILL: f64 = 1e-7;

/// The plan as binary glTF.
///
/// # Errors
/// A number that JSON cannot hold.
pub fn glb(playback: &Playback, rate_hz: Option<f64>) -> Result<Vec<u8>, serde_json::Error> {
    let mut scene = Scene::default();
    scene.fixed(playback);
    for robot in playback.problem.robot_ids() {
        scene.robot(playback, robot);
    }
    for object in (0..playback.problem.movable.len()).map(ObjectId::at) {
        scene.object(playback, object, rate_hz.unwrap_or(super::CURVE_RATE_HZ));
    }
    scene.finish(&playback.plan.problem)
}

/// A glTF document under construction.
#[derive(Default)]
struct Scene {
    buffer: Buffer,
    nodes: Vec<Value>,
    /// Nodes directly below the root.
    top: Vec<usize>,
    meshes: Vec<Value>,
    materials: Vec<Value>,
    samplers: Vec<Value>,
    channels: Vec<Value>,
    /// Accessors (positions, normals, indices) of bodies already added.
    surfaces: BTreeMap<String, Option<[usize; 3]>>,
}

impl Scene {
    fn fixed(&mut self, playback: &Playback) {
        let material = self.material("fixed", palette::FIXED, 1.0);
        for object in &playback.problem.fixed {
            let mesh = self.mesh(&object.name, &object.bodies, &[material]);
            self.stand(&object.name, &object.world_from_object, mesh);
        }
        let material = self.material("region", palette::REGION, 0.35);
        for region in &playback.problem.regions {
            // A sheet just above the surface.
            let sheet = Shape::Box { size: [region.size[0], region.size[1], 0.001] };
            let body = Body { owner_from_shape: Pose::translation(0.0, 0.0, 0.002), shape: sheet };
            let mesh = self.mesh(&region.name, &[body], &[material]);
            self.stand(&region.name, &region.world_from_region, mesh);
        }
    }

    fn robot(&mut self, playback: &Playback, id: RobotId) {
        let robot = playback.problem.robot(id);
        let colour = palette::robot(id.index());
        let materials = [
            self.material(&robot.name, colour, 1.0),
            self.material(&format!("{} light", robot.name), palette::mix(colour, [255; 3], 0.35), 1.0),
        ];
        let times = key_times(playback, id);
        let poses: Vec<Vec<Pose>> = times.iter().map(|t| playback.link_poses(id, *t)).collect();
        let first = self.nodes.len();
        for (index, link) in robot.links.iter().enumerate() {
            let parent =
                robot.joints.iter().find(|joint| joint.child.index() == index).map(|joint| joint.parent.index());
            let local: Vec<Pose> = poses
                .iter()
                .map(|poses| parent.map_or(poses[index], |parent| poses[parent].inv_mul(&poses[index])))
                .collect();
            let mesh =
                self.mesh(&format!("{}/{}", robot.name, link.name), &link.bodies, &materials[index % 2..=index % 2]);
            let node = self.node(&format!("{}/{}", robot.name, link.name), &local[0], mesh);
            self.tracks(node, &times, &local, steps(playback, id, index));
            match parent {
                None => self.top.push(node),
                Some(parent) => self.adopt(first + parent, node),
            }
        }
    }

    fn object(&mut self, playback: &Playback, id: ObjectId, rate_hz: f64) {
        let object = &playback.problem.movable[id.index()];
        let material = self.material(&object.name, palette::OBJECT, 1.0);
        let mesh = self.mesh(&object.name, std::slice::from_ref(&object.body), &[material]);
        let times = object_times(playback, id, rate_hz);
        let poses: Vec<Pose> = times.iter().map(|t| playback.object_pose(id, *t)).collect();
        let node = self.node(&object.name, &poses[0], mesh);
        self.top.push(node);
        self.tracks(node, &times, &poses, false);
    }

    fn stand(&mut self, name: &str, pose: &Pose, mesh: Option<usize>) {
        let node = self.node(name, pose, mesh);
        self.top.push(node);
    }

    fn node(&mut self, name: &str, pose: &Pose, mesh: Option<usize>) -> usize {
        let mut node = json!({"name": name, "translation": translation(pose), "rotation": rotation(pose)});
        if let Some(mesh) = mesh {
            node["mesh"] = mesh.into();
        }
        self.nodes.push(node);
        self.nodes.len() - 1
    }

    fn adopt(&mut self, parent: usize, child: usize) {
        match self.nodes[parent]["children"].as_array_mut() {
            Some(children) => children.push(child.into()),
            None => self.nodes[parent]["children"] = json!([child]),
        }
    }

    fn material(&mut self, name: &str, rgb: [u8; 3], alpha: f64) -> usize {
        let [r, g, b] = rgb.map(palette::linear);
        let mut material = json!({
            "name": name,
            "pbrMetallicRoughness": {"baseColorFactor": [r, g, b, alpha], "metallicFactor": 0.0, "roughnessFactor": 0.7},
        });
        if alpha < 1.0 {
            material["alphaMode"] = "BLEND".into();
        }
        self.materials.push(material);
        self.materials.len() - 1
    }

    /// A mesh with a primitive for each body; `None` if nothing of it can be seen.
    fn mesh(&mut self, name: &str, bodies: &[Body], materials: &[usize]) -> Option<usize> {
        let mut primitives = Vec::new();
        for body in bodies {
            if let Some([positions, normals, indices]) = self.surface(body) {
                primitives.push(json!({
                    "attributes": {"POSITION": positions, "NORMAL": normals}, "indices": indices, "material": materials[0],
                }));
            }
        }
        if primitives.is_empty() {
            return None;
        }
        self.meshes.push(json!({"name": name, "primitives": primitives}));
        Some(self.meshes.len() - 1)
    }

    fn surface(&mut self, body: &Body) -> Option<[usize; 3]> {
        let key = format!("{body:?}");
        if let Some(known) = self.surfaces.get(&key) {
            return *known;
        }
        let mesh = Mesh::of_body(body);
        let added = (!mesh.indices.is_empty()).then(|| {
            let positions: Vec<[f32; 3]> = mesh.positions.iter().map(|p| [p.x, p.y, p.z].map(|x| x as f32)).collect();
            let normals: Vec<[f32; 3]> = mesh.normals.iter().map(|n| [n.x, n.y, n.z].map(|x| x as f32)).collect();
            [
                self.buffer.floats(&positions, Use::Vertices),
                self.buffer.floats(&normals, Use::Vertices),
                self.buffer.indices(&mesh.indices),
            ]
        });
        self.surfaces.insert(key, added);
        added
    }

    /// Tracks of what moves in a node's pose; `step`: held from key to key.
    fn tracks(&mut self, node: usize, times: &[f64], poses: &[Pose], step: bool) {
        let translations: Vec<[f32; 3]> = poses.iter().map(translation).collect();
        let mut turned: Vec<Pose> = poses.to_vec();
        for i in 1..turned.len() {
            // Of the two quaternions of a rotation the one nearer to the last.
            if turned[i - 1].rotation.coords.dot(&turned[i].rotation.coords) < 0.0 {
                turned[i].rotation = UnitQuaternion::new_unchecked(-turned[i].rotation.into_inner());
            }
        }
        let rotations: Vec<[f32; 4]> = turned.iter().map(rotation).collect();
        self.track(node, "translation", times, &translations, step);
        self.track(node, "rotation", times, &rotations, step);
    }

    fn track<const N: usize>(&mut self, node: usize, path: &str, times: &[f64], values: &[[f32; N]], step: bool) {
        let near = |a: &[f32; N], b: &[f32; N]| a.iter().zip(b).all(|(a, b)| f64::from((a - b).abs()) <= STILL);
        if values.iter().all(|value| near(value, &values[0])) {
            return;
        }
        let (mut keys, mut kept): (Vec<[f32; 1]>, Vec<[f32; N]>) = (Vec::new(), Vec::new());
        for i in 0..values.len() {
            let still = i > 0
                && i + 1 < values.len()
                && near(&values[i], &kept[kept.len() - 1])
                && near(&values[i], &values[i + 1]);
            let t = times[i] as f32;
            // Times that differ by less than single precision cannot both be keys.
            if !still && keys.last().is_none_or(|last| last[0] < t) {
                keys.push([t]);
                kept.push(values[i]);
            }
        }
        let input = self.buffer.floats(&keys, Use::Animation);
        let output = self.buffer.floats(&kept, Use::Animation);
        let interpolation = if step { "STEP" } else { "LINEAR" };
        self.channels.push(json!({"sampler": self.samplers.len(), "target": {"node": node, "path": path}}));
        self.samplers.push(json!({"input": input, "output": output, "interpolation": interpolation}));
    }

    fn finish(mut self, name: &str) -> Result<Vec<u8>, serde_json::Error> {
        let root = self.nodes.len();
        self.nodes.push(json!({
            "name": name, "rotation": [-FRAC_1_SQRT_2 as f32, 0.0, 0.0, FRAC_1_SQRT_2 as f32], "children": self.top,
        }));
        let mut document = json!({
            "asset": {"version": "2.0", "generator": concat!("mrtamp ", env!("CARGO_PKG_VERSION"))},
            "scene": 0,
            "scenes": [{"name": name, "nodes": [root]}],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": self.materials,
        });
        if !self.channels.is_empty() {
            document["animations"] = json!([{"name": "plan", "channels": self.channels, "samplers": self.samplers}]);
        }
        self.buffer.into_glb(document)
    }
}

/// Times of a robot's keys (s): its knots, its events, and between knots that are a large turn apart.
fn key_times(playback: &Playback, id: RobotId) -> Vec<f64> {
    let trajectory = &playback.plan.robots[id.index()];
    let events = playback.plan.events.iter().filter(|event| event.robot == trajectory.name).map(|event| event.t);
    let mut times: Vec<f64> = events.chain([0.0]).collect();
    times.extend(trajectory.knots.first().map(|knot| knot.t));
    for pair in trajectory.knots.windows(2) {
        let turn = pair[0].q.iter().zip(&pair[1].q).map(|(a, b)| (b - a).abs()).fold(0.0, f64::max);
        let parts = (turn / GREATEST_TURN).ceil().max(1.0);
        times.extend((1..parts as u32).map(|part| pair[0].t + (pair[1].t - pair[0].t) * f64::from(part) / parts));
        times.push(pair[1].t);
    }
    sorted(times)
}

/// Whether a link moves by the opening of the hand, which jumps.
fn steps(playback: &Playback, robot: RobotId, link: usize) -> bool {
    let robot = playback.problem.robot(robot);
    let joint = robot.joints.iter().find(|joint| joint.child.index() == link);
    let mut value = joint.map(|joint| &joint.value);
    // A chain of mimics is no longer than the list of joints.
    for _ in 0..robot.joints.len() {
        match value {
            Some(model::JointValue::Mimic { of, .. }) => value = robot.joints.get(of.index()).map(|joint| &joint.value),
            Some(model::JointValue::Finger { .. }) => return true,
            _ => return false,
        }
    }
    false
}

fn translation(pose: &Pose) -> [f32; 3] {
    let Point3 { coords: t } = pose.translation.vector.into();
    [t.x, t.y, t.z].map(|x| x as f32)
}

fn rotation(pose: &Pose) -> [f32; 4] {
    let q = pose.rotation.coords.normalize();
    [q.x, q.y, q.z, q.w].map(|x| x as f32)
}
