//! The order of an object's hops, worked out from the task plan.

mod support;

use model::{GivenOrdering, ObjectId, PairId, Point, Problem, ProblemError, load_problem};
use support::{PROBLEM, good};

/// The good problem with another task and other orderings.
fn with_task(task: &str, orderings: &str) -> Result<Problem, ProblemError> {
    let mut files = good();
    let text = String::from_utf8_lossy(&files.0[PROBLEM]).into_owned();
    let head = text.split("task:").next().unwrap_or_default();
    let text = format!("{head}task: {task}\norderings: {orderings}\n");
    files.0.insert(PROBLEM.to_owned(), text.into_bytes());
    load_problem(&files, PROBLEM)
}

fn way(problem: &Problem) -> Vec<&str> {
    problem.hops_of_object(ObjectId(0)).iter().map(|pair| problem.pair(*pair).name.as_str()).collect()
}

#[test]
fn hops_follow_the_way_of_the_object_across_robots() {
    let task = "{r2: [{object: m1, from: b, to: a}], r1: [{object: m1, from: a, to: b}]}";
    let problem = with_task(task, "[]").unwrap();
    assert_eq!(way(&problem), ["r1.1", "r2.1"]);
    assert_eq!(problem.pairs[0].name, "r1.1", "pairs are listed in the order of the robots");
}

#[test]
fn there_and_back_by_two_robots_has_one_order_only() {
    let task = "{r1: [{object: m1, from: a, to: b}, {object: m1, from: a, to: b}], r2: [{object: m1, from: b, to: a}]}";
    assert_eq!(way(&with_task(task, "[]").unwrap()), ["r1.1", "r2.1", "r1.2"]);
}

#[test]
fn given_orderings_decide_between_ways() {
    let task = "{r1: [{object: m1, from: a, to: a}], r2: [{object: m1, from: a, to: a}]}";
    assert!(with_task(task, "[]").is_err());
    let problem = with_task(task, "[{before: r2.1 release, after: r1.1 grasp}]").unwrap();
    assert_eq!(way(&problem), ["r2.1", "r1.1"]);
    let expected = GivenOrdering { before: (PairId(1), Point::Release), after: (PairId(0), Point::Grasp) };
    assert_eq!(problem.orderings, [expected]);
}

#[test]
fn orderings_that_contradict_each_other_are_told_as_a_cycle() {
    let task = "{r1: [{object: m1, from: a, to: a}], r2: [{object: m1, from: a, to: a}]}";
    let orderings = "[{before: r2.1 release, after: r1.1 grasp}, {before: r1.1 release, after: r2.1 grasp}]";
    let error = with_task(task, orderings).unwrap_err();
    assert_eq!(error.findings()[0].kind().name(), "cyclic_order");
}

#[test]
fn many_equal_hops_are_refused_quickly_and_many_ordered_ones_are_read() {
    let hops = |count: usize| vec!["{object: m1, from: a, to: a}"; count].join(", ");
    let one_robot = format!("{{r1: [{}]}}", hops(400));
    assert_eq!(with_task(&one_robot, "[]").unwrap().pairs[399].hop, 400);
    let two_robots = format!("{{r1: [{}], r2: [{}]}}", hops(200), hops(200));
    assert_eq!(with_task(&two_robots, "[]").unwrap_err().findings()[0].kind().name(), "bad_task");
    let too_many = format!("{{r1: [{}]}}", hops(501));
    assert_eq!(with_task(&too_many, "[]").unwrap_err().findings()[0].kind().name(), "too_large");
}
