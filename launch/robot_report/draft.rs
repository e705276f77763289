//! A guess at what a URDF does not say: which joints are the arm, which links the hand.

use std::collections::BTreeMap;

use model::{JointMotion, LinkId, RobotTree, TreeJoint};

/// Where a chain of at least this many joints splits into short branches, these are fingers.
const SHORTEST_ARM: usize = 3;
/// Most joints of a finger.
const LONGEST_FINGER: usize = 2;

/// What an SRDF would say.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Draft {
    /// Root of the arm's chain.
    pub arm_base: LinkId,
    /// The link that the arm's last joint moves: the end effector's parent link.
    pub arm_tip: LinkId,
    /// Links that may touch what the hand holds: all beyond the arm's last joint, and the arm's last where nothing there moves.
    pub hand: Vec<LinkId>,
    /// A link whose frame looks like the tool frame.
    pub tool: Option<LinkId>,
    /// Hinges of the hand, which need an `open` state.
    pub hinges: Vec<String>,
}

impl Draft {
    /// The guess for a tree; `None` where no joint moves.
    ///
    /// The arm is the chain of joints from the root that always follows the branch with the most, until only fingers are left.
    #[must_use]
    pub fn of(tree: &RobotTree) -> Option<Self> {
        let arm_base = LinkId(0);
        let (mut arm_tip, mut length) = (arm_base, 0);
        loop {
            let next = next_joints(tree, arm_tip);
            let longest = next.iter().map(|joint| moving_joints(tree, joint)).max().unwrap_or(0);
            if longest == 0 || (length >= SHORTEST_ARM && next.len() > 1 && longest <= LONGEST_FINGER) {
                break;
            }
            let Some(followed) = next.iter().find(|joint| moving_joints(tree, joint) == longest) else { break };
            arm_tip = followed.child;
            length += 1;
        }
        if length == 0 {
            return None;
        }
        let beyond = descendants(tree, arm_tip);
        let is_moved = |link: &LinkId| tree.joint_of(*link).is_some_and(|joint| joint.motion != JointMotion::Fixed);
        let rigid = !beyond.iter().any(is_moved);
        let hand = rigid.then_some(arm_tip).into_iter().chain(beyond.iter().copied()).collect();
        let hinges = beyond.iter().filter_map(|link| tree.joint_of(*link)).filter(|joint| is_hinge(joint));
        let hinges = hinges.map(|joint| joint.name.clone()).collect();
        Some(Self { arm_base, arm_tip, hand, tool: tool(tree, arm_tip), hinges })
    }
}

fn is_hinge(joint: &TreeJoint) -> bool {
    matches!(joint.motion, JointMotion::Revolute { .. }) && !joint.mimics
}

/// Moving joints next below a link, over fixed ones.
fn next_joints(tree: &RobotTree, link: LinkId) -> Vec<&TreeJoint> {
    let (mut found, mut pending) = (Vec::new(), vec![link]);
    while let Some(link) = pending.pop() {
        for joint in tree.joints_below(link) {
            if joint.motion == JointMotion::Fixed { pending.push(joint.child) } else { found.push(joint) }
        }
    }
    found
}

/// Joints that move by themselves, from this one on.
fn moving_joints(tree: &RobotTree, joint: &TreeJoint) -> usize {
    let own = usize::from(joint.motion != JointMotion::Fixed && !joint.mimics);
    own + tree.joints_below(joint.child).map(|below| moving_joints(tree, below)).sum::<usize>()
}

/// All links below a link, in the tree's order.
fn descendants(tree: &RobotTree, link: LinkId) -> Vec<LinkId> {
    let mut below = vec![link];
    for joint in &tree.joints {
        if below.contains(&joint.parent) {
            below.push(joint.child);
        }
    }
    below.split_off(1)
}

