//! The oracle: Dijkstra over composite states as the rules define them, written straight from roadmaps and task plan.

use std::collections::{BTreeMap, BTreeSet};

use model::Point;
use skeleton::{Event, Occupancy};

use super::toy::{Place, Toy, place, present};

/// Mode and vertex of each robot. A robot without modes is at (0, 0).
pub type State = Vec<(usize, usize)>;

#[derive(Clone, Copy, PartialEq)]
enum Act {
    Stay,
    /// Edge, vertex at its other end.
    Edge(usize, usize),
    Event,
}

/// Least composite time to the end (s); `None` if the end cannot be reached.
pub fn optimum(toy: &Toy) -> Option<f64> {
    let start: State = toy.roadmaps.iter().map(|modes| (0, modes.first().map_or(0, |m| m.start.index()))).collect();
    least_time(toy, start, |_| true, |state| is_end(toy, state))
}

/// Least composite time from a state to one that is an end (s), some robots moving only; `None` if there is no way.
pub fn least_time(
    toy: &Toy,
    start: State,
    moves: impl Fn(usize) -> bool,
    is_end: impl Fn(&State) -> bool,
) -> Option<f64> {
    let mut best: BTreeMap<State, f64> = BTreeMap::from([(start.clone(), 0.0)]);
    let mut open: BTreeSet<(u64, State)> = BTreeSet::from([(0, start)]);
    // Times are not negative, so their bits are ordered as they are.
    while let Some((bits, state)) = open.pop_first() {
        let time = f64::from_bits(bits);
        if best[&state] < time {
            continue;
        }
        if is_end(&state) {
            return Some(time);
        }
        let acts_of = |robot| if moves(robot) { acts_of(toy, &state, robot) } else { vec![Act::Stay] };
        for acts in products(&state, acts_of) {
            let Some((next, duration)) = step(toy, &state, &acts) else { continue };
            let then = time + duration;
            if best.get(&next).is_none_or(|known| then < *known) {
                best.insert(next.clone(), then);
                open.insert((then.to_bits(), next));
            }
        }
    }
    None
}

fn is_end(toy: &Toy, state: &State) -> bool {
    toy.roadmaps.iter().zip(state).all(|(modes, (mode, vertex))| {
        modes.is_empty() || (mode + 1 == modes.len() && *vertex == modes[*mode].goal.index())
    })
}

fn acts_of(toy: &Toy, state: &State, robot: usize) -> Vec<Act> {
    let (mode, vertex) = state[robot];
    let mut acts = vec![Act::Stay];
    let Some(roadmap) = toy.roadmaps[robot].get(mode) else { return acts };
    for (i, edge) in roadmap.edges.iter().enumerate() {
        if edge.a.index() == vertex {
            acts.push(Act::Edge(i, edge.b.index()));
        }
        if edge.b.index() == vertex {
            acts.push(Act::Edge(i, edge.a.index()));
        }
    }
    if vertex == roadmap.goal.index() && toy.skeleton.modes[robot][mode].ends.is_some() {
        acts.push(Act::Event);
    }
    acts
}

fn products(state: &State, acts: impl Fn(usize) -> Vec<Act>) -> Vec<Vec<Act>> {
    let mut all = vec![Vec::new()];
    for robot in 0..state.len() {
        let own = acts(robot);
        all = all.into_iter().flat_map(|so_far| own.iter().map(move |act| [&so_far[..], &[*act]].concat())).collect();
    }
    all
}

