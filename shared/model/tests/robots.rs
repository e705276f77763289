//! The robots that come with the program are what their comments say.

mod support;

use model::{GraspFamily, LinkId, MovableObject, Pose, Robot, load_problem};
use nalgebra::{Point3, Vector3};
use support::frames::{distance, reach_from_axis, root_from_links};
use support::{PROBLEM, good};

/// Radius of the cylinder round the base axis that holds a folded robot (m).
const FOLDED_RADIUS: f64 = 0.38;

/// mm10 and fa7.
fn robots() -> Result<Vec<Robot>, model::ProblemError> {
    Ok(load_problem(&good(), PROBLEM)?.robots)
}

/// The box of 0.07 by 0.05 by 0.15 m, with all grasps.
fn carton() -> Result<MovableObject, model::ProblemError> {
    let problem = support::load_changed(PROBLEM, ", grasps: side", "")?;
    Ok(problem.movable[0].clone())
}

/// A configuration with the base at its origin.
fn with_base(robot: &Robot, arm: &[f64]) -> Vec<f64> {
    let mut q = vec![0.0; robot.base_len()];
    q.extend_from_slice(arm);
    q
}

fn tool_frame(robot: &Robot, q: &[f64]) -> Pose {
    let hand = &robot.end_effector;
    root_from_links(robot, q, 0.0)[hand.parent_link.index()] * hand.link_from_tool
}

#[test]
fn the_arm_has_the_published_dimensions_limits_and_speeds() {
    for robot in robots().unwrap() {
        let base = robot.base_len();
        let degrees: Vec<(f64, f64)> = robot.coordinates[base..]
            .iter()
            .map(|c| (c.upper.to_degrees().round(), c.velocity.to_degrees().round()))
            .collect();
        let limits = [170.0, 120.0, 170.0, 120.0, 170.0, 120.0, 175.0];
        let speeds = [98.0, 98.0, 100.0, 130.0, 140.0, 180.0, 180.0];
        assert_eq!(degrees, limits.into_iter().zip(speeds).collect::<Vec<_>>());
        let stretched = tool_frame(&robot, &vec![0.0; robot.coordinates.len()]);
        let height = 0.55 + 0.34 + 0.40 + 0.40 + 0.126 + 0.12 - 0.025;
        assert!((stretched.translation.vector - Vector3::new(0.0, 0.0, height)).norm() < 1e-12);
        assert_eq!(robot.end_effector.links.len(), 4);
    }
}

#[test]
fn shoulder_and_wrist_axes_meet_in_points() {
    for robot in robots().unwrap() {
        let q: Vec<f64> = (0..robot.coordinates.len()).map(|i| 0.3 + 0.2 * i as f64).collect();
        let poses = root_from_links(&robot, &q, 0.0);
        let origin = |name: &str| {
            let link = robot.links.iter().position(|link| link.name == name).unwrap();
            poses[link].translation.vector
        };
        assert!(
            (origin("arm_1") - origin("arm_2")).norm() < 1e-12 && (origin("arm_2") - origin("arm_3")).norm() < 1e-12
        );
        assert!((origin("arm_5") - origin("arm_4")).norm() < 1e-12);
        assert!((origin("arm_6") - origin("arm_7")).norm() < 1e-12);
        assert!(((origin("arm_3") - origin("arm_4")).norm() - 0.40).abs() < 1e-12);
        assert!(((origin("arm_5") - origin("arm_6")).norm() - 0.40).abs() < 1e-12);
    }
}

#[test]
fn a_folded_robot_and_the_box_it_holds_stay_in_a_narrow_cylinder() {
    let carton = carton().unwrap();
    for (index, robot) in robots().unwrap().iter().enumerate() {
        for arm in [&robot.home, &robot.carry] {
            let poses = root_from_links(robot, &with_base(robot, arm), robot.end_effector.max_opening);
            for (link, pose) in robot.links.iter().zip(&poses) {
                for body in &link.bodies {
                    let reach = reach_from_axis(pose, body);
                    assert!(reach <= FOLDED_RADIUS, "{} {} reaches {reach}", robot.name, link.name);
                }
            }
            let hand = poses[robot.end_effector.parent_link.index()];
            for grasp in &carton.grasps[index] {
                let reach = reach_from_axis(&(hand * grasp.link_from_object), &carton.body);
                assert!(reach <= FOLDED_RADIUS, "{} holding {grasp:?} reaches {reach}", robot.name);
            }
        }
    }
}

