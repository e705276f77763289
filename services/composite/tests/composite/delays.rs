//! Plans whose robots are late: safe with their arcs, and unsafe without any one of them.

use plan::{Dependency, EventKind, Plan};

use crate::oracle::{Disc, overlap, robot_discs};
use crate::toys::{Dice, Errand, OBJECT, Toy, World, random_world};

/// An execution: when each robot reaches and leaves its knots (s).
pub struct Execution {
    pub reach: Vec<Vec<f64>>,
    pub leave: Vec<Vec<f64>>,
}

/// Every robot lingers at its knots, and leaves each only when the arcs let it. `None` if arcs wait for one another.
pub fn execute(plan: &Plan, arcs: &[Dependency], linger: &dyn Fn(usize, usize) -> f64) -> Option<Execution> {
    let index = |name: &str| plan.robots.iter().position(|robot| robot.name == name).unwrap();
    let mut execution =
        Execution { reach: vec![vec![0.0]; plan.robots.len()], leave: vec![Vec::new(); plan.robots.len()] };
    loop {
        let mut moved = false;
        for (r, robot) in plan.robots.iter().enumerate() {
            let knot = execution.leave[r].len();
            if knot + 1 >= robot.knots.len() {
                continue;
            }
            let own = arcs.iter().filter(|arc| index(&arc.after.robot) == r && arc.after.knot == knot);
            let waits: Option<Vec<f64>> =
                own.map(|arc| execution.reach[index(&arc.before.robot)].get(arc.before.knot).copied()).collect();
            let Some(waits) = waits else { continue };
            let leaves = waits.into_iter().fold(execution.reach[r][knot] + linger(r, knot), f64::max);
            execution.leave[r].push(leaves);
            execution.reach[r].push(leaves + robot.knots[knot + 1].t - robot.knots[knot].t);
            moved = true;
        }
        if !moved {
            let done =
                plan.robots.iter().zip(&execution.leave).all(|(robot, left)| left.len() + 1 == robot.knots.len());
            return done.then_some(execution);
        }
    }
}

impl Execution {
    fn end(&self) -> f64 {
        self.reach.iter().filter_map(|reach| reach.last()).fold(0.0, |end, t| end.max(*t))
    }

    /// Everything at time `t` (s).
    fn discs(&self, toy: &Toy, plan: &Plan, t: f64) -> Vec<Disc> {
        let mut discs = Vec::new();
        let mut standing: Vec<Option<[f64; 2]>> = toy.assignment.poses.iter().map(|hops| Some(xy(&hops[0]))).collect();
        for (r, robot) in plan.robots.iter().enumerate() {
            let knot = self.reach[r].partition_point(|reach| *reach <= t) - 1;
            let leaves = self.leave[r].get(knot).copied().unwrap_or(f64::INFINITY);
            let share = if t <= leaves { 0.0 } else { (t - leaves) / (self.reach[r][knot + 1] - leaves) };
            let to = robot.knots.get(knot + 1).map_or(&robot.knots[knot].q, |knot| &knot.q);
            let q: Vec<f64> = robot.knots[knot].q.iter().zip(to).map(|(a, b)| a + (b - a) * share).collect();
            let happened = |e: &&plan::Event| e.robot == robot.name && self.reach[r][e.knot] <= t;
            let last = plan.events.iter().rfind(happened);
            discs.extend(robot_discs(r, &q, last.is_some_and(|event| event.kind == EventKind::Attach)));
        }
        let mut events: Vec<(f64, &plan::Event)> = plan
            .events
            .iter()
            .map(|e| (self.reach[plan.robots.iter().position(|r| r.name == e.robot).unwrap()][e.knot], e))
            .filter(|(at, _)| *at <= t)
            .collect();
        events.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, event) in events {
            let object: usize = event.object[1..].parse::<usize>().unwrap() - 1;
            let stands = event.kind == EventKind::Detach;
            standing[object] = stands.then(|| [event.world_from_object.xyz[0], event.world_from_object.xyz[1]]);
        }
        let stands = |(m, centre): (usize, &Option<[f64; 2]>)| {
            centre.map(|centre| Disc { owner: ('m', m), centre, radius: OBJECT })
        };
        discs.extend(standing.iter().enumerate().filter_map(stands));
        discs
    }

    /// The first sampled time at which discs overlap.
    pub fn meeting(&self, toy: &Toy, plan: &Plan) -> Option<(f64, (Disc, Disc))> {
        let samples = (self.end() / 0.02) as usize + 1;
        (0..=samples).map(|k| k as f64 * 0.02).find_map(|t| Some((t, overlap(&self.discs(toy, plan, t))?)))
    }
}

fn xy(pose: &model::Pose) -> [f64; 2] {
    [pose.translation.vector.x, pose.translation.vector.y]
}

