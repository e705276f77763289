//! The processes that a launch file means for a problem.

use std::collections::BTreeMap;

use bus::{Expected, Role};
use contract::StageKind;
use model::{Problem, RobotId};

use super::launch_file::{LaunchFile, Replicas};
use super::policy::Policy;

/// One process of a set.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Seat {
    /// Name for people, such as `roadmap.r1`.
    pub name: String,
    /// What it does.
    pub role: Role,
    /// The robot it is there for.
    pub robot: Option<RobotId>,
    /// Program and its first arguments; none: this program's own.
    pub command: Option<Vec<String>>,
    /// What is done when it ends.
    pub policy: Policy,
}

impl Seat {
    /// As the supervisor's side of the bus knows it.
    #[must_use]
    pub fn expected(&self) -> Expected {
        Expected { name: self.name.clone(), role: self.role, robot: self.robot }
    }
}

/// All processes, the refiner first.
#[must_use]
pub fn seats(launch: &LaunchFile, problem: &Problem) -> Vec<Seat> {
    let refiner = Seat {
        name: Role::Refiner.name().to_owned(),
        role: Role::Refiner,
        robot: None,
        command: launch.refiner.command.clone(),
        policy: launch.refiner.policy(),
    };
    let workers = StageKind::ALL.into_iter().flat_map(|stage| workers(launch, problem, stage));
    [refiner].into_iter().chain(workers).collect()
}

fn workers(launch: &LaunchFile, problem: &Problem, stage: StageKind) -> Vec<Seat> {
    let entry = launch.stages.of(stage);
    let seat = |name: String, robot| Seat {
        name,
        role: Role::Worker(stage),
        robot,
        command: entry.command.clone(),
        policy: entry.policy(),
    };
    match entry.replicas {
        Replicas::Count(1) => vec![seat(stage.name().to_owned(), None)],
        Replicas::Count(count) => (1..=count).map(|number| seat(format!("{stage}.{number}"), None)).collect(),
        Replicas::PerRobot => {
            let named = |robot: RobotId| seat(format!("{stage}.{}", problem.robot(robot).name), Some(robot));
            problem.robot_ids().map(named).collect()
        }
    }
}

/// Number of processes by role, the supervisor included.
#[must_use]
pub fn count_by_role(seats: &[Seat]) -> BTreeMap<Role, usize> {
    let mut counts = BTreeMap::from([(Role::Supervisor, 1)]);
    for seat in seats {
        *counts.entry(seat.role).or_insert(0) += 1;
    }
    counts
}
