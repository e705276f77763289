//! Bad inputs are refused with file, line and remedy. The snapshots show what a user sees.

mod support;

macro_rules! shown {
    ($text:expr $(,)?) => {
        insta::with_settings!({omit_expression => true}, { insta::assert_snapshot!($text) })
    };
}

use support::{PROBLEM, SRDF, URDF, good, load_changed, render};

/// The messages for changes to one file, one change at a time.
fn messages(path: &str, changes: &[(&str, &str)]) -> String {
    let mut text = String::new();
    for (old, new) in changes {
        let message = match load_changed(path, old, new) {
            Ok(_) => "ACCEPTED".to_owned(),
            Err(error) => {
                let told =
                    |finding: &model::Finding| finding.line().is_some() && miette::Diagnostic::help(finding).is_some();
                assert!(error.findings().iter().all(told), "no line or no remedy for {new:?}: {error}");
                render(&error)
            }
        };
        assert!(message.contains(path), "{new:?} is not told to be in {path}: {message}");
        text.push_str(&format!("# {}  ->  {}\n{message}\n\n", old.trim(), new.trim()));
    }
    text
}

#[test]
fn the_unchanged_problem_is_accepted() {
    let problem = model::load_problem(&good(), PROBLEM).unwrap();
    assert_eq!((problem.robots.len(), problem.pairs.len(), problem.orderings.len()), (2, 3, 1));
}

#[test]
fn structure_that_is_not_a_problem_file_is_refused() {
    shown!(messages(
        PROBLEM,
        &[
            ("tool: tool\n", "tol: tool\n"),
            ("    urdf: ../robots/mm10.urdf\n", ""),
            ("shape: {box:", "shape: {bx:"),
            ("grasps: side", "grasps: bottom"),
            ("grasps: side", "grasps: [side, {opening: 0.05}]"),
            ("[0.4, 0.4, 0.6]", "[0.4, 0.4]"),
            ("[0.4, 0.4, 0.6]", "[0.4, wide, 0.6]"),
            ("point: at_pick", "point: at_pickup"),
            ("before: bring done", "before: bring finished"),
            ("before: bring done", "before: bring"),
            ("name: small", "name: small\nname: other"),
            ("name: small", "name: [small"),
            ("robots:\n", "robots:\n\t"),
            ("start: {x: -1", "start: away # {x: -1"),
            ("clearance: 0.003", "clearence: 0.003"),
            ("shape: {box: [0.4, 0.4, 0.6]}", "shapes: []"),
            ("shape: {box: [0.4, 0.4, 0.6]}, ", ""),
        ]
    ));
}

#[test]
fn unknown_and_unfit_names_are_refused_with_a_suggestion() {
    shown!(messages(
        PROBLEM,
        &[
            ("mm10.urdf", "mm11.urdf"),
            ("name: table_b", "name: table_a"),
            ("name: m2", "name: 'm 2'"),
            ("on: table_b", "on: tabel_b"),
            ("  r2:\n", "  r3:\n"),
            ("{object: m2, from: b", "{object: m3, from: b"),
            ("{object: m1, from: b", "{object: m1, from: shelf"),
            ("before: bring done", "before: brng done"),
            ("name: bring", "name: r1.2"),
            ("arm_joint_7: 0.1", "arm_joint7: 0.1"),
            ("arm_joint_7: 0.1", "base/x: 0.1"),
            ("tool: tool", "tool: tol"),
        ]
    ));
}

#[test]
fn numbers_out_of_their_range_are_refused() {
    shown!(messages(
        PROBLEM,
        &[
            ("[0.4, 0.4, 0.6]", "[0.4, .nan, 0.6]"),
            ("[0.4, 0.4, 0.6]", "[0.4, -0.4, 0.6]"),
            ("[1, -1, 0]", "[1, -1, .inf]"),
            ("radius: 0.03", "radius: 0"),
            ("rpy: [0, 0, 1.57]", "quat_xyzw: [1, 0, 0, 1]"),
            ("rpy: [0, 0, 1.57]", "rpy: [0, 0, 1.57], quat_xyzw: [0, 0, 0, 1]"),
            ("x: [-2, 2]", "x: [2, -2]"),
            ("speed: 0.8", "speed: 0"),
            ("max_opening: 0.09", "max_opening: 0.2"),
            ("clearance: 0.003", "clearance: -1"),
            ("grasps: 8", "grasps: 0"),
        ]
    ));
}

