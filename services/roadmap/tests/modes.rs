//! Pieces and mode roadmaps of real scenes; every edge is checked against dense sampling of its motion.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use collision::{Geometry, Motion};
use contract::{
    Answer, CompositeMethod, Edge, Job, JobContext, MemoryProducts, ModeJob, ModeRoadmap, Obstruction, Outcome,
    PieceJob, PieceSpec, ProblemStatement, Product, ProductRef, Products, RandomStream, Request, Stage, StageKind,
};
use model::{DiskFiles, FixedObject, ObjectId, Problem, RobotId, Standing, load_problem};
use nalgebra::Translation3;
use plan::{BodyRef, Cause};
use roadmap::RoadmapStage;
use skeleton::{ModeId, Occupancy};

struct Bench {
    statement: ProblemStatement,
    stage: RoadmapStage,
    geometry: Geometry,
    products: MemoryProducts,
}

impl Bench {
    fn new(problem: Problem) -> Self {
        let statement = ProblemStatement::new(problem, 3, CompositeMethod::Prioritised);
        Self {
            stage: RoadmapStage::new(&statement).unwrap(),
            geometry: Geometry::new(&statement.problem).unwrap(),
            products: MemoryProducts::default(),
            statement,
        }
    }

    fn of_scene(name: &str) -> Self {
        let path = format!("{}/../../launch/scenes/{name}.yaml", env!("CARGO_MANIFEST_DIR"));
        Self::new(load_problem(&DiskFiles, &path).unwrap())
    }

    fn ask(&self, request: Request) -> Outcome {
        let job = Job { request, budget: 1_000_000 };
        let id = job.id(&self.statement);
        let mut context = JobContext::new(id, &job, &self.products, Arc::new(AtomicBool::new(false)));
        self.stage.refine(&job, &mut context).unwrap()
    }

    fn base(&self, robot: RobotId, level: u32) -> ProductRef {
        let spec = PieceSpec::Base;
        match self.ask(Request::Piece(PieceJob { robot, holding: None, level, spec })).result {
            Ok(Answer::Piece(product)) => product,
            other => panic!("{other:?}"),
        }
    }

    fn product(&self, wanted: &ProductRef) -> Product {
        contract::decode(&self.products.get(&wanted.digest).unwrap()).unwrap()
    }

    /// A drive from the start stand to another stand of the first robot.
    fn drive(&self, to: [f64; 3], certain: Vec<Obstruction>, possible: Vec<Obstruction>) -> Outcome {
        let robot = RobotId(0);
        let start = self.statement.problem.robot(robot).start.clone();
        let goal = [&to, &start[3..]].concat();
        self.ask(Request::Mode(ModeJob {
            mode: ModeId { robot, step: 0 },
            holding: None,
            start,
            goal,
            base: Some(self.base(robot, 0)),
            start_arm: None,
            goal_arm: None,
            certain,
            possible,
            level: 0,
        }))
    }

    fn roadmap(&self, outcome: Outcome) -> (ModeRoadmap, f64, Vec<u32>) {
        match outcome.result {
            Ok(Answer::Mode { roadmap, shortest_s, in_the_way }) => match self.product(&roadmap) {
                Product::Mode(roadmap) => (roadmap, shortest_s, in_the_way),
                other => panic!("{other:?}"),
            },
            other => panic!("{other:?}"),
        }
    }

    /// No sampled configuration of the edge touches itself, fixed objects or the obstacles.
    fn assert_free(&self, vertices: &[Vec<f64>], edge: &Edge, robot: RobotId, obstacles: &[Standing]) {
        let from = &vertices[edge.a.index()];
        let to = self.statement.problem.robot(robot).short_way(from, &vertices[edge.b.index()]);
        for i in 0..=40 {
            let q: Vec<f64> = from.iter().zip(&to).map(|(a, b)| a + (b - a) * f64::from(i) / 40.0).collect();
            assert_eq!(self.geometry.state_contact(robot, None, &q, edge.allowed), None);
            for standing in obstacles {
                assert_eq!(self.geometry.state_hits(robot, None, &q, edge.allowed, standing), None);
            }
        }
    }
}

/// An object that stands on the floor at (x, y), tall enough to be hit by a base.
fn on_the_floor(problem: &Problem, object: u32, x: f64, y: f64) -> Obstruction {
    let object = ObjectId(object);
    let height = problem.movable[object.index()].origin_height();
    let standing = Standing { object, world_from_object: Translation3::new(x, y, height).into() };
    Obstruction { occupancy: Occupancy { object, hop: 0 }, standing }
}

#[test]
fn every_edge_of_figure_1s_base_roadmaps_is_free_at_dense_samples() {
    let bench = Bench::of_scene("figure1");
    for robot in bench.statement.problem.robot_ids() {
        let Product::Piece(piece) = bench.product(&bench.base(robot, 0)) else { panic!("no piece") };
        assert!(piece.vertices.len() >= 60 && piece.edges.len() >= 60);
        for edge in &piece.edges {
            bench.assert_free(&piece.vertices, edge, robot, &[]);
        }
    }
}

