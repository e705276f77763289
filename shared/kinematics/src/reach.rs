//! How far a hand can get from its shoulder, from the lengths and limits of the chain.

use model::{Pose, Robot};
use nalgebra::{Point3, Vector3};
use std::f64::consts::{PI, TAU};

use crate::line::{Line, angle_about};
use crate::range::Range;
use crate::serial::SerialChain;

/// Slack (m) for rounding.
const SLACK: f64 = 1e-6;

/// Bounds on the distance between shoulder and end effector: outside them no configuration is, inside them one may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// The shoulder in the root frame: a point on the first arm joint's axis, where the next axes meet it if they do (m).
    pub root_from_shoulder: Point3<f64>,
    /// Least distance (m) of the end effector's parent link's origin from the shoulder.
    pub least: f64,
    /// Greatest distance (m); infinite if an unlimited joint slides.
    pub greatest: f64,
}

impl Reach {
    /// Bounds for the robot's end effector.
    ///
    /// Every axis is given the point that makes the way over these points shortest; distances of points one or two apart
    /// follow from the joint limits, all others from the triangle inequality. Where an axis runs along the way, as that of
    /// a rolling forearm does, both of its ends are tried.
    #[must_use]
    pub fn of(robot: &Robot) -> Self {
        let chain = SerialChain::of(robot);
        let (lines, root_from_link) = chain.at_zero();
        let at_origins = lines.iter().map(|line| line.point);
        let mut points: Vec<Point3<f64>> =
            at_origins.chain([Point3::from(root_from_link.translation.vector)]).collect();
        settle(&mut points, &chain, &lines, 0, lines.len());
        let root_from_shoulder = points[0];
        let (mut least, mut greatest) = (0.0_f64, f64::INFINITY);
        for split in 0..=lines.len() {
            let mut points = points.clone();
            settle(&mut points, &chain, &lines, 1, split);
            let bounds = distance_bounds(&chain, &lines, &points);
            (least, greatest) = (least.max(bounds.0), greatest.min(bounds.1));
        }
        Self { root_from_shoulder, least, greatest }
    }

    /// Whether the pose `root_from_link` lies within the bounds.
    #[must_use]
    pub fn contains(&self, root_from_link: &Pose) -> bool {
        let distance = (root_from_link.translation.vector - self.root_from_shoulder.coords).norm();
        distance >= self.least - SLACK && distance <= self.greatest + SLACK
    }
}

/// Moves the points of the joints from `first` on along their axes so that the way over all points becomes shorter.
///
/// One point per joint at joint values zero, on the axis of a turning one, then the hand. A point that may lie anywhere
/// between its neighbours goes to the one before if its joint comes before `split`, else to the one after.
fn settle(points: &mut [Point3<f64>], chain: &SerialChain, lines: &[Line], first: usize, split: usize) {
    const SWEEPS: usize = 64;
    for _ in 0..SWEEPS {
        for i in first..lines.len() {
            let (before, after) = (points[i.saturating_sub(1)], points[i + 1]);
            points[i] = match (chain.joints[i].turns, i) {
                (true, 0) => nearest_between(&lines[i], &after, &after),
                (true, _) if i < split => nearest_between(&lines[i], &before, &after),
                (true, _) => nearest_between(&lines[i], &after, &before),
                (false, 0) => points[0],
                (false, _) => before,
            };
        }
    }
}

/// The point of a line with the least sum of distances to `a` and `b`; the foot of `a` where the line holds both.
fn nearest_between(line: &Line, a: &Point3<f64>, b: &Point3<f64>) -> Point3<f64> {
    let along = |p: &Point3<f64>| line.axis.dot(&(p - line.point));
    let (across_a, across_b) = (line.to(a).norm(), line.to(b).norm());
    let total = across_a + across_b;
    let weight = if total > 1e-9 { across_a / total } else { 0.0 };
    line.point + line.axis * (along(a) + weight * (along(b) - along(a)))
}

/// Least and greatest distance (m) between the first and the last point.
fn distance_bounds(chain: &SerialChain, lines: &[Line], points: &[Point3<f64>]) -> (f64, f64) {
    let count = points.len();
    let mut bounds = vec![vec![(0.0, 0.0); count]; count];
    for span in 1..count {
        for from in 0..count - span {
            let to = from + span;
            let direct = match span {
                1 => over_one(chain, lines, points, from),
                2 => over_turn(chain, lines, points, from + 1),
                _ => (0.0, f64::INFINITY),
            };
            bounds[from][to] = (from + 1..to).fold(direct, |(least, greatest): (f64, f64), via| {
                let ((a, b), (c, d)) = (bounds[from][via], bounds[via][to]);
                (least.max(a - d).max(c - b), greatest.min(b + d))
            });
        }
    }
    bounds[0][count - 1]
}

/// Distance from the point of joint `i` to the next: constant unless the joint slides.
fn over_one(chain: &SerialChain, lines: &[Line], points: &[Point3<f64>], i: usize) -> (f64, f64) {
    let apart = points[i + 1] - points[i];
    if chain.joints[i].turns {
        return (apart.norm(), apart.norm());
    }
    let range = value_range(chain, i);
    let at = |value: f64| if value.is_finite() { (apart + lines[i].axis * value).norm() } else { f64::INFINITY };
    (at(range.nearest(-lines[i].axis.dot(&apart))), at(range.lower).max(at(range.upper)))
}

/// Distance between the points before and after joint `i`, if it and the one before it turn.
fn over_turn(chain: &SerialChain, lines: &[Line], points: &[Point3<f64>], i: usize) -> (f64, f64) {
    if !chain.joints[i].turns || !chain.joints[i - 1].turns {
        return (0.0, f64::INFINITY);
    }
    let range = value_range(chain, i);
    let (before, after): (Vector3<f64>, Vector3<f64>) = (points[i - 1] - points[i], points[i + 1] - points[i]);
    let phase = angle_about(&lines[i].axis, &before, &after);
    let at = |angle: f64| (points[i - 1] - lines[i].turn(&points[i + 1], angle)).norm();
    // The distance has its minimum where both points are on the same side of the axis, its maximum half a turn away.
    let nearest_to = |best: f64| {
        let turns = ((range.lower - best) / TAU).ceil();
        let inside = !turns.is_finite() || best + TAU * turns <= range.upper;
        if inside { [best, best] } else { [range.lower, range.upper] }.map(at)
    };
    let [a, b] = nearest_to(-phase);
    let [c, d] = nearest_to(PI - phase);
    (a.min(b), c.max(d))
}

/// Limits of the value of joint `i`.
fn value_range(chain: &SerialChain, i: usize) -> Range {
    let joint = &chain.joints[i];
    let range = chain.ranges[joint.index];
    let ends = [range.lower, range.upper].map(|x| joint.scale * x + joint.offset);
    Range { lower: ends[0].min(ends[1]), upper: ends[0].max(ends[1]) }
}
