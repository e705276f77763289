//! Commits one mode: safe-interval search to its event, with a safe tail behind it.

mod causes;
mod gates;
mod moves;
mod tail;
mod way;

use contract::{
    Answer, Assignment, CauseTally, Commitment, EdgeKind, Interrupted, JobContext, Move, Outcome, Prefix, Product,
    ProductRef, VertexId,
};
use plan::Cause;
use skeleton::{Mode, ModeId};

pub(crate) use causes::causes_of;
pub(crate) use gates::Orders;
pub(crate) use moves::Mover;

use crate::points::same_configuration;
use crate::sipp::{Gates, ModeGraph, Search, Traffic};
use crate::{Scene, Timeline, load_prefix};

/// Time (s) for an event where the robot is already: it must come strictly after what it waits for.
pub(crate) const INSTANT_S: f64 = 1e-6;
/// Gap in time (s) kept from motions that a placed object would be in the way of.
pub(crate) const GAP_S: f64 = 2e-9;

/// What to commit, and what is known.
pub(crate) struct CommitJob<'a> {
    pub scene: &'a Scene,
    pub assignment: &'a Assignment,
    pub prefix: Option<ProductRef>,
    pub mode: ModeId,
    pub roadmap: ProductRef,
    pub next_roadmap: Option<ProductRef>,
    /// Roadmaps of modes that the tail should not end in the way of.
    pub clear_of: &'a [ProductRef],
}

/// Where a search begins.
struct Start {
    vertex: VertexId,
    /// Since when the robot stands there (s).
    since_s: f64,
    /// Moves up to there.
    mover: Mover,
}

/// Why a mode was not committed.
enum Unreached {
    Interrupted(Interrupted),
    Because(Vec<Cause>),
}

impl From<Interrupted> for Unreached {
    fn from(interrupted: Interrupted) -> Self {
        Self::Interrupted(interrupted)
    }
}

