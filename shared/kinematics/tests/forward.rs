//! Forward kinematics and Jacobians.

mod common;

use common::{Random, add_base, add_coordinate, add_joint, bare, pose_error};
use kinematics::{chain, jacobian, link_pose, link_poses, link_poses_into};
use model::{CoordinateId, JointId, JointMotion, JointValue, LinkId, Pose, Robot};
use nalgebra::{Isometry3, Matrix3, Matrix4, Point3, Translation3, UnitQuaternion, Vector3};

const OPENING: f64 = 0.06;

fn revolute(axis: [f64; 3]) -> JointMotion {
    JointMotion::Revolute { axis }
}

fn prismatic(axis: [f64; 3]) -> JointMotion {
    JointMotion::Prismatic { axis }
}

fn planar_two_bar() -> Robot {
    let mut robot = bare("two bars");
    let value = add_coordinate(&mut robot, [-3.0, 3.0]);
    let upper = add_joint(&mut robot, LinkId(0), Pose::identity(), revolute([0.0, 0.0, 1.0]), value);
    let value = add_coordinate(&mut robot, [-3.0, 3.0]);
    let lower = add_joint(&mut robot, upper, Pose::translation(0.7, 0.0, 0.0), revolute([0.0, 0.0, -1.0]), value);
    let tip = Pose::translation(0.4, 0.0, 0.2);
    robot.end_effector.parent_link = add_joint(&mut robot, lower, tip, JointMotion::Fixed, JointValue::Constant(0.0));
    robot
}

#[test]
fn two_bars_in_the_plane_follow_the_textbook_formula() {
    let robot = planar_two_bar();
    let mut random = Random(1);
    for _ in 0..200 {
        let q = random.configuration(&robot);
        let (a, b) = (q[0], q[0] - q[1]);
        let expected = Vector3::new(0.7 * a.cos() + 0.4 * b.cos(), 0.7 * a.sin() + 0.4 * b.sin(), 0.2);
        let tip = link_pose(&robot, &q, robot.end_effector.parent_link);
        assert!((tip.translation.vector - expected).norm() < 1e-14);
        assert!((tip * Vector3::x() - Vector3::new(b.cos(), b.sin(), 0.0)).norm() < 1e-14);
    }
}

#[test]
fn a_planar_base_moves_in_the_frame_it_is_measured_in() {
    let mut robot = bare("rover");
    let quarter = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2);
    add_base(&mut robot, Isometry3::from_parts(Translation3::new(10.0, 20.0, 0.5), quarter));
    let pose = link_pose(&robot, &[2.0, 1.0, 0.3], LinkId(0));
    // A quarter turn takes (2, 1) to (-1, 2).
    assert!((pose.translation.vector - Vector3::new(9.0, 22.0, 0.5)).norm() < 1e-14);
    let heading = 0.3 + std::f64::consts::FRAC_PI_2;
    assert!((pose * Vector3::x() - Vector3::new(heading.cos(), heading.sin(), 0.0)).norm() < 1e-14);
}

#[test]
fn a_sliding_joint_moves_its_link_along_its_turned_axis() {
    let mut robot = bare("slide");
    let value = add_coordinate(&mut robot, [-3.0, 3.0]);
    let turned = add_joint(&mut robot, LinkId(0), Pose::identity(), revolute([1.0, 0.0, 0.0]), value);
    let value = add_coordinate(&mut robot, [0.0, 0.5]);
    let slid = add_joint(&mut robot, turned, Pose::translation(0.1, 0.0, 0.0), prismatic([0.0, 0.6, 0.8]), value);
    let q: [f64; 2] = [0.4, 0.25];
    let (sin, cos) = q[0].sin_cos();
    let expected = Vector3::new(0.1, 0.25 * (0.6 * cos - 0.8 * sin), 0.25 * (0.6 * sin + 0.8 * cos));
    assert!((link_pose(&robot, &q, slid).translation.vector - expected).norm() < 1e-15);
}

