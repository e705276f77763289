//! Local coupled repair of a dead end: a stuck mode and the robots in its way are planned together, and commitment goes on
//! behind them.

use std::collections::BTreeSet;

use contract::{Answer, Composition, Decision, FailureReport, LedgerEntry, ProductRef, StageKind};
use model::RobotId;
use skeleton::ModeId;

use crate::asking::misfit;
use crate::candidate::{Candidate, Modes};
use crate::commit::{Round, Stranded};
use crate::compose::roadmaps_of;
use crate::conflict::Halt;
use crate::search::Search;

impl Candidate<'_> {
    /// The round behind a repair of the first of some dead ends that can be repaired.
    pub(crate) fn repair_one(
        &self,
        search: &mut Search<'_>,
        modes: &Modes,
        base: &Round,
        dead_ends: &[Round],
    ) -> Result<Option<Round>, Halt> {
        for dead_end in dead_ends {
            if let Some(repaired) = self.repair_any(search, modes, base, dead_end)? {
                return Ok(Some(repaired));
            }
        }
        Ok(None)
    }

    /// The round behind the first repair that succeeds: of every stranded mode with those in its way, then with one robot
    /// more, and so on, each where the mode was first stuck, then at the dead end. Closing returns come last: who has
    /// returned makes room for nobody.
    fn repair_any(
        &self,
        search: &mut Search<'_>,
        modes: &Modes,
        base: &Round,
        dead_end: &Round,
    ) -> Result<Option<Round>, Halt> {
        let stranded = dead_end.stranded.iter().map(Self::first_set);
        let held_back = dead_end.held_back.iter().map(|(mode, robot)| (*mode, BTreeSet::from([mode.robot, *robot])));
        let mut open: Vec<(ModeId, BTreeSet<RobotId>)> = stranded.chain(held_back).collect();
        open.sort_by_key(|(mode, _)| self.skeleton.mode(*mode).ends.is_none());
        let all = dead_end.prefixes.len();
        while !open.is_empty() {
            let mut wider = Vec::new();
            for (mode, robots) in open {
                // What is behind a repair stays as it is.
                let since = dead_end.stuck_since.get(&mode).map_or(all, |since| (*since).max(base.prefixes.len()));
                let mut last = None;
                for at in std::iter::once(since).chain((since < all).then_some(all)) {
                    match self.repair(search, modes, &dead_end.cut(at), mode, &robots)? {
                        Ok(repaired) => return Ok(Some(repaired)),
                        Err(report) => last = Some(report),
                    }
                }
                wider.extend(last.and_then(|report| self.widened(mode, robots, &report, dead_end)));
            }
            open = wider;
        }
        Ok(None)
    }

    fn first_set(stranded: &Stranded) -> (ModeId, BTreeSet<RobotId>) {
        (stranded.mode, stranded.by.iter().copied().chain([stranded.mode.robot]).collect())
    }

    /// One robot more: one that the report names, else any that is not yet done with everything.
    fn widened(
        &self,
        mode: ModeId,
        mut robots: BTreeSet<RobotId>,
        report: &FailureReport,
        round: &Round,
    ) -> Option<(ModeId, BTreeSet<RobotId>)> {
        let named = self.robots_at_fault(&report.causes, mode.robot);
        let is_done = |robot: &RobotId| round.next[robot.index()] == self.skeleton.modes[robot.index()].len();
        let others = named.into_iter().chain(self.problem.robot_ids().filter(|robot| !is_done(robot)));
        let one = { others }.find(|robot| !robots.contains(robot))?;
        robots.insert(one);
        Some((mode, robots))
    }

    fn repair(
        &self,
        search: &mut Search<'_>,
        modes: &Modes,
        round: &Round,
        mode: ModeId,
        robots: &BTreeSet<RobotId>,
    ) -> Result<Result<Round, FailureReport>, Halt> {
        let prefix = round.prefixes.last().copied();
        search.commit(LedgerEntry::Decided(Decision::Repair(mode)));
        let robots = robots.iter().copied().collect();
        let job = self.compose_job(Composition::Repair { prefix, mode, robots, roadmaps: roadmaps_of(modes) });
        match search.ask_one(&job)?.result {
            Ok(Answer::Repaired { prefix, modes }) => self.behind(search, round, prefix, &modes).map(Ok),
            Ok(_) => Err(misfit(StageKind::Composite).into()),
            Err(report) => {
                let because = report.causes.first().map(|(cause, _)| cause.clone());
                search.backtrack(StageKind::Composite, Decision::Repair(mode), because);
                Ok(Err(report))
            }
        }
    }

    /// A round that goes on behind a repair.
    fn behind(
        &self,
        search: &mut Search<'_>,
        round: &Round,
        prefix: ProductRef,
        done: &[(ModeId, f64)],
    ) -> Result<Round, Halt> {
        let mut next = round.next.clone();
        for (mode, _) in done {
            search.commit(LedgerEntry::Decided(Decision::Commit(*mode)));
            let next = next.get_mut(mode.robot.index()).filter(|next| **next == mode.step as usize);
            *next.ok_or_else(|| misfit(StageKind::Composite))? += 1;
        }
        let mut round = round.clone();
        round.push_all(done, prefix);
        Ok(round)
    }
}
