//! A plan played back: where every link and object is at any time.

use model::{LinkId, ObjectId, Pose, Problem, RobotId};
use nalgebra::{Quaternion, UnitQuaternion};
use plan::{Event, EventKind, Knot, Plan, PoseRecord, RobotTrajectory};

/// How a plan does not fit a problem.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum Mismatch {
    /// Other robots, or in another order.
    #[error("the plan's robots are {plan:?}, the problem's {problem:?}")]
    Robots {
        /// Names in the plan.
        plan: Vec<String>,
        /// Names in the problem.
        problem: Vec<String>,
    },
    /// Other coordinates.
    #[error("the plan's joints of {robot} are {plan:?}, the problem's {problem:?}")]
    Joints {
        /// Robot.
        robot: String,
        /// Names in the plan.
        plan: Vec<String>,
        /// Names in the problem.
        problem: Vec<String>,
    },
    /// No knot, one with another number of values than joints, or times that do not increase.
    #[error("the knots of {robot} are not those of a trajectory")]
    Knots {
        /// Robot.
        robot: String,
    },
    /// A name or an index that leads nowhere.
    #[error("the plan speaks of {what}, which is not there")]
    Unknown {
        /// What is missing.
        what: String,
    },
}

/// A plan with the problem it was made for.
#[derive(Clone, Debug)]
pub struct Playback<'a> {
    /// Problem.
    pub problem: &'a Problem,
    /// Plan.
    pub plan: &'a Plan,
    /// Events of each object in order of time, with the robot and the link that holds.
    handling: Vec<Vec<Handling<'a>>>,
}

/// An attach or detach event with its names resolved.
#[derive(Clone, Copy, Debug)]
pub struct Handling<'a> {
    /// Event.
    pub event: &'a Event,
    /// Who.
    pub robot: RobotId,
    /// With which link.
    pub link: LinkId,
}

impl<'a> Playback<'a> {
    /// Puts a plan and its problem together.
    ///
    /// # Errors
    /// When the plan is of another problem, or not well formed.
    pub fn new(problem: &'a Problem, plan: &'a Plan) -> Result<Self, Mismatch> {
        fit_robots(problem, plan)?;
        fit_indices(problem, plan)?;
        let mut handling: Vec<Vec<Handling>> = vec![Vec::new(); problem.movable.len()];
        for event in &plan.events {
            let object = position(problem.movable.iter().map(|object| &object.name), &event.object)?;
            let robot = position(problem.robots.iter().map(|robot| &robot.name), &event.robot)?;
            let link = position(problem.robots[robot].links.iter().map(|link| &link.name), &event.link)?;
            handling[object].push(Handling { event, robot: RobotId::at(robot), link: LinkId::at(link) });
        }
        for handled in &mut handling {
            handled.sort_by(|a, b| a.event.t.total_cmp(&b.event.t));
        }
        Ok(Self { problem, plan, handling })
    }

    /// Time of the last knot of any robot (s).
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.plan.robots.iter().filter_map(|robot| robot.knots.last()).fold(0.0, |latest, knot| latest.max(knot.t))
    }

    /// Configuration of a robot (m, rad), linear between its knots.
    #[must_use]
    pub fn configuration(&self, robot: RobotId, t: f64) -> Vec<f64> {
        let knots = &self.plan.robots[robot.index()].knots;
        let next = knots.partition_point(|knot| knot.t <= t);
        match (next.checked_sub(1).map(|last| &knots[last]), knots.get(next)) {
            (Some(last), Some(next)) => between(last, next, t),
            (Some(only), None) | (None, Some(only)) => only.q.clone(),
            (None, None) => Vec::new(),
        }
    }

    /// Gap between a robot's fingers (m): that of the grasp while it holds, else fully open.
    #[must_use]
    pub fn opening(&self, robot: RobotId, t: f64) -> f64 {
        let name = &self.plan.robots[robot.index()].name;
        let last = self.plan.events.iter().rfind(|event| event.robot == *name && event.t <= t);
        match last {
            Some(event) if event.kind == EventKind::Attach => event.opening,
            _ => self.problem.robot(robot).end_effector.max_opening,
        }
    }

    /// Poses of a robot's links in the world.
    #[must_use]
    pub fn link_poses(&self, robot: RobotId, t: f64) -> Vec<Pose> {
        kinematics::link_poses(self.problem.robot(robot), &self.configuration(robot, t), self.opening(robot, t))
    }

    /// Events of an object in order of time.
    #[must_use]
    pub fn handling(&self, object: ObjectId) -> &[Handling<'a>] {
        &self.handling[object.index()]
    }

    /// Who holds an object.
    #[must_use]
    pub fn holder(&self, object: ObjectId, t: f64) -> Option<Handling<'a>> {
        self.last(object, t).filter(|last| last.event.kind == EventKind::Attach)
    }

    /// Pose of an object in the world: in the hand that holds it, else where it was put last.
    #[must_use]
    pub fn object_pose(&self, object: ObjectId, t: f64) -> Pose {
        match self.last(object, t) {
            None => self.problem.movable[object.index()].world_from_start,
            Some(last) if last.event.kind == EventKind::Attach => {
                self.link_poses(last.robot, t)[last.link.index()] * unit(last.event.link_from_object)
            }
            Some(last) => unit(last.event.world_from_object),
        }
    }

    /// Times of all knots of all robots (s), each once, in order.
    #[must_use]
    pub fn knot_times(&self) -> Vec<f64> {
        sorted(self.plan.robots.iter().flat_map(|robot| robot.knots.iter().map(|knot| knot.t)).collect())
    }

    fn last(&self, object: ObjectId, t: f64) -> Option<Handling<'a>> {
        let handled = &self.handling[object.index()];
        handled.partition_point(|handling| handling.event.t <= t).checked_sub(1).map(|last| handled[last])
    }
}

