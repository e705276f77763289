//! A configuration to start from: free of self-collision, near the robot's axis, above its foot.

use collision::{Geometry, GeometryError};
use kinematics::link_poses;
use model::{Coordinate, LinkId, Robot, RobotId};
use nalgebra::Vector3;

use super::survey::{configurations, lone};

/// Random configurations to start from.
const CANDIDATES: usize = 1_000;
/// Most rounds of changing one joint at a time.
const ROUNDS: usize = 10;
/// Distance (m) that the robot's links keep from each other there.
const CLEARANCE: f64 = 0.005;
/// Joints stand at multiples of this angle (rad): easy to read and to change.
const STEP: f64 = std::f64::consts::FRAC_PI_4;

/// The arm's coordinates of the most folded configuration found, every joint at a multiple of 45°; `None` where all that
/// were looked at touch themselves. `untested` are pairs of links that may touch. `tool` is the link whose z axis should point down.
///
/// # Errors
/// When a shape is degenerate.
pub fn folded(
    robot: &Robot,
    untested: Vec<(LinkId, LinkId)>,
    tool: Option<LinkId>,
) -> Result<Option<Vec<f64>>, GeometryError> {
    let geometry = Geometry::new(&lone(robot, untested, CLEARANCE))?;
    let mut best: Option<(f64, Vec<f64>)> = None;
    let look_at = |q: Vec<f64>, best: &mut Option<(f64, Vec<f64>)>| {
        let spread = spread(robot, &q, tool);
        if best.as_ref().is_none_or(|(least, _)| spread < *least) && geometry.own_contacts(RobotId(0), &q).is_empty() {
            *best = Some((spread, q));
        }
    };
    for q in configurations(robot, "folded").take(CANDIDATES) {
        look_at(q.iter().zip(&robot.coordinates).map(|(x, c)| on_grid(*x, c)).collect(), &mut best);
    }
    for _ in 0..ROUNDS {
        let before = best.clone();
        for (i, coordinate) in robot.coordinates.iter().enumerate().skip(robot.base_len()) {
            for multiple in -4..=4 {
                let Some((_, mut q)) = best.clone() else { return Ok(None) };
                q[i] = on_grid(f64::from(multiple) * STEP, coordinate);
                look_at(q, &mut best);
            }
        }
        if best == before {
            break;
        }
    }
    Ok(best.map(|(_, q)| q[robot.base_len()..].to_vec()))
}

/// The multiple of 45° next to a value taken into half a turn about 0, within the limits.
fn on_grid(value: f64, coordinate: &Coordinate) -> f64 {
    let half_turn = std::f64::consts::PI;
    let range = (coordinate.upper - coordinate.lower).min(2.0 * half_turn);
    if range < 2.0 * STEP {
        return 0.0_f64.clamp(coordinate.lower, coordinate.upper);
    }
    let within = value.clamp(coordinate.lower.max(-half_turn), coordinate.upper.min(half_turn));
    let multiple = STEP * (within / STEP).round();
    let inwards = if multiple > coordinate.upper {
        -STEP
    } else if multiple < coordinate.lower {
        STEP
    } else {
        0.0
    };
    multiple + inwards
}

/// Greatest distance of a body from the root's axis (m), with a malus for what is below the root, for a tool that does not
/// point down and for joints far from 0.
fn spread(robot: &Robot, q: &[f64], tool: Option<LinkId>) -> f64 {
    let poses = link_poses(robot, q, robot.end_effector.max_opening);
    let (mut farthest, mut lowest) = (0.0_f64, 0.0_f64);
    for (link, pose) in robot.links.iter().zip(&poses) {
        for body in &link.bodies {
            for point in body.shape.support_points() {
                let point = pose * (body.owner_from_shape * point);
                farthest = farthest.max(point.x.hypot(point.y) + body.shape.rounding());
                lowest = lowest.min(point.z - body.shape.rounding());
            }
        }
    }
    let upwards = tool.map_or(0.0, |tool| 1.0 + (poses[tool.index()].rotation * Vector3::z()).z);
    let bent: f64 = q.iter().map(|x| x.abs()).sum();
    farthest - 2.0 * lowest + 0.3 * upwards + 0.02 * bent
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joints_stand_at_multiples_of_45_degrees_within_their_limits() {
        let joint = |lower, upper| Coordinate { name: "j".into(), lower, upper, velocity: 1.0 };
        for i in 0..200 {
            let value = -7.0 + 0.07 * f64::from(i);
            for limits in
                [joint(-6.3, 6.3), joint(-3.0, -0.1), joint(f64::NEG_INFINITY, f64::INFINITY), joint(-0.1, 2.0)]
            {
                let on_grid = on_grid(value.clamp(limits.lower, limits.upper), &limits);
                let steps = on_grid / STEP;
                assert!((steps - steps.round()).abs() < 1e-9 && on_grid.abs() < 3.2, "{value} {limits:?} {on_grid}");
                assert!((limits.lower..=limits.upper).contains(&on_grid), "{value} {limits:?} {on_grid}");
            }
        }
        assert_eq!(on_grid(0.3, &joint(0.1, 0.4)), 0.1, "a short slide stands at its end");
    }
}
