//! Random problems under a limit on work: whatever comes out, no plan is wrong.

use contract::CompositeMethod::Prioritised;
use plan::Plan;
use refiner::End;

use crate::generator::{Size, problem};
use crate::run::{run_with, verify};

/// Work units of one run.
const LIMIT: u64 = 40_000;

fn bytes(plan: &Plan) -> Vec<u8> {
    plan::write_plan(plan).unwrap()
}

/// How many of these seeds' problems are solved.
fn solved(size: Size, seeds: std::ops::Range<u64>, again_every: u64) -> usize {
    let mut solved = 0;
    for seed in seeds {
        let problem = problem(size, seed);
        let found = run_with(&problem, seed, Prioritised, LIMIT, None);
        if let Some(plan) = &found.plan {
            if let Err(violations) = validation::check_plan(&problem, plan) {
                panic!("the checker refuses the plan of {size:?} {seed}: {violations:?}");
            }
            solved += 1;
        }
        if let End::Failed { certificate: Some(certificate), .. } = &found.end {
            verify(&problem, certificate).unwrap_or_else(|why| panic!("{size:?} {seed}: {why}"));
        }
        if seed % again_every == 0 {
            let again = run_with(&problem, seed, Prioritised, LIMIT, None);
            assert_eq!(found.ledger, again.ledger, "{size:?} {seed} is not planned the same again");
            assert_eq!(found.plan.as_ref().map(bytes), again.plan.as_ref().map(bytes), "{size:?} {seed}");
        }
    }
    solved
}

#[test]
fn small_random_problems_are_planned_right_or_not_at_all_and_the_same_again() {
    let solved = solved(Size::Small, 0..24, 8);
    println!("{solved} of 24 small ones");
    assert!(solved >= 6, "{solved} of 24 were solved: the generator makes no problems worth solving");
}

#[test]
fn large_random_problems_are_planned_right_or_not_at_all() {
    println!("{} of 2 large ones", solved(Size::Large, 0..2, 100));
}
