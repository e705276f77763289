//! Scenes of tables with a region each, questions to the stage, and a check of candidates that shares no code with it.
#![allow(dead_code, reason = "every test file uses its own part")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "its input is its own")]

pub mod check;

pub use check::assert_sound;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use contract::{
    Answer, CompositeMethod, FailureReport, Interrupted, Job, JobContext, JobId, Literal, MemoryProducts, Outcome,
    PlacementCandidate, PlacementJob, ProblemStatement, Request, Stage,
};
use model::{
    Body, DiskFiles, EndEffector, EndPolicy, FixedId, FixedObject, GivenOrdering, Levels, Link, LinkId, MovableObject,
    ObjectId, Pair, PairId, Point, Pose, Problem, Region, RegionId, Robot, RobotId, SearchSettings, Settings, Shape,
    load_problem,
};
use placement::PlacementStage;
use skeleton::Event;

/// The carton of the paper's task (m).
pub const CARTON: [f64; 3] = [0.07, 0.05, 0.15];
/// Room for one carton with 5 mm to the border, not for two (m).
pub const ONE_SLOT: [f64; 2] = [0.09, 0.07];
/// Room for many (m).
pub const WIDE: [f64; 2] = [0.6, 0.5];
/// Height of all tables (m).
pub const TOP: f64 = 0.6;

/// A problem under construction: tables 2 m apart, each with one region of the same name in the middle of its top.
pub struct Scene(pub Problem);

impl Scene {
    pub fn new(robots: usize) -> Self {
        Self(Problem {
            name: "scene".into(),
            robots: (1..=robots).map(|i| robot(format!("r{i}"))).collect(),
            fixed: vec![],
            movable: vec![],
            regions: vec![],
            pairs: vec![],
            orderings: vec![],
            end_policies: vec![EndPolicy::Return; robots],
            settings: Settings::default(),
            levels: Levels::default(),
            search: SearchSettings::default(),
        })
    }

    pub fn table(mut self, name: &str, region_size: [f64; 2]) -> Self {
        let x = 2.0 * self.0.fixed.len() as f64;
        self = self.fixed(&format!("table {name}"), [1.0, 1.0, TOP], Pose::translation(x, 0.0, TOP / 2.0));
        let support = FixedId::at(self.0.fixed.len() - 1);
        self.region(name, support, Pose::translation(x, 0.0, TOP), region_size)
    }

    pub fn fixed(mut self, name: &str, size: [f64; 3], world_from_object: Pose) -> Self {
        let body = Body { owner_from_shape: Pose::identity(), shape: Shape::Box { size } };
        self.0.fixed.push(FixedObject { name: name.into(), world_from_object, bodies: vec![body] });
        self
    }

    pub fn region(mut self, name: &str, support: FixedId, world_from_region: Pose, size: [f64; 2]) -> Self {
        self.0.regions.push(Region { name: name.into(), world_from_region, size, support });
        self
    }

    /// A carton that stands in a region, off its middle by `x`, `y` (m).
    pub fn carton(self, name: &str, region: &str, [x, y]: [f64; 2]) -> Self {
        self.object(name, Shape::Box { size: CARTON }, region, [x, y])
    }

    pub fn object(mut self, name: &str, shape: Shape, region: &str, [x, y]: [f64; 2]) -> Self {
        let body = Body { owner_from_shape: Pose::identity(), shape };
        let (start, grasps) = (Pose::identity(), vec![vec![]; self.0.robots.len()]);
        let mut object =
            MovableObject { name: name.into(), body, world_from_start: start, start_support: None, grasps };
        let region = &self.0.regions[self.region_id(region).index()];
        object.world_from_start = region.world_from_region * Pose::translation(x, y, object.origin_height());
        self.0.movable.push(object);
        self
    }

