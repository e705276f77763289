//! Toy worlds: discs that drive on a graph and carry discs in front of them, at any height that matters. Nothing in them
//! ever has to touch, so that the distance of discs is an exact check. An arm, if they have one, lowers the hand a little.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use composite::CompositeStage;
use contract::{
    Answer, Assignment, Commitment, ComposeJob, CompositeMethod, Composition, Edge, EdgeKind, FailureReport,
    Interrupted, Job, JobContext, MemoryProducts, ModeRoadmap, Outcome, ProblemStatement, Product, ProductRef,
    Products, Request, Stage, VertexId, decode, encode,
};
use model::{
    AllowedContacts, Body, Coordinate, CoordinateId, EndEffector, EndPolicy, GivenOrdering, Grasp, GraspFamily,
    GraspId, Holding, Joint, JointMotion, JointValue, Levels, Link, LinkId, MovableObject, ObjectId, Pair, PairId,
    PlanarBase, Pose, Problem, RegionId, Robot, RobotId, SearchSettings, Settings, Shape,
};
use nalgebra::{Isometry3, UnitQuaternion};
use skeleton::{ModeId, ModeKind, Skeleton};

/// Radius of a robot (m).
pub const ROBOT: f64 = 0.2;
/// Radius of an object (m).
pub const OBJECT: f64 = 0.08;
/// How far in front of the robot's centre it carries an object's (m).
pub const REACH: f64 = 0.35;
/// Speed of a robot (m/s).
pub const SPEED: f64 = 1.0;
/// Height of a lowered hand (m), and the speed at which it is lowered (m/s).
pub const LOWERED: f64 = -0.1;
pub const ARM_SPEED: f64 = 0.1;

/// Deterministic random numbers for tests.
pub struct Dice(pub u64);

impl Dice {
    pub fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) % n as u64) as usize
    }

    pub fn unit(&mut self) -> f64 {
        self.below(1 << 30) as f64 / f64::from(1 << 30)
    }
}

/// A pick-and-place in a toy world: an object is picked at one vertex and placed at another.
#[derive(Clone, Copy, Debug)]
pub struct Errand {
    pub robot: usize,
    pub object: usize,
    pub from: usize,
    pub to: usize,
}

/// A graph in the plane, robots at vertices, and what they have to do.
#[derive(Clone, Debug, Default)]
pub struct World {
    pub points: Vec<[f64; 2]>,
    pub ways: Vec<(usize, usize)>,
    pub starts: Vec<usize>,
    /// Robot by robot, as pairs are.
    pub errands: Vec<Errand>,
    /// Where objects stand at the start: the vertex from which they are picked.
    pub objects: Vec<usize>,
    pub grip_time: f64,
    /// Whether hands are lowered to pick and place.
    pub arms: bool,
    pub orderings: Vec<GivenOrdering>,
}

/// A world with its stage and what has been committed.
pub struct Toy {
    pub world: World,
    pub statement: ProblemStatement,
    pub assignment: Assignment,
    pub stage: CompositeStage,
    pub products: MemoryProducts,
}

/// A robot at a point, its hand at a height if it has an arm.
pub fn at(point: [f64; 2], hand: Option<f64>) -> Vec<f64> {
    [point[0], point[1], 0.0].into_iter().chain(hand).collect()
}

fn pose(x: f64, y: f64, z: f64) -> Pose {
    Isometry3::from_parts([x, y, z].into(), UnitQuaternion::identity())
}

fn cylinder(radius: f64, length: f64, z: f64) -> Body {
    Body { owner_from_shape: pose(0.0, 0.0, z), shape: Shape::Cylinder { radius, length } }
}

