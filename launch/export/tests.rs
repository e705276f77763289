use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use contract::{CompositeMethod, ProblemStatement};
use model::{ObjectId, Pose, Problem, RobotId};
use nalgebra::{Quaternion, Translation3, UnitQuaternion};
use plan::{EventKind, Plan};
use serde_json::Value;

use super::{csv, glb, ros2};
use crate::ending::finished_plan;
use crate::playback::{Mismatch, Playback};
use crate::progress::{Progress, Show};
use crate::{in_process, problem_source};

/// A built-in scene with its plan.
fn planned(scene: &str) -> (Problem, Plan) {
    let problem = problem_source::load(Some(Path::new(scene))).unwrap();
    let statement = Arc::new(ProblemStatement::new(problem, 0, CompositeMethod::Prioritised));
    let progress = Progress::new(statement.clone(), Show::Nothing);
    let run = in_process::run(&statement, None, &Arc::new(AtomicBool::new(false)), &progress).unwrap();
    let plan = finished_plan(&statement, &run.refinement.ledger, &run.plan.unwrap()).unwrap();
    (statement.problem.clone(), plan)
}

/// Rows of a table by time, each with its fields by column name.
fn read_table(text: &str) -> Vec<BTreeMap<String, String>> {
    let mut lines = text.split("\r\n").filter(|line| !line.is_empty());
    let names: Vec<String> = lines.next().unwrap().split(',').map(str::to_owned).collect();
    let distinct: BTreeSet<&String> = names.iter().collect();
    assert_eq!(distinct.len(), names.len(), "column names are unique");
    lines
        .map(|line| {
            let fields: Vec<&str> = line.split(',').collect();
            assert_eq!(fields.len(), names.len());
            names.iter().cloned().zip(fields.into_iter().map(str::to_owned)).collect()
        })
        .collect()
}

fn number(row: &BTreeMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column}: `{}`", row[column]))
}

#[test]
fn a_table_read_again_has_every_knot_with_the_same_configuration() {
    let (problem, plan) = planned("t05_tiny_region");
    let rows = read_table(&csv(&Playback::new(&problem, &plan).unwrap(), None, true));
    for robot in &plan.robots {
        for knot in &robot.knots {
            let row = rows.iter().find(|row| number(row, "t") == knot.t).unwrap();
            let q: Vec<f64> =
                robot.joints.iter().map(|joint| number(row, &format!("{}/{joint}", robot.name))).collect();
            assert_eq!(q, knot.q, "{} at {}", robot.name, knot.t);
        }
    }
    assert!(rows.windows(2).all(|pair| number(&pair[0], "t") < number(&pair[1], "t")));
}

#[test]
fn a_table_has_objects_where_the_events_say_and_names_who_holds_them() {
    let (problem, plan) = planned("t05_tiny_region");
    let rows = read_table(&csv(&Playback::new(&problem, &plan).unwrap(), None, false));
    for event in &plan.events {
        let row = rows.iter().find(|row| number(row, "t") == event.t).unwrap();
        let place = event.world_from_object.xyz;
        for (axis, exact) in ["x", "y", "z"].iter().zip(place) {
            let found = number(row, &format!("{}.{axis}", event.object));
            assert!((found - exact).abs() < 1e-6, "{} at {}: {found} for {exact}", event.object, event.t);
        }
        let holder = if event.kind == EventKind::Attach { event.robot.as_str() } else { "" };
        assert_eq!(row[&format!("{}.holder", event.object)], holder);
    }
}

#[test]
fn a_rate_gives_rows_at_its_times_and_at_the_end() {
    let (problem, plan) = planned("t00_one_arm");
    let rows = read_table(&csv(&Playback::new(&problem, &plan).unwrap(), Some(10.0), false));
    let times: Vec<f64> = rows.iter().map(|row| number(row, "t")).collect();
    let end = plan.robots[0].knots.last().unwrap().t;
    assert_eq!(times.len(), (end * 10.0).floor() as usize + 2);
    assert!(times[..times.len() - 1].iter().enumerate().all(|(i, t)| (t - i as f64 / 10.0).abs() < 1e-12));
    assert_eq!(times.last(), Some(&end));
}

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().unwrap().keys().map(String::as_str).collect()
}

fn nanoseconds(duration: &Value) -> i64 {
    assert_eq!(keys(duration), ["nanosec", "sec"]);
    let (sec, nanosec) = (duration["sec"].as_i64().unwrap(), duration["nanosec"].as_u64().unwrap());
    assert!(i32::try_from(sec).is_ok() && nanosec < 1_000_000_000);
    sec * 1_000_000_000 + nanosec as i64
}