#[test]
fn a_level_contains_the_samples_of_the_level_below() {
    let bench = Bench::of_scene("figure1");
    let [low, high] = [0, 1].map(|level| match bench.product(&bench.base(RobotId(0), level)) {
        Product::Piece(piece) => piece,
        other => panic!("{other:?}"),
    });
    assert!(high.vertices.len() > low.vertices.len());
    assert_eq!(high.vertices[..low.vertices.len()], low.vertices[..]);
}

#[test]
fn a_certain_object_removes_edges_and_a_possible_one_only_marks_them() {
    let bench = Bench::of_scene("figure1");
    let problem = &bench.statement.problem;
    let start = &problem.robots[0].start;
    let goal = [start[0] - 0.9, start[1], start[2]];
    let box_between = on_the_floor(problem, 0, start[0] - 0.45, start[1]);
    let (free, _, none) = bench.roadmap(bench.drive(goal, Vec::new(), Vec::new()));
    assert!(none.is_empty());
    let (marked, _, _) = bench.roadmap(bench.drive(goal, Vec::new(), vec![box_between.clone()]));
    let (removed, longer, _) = bench.roadmap(bench.drive(goal, vec![box_between.clone()], Vec::new()));
    assert_eq!(marked.edges.len(), free.edges.len());
    let blocked = marked.edges.iter().filter(|edge| edge.blockers == [0]).count();
    assert!(blocked > 0);
    assert_eq!(removed.edges.len(), free.edges.len() - blocked);
    assert!(longer > 0.9 / problem.robots[0].base.as_ref().unwrap().speed);
    for edge in &removed.edges {
        bench.assert_free(&removed.vertices, edge, RobotId(0), &[box_between.standing]);
    }
}

/// Objects on the floor round the first robot, as random values have it.
fn scattered(problem: &Problem, seed: u64, count: u64) -> Vec<Obstruction> {
    let start = &problem.robots[0].start;
    let random = RandomStream::new(seed, StageKind::Roadmap, &["test"], "scattered");
    let place = |index: u64| {
        let [object, x, y]: [f64; 3] = random.unit(index);
        on_the_floor(
            problem,
            (object * problem.movable.len() as f64) as u32,
            start[0] - 2.5 * x,
            start[1] + 3.0 * y - 1.5,
        )
    };
    (0..count).map(place).collect()
}

#[test]
fn every_edge_is_marked_with_the_objects_that_its_motion_hits_and_no_others() {
    let bench = Bench::of_scene("figure1");
    let robot = bench.statement.problem.robot(RobotId(0));
    let start = &robot.start;
    let (mut hits, mut misses) = (0, 0);
    for seed in 0..6 {
        let possible = scattered(&bench.statement.problem, seed, 5);
        let goal = [start[0] - 0.9, start[1], start[2] + 0.1 * seed as f64];
        let (roadmap, ..) = bench.roadmap(bench.drive(goal, Vec::new(), possible.clone()));
        for edge in &roadmap.edges {
            let from = roadmap.vertices[edge.a.index()].clone();
            let to = robot.short_way(&from, &roadmap.vertices[edge.b.index()]);
            let motion = Motion { robot: RobotId(0), holding: None, from, to, allowed: edge.allowed };
            for (index, obstruction) in (0_u32..).zip(&possible) {
                let hit = bench.geometry.motion_hits(&motion, &obstruction.standing).is_some();
                assert_eq!(edge.blockers.contains(&index), hit, "seed {seed}, edge {edge:?}, object {index}");
                (hits, misses) = (hits + usize::from(hit), misses + usize::from(!hit));
            }
        }
    }
    assert!(hits > 300 && misses > 300, "{hits} hits, {misses} misses");
}

#[test]
fn what_a_stage_remembers_changes_no_answer_and_no_work() {
    let experienced = Bench::of_scene("figure1");
    let problem = &experienced.statement.problem;
    let start = &problem.robots[0].start;
    // The same goals and poses come again and again, in other company.
    for round in 0..8_u64 {
        let mut poses = scattered(problem, round % 3, 3);
        poses.extend(scattered(problem, round % 2 + 10, 2));
        let certain = poses.split_off(2 + round as usize % 3);
        let goal = [start[0] - 0.9, start[1], start[2] + 0.2 * (round % 2) as f64];
        let fresh = Bench::of_scene("figure1");
        let outcomes = [&experienced, &fresh].map(|bench| bench.drive(goal, certain.clone(), poses.clone()));
        // Products are named by their content.
        assert_eq!(outcomes[0], outcomes[1], "round {round}");
    }
}

