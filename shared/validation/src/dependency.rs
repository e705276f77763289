//! Rule V17: dependency arcs; and the plan as it is executed when robots are late.

use plan::{Dependency, Knot, KnotRef, Plan, RobotTrajectory};

use crate::points;
use crate::violation::{Rule, Violation};

/// How much later than its time a robot may have to leave a knot (s): none, but for rounding.
const ON_TIME: f64 = 1e-9;

/// An arc with its robots resolved: `after` may be left once `before` has been reached.
struct Arc {
    before: (usize, usize),
    after: (usize, usize),
}

/// When each robot reaches and leaves its knots, as delays against the plan's times (s).
struct Delays {
    reached: Vec<Vec<f64>>,
    left: Vec<Vec<f64>>,
}

/// Checks that arcs are valid, that the plan's own times keep them, and that they never wait for one another in a ring.
pub(crate) fn check(plan: &Plan, wrong: &mut Vec<Violation>) {
    let arcs = match resolve(plan) {
        Ok(arcs) => arcs,
        Err(violation) => return wrong.push(violation),
    };
    let mut late = false;
    for (arc, listed) in arcs.iter().zip(&plan.dependencies) {
        let (reached, left) = (time(plan, arc.before), time(plan, arc.after));
        if reached > left + ON_TIME {
            let message = format!(
                "{} is reached at {reached} s, {} left at {left} s",
                words(&listed.before),
                words(&listed.after)
            );
            wrong.push(
                Violation::new(Rule::V17, message).robot(&listed.before.robot).robot(&listed.after.robot).at(left),
            );
            late = true;
        }
    }
    if !late && let Err(violation) = schedule(plan, &arcs, &[]) {
        wrong.push(violation);
    }
}

/// The same plan executed with extra pauses.
///
/// `pauses[robot][knot]` is how long (s) the robot lingers before it leaves each knot, beyond what its arcs make it wait;
/// missing entries, the last knot's, negative and non-finite ones count as 0. A robot leaves a knot only when the `before` knots of all
/// its arcs have been reached; every motion and planned wait takes as long as planned. A longer stay becomes a pair of
/// knots, of which the first keeps the events and ends the segment that ended there. Without delay the plan is returned as
/// it is, bit for bit; otherwise the makespans are computed anew.
///
/// # Errors
/// A violation of V17 if an arc is invalid or arcs wait for one another.
pub fn delayed_execution(plan: &Plan, pauses: &[Vec<f64>]) -> Result<Plan, Violation> {
    let arcs = resolve(plan)?;
    let delays = schedule(plan, &arcs, pauses)?;
    if delays.left.iter().flatten().all(|delay| *delay <= 0.0) {
        return Ok(plan.clone());
    }
    let mut delayed = plan.clone();
    let stays: Vec<Vec<Stay>> = (0..plan.robots.len()).map(|r| stays(plan, r, &delays)).collect();
    for (robot, stays) in delayed.robots.iter_mut().zip(&stays) {
        retime(robot, stays);
    }
    let robot_index = |name: &str| plan.robots.iter().position(|robot| robot.name == name);
    for event in &mut delayed.events {
        if let Some(stay) = robot_index(&event.robot).and_then(|r| stays[r].get(event.knot)) {
            (event.t, event.knot) = (stay.reached, stay.first);
        }
    }
    delayed.events.sort_by(|a, b| a.t.total_cmp(&b.t));
    for (arc, listed) in arcs.iter().zip(&mut delayed.dependencies) {
        listed.before.knot = stays[arc.before.0][arc.before.1].first;
        listed.after.knot = stays[arc.after.0][arc.after.1].last;
    }
    let ends = delayed.robots.iter().filter_map(|robot| robot.knots.last());
    delayed.makespan.total_s = ends.fold(0.0, |latest, knot| knot.t.max(latest));
    delayed.makespan.task_s = points::last_done(&delayed);
    Ok(delayed)
}

/// What becomes of one knot.
struct Stay {
    /// New index of the knot at which the robot arrives.
    first: usize,
    /// New index of the knot at which it leaves; `first` or the next.
    last: usize,
    reached: f64,
    left: f64,
}

fn stays(plan: &Plan, robot: usize, delays: &Delays) -> Vec<Stay> {
    let mut next = 0;
    let mut stays = Vec::new();
    for (k, knot) in plan.robots[robot].knots.iter().enumerate() {
        let (reached, left) = (knot.t + delays.reached[robot][k], knot.t + delays.left[robot][k]);
        let last = if left > reached { next + 1 } else { next };
        stays.push(Stay { first: next, last, reached, left });
        next = last + 1;
    }
    stays
}