fn floats(value: &Value, names: &[&str]) -> Vec<f64> {
    assert_eq!(keys(value), names);
    names.iter().map(|name| value[name].as_f64().unwrap()).collect()
}

/// Checks a `std_msgs/Header` and the times of the points; the points.
fn points<'v>(message: &'v Value, fields: &[&str]) -> &'v Vec<Value> {
    assert_eq!(keys(message), ["header", "joint_names", "points"]);
    assert_eq!(keys(&message["header"]), ["frame_id", "stamp"]);
    assert!(message["header"]["frame_id"].is_string());
    assert_eq!(nanoseconds(&message["header"]["stamp"]), 0);
    let points = message["points"].as_array().unwrap();
    let times: Vec<i64> = points.iter().map(|point| nanoseconds(&point["time_from_start"])).collect();
    assert!(times.windows(2).all(|pair| pair[0] < pair[1]), "times increase strictly");
    assert!(points.iter().all(|point| keys(point) == fields));
    points
}

fn check_multi_dof(message: &Value) -> usize {
    let points = points(message, &["accelerations", "time_from_start", "transforms", "velocities"]);
    let dofs = message["joint_names"].as_array().unwrap().len();
    for point in points {
        assert_eq!(point["transforms"].as_array().unwrap().len(), dofs);
        for transform in point["transforms"].as_array().unwrap() {
            assert_eq!(keys(transform), ["rotation", "translation"]);
            floats(&transform["translation"], &["x", "y", "z"]);
            let norm: f64 = floats(&transform["rotation"], &["w", "x", "y", "z"]).iter().map(|part| part * part).sum();
            assert!((norm - 1.0).abs() < 1e-9);
        }
    }
    points.len()
}

#[test]
fn ros2_messages_have_the_fields_and_types_of_their_definitions() {
    let (problem, plan) = planned("t05_tiny_region");
    let text = ros2(&Playback::new(&problem, &plan).unwrap(), None).unwrap();
    let export: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(keys(&export), ["events", "objects", "robots"]);
    for (message, robot) in export["robots"].as_array().unwrap().iter().zip(&plan.robots) {
        assert_eq!(keys(message), ["joint_trajectory", "multi_dof_joint_trajectory", "name"]);
        let arm = &message["joint_trajectory"];
        let fields = ["accelerations", "effort", "positions", "time_from_start", "velocities"];
        let points = points(arm, &fields);
        assert_eq!(arm["joint_names"].as_array().unwrap().len(), robot.joints.len() - 3);
        for point in points {
            assert_eq!(point["positions"].as_array().unwrap().len(), robot.joints.len() - 3);
            assert!(
                ["velocities", "accelerations", "effort"].iter().all(|empty| point[empty] == serde_json::json!([]))
            );
        }
        assert_eq!(check_multi_dof(&message["multi_dof_joint_trajectory"]), points.len());
        assert_eq!(message["multi_dof_joint_trajectory"]["joint_names"], serde_json::json!(["base"]));
        let (last, knot) = (points.last().unwrap(), robot.knots.last().unwrap());
        assert_eq!(nanoseconds(&last["time_from_start"]), (knot.t * 1e9).round() as i64);
        assert_eq!(last["positions"], serde_json::json!(knot.q[3..]));
    }
    for (message, object) in export["objects"].as_array().unwrap().iter().zip(&problem.movable) {
        assert!(check_multi_dof(message) > 4);
        assert_eq!(message["joint_names"], serde_json::json!([object.name]));
    }
    assert_eq!(export["events"].as_array().unwrap().len(), plan.events.len());
}

/// A binary glTF taken apart.
struct Gltf {
    json: Value,
    bytes: Vec<u8>,
}

impl Gltf {
    fn read(file: &[u8]) -> Self {
        let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!((&file[..4], word(4), word(8)), (&b"glTF"[..], 2, file.len()));
        let json_len = word(12);
        assert_eq!((&file[16..20], json_len % 4), (&b"JSON"[..], 0));
        let second = 20 + json_len;
        assert_eq!((&file[second + 4..second + 8], word(second) % 4), (&b"BIN\0"[..], 0));
        assert_eq!(second + 8 + word(second), file.len());
        Self { json: serde_json::from_slice(&file[20..second]).unwrap(), bytes: file[second + 8..].to_vec() }
    }

