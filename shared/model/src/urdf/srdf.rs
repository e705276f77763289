//! SRDF: what the URDF does not say. Groups, end effector, named configurations, link pairs that are never tested.

use std::collections::BTreeSet;

use roxmltree::Node;

use super::JointDescription;
use super::xml::{attribute, child, children, number, parse, span};
use crate::file::did_you_mean;
use crate::problem_error::{FindingKind, Found, Source, Span};
use crate::{Link, LinkId};

/// What is read of an SRDF, resolved against the URDF.
pub(crate) struct Srdf {
    pub virtual_joint: Option<VirtualJoint>,
    pub end_effector: EndEffectorEntry,
    /// Positions of the joints of the end effector's group, but for those that move its parent link too: they are the arm's,
    /// even where the group lists a link of the arm so that it may touch what the hand holds.
    pub gripper_joints: BTreeSet<usize>,
    /// Positions of the joints of the end effector's parent group; all joints where none is named.
    pub arm_joints: Option<BTreeSet<usize>>,
    pub states: Vec<GroupState>,
    pub disabled: Vec<(LinkId, LinkId)>,
    /// Its root element.
    pub span: Span,
}

/// How the root link is attached to the world.
pub(crate) struct VirtualJoint {
    pub name: String,
    pub planar: bool,
}

/// The hand.
pub(crate) struct EndEffectorEntry {
    pub name: String,
    pub parent_link: LinkId,
    pub links: Vec<LinkId>,
    pub span: Span,
}

/// A named configuration.
pub(crate) struct GroupState {
    pub name: String,
    /// Joint positions and values.
    pub values: Vec<(usize, f64)>,
    pub span: Span,
}

/// A group with its members resolved.
#[derive(Clone, Default)]
struct Group {
    links: BTreeSet<LinkId>,
    joints: BTreeSet<usize>,
}

struct Reader<'a, 'i> {
    source: &'a Source,
    root: Node<'a, 'i>,
    links: &'a [Link],
    joints: &'a [JointDescription],
}

/// Reads an SRDF.
pub(crate) fn srdf(source: &Source, links: &[Link], joints: &[JointDescription]) -> Found<Srdf> {
    let document = parse(source, "SRDF")?;
    let reader = Reader { source, root: document.root_element(), links, joints };
    let entry = reader.end_effector_node()?;
    let gripper = reader.group(attribute(source, entry, "group")?, entry)?;
    let arm_joints = match entry.attribute("parent_group") {
        Some(name) => Some(reader.group(name, entry)?.joints),
        None => None,
    };
    let parent_link = reader.link(entry, "parent_link")?;
    let end_effector = EndEffectorEntry {
        name: attribute(source, entry, "name")?.to_owned(),
        parent_link,
        links: gripper.links.iter().copied().collect(),
        span: span(source, entry),
    };
    Ok(Srdf {
        virtual_joint: reader.virtual_joint()?,
        end_effector,
        gripper_joints: &gripper.joints - &reader.joints_above(parent_link),
        arm_joints,
        states: reader.states()?,
        disabled: reader.disabled()?,
        span: span(source, reader.root),
    })
}

impl<'a, 'i> Reader<'a, 'i> {
    fn bad(&self, node: Node<'_, '_>, message: impl Into<String>) -> Box<crate::Finding> {
        self.source.finding(span(self.source, node), FindingKind::BadRobot, message)
    }

    fn end_effector_node(&self) -> Found<Node<'a, 'i>> {
        let mut nodes = children(self.root, "end_effector");
        let Some(first) = nodes.next() else {
            return Err(self.bad(self.root, "no `<end_effector>`").help(
                "add `<end_effector name=\"...\" parent_link=\"...\" group=\"...\"/>`: robots pick and place with it",
            ));
        };
        match nodes.next() {
            None => Ok(first),
            Some(second) => Err(self
                .bad(second, "a second `<end_effector>`")
                .note(self.source, span(self.source, first), "the first")
                .help("keep the one that the robot picks with")),
        }
    }

    fn virtual_joint(&self) -> Found<Option<VirtualJoint>> {
        let Some(node) = child(self.root, "virtual_joint") else { return Ok(None) };
        let name = attribute(self.source, node, "name")?.to_owned();
        let moved = self.link(node, "child_link")?;
        if moved.index() != 0 {
            return Err(self
                .bad(
                    node,
                    format!("the virtual joint moves `{}`, which is not the root link", self.links[moved.index()].name),
                )
                .help(format!("give child_link=\"{}\"", self.links[0].name)));
        }
        match attribute(self.source, node, "type")? {
            "planar" => Ok(Some(VirtualJoint { name, planar: true })),
            "fixed" => Ok(Some(VirtualJoint { name, planar: false })),
            other => Err(self
                .bad(node, format!("a virtual joint of type {other}"))
                .help("use `planar` for a mobile base, `fixed` for an arm on a stand")),
        }
    }

