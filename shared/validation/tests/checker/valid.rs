//! Hand-made valid plans are accepted.

use model::EndPolicy;
use plan::SegmentKind;
use validation::{Rule, delayed_execution};

use crate::fixture::{Writer, accepted, finish, problem, rules};
use crate::robots::{gantry, rover};
use crate::scenarios::{relay, rover_round_wall, side_by_side, single};

#[test]
fn one_gantry_picks_and_places() {
    let (problem, plan) = single();
    let verdict = accepted(&problem, &plan);
    assert_eq!(verdict.floor_hits, 0);
    assert!(verdict.intervals > 10 && verdict.pairs_tested > 10 && verdict.distances > 0, "{verdict:?}");
}

#[test]
fn two_gantries_hand_an_object_on() {
    let (problem, plan) = relay();
    accepted(&problem, &plan);
}

#[test]
fn two_gantries_work_side_by_side() {
    let (problem, plan) = side_by_side();
    accepted(&problem, &plan);
}

#[test]
fn events_with_no_number_between_their_times_are_told_apart() {
    for next in [f64::next_up, f64::next_down] {
        let (problem, mut plan) = side_by_side();
        let (theirs, knot) = (plan.events[0].t, plan.events[1].knot);
        assert_eq!(plan.events[1].t.to_bits(), theirs.to_bits(), "the scene has changed");
        let late = plan.events[1].robot.clone();
        let robot = plan.robots.iter_mut().find(|robot| robot.name == late).unwrap();
        robot.knots[knot].t = next(theirs);
        plan.events[1].t = next(theirs);
        plan.events.sort_by(|a, b| a.t.total_cmp(&b.t));
        accepted(&problem, &plan);
    }
}

#[test]
fn a_rover_returns_or_stays() {
    for policy in [EndPolicy::Return, EndPolicy::Stay] {
        let (problem, plan) = rover_round_wall(policy);
        accepted(&problem, &plan);
        let (mut other, _) = rover_round_wall(policy);
        other.end_policies[0] = if policy == EndPolicy::Stay { EndPolicy::Return } else { EndPolicy::Stay };
        assert_eq!(rules(&other, &plan), [Rule::V13]);
    }
}

#[test]
fn robots_without_work_may_stand_or_move_and_come_back() {
    let problem = problem(vec![gantry("g1", [0.0, 0.0, 0.5]), rover("r1", [1.0, 1.0, 0.0])]);
    let (standing, mut moving) = (Writer::new(&problem, 0), Writer::new(&problem, 1));
    moving.go(SegmentKind::Base, &[2.0, 1.0, 1.0, 0.8, 0.0]).go(SegmentKind::Base, &problem.robots[1].start);
    let plan = finish(&problem, vec![standing, moving]);
    accepted(&problem, &plan);
}

#[test]
fn rests_anywhere_change_nothing_where_robots_are_far_apart() {
    let (problem, plan) = side_by_side();
    let pauses: Vec<Vec<f64>> = plan
        .robots
        .iter()
        .enumerate()
        .map(|(r, robot)| (0..robot.knots.len()).map(|k| ((r + k) % 3) as f64).collect())
        .collect();
    let delayed = delayed_execution(&plan, &pauses).expect("no arcs");
    assert!(delayed.makespan.total_s > plan.makespan.total_s + 5.0);
    accepted(&problem, &delayed);
}

#[test]
fn an_object_may_touch_what_it_stands_on_by_up_to_the_tolerance() {
    for (rise, fits) in [(-0.0009, true), (0.0009, true), (-0.0011, false), (0.0011, false)] {
        let (problem, mut plan) = single();
        plan.events[1].world_from_object.xyz[2] += rise;
        assert_eq!(plan.events[1].world_from_object.xyz[2] - 0.46 > 0.0, rise > 0.0);
        let found = rules(&problem, &plan);
        assert_eq!(found.is_empty(), fits, "{rise}: {found:?}");
        assert!(fits || found.contains(&Rule::V7), "{rise}: {found:?}");
    }
}
