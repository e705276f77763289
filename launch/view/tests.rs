use std::path::Path;

use model::{Point, Pose, Problem, Robot};
use nalgebra::{Quaternion, Translation3, Unit, UnitQuaternion, Vector3};
use plan::{BodyRef, Cause, Certificate, Cover, Failure, PairPoint, Plan, ResultKind, StageCount, Stay};
use serde_json::Value;

use super::point_times::point_time;
use super::{failure_page, plan_page};
use crate::problem_source;

fn problem(scene: &str) -> Problem {
    problem_source::load(Some(Path::new(scene))).unwrap()
}

/// A plan in which every robot stands still.
fn standing_plan(problem: &Problem) -> Plan {
    let robots = problem.robots.iter().map(|robot| plan::RobotTrajectory {
        name: robot.name.clone(),
        joints: robot.coordinates.iter().map(|coordinate| coordinate.name.clone()).collect(),
        knots: vec![plan::Knot { t: 0.0, q: robot.start.clone() }],
        segments: Vec::new(),
    });
    Plan {
        format: plan::PLAN_FORMAT.into(),
        problem: problem.name.clone(),
        robots: robots.collect(),
        events: Vec::new(),
        orderings: Vec::new(),
        dependencies: Vec::new(),
        makespan: plan::Makespan { task_s: 0.0, total_s: 0.0 },
        lower_bound: plan::LowerBound { seconds: 0.0, kind: "none".into() },
        provenance: provenance(),
    }
}

fn provenance() -> plan::Provenance {
    plan::Provenance {
        problem_digest: "d".into(),
        seed: 0,
        implementations: Vec::new(),
        search: plan::SearchRecord::default(),
        ledger_digest: "l".into(),
    }
}

fn failure(causes: Vec<(Cause, u64)>) -> Failure {
    Failure {
        format: plan::FAILURE_FORMAT.into(),
        problem: "p".into(),
        result: ResultKind::SamplesExhausted,
        stopped_by: None,
        causes,
        certificate: None,
        stages: vec![StageCount { stage: "placement".into(), jobs: 3, failures: 2, work: 10 }],
        reached: None,
        provenance: provenance(),
    }
}

/// The JSON that a page's scripts read.
fn data(page: &str) -> Value {
    let (_, rest) = page.split_once("<script type=\"application/json\"").unwrap();
    let (_, rest) = rest.split_once('>').unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

#[test]
fn a_page_names_no_address_and_forbids_every_request() {
    let problem = problem("figure1");
    let page = plan_page(&problem, &standing_plan(&problem), &[], &[]).unwrap();
    let addresses = page.match_indices("://").map(|(at, _)| &page[at.saturating_sub(5)..at + 25]);
    let others: Vec<&str> = addresses.filter(|address| !address.contains("://www.w3.org/2000/svg")).collect();
    assert_eq!(others, [""; 0]);
    let (_, policy) = page.split_once("Content-Security-Policy\" content=\"").unwrap();
    let policy = policy.split_once('"').unwrap().0;
    assert!(policy.starts_with("default-src 'none';") && !policy.contains("unsafe"), "{policy}");
    let nonce = policy.split_once("'nonce-").unwrap().1.split_once('\'').unwrap().0;
    assert_eq!(page.matches(&format!("nonce=\"{nonce}\"")).count(), 3, "style, data, script");
    assert!(!page.contains("<!--") && !page.contains(" src=") && !page.contains("@import"));
}

#[test]
fn a_hostile_name_stays_text() {
    let mut problem = problem("t00_one_arm");
    let name = "</script><script>alert(1)</script><!--\u{2028}\"'&";
    name.clone_into(&mut problem.name);
    name.clone_into(&mut problem.movable[0].name);
    let page = plan_page(&problem, &standing_plan(&problem), &[], &[]).unwrap();
    assert_eq!(page.matches("</script").count(), 2);
    assert_eq!(page.matches("<script").count(), 2);
    assert!(page.contains("<title>&lt;/script&gt;"));
    assert_eq!(data(&page)["scene"]["objects"][0]["name"], name);
}

/// Numbers of a JSON array.
fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn pose(value: &Value) -> Pose {
    let p = numbers(value);
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(p[6], p[3], p[4], p[5]));
    Pose::from_parts(Translation3::new(p[0], p[1], p[2]), turn)
}

