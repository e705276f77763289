//! The order that a problem gives on the points of its pairs, and what follows from it.

use model::{Gate, ObjectId, PairId, Point, Problem};

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
        gates(problem).for_each(|(before, after)| order.add(before, after));
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

/// Where actions gate one another: for each hop of an object and each listed ordering between two robots, the arm of the
/// first has to be folded after its action before the second robot comes to the stand of its own. A fixed arm has no stand to
/// come to: it may not grasp, or not release.
pub(crate) fn gates(problem: &Problem) -> impl Iterator<Item = (At, At)> + '_ {
    let hops = (0..problem.movable.len()).flat_map(|object| {
        let hops = problem.hops_of_object(ObjectId::at(object));
        hops.windows(2).map(|two| ((two[0], Point::Release), (two[1], Point::Grasp))).collect::<Vec<_>>()
    });
    let listed = problem.orderings.iter().map(|given| (given.before, given.after));
    let between_robots = |(before, after): &(At, At)| problem.pair(before.0).robot != problem.pair(after.0).robot;
    let orderings = hops.chain(listed).filter(between_robots);
    let wanted = problem.settings.gate == Gate::Action;
    let drives = |at: At| problem.robot(problem.pair(at.0).robot).base_len() > 0;
    orderings.filter(move |_| wanted).map(move |(before, after)| gate(before, after, drives(after)))
}

/// The gate of one ordering. Up to `carry` a pair's points belong to its first action, from there on to its second.
fn gate(before: At, after: At, drives: bool) -> (At, At) {
    let is_pick = |point: Point| matches!(point, Point::Start | Point::AtPick | Point::Grasp | Point::Carry);
    let folded = if is_pick(before.1) { Point::Carry } else { Point::Done };
    let arrival = match (is_pick(after.1), drives) {
        (true, true) => Point::AtPick,
        (true, false) => Point::Grasp,
        (false, true) => Point::AtPlace,
        (false, false) => Point::Release,
    };
    ((before.0, folded), (after.0, arrival))
}

fn node((pair, point): At) -> usize {
    pair.index() * Point::ALL.len() + point as usize
}