    /// The next pair of robot `robot` (from 1). All pairs of a robot must be given before those of the next.
    pub fn moves(mut self, robot: usize, object: &str, from: &str, to: &str) -> Self {
        let of_robot = self.0.pairs.iter().filter(|pair| pair.robot.index() + 1 == robot).count();
        let object = self.object_id(object);
        let (from, to) = (self.region_id(from), self.region_id(to));
        let name = format!("r{robot}.{}", of_robot + 1);
        self.0.pairs.push(Pair { name, robot: RobotId::at(robot - 1), object, from, to, hop: 0 });
        let hop = self.0.pairs.iter().filter(|pair| pair.object == object).count() as u32;
        self.0.pairs.last_mut().unwrap().hop = hop;
        self
    }

    pub fn before(mut self, before: (&str, Point), after: (&str, Point)) -> Self {
        let [before, after] = [before, after].map(|(pair, point)| (pair_id(&self.0, pair), point));
        self.0.orderings.push(GivenOrdering { before, after });
        self
    }

    fn region_id(&self, name: &str) -> RegionId {
        RegionId::at(self.0.regions.iter().position(|region| region.name == name).unwrap())
    }

    fn object_id(&self, name: &str) -> ObjectId {
        ObjectId::at(self.0.movable.iter().position(|object| object.name == name).unwrap())
    }
}

fn robot(name: String) -> Robot {
    Robot {
        name,
        world_from_base: Pose::identity(),
        links: vec![Link { name: "base".into(), bodies: vec![] }],
        joints: vec![],
        coordinates: vec![],
        base: None,
        end_effector: EndEffector {
            name: "hand".into(),
            parent_link: LinkId(0),
            link_from_tool: Pose::identity(),
            links: vec![],
            max_opening: 0.1,
        },
        disabled_pairs: vec![],
        start: vec![],
        home: vec![],
        carry: vec![],
    }
}

pub fn pair_id(problem: &Problem, name: &str) -> PairId {
    PairId::at(problem.pairs.iter().position(|pair| pair.name == name).unwrap())
}

/// A scene that comes with the program.
pub fn shipped(name: &str) -> Problem {
    let path = format!("{}/../../launch/scenes/{name}.yaml", env!("CARGO_MANIFEST_DIR"));
    load_problem(&DiskFiles, &path).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// The stage for a problem.
pub fn stage(problem: &Problem, seed: u64) -> PlacementStage {
    PlacementStage::new(&ProblemStatement::new(problem.clone(), seed, CompositeMethod::default())).unwrap()
}

pub fn job(level: u32, first: u32, count: u32, nogoods: Vec<Vec<Literal>>) -> Job {
    Job { request: Request::Placement(PlacementJob { level, first, count, nogoods }), budget: 4_000_000 }
}

pub fn ask(stage: &PlacementStage, job: &Job) -> Result<Outcome, Interrupted> {
    let id = JobId(contract::Digest([0; 32]));
    let products = MemoryProducts::default();
    let mut context = JobContext::new(id, job, &products, Arc::new(AtomicBool::new(false)));
    stage.refine(job, &mut context)
}

pub fn candidates(stage: &PlacementStage, job: &Job) -> Vec<PlacementCandidate> {
    match ask(stage, job).unwrap().result {
        Ok(Answer::Placements(candidates)) => candidates,
        other => panic!("no candidates but {other:?}"),
    }
}

/// The first candidate, checked.
pub fn first_candidate(problem: &Problem) -> PlacementCandidate {
    let found = candidates(&stage(problem, 0), &job(0, 0, 1, vec![]));
    assert_eq!(found.len(), 1);
    assert_sound(problem, &found[0]);
    found.into_iter().next().unwrap()
}

pub fn failure(problem: &Problem) -> FailureReport {
    match ask(&stage(problem, 0), &job(0, 0, 1, vec![])).unwrap().result {
        Err(report) => report,
        Ok(answer) => panic!("no failure but {answer:?}"),
    }
}

/// Orders of a candidate in words: `grasp of r2.1 < release of r1.1`.
pub fn orders(problem: &Problem, candidate: &PlacementCandidate) -> Vec<String> {
    let words = |event: Event| event.describe(problem);
    let mut orders: Vec<String> =
        candidate.orders.iter().map(|order| format!("{} < {}", words(order.before), words(order.after))).collect();
    orders.sort();
    orders
}