/// Forward kinematics from the page's numbers alone.
fn link_poses_of_page(robot: &Value, q: &[f64], opening: f64) -> Vec<Pose> {
    let mut poses = vec![pose(&robot["base"]); robot["links"].as_array().unwrap().len()];
    if robot["planar"] == true {
        poses[0] *= Pose::from_parts(
            Translation3::new(q[0], q[1], 0.0),
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), q[2]),
        );
    }
    for joint in robot["joints"].as_array().unwrap() {
        let driver = match joint["coordinate"].as_u64() {
            Some(coordinate) => q[usize::try_from(coordinate).unwrap()],
            None if joint["opening"] == true => opening,
            None => 0.0,
        };
        let value = joint["offset"].as_f64().unwrap() + joint["factor"].as_f64().unwrap() * driver;
        let axis = |name: &str| joint.get(name).map(|axis| Vector3::from_vec(numbers(axis)));
        let motion = match (axis("turn"), axis("slide")) {
            (Some(axis), _) => Pose::from_parts(
                Translation3::identity(),
                UnitQuaternion::from_axis_angle(&Unit::new_normalize(axis), value),
            ),
            (None, Some(axis)) => Pose::from_parts((axis * value).into(), UnitQuaternion::identity()),
            (None, None) => Pose::identity(),
        };
        let end = |name: &str| usize::try_from(joint[name].as_u64().unwrap()).unwrap();
        poses[end("child")] = poses[end("parent")] * pose(&joint["pose"]) * motion;
    }
    poses
}

fn middle_configuration(robot: &Robot, part: f64) -> Vec<f64> {
    let within = |low: f64, high: f64| if high.is_finite() { low + (high - low) * part } else { 6.0 * part - 3.0 };
    robot.coordinates.iter().map(|coordinate| within(coordinate.lower, coordinate.upper)).collect()
}

#[test]
fn the_numbers_of_a_page_give_the_kinematics_of_its_robots() {
    for scene in ["figure1", "t00_one_arm"] {
        let problem = problem(scene);
        let page = data(&plan_page(&problem, &standing_plan(&problem), &[], &[]).unwrap());
        for (i, robot) in problem.robots.iter().enumerate() {
            for part in [0.0, 0.2, 0.55, 0.9, 1.0] {
                let (q, opening) = (middle_configuration(robot, part), robot.end_effector.max_opening * part);
                let found = link_poses_of_page(&page["scene"]["robots"][i], &q, opening);
                for (link, (found, exact)) in found.iter().zip(kinematics::link_poses(robot, &q, opening)).enumerate() {
                    let apart = (found.translation.vector - exact.translation.vector).norm();
                    let what = &robot.links[link].name;
                    assert!(apart < 2e-5 && found.rotation.angle_to(&exact.rotation) < 1e-6, "{what}: {apart}");
                }
            }
        }
    }
}

#[test]
fn a_plan_of_another_problem_has_no_page() {
    let plan = standing_plan(&problem("t00_one_arm"));
    assert!(plan_page(&problem("figure1"), &plan, &[], &[]).is_err());
}

/// One cause of every kind, about figure 1.
fn every_cause() -> Vec<Cause> {
    let point = |pair: &str| PairPoint { pair: pair.into(), point: Point::Grasp };
    let link = BodyRef::Link { robot: "r1".into(), link: "arm_4".into() };
    let held = BodyRef::Held { robot: "r1".into(), object: "m1".into() };
    vec![
        Cause::Collision { first: link, second: held },
        Cause::Collision { first: BodyRef::Fixed("shelf".into()), second: BodyRef::Object("m2".into()) },
        Cause::Overlap { region: "w3".into(), leaves: "m1".into(), comes: "m2".into() },
        Cause::NoPlacement { object: "m1".into(), region: "w4".into() },
        Cause::Cycle { points: vec![point("r1.1"), point("r2.1")] },
        Cause::Unreachable { robot: "r2".into(), pair: "r2.1".into(), object: "m1".into(), region: "w3".into() },
        Cause::NoCommonGrasp { pair: "r3.1".into() },
        Cause::NoPath { pair: Some("r1.2".into()), robot: "r1".into(), blocking: vec![BodyRef::Object("m4".into())] },
        Cause::NoPath { pair: None, robot: "r1".into(), blocking: Vec::new() },
        Cause::Deadlock { robots: vec!["r2".into(), "r3".into()] },
    ]
}

