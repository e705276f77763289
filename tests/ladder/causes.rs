//! What is told of failures saves placement candidates and costs no answer: a search that is told no causes takes up all the
//! candidates that one with causes takes up, and both end alike.
//!
//! That is so where failures depend on poses alone and candidates come in one order whatever is excluded, as in these scenes: what
//! fails is the reach of an arm. Where it is the motion of robots among one another, as in `t24_four_arms`, causes exclude more than
//! is sure, and without them the candidates of a level run out first.

use std::collections::BTreeSet;

use contract::CompositeMethod::Prioritised;
use model::{FailurePolicy, Policies, Problem};
use refiner::End;

use crate::regressions::edited;
use crate::run::{Run, run};
use crate::scene;

fn blind(problem: &Problem) -> Problem {
    let mut blind = problem.clone();
    let told_nothing = Some(FailurePolicy::Backtrack { causes: false });
    let policies =
        Policies { placement: None, transition: told_nothing, roadmap: told_nothing, composite: told_nothing };
    blind.search.policy = policies;
    blind
}

/// How a run ended, as a user is told it.
fn kind(run: &Run) -> String {
    match &run.end {
        End::Solved { .. } => "solved".to_owned(),
        End::Failed { result, .. } => format!("{result:?}"),
        End::Fault(fault) => panic!("{fault}"),
    }
}

/// Two objects for one arm. Of the long table to which the first goes, and perhaps the second, the arm reaches one end.
fn long_table(second_to: &str) -> Problem {
    let table = "{name: table_b, shape: {box: [0.3, 0.3, 0.6]}, pose: {xyz: [0.6, -0.3, 0.3]}}";
    let long = "{name: table_b, shape: {box: [1.6, 0.3, 0.6]}, pose: {xyz: [1.2, -0.3, 0.3]}}";
    let objects = "pose: {xyz: [0.55, 0.3, 0.675]}}
  - {name: m2, shape: {box: [0.07, 0.05, 0.15]}, pose: {xyz: [0.68, 0.3, 0.675]}}";
    let errands = format!("{{object: m1, from: a, to: b}}\n    - {{object: m2, from: a, to: {second_to}}}");
    let edits = [
        (table, long),
        ("{name: b, on: table_b, size: [0.3, 0.3]}", "{name: b, on: table_b, size: [1.6, 0.3]}"),
        ("pose: {xyz: [0.6, 0.3, 0.675]}}", objects),
        ("{object: m1, from: a, to: b}", &errands),
    ];
    Problem { name: format!("a long table, m2 to {second_to}"), ..edited("t00_one_arm", &edits) }
}

#[test]
fn without_causes_all_candidates_are_taken_up_that_are_with_causes_and_both_end_alike() {
    let problems = [long_table("a"), long_table("b"), scene("t14_blocked_for_ever"), scene("t16_out_of_reach")];
    let (mut with_causes, mut without, mut ends) = (0, 0, BTreeSet::new());
    for problem in problems {
        for seed in 0..2 {
            let [told, untold] = [&problem, &blind(&problem)].map(|problem| run(problem, seed, Prioritised));
            let context = format!("{} with seed {seed}", problem.name);
            println!(
                "{context}: {} candidates, {} without causes, {}",
                told.candidates.len(),
                untold.candidates.len(),
                kind(&told)
            );
            assert_eq!(kind(&told), kind(&untold), "{context}");
            assert!(told.candidates.iter().all(|candidate| untold.candidates.contains(candidate)), "{context}");
            if told.plan.is_some() {
                assert_eq!(told.candidates.last(), untold.candidates.last(), "{context}");
            }
            with_causes += told.candidates.len();
            without += untold.candidates.len();
            ends.insert(kind(&told));
        }
    }
    assert!(with_causes < without && ends.len() == 3, "{with_causes} {without} {ends:?}");
}
