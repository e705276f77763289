//! The kinematic tree of a URDF: one root, no cycles, unique names.

use std::collections::BTreeMap;

use roxmltree::Node;

use super::xml::{attribute, child, span};
use crate::problem_error::{Finding, FindingKind, Found, Source, Span};

/// Links and joints by position in the file, in an order in which parents come first.
pub(crate) struct Tree {
    /// Positions of links; the root first.
    pub links: Vec<usize>,
    /// Position of each joint with the positions of its parent and child link; after the joint that moves its parent.
    pub joints: Vec<(usize, usize, usize)>,
}

/// Orders links and joints as a tree.
pub(crate) fn tree(source: &Source, links: &[Node<'_, '_>], joints: &[Node<'_, '_>]) -> Found<Tree> {
    let index = names(source, links, "link")?;
    names(source, joints, "joint")?;
    let mut parent_joint: Vec<Option<usize>> = vec![None; links.len()];
    // Of each joint, the link that it hangs on.
    let mut joint_parents = Vec::with_capacity(joints.len());
    let mut child_joints: Vec<Vec<(usize, usize)>> = vec![Vec::new(); links.len()];
    for (position, joint) in joints.iter().enumerate() {
        let parent = end(source, *joint, "parent", &index)?;
        let moved = end(source, *joint, "child", &index)?;
        if let Some(other) = parent_joint[moved] {
            return Err(source
                .finding(span(source, *joint), FindingKind::BadRobot, "a second joint with the same child link")
                .note(source, span(source, joints[other]), "the first")
                .help("every link has one parent: robots with closed chains cannot be planned for"));
        }
        parent_joint[moved] = Some(position);
        joint_parents.push(parent);
        child_joints[parent].push((position, moved));
    }
    let parent_of = |link: usize| parent_joint[link].map(|joint| (joint, joint_parents[joint]));
    let Some(root) = root(source, links, &parent_joint)? else { return Err(cycle(source, joints, 0, &parent_of)) };
    let tree = walk(root, &child_joints);
    if tree.links.len() < links.len() {
        let reached = |position: &usize| tree.links.contains(position);
        let lost = (0..links.len()).find(|position| !reached(position)).unwrap_or(0);
        return Err(cycle(source, joints, lost, &parent_of));
    }
    Ok(tree)
}

fn names<'a>(source: &Source, nodes: &[Node<'a, '_>], what: &str) -> Found<BTreeMap<&'a str, usize>> {
    let mut index = BTreeMap::new();
    for (position, node) in nodes.iter().enumerate() {
        let name = attribute(source, *node, "name")?;
        if let Some(first) = index.insert(name, position) {
            return Err(source
                .finding(span(source, *node), FindingKind::BadRobot, format!("two {what}s are called `{name}`"))
                .note(source, span(source, nodes[first]), "the other")
                .help("rename one of them"));
        }
    }
    Ok(index)
}

fn end(source: &Source, joint: Node<'_, '_>, tag: &'static str, index: &BTreeMap<&str, usize>) -> Found<usize> {
    let Some(node) = child(joint, tag) else {
        return Err(source
            .finding(span(source, joint), FindingKind::BadRobot, format!("a joint without `<{tag}>`"))
            .help(format!("add `<{tag} link=\"...\"/>`")));
    };
    let name = attribute(source, node, "link")?;
    index.get(name).copied().ok_or_else(|| {
        source
            .finding(span(source, node), FindingKind::UnknownName, format!("no link is called `{name}`"))
            .help(crate::file::did_you_mean(name, index.keys().copied()))
    })
}

/// The cycle that is met on the way up from a link without a root above it.
fn cycle(
    source: &Source,
    joints: &[Node<'_, '_>],
    from: usize,
    parent_of: &dyn Fn(usize) -> Option<(usize, usize)>,
) -> Box<Finding> {
    let (mut way, mut link) = (Vec::new(), from);
    while let Some((joint, parent)) = parent_of(link) {
        if let Some(start) = way.iter().position(|(_, known)| *known == link) {
            way.drain(..start);
            break;
        }
        way.push((joint, link));
        link = parent;
    }
    let name = |(joint, _): &(usize, usize)| joints[*joint].attribute("name").unwrap_or_default().trim().to_owned();
    let mut names: Vec<String> = way.iter().rev().map(name).collect();
    names.extend(names.first().cloned());
    let at = way.last().map_or(Span { offset: 0, len: 0 }, |(joint, _)| span(source, joints[*joint]));
    source
        .finding(at, FindingKind::BadRobot, format!("joints form a cycle: {}", names.join(" → ")))
        .help("joints must form a tree: correct the `<parent>` or `<child>` of one of them")
}

/// The only link that no joint moves; `None` if every link is moved.
fn root(source: &Source, links: &[Node<'_, '_>], parent_joint: &[Option<usize>]) -> Found<Option<usize>> {
    let mut roots = (0..links.len()).filter(|position| parent_joint[*position].is_none());
    let Some(first) = roots.next() else { return Ok(None) };
    match roots.next() {
        None => Ok(Some(first)),
        Some(second) => Err(source
            .finding(
                span(source, links[second]),
                FindingKind::BadRobot,
                "a second root: no joint has this link as its child",
            )
            .note(source, span(source, links[first]), "the first root")
            .help("join the two with a joint, or remove one")),
    }
}

fn walk(root: usize, child_joints: &[Vec<(usize, usize)>]) -> Tree {
    let mut tree = Tree { links: vec![root], joints: Vec::new() };
    let mut pending = vec![root];
    while let Some(parent) = pending.pop() {
        for (joint, child) in &child_joints[parent] {
            tree.links.push(*child);
            tree.joints.push((*joint, parent, *child));
        }
        pending.extend(child_joints[parent].iter().rev().map(|(_, child)| *child));
    }
    tree
}
