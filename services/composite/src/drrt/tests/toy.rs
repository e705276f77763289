//! Toy problems: robots with a base and one arm joint, whose first coordinate names a place; no geometry at all.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use contract::{
    Commitment, ComposeJob, CompositeMethod, Composition, Digest, Edge, EdgeKind, FailureReport, Interrupted, Job,
    JobContext, JobId, MemoryProducts, ModeRoadmap, ProblemStatement, Request, VertexId,
};
use model::{
    AllowedContacts, Coordinate, EndEffector, EndPolicy, GivenOrdering, GraspId, Holding, Levels, Link, LinkId,
    ObjectId, Pair, PlanarBase, Point, Pose, Problem, RegionId, Robot, RobotId, SearchSettings, Settings,
};
use skeleton::{ModeId, Occupancy, Skeleton};

use super::super::{CompositeValidity, TimedEdge, drrt_with};
use crate::CommittedMotion;

/// A linear congruential generator, so that tests do not share their randomness with what they test.
pub struct Dice(u64);

impl Dice {
    pub fn new(seed: u64) -> Self {
        let mut dice = Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x2545_f491_4f6c_dd1d);
        (0..4).for_each(|_| {
            dice.below(2);
        });
        dice
    }

    pub fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % n
    }

    pub fn chance(&mut self, p: f64) -> bool {
        (self.below(1_000_000) as f64) < p * 1e6
    }
}

/// Conflicts and hits as functions of places: of robot, step of its mode, and places at both ends.
pub type Place = (usize, u32, usize, usize);

/// Geometry given by two functions.
pub struct Table {
    pub conflict: Box<dyn Fn(Place, Place) -> bool>,
    pub hit: Box<dyn Fn(Place, Occupancy) -> bool>,
}

/// The place that a configuration names; arm-out configurations are at the same place as folded ones.
pub fn place(q: &[f64]) -> usize {
    q[0].round() as usize
}

impl CompositeValidity for Table {
    fn edges_conflict(&self, a: &TimedEdge, b: &TimedEdge) -> bool {
        (self.conflict)(named(a), named(b))
    }

    fn stand_hits(&self, stand: &TimedEdge, occupancy: Occupancy) -> bool {
        (self.hit)(named(stand), occupancy)
    }
}

fn named(edge: &TimedEdge) -> Place {
    let mode = edge.edge.mode;
    (mode.robot.index(), mode.step, place(&edge.travel.from), place(&edge.travel.to))
}

/// A problem, its roadmaps and its geometry.
pub struct Toy {
    pub statement: ProblemStatement,
    pub skeleton: Skeleton,
    pub roadmaps: Vec<Vec<ModeRoadmap>>,
    pub table: Table,
}

/// One pair of the task: robot, object. Hops follow the order of this list.
pub type Task = (usize, usize);

/// An ordering between points of pairs; pairs are counted robot by robot.
pub type Order = ((usize, Point), (usize, Point));

/// A problem without shapes. `starts`: place at which each robot starts.
pub fn problem(starts: &[usize], tasks: &[Task], objects: usize, orders: &[Order], grip_time: f64) -> Problem {
    let mut hops = vec![0; objects];
    let mut pairs: Vec<(usize, Pair)> = tasks
        .iter()
        .map(|(robot, object)| {
            hops[*object] += 1;
            let pair = Pair {
                name: String::new(),
                robot: RobotId::at(*robot),
                object: ObjectId::at(*object),
                from: RegionId(0),
                to: RegionId(0),
                hop: hops[*object],
            };
            (*robot, pair)
        })
        .collect();
    pairs.sort_by_key(|(robot, _)| *robot);
    let mut pairs: Vec<Pair> = pairs.into_iter().map(|(_, pair)| pair).collect();
    pairs.iter_mut().enumerate().for_each(|(i, pair)| pair.name = format!("p{i}"));
    let orderings = orders.iter().map(|((a, p), (b, q))| GivenOrdering {
        before: (model::PairId::at(*a), *p),
        after: (model::PairId::at(*b), *q),
    });
    Problem {
        name: "toy".to_owned(),
        robots: starts.iter().enumerate().map(|(i, start)| robot(i, *start)).collect(),
        fixed: Vec::new(),
        movable: (0..objects).map(movable).collect(),
        regions: Vec::new(),
        pairs,
        orderings: orderings.collect(),
        end_policies: vec![EndPolicy::Return; starts.len()],
        settings: Settings { grip_time, ..Settings::default() },
        levels: Levels::default(),
        search: SearchSettings::default(),
    }
}

