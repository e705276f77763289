//! Sequences of rounds, and what they are chosen by.

use contract::Interrupted;

/// How many units each robot has done.
pub(super) type Done = Vec<u32>;

/// Robots that move in each round, ascending.
pub(super) type Sequence = Vec<Vec<usize>>;

/// Why a choice of rounds was broken off.
#[derive(Debug)]
pub(super) enum Stop {
    Interrupted(Interrupted),
    Budget,
}

impl From<Interrupted> for Stop {
    fn from(interrupted: Interrupted) -> Self {
        Self::Interrupted(interrupted)
    }
}

/// What rounds there are.
pub(super) trait Rounds {
    /// Number of units of each robot.
    fn units(&self) -> Done;

    /// Whether everything that must come in earlier rounds than a robot's next unit is done. It has a next one.
    fn is_enabled(&self, done: &[u32], robot: usize) -> bool;

    /// Bound on the time of a unit (s): it never takes less.
    fn least_s(&self, robot: usize, unit: u32) -> f64;

    /// Length of the round in which `robots`, ascending, do their next units and the others idle (s). `None`: it has been
    /// found impossible.
    fn length_s(&mut self, done: &[u32], robots: &[usize]) -> Result<Option<f64>, Stop>;

    /// Spends one work unit.
    fn spend(&mut self) -> Result<(), Stop>;
}

/// Robots whose next units may be done now, ascending.
pub(super) fn enabled(rounds: &impl Rounds, done: &[u32]) -> Vec<usize> {
    let units = rounds.units();
    (0..units.len()).filter(|r| done[*r] < units[*r] && rounds.is_enabled(done, *r)).collect()
}

/// What is done after a round.
pub(super) fn after(done: &[u32], robots: &[usize]) -> Done {
    let mut done = done.to_vec();
    robots.iter().for_each(|robot| done[*robot] += 1);
    done
}

/// All non-empty subsets of a sorted list: the largest first, equally large ones in lexicographic order.
pub(super) fn subsets(all: &[usize]) -> impl Iterator<Item = Vec<usize>> + '_ {
    (1..=all.len()).rev().flat_map(|size| {
        std::iter::successors(Some((0..size).collect::<Vec<usize>>()), |chosen| next_choice(chosen, all.len()))
            .map(|chosen| chosen.into_iter().map(|index| all[index]).collect())
    })
}

/// The next ascending choice of equally many numbers below `limit`.
fn next_choice(chosen: &[usize], limit: usize) -> Option<Vec<usize>> {
    let size = chosen.len();
    let last = (0..size).rev().find(|i| chosen[*i] < limit - size + i)?;
    let mut next = chosen.to_vec();
    for (offset, place) in next[last..].iter_mut().enumerate() {
        *place = chosen[last] + 1 + offset;
    }
    Some(next)
}