    /// Values of an accessor, each with its components.
    fn values(&self, accessor: usize) -> Vec<Vec<f64>> {
        let accessor = &self.json["accessors"][accessor];
        let view = &self.json["bufferViews"][index(&accessor["bufferView"])];
        let start = index(&view["byteOffset"]);
        let width = match accessor["type"].as_str().unwrap() {
            "SCALAR" => 1,
            "VEC3" => 3,
            _ => 4,
        };
        assert_eq!(index(&view["byteLength"]), index(&accessor["count"]) * width * 4);
        assert_eq!(start % 4, 0);
        let words =
            self.bytes[start..start + index(&view["byteLength"])].chunks(4).map(|word| word.try_into().unwrap());
        let floats = accessor["componentType"] == 5126;
        let numbers: Vec<f64> = words
            .map(|word| if floats { f64::from(f32::from_le_bytes(word)) } else { f64::from(u32::from_le_bytes(word)) })
            .collect();
        numbers.chunks(width).map(<[f64]>::to_vec).collect()
    }

    /// A node's translation or rotation at a time, as the specification has it.
    fn sampled(&self, node: usize, path: &str, t: f64) -> Vec<f64> {
        let channels = self.json["animations"][0]["channels"].as_array().unwrap();
        let of_node = |c: &&Value| index(&c["target"]["node"]) == node && c["target"]["path"] == path;
        let Some(channel) = channels.iter().find(of_node) else {
            let written = self.json["nodes"][node][path].as_array();
            let default = if path == "translation" { vec![0.0; 3] } else { vec![0.0, 0.0, 0.0, 1.0] };
            return written.map_or(default, |parts| parts.iter().map(|x| x.as_f64().unwrap()).collect());
        };
        let sampler = &self.json["animations"][0]["samplers"][index(&channel["sampler"])];
        let (times, values) = (self.values(index(&sampler["input"])), self.values(index(&sampler["output"])));
        let next = times.partition_point(|time| time[0] <= t);
        if next == 0 || next == times.len() {
            return values[next.saturating_sub(1)].clone();
        }
        let part = (t - times[next - 1][0]) / (times[next][0] - times[next - 1][0]);
        match (sampler["interpolation"].as_str().unwrap(), path) {
            ("STEP", _) => values[next - 1].clone(),
            (_, "translation") => values[next - 1].iter().zip(&values[next]).map(|(a, b)| a + (b - a) * part).collect(),
            _ => quaternion(&values[next - 1]).slerp(&quaternion(&values[next]), part).coords.iter().copied().collect(),
        }
    }

    /// Poses of all nodes in the frame of the root's children (z up).
    fn poses(&self, t: f64) -> Vec<Pose> {
        let nodes = self.json["nodes"].as_array().unwrap();
        let root = index(&self.json["scenes"][0]["nodes"][0]);
        let mut poses = vec![Pose::identity(); nodes.len()];
        let mut below = vec![(root, Pose::identity())];
        while let Some((node, parent)) = below.pop() {
            let place = self.sampled(node, "translation", t);
            let local =
                Translation3::new(place[0], place[1], place[2]) * quaternion(&self.sampled(node, "rotation", t));
            poses[node] = if node == root { parent } else { parent * local };
            let children = nodes[node]["children"].as_array().into_iter().flatten();
            below.extend(children.map(|child| (index(child), poses[node])));
        }
        poses
    }

    fn node(&self, name: &str) -> usize {
        self.json["nodes"].as_array().unwrap().iter().position(|node| node["name"] == name).unwrap()
    }
}

fn index(value: &Value) -> usize {
    usize::try_from(value.as_u64().unwrap()).unwrap()
}

fn quaternion(parts: &[f64]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(Quaternion::new(parts[3], parts[0], parts[1], parts[2]))
}