fn robot(index: usize, start: usize) -> Robot {
    let coordinate =
        |name: &str, bound: f64| Coordinate { name: name.to_owned(), lower: -bound, upper: bound, velocity: 1e9 };
    Robot {
        name: format!("r{index}"),
        world_from_base: Pose::identity(),
        links: vec![Link { name: "base".to_owned(), bodies: Vec::new() }],
        joints: Vec::new(),
        coordinates: vec![
            coordinate("v/x", 1e3),
            coordinate("v/y", 1e3),
            coordinate("v/yaw", f64::INFINITY),
            coordinate("arm", 10.0),
        ],
        base: Some(PlanarBase { speed: 1e9, yaw_rate: 1e9 }),
        end_effector: EndEffector {
            name: "hand".to_owned(),
            parent_link: LinkId(0),
            link_from_tool: Pose::identity(),
            links: vec![LinkId(0)],
            max_opening: 0.1,
        },
        disabled_pairs: Vec::new(),
        start: configuration(start, false),
        home: vec![0.0],
        carry: vec![0.0],
    }
}

fn movable(index: usize) -> model::MovableObject {
    model::MovableObject {
        name: format!("m{index}"),
        body: model::Body { owner_from_shape: Pose::identity(), shape: model::Shape::Sphere { radius: 0.1 } },
        world_from_start: Pose::identity(),
        start_support: None,
        grasps: Vec::new(),
    }
}

/// The configuration at a place.
pub fn configuration(place: usize, arm_out: bool) -> Vec<f64> {
    vec![place as f64, 0.0, 0.0, if arm_out { 1.0 } else { 0.0 }]
}

/// An edge without contacts.
pub fn edge(a: usize, b: usize, kind: EdgeKind, duration_s: f64, blockers: Vec<u32>) -> Edge {
    let allowed = AllowedContacts::default();
    Edge { a: VertexId::at(a), b: VertexId::at(b), kind, allowed, duration_s, blockers }
}

/// A roadmap whose costs to go the search has to find itself.
pub fn roadmap(
    robot: usize,
    step: usize,
    vertices: Vec<Vec<f64>>,
    edges: Vec<Edge>,
    start: usize,
    goal: usize,
    possible: Vec<Occupancy>,
) -> ModeRoadmap {
    ModeRoadmap {
        mode: ModeId { robot: RobotId::at(robot), step: step as u32 },
        // Each mode is another motion, though the places may be the same.
        holding: Some(Holding { object: ObjectId(0), grasp: GraspId::at(step) }),
        cost_to_go_s: vec![0.0; vertices.len()],
        vertices,
        edges,
        start: VertexId::at(start),
        goal: VertexId::at(goal),
        parking: Vec::new(),
        possible,
    }
}

/// Rooms without walls: places joined by edges, the same for all robots; no two robots at one place.
pub struct Places {
    pub edges: Vec<(usize, usize, f64)>,
    pub starts: Vec<usize>,
    /// Robot, object, place of the pick, place of the release.
    pub tasks: Vec<(usize, usize, usize, usize)>,
    pub objects: usize,
    pub orders: Vec<Order>,
    /// Places that an object blocks while it stands at one of its poses.
    pub blocks: Vec<(Occupancy, usize)>,
    pub grip_time: f64,
}

/// Time of an arm motion in [`Places`] (s).
pub const ARM_S: f64 = 0.4;

impl Places {
    /// The toy, with a random seed for the search.
    pub fn toy(&self, seed: u64) -> Toy {
        let tasks: Vec<Task> = self.tasks.iter().map(|(robot, object, _, _)| (*robot, *object)).collect();
        let problem = problem(&self.starts, &tasks, self.objects, &self.orders, self.grip_time);
        let skeleton = Skeleton::of_problem(&problem).unwrap();
        let roadmaps = (0..self.starts.len()).map(|robot| self.roadmaps(robot, &skeleton)).collect();
        let share = |a: Place, b: Place| [a.2, a.3].iter().any(|place| [b.2, b.3].contains(place));
        let blocks = self.blocks.clone();
        let hit = move |stand: Place, occupancy| blocks.contains(&(occupancy, stand.2));
        let table = Table { conflict: Box::new(share), hit: Box::new(hit) };
        Toy { statement: ProblemStatement::new(problem, seed, CompositeMethod::Drrt), skeleton, roadmaps, table }
    }

