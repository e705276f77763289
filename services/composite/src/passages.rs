//! `Passages` jobs: modes that cannot be done because of one other robot, wherever that is meanwhile.
//!
//! A mode needs a way on its roadmap from start to goal. A cell of that way can be travelled only while the other robot is
//! somewhere on the roadmaps of the modes that may overlap with this one. If each of the cells there conflicts with it, the
//! way is closed. This leaves out that the other robot must be able to get there, third robots, and objects: what it finds
//! is sound, for composite motion of any kind, and it finds not all.

use std::cell::Cell;
use std::collections::BTreeSet;

use contract::{Answer, Assignment, Interrupted, JobContext, Outcome, ProductRef, VertexId};
use model::RobotId;
use skeleton::{EventGraph, Interval, Mode, ModeId};

use crate::sipp::ModeGraph;
use crate::{Conflicts, Scene, Travel};

/// What to look at.
pub(crate) struct PassagesJob<'a> {
    pub scene: &'a Scene,
    pub assignment: &'a Assignment,
    pub roadmaps: &'a [Vec<ProductRef>],
}

/// All motion of one robot in a stretch of time.
struct Whereabouts {
    interval: Interval,
    travels: Vec<Travel>,
}

/// Where another robot may be during one mode.
struct Elsewhere<'a> {
    conflicts: &'a Conflicts,
    stretches: Vec<&'a Whereabouts>,
    /// The motion and cell that was out of the way last: likely it is again.
    last: Cell<Option<(Travel, u32)>>,
}

