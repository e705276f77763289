//! The arm piece at one stand: from the folded arm to an object by way of the hand's short straight way.

use collision::{Contact, Geometry, Motion};
use contract::{
    CauseTally, EdgeKind, Interrupted, JobContext, PieceJob, PieceSpec, RandomStream, RoadmapPiece, StageKind,
};
use model::{AllowedContacts, Configuration, Robot};

use crate::RoadmapStage;
use crate::base::folded;
use crate::connect::straight_edge;
use crate::retreat::retreat;

/// Greatest length (s, by the velocity limits) of one extension of a tree.
const EXTENSION_S: f64 = 0.35;
/// Tree vertices allowed for each roadmap vertex of the level.
const TREE_FACTOR: usize = 8;

pub(crate) fn arm_piece(
    stage: &RoadmapStage,
    job: &PieceJob,
    context: &mut JobContext<'_>,
) -> Result<Result<RoadmapPiece, CauseTally>, Interrupted> {
    let geometry = &stage.geometry;
    let PieceSpec::Arm { stand, near, lift_up, support, touch } = &job.spec else {
        return Err(Interrupted::Unfit("not an arm piece".to_owned()));
    };
    let problem = geometry.problem();
    let robot = problem.robot(job.robot);
    let dimensions = robot.coordinates.len();
    if stand.len() != robot.base_len() || near.is_empty() || near.iter().any(|q| q.len() != dimensions) {
        return Err(Interrupted::Unfit("configurations of another robot".to_owned()));
    }
    let drive: Configuration = [stand, folded(robot, job.holding.is_some())].concat();
    let allowed = |step: usize| AllowedContacts {
        touch: touch.map(|standing| standing.object),
        support: support.filter(|_| step < *lift_up as usize),
    };
    let mut causes = CauseTally::default();
    for (step, ends) in near.windows(2).enumerate() {
        context.spend(1)?;
        if let Some(contact) = contact(geometry, job, &ends[0], &ends[1], allowed(step)) {
            causes.count(contact.cause(problem));
            return Ok(Err(causes));
        }
    }
    let Some(way) = (ArmWay { stage, geometry, robot, job }).find(near, &drive, context, &mut causes)? else {
        return Ok(Err(causes));
    };
    Ok(Ok(piece_of(robot, job, near, &way, &allowed)))
}

/// What a motion of the piece's robot touches: itself, fixed objects, the object at hand.
pub(crate) fn contact(
    geometry: &Geometry,
    job: &PieceJob,
    from: &[f64],
    to: &[f64],
    allowed: AllowedContacts,
) -> Option<Contact> {
    let motion = Motion { robot: job.robot, holding: job.holding, from: from.to_vec(), to: to.to_vec(), allowed };
    let at_hand = match &job.spec {
        PieceSpec::Arm { touch, .. } => touch.as_ref(),
        PieceSpec::Base => None,
    };
    geometry.motion_contact(&motion).or_else(|| at_hand.and_then(|standing| geometry.motion_hits(&motion, standing)))
}

/// `way` leads from the end of `near` to the drive configuration.
fn piece_of(
    robot: &Robot,
    job: &PieceJob,
    near: &[Configuration],
    way: &[Configuration],
    allowed: &dyn Fn(usize) -> AllowedContacts,
) -> RoadmapPiece {
    let mut vertices = vec![way[way.len() - 1].clone()];
    vertices.extend(near.iter().cloned());
    let mut edges = Vec::new();
    for step in 0..near.len() - 1 {
        edges.push(straight_edge(robot, &vertices, step + 1, step + 2, EdgeKind::Arm, allowed(step)));
    }
    let mut last = near.len();
    for (i, q) in way.iter().enumerate().skip(1) {
        let next = if i + 1 == way.len() { 0 } else { vertices.len() };
        if next != 0 {
            vertices.push(q.clone());
        }
        edges.push(straight_edge(robot, &vertices, last, next, EdgeKind::Arm, AllowedContacts::default()));
        last = next;
    }
    RoadmapPiece { robot: job.robot, holding: job.holding, vertices, edges }
}

/// Free motion of the arm while the base stands. Kuffner and LaValle, RRT-Connect, doi:10.1109/ROBOT.2000.844730.
struct ArmWay<'a> {
    stage: &'a RoadmapStage,
    geometry: &'a Geometry,
    robot: &'a Robot,
    job: &'a PieceJob,
}

struct Tree(Vec<(Configuration, usize)>);

impl Tree {
    fn way_to_root(&self, mut node: usize) -> Vec<Configuration> {
        let mut way = vec![self.0[node].0.clone()];
        while node != 0 {
            node = self.0[node].1;
            way.push(self.0[node].0.clone());
        }
        way
    }
}