#[test]
fn the_folded_hand_is_level_and_points_forward() {
    for robot in robots().unwrap() {
        let tool = tool_frame(&robot, &with_base(&robot, &robot.home));
        assert!((tool * Vector3::z() - Vector3::x()).norm() < 1e-5);
        assert!((tool * Vector3::y() - Vector3::y()).norm() < 1e-5);
    }
}

#[test]
fn a_folded_robot_keeps_a_centimetre_between_its_links() {
    for robot in robots().unwrap() {
        for (arm, opening) in [(&robot.home, robot.end_effector.max_opening), (&robot.carry, 0.05)] {
            let poses = root_from_links(&robot, &with_base(&robot, arm), opening);
            for (a, b, apart) in link_distances(&robot, &poses) {
                assert!(apart >= 0.01, "{}: {a} and {b} are {apart} m apart", robot.name);
            }
        }
    }
}

#[test]
fn every_pair_of_links_that_is_tested_can_be_apart() {
    for robot in robots().unwrap() {
        let postures = [0.0, 0.7, 1.4].map(|bend| vec![0.3, bend, 0.2, -bend, 0.1, bend, 0.4]);
        let mut apart = std::collections::BTreeMap::new();
        for arm in postures {
            let poses = root_from_links(&robot, &with_base(&robot, &arm), 0.05);
            for (a, b, distance) in link_distances(&robot, &poses) {
                let most = apart.entry((a, b)).or_insert(0.0);
                *most = f64::max(*most, distance);
            }
        }
        let touching: Vec<_> = apart.iter().filter(|(_, most)| **most < 0.005).collect();
        assert!(touching.is_empty(), "{}: {touching:?}", robot.name);
    }
}

/// Names and distance of every pair of links that is tested.
fn link_distances(robot: &Robot, poses: &[Pose]) -> Vec<(String, String, f64)> {
    let mut distances = Vec::new();
    for a in 0..robot.links.len() {
        for b in a + 1..robot.links.len() {
            if robot.disabled_pairs.contains(&(LinkId::at(a), LinkId::at(b))) {
                continue;
            }
            let pairs = robot.links[a].bodies.iter().flat_map(|x| robot.links[b].bodies.iter().map(move |y| (x, y)));
            let least = pairs.map(|(x, y)| distance(&poses[a], x, &poses[b], y)).fold(f64::MAX, f64::min);
            distances.push((robot.links[a].name.clone(), robot.links[b].name.clone(), least));
        }
    }
    distances
}

#[test]
fn side_grasps_come_in_four_yaws_two_flips_and_three_heights() {
    let carton = carton().unwrap();
    let robot = &robots().unwrap()[0];
    let side: Vec<_> = carton.grasps[0].iter().filter(|grasp| grasp.family == GraspFamily::Side).collect();
    assert_eq!(side.len(), 24);
    let tool_from_link = robot.end_effector.link_from_tool.inverse();
    let mut kinds = std::collections::BTreeSet::new();
    for grasp in &side {
        let object_from_tool = (tool_from_link * grasp.link_from_object).inverse();
        let (approach, closing) = (object_from_tool * Vector3::z(), object_from_tool * Vector3::y());
        assert!(approach.z.abs() < 1e-12 && closing.z.abs() < 1e-12, "approach and closing are level");
        let up = object_from_tool * Vector3::x();
        let round = |x: f64| (x * 1e6).round() as i64;
        let height = object_from_tool.translation.z;
        assert!([0.0, 0.0375, -0.0375].iter().any(|h| (height - h).abs() < 1e-12));
        kinds.insert((round(approach.x), round(approach.y), round(up.z), round(height)));
        let width = if closing.x.abs() > 0.5 { 0.07 } else { 0.05 };
        assert!((grasp.opening - width).abs() < 1e-12);
    }
    assert_eq!(kinds.len(), 24);
}

