//! `Repair` jobs: a few robots are planned together until a stuck mode is done, and then get out of the way.

use contract::{Answer, Assignment, Interrupted, JobContext, ModeRoadmap, Outcome, Prefix, Product, ProductRef, Tail};
use model::RobotId;
use skeleton::{ModeId, Skeleton};

use crate::commit::CommitJob;
use crate::drrt::{Geometric, Repaired, Together, check_holdings, load_roadmap, repair_with};
use crate::{CommittedMotion, Scene, Timeline, load_prefix};

/// What to repair.
pub(crate) struct RepairJob<'a> {
    pub scene: &'a Scene,
    pub assignment: &'a Assignment,
    pub prefix: Option<ProductRef>,
    pub mode: ModeId,
    pub robots: &'a [RobotId],
    pub roadmaps: &'a [Vec<ProductRef>],
}

impl RepairJob<'_> {
    /// The longer prefix, or who is in the way.
    pub fn answer(&self, context: &mut JobContext<'_>) -> Result<Outcome, Interrupted> {
        let done = load_prefix(context, self.prefix)?;
        done.check(self.scene)?;
        let load = |of_robot: &Vec<ProductRef>| of_robot.iter().map(|wanted| load_roadmap(wanted, context)).collect();
        let roadmaps: Vec<Vec<ModeRoadmap>> = self.roadmaps.iter().map(load).collect::<Result<_, _>>()?;
        check_holdings(self.scene, self.assignment, &roadmaps)?;
        let repaired = match self.together(&done, &roadmaps, context)? {
            Ok(repaired) => self.with_safe_tail(done, repaired, context)?,
            Err(report) => return Ok(Outcome { result: Err(report), work: context.spent() }),
        };
        let Repaired { commitments, tails } = repaired;
        let modes = commitments.iter().map(|commitment| (commitment.mode, commitment.event_s)).collect();
        let prefix = context.publish(&Product::Prefix(Prefix { parent: self.prefix, commitments, tails }))?;
        Ok(Outcome::answer(Answer::Repaired { prefix, modes }, context.spent()))
    }

    fn together(
        &self,
        done: &CommittedMotion,
        roadmaps: &[Vec<ModeRoadmap>],
        context: &mut JobContext<'_>,
    ) -> Result<Result<Repaired, contract::FailureReport>, Interrupted> {
        let scene = self.scene;
        let skeleton = Skeleton { graph: scene.graph(self.assignment)?, ..scene.skeleton.clone() };
        let validity = Geometric { conflicts: &scene.conflicts, assignment: self.assignment };
        let together = Together { mode: self.mode, robots: self.robots };
        repair_with(&scene.statement, &skeleton, done, roadmaps, together, &validity, context)
    }

    /// The robot whose mode it is does not stay where its event happened, if it can go on to where it may stand for ever.
    /// (Nothing comes after that event, so nobody counts on what the robot has done since.)
    fn with_safe_tail(
        &self,
        mut done: CommittedMotion,
        mut repaired: Repaired,
        context: &mut JobContext<'_>,
    ) -> Result<Repaired, Interrupted> {
        let robot = self.mode.robot;
        let Some(next) = self.roadmaps[robot.index()].get(self.mode.step as usize + 1) else { return Ok(repaired) };
        done.extend(repaired.commitments.clone(), repaired.tails.clone());
        let timeline = Timeline::new(self.scene, self.assignment, done)?;
        let job = CommitJob {
            scene: self.scene,
            assignment: self.assignment,
            prefix: None,
            mode: self.mode,
            roadmap: self.roadmaps[robot.index()][self.mode.step as usize],
            next_roadmap: Some(*next),
            clear_of: &[],
        };
        if let Some(moves) = job.safe_tail(&timeline, context)? {
            repaired.tails.retain(|tail| tail.robot != robot);
            repaired.tails.push(Tail { robot, moves });
        }
        Ok(repaired)
    }
}