#[test]
fn things_that_stand_where_they_cannot_are_refused() {
    shown!(messages(
        PROBLEM,
        &[
            ("xyz: [0, 0, 0.675]", "xyz: [0, 0, 0.68]"),
            ("xyz: [0, 0, 0.675]", "xyz: [0, 0, 0.5]"),
            ("xyz: [0, 0, 0.675]", "xyz: [0, 0.18, 0.675]"),
            ("xyz: [0, 0, 0.675]", "xyz: [1, 0.1, 0.675]"),
            ("xyz: [0, 0, 0.675]", "xyz: [0, 0.6, 0.675]"),
            ("xyz: [0, 0, 0.675]", "xyz: [0, 0, 0.675], rpy: [0.1, 0, 0]"),
            ("size: [0.4, 0.4]", "size: [0.5, 0.4]"),
            ("centre: [0, 0.01]", "centre: [0, 0.15]"),
            ("yaw: 0.2", "height: 0.2"),
            ("xyz: [1, 0, 0.3]", "xyz: [1, 0, 0.3], rpy: [0.5, 0, 0]"),
            ("x: -1, y: -1", "x: -3, y: -1"),
            ("arm_joint_7: 0.1", "arm_joint_7: 3.1"),
        ]
    ));
}

#[test]
fn tasks_that_do_not_fit_together_are_refused() {
    shown!(messages(
        PROBLEM,
        &[
            ("{object: m1, from: b, to: a}", "{object: m1, from: a, to: b}"),
            ("{object: m1, from: a, to: b, name: bring}", "{object: m1, from: b, to: a, name: bring}"),
            ("max_opening: 0.09", "max_opening: 0.04"),
            (
                "{object: m2, from: b, to: a}\n  r2:\n",
                "{object: m2, from: b, to: b}\n  r2:\n    - {object: m2, from: b, to: b}\n"
            ),
            ("before: bring done, after: {pair: r2.1, point: at_pick}", "before: r2.1 release, after: bring start"),
            ("before: bring done, after: {pair: r2.1, point: at_pick}", "before: r1.2 grasp, after: bring done"),
            ("before: bring done, after: {pair: r2.1, point: at_pick}", "before: r1.2 grasp, after: r1.2 grasp"),
            (
                "- {before: bring done, after: {pair: r2.1, point: at_pick}}",
                "- {before: r1.2 done, after: r2.1 start}\n  - {before: r2.1 done, after: bring carry}"
            ),
        ]
    ));
}

#[test]
fn a_task_without_pairs_is_refused() {
    let mut files = good();
    let text = String::from_utf8(files.0[PROBLEM].clone()).unwrap();
    let head = text.split("task:").next().unwrap();
    files.0.insert(PROBLEM.to_owned(), format!("{head}task:\n  r1: []\n").into_bytes());
    let error = model::load_problem(&files, PROBLEM).unwrap_err();
    shown!(render(&error));
}

#[test]
fn robots_that_their_files_do_not_allow_are_refused() {
    shown!(messages(
        PROBLEM,
        &[
            ("tool: tool", "tool: left_finger"),
            ("    base: {x: [-2, 2], y: [-2, 2], speed: 0.8, yaw_rate: 1.5}\n", ""),
            ("  - name: r2\n", "  - name: r2\n    base: {x: [-2, 2], y: [-2, 2], speed: 0.8, yaw_rate: 1.5}\n"),
            ("name: r1\n", "name: r1\n    pose: {rpy: [0.1, 0, 0]}\n"),
        ]
    ));
}

