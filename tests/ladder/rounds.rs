//! Plans in which everybody has a clock of their own against plans in rounds, on the same placements, grasps and roadmaps.

use contract::CompositeMethod::{self, Prioritised, SyncGreedy, SyncOpt};
use model::Problem;

use crate::run::run;
use crate::scene;

/// Lower bound and makespan of the task (s).
fn seconds(problem: &Problem, seed: u64, method: CompositeMethod) -> (f64, f64) {
    let found = run(problem, seed, method);
    let plan = found.plan.unwrap_or_else(|| panic!("{} with seed {seed}: {:?}", problem.name, found.end));
    validation::check_plan(problem, &plan).unwrap();
    (plan.lower_bound.seconds, plan.makespan.task_s)
}

/// In these the first to arrive would make the other late: committed by the earliest event alone, the plans were longer than
/// those in rounds by 1 to 22 %.
#[test]
fn plans_are_no_longer_than_those_in_rounds_where_right_of_way_decides() {
    for (name, seeds) in [("t09_swap", &[0, 1, 2, 3, 4][..]), ("t22_both_jambs", &[0, 2, 4])] {
        let problem = scene(name);
        for &seed in seeds {
            let (own, rounds) = (seconds(&problem, seed, Prioritised), seconds(&problem, seed, SyncOpt));
            println!("{name} seed {seed}: {:.3} s, in rounds {:.3} s, bound {:.3} s", own.1, rounds.1, own.0);
            assert_eq!(own.0, rounds.0, "{name} with seed {seed}: not from the same choices");
            assert!(own.1 <= rounds.1 + 1e-9, "{name} with seed {seed}: {} s, in rounds {} s", own.1, rounds.1);
        }
    }
}

/// The round in which the two pass one another is found: one waits in the bay in the middle of its mode.
#[test]
fn rounds_in_which_one_makes_room_for_the_other_are_found() {
    let problem = scene("t19_passing_bay");
    for method in [SyncGreedy, SyncOpt] {
        let (bound_s, task_s) = seconds(&problem, 0, method);
        assert!(bound_s <= task_s && task_s < 1.6 * bound_s, "{task_s} s, bound {bound_s} s");
    }
}
