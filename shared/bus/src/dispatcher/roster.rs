//! The workers that the dispatcher knows.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use contract::{Digest, Job, ProblemStatement, StageKind};
use model::RobotId;

use crate::{Gone, HEARTBEAT, Hello, MemberId, Role};

/// A worker that has not been heard of for this long gets no offers.
const SILENT_AFTER: Duration = HEARTBEAT.saturating_mul(10);

/// Workers, by what they have said of themselves and what the supervisor has said of them.
#[derive(Default)]
pub(super) struct Roster {
    workers: BTreeMap<MemberId, Known>,
    gone: BTreeSet<MemberId>,
    lost: BTreeSet<StageKind>,
}

struct Known {
    stage: StageKind,
    robot: Option<RobotId>,
    fit: bool,
    heard: Duration,
}

impl Roster {
    /// A worker has spoken.
    pub(super) fn hear(&mut self, now: Duration, member: MemberId, hello: &Hello, known: (&ProblemStatement, Digest)) {
        let Role::Worker(stage) = hello.role else { return };
        if self.gone.contains(&member) {
            return;
        }
        let fit = hello.statement == Some(known.1) && hello.implementation == known.0.implementation(stage);
        self.workers.insert(member, Known { stage, robot: hello.robot, fit, heard: now });
        self.lost.remove(&stage);
    }

    /// A worker has gone; its number will not be used again.
    pub(super) fn lose(&mut self, gone: &Gone) {
        self.gone.insert(gone.member);
        self.workers.remove(&gone.member);
        if gone.left == 0 {
            self.lost.extend(gone.stage);
        }
    }

    /// Whether no worker of the stage is left, nor will come.
    pub(super) fn has_lost(&self, stage: StageKind) -> bool {
        self.lost.contains(&stage)
    }

    /// Whether a worker can be expected to answer.
    pub(super) fn is_alive(&self, now: Duration, member: MemberId) -> bool {
        self.workers.get(&member).is_some_and(|known| known.is_alive(now))
    }

    /// The worker that should get a job, among those that hold fewer than `window`: its robot's if that is alive, else
    /// the one that holds least.
    pub(super) fn choose(
        &self,
        now: Duration,
        job: &Job,
        load: &BTreeMap<MemberId, usize>,
        window: usize,
    ) -> Option<MemberId> {
        let stage = job.stage();
        let fit = || self.workers.iter().filter(move |(_, known)| known.stage == stage && known.is_alive(now));
        let own = job.robot().and_then(|robot| fit().find(|(_, known)| known.robot == Some(robot)));
        let load_of = |member: &MemberId| load.get(member).copied().unwrap_or(0);
        let chosen = match own {
            Some((member, _)) => Some(*member),
            None => fit().map(|(member, _)| *member).min_by_key(|member| (load_of(member), *member)),
        };
        chosen.filter(|member| load_of(member) < window)
    }
}

impl Known {
    fn is_alive(&self, now: Duration) -> bool {
        self.fit && now <= self.heard + SILENT_AFTER
    }
}
