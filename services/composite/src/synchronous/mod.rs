//! Synchronous schedules, for comparison with asynchronous ones: all robots move in rounds.
//!
//! In a round each robot either does one *unit* from begin to end or idles where it is. A unit is a mode (transit,
//! transfer, closing return) with the pause of the hand after its event. The next round begins when all units of the round
//! are over, so a round is as long as its slowest unit, and a schedule as long as all its rounds together. An ordering
//! X ≺ Y means here that X's unit is in an earlier round than Y's.
//!
//! Roadmaps, durations of edges and the relation of what conflicts are those of the asynchronous planner. Who has done how
//! many units tells where every robot stands and every object lies; so a round is a function of these numbers and of the
//! robots that move in it ([`rounds`]).
//!
//! * *Greedy*: each round has the most robots that can move together; of equally many, the first by the problem's order.
//!   Where that ends before all is done, the last round is chosen anew.
//! * *Optimal*: the least sum of the rounds' lengths over **all** sequences of rounds, where the length of a round is what
//!   the planner of rounds says ([`rounds::RoundPlanner`]): robots one after the other by safe-interval search, in every
//!   order for up to four robots; where no order serves, one of them first makes room ([`evasion`]). A round that is shorter
//!   than all those, or that only a search over all its robots at once finds, is not known to it. What it minimises is when everybody is home, not when the last arm is folded.

mod commitments;
mod evasion;
mod greedy;
mod needs;
mod optimal;
mod rounds;
mod sequence;
mod team;
mod unit;

use contract::{
    Answer, Assignment, CauseTally, Interrupted, JobContext, Outcome, Prefix, Product, ProductRef, RoundChoice,
};
use plan::Cause;

use crate::Scene;
use rounds::{Round, RoundPlanner};
use sequence::Stop;
use team::Team;

/// What to schedule.
pub(crate) struct SynchronousJob<'a> {
    pub scene: &'a Scene,
    pub assignment: &'a Assignment,
    pub choice: RoundChoice,
    pub roadmaps: &'a [Vec<ProductRef>],
}

impl SynchronousJob<'_> {
    /// The prefix of a whole schedule and its rounds, or who is in the way.
    pub fn answer(&self, context: &mut JobContext<'_>) -> Result<Outcome, Interrupted> {
        let team = Team::load(self.scene, self.assignment, self.roadmaps, context)?;
        let mut planner = RoundPlanner::new(&team, context);
        let sequence = match self.choice {
            RoundChoice::Greedy => greedy::greedy(&mut planner),
            RoundChoice::Optimal => optimal::optimal(&mut planner),
        };
        match sequence {
            Ok(Some(sequence)) => self.schedule(&team, planner.rounds_of(&sequence), context),
            Ok(None) => Ok(Outcome::soft_failure(planner.causes(), 0, context.spent())),
            Err(Stop::Budget) => {
                let mut causes = CauseTally::default();
                causes.count(Cause::Budget { stage: "composite".into() });
                Ok(Outcome::soft_failure(causes, 0, context.spent()))
            }
            Err(Stop::Interrupted(interrupted)) => Err(interrupted),
        }
    }

    fn schedule(
        &self,
        team: &Team<'_>,
        rounds: Vec<Round>,
        context: &mut JobContext<'_>,
    ) -> Result<Outcome, Interrupted> {
        let (commitments, ends_s) = commitments::commitments(team, &rounds);
        let modes = rounds.iter().map(|round| round.units.iter().map(|unit| unit.mode).collect()).collect();
        let prefix = context.publish(&Product::Prefix(Prefix { parent: None, commitments, tails: Vec::new() }))?;
        Ok(Outcome::answer(Answer::Rounds { prefix, rounds: modes, ends_s }, context.spent()))
    }
}

#[cfg(test)]
mod tests;