#[test]
fn a_mimicking_joint_follows_a_chain_of_joints_before_and_after_it() {
    let mut robot = bare("mimic");
    // Joint 0 follows joint 2, which follows joint 1.
    let follow = |of: u32, multiplier, offset| JointValue::Mimic { of: JointId(of), multiplier, offset };
    let x = [1.0, 0.0, 0.0];
    let first = add_joint(&mut robot, LinkId(0), Pose::identity(), prismatic(x), follow(2, 2.0, 0.5));
    let value = add_coordinate(&mut robot, [-1.0, 1.0]);
    let second = add_joint(&mut robot, LinkId(0), Pose::identity(), prismatic(x), value);
    let third = add_joint(&mut robot, LinkId(0), Pose::identity(), prismatic(x), follow(1, -3.0, 0.1));
    let poses = link_poses(&robot, &[0.2], 0.0);
    let x_of = |link: LinkId| poses[link.index()].translation.vector.x;
    assert!((x_of(second) - 0.2).abs() < 1e-15);
    assert!((x_of(third) - (-3.0 * 0.2 + 0.1)).abs() < 1e-15);
    assert!((x_of(first) - (2.0 * (-3.0 * 0.2 + 0.1) + 0.5)).abs() < 1e-15);
    assert_eq!(chain(&robot, first), vec![CoordinateId(0)]);
}

#[test]
fn joints_that_mimic_each_other_stand_still() {
    let mut robot = bare("ring");
    let follow = |of: u32| JointValue::Mimic { of: JointId(of), multiplier: 1.0, offset: 0.0 };
    let first = add_joint(&mut robot, LinkId(0), Pose::identity(), prismatic([1.0, 0.0, 0.0]), follow(1));
    let second = add_joint(&mut robot, first, Pose::identity(), prismatic([1.0, 0.0, 0.0]), follow(0));
    assert_eq!(link_pose(&robot, &[], second), Pose::identity());
}

#[test]
fn fingers_stand_apart_by_the_opening_and_a_lone_link_sees_the_hand_open() {
    let mut robot = bare("gripper");
    let finger = JointValue::Finger { scale: 0.5 };
    let y = [0.0, 1.0, 0.0];
    let left = add_joint(&mut robot, LinkId(0), Pose::identity(), prismatic(y), finger);
    let mirror = JointValue::Mimic { of: JointId(0), multiplier: -1.0, offset: 0.0 };
    let right = add_joint(&mut robot, LinkId(0), Pose::identity(), prismatic(y), mirror);
    let poses = link_poses(&robot, &[], OPENING);
    let gap = poses[left.index()].translation.vector.y - poses[right.index()].translation.vector.y;
    assert!((gap - OPENING).abs() < 1e-15);
    let open = link_pose(&robot, &[], left).translation.vector.y;
    assert!((open - 0.5 * robot.end_effector.max_opening).abs() < 1e-15);
}

/// A tree on a planar base with branches, rigid, sliding, mimicking and finger joints.
fn random_tree(random: &mut Random) -> Robot {
    let mut robot = bare("tree");
    if random.unit() < 0.5 {
        let stand = random.pose(2.0);
        add_base(&mut robot, stand);
    }
    for i in 0..12_usize {
        let parent = LinkId::at((random.unit() * robot.links.len() as f64) as usize);
        let axis = random.direction().into();
        let value = match (random.unit() * 5.0) as usize {
            0 if i > 0 => {
                let of = JointId::at((random.unit() * i as f64) as usize);
                JointValue::Mimic { of, multiplier: random.between(-2.0, 2.0), offset: random.between(-1.0, 1.0) }
            }
            1 => JointValue::Finger { scale: random.between(-1.0, 1.0) },
            2 => JointValue::Constant(random.between(-1.0, 1.0)),
            _ => add_coordinate(&mut robot, [-2.0, 2.0]),
        };
        let motion = match (random.unit() * 4.0) as usize {
            0 => JointMotion::Fixed,
            1 => prismatic(axis),
            _ => revolute(axis),
        };
        let place = random.pose(0.5);
        add_joint(&mut robot, parent, place, motion, value);
    }
    robot
}

