//! Phases: the modes of a robot, cut also at those inner points of pairs that an ordering names.
//!
//! A mode whose grasp or release alone is ordered is one phase. Where an ordering names `carry`, `done`, `start`, `at_pick`
//! or `at_place`, the mode is cut at the stand where that point happens: the point is passed at a moment that the search
//! chooses, after which the robot may not go back to before it. So the point is the last time that the robot left, or
//! came to, its arm's region, as the checker of plans computes it.

use contract::{EdgeKind, VertexId};
use model::{PairId, Point, Problem, Robot};
use skeleton::{ArcOrigin, Event, EventGraph, Mode, ModeKind};

use super::mode_graph::ModeGraph;

/// A stretch of a robot's way that ends with an event (the last: with the end of the plan).
#[derive(Clone, Debug)]
pub(super) struct Phase {
    /// Index of its mode.
    pub mode: usize,
    /// Vertices of the mode's roadmap that may be used.
    pub usable: Vec<bool>,
    /// Where its event happens. Until all that must come before has happened, it may not be entered.
    pub goal: VertexId,
    /// Where the next phase begins, in the next phase's roadmap.
    pub enters: VertexId,
    /// What happens at its end: several points that are one instant; none in the last phase.
    pub events: Vec<Event>,
    /// Rest after the event (s).
    pub rest_s: f64,
    /// For each robot, how many of its phases must be over before this one's goal may be entered.
    pub needs: Vec<u32>,
    /// Least time from each vertex to the goal, blockers ignored (s).
    pub cost_to_go_s: Vec<f64>,
    /// Least time from the event to the end of the plan, other robots' gates counted (s).
    pub remaining_s: f64,
}

impl Phase {
    /// Whether its event ends its mode.
    pub fn ends_mode(&self) -> bool {
        self.events.iter().any(|event| matches!(event.point, Point::Grasp | Point::Release))
    }

    /// Whether the robot comes to where its mode ends at its end.
    pub fn is_arrival(&self) -> bool {
        self.events.iter().any(|event| matches!(event.point, Point::AtPick | Point::AtPlace))
    }

    /// Whether a robot at `vertex` has the point at this phase's end behind it: the arm is folded, and nothing else had
    /// to come before.
    pub fn is_left_behind(&self, vertex: VertexId, next: Option<&Phase>) -> bool {
        self.events.iter().any(|event| matches!(event.point, Point::Carry | Point::Done | Point::Start))
            && self.needs.iter().all(|needed| *needed == 0)
            && next.is_some_and(|next| next.usable[vertex.index()])
    }
}

/// The inner points that a non-trivial ordering names. The first `start` of a robot is the beginning of the plan: it
/// counts only where something is to come before it, which nothing can.
pub(super) fn ordered_points(problem: &Problem, graph: &EventGraph) -> Vec<Event> {
    let arcs = graph.arcs().iter().filter(|arc| arc.origin != ArcOrigin::Robot);
    let is_inner = |event: &Event| !matches!(event.point, Point::Grasp | Point::Release);
    let before = arcs.clone().map(|arc| arc.before).filter(|event| !is_beginning(problem, *event));
    let mut points: Vec<Event> = before.chain(arcs.map(|arc| arc.after)).filter(is_inner).collect();
    points.sort_unstable();
    points.dedup();
    points
}

/// Whether an event is the beginning of the plan for its robot.
pub(super) fn is_beginning(problem: &Problem, event: Event) -> bool {
    let robot = problem.pair(event.pair).robot;
    event.point == Point::Start && problem.pairs_of_robot(robot).next() == Some(event.pair)
}

