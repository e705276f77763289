//! `mrtamp robot`.

use crate::{code, copy_robot, mrtamp, said, t00_with};

#[test]
fn a_robot_is_shown_with_tree_limits_hand_reach_and_pairs() {
    let folder = tempfile::tempdir().unwrap();
    copy_robot("fa7.urdf", &folder.path().join("fa7.urdf"));
    copy_robot("fa7.srdf", &folder.path().join("fa7.srdf"));
    let shown = mrtamp(&["robot", "fa7.urdf", "--srdf", "fa7.srdf"], folder.path(), &[]);
    assert_eq!(code(&shown), 0, "{}", said(&shown));
    let text = String::from_utf8_lossy(&shown.stdout);
    for piece in [
        "fa7: 13 links, 7 planned coordinates",
        "          arm_3  (arm_joint_3: revolute, planned)  [capsule]",
        "right_finger  (right_finger_joint: prismatic, follows left_finger_joint)  [box]",
        "arm_joint_4                    -2.094      2.094      2.269     -1.791",
        "sliding fingers open 0.1000 m",
        "`tool: tool` in a problem",
        "bounds       0.400 to 0.800 m",
        "pairs of links in 10000 random configurations",
        "Never (28): proven",
    ] {
        assert!(text.contains(piece), "no {piece:?} in\n{text}");
    }
}

#[test]
fn programs_get_the_same_as_json() {
    let folder = tempfile::tempdir().unwrap();
    copy_robot("mm10.urdf", &folder.path().join("mm10.urdf"));
    copy_robot("mm10.srdf", &folder.path().join("mm10.srdf"));
    let shown =
        mrtamp(&["robot", "mm10.urdf", "--srdf", "mm10.srdf", "--json", "--samples", "500"], folder.path(), &[]);
    let report: serde_json::Value = serde_json::from_slice(&shown.stdout).unwrap();
    assert_eq!(report["coordinates"].as_array().unwrap().len(), 10);
    assert!(report["coordinates"][2]["upper"].is_null(), "yaw has no limit");
    assert_eq!(report["samples"], 500);
    let doubtful = &report["doubtful"][0];
    assert_eq!((&doubtful["link1"], &doubtful["link2"]), (&"arm_5".into(), &"arm_7".into()));
    let sampled = report["reach"]["sampled"][1].as_f64().unwrap();
    assert!(sampled <= report["reach"]["bounds"][1].as_f64().unwrap() && sampled > 0.7);
}

#[test]
fn the_srdf_it_writes_plans_a_scene_and_is_never_written_over() {
    let folder = tempfile::tempdir().unwrap();
    copy_robot("fa7.urdf", &folder.path().join("fa7.urdf"));
    let write = ["robot", "fa7.urdf", "--write-srdf", "fa7.srdf"];
    let written = mrtamp(&write, folder.path(), &[]);
    assert_eq!(code(&written), 0, "{}", said(&written));
    let srdf = std::fs::read(folder.path().join("fa7.srdf")).unwrap();
    std::fs::write(folder.path().join("scene.yaml"), t00_with("fa7.urdf", "fa7.srdf")).unwrap();
    let planned = mrtamp(&["plan", "scene.yaml", "--in-process", "--out", "out"], folder.path(), &[]);
    assert_eq!(code(&planned), 0, "{}", said(&planned));
    let again = mrtamp(&write, folder.path(), &[]);
    assert_eq!(code(&again), 2);
    assert!(said(&again).contains("fa7.srdf exists already"), "{}", said(&again));
    assert_eq!(std::fs::read(folder.path().join("fa7.srdf")).unwrap(), srdf);
}

#[test]
fn a_written_srdf_of_a_mobile_base_moves_in_the_plane() {
    let folder = tempfile::tempdir().unwrap();
    copy_robot("mm10.urdf", &folder.path().join("mm10.urdf"));
    let write = ["robot", "mm10.urdf", "--planar-base", "--write-srdf", "mm10.srdf", "--samples", "100"];
    assert_eq!(code(&mrtamp(&write, folder.path(), &[])), 0);
    let shown = mrtamp(&["robot", "mm10.urdf", "--srdf", "mm10.srdf", "--samples", "100"], folder.path(), &[]);
    assert!(said(&shown).contains("10 planned coordinates") && said(&shown).contains("base/yaw"), "{}", said(&shown));
}

#[test]
fn files_that_are_no_robot_are_refused_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    copy_robot("fa7.urdf", &folder.path().join("fa7.urdf"));
    std::fs::write(folder.path().join("stone.urdf"), "<robot name='stone'><link name='stone'/></robot>").unwrap();
    std::fs::write(folder.path().join("empty.srdf"), "<robot name='fa7'>\n</robot>").unwrap();
    for (arguments, told) in [
        (vec!["robot", "nowhere.urdf"], "nowhere.urdf"),
        (vec!["robot", "stone.urdf"], "no joint moves"),
        (vec!["robot", "fa7.urdf", "--srdf", "empty.srdf"], "empty.srdf:1"),
    ] {
        let refused = mrtamp(&arguments, folder.path(), &[]);
        assert_eq!(code(&refused), 2, "{arguments:?}");
        assert!(said(&refused).contains(told), "{}", said(&refused));
    }
}
