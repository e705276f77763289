//! What `mrtamp robot` says of real robots.

use std::path::PathBuf;

use launch::packages::PackageArgs;
use launch::robot_command::{RobotArgs, look_at};
use launch::robot_report::{Reason, RobotReport, text};
use model::{DiskFiles, load_robot};

use crate::{panda_urdf, ur5_urdf};

fn guessed(urdf: PathBuf) -> (RobotReport, String) {
    let arguments = RobotArgs {
        urdf,
        srdf: None,
        packages: PackageArgs::default(),
        write_srdf: None,
        planar_base: false,
        samples: 2_000,
        json: false,
    };
    let (report, srdf) = look_at(&arguments).unwrap();
    (report, srdf.unwrap())
}

fn pairs(report: &RobotReport, reason: Reason) -> Vec<(&str, &str)> {
    let of_reason = report.not_tested.iter().filter(|pair| pair.reason == Some(reason));
    of_reason.map(|pair| (pair.link1.as_str(), pair.link2.as_str())).collect()
}

#[test]
fn the_pandas_arm_hand_and_tool_frame_are_guessed() {
    let (report, _) = guessed(panda_urdf());
    let said = text(&report);
    for piece in [
        "panda: 13 links, 7 planned coordinates",
        "panda_leftfinger  (panda_finger_joint1: prismatic, finger)  [4 × box]",
        "panda_rightfinger  (panda_finger_joint2: prismatic, follows panda_finger_joint1)  [4 × box]",
        "panda_joint4                   -3.072     -0.070      2.175",
        "grasps in    panda_link7",
        "may touch    panda_link8, panda_hand, panda_hand_tcp, panda_leftfinger, panda_rightfinger",
        "sliding fingers open 0.0800 m",
        "`tool: panda_hand_tcp`",
        "shoulder at (0.000, 0.000, 0.333)",
    ] {
        assert!(said.contains(piece), "no {piece:?} in\n{said}");
    }
    assert_eq!(pairs(&report, Reason::Adjacent).len(), 10);
    let never = pairs(&report, Reason::Never);
    assert!(never.contains(&("panda_link3", "panda_hand")) && never.contains(&("panda_link0", "panda_link2")));
    assert!(pairs(&report, Reason::Always).is_empty() && report.doubtful.is_empty());
    assert!(report.tested.iter().any(|pair| pair.link1 == "panda_link5" && pair.touching > 0.03));
}

#[test]
fn the_ur5_is_seen_to_have_no_gripper() {
    let (report, _) = guessed(ur5_urdf());
    let hand = &report.end_effector;
    assert_eq!(
        (hand.parent_link.as_str(), hand.max_opening, hand.tool.as_deref()),
        ("wrist_3_link", 0.0, Some("tool0"))
    );
    assert_eq!(hand.touch_links, ["wrist_3_link", "ee_link", "tool0"], "its flange may touch what it holds");
    assert!(text(&report).contains("a problem must give `max_opening`"));
    assert_eq!(report.coordinates.len(), 6);
}

#[test]
fn guessed_srdf_files_load_and_their_homes_are_free() {
    for urdf in [panda_urdf(), ur5_urdf()] {
        let (report, srdf) = guessed(urdf.clone());
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("guessed.srdf").to_string_lossy().into_owned();
        std::fs::write(&path, srdf).unwrap();
        let robot = load_robot(&DiskFiles, &urdf.to_string_lossy(), &path).unwrap();
        assert!(pairs(&report, Reason::Default).is_empty(), "{} touches itself at home", report.name);
        let steps: Vec<f64> = robot.home.iter().map(|x| x / std::f64::consts::FRAC_PI_4).collect();
        assert!(steps.iter().all(|x| (x - x.round()).abs() < 1e-5), "{steps:?}");
        assert!(steps.iter().any(|x| x.abs() > 0.5), "a folded arm is bent");
    }
}

#[test]
fn no_sample_of_a_proven_pair_touches() {
    for urdf in [panda_urdf(), ur5_urdf()] {
        let (report, _) = guessed(urdf);
        let never = report.not_tested.iter().filter(|pair| pair.reason == Some(Reason::Never));
        assert!(never.clone().count() >= 2 && never.clone().all(|pair| pair.touching == 0.0));
    }
}
