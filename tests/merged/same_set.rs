//! The three pipelines accept exactly the same placements: of all combinations of few samples, the same ones.

use std::collections::BTreeSet;

use contract::{Merge, StageKind};
use model::Problem;

use crate::acceptance::{Pipelines, Placement};
use crate::brute::Brute;
use crate::generator::{Size, problem};
use crate::{coarse, scene};

const MERGED: [Merge; 2] = [Merge::PlacementAndTransition, Merge::PlacementToRoadmap];

/// Sizes of sets over all problems.
#[derive(Debug, Default)]
struct Totals {
    problems: usize,
    placed: usize,
    ordered: usize,
    with_alternatives: usize,
    with_roadmaps: usize,
}

impl Totals {
    /// Compares the pipelines on one problem.
    fn compare(&mut self, name: &str, problem: &Problem, seed: u64) {
        let mut pipelines = Pipelines::new(problem, seed);
        let brute = Brute::new(&mut pipelines).all();
        let mut accepted = |merge, until| pipelines.accepted(merge, false, until).0;
        let up_to_two = accepted(Merge::None, StageKind::Roadmap);
        assert_same(name, "brute force and steps apart, up to step 2", &brute.with_alternatives, &up_to_two);
        let merged = accepted(Merge::PlacementAndTransition, StageKind::Roadmap);
        assert_same(name, "1&2 merged, up to step 2", &merged, &up_to_two);
        let up_to_three = accepted(Merge::None, StageKind::Composite);
        for merge in MERGED {
            let merged = accepted(merge, StageKind::Composite);
            assert_same(name, &format!("{merge:?}, up to step 3"), &merged, &up_to_three);
        }
        for merge in MERGED {
            let (with_causes, _) = pipelines.accepted(merge, true, StageKind::Composite);
            assert!(with_causes.is_subset(&up_to_three), "{name}: {merge:?} with causes");
        }
        self.problems += 1;
        self.placed += brute.placements.len();
        self.ordered += brute.placements.iter().filter(|(_, orders)| !orders.is_empty()).count();
        self.with_alternatives += up_to_two.len();
        self.with_roadmaps += up_to_three.len();
        println!(
            "{name}: {} placements, {} up to step 2, {} up to step 3",
            brute.placements.len(),
            up_to_two.len(),
            up_to_three.len()
        );
    }
}

fn assert_same(name: &str, what: &str, found: &BTreeSet<Placement>, expected: &BTreeSet<Placement>) {
    let (more, fewer): (Vec<_>, Vec<_>) =
        (found.difference(expected).take(3).collect(), expected.difference(found).take(3).collect());
    assert!(more.is_empty() && fewer.is_empty(), "{name}: {what}: only there {more:?}, missing {fewer:?}");
}

#[test]
fn on_scenes_of_the_ladder_the_three_pipelines_accept_the_same_placements() {
    let mut totals = Totals::default();
    let scenes = [
        ("t05_tiny_region", 4),
        ("t08_off_diagonal", 4),
        ("t09_swap", 3),
        ("t10_swap_with_buffer", 2),
        ("t12_deep_cabinet", 3),
        ("t13_occluded", 3),
        ("t15b_regrasp", 3),
    ];
    for (name, placements) in scenes {
        for [grasps, stands] in [[4, 3], [2, 1]] {
            totals.compare(name, &coarse(scene(name), [placements, grasps, stands]), 0);
        }
    }
    println!("{totals:?}");
    assert!(totals.ordered > 10 && totals.with_alternatives < totals.placed, "{totals:?}");
    assert!((1..totals.with_alternatives).contains(&totals.with_roadmaps), "{totals:?}");
}

#[test]
fn on_random_problems_the_three_pipelines_accept_the_same_placements() {
    let mut totals = Totals::default();
    for seed in 0..24 {
        let problem = problem(Size::Small, seed);
        if (2..=4).contains(&problem.pairs.len()) {
            totals.compare(&format!("random problem {seed}"), &coarse(problem, [2, 3, 2]), seed);
        }
    }
    println!("{totals:?}");
    assert!(totals.problems > 5 && totals.with_roadmaps > 5, "{totals:?}");
}
