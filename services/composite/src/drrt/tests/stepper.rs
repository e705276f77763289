//! Replays a schedule, knowing only its commitments, the roadmaps, and the rules.

use std::collections::BTreeMap;

use contract::{Commitment, Move};
use model::Point;
use skeleton::{Event, Occupancy};

use super::toy::{Place, Toy, place, present};

/// Rounding of times (s).
const EQUAL: f64 = 1e-7;

/// One robot's committed motion: all moves with the step of their mode, and the ends of its modes.
#[derive(Default)]
struct Line {
    moves: Vec<(usize, Move)>,
    ends: Vec<f64>,
}

/// Replays commitments from the beginning of the plan; what is wrong, or when all is over (s).
pub fn replay(toy: &Toy, commitments: &[Commitment]) -> Result<f64, String> {
    let mut last = 0.0;
    let mut lines: Vec<Line> = toy.roadmaps.iter().map(|_| Line::default()).collect();
    for commitment in commitments {
        if commitment.event_s < last {
            return Err(format!("commitments are not in order of time at {last}"));
        }
        last = commitment.event_s;
        add(toy, &mut lines, commitment)?;
    }
    for (robot, line) in lines.iter().enumerate() {
        if line.ends.len() != toy.roadmaps[robot].len() {
            return Err(format!("robot {robot} ends {} of {} modes", line.ends.len(), toy.roadmaps[robot].len()));
        }
    }
    check_orders(toy, &lines)?;
    check_steps(toy, &lines)?;
    Ok(last)
}

fn add(toy: &Toy, lines: &mut [Line], commitment: &Commitment) -> Result<(), String> {
    let robot = commitment.mode.robot.index();
    let line = &mut lines[robot];
    let step = line.ends.len();
    if commitment.mode.step as usize != step || !commitment.tail.is_empty() {
        return Err(format!("robot {robot} commits {:?} as its mode {step}, or with a tail", commitment.mode));
    }
    let start = &toy.statement.problem.robots[robot].start;
    let mut at = line.moves.last().map_or(start.clone(), |(_, m)| m.to.clone());
    let mut now = line.ends.last().copied().unwrap_or(0.0);
    let grip = toy.statement.problem.settings.grip_time;
    let rested = if step == 0 { 0.0 } else { now + grip };
    let roadmap = &toy.roadmaps[robot][step];
    for m in &commitment.moves {
        if m.from != at || m.begins_s != now || m.ends_s < m.begins_s {
            return Err(format!("robot {robot} jumps at {now}"));
        }
        let stands = m.from == m.to;
        if !stands && m.begins_s < rested - EQUAL {
            return Err(format!("robot {robot} does not rest until {rested}"));
        }
        let is = |vertex: contract::VertexId, q: &[f64]| roadmap.vertices[vertex.index()] == q;
        let mut along = roadmap
            .edges
            .iter()
            .filter(|e| (is(e.a, &m.from) && is(e.b, &m.to)) || (is(e.b, &m.from) && is(e.a, &m.to)));
        let fits = along.any(|e| (m.ends_s - m.begins_s - e.duration_s).abs() < EQUAL && e.kind == m.kind);
        let is_vertex = roadmap.vertices.contains(&m.from);
        if !(stands && is_vertex || fits) {
            return Err(format!("robot {robot} leaves its roadmap at {now}: {:?} to {:?}", m.from, m.to));
        }
        (at, now) = (m.to.clone(), m.ends_s);
    }
    if now != commitment.event_s || at != roadmap.vertices[roadmap.goal.index()] {
        return Err(format!("robot {robot} ends mode {step} at {now} and {at:?}, event {}", commitment.event_s));
    }
    if step + 1 == toy.roadmaps[robot].len() && now < rested - EQUAL {
        return Err(format!("robot {robot} is done before it has rested"));
    }
    line.moves.extend(commitment.moves.iter().map(|m| (step, m.clone())));
    line.ends.push(now);
    Ok(())
}

/// Time of a grasp or release.
fn time_of(toy: &Toy, lines: &[Line], event: Event) -> Option<f64> {
    let robot = toy.statement.problem.pair(event.pair).robot.index();
    let step = toy.skeleton.modes[robot].iter().position(|mode| mode.ends == Some(event))?;
    lines[robot].ends.get(step).copied()
}

fn check_orders(toy: &Toy, lines: &[Line]) -> Result<(), String> {
    let instants: Vec<Event> =
        toy.skeleton.graph.events().filter(|e| matches!(e.point, Point::Grasp | Point::Release)).collect();
    for a in &instants {
        for b in instants.iter().filter(|b| toy.skeleton.graph.precedes(*a, **b)) {
            let (first, second) = (time_of(toy, lines, *a), time_of(toy, lines, *b));
            if !matches!((first, second), (Some(first), Some(second)) if first + 1e-9 < second) {
                return Err(format!("{a:?} at {first:?} is not before {b:?} at {second:?}"));
            }
        }
    }
    Ok(())
}

/// What a robot does from a time on.
struct Doing {
    name: Place,
    /// When it arrives; before that it may do nothing else.
    until: f64,
    /// Whether something begins now, or the mode has just ended.
    is_new: bool,
    vertex: Vec<f64>,
}