impl CommitJob<'_> {
    /// The longer prefix, or who is in the way.
    pub fn answer(&self, context: &mut JobContext<'_>) -> Result<Outcome, Interrupted> {
        let timeline = Timeline::new(self.scene, self.assignment, load_prefix(context, self.prefix)?)?;
        let mode = self.mode(&timeline)?;
        match self.commit(&mode, &timeline, context) {
            Ok(commitment) => {
                let event_s = commitment.event_s;
                let tail_s = commitment.tail.last().map_or(event_s, |last| last.ends_s);
                let prefix = Prefix { parent: self.prefix, commitments: vec![commitment], tails: Vec::new() };
                let prefix = context.publish(&Product::Prefix(prefix))?;
                Ok(Outcome::answer(Answer::Committed { prefix, event_s, tail_s }, context.spent()))
            }
            Err(Unreached::Interrupted(interrupted)) => Err(interrupted),
            Err(Unreached::Because(causes)) => {
                let mut tally = CauseTally::default();
                causes.into_iter().for_each(|cause| tally.count(cause));
                Ok(Outcome::soft_failure(tally, 0, context.spent()))
            }
        }
    }

    /// The mode, which must be its robot's next.
    fn mode(&self, timeline: &Timeline) -> Result<Mode, Interrupted> {
        let modes = self.scene.skeleton.modes.get(self.mode.robot.index());
        let mode = modes.and_then(|modes| modes.get(self.mode.step as usize));
        let mode = *mode.ok_or_else(|| Interrupted::Unfit(format!("there is no mode {:?}", self.mode)))?;
        let committed = timeline.robot(self.mode.robot).commitments.len();
        if self.mode.step as usize != committed {
            return Err(Interrupted::Unfit(format!("mode {:?} is not its robot's next: {committed} is", self.mode)));
        }
        if mode.ends.is_some() != self.next_roadmap.is_some() {
            return Err(Interrupted::Unfit(
                "a mode that ends with an event needs the next roadmap, no other does".into(),
            ));
        }
        Ok(mode)
    }

    fn commit(&self, mode: &Mode, timeline: &Timeline, context: &mut JobContext<'_>) -> Result<Commitment, Unreached> {
        let graph = self.scene.mode_graph(self.assignment, mode, &self.roadmap, context)?;
        let order = self.scene.graph(self.assignment)?;
        let orders = Orders { scene: self.scene, graph: &order, timeline };
        if let Some(event) = orders.lacks_event(mode) {
            let event = event.describe(self.scene.problem());
            return Err(Interrupted::Unfit(format!("{event} comes before and is not committed")).into());
        }
        let gates = orders.gates(mode).map_err(|robots| Unreached::Because(vec![self.deadlock(&robots)]))?;
        let start = self.start(mode, &graph, &orders)?;
        let own = timeline.robot(mode.id.robot);
        let traffic = Traffic::new(&self.scene.conflicts, timeline, mode.id.robot, own.event_s());
        let gates = self.settle_gates(mode, gates, &graph, &traffic, &start)?;
        let next_mode = self.scene.skeleton.modes[mode.id.robot.index()].get(mode.id.step as usize + 1);
        let next = match (&self.next_roadmap, next_mode) {
            (Some(next), Some(next_mode)) => Some(self.scene.mode_graph(self.assignment, next_mode, next, context)?),
            _ => None,
        };
        self.search(mode, &graph, next.as_ref(), &traffic, timeline, gates, start, context)
    }

    /// Where the search begins: after the hand's pause, or after the part of the tail that others count on.
    fn start(&self, mode: &Mode, graph: &ModeGraph<'_>, orders: &Orders<'_>) -> Result<Start, Interrupted> {
        let own = orders.timeline.robot(mode.id.robot);
        let start = graph.roadmap.start;
        let Some(last) = own.commitments.last() else {
            return begin_at(graph, start, 0.0, Mover::new(graph.robot.start.clone(), 0.0));
        };
        let event_at = last.moves.last().map_or_else(|| graph.robot.start.clone(), |step| step.to.clone());
        let frozen = orders.frozen_len(mode, &last.tail);
        let mut mover = Mover::new(event_at, last.event_s);
        if frozen > 0 {
            mover.moves = last.tail[..frozen].to_vec();
            if let Some(step) = mover.moves.last() {
                (mover.at, mover.time_s) = (step.to.clone(), step.ends_s);
            }
            let vertex = graph.vertex_at(&mover.at);
            let vertex = vertex.ok_or_else(|| Interrupted::Unfit("the tail does not end on the roadmap".into()))?;
            return begin_at(graph, vertex, mover.time_s, mover);
        }
        if mode.begins.is_some() {
            let until_s = mover.time_s + self.scene.problem().settings.grip_time;
            mover.stand(until_s, EdgeKind::Arm, graph.allowed_at(start));
        }
        begin_at(graph, start, last.event_s, mover)
    }

    /// Adds what depends on where the mode begins and ends.
    fn settle_gates(
        &self,
        mode: &Mode,
        mut gates: Gates,
        graph: &ModeGraph<'_>,
        traffic: &Traffic<'_>,
        start: &Start,
    ) -> Result<Gates, Unreached> {
        if graph.same_stand(start.vertex, graph.roadmap.goal) {
            gates.fold_s = gates.fold_s.max(gates.arrive_s);
        }
        // An arm that is folded already cannot be folded later.
        if gates.fold_s >= start.mover.time_s && (mode.begins.is_none() || graph.is_folded(start.vertex)) {
            return Err(Unreached::Because(vec![self.deadlock(&[])]));
        }
        if let Some((ends_s, robot)) =
            self.scene.placed(self.assignment, mode)?.and_then(|placed| traffic.last_through(&placed))
        {
            if ends_s == f64::INFINITY {
                return Err(Unreached::Because(vec![self.deadlock(&[robot])]));
            }
            gates.goal_s = gates.goal_s.max(ends_s + GAP_S);
        }
        Ok(gates)
    }

    fn search(
        &self,
        mode: &Mode,
        graph: &ModeGraph<'_>,
        next: Option<&ModeGraph<'_>>,
        traffic: &Traffic<'_>,
        timeline: &Timeline,
        gates: Gates,
        start: Start,
        context: &mut JobContext<'_>,
    ) -> Result<Commitment, Unreached> {
        let goal = graph.roadmap.goal;
        let conflicts = &self.scene.conflicts;
        let bound_s = graph.times_to(goal);
        let Start { vertex, since_s, mover: before } = start;
        let mut search = Search::new(graph, traffic, conflicts, gates, bound_s, (vertex, since_s, before.time_s));
        let leave_free = self.ways_to_leave_free(timeline, context)?;
        let mut in_the_way = Vec::new();
        while let Some(index) = search.next() {
            self.spend(context)?;
            let state = search.state(index);
            if state.vertex != goal {
                continue;
            }
            let (path, interval) = (search.path(index), search.interval(&state));
            let mut mover = before.clone();
            mover.follow(graph, &path);
            if mode.ends.is_some() && path.is_empty() {
                let begins_s = state.time_s.max(gates.goal_s);
                mover.stand(begins_s, EdgeKind::Arm, graph.allowed_at(goal));
                mover.stand(begins_s + INSTANT_S, EdgeKind::Arm, graph.allowed_at(goal));
            }
            if !interval.contains(mover.time_s) {
                continue;
            }
            let Some(next) = next else {
                if interval.until_s == f64::INFINITY {
                    let (holding, event_s) = (graph.roadmap.holding, mover.time_s);
                    let (moves, tail) = (mover.moves, Vec::new());
                    return Ok(Commitment { mode: mode.id, holding, moves, event_s, tail, tail_holding: holding });
                }
                continue;
            };
            let after = self.traffic_after(mode, timeline, mover.time_s)?;
            if let Some(tail) = self.tail(next, &after, &leave_free, &mover.at, mover.time_s, context)? {
                let (holding, tail_holding, event_s) = (graph.roadmap.holding, next.roadmap.holding, mover.time_s);
                return Ok(Commitment { mode: mode.id, holding, moves: mover.moves, event_s, tail, tail_holding });
            }
            in_the_way.extend(after.blamed());
        }
        in_the_way.extend(traffic.blamed());
        if let Some(for_ever) = self.for_ever_in_the_way(graph, next, traffic) {
            in_the_way = for_ever;
        }
        Err(Unreached::Because(causes_of(self.scene, mode, &in_the_way)))
    }

    /// The traffic after the mode's event. An object that is grasped need not be taken out: who holds it does not hit it.
    fn traffic_after<'a>(
        &'a self,
        mode: &Mode,
        timeline: &'a Timeline,
        event_s: f64,
    ) -> Result<Traffic<'a>, Interrupted> {
        let mut traffic = Traffic::new(&self.scene.conflicts, timeline, mode.id.robot, event_s);
        if let Some(placed) = self.scene.placed(self.assignment, mode)? {
            traffic.put(placed, event_s);
        }
        Ok(traffic)
    }

    /// A tail behind the mode's event, which is its robot's last in a timeline; `None` if there is none, or no work left.
    pub fn safe_tail(
        &self,
        timeline: &Timeline,
        context: &mut JobContext<'_>,
    ) -> Result<Option<Vec<Move>>, Interrupted> {
        let modes = &self.scene.skeleton.modes[self.mode.robot.index()];
        let (mode, next) = (modes.get(self.mode.step as usize), modes.get(self.mode.step as usize + 1));
        let last = timeline.robot(self.mode.robot).commitments.last().filter(|last| last.mode == self.mode);
        let (Some(mode), Some(next), Some(roadmap), Some(last)) = (mode, next, self.next_roadmap, last) else {
            return Ok(None);
        };
        let graph = self.scene.mode_graph(self.assignment, next, &roadmap, context)?;
        let traffic = self.traffic_after(mode, timeline, last.event_s)?;
        let Some(at) = last.moves.last().map(|step| &step.to) else { return Ok(None) };
        match self.tail(&graph, &traffic, &[], at, last.event_s, context) {
            Ok(tail) => Ok(tail),
            Err(Unreached::Because(_)) => Ok(None),
            Err(Unreached::Interrupted(interrupted)) => Err(interrupted),
        }
    }

    fn spend(&self, context: &mut JobContext<'_>) -> Result<(), Unreached> {
        if context.spend(1)? {
            return Ok(());
        }
        Err(Unreached::Because(vec![Cause::Budget { stage: "composite".into() }]))
    }
}

fn begin_at(graph: &ModeGraph<'_>, vertex: VertexId, since_s: f64, mover: Mover) -> Result<Start, Interrupted> {
    if same_configuration(graph.robot, graph.vertex(vertex), &mover.at) {
        Ok(Start { vertex, since_s, mover })
    } else {
        Err(Interrupted::Unfit("the roadmap does not begin where the robot is".into()))
    }
}
