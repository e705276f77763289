//! The order that a problem gives on the points of its pairs, and what follows from it.

use model::{ObjectId, PairId, Point, Problem};

/// A point of a pair.
pub(crate) type At = (PairId, Point);

/// Strict orderings between points.
#[derive(Clone)]
pub(crate) struct Precedence {
    /// For each point, the points that some ordering puts directly after it.
    next: Vec<Vec<usize>>,
}

impl Precedence {
    /// Each robot's points in order, each object's hops, and the listed orderings.
    pub(crate) fn given(problem: &Problem) -> Self {
        let mut order = Self { next: vec![Vec::new(); problem.pairs.len() * Point::ALL.len()] };
        for robot in problem.robot_ids() {
            let points = problem.pairs_of_robot(robot).flat_map(|pair| Point::ALL.map(|point| (pair, point)));
            let points: Vec<At> = points.collect();
            points.windows(2).for_each(|step| order.add(step[0], step[1]));
        }
        for object in (0..problem.movable.len()).map(ObjectId::at) {
            for hops in problem.hops_of_object(object).windows(2) {
                order.add((hops[0], Point::Release), (hops[1], Point::Grasp));
            }
        }
        problem.orderings.iter().for_each(|given| order.add(given.before, given.after));
        order
    }

    pub(crate) fn add(&mut self, before: At, after: At) {
        self.next[node(before)].push(node(after));
    }

    /// Whether `a` comes strictly before `b`.
    pub(crate) fn precedes(&self, a: At, b: At) -> bool {
        let (mut seen, mut open) = (vec![false; self.next.len()], vec![node(a)]);
        while let Some(at) = open.pop() {
            for next in self.next[at].iter().copied() {
                if next == node(b) {
                    return true;
                }
                if !std::mem::replace(&mut seen[next], true) {
                    open.push(next);
                }
            }
        }
        false
    }
}

fn node((pair, point): At) -> usize {
    pair.index() * Point::ALL.len() + point as usize
}