/// Times in order, each once.
#[must_use]
pub fn sorted(mut times: Vec<f64>) -> Vec<f64> {
    times.sort_by(f64::total_cmp);
    times.dedup();
    times
}

/// A pose from a file, its quaternion made unit again.
fn unit(record: PoseRecord) -> Pose {
    let [x, y, z, w] = record.quat_xyzw;
    let [tx, ty, tz] = record.xyz;
    Pose::from_parts([tx, ty, tz].into(), UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)))
}

fn between(last: &Knot, next: &Knot, t: f64) -> Vec<f64> {
    let part = (t - last.t) / (next.t - last.t);
    last.q.iter().zip(&next.q).map(|(a, b)| a + (b - a) * part).collect()
}

fn position<'n>(mut names: impl Iterator<Item = &'n String>, wanted: &str) -> Result<usize, Mismatch> {
    names.position(|name| name == wanted).ok_or_else(|| Mismatch::Unknown { what: format!("`{wanted}`") })
}

fn fit_robots(problem: &Problem, plan: &Plan) -> Result<(), Mismatch> {
    let planned: Vec<String> = plan.robots.iter().map(|robot| robot.name.clone()).collect();
    let known: Vec<String> = problem.robots.iter().map(|robot| robot.name.clone()).collect();
    if planned != known {
        return Err(Mismatch::Robots { plan: planned, problem: known });
    }
    for (trajectory, robot) in plan.robots.iter().zip(&problem.robots) {
        let known: Vec<String> = robot.coordinates.iter().map(|coordinate| coordinate.name.clone()).collect();
        let name = &robot.name;
        if trajectory.joints != known {
            return Err(Mismatch::Joints { robot: name.clone(), plan: trajectory.joints.clone(), problem: known });
        }
        if !is_trajectory(trajectory) {
            return Err(Mismatch::Knots { robot: name.clone() });
        }
    }
    Ok(())
}

fn is_trajectory(trajectory: &RobotTrajectory) -> bool {
    let knots = &trajectory.knots;
    !knots.is_empty()
        && knots.iter().all(|knot| knot.q.len() == trajectory.joints.len())
        && knots.windows(2).all(|pair| pair[0].t < pair[1].t)
}

fn fit_indices(problem: &Problem, plan: &Plan) -> Result<(), Mismatch> {
    for robot in &plan.robots {
        for segment in &robot.segments {
            if segment.from > segment.to || segment.to >= robot.knots.len() {
                let what = format!("knots {} to {} of {}", segment.from, segment.to, robot.name);
                return Err(Mismatch::Unknown { what });
            }
            if let Some(pair) = &segment.pair {
                position(problem.pairs.iter().map(|pair| &pair.name), pair)?;
            }
        }
    }
    for knot in plan.dependencies.iter().flat_map(|arc| [&arc.before, &arc.after]) {
        let robot = position(plan.robots.iter().map(|robot| &robot.name), &knot.robot)?;
        if knot.knot >= plan.robots[robot].knots.len() {
            return Err(Mismatch::Unknown { what: format!("knot {} of {}", knot.knot, knot.robot) });
        }
    }
    Ok(())
}
