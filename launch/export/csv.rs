//! One wide table: a row for each time, a column for each value.

use model::{LinkId, ObjectId, Pose, RobotId};

use super::grid;
use crate::playback::Playback;

/// Names of a pose's seven columns: m in the world, unit quaternion.
const POSE: [&str; 7] = ["x", "y", "z", "qx", "qy", "qz", "qw"];

/// The plan as CSV (RFC 4180), numbers in shortest form that reads back the same.
///
/// Columns: `t` (s); `<robot>/<joint>` (m or rad); `<robot>.tool.x` to `.qw`, the tool frame in the world;
/// with `links` also `<robot>.link.<link>.x` to `.qw`; `<object>.x` to `.qw`; `<object>.holder`, the robot that holds it.
/// Rows are the knots of all robots, or a grid where a rate (Hz) is given.
#[must_use]
pub fn csv(playback: &Playback, rate_hz: Option<f64>, links: bool) -> String {
    let times = rate_hz.map_or_else(|| playback.knot_times(), |rate| grid(playback, rate));
    let mut text = line(header(playback, links));
    for t in times {
        text += &line(row(playback, t, links));
    }
    text
}

fn header(playback: &Playback, links: bool) -> Vec<String> {
    let mut names = vec!["t".to_owned()];
    let pose = |names: &mut Vec<String>, of: String| names.extend(POSE.map(|axis| format!("{of}.{axis}")));
    for robot in &playback.problem.robots {
        names.extend(robot.coordinates.iter().map(|coordinate| format!("{}/{}", robot.name, coordinate.name)));
        pose(&mut names, format!("{}.tool", robot.name));
        for link in robot.links.iter().filter(|_| links) {
            pose(&mut names, format!("{}.link.{}", robot.name, link.name));
        }
    }
    for object in &playback.problem.movable {
        pose(&mut names, object.name.clone());
        names.push(format!("{}.holder", object.name));
    }
    names
}

fn row(playback: &Playback, t: f64, links: bool) -> Vec<String> {
    let mut values = vec![number(t)];
    for robot in playback.problem.robot_ids() {
        values.extend(playback.configuration(robot, t).into_iter().map(number));
        let poses = playback.link_poses(robot, t);
        values.extend(numbers(&(world_from_tool(playback, robot, &poses))));
        values.extend(poses.iter().filter(|_| links).flat_map(numbers));
    }
    for object in (0..playback.problem.movable.len()).map(ObjectId::at) {
        values.extend(numbers(&playback.object_pose(object, t)));
        values.push(playback.holder(object, t).map_or(String::new(), |holder| holder.event.robot.clone()));
    }
    values
}

fn world_from_tool(playback: &Playback, robot: RobotId, link_poses: &[Pose]) -> Pose {
    let hand = &playback.problem.robot(robot).end_effector;
    let parent: LinkId = hand.parent_link;
    link_poses[parent.index()] * hand.link_from_tool
}

fn numbers(pose: &Pose) -> Vec<String> {
    let (t, q) = (pose.translation.vector, pose.rotation.coords);
    [t.x, t.y, t.z, q.x, q.y, q.z, q.w].map(number).to_vec()
}

fn number(value: f64) -> String {
    format!("{}", value + 0.0)
}

fn line(fields: Vec<String>) -> String {
    let quoted = |field: String| {
        if field.contains([',', '"', '\n', '\r']) { format!("\"{}\"", field.replace('"', "\"\"")) } else { field }
    };
    fields.into_iter().map(quoted).collect::<Vec<_>>().join(",") + "\r\n"
}