#[test]
fn grasps_put_the_object_between_the_fingers_and_not_into_the_palm() {
    let carton = carton().unwrap();
    let robot = &robots().unwrap()[0];
    let hand = &robot.end_effector;
    let palm = robot.links.iter().position(|link| link.name == "hand").unwrap();
    let finger = robot.links.iter().position(|link| link.name == "left_finger").unwrap();
    for grasp in &carton.grasps[0] {
        let poses = root_from_links(robot, &[0.0; 10], grasp.opening);
        let object = poses[hand.parent_link.index()] * grasp.link_from_object;
        let to = |link: usize| distance(&object, &carton.body, &poses[link], &robot.links[link].bodies[0]);
        assert!(to(palm) > 0.001, "{grasp:?} is {} from the palm", to(palm));
        assert!(to(finger) < 1e-4, "{grasp:?} is {} from a finger", to(finger));
        let tool = poses[hand.parent_link.index()] * hand.link_from_tool;
        let in_tool = tool.inverse() * object * Point3::origin();
        assert!(in_tool.y.abs() < 1e-12, "centred between the fingers");
    }
}

#[test]
fn the_first_grasps_differ_in_family_and_yaw() {
    let carton = carton().unwrap();
    let first = &carton.grasps[0][..8];
    assert_eq!(first.iter().filter(|grasp| grasp.family == GraspFamily::Top).count(), 4);
    let directions: std::collections::BTreeSet<String> = first
        .iter()
        .map(|grasp| {
            (grasp.link_from_object.rotation.inverse() * Vector3::from(grasp.approach)).map(|x| x.round() as i64)
        })
        .map(|direction| format!("{direction}"))
        .collect();
    assert_eq!(directions.len(), 5, "four sides and from above: {directions:?}");
}

#[test]
fn grasps_wider_than_the_hand_are_left_out() {
    let problem = support::load_changed(PROBLEM, "max_opening: 0.09", "max_opening: 0.06").unwrap();
    let widths: Vec<f64> = problem.movable[0].grasps[0].iter().map(|grasp| grasp.opening).collect();
    assert!(!widths.is_empty() && widths.iter().all(|width| (width - 0.05).abs() < 1e-12));
    assert!(problem.movable[0].grasps[1].iter().any(|grasp| grasp.opening > 0.06), "the other robot's hand is wider");
}

#[test]
fn listed_grasps_come_first_and_only_for_their_robots() {
    let list = "grasps: [side, {link_from_object: {xyz: [0, 0, 0.2]}, opening: 0.05, robots: [r2]}]";
    let problem = support::load_changed(PROBLEM, "grasps: side", list).unwrap();
    let families = |robot: usize| problem.movable[0].grasps[robot].iter().map(|grasp| grasp.family).collect::<Vec<_>>();
    assert_eq!(families(0), vec![GraspFamily::Side; 24]);
    assert_eq!(families(1)[..2], [GraspFamily::Listed, GraspFamily::Side]);
    assert_eq!(families(1).len(), 25);
    assert_eq!(problem.movable[0].grasps[1][0].approach, [0.0, 0.0, 1.0]);
}

#[test]
fn fingers_share_the_opening_and_follow_each_other() {
    for robot in robots().unwrap() {
        let poses = root_from_links(&robot, &vec![0.0; robot.coordinates.len()], 0.06);
        let y = |name: &str| poses[robot.links.iter().position(|link| link.name == name).unwrap()].translation.y;
        assert!((y("left_finger") - 0.03).abs() < 1e-12 && (y("right_finger") + 0.03).abs() < 1e-12);
    }
}

#[test]
fn a_planar_base_leads_the_coordinates_and_a_fixed_one_has_none() {
    let robots = robots().unwrap();
    let names: Vec<&str> = robots[0].coordinates.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names[..4], ["base/x", "base/y", "base/yaw", "arm_joint_1"]);
    assert_eq!((robots[0].coordinates[0].lower, robots[0].coordinates[2].upper), (-2.0, f64::INFINITY));
    assert_eq!(robots[0].start[..3], [-1.0, -1.0, 0.5]);
    assert_eq!(robots[0].start[9], 0.1);
    assert_eq!((robots[1].coordinates.len(), robots[1].start.clone()), (7, robots[1].home.clone()));
}
