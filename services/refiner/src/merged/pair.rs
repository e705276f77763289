//! One pair whose two poses have just become known: its alternatives, and where that is merged, too, its roadmaps.
//!
//! Hops that are not placed yet do not count. Whatever fails here fails with them, too: they only add obstacles.

use contract::Merge;
use model::PairId;
use skeleton::{Mode, Occupancy, Presence};

use crate::candidate::Candidate;
use crate::conflict::{Choice, Conflict, Stuck};
use crate::search::Search;

/// Alternatives whose roadmaps are asked for, of one pair and the robot's earlier ones, before the next hop is placed all
/// the same.
const WAYS: u32 = 128;

impl Candidate<'_> {
    /// Finds a way to do the pair.
    pub(crate) fn serve(&mut self, search: &mut Search<'_>, pair: PairId) -> Result<(), Stuck> {
        self.ask_alternatives(search, &[pair])?;
        self.drop_blocked(search, &[pair])?;
        if search.statement.options.merge == Merge::PlacementToRoadmap {
            self.connect(search, pair, &mut WAYS.clone())?;
        }
        Ok(())
    }

    /// Chooses, from the present alternative of the pair on, the first whose modes connect; where none does, the robot's
    /// earlier pairs are done in other ways: chronological backtracking along the robot's pairs. When no more are `left`
    /// to be tried, nothing is known and nothing given up.
    fn connect(&mut self, search: &mut Search<'_>, pair: PairId, left: &mut u32) -> Result<(), Stuck> {
        let before = self.pair_before(pair);
        let mut why = Conflict::default();
        loop {
            if self.find_connected(search, pair, left, &mut why)? {
                return Ok(());
            }
            why.choices.remove(&Choice::Alternative(pair));
            why.choices.extend(self.ends(pair));
            why.merge(self.choices[pair.index()].why_fewer());
            let Some(before) = before.filter(|before| why.choices.remove(&Choice::Alternative(*before))) else {
                return Err(Stuck::Failed(why));
            };
            match self.another_way(search, before, left) {
                Ok(()) => self.choices[pair.index()].take_back(0),
                Err(Stuck::Failed(conflict)) => {
                    why.merge(conflict);
                    return Err(Stuck::Failed(why));
                }
                Err(halted) => return Err(halted),
            }
        }
    }

    /// The next way to do an earlier pair.
    fn another_way(&mut self, search: &mut Search<'_>, pair: PairId, left: &mut u32) -> Result<(), Stuck> {
        if !self.choices[pair.index()].step() {
            let Some(before) = self.pair_before(pair) else {
                // Why each of them was given up is not remembered.
                return Err(Stuck::Failed(Conflict::of(self.known_poses().map(Choice::Pose), &[], None)));
            };
            self.another_way(search, before, left)?;
            self.choices[pair.index()].take_back(0);
        }
        self.connect(search, pair, left)
    }

    /// Goes on to the first alternative whose modes connect, or that nobody may try any more. `false`: there is none.
    fn find_connected(
        &mut self,
        search: &mut Search<'_>,
        pair: PairId,
        left: &mut u32,
        why: &mut Conflict,
    ) -> Result<bool, Stuck> {
        loop {
            if *left == 0 {
                return Ok(true);
            }
            *left -= 1;
            let Err(conflict) = self.connects(search, pair)? else { return Ok(true) };
            let is_its_own = conflict.choices.contains(&Choice::Alternative(pair));
            why.merge(conflict);
            if !is_its_own || !self.choices[pair.index()].step() {
                return Ok(false);
            }
        }
    }

    /// Whether the present alternative's transfer connects, and the transit before it.
    fn connects(&self, search: &mut Search<'_>, pair: PairId) -> Result<Result<(), Conflict>, Stuck> {
        let of_robot = &self.skeleton.modes[self.problem.pair(pair).robot.index()];
        let modes: Vec<Mode> = of_robot.iter().rev().filter(|mode| mode.pair == Some(pair)).copied().collect();
        let Err(mut conflict) = self.try_roadmaps(search, &modes)? else { return Ok(Ok(())) };
        let certain = modes.iter().flat_map(|mode| self.obstructions(mode, Presence::Certain));
        conflict.choices.extend(certain.map(|obstruction| Choice::Pose(obstruction.occupancy)));
        Ok(Err(conflict))
    }

    /// The robot's pair before a pair.
    fn pair_before(&self, pair: PairId) -> Option<PairId> {
        self.problem.pairs_of_robot(self.problem.pair(pair).robot).take_while(|other| *other != pair).last()
    }

    fn known_poses(&self) -> impl Iterator<Item = Occupancy> + '_ {
        self.skeleton.occupancies().filter(|occupancy| self.is_placed(*occupancy))
    }
}