/// A disc that drives freely, its hand on a vertical slide if it has an arm.
pub fn disc(name: &str, start: Vec<f64>) -> Robot {
    let coordinate = |axis: &str, bound: f64, velocity: f64| Coordinate {
        name: format!("base/{axis}"),
        lower: -bound,
        upper: bound,
        velocity,
    };
    let arm = start.len() > 3;
    let mut coordinates =
        vec![coordinate("x", 100.0, SPEED), coordinate("y", 100.0, SPEED), coordinate("yaw", f64::INFINITY, SPEED)];
    coordinates.extend(arm.then(|| coordinate("lift", 1.0, ARM_SPEED)));
    let folded = start[3..].to_vec();
    Robot {
        name: name.into(),
        world_from_base: Pose::identity(),
        links: vec![
            Link { name: "body".into(), bodies: vec![cylinder(ROBOT, 0.4, 0.2)] },
            Link { name: "hand".into(), bodies: vec![] },
        ],
        joints: vec![Joint {
            name: "lift".into(),
            parent: LinkId(0),
            child: LinkId(1),
            parent_from_joint: Pose::identity(),
            motion: if arm { JointMotion::Prismatic { axis: [0.0, 0.0, 1.0] } } else { JointMotion::Fixed },
            value: if arm { JointValue::Coordinate(CoordinateId(3)) } else { JointValue::Constant(0.0) },
        }],
        coordinates,
        base: Some(PlanarBase { speed: SPEED, yaw_rate: SPEED }),
        end_effector: EndEffector {
            name: "hand".into(),
            parent_link: LinkId(1),
            link_from_tool: Pose::identity(),
            links: vec![LinkId(1)],
            max_opening: 0.1,
        },
        disabled_pairs: vec![(LinkId(0), LinkId(1))],
        start,
        home: folded.clone(),
        carry: folded,
    }
}

fn movable(name: String, start: Pose, robots: usize) -> MovableObject {
    let grasp = Grasp {
        link_from_object: pose(REACH, 0.0, 0.2),
        opening: 0.05,
        approach: [1.0, 0.0, 0.0],
        family: GraspFamily::Listed,
    };
    MovableObject {
        name,
        body: cylinder(OBJECT, 0.2, 0.0),
        world_from_start: start,
        start_support: None,
        grasps: vec![vec![grasp]; robots],
    }
}

impl World {
    /// A rectangular grid of `columns` × `rows` points `step` (m) apart.
    pub fn grid(columns: usize, rows: usize, step: f64) -> Self {
        let number = |c: usize, r: usize| r * columns + c;
        let mut world = Self::default();
        for r in 0..rows {
            for c in 0..columns {
                world.points.push([c as f64 * step, r as f64 * step]);
                if c + 1 < columns {
                    world.ways.push((number(c, r), number(c + 1, r)));
                }
                if r + 1 < rows {
                    world.ways.push((number(c, r), number(c, r + 1)));
                }
            }
        }
        world
    }

    /// Where an object stands that is picked or placed from a vertex.
    pub fn stand_of(&self, vertex: usize) -> Pose {
        let [x, y] = self.points[vertex];
        pose(x + REACH, y, 0.2 + self.lowered().unwrap_or(0.0))
    }

    fn folded(&self) -> Option<f64> {
        self.arms.then_some(0.0)
    }

    fn lowered(&self) -> Option<f64> {
        self.arms.then_some(LOWERED)
    }

    pub fn problem(&self) -> Problem {
        let mut hops = vec![0; self.objects.len()];
        let mut counts = vec![0; self.starts.len()];
        let pairs = self.errands.iter().map(|errand| {
            hops[errand.object] += 1;
            counts[errand.robot] += 1;
            Pair {
                name: format!("r{}.{}", errand.robot + 1, counts[errand.robot]),
                robot: RobotId::at(errand.robot),
                object: ObjectId::at(errand.object),
                from: RegionId(0),
                to: RegionId(0),
                hop: hops[errand.object],
            }
        });
        Problem {
            name: "toy".into(),
            pairs: pairs.collect(),
            robots: (0..)
                .zip(&self.starts)
                .map(|(r, start)| disc(&format!("r{}", r + 1), at(self.points[*start], self.folded())))
                .collect(),
            fixed: vec![],
            movable: (0..)
                .zip(&self.objects)
                .map(|(m, from)| movable(format!("m{}", m + 1), self.stand_of(*from), self.starts.len()))
                .collect(),
            regions: vec![],
            orderings: self.orderings.clone(),
            end_policies: vec![EndPolicy::Return; self.starts.len()],
            settings: Settings { grip_time: self.grip_time, ..Settings::default() },
            levels: Levels::default(),
            search: SearchSettings::default(),
        }
    }

    pub fn build(self) -> Toy {
        let statement = ProblemStatement::new(self.problem(), 0, CompositeMethod::Prioritised);
        let mut poses: Vec<Vec<Pose>> = self.objects.iter().map(|from| vec![self.stand_of(*from)]).collect();
        for errand in &self.errands {
            poses[errand.object].push(self.stand_of(errand.to));
        }
        let assignment = Assignment { poses, grasps: vec![GraspId(0); self.errands.len()], orders: vec![] };
        let stage = CompositeStage::new(&statement).unwrap();
        Toy { world: self, statement, assignment, stage, products: MemoryProducts::default() }
    }
}

impl Toy {
    pub fn problem(&self) -> &Problem {
        &self.statement.problem
    }