#[test]
fn every_body_that_a_cause_names_is_in_the_scene_of_its_page() {
    let problem = problem("figure1");
    let causes = every_cause().into_iter().map(|cause| (cause, 2)).collect();
    let page = data(&failure_page(&problem, &failure(causes)).unwrap());
    let mut known = Vec::new();
    for (kind, list) in [("robot", "robots"), ("object", "objects"), ("fixed", "fixed"), ("region", "regions")] {
        for owner in page["scene"][list].as_array().unwrap() {
            let name = owner["name"].as_str().unwrap();
            known.push(format!("{kind}:{name}"));
            for link in owner["links"].as_array().into_iter().flatten() {
                known.push(format!("link:{name}/{}", link["name"].as_str().unwrap()));
            }
        }
    }
    for cause in page["failure"]["causes"].as_array().unwrap() {
        let bodies = cause["bodies"].as_array().unwrap();
        assert!(!bodies.is_empty(), "{cause}");
        for body in bodies {
            assert!(known.iter().any(|name| body == name), "{body} of {cause}");
        }
        assert_eq!(cause["count"], 2);
    }
}

#[test]
fn a_proof_comes_before_the_causes_and_names_what_it_is_about() {
    let problem = problem("figure1");
    let certificates = [
        Certificate::ObjectTooLarge { object: "m1".into(), region: "w4".into() },
        Certificate::NoCommonGrasp { robot: "r1".into(), pair: "r1.1".into(), grasps: Vec::new() },
        Certificate::Area {
            region: "w3".into(),
            region_area_m2: 0.16,
            stays: vec![Cover { stay: Stay { object: "m2".into(), placed_by: None }, area_m2: 0.17 }],
            together: Vec::new(),
        },
    ];
    let expected = [
        ("m1 does not fit into w4 at any yaw", vec!["object:m1", "region:w4"]),
        ("each of the 0 grasps of r1 for r1.1 is impossible", vec!["object:m1", "region:w1", "region:w3", "robot:r1"]),
        ("m2 have to be in w3 together: 1700.0 cm² where there are 1600.0", vec!["object:m2", "region:w3"]),
    ];
    for (certificate, (words, bodies)) in certificates.into_iter().zip(expected) {
        let mut failure = failure(vec![(Cause::Deadlock { robots: vec!["r1".into()] }, 1)]);
        failure.certificate = Some(certificate);
        let page = data(&failure_page(&problem, &failure).unwrap());
        let [proof, cause] = page["failure"]["causes"].as_array().unwrap().as_slice() else { panic!("not two") };
        assert_eq!((&proof["group"], &cause["group"]), (&"proof".into(), &"task".into()));
        assert!(proof["words"].as_str().unwrap().contains(words), "{proof}");
        assert_eq!(proof["bodies"], serde_json::json!(bodies));
    }
}

#[test]
fn a_failure_page_says_how_much_was_tried() {
    let mut problem = problem("t00_one_arm");
    problem.levels.highest = 2;
    let page = data(&failure_page(&problem, &failure(Vec::new())).unwrap());
    let tried = page["failure"]["tried"]["lines"].as_array().unwrap();
    assert!(tried.iter().any(|line| line == "128 placements for each hop of an object"), "{tried:?}");
    assert!(tried.iter().any(|line| line == "3 jobs were answered, 2 with a failure"), "{tried:?}");
    assert_eq!(page["stages"][0]["work"], 10);
}

#[test]
fn points_of_a_pair_without_its_events_have_no_time() {
    let problem = problem("t00_one_arm");
    assert_eq!(point_time(&standing_plan(&problem), "r1.1", Point::Grasp), None);
}