/// Poses as products of homogeneous matrices, rotations by Rodrigues' formula: shares no code with the crate.
fn matrices(robot: &Robot, q: &[f64], opening: f64) -> Vec<Matrix4<f64>> {
    fn value(robot: &Robot, joint: usize, q: &[f64], opening: f64) -> f64 {
        match robot.joints[joint].value {
            JointValue::Coordinate(id) => q[id.index()],
            JointValue::Finger { scale } => scale * opening,
            JointValue::Constant(constant) => constant,
            JointValue::Mimic { of, multiplier, offset } => multiplier * value(robot, of.index(), q, opening) + offset,
        }
    }
    fn turn(axis: [f64; 3], angle: f64) -> Matrix4<f64> {
        let k = Vector3::from(axis).cross_matrix();
        (Matrix3::identity() + k * angle.sin() + k * k * (1.0 - angle.cos())).to_homogeneous()
    }
    fn slide(shift: Vector3<f64>) -> Matrix4<f64> {
        Matrix4::new_translation(&shift)
    }
    let mut root = robot.world_from_base.to_homogeneous();
    if robot.base.is_some() {
        root = root * slide(Vector3::new(q[0], q[1], 0.0)) * turn([0.0, 0.0, 1.0], q[2]);
    }
    let mut poses = vec![root; robot.links.len()];
    for (i, joint) in robot.joints.iter().enumerate() {
        let v = value(robot, i, q, opening);
        let moved = match joint.motion {
            JointMotion::Fixed => Matrix4::identity(),
            JointMotion::Revolute { axis } => turn(axis, v),
            JointMotion::Prismatic { axis } => slide(Vector3::from(axis) * v),
        };
        poses[joint.child.index()] = poses[joint.parent.index()] * joint.parent_from_joint.to_homogeneous() * moved;
    }
    poses
}

#[test]
fn poses_of_random_trees_are_the_products_of_homogeneous_matrices() {
    for seed in 0..200 {
        let mut random = Random(seed);
        let robot = random_tree(&mut random);
        let mut poses = Vec::new();
        for opening in [OPENING, robot.end_effector.max_opening] {
            let q = random.configuration(&robot);
            link_poses_into(&robot, &q, opening, &mut poses);
            for (link, expected) in matrices(&robot, &q, opening).iter().enumerate() {
                let error = (poses[link].to_homogeneous() - expected).abs().max();
                assert!(error < 1e-12, "seed {seed}, link {link}: {error}");
            }
            assert_eq!(poses, link_poses(&robot, &q, opening), "seed {seed}");
        }
        let q = random.configuration(&robot);
        let all = link_poses(&robot, &q, robot.end_effector.max_opening);
        for (link, pose) in all.iter().enumerate() {
            assert!(pose_error(&link_pose(&robot, &q, LinkId::at(link)), pose) < 1e-13, "seed {seed}");
        }
    }
}

#[test]
fn the_jacobian_is_the_derivative_of_the_pose() {
    const STEP: f64 = 1e-5;
    for seed in 0..100 {
        let mut random = Random(1000 + seed);
        let robot = random_tree(&mut random);
        let link = LinkId::at(robot.links.len() - 1);
        let point = Point3::from(random.direction());
        let q = random.configuration(&robot);
        let columns = jacobian(&robot, &q, link, &point);
        assert_eq!(columns.shape(), (6, robot.coordinates.len()));
        let on_chain = chain(&robot, link);
        for i in 0..q.len() {
            let at = |x: f64| {
                let mut q = q.clone();
                q[i] += x;
                link_pose(&robot, &q, link)
            };
            let (before, after) = (at(-STEP), at(STEP));
            let linear = (after * point - before * point) / (2.0 * STEP);
            let angular = (after.rotation * before.rotation.inverse()).scaled_axis() / (2.0 * STEP);
            let error = (columns.fixed_view::<3, 1>(0, i) - linear).norm()
                + (columns.fixed_view::<3, 1>(3, i) - angular).norm();
            assert!(error < 1e-8, "seed {seed}, coordinate {i}: {error}");
            let moves = linear.norm() + angular.norm() > 1e-9;
            assert!(!moves || on_chain.contains(&CoordinateId::at(i)), "seed {seed}, coordinate {i} not on the chain");
        }
    }
}

#[test]
fn a_chain_lists_the_base_first_and_then_joints_outwards() {
    let mut robot = bare("ordered");
    add_base(&mut robot, Pose::identity());
    let early = add_coordinate(&mut robot, [-1.0, 1.0]);
    let late = add_coordinate(&mut robot, [-1.0, 1.0]);
    let z = [0.0, 0.0, 1.0];
    let first = add_joint(&mut robot, LinkId(0), Pose::identity(), revolute(z), late);
    let second = add_joint(&mut robot, first, Pose::identity(), revolute(z), early);
    assert_eq!(chain(&robot, second), [0, 1, 2, 4, 3].map(CoordinateId).to_vec());
    assert_eq!(chain(&robot, LinkId(0)), [0, 1, 2].map(CoordinateId).to_vec());
}