/// Where the acts lead and how long they take, if the rules allow them.
fn step(toy: &Toy, state: &State, acts: &[Act]) -> Option<(State, f64)> {
    if acts.iter().all(|act| *act == Act::Stay) {
        return None;
    }
    let before: Vec<usize> = state.iter().map(|(mode, _)| *mode).collect();
    let after: Vec<usize> = before.iter().zip(acts).map(|(m, act)| m + usize::from(*act == Act::Event)).collect();
    let (there_before, there_after) = (present(&toy.skeleton, &before), present(&toy.skeleton, &after));
    let placed: Vec<Occupancy> = there_after.keys().filter(|o| there_after[o] && !there_before[o]).copied().collect();
    let mut next = Vec::new();
    let mut duration: f64 = 0.0;
    for (robot, act) in acts.iter().enumerate() {
        let (mode, vertex) = state[robot];
        let gate_is_open = gate_is_open(toy, &before, robot);
        match *act {
            Act::Stay => next.push((mode, vertex)),
            Act::Edge(i, to) => {
                let roadmap = &toy.roadmaps[robot][mode];
                let blocked = roadmap.edges[i].blockers.iter().any(|b| there_after[&roadmap.possible[*b as usize]]);
                if blocked || (to == roadmap.goal.index() && !gate_is_open) {
                    return None;
                }
                duration = duration.max(roadmap.edges[i].duration_s);
                next.push((mode, to));
            }
            Act::Event => {
                if !gate_is_open {
                    return None;
                }
                duration = duration.max(toy.statement.problem.settings.grip_time.max(1e-6));
                next.push((mode + 1, toy.roadmaps[robot][mode + 1].start.index()));
            }
        }
        let stands = !matches!(act, Act::Edge(..));
        if stands && placed.iter().any(|o| placer(toy, *o) != Some(robot) && is_hit(toy, robot, next[robot], *o)) {
            return None;
        }
    }
    for b in 0..acts.len() {
        for a in 0..b {
            let both_stay = acts[a] == Act::Stay && acts[b] == Act::Stay;
            if !both_stay && (toy.table.conflict)(named(toy, state, acts, &next, a), named(toy, state, acts, &next, b))
            {
                return None;
            }
        }
    }
    Some((next, duration))
}

fn gate_is_open(toy: &Toy, modes: &[usize], robot: usize) -> bool {
    let Some(mode) = toy.skeleton.modes[robot].get(modes[robot]) else { return true };
    let Some(event) = mode.ends else { return true };
    let happened = |other: &Event| {
        let owner = toy.statement.problem.pair(other.pair).robot.index();
        toy.skeleton.modes[owner][..modes[owner]].iter().any(|mode| mode.ends == Some(*other))
    };
    let instants = toy.skeleton.graph.events().filter(|e| matches!(e.point, Point::Grasp | Point::Release));
    instants.filter(|e| toy.skeleton.graph.precedes(*e, event)).all(|e| happened(&e))
}

fn placer(toy: &Toy, occupancy: Occupancy) -> Option<usize> {
    let event = toy.skeleton.interval_of(occupancy).from?;
    Some(toy.statement.problem.pair(event.pair).robot.index())
}

fn is_hit(toy: &Toy, robot: usize, (mode, vertex): (usize, usize), occupancy: Occupancy) -> bool {
    let Some(roadmap) = toy.roadmaps[robot].get(mode) else {
        let at = place(&toy.statement.problem.robots[robot].start);
        return (toy.table.hit)((robot, mode as u32, at, at), occupancy);
    };
    let at = place(&roadmap.vertices[vertex]);
    let ends_here = roadmap.edges.iter().filter(|edge| [edge.a.index(), edge.b.index()].contains(&vertex));
    let blocked = |edge: &contract::Edge| edge.blockers.iter().any(|b| roadmap.possible[*b as usize] == occupancy);
    ends_here.clone().all(blocked) && (toy.table.hit)((robot, mode as u32, at, at), occupancy)
}

/// What a robot does, as the table names it: in the mode after its event, from the place at the beginning.
fn named(toy: &Toy, state: &State, acts: &[Act], next: &State, robot: usize) -> Place {
    let (mode, to) = next[robot];
    let Some(roadmap) = toy.roadmaps[robot].get(mode) else {
        let at = place(&toy.statement.problem.robots[robot].start);
        return (robot, mode as u32, at, at);
    };
    let to = place(&roadmap.vertices[to]);
    let from = if acts[robot] == Act::Event { to } else { place(&roadmap.vertices[state[robot].1]) };
    (robot, mode as u32, from, to)
}
