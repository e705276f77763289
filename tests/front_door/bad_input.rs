//! Every kind of bad input through the program itself: exit code 2, file and line on stderr, no existing file touched.

use std::process::Output;
use std::time::{Duration, Instant};

use assert_cmd::Command;

use crate::{contents, launch_folder};

/// Planning is not reached; a program that takes longer hangs.
const AT_MOST: Duration = Duration::from_secs(30);

/// A folder with a relay of two mobile arms, `robots/` and `scenes/relay.yaml`, and results of an earlier run.
struct Relay(tempfile::TempDir);

impl Relay {
    fn new() -> Self {
        let root = tempfile::tempdir().unwrap();
        let from = launch_folder();
        for folder in ["robots", "scenes", "out"] {
            std::fs::create_dir(root.path().join(folder)).unwrap();
        }
        for file in ["robots/mm10.urdf", "robots/mm10.srdf"] {
            std::fs::copy(from.join(file), root.path().join(file)).unwrap();
        }
        std::fs::copy(from.join("scenes/t03_relay.yaml"), root.path().join("scenes/relay.yaml")).unwrap();
        for file in ["plan.json", "plan.html", "failure.json", "failure.html"] {
            std::fs::write(root.path().join("out").join(file), format!("an earlier {file}")).unwrap();
        }
        Self(root)
    }

    /// With one change to one file.
    fn changed(file: &str, old: &str, new: &str) -> Self {
        let relay = Self::new();
        let path = relay.0.path().join(file);
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains(old), "{file} has no {old:?}");
        std::fs::write(path, text.replacen(old, new, 1)).unwrap();
        relay
    }

    fn plan(&self, out: &str) -> Output {
        let arguments = ["plan", "scenes/relay.yaml", "--in-process", "--out", out];
        let mut command = Command::cargo_bin("mrtamp").unwrap();
        command.args(arguments).current_dir(self.0.path()).env("COLUMNS", "200").timeout(AT_MOST).output().unwrap()
    }
}

/// What a run says on stderr, without any space: lines are broken anywhere.
fn said(output: &Output) -> String {
    joined(&String::from_utf8_lossy(&output.stderr))
}

fn joined(text: &str) -> String {
    text.replace('│', " ").split_whitespace().collect()
}

/// Plans, and sees that it is refused with all of `told` and leaves everything as it was.
fn assert_refused(relay: &Relay, out: &str, told: &[&str]) {
    let before = contents(relay.0.path());
    let refused = relay.plan(out);
    let said = said(&refused);
    assert_eq!(refused.status.code(), Some(2), "{told:?}: {said}");
    for piece in told.iter().chain(&["help:"]) {
        assert!(said.contains(&joined(piece)), "no {piece:?} in {said}");
    }
    assert!(contents(relay.0.path()) == before, "{told:?}: a file was touched");
}

const PROBLEM: &str = "scenes/relay.yaml";
const URDF: &str = "robots/mm10.urdf";
const M1: &str = "{name: m1, shape: {box: [0.07, 0.05, 0.15]}, pose: {xyz: [-2.0, 0.0, 0.675]}}";