impl ArmWay<'_> {
    fn is_free(&self, from: &[f64], to: &[f64], causes: &mut CauseTally) -> bool {
        let contact = contact(self.geometry, self.job, from, to, AllowedContacts::default());
        if let Some(contact) = contact {
            causes.count(contact.cause(self.geometry.problem()));
        }
        contact.is_none()
    }

    /// A way from the last of `near` to `to`: straight in configuration space; or first further along the hand's straight
    /// way; or by trees.
    fn find(
        &self,
        near: &[Configuration],
        to: &Configuration,
        context: &mut JobContext<'_>,
        causes: &mut CauseTally,
    ) -> Result<Option<Vec<Configuration>>, Interrupted> {
        let from = &near[near.len() - 1];
        if self.is_free(from, to, causes) {
            return Ok(Some(vec![from.clone(), to.clone()]));
        }
        let solver = &self.stage.solvers[self.job.robot.index()];
        let straight = retreat(self.geometry, solver, self.job, near, context)?;
        for (last, q) in straight.iter().enumerate().skip(1) {
            if self.is_free(q, to, causes) {
                let way = straight[..=last].iter().chain([to]).cloned().collect();
                return Ok(Some(self.shortened(way, causes)));
            }
        }
        let random = RandomStream::new(self.stage.seed, StageKind::Roadmap, &[&self.robot.name], "arm");
        let limit = (self.geometry.problem().levels.vertices as usize * TREE_FACTOR) << self.job.level.min(16);
        let chain = straight.iter().enumerate().map(|(i, q)| (q.clone(), i.saturating_sub(1)));
        let (mut grown, mut other) = (Tree(chain.collect()), Tree(vec![(to.clone(), 0)]));
        for index in 0..limit as u64 {
            if grown.0.len() + other.0.len() > limit || !context.spend(1)? {
                break;
            }
            let target = self.sample(&random, index, from);
            if let Some(new) = self.extend(&mut grown, &target, causes) {
                let goal = grown.0[new].0.clone();
                if let Some(meeting) = self.connect(&mut other, &goal, causes) {
                    let way = self.join(&grown, new, &other, meeting, from);
                    return Ok(Some(self.shortened(way, causes)));
                }
            }
            std::mem::swap(&mut grown, &mut other);
        }
        Ok(None)
    }

    /// A configuration with the base of `like` and the arm uniform within its limits (±π where unbounded).
    fn sample(&self, random: &RandomStream, index: u64, like: &[f64]) -> Configuration {
        let mut values = random.values(index);
        let mut q = like.to_vec();
        for i in self.robot.base_len()..q.len() {
            let coordinate = &self.robot.coordinates[i];
            let low = coordinate.lower.max(-std::f64::consts::PI);
            let high = coordinate.upper.min(std::f64::consts::PI);
            q[i] = low + values.next_unit() * (high - low);
        }
        q
    }

    fn nearest(&self, tree: &Tree, q: &[f64]) -> usize {
        let distance = |i: usize| self.robot.duration(&tree.0[i].0, q);
        (0..tree.0.len()).min_by(|a, b| distance(*a).total_cmp(&distance(*b))).unwrap_or(0)
    }

    /// One step towards a configuration; the new node, if the step is free.
    fn extend(&self, tree: &mut Tree, target: &[f64], causes: &mut CauseTally) -> Option<usize> {
        let near = self.nearest(tree, target);
        let from = tree.0[near].0.clone();
        let share = (EXTENSION_S / self.robot.duration(&from, target).max(f64::MIN_POSITIVE)).min(1.0);
        let to: Configuration = if share < 1.0 {
            from.iter().zip(target).map(|(a, b)| a + share * (b - a)).collect()
        } else {
            target.to_vec()
        };
        if from == to || !self.is_free(&from, &to, causes) {
            return None;
        }
        tree.0.push((to, near));
        Some(tree.0.len() - 1)
    }

    /// Steps towards a configuration until it is reached (its node) or blocked.
    fn connect(&self, tree: &mut Tree, target: &[f64], causes: &mut CauseTally) -> Option<usize> {
        loop {
            let new = self.extend(tree, target, causes)?;
            if tree.0[new].0 == target {
                return Some(new);
            }
        }
    }

    /// The whole way, beginning at `from`.
    fn join(&self, one: &Tree, node: usize, two: &Tree, meeting: usize, from: &Configuration) -> Vec<Configuration> {
        let mut way = one.way_to_root(node);
        way.reverse();
        way.extend(two.way_to_root(meeting).into_iter().skip(1));
        if &way[0] != from {
            way.reverse();
        }
        way
    }

    /// Greedy shortcuts: from each configuration to the furthest that is straight ahead.
    fn shortened(&self, way: Vec<Configuration>, causes: &mut CauseTally) -> Vec<Configuration> {
        let mut short = vec![way[0].clone()];
        let mut at = 0;
        while at + 1 < way.len() {
            let next = (at + 2..way.len()).rev().find(|j| self.is_free(&way[at], &way[*j], causes)).unwrap_or(at + 1);
            short.push(way[next].clone());
            at = next;
        }
        short
    }
}