/// All motions must begin at common times and be over at the next; at each the rules are checked.
fn check_steps(toy: &Toy, lines: &[Line]) -> Result<(), String> {
    // The closing return ends with no event, at any time.
    let mut times: Vec<f64> = lines.iter().flat_map(|line| line.ends.iter().rev().skip(1).copied()).collect();
    let moving = lines.iter().flat_map(|line| &line.moves).filter(|(_, m)| m.from != m.to);
    times.extend(moving.clone().flat_map(|(_, m)| [m.begins_s]));
    times.sort_by(f64::total_cmp);
    times.dedup();
    let mut before: Option<BTreeMap<Occupancy, bool>> = None;
    for (i, now) in times.iter().enumerate() {
        let ended =
            |line: &Line, count: fn(f64, f64) -> bool| line.ends.iter().filter(|end| count(**end, *now)).count();
        // The closing return never ends.
        let cap = |robot: usize, modes: usize| modes.min(toy.roadmaps[robot].len().saturating_sub(1));
        let modes: Vec<usize> =
            lines.iter().enumerate().map(|(r, line)| cap(r, ended(line, |end, now| end <= now))).collect();
        let modes_before: Vec<usize> =
            lines.iter().enumerate().map(|(r, line)| cap(r, ended(line, |end, now| end < now))).collect();
        let world = present(&toy.skeleton, &modes);
        let world_before = before.take().unwrap_or_else(|| present(&toy.skeleton, &modes_before));
        let doing: Vec<Doing> =
            (0..lines.len()).map(|robot| doing(toy, &lines[robot], robot, *now, &modes, &modes_before)).collect();
        for (robot, own) in doing.iter().enumerate() {
            if times.get(i + 1).is_some_and(|next| own.until > next + EQUAL) {
                return Err(format!("robot {robot} is still under way at {}", times[i + 1]));
            }
            check_alone(toy, robot, own, (&modes, &modes_before), (&world, &world_before), *now)?;
            for (other, theirs) in doing.iter().enumerate().take(robot) {
                if (own.is_new || theirs.is_new) && (toy.table.conflict)(theirs.name, own.name) {
                    return Err(format!("robots {other} and {robot} meet at {now}: {:?} {:?}", theirs.name, own.name));
                }
            }
        }
        before = Some(world);
    }
    Ok(())
}

fn doing(toy: &Toy, line: &Line, robot: usize, now: f64, modes: &[usize], before: &[usize]) -> Doing {
    let step = modes[robot] as u32;
    let begun = line.moves.iter().find(|(_, m)| m.begins_s == now && m.from != m.to);
    let ended = modes[robot] != before[robot];
    if let (Some((_, m)), false) = (begun, ended) {
        let name = (robot, step, place(&m.from), place(&m.to));
        return Doing { name, until: m.ends_s, is_new: true, vertex: m.to.clone() };
    }
    let start = &toy.statement.problem.robots[robot].start;
    let at = line.moves.iter().rfind(|(_, m)| m.begins_s < now).map_or(start, |(_, m)| &m.to).clone();
    Doing { name: (robot, step, place(&at), place(&at)), until: now, is_new: ended, vertex: at }
}

fn check_alone(
    toy: &Toy,
    robot: usize,
    own: &Doing,
    (modes, before): (&[usize], &[usize]),
    (world, world_before): (&BTreeMap<Occupancy, bool>, &BTreeMap<Occupancy, bool>),
    now: f64,
) -> Result<(), String> {
    let Some(roadmap) = toy.roadmaps[robot].get(modes[robot]) else { return Ok(()) };
    let (from, to) = (own.name.2, own.name.3);
    if own.until > now {
        let ends = |e: &&contract::Edge| {
            let places = [e.a, e.b].map(|v| place(&roadmap.vertices[v.index()]));
            let same_arm = [e.a, e.b].iter().any(|v| roadmap.vertices[v.index()] == own.vertex);
            (places == [from, to] || places == [to, from]) && same_arm
        };
        let free = |e: &contract::Edge| e.blockers.iter().all(|b| !world[&roadmap.possible[*b as usize]]);
        if !roadmap.edges.iter().filter(ends).any(free) {
            return Err(format!("robot {robot} goes through an object at {now}"));
        }
        let event = toy.skeleton.modes[robot][modes[robot]].ends;
        let enters_goal = own.vertex == roadmap.vertices[roadmap.goal.index()];
        if let (Some(event), true) = (event, enters_goal) {
            let instants = toy.skeleton.graph.events().filter(|e| matches!(e.point, Point::Grasp | Point::Release));
            for earlier in instants.filter(|e| toy.skeleton.graph.precedes(*e, event)) {
                let owner = toy.statement.problem.pair(earlier.pair).robot.index();
                if !toy.skeleton.modes[owner][..before[owner]].iter().any(|mode| mode.ends == Some(earlier)) {
                    return Err(format!("robot {robot} enters its goal at {now} before {earlier:?}"));
                }
            }
        }
        return Ok(());
    }
    for (occupancy, _) in world.iter().filter(|(o, there)| **there && !world_before[o]) {
        let placer =
            toy.skeleton.interval_of(*occupancy).from.map(|e| toy.statement.problem.pair(e.pair).robot.index());
        let vertex = roadmap.vertices.iter().position(|v| *v == own.vertex);
        let at_vertex = roadmap.edges.iter().filter(|e| [e.a, e.b].iter().any(|v| Some(v.index()) == vertex));
        let all_blocked =
            at_vertex.clone().all(|e| e.blockers.iter().any(|b| roadmap.possible[*b as usize] == *occupancy));
        if placer != Some(robot) && all_blocked && (toy.table.hit)(own.name, *occupancy) {
            return Err(format!("{occupancy:?} is placed on robot {robot} at {now}"));
        }
    }
    Ok(())
}
