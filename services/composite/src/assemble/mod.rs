//! Assembles the plan of a complete prefix: waits taken out, arcs put in, earliest times, events, bound. The plan of a
//! synchronous schedule keeps its rounds: all arcs from one to the next are put in.

mod barriers;
mod bound;
mod cells;
mod check;
mod events;
mod needed;
mod order;
mod trajectory;

use contract::{Answer, Assignment, CauseTally, Interrupted, JobContext, Outcome, Product, ProductRef};
use model::{Point, RobotId, Standing};
use plan::{Dependency, KnotRef, LowerBound, Makespan, PLAN_FORMAT, Plan, Provenance, SearchRecord};
use skeleton::{ArcOrigin, Event, EventGraph, ModeId};

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
    pub rounds: &'a [Vec<ModeId>],
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
        let assignment = &needed::needed(self.scene, self.assignment, &timeline)?;
        let graph = self.scene.graph(assignment)?;
        let retimed = retime(self.scene, assignment, &graph, &timeline, self.rounds)?;
        let plan = AssembleJob { assignment, ..*self }.plan(&graph, &retimed)?;
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
                search: SearchRecord::default(),
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
    rounds: &[Vec<ModeId>],
) -> Result<Retimed, Interrupted> {
    let robots = timeline.robots.iter().map(|robot| RobotCells::new(scene, robot));
    let robots: Vec<RobotCells> = robots.collect::<Result<_, _>>().map_err(Interrupted::Unfit)?;
    let mut events = event_arcs(&Orders { scene, graph, timeline }, &robots)?;
    events.extend(barriers::barriers(scene, &robots, rounds)?);
    events.sort_unstable();
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
