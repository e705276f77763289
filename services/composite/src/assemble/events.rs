//! The plan's events and orderings.

use contract::Interrupted;
use model::Point;
use plan::{Event as PlanEvent, EventKind, Origin, PairPoint, PlanOrdering};
use skeleton::{ArcOrigin, Event};

use super::trajectory::Knots;
use super::{AssembleJob, Retimed, pose_of};

impl AssembleJob<'_> {
    /// Attach and detach events in order of time. The object is attached exactly where it stands: the transform to the
    /// hand absorbs the rounding of the hand's pose, and is kept until the release.
    pub fn events(&self, retimed: &Retimed, knots: &[Knots]) -> Result<Vec<PlanEvent>, Interrupted> {
        let problem = self.scene.problem();
        let mut events = Vec::new();
        for (r, robot) in retimed.robots.iter().enumerate() {
            let mut link_from_object = None;
            for (c, cell) in robot.cells.iter().enumerate() {
                let Some(event) = cell.event else { continue };
                let pair = problem.pair(event.pair);
                let (link, kind) = (problem.robots[r].end_effector.parent_link, event_kind(event));
                let standing = pose_of(self.scene, self.assignment, event)?;
                if kind == EventKind::Attach {
                    let world_from_link = kinematics::link_pose(&problem.robots[r], &cell.to, link);
                    link_from_object = Some(world_from_link.inverse() * standing.world_from_object);
                }
                let grasp = self.assignment.grasps.get(event.pair.index());
                let grasps = problem.movable[pair.object.index()].grasps.get(r);
                let grasp = grasp.zip(grasps).and_then(|(grasp, grasps)| grasps.get(grasp.index()));
                let grasp = grasp.ok_or_else(|| Interrupted::Unfit("the assignment lacks a grasp".into()))?;
                let knot = knots[r].at(c + 1).reach;
                events.push(PlanEvent {
                    t: knots[r].knots[knot].t,
                    kind,
                    robot: problem.robots[r].name.clone(),
                    knot,
                    pair: pair.name.clone(),
                    object: problem.movable[pair.object.index()].name.clone(),
                    link: problem.robots[r].links[link.index()].name.clone(),
                    link_from_object: link_from_object.unwrap_or(grasp.link_from_object).into(),
                    world_from_object: standing.world_from_object.into(),
                    opening: grasp.opening,
                });
            }
        }
        events.sort_by(|a: &PlanEvent, b| a.t.total_cmp(&b.t));
        Ok(events)
    }

    /// Given orderings, the hops of objects, the gates that the problem puts on them, and what the geometry forces.
    pub fn orderings(&self) -> Vec<PlanOrdering> {
        let problem = self.scene.problem();
        let point = |event: Event| PairPoint { pair: problem.pair(event.pair).name.clone(), point: event.point };
        let given = problem.orderings.iter().map(|ordering| {
            (Event::new(ordering.before.0, ordering.before.1), Event::new(ordering.after.0, ordering.after.1))
        });
        let hops = self
            .scene
            .skeleton
            .hops
            .iter()
            .flat_map(|hops| hops.windows(2).map(|pair| (Event::release(pair[0]), Event::grasp(pair[1]))));
        let listed: Vec<(Event, Event)> = given.chain(hops).collect();
        let of_problem = self.scene.skeleton.graph.arcs().iter().filter(|arc| arc.origin != ArcOrigin::Robot);
        let gates: Vec<(Event, Event)> =
            of_problem.map(|arc| (arc.before, arc.after)).filter(|ends| !listed.contains(ends)).collect();
        let (origin, cause) = (Origin::Given, None);
        let mut orderings: Vec<PlanOrdering> = listed
            .into_iter()
            .chain(gates)
            .map(|(before, after)| PlanOrdering {
                before: point(before),
                after: point(after),
                origin,
                cause: cause.clone(),
            })
            .collect();
        orderings.extend(self.assignment.orders.iter().map(|order| PlanOrdering {
            before: point(order.before),
            after: point(order.after),
            origin: Origin::Discovered,
            cause: Some(order.cause.clone()),
        }));
        orderings
    }
}

fn event_kind(event: Event) -> EventKind {
    if event.point == Point::Grasp { EventKind::Attach } else { EventKind::Detach }
}