#[test]
fn urdf_files_that_describe_no_robot_are_refused() {
    shown!(messages(
        URDF,
        &[
            ("<link name=\"base_link\">", "<xacro:include filename=\"arm.xacro\"/><link name=\"base_link\">"),
            ("<robot", "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\"><xacro:arm/></robot><!--"),
            ("</link>", ""),
            ("<limit lower=\"-2.96706\" upper=\"2.96706\" effort=\"100\" velocity=\"1.710423\"/>", ""),
            ("velocity=\"1.710423\"", ""),
            ("velocity=\"1.710423\"", "velocity=\"0\""),
            ("lower=\"-2.96706\" upper=\"2.96706\"", "lower=\"2.96706\" upper=\"-2.96706\""),
            ("lower=\"-2.96706\"", "lower=\"${-170 * deg}\""),
            ("<child link=\"arm_1\"/>", "<child link=\"arm_2\"/>"),
            ("<parent link=\"base_link\"/>", "<parent link=\"tool\"/>"),
            ("<link name=\"tool\"/>", "<link name=\"tool\"/><link name=\"floating\"/>"),
            ("<link name=\"tool\"/>", "<link name=\"tool\"/><link name=\"hand\"/>"),
            ("<child link=\"arm_1\"/>", "<child link=\"arm_11\"/>"),
            ("<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 0 0\"/>"),
            ("<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 0 z\"/>"),
            ("radius=\"0.3\"", "radius=\"-0.3\""),
            ("<cylinder radius=\"0.3\" length=\"0.53\"/>", "<mesh filename=\"package://mm10/base.stl\"/>"),
            ("type=\"revolute\"", "type=\"floating\""),
            ("<mimic joint=\"left_finger_joint\"/>", "<mimic joint=\"right_finger_joint\"/>"),
            ("<mimic joint=\"left_finger_joint\"/>", "<mimic joint=\"finger_joint\"/>"),
        ]
    ));
}

#[test]
fn srdf_files_that_do_not_fit_the_urdf_are_refused() {
    shown!(messages(
        SRDF,
        &[
            ("<end_effector name=\"gripper\" parent_link=\"arm_7\" group=\"gripper\" parent_group=\"arm\"/>", ""),
            ("group=\"gripper\" parent_group", "group=\"griper\" parent_group"),
            ("parent_group=\"arm\"", "parent_group=\"gripper\""),
            ("name=\"home\"", "name=\"hone\""),
            ("<joint name=\"arm_joint_4\" value=\"-1.79133\"/>", ""),
            ("name=\"arm_joint_4\" value=\"-1.79133\"", "name=\"arm_joint_4\" value=\"-4\""),
            ("name=\"arm_joint_4\" value=\"-1.79133\"", "name=\"arm_joint_4\" value=\"bent\""),
            ("link1=\"arm_5\"", "link1=\"arm5\""),
            ("type=\"planar\"", "type=\"floating\""),
            ("child_link=\"base_link\"", "child_link=\"arm_1\""),
            ("base_link=\"arm_base\" tip_link=\"arm_7\"", "base_link=\"arm_7\" tip_link=\"arm_base\""),
        ]
    ));
}

#[test]
fn a_missing_problem_file_is_told_by_its_path() {
    let error = model::load_problem(&good(), "scenes/smal.yaml").unwrap_err();
    shown!(render(&error));
}

#[test]
fn bytes_that_are_no_text_are_refused() {
    let mut files = good();
    files.0.insert(PROBLEM.to_owned(), vec![b'n', 0xFF, 0xFE]);
    let error = model::load_problem(&files, PROBLEM).unwrap_err();
    shown!(render(&error));
}

#[test]
fn a_world_file_is_not_taken_for_a_robot() {
    let mut files = good();
    files.0.insert(URDF.to_owned(), b"<sdf version='1.9'><world name='w'/></sdf>".to_vec());
    let error = model::load_problem(&files, PROBLEM).unwrap_err();
    shown!(render(&error));
}

#[test]
fn all_findings_of_one_step_are_told_at_once() {
    let mut files = good();
    let text = String::from_utf8(files.0[PROBLEM].clone()).unwrap();
    let text = text.replace("object: m2", "object: m3").replace("from: b", "from: c");
    files.0.insert(PROBLEM.to_owned(), text.into_bytes());
    let error = model::load_problem(&files, PROBLEM).unwrap_err();
    let lines: Vec<_> = error.findings().iter().map(|finding| (finding.kind().name(), finding.line())).collect();
    assert_eq!(lines, [("unknown_name", Some(27)), ("unknown_name", Some(29))]);
}

#[test]
fn search_settings_that_mean_nothing_are_refused() {
    let instead = |text: &'static str| ("levels: {grasps: 8}", text);
    shown!(messages(
        PROBLEM,
        &[
            instead("search: {policy: {transition: more:3:1}}"),
            instead("search: {policy: {transition: {more: 2}}}"),
            instead("search: {policy: {roadmap: halt}}"),
            instead("search: {policy: {motion: stop}}"),
            instead("search: {limit: {drrt: 0}}"),
            instead("search: {limit: {composite: many}}"),
            instead("search: {time_limit: -3}"),
        ]
    ));
}
