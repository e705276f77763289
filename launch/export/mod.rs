//! Plans in other programs' formats: animated glTF, a wide CSV table, ROS 2 messages.

mod csv;
mod glb;
mod glb_buffer;
mod mesh;
mod ros2;

pub use csv::csv;
pub use glb::glb;
pub use ros2::ros2;

use crate::playback::{Playback, sorted};

/// Samples per second of what is curved between knots, where the user names no rate (Hz).
const CURVE_RATE_HZ: f64 = 30.0;

/// Times `0, 1/rate, 2/rate, ...` and the end (s).
fn grid(playback: &Playback, rate_hz: f64) -> Vec<f64> {
    let end = playback.duration_s();
    let steps = (end * rate_hz).floor() as u32;
    let mut times: Vec<f64> = (0..=steps).map(|step| f64::from(step) / rate_hz).filter(|t| *t <= end).collect();
    times.push(end);
    sorted(times)
}

/// Times at which an object's pose is needed for straight lines between them to follow it: events, and while it is held
/// the holder's knots and a grid.
fn object_times(playback: &Playback, object: model::ObjectId, rate_hz: f64) -> Vec<f64> {
    let mut times = vec![0.0, playback.duration_s()];
    for pair in playback.handling(object).chunks(2) {
        let from = pair[0].event.t;
        let to = pair.get(1).map_or(playback.duration_s(), |detach| detach.event.t);
        times.extend([from, to]);
        let knots = playback.plan.robots[pair[0].robot.index()].knots.iter().map(|knot| knot.t);
        times.extend(knots.chain(grid(playback, rate_hz)).filter(|t| (from..to).contains(t)));
    }
    sorted(times)
}

#[cfg(test)]
mod tests;