    pub fn skeleton(&self) -> Skeleton {
        Skeleton::of_problem(self.problem()).unwrap()
    }

    /// The whole graph as roadmap of a mode; the robot parks where it started.
    pub fn roadmap(&self, mode: ModeId) -> ModeRoadmap {
        let own = self.world.errands.iter().filter(|errand| errand.robot == mode.robot.index());
        let own: Vec<Errand> = own.copied().collect();
        let start = self.world.starts[mode.robot.index()];
        let pair = mode.step as usize / 2;
        let kind = self.skeleton().mode(mode).kind;
        let (from, to) = match kind {
            ModeKind::Transit => (pair.checked_sub(1).map_or(start, |before| own[before].to), own[pair].from),
            ModeKind::Transfer => (own[pair].from, own[pair].to),
            ModeKind::Return => (own[pair - 1].to, start),
        };
        let holding =
            (kind == ModeKind::Transfer).then(|| Holding { object: ObjectId::at(own[pair].object), grasp: GraspId(0) });
        let points = &self.world.points;
        let mut vertices: Vec<Vec<f64>> = points.iter().map(|point| at(*point, self.world.folded())).collect();
        let duration = |a: usize, b: usize| (points[a][0] - points[b][0]).hypot(points[a][1] - points[b][1]) / SPEED;
        let mut edges: Vec<Edge> =
            self.world.ways.iter().map(|(a, b)| edge(*a, *b, EdgeKind::Base, duration(*a, *b))).collect();
        let mut lowered = |vertex: usize| {
            if self.world.arms {
                edges.push(edge(vertex, vertices.len(), EdgeKind::Arm, -LOWERED / ARM_SPEED));
                vertices.push(at(points[vertex], self.world.lowered()));
                vertices.len() - 1
            } else {
                vertex
            }
        };
        let first = if mode.step == 0 { from } else { lowered(from) };
        let last = if kind == ModeKind::Return { to } else { lowered(to) };
        ModeRoadmap {
            mode,
            holding,
            start: VertexId::at(first),
            goal: VertexId::at(last),
            parking: vec![VertexId::at(start)],
            possible: vec![],
            cost_to_go_s: vec![],
            vertices,
            edges,
        }
    }

    pub fn put(&self, product: &Product) -> ProductRef {
        let digest = self.products.put(encode(product).unwrap());
        ProductRef { digest, made_by: contract::JobId(digest) }
    }

    pub fn get(&self, product: ProductRef) -> Product {
        decode(&self.products.get(&product.digest).unwrap()).unwrap()
    }

    pub fn job(&self, composition: Composition) -> Job {
        let compose = ComposeJob { assignment: self.assignment.clone(), composition };
        Job { request: Request::Compose(compose), budget: 1_000_000 }
    }

    pub fn ask(&self, job: &Job) -> Result<Outcome, Interrupted> {
        let id = job.id(&self.statement);
        let mut context = JobContext::new(id, job, &self.products, Arc::new(AtomicBool::new(false)));
        self.stage.refine(job, &mut context)
    }

    pub fn commit_job(&self, prefix: Option<ProductRef>, mode: ModeId, edit: impl Fn(&mut ModeRoadmap)) -> Job {
        let roadmap = |mode| {
            let mut roadmap = self.roadmap(mode);
            edit(&mut roadmap);
            self.put(&Product::Mode(roadmap))
        };
        let next = ModeId { step: mode.step + 1, ..mode };
        let has_next = self.skeleton().modes[mode.robot.index()].len() > next.step as usize;
        self.job(Composition::CommitMode {
            prefix,
            mode,
            roadmap: roadmap(mode),
            next_roadmap: has_next.then(|| roadmap(next)),
            clear_of: vec![],
        })
    }

    /// The longer prefix and the time of the event.
    #[allow(clippy::result_large_err)]
    pub fn commit(&self, prefix: Option<ProductRef>, mode: ModeId) -> Result<(ProductRef, f64), FailureReport> {
        let outcome = self.ask(&self.commit_job(prefix, mode, |_| ())).unwrap();
        outcome.result.map(|answer| match answer {
            Answer::Committed { prefix, event_s, .. } => (prefix, event_s),
            other => panic!("{other:?}"),
        })
    }

