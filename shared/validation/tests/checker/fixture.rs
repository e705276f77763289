//! Problems and hand-written plans.

use model::{
    EndPolicy, FixedId, FixedObject, Levels, MovableObject, ObjectId, Pair, PairId, Problem, Region, RegionId, Robot,
    RobotId, SearchSettings, Settings,
};
use plan::{
    Event, EventKind, Knot, LowerBound, Makespan, ModeKind, PLAN_FORMAT, Plan, RobotTrajectory, Segment, SegmentKind,
};
use validation::{Rule, Verdict, Violation, check_plan};

use crate::robots::{at, block, top_grasp};

/// Height of all table tops (m).
pub const TOP: f64 = 0.4;
/// Edge lengths of the objects (m).
pub const OBJECT: [f64; 3] = [0.06, 0.04, 0.12];

/// A table at (x, y) with a region of 0.2 × 0.2 in its middle.
pub fn add_table(problem: &mut Problem, name: &str, x: f64, y: f64) -> RegionId {
    let support = FixedId::at(problem.fixed.len());
    problem.fixed.push(FixedObject {
        name: format!("table {name}"),
        world_from_object: at(x, y, TOP / 2.0),
        bodies: vec![block([0.3, 0.3, TOP], [0.0; 3])],
    });
    problem.regions.push(Region { name: name.to_owned(), world_from_region: at(x, y, TOP), size: [0.2, 0.2], support });
    RegionId::at(problem.regions.len() - 1)
}

/// A fixed box.
pub fn add_fixed(problem: &mut Problem, name: &str, size: [f64; 3], centre: [f64; 3]) {
    problem.fixed.push(FixedObject {
        name: name.to_owned(),
        world_from_object: at(centre[0], centre[1], centre[2]),
        bodies: vec![block(size, [0.0; 3])],
    });
}

/// An object standing at (x, y) on a table; every robot may take it from above.
pub fn add_object(problem: &mut Problem, name: &str, x: f64, y: f64, region: RegionId) -> ObjectId {
    problem.movable.push(MovableObject {
        name: name.to_owned(),
        body: block(OBJECT, [0.0; 3]),
        world_from_start: at(x, y, TOP + OBJECT[2] / 2.0),
        start_support: Some(problem.regions[region.index()].support),
        grasps: vec![vec![top_grasp()]; problem.robots.len()],
    });
    ObjectId::at(problem.movable.len() - 1)
}

/// A pair; pairs are added robot by robot.
pub fn add_pair(problem: &mut Problem, robot: usize, object: ObjectId, from: RegionId, to: RegionId) -> PairId {
    let number = problem.pairs.iter().filter(|pair| pair.robot.index() == robot).count() + 1;
    let hop = 1 + problem.pairs.iter().filter(|pair| pair.object == object).count() as u32;
    let name = format!("{}.{number}", problem.robots[robot].name);
    problem.pairs.push(Pair { name, robot: RobotId::at(robot), object, from, to, hop });
    PairId::at(problem.pairs.len() - 1)
}

/// A problem of robots alone.
pub fn problem(robots: Vec<Robot>) -> Problem {
    Problem {
        name: "hand-made".to_owned(),
        end_policies: vec![EndPolicy::Return; robots.len()],
        robots,
        fixed: Vec::new(),
        movable: Vec::new(),
        regions: Vec::new(),
        pairs: Vec::new(),
        orderings: Vec::new(),
        settings: Settings::default(),
        levels: Levels::default(),
        search: SearchSettings::default(),
    }
}

/// Writes one robot's trajectory step by step.
pub struct Writer<'a> {
    problem: &'a Problem,
    robot: &'a Robot,
    trajectory: RobotTrajectory,
    events: Vec<Event>,
    pair: Option<PairId>,
}

impl<'a> Writer<'a> {
    pub fn new(problem: &'a Problem, robot: usize) -> Self {
        let robot = &problem.robots[robot];
        let trajectory = RobotTrajectory {
            name: robot.name.clone(),
            joints: robot.coordinates.iter().map(|c| c.name.clone()).collect(),
            knots: vec![Knot { t: 0.0, q: robot.start.clone() }],
            segments: Vec::new(),
        };
        Self { problem, robot, trajectory, events: Vec::new(), pair: None }
    }

    /// Index of the last knot.
    pub fn knot(&self) -> usize {
        self.trajectory.knots.len() - 1
    }

    /// Time of the last knot.
    pub fn time(&self) -> f64 {
        self.trajectory.knots[self.knot()].t
    }

    /// Begins a pair, or (none) the closing return.
    pub fn begin(&mut self, pair: Option<PairId>) -> &mut Self {
        self.pair = pair;
        self
    }