#[test]
fn every_delayed_execution_of_a_plan_is_safe() {
    let (mut executions, mut arcs) = (0, 0);
    for seed in 0..25 {
        let mut dice = Dice(seed * 31_337 + 5);
        let (robots, errands) = (2 + dice.below(2), 1 + dice.below(2));
        let toy = random_world(&mut dice, 8, 4, robots, errands).build();
        let (prefix, _) = toy.commit_all(|_| ());
        let Some(prefix) = prefix.filter(|prefix| toy.is_complete(Some(*prefix))) else { continue };
        let plan = toy.assemble(prefix);
        arcs += plan.dependencies.len();
        for round in 0..12 {
            let often = [0.0, 0.05, 0.3, 1.0][round % 4];
            let draws: Vec<Vec<f64>> = plan
                .robots
                .iter()
                .map(|r| r.knots.iter().map(|_| if dice.unit() < often { dice.unit() * 3.0 } else { 0.0 }).collect())
                .collect();
            let late = execute(&plan, &plan.dependencies, &|r, k| draws[r][k]).expect("arcs wait for one another");
            let meeting = late.meeting(&toy, &plan);
            assert!(meeting.is_none(), "seed {seed}, round {round}: {meeting:?}");
            executions += 1;
        }
    }
    assert!(executions > 200 && arcs > 100, "{executions} executions, {arcs} arcs");
}

/// Two robots whose ways cross, there and back.
fn crossing() -> Toy {
    let mut world = World::grid(5, 5, 0.7);
    world.ways.retain(|(a, b)| (a / 5 == 2 && b / 5 == 2) || (a % 5 == 2 && b % 5 == 2));
    world.starts = vec![10, 2];
    world.objects = vec![14, 22];
    world.errands =
        vec![Errand { robot: 0, object: 0, from: 14, to: 13 }, Errand { robot: 1, object: 1, from: 22, to: 17 }];
    world.build()
}

#[test]
fn a_crossing_is_unsafe_without_any_one_of_its_arcs() {
    let toy = crossing();
    let (prefix, failures) = toy.commit_all(|_| ());
    assert!(toy.is_complete(prefix), "{failures:?}");
    let plan = toy.assemble(prefix.unwrap());
    assert!(plan.dependencies.len() >= 2, "{:?}", plan.dependencies);
    for dropped in 0..plan.dependencies.len() {
        let mut arcs = plan.dependencies.clone();
        let arc = arcs.remove(dropped);
        let late = plan.robots.iter().position(|robot| robot.name == arc.before.robot).unwrap();
        let linger = |r: usize, knot: usize| if r == late && knot + 1 == arc.before.knot { 60.0 } else { 0.0 };
        let kept = execute(&plan, &plan.dependencies, &linger).unwrap();
        assert_eq!(kept.meeting(&toy, &plan), None, "with all arcs");
        let execution = execute(&plan, &arcs, &linger).unwrap();
        assert!(execution.meeting(&toy, &plan).is_some(), "without {arc:?} nothing happens");
    }
}

#[test]
fn an_execution_without_delay_is_the_plan() {
    let toy = crossing();
    let plan = toy.assemble(toy.commit_all(|_| ()).0.unwrap());
    let execution = execute(&plan, &plan.dependencies, &|_, _| 0.0).unwrap();
    for (r, robot) in plan.robots.iter().enumerate() {
        for (knot, reach) in robot.knots.iter().zip(&execution.reach[r]) {
            assert!((knot.t - reach).abs() < 1e-9, "{} s and {reach} s", knot.t);
        }
    }
}

#[test]
fn no_arc_of_a_plan_follows_from_the_others() {
    let mut arcs = 0;
    for seed in 0..12 {
        let mut dice = Dice(seed * 4099 + 21);
        let toy = random_world(&mut dice, 8, 4, 3, 1).build();
        let (prefix, _) = toy.commit_all(|_| ());
        let Some(prefix) = prefix.filter(|prefix| toy.is_complete(Some(*prefix))) else { continue };
        let plan = toy.assemble(prefix);
        for arc in &plan.dependencies {
            assert!(!follows(&plan, arc), "seed {seed}: {arc:?}");
            arcs += 1;
        }
    }
    assert!(arcs > 60, "{arcs} arcs");
}

/// Whether leaving `arc.after` comes after reaching `arc.before` by the other arcs alone.
fn follows(plan: &Plan, arc: &Dependency) -> bool {
    let mut reached: Vec<(String, usize)> = vec![(arc.before.robot.clone(), arc.before.knot)];
    let mut next = 0;
    while let Some((robot, knot)) = reached.get(next).cloned() {
        next += 1;
        if robot == arc.after.robot && knot <= arc.after.knot {
            return true;
        }
        // Whoever may leave a knot only now reaches the one after it only then.
        let later = plan
            .dependencies
            .iter()
            .filter(|other| *other != arc && other.before.robot == robot && other.before.knot >= knot);
        for other in later.map(|other| (other.after.robot.clone(), other.after.knot + 1)) {
            if !reached.contains(&other) {
                reached.push(other);
            }
        }
    }
    false
}
