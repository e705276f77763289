//! Synchronous schedules of discs: rounds by hand, free of contact, and kept in every execution.

use contract::{Answer, Composition, FailureReport, Interrupted, Outcome, Product, ProductRef, RoundChoice};
use model::{GivenOrdering, Point};
use plan::{Cause, Plan};
use skeleton::ModeId;

use crate::delays::{Execution, execute};
use crate::oracle::assert_free;
use crate::toys::{Dice, Errand, Toy, World, mode, pair, random_world};

/// A schedule: all commitments, the rounds, and when the last is over (s).
type Schedule = (ProductRef, Vec<Vec<ModeId>>, f64);

fn ask(toy: &Toy, choice: RoundChoice) -> Result<Outcome, Interrupted> {
    let roadmap = |mode: &skeleton::Mode| toy.put(&Product::Mode(toy.roadmap(mode.id)));
    let roadmaps = toy.skeleton().modes.iter().map(|modes| modes.iter().map(roadmap).collect()).collect();
    toy.ask(&toy.job(Composition::Synchronous { choice, roadmaps }))
}

fn schedule(toy: &Toy, choice: RoundChoice) -> Result<Schedule, FailureReport> {
    ask(toy, choice).unwrap().result.map(|answer| match answer {
        Answer::Rounds { prefix, rounds, ends_s } => (prefix, rounds, ends_s),
        other => panic!("{other:?}"),
    })
}

/// Two robots ten metres apart, in a row of six points each. The first picks near and places far, the second the other
/// way round.
fn two_rows() -> World {
    let mut world = World::grid(6, 1, 0.7);
    let second: Vec<[f64; 2]> = world.points.iter().map(|[x, y]| [*x, y + 10.0]).collect();
    world.points.extend(second);
    world.ways.extend((6..11).map(|v| (v, v + 1)));
    (world.starts, world.objects) = (vec![0, 6], vec![1, 10]);
    world.errands =
        vec![Errand { robot: 0, object: 0, from: 1, to: 5 }, Errand { robot: 1, object: 1, from: 10, to: 11 }];
    world
}

#[test]
fn rounds_of_robots_far_apart_are_as_long_as_computed_by_hand() {
    // Units in steps of 0.7 s: 1, 4, 5 and 4, 1, 5. All at once in each round: 4 + 4 + 5. The two fours together and the
    // ones alone: 1 + 4 + 1 + 5.
    let toy = two_rows().build();
    let (prefix, rounds, ends_s) = schedule(&toy, RoundChoice::Greedy).unwrap();
    assert_eq!(rounds, [0, 1, 2].map(|step| [mode(0, step), mode(1, step)]));
    assert!((ends_s - 13.0 * 0.7).abs() < 1e-9, "{ends_s} s");
    assert!((toy.assemble_rounds(prefix, rounds).makespan.total_s - ends_s).abs() < 1e-9);
    let (prefix, rounds, ends_s) = schedule(&toy, RoundChoice::Optimal).unwrap();
    let expected = [vec![mode(0, 0)], vec![mode(0, 1), mode(1, 0)], vec![mode(1, 1)], vec![mode(0, 2), mode(1, 2)]];
    assert_eq!(rounds, expected);
    assert!((ends_s - 11.0 * 0.7).abs() < 1e-9, "{ends_s} s");
    assert!((toy.assemble_rounds(prefix, rounds).makespan.total_s - ends_s).abs() < 1e-9);
    // The same motion without rounds: nobody waits for anybody.
    assert!((toy.assemble(prefix).makespan.total_s - 10.0 * 0.7).abs() < 1e-9);
}

#[test]
fn a_hands_pause_belongs_to_the_round_of_its_event() {
    let mut world = two_rows();
    world.grip_time = 0.5;
    let toy = world.build();
    let (prefix, rounds, ends_s) = schedule(&toy, RoundChoice::Optimal).unwrap();
    // A pause in each round but the last.
    assert!((ends_s - (11.0 * 0.7 + 3.0 * 0.5)).abs() < 1e-9, "{ends_s} s");
    assert!((toy.assemble_rounds(prefix, rounds).makespan.total_s - ends_s).abs() < 1e-9);
}

