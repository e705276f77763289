//! Plans executed with extra pauses.

use plan::{Dependency, EventKind, KnotRef, Plan};
use validation::{Rule, check_plan, delayed_execution};

use crate::fixture::{accepted, rules};
use crate::numbers::Random;
use crate::scenarios::{relay, side_by_side, single};

fn no_pauses(plan: &Plan) -> Vec<Vec<f64>> {
    plan.robots.iter().map(|robot| vec![0.0; robot.knots.len()]).collect()
}

fn arc(before: (&str, usize), after: (&str, usize)) -> Dependency {
    let knot = |(robot, knot): (&str, usize)| KnotRef { robot: robot.to_owned(), knot };
    Dependency { before: knot(before), after: knot(after) }
}

#[test]
fn no_pauses_give_the_identical_plan() {
    for (_, plan) in [single(), relay(), side_by_side()] {
        assert_eq!(delayed_execution(&plan, &no_pauses(&plan)).expect("no deadlock"), plan);
        assert_eq!(delayed_execution(&plan, &[]).expect("no deadlock"), plan);
    }
    // A pause at the last knot is not between anything.
    let (_, plan) = single();
    let mut pauses = no_pauses(&plan);
    *pauses[0].last_mut().expect("it moves") = 3.0;
    assert_eq!(delayed_execution(&plan, &pauses).expect("no deadlock"), plan);
}

#[test]
fn a_pause_delays_all_that_follows_and_keeps_every_label() {
    let (problem, plan) = single();
    // At the attach: the object is attached on arrival, and the pause comes on top of the grip time.
    let attach = plan.events[0].knot;
    let mut pauses = no_pauses(&plan);
    pauses[0][attach] = 2.0;
    let late = delayed_execution(&plan, &pauses).expect("no arcs");
    accepted(&problem, &late);
    let (knots, new) = (&plan.robots[0].knots, &late.robots[0].knots);
    assert_eq!(new.len(), knots.len() + 1);
    assert_eq!(new[..=attach], knots[..=attach]);
    for (i, knot) in knots.iter().enumerate().skip(attach) {
        assert_eq!((new[i + 1].t, &new[i + 1].q), (knot.t + 2.0, &knot.q));
    }
    assert_eq!((late.events[0].t, late.events[0].knot), (plan.events[0].t, attach));
    assert_eq!((late.events[1].t, late.events[1].knot), (plan.events[1].t + 2.0, plan.events[1].knot + 1));
    assert_eq!(late.robots[0].segments.len(), plan.robots[0].segments.len());
    assert_eq!(late.robots[0].segments[attach].to, attach + 2);
    assert_eq!(late.makespan.total_s, plan.makespan.total_s + 2.0);
    assert_eq!(late.makespan.task_s, plan.makespan.task_s + 2.0);
}

#[test]
fn whoever_waits_for_a_late_robot_waits_longer() {
    let (problem, plan) = relay();
    let mut pauses = no_pauses(&plan);
    pauses[0][1] = 5.0;
    let late = delayed_execution(&plan, &pauses).expect("no deadlock");
    accepted(&problem, &late);
    let arrival = late.robots[0].knots.last().expect("it moves").t;
    assert_eq!(arrival, plan.robots[0].knots.last().expect("it moves").t + 5.0);
    // The plan had a spare 0.1 s between the arrival and the start.
    let attach = late.events.iter().find(|e| e.robot == "g2" && e.kind == EventKind::Attach).expect("it grasps");
    assert!((attach.t - (plan.events[2].t + 4.9)).abs() < 1e-9, "{}", attach.t);
    let arc = &late.dependencies[0];
    assert!(late.robots[1].knots[arc.after.knot].t >= late.robots[0].knots[arc.before.knot].t);
}

#[test]
fn delays_that_respect_the_arcs_are_safe_and_delays_that_do_not_are_found() {
    let mut caught = 0;
    for seed in 0..200 {
        let (problem, plan) = relay();
        let mut random = Random(seed);
        let mut pauses = no_pauses(&plan);
        for pause in pauses.iter_mut().flatten() {
            *pause = (random.between(-8.0, 4.0)).max(0.0);
        }
        let late = delayed_execution(&plan, &pauses).expect("no deadlock");
        if let Err(wrong) = check_plan(&problem, &late) {
            panic!("seed {seed}: {}", wrong[0]);
        }
        let mut free = plan.clone();
        free.dependencies.clear();
        let late = delayed_execution(&free, &pauses).expect("no arcs");
        let found = rules(&problem, &late);
        let meant = [Rule::V5, Rule::V6, Rule::V8, Rule::V9, Rule::V11, Rule::V12];
        assert!(found.iter().all(|rule| meant.contains(rule)), "seed {seed}: {found:?}");
        caught += usize::from(!found.is_empty());
    }
    assert!((20..180).contains(&caught), "{caught} of 200 unsafe executions");
}

#[test]
fn arcs_that_wait_for_one_another_are_a_deadlock() {
    let (_, plan) = side_by_side();
    for (first, second) in
        [(arc(("g1", 5), ("g2", 3)), arc(("g2", 5), ("g1", 3))), (arc(("g1", 4), ("g2", 3)), arc(("g2", 4), ("g1", 3)))]
    {
        let mut stuck = plan.clone();
        stuck.dependencies = vec![first.clone(), second];
        let violation = delayed_execution(&stuck, &no_pauses(&stuck)).expect_err("a ring");
        assert_eq!(violation.rule, Rule::V17);
        assert_eq!(violation.robots, ["g1", "g2"]);
        assert!(violation.message.contains("knot 3 of g1 or knot 3 of g2"), "{violation}");
        stuck.dependencies = vec![first];
        delayed_execution(&stuck, &no_pauses(&stuck)).expect("one arc alone is no ring");
    }
    // Crossing arcs at the same knots are none: each robot may leave once the other has arrived.
    let mut crossing = plan.clone();
    crossing.dependencies = vec![arc(("g1", 3), ("g2", 3)), arc(("g2", 3), ("g1", 3))];
    assert_eq!(delayed_execution(&crossing, &no_pauses(&plan)).expect("no ring"), crossing);
}

#[test]
fn arcs_to_nowhere_are_refused() {
    let (_, plan) = side_by_side();
    for wrong in
        [arc(("g1", 99), ("g2", 0)), arc(("g1", 0), ("g2", 99)), arc(("g7", 0), ("g2", 0)), arc(("g1", 0), ("g1", 2))]
    {
        let mut broken = plan.clone();
        broken.dependencies = vec![wrong];
        assert_eq!(delayed_execution(&broken, &[]).expect_err("no such knot").rule, Rule::V17);
    }
}
