//! Assembles the plan of a complete prefix: waits taken out, arcs put in, earliest times, events, bound.

mod bound;
mod cells;
mod check;
mod order;
mod trajectory;

use contract::{Answer, Assignment, CauseTally, Interrupted, JobContext, Outcome, Product, ProductRef};
use model::{Point, RobotId, Standing};
use plan::{
    Dependency, Event as PlanEvent, EventKind, KnotRef, LowerBound, Makespan, Origin, PLAN_FORMAT, PairPoint, Plan,
    PlanOrdering, Provenance,
};
use skeleton::{ArcOrigin, Event, EventGraph};

use crate::commit::Orders;
use crate::{Scene, Timeline, load_prefix};

use cells::RobotCells;
use order::{CellArc, Reasons, arcs, earliest};
use trajectory::Knots;

/// A complete prefix, and what its plan is made from.
pub(crate) struct AssembleJob<'a> {
    pub scene: &'a Scene,
    pub assignment: &'a Assignment,
    pub prefix: ProductRef,
    pub shortest_s: &'a [Vec<f64>],
}

/// Committed motion cut into cells, with its arcs and times.
pub(crate) struct Retimed {
    pub robots: Vec<RobotCells>,
    pub arcs: Vec<CellArc>,
    pub times: Vec<Vec<(f64, f64)>>,
}

