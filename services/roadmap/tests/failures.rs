//! What it rests on that a mode has no way: a least set of certain poses, and the alternatives at whose end the arm is cut
//! off, as the stage itself tells when it is asked about less.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use contract::{
    Answer, Choice, CompositeMethod, FailureReport, Job, JobContext, MemoryProducts, ModeJob, Obstruction, Outcome,
    PieceJob, PieceSpec, ProblemStatement, ProductRef, Request, Stage,
};
use kinematics::link_pose;
use model::{Configuration, DiskFiles, FixedObject, ObjectId, PairId, Problem, RobotId, Standing, load_problem};
use nalgebra::Translation3;
use roadmap::RoadmapStage;
use skeleton::{ModeId, Occupancy};

const ROBOT: RobotId = RobotId(0);
/// On the other side of the gaps.
const FAR_STAND: [f64; 3] = [-6.4, -2.0, 0.0];

/// SplitMix64: numbers from 0 to 1.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}

/// The annex of figure 1 cut in two by a wall with two gaps.
fn divided() -> Problem {
    let path = format!("{}/../../launch/scenes/figure1.yaml", env!("CARGO_MANIFEST_DIR"));
    let mut problem = load_problem(&DiskFiles, &path).unwrap();
    let wall = |y: f64, length: f64| model::Body {
        owner_from_shape: Translation3::new(-5.8, y, 0.5).into(),
        shape: model::Shape::Box { size: [0.1, length, 1.0] },
    };
    problem.fixed.push(FixedObject {
        name: "divider".into(),
        world_from_object: nalgebra::Isometry3::identity(),
        bodies: vec![wall(-0.1, 0.2), wall(-2.0, 0.7), wall(-3.9, 0.2)],
    });
    problem
}

/// A stand with the arm stretched out there, and the piece that leads to it.
struct End {
    q: Configuration,
    arm: ProductRef,
}

struct Bench {
    statement: ProblemStatement,
    stage: RoadmapStage,
    products: MemoryProducts,
    base: ProductRef,
}

impl Bench {
    fn new() -> Self {
        let statement = ProblemStatement::new(divided(), 3, CompositeMethod::Prioritised);
        let (stage, products) = (RoadmapStage::new(&statement).unwrap(), MemoryProducts::default());
        let nothing = contract::Digest([0; 32]);
        let base = ProductRef { digest: nothing, made_by: contract::JobId(nothing) };
        let mut bench = Self { statement, stage, products, base };
        bench.base = bench.piece(PieceSpec::Base).unwrap();
        bench
    }

    fn problem(&self) -> &Problem {
        &self.statement.problem
    }

    fn ask(&self, request: Request) -> Outcome {
        let job = Job { request, budget: 1_000_000 };
        let id = job.id(&self.statement);
        let mut context = JobContext::new(id, &job, &self.products, Arc::new(AtomicBool::new(false)));
        self.stage.refine(&job, &mut context).unwrap()
    }

    fn piece(&self, spec: PieceSpec) -> Option<ProductRef> {
        match self.ask(Request::Piece(PieceJob { robot: ROBOT, holding: None, level: 2, spec })).result {
            Ok(Answer::Piece(product)) => Some(product),
            Ok(other) => panic!("{other:?}"),
            Err(_) => None,
        }
    }

    /// An arm stretched out at a stand, as random values have it, with the hand far from where it is folded.
    fn stretched(&self, stand: &[f64], random: &mut Random) -> End {
        let robot = self.problem().robot(ROBOT);
        let hand = |q: &[f64]| link_pose(robot, q, robot.end_effector.parent_link).translation.vector;
        let folded = [stand, &robot.home].concat();
        loop {
            let turned = robot.coordinates[3..].iter().zip(&robot.home);
            let arm: Vec<f64> =
                turned.map(|(c, home)| (home + random.between(-1.6, 1.6)).clamp(c.lower, c.upper)).collect();
            let q = [stand, &arm].concat();
            let spec =
                PieceSpec::Arm { stand: stand.to_vec(), near: vec![q.clone()], lift_up: 0, support: None, touch: None };
            if (hand(&q) - hand(&folded)).norm() > 0.5
                && let Some(arm) = self.piece(spec)
            {
                return End { q, arm };
            }
        }
    }

    /// Second transit of the robot: from where its first pair ends to where its second begins. `None`: there is a way.
    fn failure(
        &self,
        start: (&[f64], Option<ProductRef>),
        goal: (&[f64], Option<ProductRef>),
        certain: &[Obstruction],
    ) -> Option<FailureReport> {
        let job = ModeJob {
            mode: ModeId { robot: ROBOT, step: 2 },
            holding: None,
            start: start.0.to_vec(),
            goal: goal.0.to_vec(),
            base: Some(self.base),
            start_arm: start.1,
            goal_arm: goal.1,
            certain: certain.to_vec(),
            possible: Vec::new(),
            level: 0,
        };
        self.ask(Request::Mode(job)).result.err()
    }

