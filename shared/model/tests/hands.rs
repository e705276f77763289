//! Hands without fingers, robots by themselves, and files in ROS packages.

mod support;

use model::{GraspFamily, JointValue, Problem, ProblemError, load_problem, load_robot, read_urdf};
use support::{MemoryFiles, PROBLEM, good};

/// The second robot holds with its flange, as if a suction cup were there.
const SUCTION: &str = r#"<robot name="fa7">
  <group name="arm"><chain base_link="arm_base" tip_link="arm_7"/></group>
  <group name="cup"><link name="arm_7"/></group>
  <end_effector name="cup" parent_link="arm_7" group="cup" parent_group="arm"/>
  <group_state name="home" group="arm">
    <joint name="arm_joint_1" value="0"/><joint name="arm_joint_2" value="-0.9"/><joint name="arm_joint_3" value="0"/>
    <joint name="arm_joint_4" value="-1.8"/><joint name="arm_joint_5" value="0"/><joint name="arm_joint_6" value="0.7"/>
    <joint name="arm_joint_7" value="0"/>
  </group_state>
</robot>"#;
/// From the wrist's centre to the front of the flange in fa7 (m).
const FLANGE: f64 = 0.126;
const HEIGHT_OF_M1: f64 = 0.15;

fn replaced(files: &mut MemoryFiles, path: &str, old: &str, new: &str) {
    let text = String::from_utf8_lossy(&files.0[path]).into_owned();
    assert!(text.contains(old), "{path} does not contain {old:?}");
    files.0.insert(path.to_owned(), text.replacen(old, new, 1).into_bytes());
}

fn with_suction(max_opening: &str) -> Result<Problem, ProblemError> {
    let mut files = good();
    files.0.insert("robots/fa7.srdf".to_owned(), SUCTION.as_bytes().to_vec());
    replaced(&mut files, PROBLEM, "fa7.srdf\n    tool: tool\n", &format!("fa7.srdf\n{max_opening}"));
    replaced(&mut files, PROBLEM, "grasps: side", "grasps: top");
    load_problem(&files, PROBLEM)
}

#[test]
fn a_rigid_hand_holds_an_object_close_before_its_front() {
    let problem = with_suction("    max_opening: 0.3\n").unwrap();
    let grasps = &problem.movable[0].grasps[1];
    assert_eq!(grasps.len(), 4);
    for grasp in grasps {
        let middle = grasp.link_from_object.translation.vector;
        assert!((middle.z - (FLANGE + 0.002 + HEIGHT_OF_M1 / 2.0)).abs() < 1e-9, "{middle}");
        assert!(middle.x.hypot(middle.y) < 1e-9 && grasp.family == GraspFamily::Top);
        assert!((grasp.link_from_object * nalgebra::Vector3::z()).z < -0.999, "the object is seen upside down");
    }
}

#[test]
fn a_link_of_the_arm_in_the_hands_group_may_touch_and_its_joint_stays_planned() {
    let problem = with_suction("    max_opening: 0.3\n").unwrap();
    let robot = &problem.robots[1];
    assert_eq!(robot.coordinates.len(), 7);
    let last = robot.joints.iter().find(|joint| joint.name == "arm_joint_7").unwrap();
    assert!(matches!(last.value, JointValue::Coordinate(_)) && robot.is_touch_link(last.child));
}

#[test]
fn a_rigid_hand_of_which_no_width_is_known_is_refused_with_the_remedy() {
    let error = with_suction("").unwrap_err();
    assert_eq!(error.findings().len(), 1);
    assert_eq!(error.findings()[0].line(), Some(10));
    let told = support::render(&error);
    assert!(told.contains("`r2`") && told.contains("max_opening"), "{told}");
}

#[test]
fn a_robot_without_a_problem_is_as_in_one() {
    let files = good();
    let alone = load_robot(&files, "robots/fa7.urdf", "robots/fa7.srdf").unwrap();
    let within = &load_problem(&files, PROBLEM).unwrap().robots[1];
    assert_eq!(alone.name, "fa7");
    assert_eq!(alone.coordinates, within.coordinates);
    assert_eq!((&alone.links, &alone.joints), (&within.links, &within.joints));
    assert_eq!((&alone.home, &alone.disabled_pairs), (&within.home, &within.disabled_pairs));
    assert_eq!(load_robot(&files, support::URDF, support::SRDF).unwrap().base_len(), 3);
}

#[test]
fn a_urdf_alone_gives_the_tree_and_its_limits() {
    let tree = read_urdf(&good(), "robots/fa7.urdf").unwrap();
    assert_eq!(tree.links[0].name, "base_link");
    let seven = tree.joints.iter().find(|joint| joint.name == "arm_joint_7").unwrap();
    assert_eq!((seven.lower, seven.upper), (-3.054326, 3.054326));
    assert!((seven.velocity - std::f64::consts::PI).abs() < 1e-6);
    assert_eq!(tree.joint_of(seven.child), Some(seven));
    assert!(tree.joints_below(seven.child).any(|joint| joint.name == "hand_mount"));
    assert_eq!(tree.joints.iter().filter(|joint| joint.mimics).count(), 1);
    assert!(read_urdf(&good(), "robots/fa8.urdf").unwrap_err().to_string().contains("fa8.urdf"));
}

#[test]
fn descriptions_in_packages_are_found_and_where_they_were_sought_is_told() {
    let mut files = good();
    for name in ["fa7.urdf", "fa7.srdf"] {
        let bytes = files.0.remove(&format!("robots/{name}")).unwrap();
        files.0.insert(format!("arms/robots/{name}"), bytes);
        replaced(&mut files, PROBLEM, &format!("../robots/{name}"), &format!("package://arms/robots/{name}"));
    }
    assert!(load_problem(&files, PROBLEM).is_ok());
    files.0.remove("arms/robots/fa7.srdf");
    let told = support::render(&load_problem(&files, PROBLEM).unwrap_err());
    let flat = told.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(flat.contains("scenes/arms/robots/fa7.srdf, arms/robots/fa7.srdf"), "{told}");
    assert!(flat.contains("--package arms=FOLDER") && flat.contains("package://arms/robots/fa7.srdf"), "{told}");
}