#[test]
fn a_glb_has_its_chunks_and_every_accessor_its_true_bounds() {
    let (problem, plan) = planned("t05_tiny_region");
    let gltf = Gltf::read(&glb(&Playback::new(&problem, &plan).unwrap(), None).unwrap());
    for (i, accessor) in gltf.json["accessors"].as_array().unwrap().iter().enumerate() {
        let values = gltf.values(i);
        for (component, bound) in accessor["min"].as_array().unwrap().iter().enumerate() {
            let least = values.iter().map(|value| value[component]).fold(f64::MAX, f64::min);
            assert_eq!(bound.as_f64(), Some(least), "accessor {i}");
        }
        for (component, bound) in accessor["max"].as_array().unwrap().iter().enumerate() {
            let greatest = values.iter().map(|value| value[component]).fold(f64::MIN, f64::max);
            assert_eq!(bound.as_f64(), Some(greatest), "accessor {i}");
        }
    }
    for sampler in gltf.json["animations"][0]["samplers"].as_array().unwrap() {
        let times = gltf.values(index(&sampler["input"]));
        assert!(times[0][0] >= 0.0 && times.windows(2).all(|pair| pair[0][0] < pair[1][0]));
    }
    let root = &gltf.json["nodes"][index(&gltf.json["scenes"][0]["nodes"][0])];
    let turn: Vec<f64> = root["rotation"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    let up = quaternion(&turn) * nalgebra::Vector3::z();
    assert!((up - nalgebra::Vector3::y()).norm() < 1e-6, "z up becomes y up: {up}");
}

/// Compares every link and object of a glb with the playback at times between the knots.
fn assert_glb_follows(problem: &Problem, plan: &Plan) {
    let playback = Playback::new(problem, plan).unwrap();
    let gltf = Gltf::read(&glb(&playback, None).unwrap());
    for step in 0..=40 {
        let t = playback.duration_s() * (f64::from(step) + 0.123) / 41.0;
        let poses = gltf.poses(t);
        for robot in (0..problem.robots.len()).map(RobotId::at) {
            for (link, exact) in problem.robot(robot).links.iter().zip(playback.link_poses(robot, t)) {
                let found = poses[gltf.node(&format!("{}/{}", problem.robot(robot).name, link.name))];
                assert_near(&found, &exact, 2e-5, &format!("{} at {t}", link.name));
            }
        }
        for (i, object) in problem.movable.iter().enumerate() {
            // A held object's curve is followed by short straight pieces.
            assert_near(&poses[gltf.node(&object.name)], &playback.object_pose(ObjectId::at(i), t), 2e-3, &object.name);
        }
    }
}

fn assert_near(found: &Pose, exact: &Pose, tolerance: f64, what: &str) {
    let apart = (found.translation.vector - exact.translation.vector).norm();
    assert!(apart < tolerance, "{what}: {apart} m off");
    assert!(found.rotation.angle_to(&exact.rotation) < 10.0 * tolerance, "{what}: turned");
}

#[test]
fn a_glb_player_shows_links_and_objects_where_the_plan_has_them() {
    for scene in ["t00_one_arm", "t05_tiny_region"] {
        let (problem, plan) = planned(scene);
        assert_glb_follows(&problem, &plan);
    }
}

#[test]
fn turns_of_more_than_half_a_circle_are_not_taken_the_short_way() {
    let (problem, mut plan) = planned("t05_tiny_region");
    let last = plan.robots[0].knots.len() - 1;
    let mut turned = plan.robots[0].knots[last].clone();
    plan.robots[0].knots[last].q[2] += 5.0;
    turned.t += 3.0;
    plan.robots[0].knots.push(turned);
    assert_glb_follows(&problem, &plan);
    let export: Value = serde_json::from_str(&ros2(&Playback::new(&problem, &plan).unwrap(), None).unwrap()).unwrap();
    let points = export["robots"][0]["multi_dof_joint_trajectory"]["points"].as_array().unwrap();
    let turns: Vec<UnitQuaternion<f64>> = points
        .iter()
        .map(|point| {
            quaternion(&["x", "y", "z", "w"].map(|part| point["transforms"][0]["rotation"][part].as_f64().unwrap()))
        })
        .collect();
    assert!(turns.windows(2).all(|pair| pair[0].angle_to(&pair[1]) < 1.6));
}

#[test]
fn a_plan_of_another_problem_is_refused_by_name() {
    let (problem, plan) = planned("t00_one_arm");
    let other = problem_source::load(Some(Path::new("t05_tiny_region"))).unwrap();
    assert!(matches!(Playback::new(&other, &plan), Err(Mismatch::Robots { .. })));
    let changed = |change: fn(&mut Plan)| {
        let mut plan = plan.clone();
        change(&mut plan);
        Playback::new(&problem, &plan).map(|_| ()).unwrap_err()
    };
    assert!(matches!(changed(|plan| plan.robots[0].joints[0] = "elbow".into()), Mismatch::Joints { .. }));
    assert!(matches!(changed(|plan| plan.robots[0].knots.clear()), Mismatch::Knots { .. }));
    assert!(matches!(changed(|plan| plan.robots[0].knots[1].t = 0.0), Mismatch::Knots { .. }));
    assert!(matches!(changed(|plan| plan.events[0].object = "m9".into()), Mismatch::Unknown { .. }));
    assert!(matches!(changed(|plan| plan.robots[0].segments[0].to = 9999), Mismatch::Unknown { .. }));
}