#[test]
fn every_kind_of_bad_input_is_refused_with_file_line_and_remedy() {
    let limit = "<limit lower=\"-2.96706\" upper=\"2.96706\" effort=\"100\" velocity=\"1.710423\"/>";
    let cases: &[(&str, &str, &str, &[&str])] = &[
        (PROBLEM, "tool: tool", "tol: tool", &["relay.yaml:8:", "unknown key `tol`", "`tool`"]),
        (PROBLEM, "speed: 0.8", "speed: fast", &["relay.yaml:9:", "not a number"]),
        (PROBLEM, "mm10.urdf", "mm11.urdf", &["relay.yaml:6:", "robots/mm11.urdf: there is no such file"]),
        (
            PROBLEM,
            "{box: [0.4, 0.4, 0.6]}",
            "{mesh: {file: t.stl}}",
            &["relay.yaml:19:", "no mesh t.stl", "scenes/t.stl"],
        ),
        (
            URDF,
            "<link name=\"base_link\">",
            "<xacro:arm/><link name=\"base_link\">",
            &["mm10.urdf:5:", "xacro robots/mm10.urdf > robots/mm10.expanded.urdf"],
        ),
        (
            URDF,
            "<parent link=\"base_link\"/>",
            "<parent link=\"tool\"/>",
            &[
                "mm10.urdf:33:",
                "joints form a cycle: arm_joint_1 → arm_joint_2",
                "tool_mount → arm_mount → arm_joint_1",
            ],
        ),
        (URDF, limit, "", &["mm10.urdf:33:", "joint `arm_joint_1` has no `<limit>`"]),
        (URDF, limit, &limit.replace("-2.96706", "nan"), &["mm10.urdf:", "\"nan\""]),
        (PROBLEM, "[0.4, 0.4, 0.6]", "[0.4, .nan, 0.6]", &["relay.yaml:19:", "contains NaN"]),
        (PROBLEM, "[0.4, 0.4, 0.6]", "[0.4, -0.4, 0.6]", &["relay.yaml:19:", "edge length is -0.4"]),
        (
            PROBLEM,
            "size: [0.4, 0.4]",
            "size: [0.5, 0.4]",
            &["relay.yaml:27:", "sticks out of the surface of `table_a`"],
        ),
        (PROBLEM, "m1, from: a, to: b", "m1, from: c, to: b", &["relay.yaml:33:", "does not stand at the start"]),
        (
            PROBLEM,
            "task:",
            "orderings:\n  - {before: r2.1 done, after: r1.1 start}\ntask:",
            &["relay.yaml:32:", "orderings form a cycle: r1.1 start", "then r2.1 done comes first by ordering 1"],
        ),
        (PROBLEM, "on: table_b", "on: tabel_b", &["relay.yaml:28:", "did you mean `table_b`?"]),
        (PROBLEM, "tool: tool", "tool: left_finger", &["relay.yaml:8:", "`left_finger` moves relative to `arm_7`"]),
        (
            PROBLEM,
            "  r1:\n    - {object: m1, from: a, to: b}\n  r2:\n    - {object: m1, from: b, to: c}\n",
            "  r1: []\n",
            &["relay.yaml:32:", "the task is empty"],
        ),
        (
            PROBLEM,
            "[-2.0, 0.0, 0.675]",
            "[-2.0, 0.0, 0.705]",
            &["relay.yaml:24:", "`m1` floats 30.0 mm above `table_a`"],
        ),
        (PROBLEM, "[-2.0, 0.0, 0.675]", "[-2.0, 0.0, 0.655]", &["relay.yaml:24:", "`m1` sinks 20.0 mm into `table_a`"]),
    ];
    for (file, old, new, told) in cases {
        assert_refused(&Relay::changed(file, old, new), "out", told);
    }
    let relay = Relay::changed(PROBLEM, "mm10.urdf", "arm.urdf.xacro");
    std::fs::copy(relay.0.path().join(URDF), relay.0.path().join("robots/arm.urdf.xacro")).unwrap();
    assert_refused(&relay, "out", &["arm.urdf.xacro:1:", "xacro robots/arm.urdf.xacro > robots/arm.expanded.urdf"]);
}

#[test]
fn a_start_in_collision_is_refused_with_both_bodies_and_the_depth() {
    let beside = |x: f64| {
        format!("{M1}\n  - {{name: m2, shape: {{box: [0.07, 0.05, 0.15]}}, pose: {{xyz: [{x}, 0.0, 0.675]}}}}")
    };
    let wall =
        |x: f64| format!("fixed:\n  - {{name: wall, shape: {{box: [0.1, 1.0, 2.0]}}, pose: {{xyz: [{x}, 0.0, 1.0]}}}}");
    let bent = "yaw: 0.0, arm_joint_2: 2.0, arm_joint_4: -2.0, arm_joint_6: 2.0}";
    let cases: &[(&str, &str, &[&str])] = &[
        // A disc of radius 0.3 at y = -0.3 and a table whose edge is at y = -0.2.
        (
            "start: {x: -1.0, y: -1.0",
            "start: {x: -2.0, y: -0.3",
            &["relay.yaml:10:", "link `base_link` of `r1` and `table_a` overlap by 200.0 mm"],
        ),
        (
            "start: {x: -1.0, y: -1.0",
            "start: {x: -2.0, y: -0.501",
            &[
                "relay.yaml:10:",
                "link `base_link` of `r1` and `table_a` are only 1.0 mm apart, less than the clearance of 2 mm",
            ],
        ),
        (
            "start: {x: 1.0, y: -1.0",
            "start: {x: -0.5, y: -1.0",
            &["relay.yaml:10:", "link `base_link` of `r1` and link `base_link` of `r2` overlap by 100.0 mm"],
        ),
        (
            "yaw: 0.0}",
            bent,
            &["relay.yaml:10:", "link `base_link` of `r1` and link `arm_6` of `r1` overlap by", "link1=\"base_link\""],
        ),
        (M1, &beside(-1.94), &["relay.yaml:24:", "`m2` and `m1` overlap by 10.0 mm", "by at least 10.0 mm"]),
        ("fixed:", &wall(-2.08), &["relay.yaml:19:", "`m1` and `wall` overlap by 5.0 mm"]),
        (
            "fixed:",
            &wall(-0.75).replace("[0.1, 1.0, 2.0]", "[0.2, 2.2, 2.0]"),
            &["relay.yaml:10:", "of `r1` and `wall` overlap by"],
        ),
        // An arm that stands on a table beside the object.
        ("start: {x: -1.0, y: -1.0", "start: {x: -2.0, y: 0.0", &["relay.yaml:10:", "of `r1` and `m1` overlap by"]),
    ];
    for (old, new, told) in cases {
        assert_refused(&Relay::changed(PROBLEM, old, new), "out", told);
    }
}