    /// Objects at the hands, in the gaps, and anywhere about.
    fn about(&self, ends: [&End; 2], random: &mut Random) -> Vec<Obstruction> {
        let robot = self.problem().robot(ROBOT);
        let mut obstructions = Vec::new();
        for hop in 0..3 + (random.unit() * 9.0) as u32 {
            let object = ObjectId((random.unit() * 4.0) as u32);
            let height = self.problem().movable[object.index()].origin_height();
            let kind = random.unit();
            let mut beside = |x: f64, y: f64, by: f64| [x + random.between(-by, by), y + random.between(-by, by)];
            let world_from_object = if kind < 0.08 {
                let end = ends[usize::from(kind < 0.06)];
                let hand = link_pose(robot, &end.q, robot.end_effector.parent_link).translation;
                let [x, y] = beside(hand.x, hand.y, 0.25);
                Translation3::new(x, y, hand.z)
            } else {
                let [x, y] = if kind < 0.85 {
                    beside(-5.8, [-1.0, -3.0][usize::from(kind < 0.45)], 0.4)
                } else {
                    beside(-5.5, -2.0, 1.8)
                };
                Translation3::new(x, y, height)
            };
            let standing = Standing { object, world_from_object: world_from_object.into() };
            obstructions.push(Obstruction { occupancy: Occupancy { object, hop }, standing });
        }
        obstructions
    }
}

#[test]
fn a_mode_without_a_way_rests_on_a_least_set_of_poses_and_on_the_ends_at_which_the_arm_is_cut_off() {
    let bench = Bench::new();
    let robot = bench.problem().robot(ROBOT);
    let near_stand = robot.start[..3].to_vec();
    let pairs: Vec<PairId> = bench.problem().pairs_of_robot(ROBOT).collect();
    let (mut at_start, mut at_goal, mut between, mut ways, mut several) = (0, 0, 0, 0, 0);
    for seed in 0..75 {
        let mut random = Random(seed);
        let [start, goal] = [&near_stand[..], &FAR_STAND].map(|stand| bench.stretched(stand, &mut random));
        let [near_folded, far_folded] = [&near_stand[..], &FAR_STAND].map(|stand| [stand, &robot.home].concat());
        let (from, to) = ((&start.q[..], Some(start.arm)), (&goal.q[..], Some(goal.arm)));
        assert!(bench.failure(from, to, &[]).is_none(), "seed {seed}: no way among nothing");
        let certain = bench.about([&start, &goal], &mut random);
        let Some(report) = bench.failure(from, to, &certain) else {
            ways += 1;
            continue;
        };
        let rests_on = report.rests_on.unwrap_or_else(|| panic!("seed {seed}: rests on nothing"));
        let is_start_cut = bench.failure(from, (&near_folded[..], None), &certain).is_some();
        let is_goal_cut = bench.failure((&far_folded[..], None), to, &certain).is_some();
        let (alternatives, part_of_way) = match (is_start_cut, is_goal_cut) {
            (true, _) => (vec![pairs[0]], [from, (&near_folded[..], None)]),
            (false, true) => (vec![pairs[1]], [(&far_folded[..], None), to]),
            (false, false) => (vec![pairs[0], pairs[1]], [from, to]),
        };
        let named: Vec<PairId> = rests_on
            .iter()
            .filter_map(|choice| if let Choice::Alternative(pair) = choice { Some(*pair) } else { None })
            .collect();
        assert_eq!(named, alternatives, "seed {seed}: cut at start {is_start_cut}, at goal {is_goal_cut}");
        let is_named = |o: &&Obstruction| rests_on.contains(&Choice::Pose(o.occupancy));
        let needed: Vec<Obstruction> = certain.iter().filter(is_named).cloned().collect();
        assert_eq!(needed.len() + named.len(), rests_on.len(), "seed {seed}: poses that are not there");
        assert!(bench.failure(from, to, &needed).is_some(), "seed {seed}: {rests_on:?} does not suffice");
        for spared in 0..needed.len() {
            let mut fewer = needed.clone();
            fewer.remove(spared);
            let [from, to] = part_of_way;
            assert!(bench.failure(from, to, &fewer).is_none(), "seed {seed}: {rests_on:?} can spare number {spared}");
        }
        several += usize::from(needed.len() > 1);
        *match (is_start_cut, is_goal_cut) {
            (true, _) => &mut at_start,
            (false, true) => &mut at_goal,
            (false, false) => &mut between,
        } += 1;
    }
    let counts = [at_start, at_goal, between, ways, several];
    println!("{counts:?}");
    assert!(counts.iter().all(|count| *count > 3), "{counts:?}");
}
