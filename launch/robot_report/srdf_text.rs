//! The text of a starting SRDF.

use model::{LinkId, RobotTree};

use super::draft::Draft;

/// Why a pair of links is not tested, in the words of MoveIt's Setup Assistant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
pub enum Reason {
    /// A joint joins them.
    Adjacent,
    /// They touch in practically every configuration.
    Always,
    /// They touch in the configuration `home`.
    Default,
    /// They touch in no configuration: proven.
    Never,
}

/// What a starting SRDF says beyond the groups.
#[derive(Clone, Debug, Default)]
pub struct Entries {
    /// Joint names and values (rad or m) of the group state `home`.
    pub home: Vec<(String, f64)>,
    /// Pairs that are not tested.
    pub pairs: Vec<((LinkId, LinkId), Reason)>,
    /// Whether the root link moves in the plane.
    pub planar_base: bool,
}

/// The SRDF of a draft.
#[must_use]
pub fn srdf_text(name: &str, tree: &RobotTree, draft: &Draft, entries: &Entries) -> String {
    let link = |link: LinkId| escaped(&tree.links[link.index()].name);
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n<!-- A start, as `mrtamp robot` guesses it. Look at the arm's chain, the hand's links, `home`, and what is not tested. -->\n\
         <robot name=\"{}\">\n",
        escaped(name)
    );
    if entries.planar_base {
        text += &format!(
            "  <!-- The base moves in the plane: coordinates base/x, base/y, base/yaw. -->\n  \
             <virtual_joint name=\"base\" type=\"planar\" parent_frame=\"world\" child_link=\"{}\"/>\n\n",
            link(draft.arm_base)
        );
    }
    let (base, tip) = (link(draft.arm_base), link(draft.arm_tip));
    text += &format!("  <group name=\"arm\">\n    <chain base_link=\"{base}\" tip_link=\"{tip}\"/>\n  </group>\n");
    text += "  <!-- The links of this group may touch the object that the hand holds. -->\n  <group name=\"hand\">\n";
    text.extend(draft.hand.iter().map(|hand| format!("    <link name=\"{}\"/>\n", link(*hand))));
    text += &format!(
        "  </group>\n  <end_effector name=\"hand\" parent_link=\"{tip}\" group=\"hand\" parent_group=\"arm\"/>\n\n"
    );
    text += "  <!-- How the arm is folded before the first pair, after the last, and while a base drives. -->\n";
    text += &state("home", "arm", &entries.home);
    if !draft.hinges.is_empty() {
        text += "  <!-- Hinges of the hand always stand like this: give the values at which it is open. -->\n";
        text += &state("open", "hand", &draft.hinges.iter().map(|hinge| (hinge.clone(), 0.0)).collect::<Vec<_>>());
    }
    if !entries.pairs.is_empty() {
        text += "\n  <!-- Not tested against each other. Never: proven for all values within the limits. -->\n";
    }
    for ((first, second), reason) in &entries.pairs {
        text += &format!(
            "  <disable_collisions link1=\"{}\" link2=\"{}\" reason=\"{reason:?}\"/>\n",
            link(*first),
            link(*second)
        );
    }
    text + "</robot>\n"
}

fn state(name: &str, group: &str, joints: &[(String, f64)]) -> String {
    let entry = |(joint, value): &(String, f64)| {
        // Six digits, but nothing that a limit would not allow: they are cut, not rounded.
        let value = (value * 1e6).trunc() / 1e6 + 0.0;
        format!("    <joint name=\"{}\" value=\"{value}\"/>\n", escaped(joint))
    };
    let joints: String = joints.iter().map(entry).collect();
    format!("  <group_state name=\"{name}\" group=\"{group}\">\n{joints}  </group_state>\n")
}

/// Text as it stands in an attribute.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