#[test]
fn rounds_follow_one_another_to_the_last_bit() {
    for seed in 0..60 {
        let mut dice = Dice(seed * 8_191 + 29);
        let mut world = two_rows();
        let mut x = 0.0;
        for v in 0..12 {
            x = if v == 6 { 0.0 } else { x + 0.7 + dice.unit() };
            world.points[v][0] = x;
        }
        world.grip_time = dice.unit();
        let toy = world.build();
        let (prefix, rounds, ends_s) = schedule(&toy, RoundChoice::Greedy).unwrap();
        let plan = toy.assemble_rounds(prefix, rounds);
        assert!((plan.makespan.total_s - ends_s).abs() < 1e-9, "seed {seed}");
    }
}

#[test]
fn an_ordering_puts_its_events_in_different_rounds() {
    let ordered = |before: (usize, Point), after: (usize, Point)| {
        let mut world = two_rows();
        world.orderings = vec![GivenOrdering { before: (pair(before.0), before.1), after: (pair(after.0), after.1) }];
        schedule(&world.build(), RoundChoice::Greedy).unwrap().1
    };
    let (first, second) = ([0, 1, 2].map(|step| mode(0, step)), [0, 1, 2].map(|step| mode(1, step)));
    let rounds = ordered((0, Point::Release), (1, Point::Grasp));
    let expected = [vec![first[0]], vec![first[1]], vec![first[2], second[0]], vec![second[1]], vec![second[2]]];
    assert_eq!(rounds, expected);
    // Hands without arms are folded at once, so that `carry` and `done` are where the mode before ends.
    let rounds = ordered((0, Point::Carry), (1, Point::Release));
    assert_eq!(rounds, [0, 1, 2].map(|step| vec![first[step], second[step]]));
    let rounds = ordered((0, Point::Done), (1, Point::Release));
    assert_eq!(rounds[..3], [vec![first[0], second[0]], vec![first[1]], vec![first[2], second[1]]]);
}

/// Departure of the first unit of each round that moves, and end of the last, in an execution of a plan.
fn assert_rounds_are_kept(toy: &Toy, plan: &Plan, rounds: &[Vec<ModeId>], execution: &Execution, context: &str) {
    let pause_s = toy.problem().settings.grip_time;
    let units = |round: &Vec<ModeId>| -> Vec<(f64, f64)> {
        let of_mode = |mode: &ModeId| {
            let (robot, step) = (mode.robot.index(), mode.step as usize);
            let knots = &plan.robots[robot].knots;
            let events: Vec<usize> =
                plan.events.iter().filter(|e| e.robot == plan.robots[robot].name).map(|e| e.knot).collect();
            let begin = step.checked_sub(1).map_or(0, |before| events[before]);
            let end = events.get(step).copied().unwrap_or(knots.len() - 1);
            let departs = (begin..end).find(|k| knots[*k].q != knots[k + 1].q)?;
            let pause_s = if events.len() > step { pause_s } else { 0.0 };
            Some((execution.leave[robot][departs], execution.reach[robot][end] + pause_s))
        };
        round.iter().filter_map(of_mode).collect()
    };
    let units: Vec<Vec<(f64, f64)>> = rounds.iter().map(units).filter(|units| !units.is_empty()).collect();
    for pair in units.windows(2) {
        let ends_s = pair[0].iter().fold(0.0, |latest: f64, unit| latest.max(unit.1));
        let departs_s = pair[1].iter().fold(f64::INFINITY, |first: f64, unit| first.min(unit.0));
        assert!(departs_s >= ends_s - 1e-9, "{context}: {departs_s} s before {ends_s} s");
    }
}