    /// Commits modes as the refiner does: of those that are ready the one whose event comes first. Calls `each` with
    /// every prefix. Ends where nothing can be committed.
    pub fn commit_all(&self, mut each: impl FnMut(&[Commitment])) -> (Option<ProductRef>, Vec<FailureReport>) {
        let mut skeleton = self.skeleton();
        for order in &self.assignment.orders {
            skeleton.graph.add(order.before, order.after, skeleton::ArcOrigin::Discovered).unwrap();
        }
        let mut next = vec![0_usize; skeleton.modes.len()];
        let mut prefix = None;
        loop {
            let committed = |event| {
                skeleton.modes.iter().zip(&next).any(|(modes, n)| modes[..*n].iter().any(|m| m.ends == Some(event)))
            };
            let ends = || skeleton.modes.iter().flatten().filter_map(|mode| mode.ends);
            let ready = skeleton.modes.iter().zip(&next).filter_map(|(modes, n)| modes.get(*n)).filter(|mode| {
                mode.ends.is_none_or(|own| ends().filter(|e| skeleton.graph.precedes(*e, own)).all(committed))
            });
            let ready: Vec<ModeId> = ready.map(|mode| mode.id).collect();
            let (mut best, mut failures): (Option<(f64, ModeId, ProductRef)>, _) = (None, Vec::new());
            for mode in &ready {
                match self.commit(prefix, *mode) {
                    Ok((longer, event_s)) if best.is_none_or(|(best_s, ..)| event_s < best_s) => {
                        best = Some((event_s, *mode, longer));
                    }
                    Ok(_) => {}
                    Err(report) => failures.push(report),
                }
            }
            let Some((_, mode, longer)) = best else { return (prefix, failures) };
            next[mode.robot.index()] += 1;
            prefix = Some(longer);
            each(&self.commitments(longer));
        }
    }

    /// Whether a prefix holds all modes.
    pub fn is_complete(&self, prefix: Option<ProductRef>) -> bool {
        let all: usize = self.skeleton().modes.iter().map(Vec::len).sum();
        prefix.is_some_and(|prefix| self.commitments(prefix).len() == all)
    }

    pub fn commitments(&self, prefix: ProductRef) -> Vec<Commitment> {
        let mut parts = Vec::new();
        let mut next = Some(prefix);
        while let Some(part) = next {
            let Product::Prefix(part) = self.get(part) else { panic!("no prefix") };
            next = part.parent;
            parts.push(part.commitments);
        }
        parts.into_iter().rev().flatten().collect()
    }

    pub fn assemble(&self, prefix: ProductRef) -> plan::Plan {
        self.assemble_rounds(prefix, vec![])
    }

    pub fn assemble_rounds(&self, prefix: ProductRef, rounds: Vec<Vec<ModeId>>) -> plan::Plan {
        let shortest_s = self.skeleton().modes.iter().map(|modes| vec![0.0; modes.len()]).collect();
        let outcome = self.ask(&self.job(Composition::Assemble { prefix, shortest_s, rounds })).unwrap();
        let Ok(Answer::Plan { plan, .. }) = outcome.result else { panic!("{outcome:?}") };
        let Product::Plan(bytes) = self.get(plan) else { panic!("no plan") };
        plan::read_plan(&bytes).unwrap()
    }
}

fn edge(a: usize, b: usize, kind: EdgeKind, duration_s: f64) -> Edge {
    let (a, b, allowed) = (VertexId::at(a), VertexId::at(b), AllowedContacts::default());
    Edge { a, b, kind, allowed, duration_s, blockers: vec![] }
}

pub fn mode(robot: usize, step: u32) -> ModeId {
    ModeId { robot: RobotId::at(robot), step }
}

pub fn pair(index: usize) -> PairId {
    PairId::at(index)
}

/// Robots start at different vertices of a grid and carry objects between others; every vertex is used once at most, and
/// vertices that are used are a column apart, so that what stands at one is in the way of nobody's goal.
pub fn random_world(dice: &mut Dice, columns: usize, rows: usize, robots: usize, errands: usize) -> World {
    let mut world = World::grid(columns, rows, 0.7);
    let mut free: Vec<usize> = (0..columns * rows).filter(|v| (v % columns).is_multiple_of(2)).collect();
    let mut draw = |dice: &mut Dice| free.swap_remove(dice.below(free.len()));
    world.starts = (0..robots).map(|_| draw(dice)).collect();
    for robot in 0..robots {
        for _ in 0..errands {
            let (from, to) = (draw(dice), draw(dice));
            world.errands.push(Errand { robot, object: world.objects.len(), from, to });
            world.objects.push(from);
        }
    }
    world.grip_time = if dice.below(2) == 0 { 0.0 } else { 0.5 };
    world.arms = dice.below(2) == 0;
    world
}
