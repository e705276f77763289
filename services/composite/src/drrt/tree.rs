//! The search tree: states with their best known parents.

use std::collections::BTreeMap;

use super::mode_vector::VectorId;
use super::rules::{Act, State};

/// A node's number.
pub(super) type NodeId = usize;

/// How a node is reached: from its parent, by what each robot does, in a time (s).
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub parent: NodeId,
    pub acts: Vec<Act>,
    pub duration_s: f64,
}

/// A state that has been reached.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub state: State,
    /// None: the root.
    pub entry: Option<Entry>,
    /// Time since the root (s).
    pub cost_s: f64,
    children: Vec<NodeId>,
}

/// All nodes, by number, by state, and by mode vector.
#[derive(Debug)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    known: BTreeMap<State, NodeId>,
    by_vector: BTreeMap<VectorId, Vec<NodeId>>,
}

impl Tree {
    /// A tree with its root, node 0.
    pub fn new(root: State) -> Self {
        let mut tree = Self { nodes: Vec::new(), known: BTreeMap::new(), by_vector: BTreeMap::new() };
        tree.push(root, None, 0.0);
        tree
    }

    pub fn get(&self, node: NodeId) -> &Node {
        &self.nodes[node]
    }

    /// The node of a state.
    pub fn find(&self, state: &State) -> Option<NodeId> {
        self.known.get(state).copied()
    }

    /// Nodes of a mode vector, oldest first.
    pub fn in_vector(&self, vector: VectorId) -> &[NodeId] {
        self.by_vector.get(&vector).map_or(&[], Vec::as_slice)
    }

    /// Mode vectors reached, in order of their numbers.
    pub fn vectors(&self) -> impl Iterator<Item = VectorId> + '_ {
        self.by_vector.keys().copied()
    }

    /// Adds a state that is not yet there.
    pub fn add(&mut self, state: State, entry: Entry) -> NodeId {
        let cost_s = self.nodes[entry.parent].cost_s + entry.duration_s;
        let parent = entry.parent;
        let node = self.push(state, Some(entry), cost_s);
        self.nodes[parent].children.push(node);
        node
    }

    fn push(&mut self, state: State, entry: Option<Entry>, cost_s: f64) -> NodeId {
        let node = self.nodes.len();
        self.by_vector.entry(state.vector).or_default().push(node);
        self.known.insert(state.clone(), node);
        self.nodes.push(Node { state, entry, cost_s, children: Vec::new() });
        node
    }

    /// Whether an entry would make a node cheaper. An ancestor never becomes cheaper through a descendant, so no
    /// cycle can close.
    pub fn is_cheaper(&self, node: NodeId, parent: NodeId, duration_s: f64) -> bool {
        self.nodes[parent].cost_s + duration_s < self.nodes[node].cost_s
    }

    /// Enters a node in another way if that is cheaper; its descendants get cheaper with it.
    pub fn rewire(&mut self, node: NodeId, entry: Entry) {
        if !self.is_cheaper(node, entry.parent, entry.duration_s) {
            return;
        }
        let Some(old) = self.nodes[node].entry.take() else { return };
        self.nodes[old.parent].children.retain(|child| *child != node);
        self.nodes[entry.parent].children.push(node);
        self.nodes[node].entry = Some(entry);
        let mut cheaper = vec![node];
        while let Some(node) = cheaper.pop() {
            if let Some(entry) = &self.nodes[node].entry {
                self.nodes[node].cost_s = self.nodes[entry.parent].cost_s + entry.duration_s;
            }
            cheaper.extend_from_slice(&self.nodes[node].children);
        }
    }

    /// From the root to a node: what was done at each step.
    pub fn path_to(&self, node: NodeId) -> Vec<Vec<Act>> {
        let mut acts = Vec::new();
        let mut at = node;
        while let Some(entry) = &self.nodes[at].entry {
            acts.push(entry.acts.clone());
            at = entry.parent;
        }
        acts.reverse();
        acts
    }
}