    fn push(&mut self, t: f64, q: Vec<f64>, kind: SegmentKind) {
        let from = self.knot();
        self.trajectory.knots.push(Knot { t, q });
        let holding = self.events.last().is_some_and(|event| event.kind == EventKind::Attach);
        let mode = match self.pair {
            None => ModeKind::Return,
            Some(_) if holding => ModeKind::Transfer,
            Some(_) => ModeKind::Transit,
        };
        let pair = self.pair.map(|pair| self.problem.pair(pair).name.clone());
        self.trajectory.segments.push(Segment { from, to: from + 1, pair, mode, kind });
    }

    /// Goes straight to `q` as fast as the limits allow.
    pub fn go(&mut self, kind: SegmentKind, q: &[f64]) -> &mut Self {
        let from = self.trajectory.knots[self.knot()].q.clone();
        let duration = self.robot.duration(&from, q);
        if duration > 0.0 {
            self.push(self.time() + duration, q.to_vec(), kind);
        }
        self
    }

    /// Stands until `t`.
    pub fn wait_until(&mut self, t: f64) -> &mut Self {
        if t > self.time() {
            let q = self.trajectory.knots[self.knot()].q.clone();
            self.push(t, q, SegmentKind::Wait);
        }
        self
    }

    /// Attaches or detaches where the robot is, then stands for the grip time. `x`, `y` is where the object stands.
    pub fn grip(&mut self, kind: EventKind, x: f64, y: f64) -> &mut Self {
        let pair = self.pair.map(|pair| self.problem.pair(pair)).expect("a pair has begun");
        let (grasp, knot) = (top_grasp(), self.knot());
        let hand = &self.robot.end_effector;
        self.events.push(Event {
            t: self.time(),
            kind,
            robot: self.robot.name.clone(),
            knot,
            pair: pair.name.clone(),
            object: self.problem.movable[pair.object.index()].name.clone(),
            link: self.robot.links[hand.parent_link.index()].name.clone(),
            link_from_object: grasp.link_from_object.into(),
            world_from_object: at(x, y, TOP + OBJECT[2] / 2.0).into(),
            opening: grasp.opening,
        });
        self.wait_until(self.time() + self.problem.settings.grip_time)
    }
}

/// The plan made of all robots' trajectories.
pub fn finish(problem: &Problem, writers: Vec<Writer>) -> Plan {
    let mut events: Vec<Event> = writers.iter().flat_map(|writer| writer.events.clone()).collect();
    events.sort_by(|a, b| a.t.total_cmp(&b.t));
    let mut plan = Plan {
        format: PLAN_FORMAT.to_owned(),
        problem: problem.name.clone(),
        robots: writers.into_iter().map(|writer| writer.trajectory).collect(),
        events,
        orderings: Vec::new(),
        dependencies: Vec::new(),
        makespan: Makespan { task_s: 0.0, total_s: 0.0 },
        lower_bound: LowerBound { seconds: 0.0, kind: "none".to_owned() },
        provenance: crate::certificates::failure::provenance(),
    };
    report_makespan(&mut plan);
    plan
}

/// Sets the makespans that the trajectories have: a pair is done at the end of its last retract.
pub fn report_makespan(plan: &mut Plan) {
    let (mut task, mut total): (f64, f64) = (0.0, 0.0);
    for robot in &plan.robots {
        total = total.max(robot.knots[robot.knots.len() - 1].t);
        let detached = |pair: &Option<String>, from: usize| {
            let is = |e: &&Event| e.kind == EventKind::Detach && Some(&e.pair) == pair.as_ref() && e.knot <= from;
            plan.events.iter().any(|event| is(&event))
        };
        for segment in robot.segments.iter().filter(|s| s.kind == SegmentKind::Retract && detached(&s.pair, s.from)) {
            task = task.max(robot.knots[segment.to].t);
        }
    }
    plan.makespan = Makespan { task_s: task, total_s: total };
}

/// The rules a plan breaks, each once.
pub fn rules(problem: &Problem, plan: &Plan) -> Vec<Rule> {
    let mut rules: Vec<Rule> = violations(problem, plan).iter().map(|violation| violation.rule).collect();
    rules.dedup();
    rules
}

/// What a plan breaks.
pub fn violations(problem: &Problem, plan: &Plan) -> Vec<Violation> {
    check_plan(problem, plan).err().unwrap_or_default()
}

/// Asserts that a plan is accepted.
#[track_caller]
pub fn accepted(problem: &Problem, plan: &Plan) -> Verdict {
    let words = |wrong: Vec<Violation>| wrong.iter().map(ToString::to_string).collect::<Vec<_>>();
    check_plan(problem, plan).map_err(words).expect("a valid plan")
}

/// Asserts that a plan is rejected for exactly one rule.
#[track_caller]
pub fn rejected(problem: &Problem, plan: &Plan, rule: Rule) {
    let found = violations(problem, plan);
    assert!(!found.is_empty(), "accepted, expected {}", rule.name());
    let words: Vec<String> = found.iter().map(ToString::to_string).collect();
    assert!(
        found.iter().all(|violation| violation.rule == rule),
        "expected {} alone:\n{}",
        rule.name(),
        words.join("\n")
    );
}