#[test]
fn objects_that_only_touch_are_no_collision() {
    let beside =
        format!("{M1}\n  - {{name: m2, shape: {{box: [0.07, 0.05, 0.15]}}, pose: {{xyz: [-1.93, 0.0, 0.675]}}}}");
    let relay = Relay::changed(PROBLEM, M1, &beside);
    let mut command = Command::cargo_bin("mrtamp").unwrap();
    let arguments = ["plan", PROBLEM, "--in-process", "--time-limit", "0", "--out", "out"];
    let ended = command.args(arguments).current_dir(relay.0.path()).timeout(AT_MOST).output().unwrap();
    assert_eq!(ended.status.code(), Some(5), "it is planned for, until the limit of no time: {}", said(&ended));
}

#[test]
fn files_that_are_no_problem_are_refused() {
    let relay = Relay::new();
    std::fs::write(relay.0.path().join(PROBLEM), [0xFF, 0xFE, 0x00]).unwrap();
    assert_refused(&relay, "out", &["scenes/relay.yaml", "UTF-8"]);
    std::fs::write(relay.0.path().join(PROBLEM), "").unwrap();
    assert_refused(&relay, "out", &["relay.yaml:1:"]);
    std::fs::remove_file(relay.0.path().join(PROBLEM)).unwrap();
    assert_refused(&relay, "out", &["scenes/relay.yaml: there is no such file"]);
    std::fs::create_dir(relay.0.path().join(PROBLEM)).unwrap();
    assert_refused(&relay, "out", &["scenes/relay.yaml"]);
}

#[test]
fn a_folder_for_results_that_cannot_be_written_is_refused_before_planning() {
    let relay = Relay::new();
    std::fs::write(relay.0.path().join("file"), "mine").unwrap();
    assert_refused(&relay, "file", &["file: no such folder can be made", "--out DIR"]);
    assert_refused(&relay, "file/deeper", &["file/deeper: no such folder can be made"]);
    assert_refused(&relay, "/dev/null/out", &["/dev/null/out: no such folder can be made"]);
    // Nobody may make files there, not even root.
    assert_refused(&relay, "/proc", &["/proc: no file can be written there"]);
    std::fs::create_dir_all(relay.0.path().join("other/plan.json")).unwrap();
    assert_refused(&relay, "other", &["other/plan.json: is a folder"]);
}

/// The relay with so many more objects on a hall's floor, `step` apart.
fn crowd(count: usize, step: f64) -> Relay {
    let objects = (0..count).map(|i| {
        let (x, y) = (20.0 + (i % 100) as f64 * step, (i / 100) as f64 * step);
        format!("  - {{name: k{i}, shape: {{box: [0.01, 0.01, 0.15]}}, pose: {{xyz: [{x}, {y}, 0.675]}}}}\n")
    });
    let hall = "fixed:\n  - {name: hall, shape: {box: [10, 10, 0.6]}, pose: {xyz: [20, 0, 0.3]}}\n";
    let relay = Relay::changed(PROBLEM, "fixed:\n", hall);
    let text = std::fs::read_to_string(relay.0.path().join(PROBLEM)).unwrap();
    let text = text.replace("movable:\n", &format!("movable:\n{}", objects.collect::<String>()));
    std::fs::write(relay.0.path().join(PROBLEM), text).unwrap();
    relay
}

#[test]
fn ten_thousand_objects_are_read_and_checked_within_seconds_and_more_are_refused() {
    let started = Instant::now();
    let relay = crowd(10_000, 0.02);
    assert_refused(&relay, "out", &["10001 entries in `movable`", "relay.yaml:10025:", "give 0 to 10000"]);
    assert_refused(&crowd(9_999, 0.0), "out", &["`k1` and `k0` overlap by 10.0 mm"]);
    // So close that everybody touches their neighbours' bounds; the last one is misplaced.
    let relay = crowd(9_999, 0.01);
    let path = relay.0.path().join(PROBLEM);
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace("[-2.0, 0.0, 0.675]", "[-2.0, 0.0, 0.705]")).unwrap();
    assert_refused(&relay, "out", &["`m1` floats 30.0 mm"]);
    std::fs::write(
        &path,
        text.replace("yaw: 0.0}", "yaw: 0.0, arm_joint_4: -2.0, arm_joint_2: 2.0, arm_joint_6: 2.0}"),
    )
    .unwrap();
    assert_refused(&relay, "out", &["link `arm_6` of `r1`"]);
    assert!(started.elapsed() < 4 * Duration::from_secs(5), "{:?}", started.elapsed());
}