fn retime(robot: &mut RobotTrajectory, stays: &[Stay]) {
    let mut knots = Vec::new();
    for (knot, stay) in robot.knots.iter().zip(stays) {
        knots.push(Knot { t: stay.reached, q: knot.q.clone() });
        if stay.last > stay.first {
            knots.push(Knot { t: stay.left, q: knot.q.clone() });
        }
    }
    robot.knots = knots;
    for segment in &mut robot.segments {
        let moved = |knot: usize| stays.get(knot).map_or(knot, |stay| stay.first);
        (segment.from, segment.to) = (moved(segment.from), moved(segment.to));
    }
}

fn time(plan: &Plan, (robot, knot): (usize, usize)) -> f64 {
    plan.robots[robot].knots[knot].t
}

fn words(knot: &KnotRef) -> String {
    format!("knot {} of {}", knot.knot, knot.robot)
}

fn resolve(plan: &Plan) -> Result<Vec<Arc>, Violation> {
    let find = |reference: &KnotRef| {
        let robot = plan.robots.iter().position(|robot| robot.name == reference.robot)?;
        (reference.knot < plan.robots[robot].knots.len()).then_some((robot, reference.knot))
    };
    let arc = |dependency: &Dependency| {
        let wrong = |what: String| {
            let Dependency { before, after } = dependency;
            Violation::new(Rule::V17, what).robot(&before.robot).robot(&after.robot)
        };
        let missing = |reference: &KnotRef| wrong(format!("there is no {}", words(reference)));
        let before = find(&dependency.before).ok_or_else(|| missing(&dependency.before))?;
        let after = find(&dependency.after).ok_or_else(|| missing(&dependency.after))?;
        if before.0 == after.0 {
            return Err(wrong("an arc binds a robot to itself".to_owned()));
        }
        Ok(Arc { before, after })
    };
    plan.dependencies.iter().map(arc).collect()
}

/// Lets every robot run on as far as its arcs allow, until all are at their last knots or none can go on.
fn schedule(plan: &Plan, arcs: &[Arc], pauses: &[Vec<f64>]) -> Result<Delays, Violation> {
    let count = plan.robots.len();
    let mut binding: Vec<Vec<Vec<(usize, usize)>>> =
        plan.robots.iter().map(|robot| vec![Vec::new(); robot.knots.len()]).collect();
    for arc in arcs {
        binding[arc.after.0][arc.after.1].push(arc.before);
    }
    let mut delays = Delays { reached: vec![vec![0.0]; count], left: vec![Vec::new(); count] };
    loop {
        let mut moved = false;
        for robot in 0..count {
            while delays.left[robot].len() < plan.robots[robot].knots.len() {
                let knot = delays.left[robot].len();
                let extra =
                    pauses.get(robot).and_then(|list| list.get(knot)).copied().filter(|pause| pause.is_finite());
                let waits = &binding[robot][knot];
                let extra = extra.unwrap_or(0.0).max(0.0);
                let Some(delay) = leaving_delay(plan, &delays, (robot, knot), extra, waits) else { break };
                delays.left[robot].push(delay);
                delays.reached[robot].push(delay);
                moved = true;
            }
        }
        if !moved {
            break;
        }
    }
    deadlock(plan, &delays).map_or(Ok(delays), Err)
}

/// Delay with which a robot leaves a knot; none while some arc's knot has not been reached. The last knot is never left.
fn leaving_delay(
    plan: &Plan,
    delays: &Delays,
    (robot, knot): (usize, usize),
    extra: f64,
    waits: &[(usize, usize)],
) -> Option<f64> {
    let reached = delays.reached[robot][knot];
    if knot + 1 == plan.robots[robot].knots.len() {
        return Some(reached);
    }
    let planned = time(plan, (robot, knot));
    let mut delay = reached + extra;
    for &(other, at) in waits {
        let arrival = time(plan, (other, at)) + delays.reached[other].get(at)?;
        // An arc that the plan's own times keep costs nothing, not even a rounding.
        if arrival > planned + delay {
            delay = delay.max(arrival - planned);
        }
    }
    Some(delay)
}

fn deadlock(plan: &Plan, delays: &Delays) -> Option<Violation> {
    let stuck: Vec<KnotRef> = plan
        .robots
        .iter()
        .zip(&delays.left)
        .filter(|(robot, left)| left.len() < robot.knots.len())
        .map(|(robot, left)| KnotRef { robot: robot.name.clone(), knot: left.len() })
        .collect();
    let places: Vec<String> = stuck.iter().map(words).collect();
    let message = format!("the arcs wait for one another: nobody can leave {}", places.join(" or "));
    let violation = stuck.iter().fold(Violation::new(Rule::V17, message), |v, knot| v.robot(&knot.robot));
    (!stuck.is_empty()).then_some(violation)
}
