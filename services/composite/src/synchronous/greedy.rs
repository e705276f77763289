//! The greedy choice: in each round the most robots that can move together.

use std::collections::BTreeSet;

use super::sequence::{Done, Rounds, Sequence, Stop, after, enabled, subsets};

/// Round after round. Where nobody can move before all is done, the last round is chosen anew. `None`: there is no
/// sequence of rounds.
pub(super) fn greedy(rounds: &mut impl Rounds) -> Result<Option<Sequence>, Stop> {
    let units = rounds.units();
    let mut done = vec![0; units.len()];
    // The sequence so far, with how many sets of robots have been looked at for each round.
    let mut sequence: Vec<(Vec<usize>, usize)> = Vec::new();
    let (mut looked_at, mut dead_ends) = (0, BTreeSet::new());
    while done != units {
        if let Some((robots, next)) = most_robots(rounds, &done, looked_at, &dead_ends)? {
            done = after(&done, &robots);
            sequence.push((robots, next));
            looked_at = 0;
            continue;
        }
        dead_ends.insert(done.clone());
        let Some((robots, next)) = sequence.pop() else { return Ok(None) };
        robots.iter().for_each(|robot| done[*robot] -= 1);
        looked_at = next;
    }
    Ok(Some(sequence.into_iter().map(|(robots, _)| robots).collect()))
}

/// The first set of robots from the `from`-th on that can move together and is not known to lead to a dead end, with the
/// number of the set after it.
fn most_robots(
    rounds: &mut impl Rounds,
    done: &[u32],
    from: usize,
    dead_ends: &BTreeSet<Done>,
) -> Result<Option<(Vec<usize>, usize)>, Stop> {
    for (number, robots) in subsets(&enabled(rounds, done)).enumerate().skip(from) {
        rounds.spend()?;
        if !dead_ends.contains(&after(done, &robots)) && rounds.length_s(done, &robots)?.is_some() {
            return Ok(Some((robots, number + 1)));
        }
    }
    Ok(None)
}
