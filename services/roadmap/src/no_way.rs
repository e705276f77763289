//! Why a mode has no way: the pair at fault, and the poses that together close it.

use std::collections::BTreeSet;

use contract::{CauseTally, Choice, Edge, Obstruction};
use model::PairId;
use plan::{BodyRef, Cause};

use crate::glue::Glue;
use crate::graph::{cost_to_go, least_blockers};

/// Why the goal cannot be reached.
pub(crate) struct NoWay {
    pub(crate) causes: CauseTally,
    /// Choices of which one must change.
    pub(crate) rests_on: Vec<Choice>,
}

impl Glue<'_> {
    /// Why there is no way. The arm that cannot get away from the object, or to it, is the matter of the pair at that end
    /// alone; otherwise it is that of the pairs at both.
    pub(crate) fn no_way(&self, [start, goal]: [usize; 2], stands: [usize; 2], free: &[Edge]) -> NoWay {
        let is_cut = |from: usize, to: usize| !cost_to_go(self.vertices.len(), free, to)[from].is_finite();
        let ends = self.pairs_at_ends();
        let (pairs, [from, to]) = if is_cut(start, stands[0]) {
            (vec![ends[0]], [start, stands[0]])
        } else if is_cut(stands[1], goal) {
            (vec![ends[1]], [stands[1], goal])
        } else {
            (ends.to_vec(), [start, goal])
        };
        let pairs: BTreeSet<PairId> = pairs.into_iter().flatten().collect();
        let poses = self.needed(from, to).into_iter().map(|obstruction| Choice::Pose(obstruction.occupancy));
        let rests_on = pairs.iter().copied().map(Choice::Alternative).chain(poses).collect();
        NoWay { causes: self.causes(&pairs, [from, to]), rests_on }
    }

    /// The pairs whose alternatives decide where the mode begins and ends: a robot's start belongs to none.
    fn pairs_at_ends(&self) -> [Option<PairId>; 2] {
        let step = self.job.mode.step as usize;
        let problem = self.stage.geometry.problem();
        let pair = |number: usize| problem.pairs_of_robot(self.job.mode.robot).nth(number);
        match (step % 2, pair(step / 2)) {
            (0, own) => {
                let previous = (step / 2).checked_sub(1).and_then(pair);
                // A closing return of a robot that stays ends where its last pair does.
                [previous, own.or(previous)]
            }
            (_, own) => [own, own],
        }
    }

    /// The least that has to be away for a way, told for each pair.
    fn causes(&self, pairs: &BTreeSet<PairId>, [from, to]: [usize; 2]) -> CauseTally {
        let problem = self.stage.geometry.problem();
        let all: Vec<&Obstruction> = self.job.possible.iter().chain(&self.job.certain).collect();
        let name = |index: &u32| {
            let object = all[*index as usize].standing.object;
            BodyRef::Object(problem.movable[object.index()].name.clone())
        };
        let blocking = least_blockers(self.vertices.len(), &self.edges, from, to).unwrap_or_default();
        let is_return = self.job.mode.step as usize / 2 == problem.pairs_of_robot(self.job.mode.robot).count();
        let named = pairs.iter().filter(|_| !is_return).map(|pair| Some(problem.pair(*pair).name.clone()));
        let mut named: Vec<Option<String>> = named.collect();
        if named.is_empty() {
            named.push(None);
        }
        let mut causes = CauseTally::default();
        for pair in named {
            let blocking = blocking.iter().map(name).collect();
            causes.count(Cause::NoPath { pair, robot: self.robot.name.clone(), blocking });
        }
        causes
    }

    /// Certain poses that together leave no way: none of them can be spared, though others might do as well.
    fn needed(&self, from: usize, to: usize) -> Vec<&Obstruction> {
        let first = self.job.possible.len() as u32;
        let blocks_some = |index: &u32| self.edges.iter().any(|edge| edge.blockers.contains(index));
        let mut needed: BTreeSet<u32> = (first..first + self.job.certain.len() as u32).filter(blocks_some).collect();
        for index in needed.clone() {
            needed.remove(&index);
            let is_free = |edge: &&Edge| edge.blockers.iter().all(|blocker| !needed.contains(blocker));
            let free: Vec<Edge> = self.edges.iter().filter(is_free).cloned().collect();
            if cost_to_go(self.vertices.len(), &free, to)[from].is_finite() {
                needed.insert(index);
            }
        }
        needed.into_iter().map(|index| &self.job.certain[(index - first) as usize]).collect()
    }
}
