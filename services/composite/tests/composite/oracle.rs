//! Where everything is at an instant, and whether any discs overlap: written without the crate's geometry.

use contract::Commitment;

use crate::toys::{OBJECT, REACH, ROBOT, Toy};

/// A disc, and whose it is: a robot (with what it holds) or a standing object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    pub owner: (char, usize),
    pub centre: [f64; 2],
    pub radius: f64,
}

/// Discs of a robot at x, y, yaw.
pub fn robot_discs(robot: usize, q: &[f64], holds: bool) -> Vec<Disc> {
    let owner = ('r', robot);
    let mut discs = vec![Disc { owner, centre: [q[0], q[1]], radius: ROBOT }];
    if holds {
        let centre = [q[0] + REACH * q[2].cos(), q[1] + REACH * q[2].sin()];
        discs.push(Disc { owner, centre, radius: OBJECT });
    }
    discs
}

/// Two discs of different owners that overlap; standing objects may.
pub fn overlap(discs: &[Disc]) -> Option<(Disc, Disc)> {
    for (i, a) in discs.iter().enumerate() {
        for b in &discs[i + 1..] {
            let both_stand = a.owner.0 == 'm' && b.owner.0 == 'm';
            let distance = (a.centre[0] - b.centre[0]).hypot(a.centre[1] - b.centre[1]);
            if a.owner != b.owner && !both_stand && distance < a.radius + b.radius {
                return Some((*a, *b));
            }
        }
    }
    None
}

fn between(from: &[f64], to: &[f64], share: f64) -> Vec<f64> {
    from.iter().zip(to).map(|(a, b)| a + (b - a) * share).collect()
}

/// Everything at time `t` (s) if nothing more is committed.
pub fn discs_at(toy: &Toy, commitments: &[Commitment], t: f64) -> Vec<Disc> {
    let mut discs = Vec::new();
    for (r, robot) in toy.problem().robots.iter().enumerate() {
        let own: Vec<&Commitment> = commitments.iter().filter(|c| c.mode.robot.index() == r).collect();
        let moves = own.iter().flat_map(|c| c.moves.iter().map(|step| (step, c.holding)));
        let tail = own.last().into_iter().flat_map(|c| c.tail.iter().map(|step| (step, c.tail_holding)));
        let (mut q, mut holds) = (robot.start.clone(), false);
        for (step, holding) in moves.chain(tail).filter(|(step, _)| step.begins_s <= t) {
            let length = step.ends_s - step.begins_s;
            let share = if length > 0.0 { ((t - step.begins_s) / length).min(1.0) } else { 1.0 };
            (q, holds) = (between(&step.from, &step.to, share), holding.is_some());
        }
        if let Some(last) = own.last().filter(|last| last.tail.is_empty() && last.event_s <= t) {
            holds = last.tail_holding.is_some();
        }
        discs.extend(robot_discs(r, &q, holds));
    }
    for object in 0..toy.world.objects.len() {
        let mut stands = Some(0);
        for (hop, (pair, errand)) in
            toy.world.errands.iter().enumerate().filter(|(_, errand)| errand.object == object).enumerate()
        {
            let of_robot = toy.world.errands[..pair].iter().filter(|other| other.robot == errand.robot).count();
            let event_s = |step: usize| {
                let is = |c: &&Commitment| c.mode.robot.index() == errand.robot && c.mode.step as usize == step;
                commitments.iter().find(is).map_or(f64::INFINITY, |c| c.event_s)
            };
            if event_s(2 * of_robot) <= t {
                stands = None;
            }
            if event_s(2 * of_robot + 1) <= t {
                stands = Some(hop + 1);
            }
        }
        if let Some(hop) = stands {
            let at = toy.assignment.poses[object][hop].translation.vector;
            discs.push(Disc { owner: ('m', object), centre: [at.x, at.y], radius: OBJECT });
        }
    }
    discs
}

/// Asserts that no discs overlap at any sampled time.
pub fn assert_free(toy: &Toy, commitments: &[Commitment], context: &str) {
    let end = commitments.iter().flat_map(|c| c.moves.iter().chain(&c.tail)).fold(0.0, |end: f64, m| end.max(m.ends_s));
    let step = 0.01;
    for k in 0..=(end / step) as usize + 2 {
        let t = k as f64 * step;
        let found = overlap(&discs_at(toy, commitments, t));
        assert!(found.is_none(), "{context}: at {t} s {found:?}");
    }
}