#[test]
fn random_worlds_are_scheduled_without_contact_and_every_execution_keeps_the_rounds() {
    let (mut solved, mut shorter, mut executions) = (0, 0, 0);
    for seed in 0..20 {
        let mut dice = Dice(seed * 6_151 + 17);
        let (robots, errands) = [(2, 2), (3, 1), (3, 2), (4, 1)][seed as usize % 4];
        let toy = random_world(&mut dice, 8, 4, robots, errands).build();
        let found = [RoundChoice::Greedy, RoundChoice::Optimal].map(|choice| schedule(&toy, choice));
        if let [Ok((.., greedy_s)), Ok((.., best_s))] = &found {
            assert!(*best_s <= greedy_s + 1e-6, "seed {seed}: {best_s} s, greedy {greedy_s} s");
            shorter += usize::from(*best_s < greedy_s - 0.01);
        }
        assert!(found[0].is_err() || found[1].is_ok(), "seed {seed}: only greedy finds a schedule");
        for (choice, found) in found.into_iter().enumerate() {
            let Ok((prefix, rounds, ends_s)) = found else { continue };
            let context = format!("seed {seed}, choice {choice}");
            assert_free(&toy, &toy.commitments(prefix), &context);
            let plan = toy.assemble_rounds(prefix, rounds.clone());
            assert!(plan.makespan.total_s <= ends_s + 1e-6, "{context}");
            for often in [0.0, 0.1, 0.5] {
                let mut late_s = |_| if dice.unit() < often { dice.unit() * 3.0 } else { 0.0 };
                let draws: Vec<Vec<f64>> =
                    plan.robots.iter().map(|r| r.knots.iter().map(&mut late_s).collect()).collect();
                let execution = execute(&plan, &plan.dependencies, &|r, k| draws[r][k]).expect("arcs in a circle");
                assert_rounds_are_kept(&toy, &plan, &rounds, &execution, &context);
                let meeting = execution.meeting(&toy, &plan);
                assert!(meeting.is_none(), "{context}: {meeting:?}");
                executions += 1;
            }
            solved += 1;
        }
    }
    println!("{solved} schedules, optimal shorter in {shorter}, {executions} executions");
    assert!(solved >= 30 && shorter >= 3, "{solved} schedules, optimal shorter in {shorter}");
}

/// A lane with a spur at either end, where each disc starts and picks and where the other one's object goes, and a bay in the
/// middle, if there is one.
fn lane(with_bay: bool) -> World {
    let mut world = World::grid(5, 1, 0.7);
    world.points.extend([[0.0, -0.8], [2.8, -0.8], [1.4, 0.8]]);
    world.ways.extend([(0, 5), (4, 6)]);
    world.ways.extend(with_bay.then_some((2, 7)));
    (world.starts, world.objects) = (vec![5, 6], vec![5, 6]);
    world.errands =
        vec![Errand { robot: 0, object: 0, from: 5, to: 6 }, Errand { robot: 1, object: 1, from: 6, to: 5 }];
    world
}

#[test]
fn within_a_round_one_makes_room_in_a_bay_where_nobody_can_go_first() {
    for choice in [RoundChoice::Greedy, RoundChoice::Optimal] {
        assert!(schedule(&lane(false).build(), choice).is_err(), "they pass one another in the lane");
        let toy = lane(true).build();
        let (prefix, rounds, ends_s) = schedule(&toy, choice).unwrap();
        for step in [1, 2] {
            assert!(rounds.contains(&vec![mode(0, step), mode(1, step)]), "{rounds:?}");
        }
        let commitments = toy.commitments(prefix);
        assert_free(&toy, &commitments, "a lane with a bay");
        let in_the_bay = |commitment: &&contract::Commitment| commitment.moves.iter().any(|step| step.to[1] == 0.8);
        assert_eq!(commitments.iter().filter(in_the_bay).count(), 2, "one in each of two rounds");
        // To the bay and on, as long as the other one needs to pass: less than one after the other.
        let one_by_one_s = 4.0 * (0.8 + 2.8 + 0.8);
        assert!(ends_s < one_by_one_s, "{ends_s} s");
        assert!((toy.assemble_rounds(prefix, rounds).makespan.total_s - ends_s).abs() < 1e-6);
    }
}