    fn states(&self) -> Found<Vec<GroupState>> {
        let mut states: Vec<GroupState> = Vec::new();
        for node in children(self.root, "group_state") {
            let name = attribute(self.source, node, "name")?.to_owned();
            let mut values = Vec::new();
            for entry in children(node, "joint") {
                values.push((self.joint(entry, "name")?, number(self.source, entry, "value")?));
            }
            states.push(GroupState { name, values, span: span(self.source, node) });
        }
        Ok(states)
    }

    fn disabled(&self) -> Found<Vec<(LinkId, LinkId)>> {
        let mut pairs = Vec::new();
        for node in children(self.root, "disable_collisions") {
            let (one, other) = (self.link(node, "link1")?, self.link(node, "link2")?);
            if one != other {
                pairs.push((one.min(other), one.max(other)));
            }
        }
        Ok(pairs)
    }

    /// The group called `name`: links, joints, chains and groups that it lists.
    fn group(&self, name: &str, user: Node<'_, '_>) -> Found<Group> {
        let mut group = Group::default();
        let mut pending = vec![(name, user)];
        let mut seen = BTreeSet::new();
        while let Some((name, user)) = pending.pop() {
            if !seen.insert(name) {
                continue;
            }
            for entry in self.group_node(name, user)?.children().filter(Node::is_element) {
                match entry.tag_name().name() {
                    "link" => self.add_link(&mut group, self.link(entry, "name")?),
                    "joint" => self.add_joint(&mut group, self.joint(entry, "name")?),
                    "chain" => self.add_chain(&mut group, entry)?,
                    "group" => pending.push((attribute(self.source, entry, "name")?, entry)),
                    _ => {}
                }
            }
        }
        Ok(group)
    }

    fn group_node(&self, name: &str, user: Node<'_, '_>) -> Found<Node<'a, 'i>> {
        let all = || children(self.root, "group");
        all().find(|node| node.attribute("name") == Some(name)).ok_or_else(|| {
            let known: Vec<&str> = all().filter_map(|node| node.attribute("name")).collect();
            self.source
                .finding(span(self.source, user), FindingKind::UnknownName, format!("no group is called `{name}`"))
                .help(did_you_mean(name, known.into_iter()))
        })
    }

    fn add_link(&self, group: &mut Group, link: LinkId) {
        group.links.insert(link);
        group.joints.extend(self.joints.iter().position(|joint| joint.child == link));
    }

    fn add_joint(&self, group: &mut Group, joint: usize) {
        group.joints.insert(joint);
        group.links.insert(self.joints[joint].child);
    }

    fn add_chain(&self, group: &mut Group, node: Node<'_, '_>) -> Found<()> {
        let (base, tip) = (self.link(node, "base_link")?, self.link(node, "tip_link")?);
        let mut link = tip;
        while link != base {
            let Some(joint) = self.joints.iter().position(|joint| joint.child == link) else {
                return Err(self
                    .bad(node, "no chain of joints leads from the base link to the tip link")
                    .help("`base_link` must be an ancestor of `tip_link`"));
            };
            self.add_joint(group, joint);
            link = self.joints[joint].parent;
        }
        Ok(())
    }

    /// Positions of the joints between the root and a link.
    fn joints_above(&self, link: LinkId) -> BTreeSet<usize> {
        let moves = |link: LinkId| self.joints.iter().position(|joint| joint.child == link);
        std::iter::successors(moves(link), |joint| moves(self.joints[*joint].parent)).collect()
    }

    fn link(&self, node: Node<'_, '_>, name: &str) -> Found<LinkId> {
        let link = attribute(self.source, node, name)?;
        self.links.iter().position(|known| known.name == link).map(LinkId::at).ok_or_else(|| {
            self.source
                .finding(span(self.source, node), FindingKind::UnknownName, format!("the URDF has no link `{link}`"))
                .help(did_you_mean(link, self.links.iter().map(|known| known.name.as_str())))
        })
    }

    fn joint(&self, node: Node<'_, '_>, name: &str) -> Found<usize> {
        let joint = attribute(self.source, node, name)?;
        self.joints.iter().position(|known| known.name == joint).ok_or_else(|| {
            self.source
                .finding(span(self.source, node), FindingKind::UnknownName, format!("the URDF has no joint `{joint}`"))
                .help(did_you_mean(joint, self.joints.iter().map(|known| known.name.as_str())))
        })
    }
}
