//! The kinematic tree of a URDF: one root, no cycles, unique names.

use std::collections::BTreeMap;

use roxmltree::Node;

use super::xml::{attribute, child, span};
use crate::problem_error::{FindingKind, Found, Source};

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
        child_joints[parent].push((position, moved));
    }
    let root = root(source, links, &parent_joint)?;
    let tree = walk(root, &child_joints);
    if tree.links.len() < links.len() {
        let reached = |position: &usize| tree.links.contains(position);
        let lost = (0..links.len()).find(|position| !reached(position)).unwrap_or(0);
        return Err(source
            .finding(span(source, links[lost]), FindingKind::BadRobot, "this link's joints form a cycle")
            .help("joints must form a tree"));
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

fn root(source: &Source, links: &[Node<'_, '_>], parent_joint: &[Option<usize>]) -> Found<usize> {
    let mut roots = (0..links.len()).filter(|position| parent_joint[*position].is_none());
    let Some(first) = roots.next() else {
        let finding = crate::Finding::of_file(&source.path, FindingKind::BadRobot, "no root link");
        return Err(finding.help("exactly one link must not be the child of any joint"));
    };
    match roots.next() {
        None => Ok(first),
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