    fn roadmaps(&self, robot: usize, skeleton: &Skeleton) -> Vec<ModeRoadmap> {
        let own = self.tasks.iter().filter(|task| task.0 == robot);
        let mut stops: Vec<(usize, bool)> = vec![(self.starts[robot], false)];
        stops.extend(own.flat_map(|task| [(task.2, true), (task.3, true)]));
        if stops.len() == 1 {
            return Vec::new();
        }
        stops.push((self.starts[robot], false));
        let ends = stops.windows(2).enumerate();
        ends.map(|(step, ends)| self.mode(robot, step, ends[0], ends[1], skeleton)).collect()
    }

    fn mode(
        &self,
        robot: usize,
        step: usize,
        start: (usize, bool),
        goal: (usize, bool),
        skeleton: &Skeleton,
    ) -> ModeRoadmap {
        let places = self.edges.iter().map(|(a, b, _)| a.max(b) + 1).max().unwrap_or(1);
        let possible: Vec<Occupancy> = skeleton.occupancies().collect();
        let blockers = |ends: &[usize]| -> Vec<u32> {
            let blocked =
                |i: &u32| self.blocks.iter().any(|(o, place)| *o == possible[*i as usize] && ends.contains(place));
            (0..possible.len() as u32).filter(blocked).collect()
        };
        let mut vertices: Vec<Vec<f64>> = (0..places).map(|place| configuration(place, false)).collect();
        let mut edges: Vec<Edge> =
            self.edges.iter().map(|(a, b, d)| edge(*a, *b, EdgeKind::Base, *d, blockers(&[*a, *b]))).collect();
        let mut end = |(place, is_out): (usize, bool)| {
            if !is_out {
                return place;
            }
            let q = configuration(place, true);
            let known = vertices.iter().position(|v| *v == q);
            known.unwrap_or_else(|| {
                vertices.push(q);
                edges.push(edge(place, vertices.len() - 1, EdgeKind::Arm, ARM_S, blockers(&[place])));
                vertices.len() - 1
            })
        };
        let (start, goal) = (end(start), end(goal));
        ModeRoadmap { holding: None, ..roadmap(robot, step, vertices, edges, start, goal, possible) }
    }
}

/// What a search gave, and the work it took.
pub type Outcome = Result<Result<Vec<Commitment>, FailureReport>, Interrupted>;

impl Toy {
    /// Calls `work` with a context that has a budget.
    pub fn with_context<T>(&self, budget: u64, work: impl FnOnce(&mut JobContext<'_>) -> T) -> T {
        self.with_flag(budget, false, work)
    }

    /// The same, cancelled or not.
    pub fn with_flag<T>(&self, budget: u64, cancelled: bool, work: impl FnOnce(&mut JobContext<'_>) -> T) -> T {
        let products = MemoryProducts::default();
        let composition = Composition::Drrt { prefix: None, roadmaps: Vec::new() };
        let assignment = contract::Assignment { poses: Vec::new(), grasps: Vec::new(), orders: Vec::new() };
        let job = Job { request: Request::Compose(ComposeJob { assignment, composition }), budget };
        let flag = Arc::new(AtomicBool::new(cancelled));
        work(&mut JobContext::new(JobId(Digest([0; 32])), &job, &products, flag))
    }

    /// Searches after a prefix within a budget; also the work units spent.
    pub fn solve_after(&self, done: &[Commitment], budget: u64) -> (Outcome, u64) {
        self.with_context(budget, |context| {
            let done = CommittedMotion::from(done.to_vec());
            let outcome = drrt_with(&self.statement, &self.skeleton, &done, &self.roadmaps, &self.table, context);
            (outcome, context.spent())
        })
    }

    /// Searches from the beginning.
    pub fn solve(&self, budget: u64) -> Result<Vec<Commitment>, Box<FailureReport>> {
        self.solve_after(&[], budget).0.unwrap().map_err(Box::new)
    }
}

/// Which events have happened when the robots are in these modes (by step): an event ends its mode.
pub fn present(skeleton: &Skeleton, modes: &[usize]) -> BTreeMap<Occupancy, bool> {
    let happened = |event: skeleton::Event| {
        let ended =
            |robot: usize, mode: &skeleton::Mode| mode.ends == Some(event) && modes[robot] > mode.id.step as usize;
        skeleton.modes.iter().enumerate().any(|(robot, own)| own.iter().any(|mode| ended(robot, mode)))
    };
    let is_present = |occupancy: Occupancy| {
        let interval = skeleton.interval_of(occupancy);
        interval.from.is_none_or(happened) && !interval.to.is_some_and(happened)
    };
    skeleton.occupancies().map(|occupancy| (occupancy, is_present(occupancy))).collect()
}
