//! Why a mode was not committed, naming who is in the way.

use model::{Problem, RobotId};
use plan::{BodyRef, Cause};
use skeleton::Mode;

use crate::sipp::Blocker;

use super::CommitJob;
use crate::Scene;

impl CommitJob<'_> {
    /// The robot and others block one another.
    pub(super) fn deadlock(&self, others: &[RobotId]) -> Cause {
        deadlock_of(self.scene.problem(), self.mode.robot, others)
    }
}

fn deadlock_of(problem: &Problem, robot: RobotId, others: &[RobotId]) -> Cause {
    let mut robots = vec![robot];
    robots.extend(others);
    robots.sort_unstable();
    robots.dedup();
    Cause::Deadlock { robots: robots.into_iter().map(|robot| problem.robot(robot).name.clone()).collect() }
}

/// Robots in the way are a deadlock; objects, robots that never move, or nobody at all leave no path.
pub(crate) fn causes_of(scene: &Scene, mode: &Mode, in_the_way: &[Blocker]) -> Vec<Cause> {
    let problem = scene.problem();
    let is_idle = |robot: &RobotId| scene.skeleton.modes[robot.index()].is_empty();
    let (mut idle, robots): (Vec<_>, Vec<_>) = in_the_way.iter().filter_map(Blocker::robot).partition(is_idle);
    idle.sort_unstable();
    idle.dedup();
    let mut objects: Vec<_> = in_the_way.iter().filter_map(Blocker::object).collect();
    objects.sort_unstable();
    objects.dedup();
    let mut causes = Vec::new();
    let name = |robot: &RobotId| problem.robot(*robot);
    let links = idle.iter().map(name).filter_map(|robot| {
        let link = robot.links.iter().find(|link| !link.bodies.is_empty())?;
        Some(BodyRef::Link { robot: robot.name.clone(), link: link.name.clone() })
    });
    let objects = objects.iter().map(|m| BodyRef::Object(problem.movable[m.index()].name.clone()));
    let blocking: Vec<BodyRef> = objects.chain(links).collect();
    if !blocking.is_empty() || robots.is_empty() {
        causes.push(Cause::NoPath {
            pair: mode.pair.map(|pair| problem.pair(pair).name.clone()),
            robot: problem.robot(mode.id.robot).name.clone(),
            blocking,
        });
    }
    if !robots.is_empty() {
        causes.push(deadlock_of(problem, mode.id.robot, &robots));
    }
    causes
}