#[test]
fn discs_that_must_pass_one_another_in_a_corridor_have_no_rounds_and_are_named() {
    let mut world = World::grid(9, 1, 0.7);
    world.points.push([0.0, -0.8]);
    world.ways.push((0, 9));
    world.starts = vec![1, 7];
    world.objects = vec![8, 9];
    world.errands =
        vec![Errand { robot: 0, object: 0, from: 8, to: 8 }, Errand { robot: 1, object: 1, from: 9, to: 9 }];
    let toy = world.build();
    for choice in [RoundChoice::Greedy, RoundChoice::Optimal] {
        let report = schedule(&toy, choice).unwrap_err();
        assert_eq!(report.causes[0].0, Cause::Deadlock { robots: vec!["r1".into(), "r2".into()] }, "{report:?}");
    }
}

#[test]
fn orderings_that_no_rounds_can_keep_name_all_robots() {
    let mut world = two_rows();
    let ordering = |before: (usize, Point), after: (usize, Point)| GivenOrdering {
        before: (pair(before.0), before.1),
        after: (pair(after.0), after.1),
    };
    // Possible at one's own pace: each comes to its stand before the other grasps.
    world.orderings =
        vec![ordering((0, Point::AtPick), (1, Point::Grasp)), ordering((1, Point::AtPick), (0, Point::Grasp))];
    world.arms = true;
    let report = schedule(&world.build(), RoundChoice::Optimal).unwrap_err();
    assert_eq!(report.causes, [(Cause::Deadlock { robots: vec!["r1".into(), "r2".into()] }, 1)]);
}

#[test]
fn roadmaps_or_rounds_that_are_not_all_modes_are_refused() {
    let toy = two_rows().build();
    let unfit = |composition: Composition| {
        let answer = toy.ask(&toy.job(composition));
        assert!(matches!(answer, Err(Interrupted::Unfit(_))), "{answer:?}");
    };
    unfit(Composition::Synchronous { choice: RoundChoice::Greedy, roadmaps: vec![] });
    let wrong = toy.put(&Product::Mode(toy.roadmap(mode(0, 0))));
    unfit(Composition::Synchronous { choice: RoundChoice::Greedy, roadmaps: vec![vec![wrong; 3]; 2] });
    let (prefix, rounds, _) = schedule(&toy, RoundChoice::Greedy).unwrap();
    let shortest_s = vec![vec![0.0; 3]; 2];
    let with = |rounds: Vec<Vec<ModeId>>| Composition::Assemble { prefix, shortest_s: shortest_s.clone(), rounds };
    unfit(with(rounds[..2].to_vec()));
    unfit(with(rounds.iter().rev().cloned().collect()));
    unfit(with(vec![rounds.concat()]));
    unfit(with([rounds.clone(), vec![vec![mode(7, 0)]]].concat()));
    // Rounds that are not those of the motion.
    let apart = [rounds[0].clone(), rounds[1][..1].to_vec(), rounds[2][..1].to_vec(), rounds[1][1..].to_vec()];
    unfit(with([apart.to_vec(), vec![rounds[2][1..].to_vec()]].concat()));
}

#[test]
fn equal_jobs_have_equal_schedules_and_a_small_budget_is_a_cause() {
    let toy = || random_world(&mut Dice(7), 7, 5, 3, 1).build();
    let outcomes = [(); 2].map(|()| ask(&toy(), RoundChoice::Optimal).unwrap());
    assert_eq!(outcomes[0], outcomes[1]);
    let toy = two_rows().build();
    let roadmap = |mode: &skeleton::Mode| toy.put(&Product::Mode(toy.roadmap(mode.id)));
    let roadmaps = toy.skeleton().modes.iter().map(|modes| modes.iter().map(roadmap).collect()).collect();
    let mut job = toy.job(Composition::Synchronous { choice: RoundChoice::Optimal, roadmaps });
    job.budget = 3;
    let causes = toy.ask(&job).unwrap().result.unwrap_err().causes;
    assert_eq!(causes, [(Cause::Budget { stage: "composite".into() }, 1)]);
}
