//! Rules V2 (objects), V6 and V7: what is true at an attach and after a detach.

use glamx::DVec3;
use model::{Pair, Region};

use crate::frame::Frame;
use crate::mechanism::Posture;
use crate::script::{Script, Step};
use crate::solid::Solid;
use crate::timeline::{Standing, Timeline};
use crate::violation::{Rule, Violation};

/// How far hand and object may be from where they should (m).
pub(crate) const ATTACH_DISTANCE: f64 = 1e-3;
/// How far they may be turned (rad).
pub(crate) const ATTACH_ANGLE: f64 = 0.2 * std::f64::consts::PI / 180.0;
/// Tolerance where numbers should be copies of one another (m, rad).
const COPY: f64 = 1e-9;
/// How far a standing object's z axis may lean (rad).
pub(crate) const UPRIGHT: f64 = 1e-6;

pub(crate) fn check(script: &Script, timeline: &Timeline, wrong: &mut Vec<Violation>) {
    for hold in &timeline.holds {
        let attach = &script.steps[hold.attach];
        check_attach(script, attach, wrong);
        if let Some(detach) = hold.detach {
            check_detach(script, attach, &script.steps[detach], wrong);
        }
    }
    for standing in &timeline.standings {
        check_unmoved(script, timeline, standing, wrong);
    }
}

fn deviation(script: &Script, step: &Step) -> (f64, f64) {
    let mut posture = Posture::default();
    let q = &script.tracks[step.robot.index()].knots[step.knot].q;
    script.mechanisms[step.robot.index()].place(q, step.opening, &mut posture);
    (posture.links[step.link.index()] * step.link_from_object).difference(&step.world_from_object)
}

fn is_far((distance, angle): (f64, f64)) -> bool {
    distance > ATTACH_DISTANCE + COPY || angle > ATTACH_ANGLE + COPY
}

fn in_words((distance, angle): (f64, f64)) -> String {
    format!("{:.3} mm and {:.3}°", distance * 1e3, angle.to_degrees())
}

fn check_attach(script: &Script, step: &Step, wrong: &mut Vec<Violation>) {
    let mut say = |message: String| wrong.push(script.about(step, Rule::V6, message));
    let off = deviation(script, step);
    if is_far(off) {
        say(format!("the hand would hold the object {} from where it stands", in_words(off)));
    }
    let movable = &script.problem.movable[step.object.index()];
    let grasps = movable.grasps.get(step.robot.index()).map_or(&[][..], Vec::as_slice);
    let listed = grasps.iter().any(|grasp| {
        let off = step.link_from_object.difference(&Frame::of(&grasp.link_from_object));
        !is_far(off) && (grasp.opening - step.opening).abs() <= COPY
    });
    if !listed {
        say(format!("link_from_object and opening are none of the {} grasps of {}", grasps.len(), movable.name));
    }
    if let Some(t) = moves_during_pause(script, step) {
        say(format!("the robot moves at {t} s, within the grip time of {} s", script.problem.settings.grip_time));
    }
}

fn check_detach(script: &Script, attach: &Step, step: &Step, wrong: &mut Vec<Violation>) {
    let mut say = |message: String| wrong.push(script.about(step, Rule::V7, message));
    if step.link_from_object != attach.link_from_object || step.opening != attach.opening {
        say("the grasp at the release is not the one at the attach".to_owned());
    }
    let off = deviation(script, step);
    if is_far(off) {
        say(format!("the object stands {} from where the hand held it", in_words(off)));
    }
    let pair = script.problem.pair(step.pair);
    for message in misplaced(script, pair, step) {
        say(message);
    }
    if let Some(t) = moves_during_pause(script, step) {
        say(format!("the robot moves at {t} s, within the grip time of {} s", script.problem.settings.grip_time));
    }
}

/// When the robot first is not where it was at the event, within the grip time after it.
fn moves_during_pause(script: &Script, step: &Step) -> Option<f64> {
    let track = &script.tracks[step.robot.index()];
    let (q, until) = (&track.knots[step.knot].q, step.t + script.problem.settings.grip_time);
    let still = |knot: &plan::Knot| knot.q.iter().zip(q).all(|(a, b)| (a - b).abs() <= COPY);
    for pair in track.knots[step.knot..].windows(2) {
        if pair[0].t >= until - COPY {
            return None;
        }
        if !still(&pair[1]) {
            return Some(pair[0].t);
        }
    }
    None
}

/// What is wrong with where an object was put.
fn misplaced(script: &Script, pair: &Pair, step: &Step) -> Vec<String> {
    let (region, settings) = (&script.problem.regions[pair.to.index()], &script.problem.settings);
    let solid = Solid::new(&script.problem.movable[pair.object.index()].body);
    let placed = step.world_from_object;
    let shape = placed * solid.owner_from_shape;
    let mut wrong = Vec::new();
    let lean = placed.rotation.z_axis.truncate().length();
    if lean > UPRIGHT || placed.rotation.z_axis.z < 0.0 {
        wrong.push(format!("the object leans by {:.4}°", lean.asin().to_degrees()));
    }
    let world_from_region = Frame::of(&region.world_from_region);
    for (axis, size, name) in edges(&world_from_region, region) {
        let (most, least) = (solid.height_along(&shape, axis), -solid.height_along(&shape, -axis));
        let (middle, free) = (axis.dot(world_from_region.origin), size / 2.0 - settings.region_margin + COPY);
        let excess = (most - middle).max(middle - least) - free;
        if excess > 0.0 {
            wrong.push(format!("the object stands {:.3} mm outside {} along {name}", excess * 1e3, region.name));
        }
    }
    let above = -solid.height_along(&shape, -DVec3::Z) - world_from_region.origin.z;
    if above.abs() > settings.support_tolerance + COPY {
        wrong.push(format!("the object's bottom is {:.3} mm above the surface of {}", above * 1e3, region.name));
    }
    wrong
}

fn edges(world_from_region: &Frame, region: &Region) -> [(DVec3, f64, &'static str); 2] {
    let rotation = world_from_region.rotation;
    [(rotation.x_axis, region.size[0], "x"), (rotation.y_axis, region.size[1], "y")]
}

/// An object is attached exactly where it stands: at the problem's start pose, or where it was last put.
fn check_unmoved(script: &Script, timeline: &Timeline, standing: &Standing, wrong: &mut Vec<Violation>) {
    let Some(taker) = standing.taken_by else { return };
    let step = &script.steps[timeline.holds[taker].attach];
    let (distance, angle) = step.world_from_object.difference(&standing.world_from_object);
    let jump = format!("the object is attached {} from where it stands", in_words((distance, angle)));
    match standing.put_by.and_then(|put| timeline.holds[put].detach) {
        None if distance > COPY || angle > COPY => wrong.push(script.about(step, Rule::V2, jump)),
        Some(put) => {
            let (events, taken) = (&script.plan.events, timeline.holds[taker].attach);
            if events[put].world_from_object != events[taken].world_from_object {
                wrong.push(script.about(step, Rule::V7, jump));
            }
        }
        None => {}
    }
}
