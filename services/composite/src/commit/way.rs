//! The way of a mode on which the fewest stand for ever: who has to give way, and what has to be left free.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

use contract::{Interrupted, JobContext, Product};
use model::RobotId;

use crate::sipp::{Blocker, ModeGraph, Traffic};
use crate::{Timeline, Travel};

use super::CommitJob;

/// A way from a mode's start to its goal.
pub(super) struct Way {
    /// Its motions; standing, if it begins at the goal.
    pub travels: Vec<Travel>,
    /// Who stands on it for ever.
    pub blockers: BTreeSet<Blocker>,
}

/// How good a way is: how many are in it, then how long it takes (bits of seconds, which order as the seconds do).
type Cost = (usize, u64);

/// The best way known to a vertex.
#[derive(Clone)]
struct Reached {
    cost: Cost,
    /// The vertex before it, and the edge from there.
    came: Option<(usize, usize)>,
    blockers: BTreeSet<Blocker>,
}

impl CommitJob<'_> {
    /// The way with few distinct blockers, then short; `None` if the roadmap does not connect. Greedy minimum constraint
    /// removal (Hauser, doi:10.1177/0278364913507795). Whoever is `ignored` is in nobody's way.
    pub(super) fn least_obstructed(
        &self,
        graph: &ModeGraph<'_>,
        traffic: &Traffic<'_>,
        ignored: Option<RobotId>,
    ) -> Option<Way> {
        let (start, goal) = (graph.roadmap.start, graph.roadmap.goal);
        let conflicts = &self.scene.conflicts;
        let in_the_way = |travel: &Travel| {
            let mut blockers = traffic.for_ever(travel);
            blockers.retain(|blocker| ignored.is_none() || blocker.robot() != ignored);
            blockers
        };
        let mut known: BTreeMap<usize, BTreeSet<Blocker>> = BTreeMap::new();
        let stand = graph.stand(start, conflicts);
        let mut reached: Vec<Option<Reached>> = vec![None; graph.len()];
        let first = in_the_way(&stand);
        let mut queue = BinaryHeap::from([Reverse(((first.len(), 0_u64), start.index(), None, first))]);
        while let Some(Reverse((cost, vertex, came, blockers))) = queue.pop() {
            if reached[vertex].as_ref().is_some_and(|known| known.cost <= cost) {
                continue;
            }
            reached[vertex] = Some(Reached { cost, came, blockers: blockers.clone() });
            if vertex == goal.index() {
                break;
            }
            for hop in graph.hops(contract::VertexId::at(vertex)) {
                let on_edge =
                    known.entry(hop.edge).or_insert_with(|| in_the_way(&conflicts.travel(&graph.motion(hop.edge))));
                let all: BTreeSet<Blocker> = blockers.union(on_edge).copied().collect();
                let time_s = f64::from_bits(cost.1) + graph.duration_s(hop.edge);
                let next = ((all.len(), time_s.to_bits()), hop.to.index(), Some((vertex, hop.edge)), all);
                queue.push(Reverse(next));
            }
        }
        let blockers = reached[goal.index()].as_ref()?.blockers.clone();
        let (mut travels, mut at) = (vec![stand], goal.index());
        while let Some(Reached { came: Some((before, edge)), .. }) = reached[at].as_ref() {
            travels.push(conflicts.travel(&graph.motion(*edge)));
            at = *before;
        }
        Some(Way { travels, blockers })
    }

    /// Those who stand for ever where the robot has to pass, or where it would be after its event: where nobody can get past
    /// them, nobody else is to blame. `None` if there are none.
    pub(super) fn for_ever_in_the_way(
        &self,
        graph: &ModeGraph<'_>,
        next: Option<&ModeGraph<'_>>,
        traffic: &Traffic<'_>,
    ) -> Option<Vec<Blocker>> {
        let mut blockers = self.least_obstructed(graph, traffic, None)?.blockers;
        if let (true, Some(next)) = (blockers.is_empty(), next) {
            blockers = traffic.for_ever(&next.stand(next.roadmap.start, &self.scene.conflicts));
        }
        (!blockers.is_empty()).then(|| blockers.into_iter().collect())
    }

    /// Motions that the robot should not park in the way of.
    pub(super) fn ways_to_leave_free(
        &self,
        timeline: &Timeline,
        context: &JobContext<'_>,
    ) -> Result<Vec<Travel>, Interrupted> {
        let mut travels = Vec::new();
        for wanted in self.clear_of {
            let Product::Mode(roadmap) = context.product(wanted)? else {
                return Err(Interrupted::Unfit("a way to be left free that is no roadmap of a mode".into()));
            };
            let robot = roadmap.mode.robot;
            let robots = &self.scene.problem().robots;
            let model = robots.get(robot.index()).filter(|_| robot != self.mode.robot);
            let model = model.ok_or_else(|| Interrupted::Unfit("a way to be left free is of no other robot".into()))?;
            let graph = ModeGraph::new(model, roadmap).map_err(Interrupted::Unfit)?;
            let since_s = timeline.robot(robot).event_s();
            let traffic = Traffic::new(&self.scene.conflicts, timeline, robot, since_s);
            let way = self.least_obstructed(&graph, &traffic, Some(self.mode.robot));
            travels.extend(way.into_iter().flat_map(|way| way.travels));
        }
        Ok(travels)
    }
}
