//! Two robots without joints, three objects, three pairs.

use contract::{CompositeMethod, ProblemStatement, StageKind};
use model::{
    Body, EndEffector, EndPolicy, FixedId, LinkId, MovableObject, ObjectId, Pair, Pose, Problem, RegionId, Robot,
    RobotId, Shape,
};

use super::toy_implementation;

/// The toy problem's statement.
pub fn toy_statement(seed: u64) -> ProblemStatement {
    let problem = Problem {
        name: "toy".to_owned(),
        robots: ["r1", "r2"].map(robot).into(),
        fixed: Vec::new(),
        movable: ["a", "b", "c"].map(object).into(),
        regions: Vec::new(),
        pairs: vec![pair("p1", 0, 0), pair("p2", 0, 1), pair("p3", 1, 2)],
        orderings: Vec::new(),
        end_policies: vec![EndPolicy::Return; 2],
        settings: model::Settings::default(),
        levels: model::Levels::default(),
        search: model::SearchSettings::default(),
    };
    let mut statement = ProblemStatement::new(problem, seed, CompositeMethod::default());
    statement.implementations = StageKind::ALL.map(|stage| (stage, toy_implementation(stage))).into();
    statement
}

fn robot(name: &str) -> Robot {
    Robot {
        name: name.to_owned(),
        world_from_base: Pose::identity(),
        links: Vec::new(),
        joints: Vec::new(),
        coordinates: Vec::new(),
        base: None,
        end_effector: EndEffector {
            name: "hand".to_owned(),
            parent_link: LinkId(0),
            link_from_tool: Pose::identity(),
            links: Vec::new(),
            max_opening: 0.1,
        },
        disabled_pairs: Vec::new(),
        start: Vec::new(),
        home: Vec::new(),
        carry: Vec::new(),
    }
}

fn object(name: &str) -> MovableObject {
    MovableObject {
        name: name.to_owned(),
        body: Body { owner_from_shape: Pose::identity(), shape: Shape::Sphere { radius: 0.1 } },
        world_from_start: Pose::identity(),
        start_support: Some(FixedId(0)),
        grasps: vec![Vec::new(); 2],
    }
}

fn pair(name: &str, robot: usize, object: usize) -> Pair {
    Pair {
        name: name.to_owned(),
        robot: RobotId::at(robot),
        object: ObjectId::at(object),
        from: RegionId(0),
        to: RegionId(0),
        hop: 1,
    }
}
