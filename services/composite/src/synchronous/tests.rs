//! Choices of rounds in worlds of numbers: units have durations, some exclude one another, and brute force knows the best.

use std::collections::{BTreeMap, BTreeSet};

use super::greedy::greedy;
use super::optimal::optimal;
use super::sequence::{Done, Rounds, Sequence, Stop, after, enabled, subsets};

/// Deterministic random numbers.
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) % n as u64) as usize
    }
}

type UnitId = (usize, u32);

/// Units by their least durations; which may not be in one round; what comes before what; what takes longer, or is
/// impossible, in one round after what has been done.
#[derive(Clone, Debug, Default)]
struct World {
    least_s: Vec<Vec<f64>>,
    apart: BTreeSet<(UnitId, UnitId)>,
    before: Vec<(UnitId, UnitId)>,
    longer_s: BTreeMap<(Done, Vec<usize>), f64>,
    asked: u32,
    budget: u32,
}

impl World {
    fn new(least_s: &[&[f64]]) -> Self {
        Self { least_s: least_s.iter().map(|units| units.to_vec()).collect(), budget: u32::MAX, ..Self::default() }
    }

    fn random(dice: &mut Dice) -> Self {
        let robots = 1 + dice.below(3);
        let mut world = Self { budget: u32::MAX, ..Self::default() };
        for _ in 0..robots {
            let units = 1 + dice.below(3);
            world.least_s.push((0..units).map(|_| 1.0 + dice.below(9) as f64).collect());
        }
        let unit = |dice: &mut Dice, world: &Self| {
            let robot = dice.below(robots);
            (robot, dice.below(world.least_s[robot].len()) as u32)
        };
        for _ in 0..dice.below(6) {
            let pair = (unit(dice, &world), unit(dice, &world));
            world.apart.extend([pair, (pair.1, pair.0)]);
        }
        for _ in 0..dice.below(3) {
            let pair = (unit(dice, &world), unit(dice, &world));
            if pair.0.0 != pair.1.0 {
                world.before.push(pair);
            }
        }
        for _ in 0..dice.below(12) {
            let done: Done = world.least_s.iter().map(|units| dice.below(units.len() + 1) as u32).collect();
            let robots: Vec<usize> = (0..robots).filter(|_| dice.below(2) == 0).collect();
            let longer_s = [0.5, 1.5, 4.0, f64::INFINITY][dice.below(4)];
            world.longer_s.insert((done, robots), longer_s);
        }
        world
    }

    /// Length of a round, without anything remembered (s).
    fn true_length_s(&self, done: &[u32], robots: &[usize]) -> f64 {
        let units: Vec<UnitId> = robots.iter().map(|robot| (*robot, done[*robot])).collect();
        if units.iter().any(|a| units.iter().any(|b| self.apart.contains(&(*a, *b)) && a != b)) {
            return f64::INFINITY;
        }
        let least_s = units.iter().map(|(robot, unit)| self.least_s[*robot][*unit as usize]).fold(0.0, f64::max);
        least_s + self.longer_s.get(&(done.to_vec(), robots.to_vec())).copied().unwrap_or(0.0)
    }

    fn total_s(&self, sequence: &Sequence) -> f64 {
        let mut done = vec![0; self.least_s.len()];
        let mut total_s = 0.0;
        for robots in sequence {
            assert!(robots.iter().all(|robot| self.is_enabled(&done, *robot)), "{self:?}: {sequence:?}");
            total_s += self.true_length_s(&done, robots);
            done = after(&done, robots);
        }
        assert_eq!(done, self.units(), "{self:?}: {sequence:?}");
        total_s
    }

    /// The least total from a state on, by trying every sequence of rounds.
    fn least_total_s(&self, done: &[u32]) -> f64 {
        if done == self.units() {
            return 0.0;
        }
        let able: Vec<usize> =
            (0..done.len()).filter(|r| done[*r] < self.units()[*r] && self.is_enabled(done, *r)).collect();
        let mut least_s = f64::INFINITY;
        for chosen in 1_u32..1 << able.len() {
            let robots: Vec<usize> = (0..able.len()).filter(|i| chosen >> i & 1 == 1).map(|i| able[i]).collect();
            let length_s = self.true_length_s(done, &robots);
            if length_s.is_finite() {
                least_s = least_s.min(length_s + self.least_total_s(&after(done, &robots)));
            }
        }
        least_s
    }
}

impl Rounds for World {
    fn units(&self) -> Done {
        self.least_s.iter().map(|units| units.len() as u32).collect()
    }

    fn is_enabled(&self, done: &[u32], robot: usize) -> bool {
        let next = (robot, done[robot]);
        self.before.iter().filter(|(_, later)| *later == next).all(|((other, unit), _)| done[*other] > *unit)
    }

    fn least_s(&self, robot: usize, unit: u32) -> f64 {
        self.least_s[robot][unit as usize]
    }

    fn length_s(&mut self, done: &[u32], robots: &[usize]) -> Result<Option<f64>, Stop> {
        self.asked += 1;
        Ok(Some(self.true_length_s(done, robots)).filter(|length_s| length_s.is_finite()))
    }

    fn spend(&mut self) -> Result<(), Stop> {
        self.budget = self.budget.checked_sub(1).ok_or(Stop::Budget)?;
        Ok(())
    }
}

