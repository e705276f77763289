//! The optimal choice: the least sum of the rounds' lengths over all sequences of rounds.
//!
//! A* over what every robot has done, lazily (Dellin and Srinivasa, LazySP, ICAPS 2016): lengths of rounds are first thought
//! to be their bounds; the rounds of the best sequence are then planned one after the other, and as soon as one takes
//! longer than was thought the search begins again. A sequence all of whose rounds are as long as was thought is the best:
//! no length that is still only thought is greater than the true one.

use std::cmp::Reverse;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BinaryHeap};

use super::sequence::{Done, Rounds, Sequence, Stop, after, enabled, subsets};

/// Lengths up to this apart (s) count as equal.
const EQUAL_S: f64 = 1e-9;

/// What is known of rounds so far (s); infinite where there is none.
type Lengths = BTreeMap<(Done, Vec<usize>), f64>;

/// The best sequence; `None` if there is none.
pub(super) fn optimal(rounds: &mut impl Rounds) -> Result<Option<Sequence>, Stop> {
    let mut lengths = Lengths::new();
    loop {
        let Some(sequence) = best_as_thought(rounds, &lengths)? else { return Ok(None) };
        if is_as_thought(rounds, &sequence, &mut lengths)? {
            return Ok(Some(sequence));
        }
    }
}

/// Plans the rounds of a sequence until one takes longer than was thought.
fn is_as_thought(rounds: &mut impl Rounds, sequence: &Sequence, lengths: &mut Lengths) -> Result<bool, Stop> {
    let mut done = vec![0; rounds.units().len()];
    for robots in sequence {
        if let Entry::Vacant(unknown) = lengths.entry((done.clone(), robots.clone())) {
            let thought_s = bound_s(rounds, &done, robots);
            let length_s = *unknown.insert(rounds.length_s(&done, robots)?.unwrap_or(f64::INFINITY));
            if length_s > thought_s + EQUAL_S {
                return Ok(false);
            }
        }
        done = after(&done, robots);
    }
    Ok(true)
}

fn bound_s(rounds: &impl Rounds, done: &[u32], robots: &[usize]) -> f64 {
    robots.iter().map(|robot| rounds.least_s(*robot, done[*robot])).fold(0.0, f64::max)
}

/// A state's bound on the whole (s, as bits: those of non-negative numbers order as the numbers do), then more done first.
type Open = Reverse<(u64, Reverse<u32>, Done)>;

/// A* with what is thought of lengths.
fn best_as_thought(rounds: &mut impl Rounds, lengths: &Lengths) -> Result<Option<Sequence>, Stop> {
    let units = rounds.units();
    let start = vec![0; units.len()];
    let left_s = work_left(rounds, &units);
    let bound_left_s = |done: &[u32]| done.iter().zip(&left_s).map(|(d, left)| left[*d as usize]).fold(0.0, f64::max);
    let mut reached: BTreeMap<Done, (f64, Option<Vec<usize>>)> = BTreeMap::from([(start.clone(), (0.0, None))]);
    let mut open: BinaryHeap<Open> = BinaryHeap::from([Reverse((bound_left_s(&start).to_bits(), Reverse(0), start))]);
    while let Some(Reverse((bits, _, done))) = open.pop() {
        let (time_s, _) = reached[&done];
        if done == units {
            return Ok(Some(way_to(&reached, done)));
        }
        if (time_s + bound_left_s(&done)).to_bits() < bits {
            continue;
        }
        for robots in subsets(&enabled(rounds, &done)) {
            rounds.spend()?;
            let key = (done.clone(), robots);
            let length_s = lengths.get(&key).copied().unwrap_or_else(|| bound_s(rounds, &done, &key.1));
            let (next, next_s) = (after(&done, &key.1), time_s + length_s);
            if next_s < reached.get(&next).map_or(f64::INFINITY, |known| known.0) {
                let entry = (next_s + bound_left_s(&next)).to_bits();
                open.push(Reverse((entry, Reverse(next.iter().sum()), next.clone())));
                reached.insert(next, (next_s, Some(key.1)));
            }
        }
    }
    Ok(None)
}

/// For each robot, the least time of its units from each on (s).
fn work_left(rounds: &impl Rounds, units: &[u32]) -> Vec<Vec<f64>> {
    let of_robot = |robot: usize| {
        let mut left_s = vec![0.0; units[robot] as usize + 1];
        for unit in (0..units[robot]).rev() {
            left_s[unit as usize] = left_s[unit as usize + 1] + rounds.least_s(robot, unit);
        }
        left_s
    };
    (0..units.len()).map(of_robot).collect()
}

fn way_to(reached: &BTreeMap<Done, (f64, Option<Vec<usize>>)>, mut done: Done) -> Sequence {
    let mut sequence = Sequence::new();
    while let Some((_, Some(robots))) = reached.get(&done) {
        robots.iter().for_each(|robot| done[*robot] -= 1);
        sequence.push(robots.clone());
    }
    sequence.reverse();
    sequence
}