impl AssembleJob<'_> {
    /// The plan; or a failure if the prefix is in conflict with itself.
    pub fn answer(&self, context: &mut JobContext<'_>) -> Result<Outcome, Interrupted> {
        let timeline = Timeline::new(self.scene, self.assignment, load_prefix(context, Some(self.prefix))?)?;
        let complete = timeline.robots.iter().zip(&self.scene.skeleton.modes);
        if complete.into_iter().any(|(robot, modes)| robot.commitments.len() != modes.len()) {
            return Err(Interrupted::Unfit("the prefix does not hold all modes".into()));
        }
        context.spend(timeline.robots.iter().map(|robot| robot.moves.len() as u64).sum())?;
        if let Some(cause) = check::first_conflict(self.scene, &timeline) {
            let mut tally = CauseTally::default();
            tally.count(cause);
            return Ok(Outcome::soft_failure(tally, 0, context.spent()));
        }
        let graph = self.scene.graph(self.assignment)?;
        let retimed = retime(self.scene, self.assignment, &graph, &timeline)?;
        let plan = self.plan(&graph, &retimed)?;
        let makespan_s = plan.makespan.task_s;
        let bytes = plan::write_plan(&plan).map_err(|error| Interrupted::Unfit(error.to_string()))?;
        let plan = context.publish(&Product::Plan(bytes))?;
        Ok(Outcome::answer(Answer::Plan { plan, makespan_s }, context.spent()))
    }

    fn plan(&self, graph: &EventGraph, retimed: &Retimed) -> Result<Plan, Interrupted> {
        let (problem, statement) = (self.scene.problem(), &self.scene.statement);
        let named = named_boundaries(retimed);
        let knots: Vec<Knots> =
            (0..retimed.robots.len()).map(|r| Knots::new(&retimed.robots[r], &retimed.times[r], &named[r])).collect();
        let robots: Vec<_> =
            knots.iter().enumerate().map(|(r, k)| k.trajectory(self.scene, r, &retimed.robots[r])).collect();
        let makespan = self.makespan(retimed, &knots);
        let (modes, robots_cells) = (&self.scene.skeleton, &retimed.robots);
        let bound_s = bound::lower_bound_s(problem, modes, graph, self.shortest_s, robots_cells)?;
        Ok(Plan {
            format: PLAN_FORMAT.into(),
            problem: problem.name.clone(),
            robots,
            events: self.events(retimed, &knots)?,
            orderings: self.orderings(),
            dependencies: dependencies(self.scene, retimed, &knots),
            makespan,
            // Equal sums of the same times may differ by rounding.
            lower_bound: LowerBound { seconds: bound_s.min(makespan.task_s), kind: "assignment-roadmap".into() },
            provenance: Provenance {
                problem_digest: statement.problem_digest().hex(),
                seed: statement.seed,
                implementations: statement
                    .implementations
                    .iter()
                    .map(|(stage, implementation)| format!("{stage} {implementation}"))
                    .collect(),
                ledger_digest: String::new(),
            },
        })
    }

    /// The work is over when the arm is folded after the last release; everything, when the last robot stands.
    fn makespan(&self, retimed: &Retimed, knots: &[Knots]) -> Makespan {
        let (mut task_s, mut total_s) = (0.0_f64, 0.0_f64);
        for (r, modes) in self.scene.skeleton.modes.iter().enumerate() {
            total_s = knots[r].knots.last().map_or(total_s, |knot| total_s.max(knot.t));
            let after_release = |step: &usize| modes[*step].begins.is_some_and(|event| event.point == Point::Release);
            for step in (0..modes.len()).filter(after_release) {
                let mode = retimed.robots[r].modes[step];
                let done = knots[r].at(mode.fold.unwrap_or(mode.last)).reach;
                task_s = task_s.max(knots[r].knots[done].t);
            }
        }
        Makespan { task_s, total_s }
    }

    /// Attach and detach events in order of time. The object is attached exactly where it stands: the transform to the
    /// hand absorbs the rounding of the hand's pose, and is kept until the release.
    fn events(&self, retimed: &Retimed, knots: &[Knots]) -> Result<Vec<PlanEvent>, Interrupted> {
        let problem = self.scene.problem();
        let mut events = Vec::new();
        for (r, robot) in retimed.robots.iter().enumerate() {
            let mut link_from_object = None;
            for (c, cell) in robot.cells.iter().enumerate() {
                let Some(event) = cell.event else { continue };
                let pair = problem.pair(event.pair);
                let (link, kind) = (problem.robots[r].end_effector.parent_link, event_kind(event));
                let standing = self.pose_of(event)?;
                if kind == EventKind::Attach {
                    let world_from_link = kinematics::link_pose(&problem.robots[r], &cell.to, link);
                    link_from_object = Some(world_from_link.inverse() * standing.world_from_object);
                }
                let grasp = self.assignment.grasps.get(event.pair.index());
                let grasps = &problem.movable[pair.object.index()].grasps[r];
                let grasp = grasp.and_then(|grasp| grasps.get(grasp.index()));
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

    fn pose_of(&self, event: Event) -> Result<Standing, Interrupted> {
        pose_of(self.scene, self.assignment, event)
    }

    fn orderings(&self) -> Vec<PlanOrdering> {
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
        let (origin, cause) = (Origin::Given, None);
        let mut orderings: Vec<PlanOrdering> = given
            .chain(hops)
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

/// The pose that a grasp ends, or a release begins.
fn pose_of(scene: &Scene, assignment: &Assignment, event: Event) -> Result<Standing, Interrupted> {
    let (problem, skeleton) = (scene.problem(), &scene.skeleton);
    let occupancy = match event.point {
        Point::Grasp => skeleton.picked(problem, event.pair),
        _ => skeleton.placed(problem, event.pair),
    };
    scene.standing(assignment, occupancy)
}

/// Cuts a complete timeline, finds its arcs and its earliest times.
pub(crate) fn retime(
    scene: &Scene,
    assignment: &Assignment,
    graph: &EventGraph,
    timeline: &Timeline,
) -> Result<Retimed, Interrupted> {
    let robots = timeline.robots.iter().map(|robot| RobotCells::new(scene, robot));
    let robots: Vec<RobotCells> = robots.collect::<Result<_, _>>().map_err(Interrupted::Unfit)?;
    let events = event_arcs(&Orders { scene, graph, timeline }, &robots)?;
    let pose = |event| pose_of(scene, assignment, event).ok();
    let reasons = Reasons { conflicts: &scene.conflicts, pose_of: &pose, events };
    let arcs = arcs(&robots, &reasons);
    let times = earliest(&robots, &arcs);
    Ok(Retimed { robots, arcs, times })
}

/// Orderings between robots as arcs between the cells that end with their points.
fn event_arcs(orders: &Orders<'_>, robots: &[RobotCells]) -> Result<Vec<CellArc>, Interrupted> {
    let mut arcs = Vec::new();
    for arc in orders.graph.arcs().iter().filter(|arc| arc.origin != ArcOrigin::Robot) {
        let (Some(before), Some(after)) = (last_cell(orders, robots, arc.before), last_cell(orders, robots, arc.after))
        else {
            continue;
        };
        if before.0 == after.0 {
            continue;
        }
        let (first, second) = (&robots[before.0].cells[before.1], &robots[after.0].cells[after.1]);
        if first.ends_s > second.begins_s + 1e-9 {
            let name = |event: Event| event.describe(orders.scene.problem());
            return Err(Interrupted::Unfit(format!("{} is not before {}", name(arc.before), name(arc.after))));
        }
        arcs.push(CellArc { before, after });
    }
    arcs.sort_unstable();
    Ok(arcs)
}

/// The cell that ends with a point: robot and number. None for the start of the plan.
fn last_cell(orders: &Orders<'_>, robots: &[RobotCells], event: Event) -> Option<(usize, usize)> {
    let mode = orders.mode_of(event)?;
    let robot = mode.robot.index();
    let cells = robots[robot].modes[mode.step as usize];
    let boundary = match event.point {
        Point::Grasp | Point::Release => cells.last,
        Point::Carry | Point::Done | Point::Start => cells.fold.unwrap_or(cells.last),
        Point::AtPick | Point::AtPlace => cells.arrive,
    };
    boundary.checked_sub(1).map(|cell| (robot, cell))
}

/// Boundaries that an arc needs as knots, for each robot.
fn named_boundaries(retimed: &Retimed) -> Vec<Vec<bool>> {
    let mut named: Vec<Vec<bool>> = retimed.robots.iter().map(|robot| vec![false; robot.cells.len() + 1]).collect();
    for arc in &retimed.arcs {
        named[arc.before.0][arc.before.1 + 1] = true;
        named[arc.after.0][arc.after.1] = true;
    }
    named
}

fn dependencies(scene: &Scene, retimed: &Retimed, knots: &[Knots]) -> Vec<Dependency> {
    let name = |r: usize| scene.problem().robot(RobotId::at(r)).name.clone();
    let dependency = |arc: &CellArc| Dependency {
        before: KnotRef { robot: name(arc.before.0), knot: knots[arc.before.0].at(arc.before.1 + 1).reach },
        after: KnotRef { robot: name(arc.after.0), knot: knots[arc.after.0].at(arc.after.1).leave },
    };
    retimed.arcs.iter().map(dependency).collect()
}
