//! What of a URDF and an SRDF becomes which part of a robot.

mod support;

use model::{JointMotion, JointValue, LinkId, Problem, ProblemError, Robot, load_problem};
use support::{PROBLEM, SRDF, URDF, good};

/// The first robot of the good problem after changes (file, old, new).
fn robot(changes: &[(&str, &str, &str)]) -> Result<Robot, ProblemError> {
    let mut files = good();
    for (path, old, new) in changes {
        let text = String::from_utf8_lossy(&files.0[*path]).into_owned();
        assert!(text.contains(old), "{path} does not contain {old:?}");
        files.0.insert((*path).to_owned(), text.replacen(old, new, 1).into_bytes());
    }
    let Problem { mut robots, .. } = load_problem(&files, PROBLEM)?;
    Ok(robots.swap_remove(0))
}

fn value_of<'a>(robot: &'a Robot, joint: &str) -> Option<&'a JointValue> {
    robot.joints.iter().find(|known| known.name == joint).map(|known| &known.value)
}

#[test]
fn joints_come_after_the_joint_that_moves_their_parent() {
    let robot = robot(&[]).unwrap();
    let mut placed = vec![LinkId(0)];
    for joint in &robot.joints {
        assert!(placed.contains(&joint.parent), "{}", joint.name);
        placed.push(joint.child);
    }
    assert_eq!(placed.len(), robot.links.len());
}

#[test]
fn a_joint_outside_the_arm_group_stands_as_home_says() {
    let shorter = ("base_link=\"arm_base\" tip_link=\"arm_7\"", "base_link=\"arm_1\" tip_link=\"arm_7\"");
    let moved = ("<joint name=\"arm_joint_1\" value=\"0\"/>", "<joint name=\"arm_joint_1\" value=\"0.25\"/>");
    let robot = robot(&[(SRDF, shorter.0, shorter.1), (SRDF, moved.0, moved.1)]).unwrap();
    assert_eq!(value_of(&robot, "arm_joint_1"), Some(&JointValue::Constant(0.25)));
    assert_eq!(robot.coordinates[3].name, "arm_joint_2");
    assert_eq!(robot.home.len(), 6);
}

#[test]
fn without_a_parent_group_all_joints_but_the_hands_are_planned() {
    let robot = robot(&[(SRDF, " parent_group=\"arm\"", "")]).unwrap();
    assert_eq!(robot.coordinates.len(), 10);
}

#[test]
fn groups_may_list_groups_links_and_joints() {
    let nested = "<group name=\"inner\"><link name=\"hand\"/><joint name=\"left_finger_joint\"/></group>\n  \
                  <group name=\"gripper\">\n    <group name=\"inner\"/><group name=\"gripper\"/>";
    let robot = robot(&[(
        SRDF,
        "<group name=\"gripper\">\n    <link name=\"hand\"/>\n    <link name=\"left_finger\"/>",
        nested,
    )]);
    let mut links: Vec<String> = Vec::new();
    let robot = robot.unwrap();
    links.extend(robot.end_effector.links.iter().map(|link| robot.links[link.index()].name.clone()));
    assert_eq!(links, ["hand", "left_finger", "right_finger", "tool"]);
}

#[test]
fn a_continuous_joint_has_no_bounds_but_a_speed() {
    let old = "type=\"revolute\">\n    <origin xyz=\"0 0 0.34\"/>";
    let robot = robot(&[(URDF, old, &old.replace("revolute", "continuous"))]).unwrap();
    let first = &robot.coordinates[3];
    assert_eq!((first.lower, first.upper), (f64::NEG_INFINITY, f64::INFINITY));
    assert!((first.velocity - 1.710423).abs() < 1e-12);
    assert!(matches!(robot.joints[1].motion, JointMotion::Revolute { axis: [0.0, 0.0, 1.0] }));
}

#[test]
fn axes_are_normalised() {
    let robot = robot(&[(URDF, "<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 0 2.5\"/>")]).unwrap();
    assert!(matches!(robot.joints[1].motion, JointMotion::Revolute { axis: [0.0, 0.0, 1.0] }));
}

#[test]
fn a_hand_of_hinges_stands_open_as_its_group_state_says() {
    let hinged = [
        (URDF, "name=\"left_finger_joint\" type=\"prismatic\"", "name=\"left_finger_joint\" type=\"revolute\""),
        (URDF, "name=\"right_finger_joint\" type=\"prismatic\"", "name=\"right_finger_joint\" type=\"revolute\""),
    ];
    assert!(robot(&hinged).unwrap_err().to_string().contains("no sliding finger"));
    let open = "<group_state name=\"open\" group=\"gripper\"><joint name=\"left_finger_joint\" value=\"0.04\"/></group_state></robot>";
    let robot = robot(&[hinged[0], hinged[1], (SRDF, "</robot>", open)]).unwrap();
    assert_eq!(value_of(&robot, "left_finger_joint"), Some(&JointValue::Constant(0.04)));
    assert_eq!(value_of(&robot, "right_finger_joint"), Some(&JointValue::Constant(0.04)), "a follower follows");
    assert_eq!(robot.end_effector.max_opening, 0.09);
}

#[test]
fn without_a_tool_link_the_parent_link_is_the_tool_frame() {
    let robot = robot(&[(PROBLEM, "    tool: tool\n", ""), (PROBLEM, "    max_opening: 0.09\n", "")]).unwrap();
    assert_eq!(robot.end_effector.link_from_tool, model::Pose::identity());
    assert!((robot.end_effector.max_opening - 0.10).abs() < 1e-12, "what the finger joints allow");
}

#[test]
fn adjacent_links_links_of_one_piece_and_disabled_ones_are_never_tested() {
    let robot = robot(&[]).unwrap();
    let tested = |a: &str, b: &str| {
        let id = |name: &str| LinkId::at(robot.links.iter().position(|link| link.name == name).unwrap());
        let (a, b) = (id(a).min(id(b)), id(a).max(id(b)));
        !robot.disabled_pairs.contains(&(a, b))
    };
    assert!(!tested("arm_1", "arm_2"), "joined by a joint");
    assert!(!tested("arm_7", "tool"), "on one rigid piece");
    assert!(!tested("arm_5", "arm_7"), "disabled in the SRDF");
    assert!(tested("arm_1", "arm_3") && tested("base_link", "hand") && tested("arm_3", "arm_5"));
    assert!(robot.disabled_pairs.is_sorted() && robot.disabled_pairs.iter().all(|(a, b)| a < b));
}

#[test]
fn robots_that_share_a_faulty_file_have_it_told_once() {
    let mut files = good();
    let problem = String::from_utf8_lossy(&files.0[PROBLEM]).replace("fa7", "mm10");
    files.0.insert(PROBLEM.to_owned(), problem.into_bytes());
    let urdf = String::from_utf8_lossy(&files.0[URDF]).replacen("<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 0 0\"/>", 1);
    files.0.insert(URDF.to_owned(), urdf.into_bytes());
    assert_eq!(load_problem(&files, PROBLEM).unwrap_err().findings().len(), 1);
}
