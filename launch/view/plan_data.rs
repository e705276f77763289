//! A plan as the page's scripts read it.

use plan::{EventKind, ModeKind, Origin, PairPoint, PlanOrdering, SegmentKind};
use serde::Serialize;

use super::point_times::point_time;
use super::scene::{pose, rounded};
use crate::playback::Playback;

/// A plan with its names turned into indices and its numbers rounded.
#[derive(Serialize)]
pub struct PlanData {
    pairs: Vec<PairData>,
    robots: Vec<TrajectoryData>,
    events: Vec<EventData>,
    orderings: Vec<OrderingData>,
    /// Robot and knot before, robot and knot after.
    arcs: Vec<[usize; 4]>,
    task_s: f64,
    total_s: f64,
    bound_s: f64,
    bound_kind: String,
}

#[derive(Serialize)]
struct PairData {
    name: String,
    robot: usize,
    object: usize,
    from: String,
    to: String,
}

/// Knots as columns: times and configurations.
#[derive(Serialize)]
struct TrajectoryData {
    t: Vec<f64>,
    q: Vec<Vec<f64>>,
    segments: Vec<SegmentData>,
}

#[derive(Serialize)]
struct SegmentData {
    from: usize,
    to: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    pair: Option<usize>,
    mode: ModeKind,
    kind: SegmentKind,
}

#[derive(Serialize)]
struct EventData {
    t: f64,
    attach: bool,
    robot: usize,
    pair: usize,
    object: usize,
    link: usize,
    link_from_object: [f64; 7],
    world_from_object: [f64; 7],
    opening: f64,
}

#[derive(Serialize)]
struct OrderingData {
    before: PointData,
    after: PointData,
    discovered: bool,
    words: String,
}

#[derive(Serialize)]
struct PointData {
    pair: usize,
    point: &'static str,
    t: Option<f64>,
}

impl PlanData {
    /// The plan of a playback.
    #[must_use]
    pub fn of(playback: &Playback) -> Self {
        let plan = playback.plan;
        let robot = |name: &str| plan.robots.iter().position(|robot| robot.name == name).unwrap_or(0);
        let arcs = plan
            .dependencies
            .iter()
            .map(|arc| [robot(&arc.before.robot), arc.before.knot, robot(&arc.after.robot), arc.after.knot]);
        Self {
            pairs: pairs(playback),
            robots: plan.robots.iter().map(|trajectory| trajectory_data(playback, trajectory)).collect(),
            events: events(playback),
            orderings: plan.orderings.iter().map(|ordering| ordering_data(playback, ordering)).collect(),
            arcs: arcs.collect(),
            task_s: rounded(plan.makespan.task_s),
            total_s: rounded(plan.makespan.total_s),
            bound_s: rounded(plan.lower_bound.seconds),
            bound_kind: plan.lower_bound.kind.clone(),
        }
    }
}

fn pairs(playback: &Playback) -> Vec<PairData> {
    let problem = playback.problem;
    let region = |id: model::RegionId| problem.regions[id.index()].name.clone();
    let pairs = problem.pairs.iter().map(|pair| PairData {
        name: pair.name.clone(),
        robot: pair.robot.index(),
        object: pair.object.index(),
        from: region(pair.from),
        to: region(pair.to),
    });
    pairs.collect()
}

fn pair_index(playback: &Playback, name: &str) -> usize {
    playback.problem.pairs.iter().position(|pair| pair.name == name).unwrap_or(0)
}

fn trajectory_data(playback: &Playback, trajectory: &plan::RobotTrajectory) -> TrajectoryData {
    let segments = trajectory.segments.iter().map(|segment| SegmentData {
        from: segment.from,
        to: segment.to,
        pair: segment.pair.as_ref().map(|name| pair_index(playback, name)),
        mode: segment.mode,
        kind: segment.kind,
    });
    TrajectoryData {
        t: trajectory.knots.iter().map(|knot| rounded(knot.t)).collect(),
        q: trajectory.knots.iter().map(|knot| knot.q.iter().copied().map(rounded).collect()).collect(),
        segments: segments.collect(),
    }
}

fn events(playback: &Playback) -> Vec<EventData> {
    let objects = (0..playback.problem.movable.len()).map(model::ObjectId::at);
    let mut events: Vec<EventData> = objects
        .flat_map(|object| playback.handling(object).iter().map(move |handling| (object, handling)))
        .map(|(object, handling)| EventData {
            t: rounded(handling.event.t),
            attach: handling.event.kind == EventKind::Attach,
            robot: handling.robot.index(),
            pair: pair_index(playback, &handling.event.pair),
            object: object.index(),
            link: handling.link.index(),
            link_from_object: pose(&handling.event.link_from_object.into()),
            world_from_object: pose(&handling.event.world_from_object.into()),
            opening: handling.event.opening,
        })
        .collect();
    events.sort_by(|a, b| a.t.total_cmp(&b.t));
    events
}

fn ordering_data(playback: &Playback, ordering: &PlanOrdering) -> OrderingData {
    let point = |at: &PairPoint| PointData {
        pair: pair_index(playback, &at.pair),
        point: at.point.name(),
        t: point_time(playback.plan, &at.pair, at.point).map(rounded),
    };
    OrderingData {
        before: point(&ordering.before),
        after: point(&ordering.after),
        discovered: ordering.origin == Origin::Discovered,
        words: crate::words::ordering(ordering),
    }
}
