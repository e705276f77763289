//! What must be so in a plan beyond the checker's rules: planted by a scene's geometry, read from the plan alone.

use plan::{EventKind, Origin, Plan};

/// A fact about a plan; a sentence if it is not so.
pub type Fact = fn(&Plan) -> Result<(), String>;

/// Discovered orderings as `point pair < point pair`, sorted.
pub fn discovered(plan: &Plan) -> Vec<String> {
    let of_origin = plan.orderings.iter().filter(|ordering| ordering.origin == Origin::Discovered);
    let mut all: Vec<String> = of_origin
        .map(|o| format!("{} {} < {} {}", o.before.point.name(), o.before.pair, o.after.point.name(), o.after.pair))
        .collect();
    all.sort();
    all
}

/// Time of an event (s).
pub fn time_of(plan: &Plan, pair: &str, kind: EventKind) -> f64 {
    plan.events.iter().find(|event| event.pair == pair && event.kind == kind).map_or(f64::NAN, |event| event.t)
}

/// Value of a robot's coordinate at a time (s).
pub fn coordinate(plan: &Plan, robot: &str, name: &str, t: f64) -> f64 {
    let Some(robot) = plan.robots.iter().find(|known| known.name == robot) else { return f64::NAN };
    let Some(i) = robot.joints.iter().position(|joint| joint == name) else { return f64::NAN };
    let after = robot.knots.partition_point(|knot| knot.t < t);
    match (after.checked_sub(1).map(|k| &robot.knots[k]), robot.knots.get(after)) {
        (Some(a), Some(b)) => a.q[i] + (b.q[i] - a.q[i]) * (t - a.t) / (b.t - a.t),
        (Some(only), None) | (None, Some(only)) => only.q[i],
        (None, None) => f64::NAN,
    }
}

/// Values of a robot's coordinate at all its knots, with their times.
fn values(plan: &Plan, robot: &str, name: &str) -> Vec<(f64, f64)> {
    let robot = plan.robots.iter().find(|known| known.name == robot);
    robot.map_or(Vec::new(), |known| {
        known.knots.iter().map(|knot| (knot.t, coordinate(plan, &known.name, name, knot.t))).collect()
    })
}

fn holds(so: bool, sentence: &str) -> Result<(), String> {
    if so { Ok(()) } else { Err(sentence.to_owned()) }
}

/// T08: the left box stands beside the middle, the right one in it.
pub fn one_off_and_one_in_the_middle(plan: &Plan) -> Result<(), String> {
    let off = |object: &str, [x, y]: [f64; 2]| {
        let placed = plan.events.iter().rfind(|e| e.object == object && e.kind == EventKind::Detach);
        placed.map_or(f64::NAN, |e| (e.world_from_object.xyz[0] - x).hypot(e.world_from_object.xyz[1] - y))
    };
    holds(off("m1", [-0.6, 0.8]) > 0.03, "m1 stands where the post is")?;
    holds(off("m2", [0.6, 0.8]) < 0.03, "m2 does not stand between the rails")
}

/// T15b: one grasp out of the rack, another into the crate.
pub fn regrasped(plan: &Plan) -> Result<(), String> {
    let grasp = |pair: &str| {
        let attach = plan.events.iter().find(|e| e.pair == pair && e.kind == EventKind::Attach);
        attach.map(|e| e.link_from_object.quat_xyzw)
    };
    let apart = |a: [f64; 4], b: [f64; 4]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>().abs() < 0.99;
    holds(grasp("r1.1").zip(grasp("r1.2")).is_some_and(|(a, b)| apart(a, b)), "both pairs have one grasp")
}

/// T18: r1 passes the door only after the crate has been taken from it.
pub fn waits_for_the_crate(plan: &Plan) -> Result<(), String> {
    let (parked, taken) = (time_of(plan, "r2.1", EventKind::Detach), time_of(plan, "r2.2", EventKind::Attach));
    let in_the_door = |(t, x): &(f64, f64)| x.abs() < 0.04 && *t > parked && *t < taken;
    holds(!values(plan, "r1", "base/x").iter().any(in_the_door), "r1 is in the door beside the crate")?;
    holds(coordinate(plan, "r1", "base/x", parked) < 0.0, "r1 has passed the door before the crate came")
}

/// T19: somebody was in the bay.
pub fn the_bay_is_used(plan: &Plan) -> Result<(), String> {
    let deepest = |robot: &str| values(plan, robot, "base/y").iter().fold(f64::MIN, |most, (_, y)| most.max(*y));
    holds(deepest("r1").max(deepest("r2")) > 0.3, "nobody made room in the bay")
}

/// T20: r1 is out of the lane before r2 takes the box, and comes out backwards: the lane is too narrow to do otherwise.
pub fn comes_out_before_the_other_goes_in(plan: &Plan) -> Result<(), String> {
    let taken = time_of(plan, "r2.1", EventKind::Attach);
    holds(coordinate(plan, "r1", "base/y", taken) < 0.0, "r1 is in the lane when r2 takes the box")?;
    let released = time_of(plan, "r1.1", EventKind::Detach);
    holds(coordinate(plan, "r1", "base/y", released) > 0.5, "r1 reached the shelf from outside of the lane")
}

/// T21: the near door is not passed while the crate stands in it.
pub fn the_near_door_is_passed_only_without_the_crate(plan: &Plan) -> Result<(), String> {
    let taken = time_of(plan, "r2.1", EventKind::Attach);
    let track = values(plan, "r1", "base/x");
    let crossings = track.windows(2).filter(|two| two[0].1.signum() != two[1].1.signum());
    for two in crossings {
        let share = two[0].1 / (two[0].1 - two[1].1);
        let t = two[0].0 + (two[1].0 - two[0].0) * share;
        let y = coordinate(plan, "r1", "base/y", t);
        holds(t > taken || y > 1.2, "r1 passes the near door beside the crate")?;
    }
    holds(!track.is_empty(), "r1 does not move")
}

/// T25: r1's base stands still after its last release.
pub fn stays_for_good(plan: &Plan) -> Result<(), String> {
    let released = time_of(plan, "r1.1", EventKind::Detach);
    let moves = ["base/x", "base/y", "base/yaw"].into_iter().any(|name| {
        let stand = coordinate(plan, "r1", name, released);
        values(plan, "r1", name).iter().any(|(t, value)| *t > released && (value - stand).abs() > 1e-6)
    });
    holds(!moves, "r1 moves on after its last release")
}

/// T26: r2 makes room in the door, and is at home again in the end.
pub fn makes_room_and_comes_home(plan: &Plan) -> Result<(), String> {
    let x = values(plan, "r2", "base/x");
    holds(x.iter().any(|(_, x)| x.abs() > 0.5), "r2 stays in the door")?;
    holds(x.last().is_some_and(|(_, x)| x.abs() < 1e-6), "r2 is not at home in the end")
}