impl PassagesJob<'_> {
    /// Modes without a passage; those found so far if the budget ends.
    pub fn answer(&self, context: &mut JobContext<'_>) -> Result<Outcome, Interrupted> {
        let order = self.scene.graph(self.assignment)?;
        let graphs = self.graphs(context)?;
        let whereabouts: Vec<Vec<Whereabouts>> =
            (0..graphs.len()).map(|robot| self.whereabouts(robot, &graphs[robot])).collect();
        let mut found: Vec<(ModeId, RobotId)> = Vec::new();
        for (robot, graphs) in graphs.iter().enumerate() {
            for (mode, graph) in self.scene.skeleton.modes[robot].iter().zip(graphs) {
                let others = (0..whereabouts.len()).filter(|other| *other != robot);
                for other in others {
                    let elsewhere = self.elsewhere(&whereabouts[other], mode, &order);
                    match elsewhere.leaves_way(graph, context)? {
                        None => return Ok(Outcome::answer(Answer::NoPassage(found), context.spent())),
                        Some(true) => {}
                        Some(false) => {
                            found.push((mode.id, RobotId::at(other)));
                            break;
                        }
                    }
                }
            }
        }
        Ok(Outcome::answer(Answer::NoPassage(found), context.spent()))
    }

    fn graphs(&self, context: &JobContext<'_>) -> Result<Vec<Vec<ModeGraph<'_>>>, Interrupted> {
        let of_all = &self.scene.skeleton.modes;
        let fits = self.roadmaps.len() == of_all.len();
        if !fits || self.roadmaps.iter().zip(of_all).any(|(roadmaps, modes)| roadmaps.len() != modes.len()) {
            return Err(Interrupted::Unfit("not one roadmap for each mode".into()));
        }
        let load =
            |(mode, product): (&Mode, &ProductRef)| self.scene.mode_graph(self.assignment, mode, product, context);
        of_all
            .iter()
            .zip(self.roadmaps)
            .map(|(modes, products)| modes.iter().zip(products).map(load).collect())
            .collect()
    }

    /// A robot in each of its modes, and where it stands without any or after the last.
    fn whereabouts(&self, robot: usize, graphs: &[ModeGraph<'_>]) -> Vec<Whereabouts> {
        let conflicts = &self.scene.conflicts;
        let modes = &self.scene.skeleton.modes[robot];
        let in_mode = |(mode, graph): (&Mode, &ModeGraph<'_>)| {
            let reached = reached_from_start(graph);
            let stands = (0..graph.len()).filter(|v| reached[*v]).map(|v| graph.stand(VertexId::at(v), conflicts));
            let edges = (0..graph.roadmap.edges.len()).filter(|edge| reached[graph.roadmap.edges[*edge].a.index()]);
            let edges = edges.map(|edge| conflicts.travel(&graph.motion(edge)));
            Whereabouts { interval: mode.interval(), travels: stands.chain(edges).collect() }
        };
        let mut all: Vec<Whereabouts> = modes.iter().zip(graphs).map(in_mode).collect();
        if modes.last().is_none_or(|last| last.ends.is_some()) {
            let at = graphs.last().map(|graph| graph.vertex(graph.roadmap.goal).clone());
            let q = at.unwrap_or_else(|| self.scene.problem().robots[robot].start.clone());
            let (id, allowed) = (RobotId::at(robot), Default::default());
            let stand = collision::Motion { robot: id, holding: None, from: q.clone(), to: q, allowed };
            let interval = Interval { from: modes.last().and_then(|last| last.ends), to: None };
            all.push(Whereabouts { interval, travels: vec![conflicts.travel(&stand)] });
        }
        all
    }

    fn elsewhere<'a>(&'a self, of_other: &'a [Whereabouts], mode: &Mode, order: &EventGraph) -> Elsewhere<'a> {
        let meanwhile = of_other.iter().filter(|stretch| order.may_overlap(stretch.interval, mode.interval()));
        Elsewhere { conflicts: &self.scene.conflicts, stretches: meanwhile.collect(), last: Cell::new(None) }
    }
}

/// The vertices that are connected with the start.
fn reached_from_start(graph: &ModeGraph<'_>) -> Vec<bool> {
    let mut reached = vec![false; graph.len()];
    let mut open = vec![graph.roadmap.start];
    while let Some(vertex) = open.pop() {
        if !std::mem::replace(&mut reached[vertex.index()], true) {
            open.extend(graph.hops(vertex).iter().map(|hop| hop.to));
        }
    }
    reached
}

impl Elsewhere<'_> {
    /// Whether there is a way from a mode's start to its goal all of whose cells can be travelled at some time; `None` if the
    /// budget ends first.
    fn leaves_way(&self, graph: &ModeGraph<'_>, context: &mut JobContext<'_>) -> Result<Option<bool>, Interrupted> {
        let (start, goal) = (graph.roadmap.start, graph.roadmap.goal);
        let to_go_s = graph.times_to(goal);
        if !self.can_avoid(&graph.stand(start, self.conflicts)) {
            return Ok(Some(false));
        }
        let mut reached = vec![false; graph.len()];
        // Nearest to the goal first; bits of non-negative numbers order as the numbers do.
        let mut open = BTreeSet::from([(to_go_s[start.index()].to_bits(), start)]);
        reached[start.index()] = true;
        while let Some((_, vertex)) = open.pop_first() {
            if vertex == goal {
                return Ok(Some(true));
            }
            for hop in graph.hops(vertex) {
                if reached[hop.to.index()] {
                    continue;
                }
                if !context.spend(1)? {
                    return Ok(None);
                }
                if self.can_avoid(&self.conflicts.travel(&graph.motion(hop.edge))) {
                    reached[hop.to.index()] = true;
                    open.insert((to_go_s[hop.to.index()].to_bits(), hop.to));
                }
            }
        }
        Ok(Some(false))
    }

    /// Whether the other robot can be out of the way of each cell of a motion.
    fn can_avoid(&self, travel: &Travel) -> bool {
        (0..travel.cells).all(|cell| {
            let is_free =
                |(other, other_cell): &(Travel, u32)| !self.conflicts.cells_conflict(travel, cell, other, *other_cell);
            if self.last.get().is_some_and(|last| is_free(&last)) {
                return true;
            }
            let travels = self.stretches.iter().flat_map(|stretch| &stretch.travels);
            let cells = travels.flat_map(|travel| (0..travel.cells).map(|cell| (*travel, cell)));
            let found = { cells }.find(is_free);
            self.last.set(found.or(self.last.get()));
            found.is_some()
        })
    }
}
