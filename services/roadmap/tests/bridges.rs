//! Base roadmaps through narrow doors.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use collision::{Geometry, Motion};
use contract::{
    Answer, CompositeMethod, Job, JobContext, MemoryProducts, PieceJob, PieceSpec, ProblemStatement, Product, Products,
    Request, RoadmapPiece, Stage,
};
use model::{Body, DiskFiles, FixedObject, Problem, RobotId, Shape, load_problem};
use nalgebra::Translation3;
use roadmap::RoadmapStage;

/// A hall of 8 m by 4 m, parted at x = 0 by a wall with a door at y = 0; the robot is in the west.
fn hall(door_m: Option<f64>) -> Problem {
    let path = format!("{}/../../launch/scenes/t01_one_robot.yaml", env!("CARGO_MANIFEST_DIR"));
    let mut problem = load_problem(&DiskFiles, &path).unwrap();
    let length = 2.0 - door_m.unwrap_or(0.0) / 2.0;
    let wall = |side: f64| Body {
        owner_from_shape: Translation3::new(0.0, side * (2.0 - length / 2.0), 0.5).into(),
        shape: Shape::Box { size: [0.1, length, 1.0] },
    };
    problem.fixed.truncate(0);
    problem.fixed.push(FixedObject {
        name: "divider".into(),
        world_from_object: nalgebra::Isometry3::identity(),
        bodies: vec![wall(1.0), wall(-1.0)],
    });
    let robot = &mut problem.robots[0];
    (robot.coordinates[0].lower, robot.coordinates[0].upper, robot.start[0]) = (-4.0, 4.0, -2.5);
    problem
}

fn base_piece(problem: &Problem, seed: u64) -> RoadmapPiece {
    let statement = ProblemStatement::new(problem.clone(), seed, CompositeMethod::Prioritised);
    let products = MemoryProducts::default();
    let piece = PieceJob { robot: RobotId(0), holding: None, level: 0, spec: PieceSpec::Base };
    let job = Job { request: Request::Piece(piece), budget: 50_000 };
    let mut context = JobContext::new(job.id(&statement), &job, &products, Arc::new(AtomicBool::new(false)));
    let stage = RoadmapStage::new(&statement).unwrap();
    match stage.refine(&job, &mut context).unwrap().result {
        Ok(Answer::Piece(product)) => match contract::decode(&products.get(&product.digest).unwrap()).unwrap() {
            Product::Piece(piece) => piece,
            other => panic!("{other:?}"),
        },
        other => panic!("{other:?}"),
    }
}

/// Vertices that can be reached from the start, and whether some of them are in the east.
fn reached(piece: &RoadmapPiece) -> (usize, bool) {
    let mut reached = vec![false; piece.vertices.len()];
    reached[0] = true;
    loop {
        let before = reached.clone();
        for edge in &piece.edges {
            let [a, b] = [edge.a.index(), edge.b.index()];
            (reached[a], reached[b]) = (before[a] || reached[b], before[b] || reached[a]);
        }
        if reached == before {
            let east = (0..reached.len()).any(|i| reached[i] && piece.vertices[i][0] > 0.5);
            return (reached.iter().filter(|reached| **reached).count(), east);
        }
    }
}

#[test]
fn a_base_roadmap_goes_through_a_narrow_door_whatever_the_seed_and_through_no_wall() {
    let (door, closed) = (hall(Some(0.66)), hall(None));
    let geometry = Geometry::new(&door).unwrap();
    for seed in 0..12 {
        let piece = base_piece(&door, seed);
        let (count, east) = reached(&piece);
        assert!(east && count > 60, "seed {seed}: {count} of {}", piece.vertices.len());
        for edge in &piece.edges {
            let from = piece.vertices[edge.a.index()].clone();
            let to = door.robots[0].short_way(&from, &piece.vertices[edge.b.index()]);
            let motion = Motion { robot: RobotId(0), holding: None, from, to, allowed: edge.allowed };
            assert_eq!(geometry.motion_contact(&motion), None, "seed {seed}");
        }
        assert!(!reached(&base_piece(&closed, seed)).1, "seed {seed}: through the wall");
    }
}