/// Cuts one mode into phases. `needs`, `enters` of the last and `remaining_s` are filled in by the caller.
pub(super) fn phases_of_mode(
    problem: &Problem,
    mode: &Mode,
    graph: &ModeGraph<'_>,
    ordered: &[Event],
    rest_s: f64,
) -> Vec<Phase> {
    let robot = problem.robot(mode.id.robot);
    let everywhere = vec![true; graph.arcs.len()];
    let (left, arrived) = inner_points(problem, mode);
    let relevant = |points: Vec<Event>| points.into_iter().filter(|point| ordered.contains(point)).collect::<Vec<_>>();
    let (left, arrived) = (relevant(left), relevant(arrived));
    let (start, goal) = (graph.roadmap.start, graph.roadmap.goal);
    let mut phases = Vec::new();
    let mut usable = everywhere;
    let index = mode.id.step as usize;
    let near_goal = arm_region(robot, mode.is_holding(), graph, goal);
    if !left.is_empty() {
        let near_start = arm_region(robot, mode.is_holding(), graph, start);
        phases.push(phase(index, graph, without(&usable, goal, near_start.stand), near_start.stand, left, 0.0));
        for v in 0..usable.len() {
            usable[v] = usable[v] && (!near_start.inside[v] || near_goal.inside[v]);
        }
    }
    if !arrived.is_empty() {
        phases.push(phase(index, graph, without(&usable, goal, near_goal.stand), near_goal.stand, arrived, 0.0));
        for v in 0..usable.len() {
            usable[v] = near_goal.inside[v] || v == near_goal.stand.index();
        }
    }
    phases.push(phase(index, graph, usable, goal, mode.ends.into_iter().collect(), rest_s));
    phases
}

/// Points of a mode at its start stand, and at its goal stand. `start` of a pair is `done` of the one before.
fn inner_points(problem: &Problem, mode: &Mode) -> (Vec<Event>, Vec<Event>) {
    let before = mode.begins.map(|event| Event::new(event.pair, Point::Done));
    let at = |pair: Option<PairId>, point: Point| pair.map(|pair| Event::new(pair, point));
    debug_assert!(mode.pair.is_none_or(|pair| problem.pair(pair).robot == mode.id.robot));
    let (left, arrived) = match mode.kind {
        ModeKind::Transit => ([before, at(mode.pair, Point::Start)], at(mode.pair, Point::AtPick)),
        ModeKind::Transfer => ([at(mode.pair, Point::Carry), None], at(mode.pair, Point::AtPlace)),
        ModeKind::Return => ([before, None], None),
    };
    (left.into_iter().flatten().collect(), arrived.into_iter().collect())
}

fn phase(
    mode: usize,
    graph: &ModeGraph<'_>,
    usable: Vec<bool>,
    goal: VertexId,
    events: Vec<Event>,
    rest_s: f64,
) -> Phase {
    let cost_to_go_s = graph.times_to(goal, &usable, |arc| arc.duration_s);
    Phase { mode, usable, goal, enters: goal, events, rest_s, needs: Vec::new(), cost_to_go_s, remaining_s: 0.0 }
}

fn without(usable: &[bool], goal: VertexId, kept: VertexId) -> Vec<bool> {
    let mut usable = usable.to_vec();
    usable[goal.index()] = goal == kept;
    usable
}

/// Where the arm is out at one end of a mode, and the stand at which it is folded again.
struct ArmRegion {
    inside: Vec<bool>,
    stand: VertexId,
}

/// What arm motions reach from `end` without passing a vertex with the arm folded.
fn arm_region(robot: &Robot, holding: bool, graph: &ModeGraph<'_>, end: VertexId) -> ArmRegion {
    let folded = if holding { &robot.carry } else { &robot.home };
    let is_folded = |v: VertexId| {
        let arm = &graph.roadmap.vertices[v.index()][robot.base_len()..];
        arm.iter().zip(folded).all(|(a, b)| (a - b).abs() <= 1e-9)
    };
    let mut region = ArmRegion { inside: vec![false; graph.arcs.len()], stand: end };
    if is_folded(end) {
        return region;
    }
    let mut stand: Option<VertexId> = None;
    let mut reached = vec![end];
    region.inside[end.index()] = true;
    while let Some(v) = reached.pop() {
        for arc in graph.arcs[v.index()].iter().filter(|arc| arc.kind == EdgeKind::Arm) {
            if is_folded(arc.to) {
                stand = Some(stand.map_or(arc.to, |stand| stand.min(arc.to)));
            } else if !region.inside[arc.to.index()] {
                region.inside[arc.to.index()] = true;
                reached.push(arc.to);
            }
        }
    }
    region.stand = stand.unwrap_or(end);
    region
}