/// A link fixed to the hand that has no body and a name such as `tool0` or `hand_tcp`; of several the farthest out.
fn tool(tree: &RobotTree, arm_tip: LinkId) -> Option<LinkId> {
    let mut depth = BTreeMap::from([(arm_tip, 0_usize)]);
    for joint in tree.joints.iter().filter(|joint| joint.motion == JointMotion::Fixed) {
        if let Some(above) = depth.get(&joint.parent).copied() {
            depth.insert(joint.child, above + 1);
        }
    }
    let looks_like_one = |link: &LinkId| {
        let link_data = &tree.links[link.index()];
        let name = link_data.name.to_lowercase();
        link_data.bodies.is_empty() && ["tcp", "tool", "grasp"].iter().any(|word| name.contains(word))
    };
    depth.into_iter().filter(|(link, _)| looks_like_one(link)).max_by_key(|(_, depth)| *depth).map(|(link, _)| link)
}

#[cfg(test)]
mod tests {
    use model::{Link, Pose};

    use super::*;

    const Z: [f64; 3] = [0.0, 0.0, 1.0];
    const TURNS: JointMotion = JointMotion::Revolute { axis: Z };
    const SLIDES: JointMotion = JointMotion::Prismatic { axis: Z };

    /// A tree of joints (parent link, motion, whether it mimics); joint i moves link i + 1.
    fn tree(joints: &[(u32, JointMotion, bool)], names: &[(u32, &str)]) -> RobotTree {
        let name =
            |i: u32| names.iter().find(|(link, _)| *link == i).map_or(format!("l{i}"), |(_, name)| (*name).to_owned());
        let count = u32::try_from(joints.len()).unwrap();
        let joint = |(i, (parent, motion, mimics)): (usize, &(u32, JointMotion, bool))| TreeJoint {
            name: format!("j{i}"),
            parent: LinkId(*parent),
            child: LinkId::at(i + 1),
            parent_from_joint: Pose::identity(),
            motion: motion.clone(),
            lower: -1.0,
            upper: 1.0,
            velocity: 1.0,
            mimics: *mimics,
        };
        RobotTree {
            links: (0..=count).map(|i| Link { name: name(i), bodies: Vec::new() }).collect(),
            joints: joints.iter().enumerate().map(joint).collect(),
        }
    }

    fn links(indices: &[u32]) -> Vec<LinkId> {
        indices.iter().map(|i| LinkId(*i)).collect()
    }

    #[test]
    fn two_sliding_fingers_after_three_joints_are_the_hand() {
        let arm = [(0, TURNS, false), (1, TURNS, false), (2, TURNS, false), (3, JointMotion::Fixed, false)];
        let fingers = [(4, SLIDES, false), (4, SLIDES, true), (4, JointMotion::Fixed, false)];
        let draft = Draft::of(&tree(&[arm.as_slice(), &fingers].concat(), &[(7, "hand_tcp")])).unwrap();
        assert_eq!((draft.arm_tip, draft.tool), (LinkId(3), Some(LinkId(7))));
        assert_eq!(draft.hand, links(&[4, 5, 6, 7]), "the arm's last link may not touch: the hand has fingers");
        assert!(draft.hinges.is_empty());
    }

    #[test]
    fn without_fingers_the_last_link_itself_is_the_hand() {
        let arm = [(0, TURNS, false), (1, TURNS, false), (2, JointMotion::Fixed, false)];
        let draft = Draft::of(&tree(&arm, &[(3, "Tool0")])).unwrap();
        assert_eq!((draft.arm_tip, draft.hand, draft.tool), (LinkId(2), links(&[2, 3]), Some(LinkId(3))));
    }

    #[test]
    fn wheels_are_no_arm_and_hinged_fingers_are_told() {
        let base = [(0, TURNS, false), (0, TURNS, false), (0, TURNS, false)];
        let arm = [(3, TURNS, false), (4, TURNS, false), (5, TURNS, false)];
        let fingers = [(6, TURNS, false), (6, TURNS, true)];
        let draft = Draft::of(&tree(&[base.as_slice(), &arm, &fingers].concat(), &[])).unwrap();
        assert_eq!((draft.arm_tip, draft.hand), (LinkId(6), links(&[7, 8])));
        assert_eq!(draft.hinges, ["j6"], "the follower follows");
    }

    #[test]
    fn a_robot_that_cannot_move_has_no_arm() {
        assert_eq!(Draft::of(&tree(&[(0, JointMotion::Fixed, false)], &[])), None);
    }
}