#[test]
fn cost_to_go_equals_that_of_repeated_relaxation() {
    let bench = Bench::of_scene("figure1");
    let start = &bench.statement.problem.robots[0].start;
    let goal = [start[0] - 0.9, start[1] + 0.5, start[2] + 2.0];
    let (roadmap, shortest_s, _) = bench.roadmap(bench.drive(goal, Vec::new(), Vec::new()));
    let mut cost = vec![f64::INFINITY; roadmap.vertices.len()];
    cost[roadmap.goal.index()] = 0.0;
    for _ in 0..roadmap.vertices.len() {
        for edge in &roadmap.edges {
            let (a, b) = (edge.a.index(), edge.b.index());
            cost[a] = cost[a].min(cost[b] + edge.duration_s);
            cost[b] = cost[b].min(cost[a] + edge.duration_s);
        }
    }
    assert_eq!(cost, roadmap.cost_to_go_s);
    assert_eq!(shortest_s, cost[roadmap.start.index()]);
}

/// The annex of figure 1 cut in two by a wall with a gap of `gap` metres.
fn divided(gap: f64) -> Problem {
    let path = format!("{}/../../launch/scenes/figure1.yaml", env!("CARGO_MANIFEST_DIR"));
    let mut problem = load_problem(&DiskFiles, &path).unwrap();
    let wall = |y: f64, length: f64| model::Body {
        owner_from_shape: Translation3::new(-5.8, y, 0.5).into(),
        shape: model::Shape::Box { size: [0.1, length, 1.0] },
    };
    let half = (4.0 - gap) / 2.0;
    let bodies = vec![wall(-half / 2.0, half), wall(-4.0 + half / 2.0, half)];
    problem.fixed.push(FixedObject {
        name: "divider".into(),
        world_from_object: nalgebra::Isometry3::identity(),
        bodies,
    });
    problem
}

#[test]
fn objects_that_close_the_only_gap_are_named_as_the_least_blocking_set() {
    let bench = Bench::new(divided(0.9));
    let problem = &bench.statement.problem;
    let goal = [-6.4, -2.0, 0.0];
    let (_, _, none) = bench.roadmap(bench.drive(goal, Vec::new(), Vec::new()));
    assert!(none.is_empty());
    let in_gap = on_the_floor(problem, 1, -5.8, -2.0);
    let elsewhere = on_the_floor(problem, 2, -4.0, -3.5);
    let (_, _, in_the_way) = bench.roadmap(bench.drive(goal, Vec::new(), vec![elsewhere.clone(), in_gap.clone()]));
    assert_eq!(in_the_way, [1]);
    let report = bench.drive(goal, vec![elsewhere, in_gap], Vec::new()).result.unwrap_err();
    let named = BodyRef::Object(problem.movable[1].name.clone());
    assert!(matches!(&report.causes[0].0, Cause::NoPath { blocking, .. } if *blocking == [named]), "{report:?}");
}

#[test]
fn a_wall_without_a_gap_blocks_with_no_object_to_blame() {
    let bench = Bench::new(divided(0.3));
    let report = bench.drive([-6.4, -2.0, 0.0], Vec::new(), Vec::new()).result.unwrap_err();
    assert!(matches!(&report.causes[0].0, Cause::NoPath { blocking, .. } if blocking.is_empty()), "{report:?}");
}

#[test]
fn an_arm_piece_runs_from_the_folded_arm_to_the_object_and_is_free() {
    let bench = Bench::of_scene("t00_one_arm");
    let robot = RobotId(0);
    let model = bench.statement.problem.robot(robot);
    let mut turned = model.home.clone();
    turned[0] += 0.6;
    let spec = PieceSpec::Arm { stand: Vec::new(), near: vec![turned.clone()], lift_up: 0, support: None, touch: None };
    let outcome = bench.ask(Request::Piece(PieceJob { robot, holding: None, level: 0, spec }));
    let Ok(Answer::Piece(product)) = outcome.result else { panic!("{outcome:?}") };
    let Product::Piece(piece) = bench.product(&product) else { panic!("no piece") };
    assert_eq!(piece.vertices[..2], [model.home.clone(), turned]);
    for edge in &piece.edges {
        bench.assert_free(&piece.vertices, edge, robot, &[]);
    }
}

#[test]
fn a_job_with_configurations_of_another_robot_is_unfit_and_not_a_panic() {
    let bench = Bench::of_scene("figure1");
    let spec = PieceSpec::Arm { stand: vec![0.0], near: vec![vec![0.0; 2]], lift_up: 0, support: None, touch: None };
    let job =
        Job { request: Request::Piece(PieceJob { robot: RobotId(0), holding: None, level: 0, spec }), budget: 10 };
    let mut context =
        JobContext::new(job.id(&bench.statement), &job, &bench.products, Arc::new(AtomicBool::new(false)));
    assert!(bench.stage.refine(&job, &mut context).is_err());
    // The geometry itself stays usable.
    let q = bench.statement.problem.robots[0].start.clone();
    let still = Motion { robot: RobotId(0), holding: None, from: q.clone(), to: q, allowed: Default::default() };
    assert_eq!(bench.geometry.motion_contact(&still), None);
}