#[test]
fn the_optimal_choice_is_as_short_as_the_best_of_all_sequences() {
    let (mut without, mut longer) = (0, 0);
    for seed in 0..400 {
        let world = World::random(&mut Dice(seed * 7919 + 3));
        let least_s = world.least_total_s(&vec![0; world.least_s.len()]);
        let (best, quick) = (optimal(&mut world.clone()).unwrap(), greedy(&mut world.clone()).unwrap());
        let Some(best) = best else {
            assert!(least_s.is_infinite(), "seed {seed}: {world:?} has a sequence of {least_s} s");
            assert_eq!(quick, None, "seed {seed}");
            without += 1;
            continue;
        };
        assert!((world.total_s(&best) - least_s).abs() < 1e-9, "seed {seed}: {world:?}: {best:?}, best {least_s} s");
        let Some(quick) = quick else { panic!("seed {seed}: greedy finds none") };
        longer += usize::from(world.total_s(&quick) > least_s + 1e-9);
        assert!(world.total_s(&quick) >= least_s - 1e-9, "seed {seed}");
    }
    assert!(without > 10 && longer > 10, "{without} without a sequence, {longer} where greedy takes longer");
}

#[test]
fn greedy_moves_all_it_can_and_so_may_pair_short_units_with_long_ones() {
    // r1: 1 s, then 10 s; r2: 10 s. All at once: 10 + 10 s. r1 alone first: 1 + 10 s.
    let mut world = World::new(&[&[1.0, 10.0], &[10.0]]);
    assert_eq!(greedy(&mut world).unwrap().unwrap(), [vec![0, 1], vec![0]]);
    assert_eq!(world.total_s(&vec![vec![0, 1], vec![0]]), 20.0);
    let best = optimal(&mut world).unwrap().unwrap();
    assert_eq!(best, [vec![0], vec![0, 1]]);
    assert_eq!(world.total_s(&best), 11.0);
}

#[test]
fn of_equally_many_robots_greedy_takes_the_first_of_the_problem() {
    let mut world = World::new(&[&[1.0], &[2.0], &[3.0]]);
    world.apart.extend([((0, 0), (1, 0)), ((1, 0), (0, 0)), ((1, 0), (2, 0)), ((2, 0), (1, 0))]);
    assert_eq!(greedy(&mut world).unwrap().unwrap(), [vec![0, 2], vec![1]]);
    world.apart.extend([((0, 0), (2, 0)), ((2, 0), (0, 0))]);
    assert_eq!(greedy(&mut world).unwrap().unwrap(), [vec![0], vec![1], vec![2]]);
}

#[test]
fn an_ordering_puts_its_units_in_different_rounds() {
    let mut world = World::new(&[&[3.0], &[4.0, 1.0]]);
    world.before.push(((0, 0), (1, 0)));
    for sequence in [greedy(&mut world), optimal(&mut world)] {
        let sequence = sequence.unwrap().unwrap();
        assert_eq!(sequence, [vec![0], vec![1], vec![1]]);
        assert_eq!(world.total_s(&sequence), 8.0);
    }
    world.before.push(((1, 1), (0, 0)));
    assert_eq!((greedy(&mut world).unwrap(), optimal(&mut world).unwrap()), (None, None));
}

#[test]
fn where_nobody_can_move_greedy_goes_back_as_little_as_helps() {
    let mut world = World::new(&[&[1.0, 1.0], &[1.0]]);
    // Both together first is a dead end; the first alone is not.
    world.longer_s.insert((vec![1, 1], vec![0]), f64::INFINITY);
    assert_eq!(greedy(&mut world).unwrap().unwrap(), [vec![0], vec![0, 1]]);
    assert_eq!(optimal(&mut world).unwrap().unwrap(), [vec![0], vec![0, 1]]);
    // Now that is none either, unless the first goes on alone.
    world.longer_s.insert((vec![1, 0], vec![0, 1]), f64::INFINITY);
    assert_eq!(greedy(&mut world).unwrap().unwrap(), [vec![0], vec![0], vec![1]]);
    world.longer_s.insert((vec![2, 0], vec![1]), f64::INFINITY);
    assert_eq!(greedy(&mut world).unwrap(), None);
}

#[test]
fn rounds_that_the_best_sequence_does_not_need_are_not_planned() {
    let least_s: Vec<Vec<f64>> = (0..3).map(|_| vec![1.0; 6]).collect();
    let mut world = World { least_s, budget: u32::MAX, ..World::default() };
    assert_eq!(optimal(&mut world).unwrap().unwrap().len(), 6);
    assert_eq!(world.asked, 6);
}

#[test]
fn a_choice_ends_when_its_budget_is_used_up() {
    let mut world = World::new(&[&[1.0; 6], &[1.0; 6], &[1.0; 6]]);
    world.budget = 5;
    assert!(matches!(optimal(&mut world), Err(Stop::Budget)));
    world.budget = 3;
    assert!(matches!(greedy(&mut world), Err(Stop::Budget)));
}

#[test]
fn subsets_come_largest_first_and_are_all_there() {
    let all: Vec<Vec<usize>> = subsets(&[2, 5, 7]).collect();
    let expected: [&[usize]; 7] = [&[2, 5, 7], &[2, 5], &[2, 7], &[5, 7], &[2], &[5], &[7]];
    assert_eq!(all, expected);
    assert_eq!(subsets(&[]).count(), 0);
    assert_eq!(subsets(&(0..10).collect::<Vec<_>>()).collect::<BTreeSet<_>>().len(), 1023);
    let world = World::new(&[&[1.0], &[1.0]]);
    assert_eq!(enabled(&world, &[1, 0]), [1]);
}
