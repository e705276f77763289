//! Bounds on the distance between a point of a robot's root and the origin of its hand, over all arm configurations.
//!
//! Each joint is given a point: of a turning one any point of its axis, which belongs to both links that it connects.
//! Then the distance of neighbouring points is constant, that of points two apart depends on the one angle between them,
//! and the rest is the triangle inequality. Any choice of points gives valid bounds; several are tried.

use std::f64::consts::{PI, TAU};

use glamx::{DMat3, DVec3};

use crate::mechanism::Axis;

/// Sweeps over the points that shorten the way along them.
const SWEEPS: usize = 40;
/// Allowance for rounding (m).
const ROUNDING: f64 = 1e-9;

/// Least and greatest distance (m).
pub(crate) fn distance_range(axes: &[Axis], shoulder: DVec3, hand: DVec3) -> (f64, f64) {
    let mut range = (0.0_f64, f64::INFINITY);
    for bend in 0..=axes.len() {
        let mut points = spread(axes, shoulder, hand, bend);
        for shortened in [false, true] {
            if shortened {
                (0..SWEEPS).for_each(|_| shorten(axes, &mut points));
            }
            let (least, greatest) = over_all(axes, &points);
            range = (range.0.max(least - ROUNDING), range.1.min(greatest + ROUNDING));
        }
    }
    (range.0.max(0.0), range.1)
}

/// Points of the first `bend` joints close to the shoulder, those of the others close to the hand.
fn spread(axes: &[Axis], shoulder: DVec3, hand: DVec3, bend: usize) -> Vec<DVec3> {
    let mut points = vec![shoulder; axes.len() + 2];
    points[axes.len() + 1] = hand;
    for i in 0..bend {
        points[i + 1] = foot(&axes[i], points[i]);
    }
    for i in (bend..axes.len()).rev() {
        points[i + 1] = foot(&axes[i], points[i + 2]);
    }
    points
}

/// The point of a turning joint that is nearest to `p`; of a sliding one, whose point may be anywhere, `p` itself.
fn foot(axis: &Axis, p: DVec3) -> DVec3 {
    if axis.turns { axis.point + axis.direction * axis.direction.dot(p - axis.point) } else { p }
}

/// Moves each turning joint's point to where the way from its neighbour to its other neighbour is shortest.
fn shorten(axes: &[Axis], points: &mut [DVec3]) {
    for (i, axis) in axes.iter().enumerate().filter(|(_, axis)| axis.turns) {
        let [a, b] = [points[i], points[i + 2]].map(|p| (foot(axis, p), p));
        let [off_a, off_b] = [a, b].map(|(foot, p)| foot.distance(p));
        if off_a + off_b > ROUNDING {
            points[i + 1] = a.0.lerp(b.0, off_a / (off_a + off_b));
        }
    }
}

/// Range of the distance between the first and the last point.
fn over_all(axes: &[Axis], points: &[DVec3]) -> (f64, f64) {
    let n = points.len();
    let mut ranges = vec![vec![(0.0_f64, f64::INFINITY); n]; n];
    for width in 1..n {
        for from in 0..n - width {
            let to = from + width;
            let mut range = match width {
                1 => over_joint(axes, points, from),
                2 => over_bend(axes, points, from),
                _ => (0.0, f64::INFINITY),
            };
            for via in from + 1..to {
                let ((near, far), (other_near, other_far)) = (ranges[from][via], ranges[via][to]);
                range.0 = range.0.max(near - other_far).max(other_near - far);
                range.1 = range.1.min(far + other_far);
            }
            ranges[from][to] = range;
        }
    }
    ranges[0][n - 1]
}

/// From point `i` to the next: the joint of point `i` lies between them, unless `i` is the shoulder.
fn over_joint(axes: &[Axis], points: &[DVec3], i: usize) -> (f64, f64) {
    let apart = points[i + 1] - points[i];
    match i.checked_sub(1).map(|joint| &axes[joint]) {
        Some(axis) if !axis.turns => {
            let at =
                |value: f64| if value.is_finite() { (apart + axis.direction * value).length() } else { f64::INFINITY };
            let nearest = (-apart.dot(axis.direction)).clamp(axis.range.0, axis.range.1);
            (at(nearest), at(axis.range.0).max(at(axis.range.1)))
        }
        _ => (apart.length(), apart.length()),
    }
}

/// From point `i` to the one after the next, round the joint between them. Its square is a constant and a wave.
fn over_bend(axes: &[Axis], points: &[DVec3], i: usize) -> (f64, f64) {
    let axis = &axes[i];
    if !axis.turns || i.checked_sub(1).is_some_and(|before| !axes[before].turns) {
        return (0.0, f64::INFINITY);
    }
    let square = |angle: f64| {
        let turned = axis.point + DMat3::from_axis_angle(axis.direction, angle) * (points[i + 2] - axis.point);
        turned.distance_squared(points[i])
    };
    let (ahead, behind, aside) = (square(0.0), square(PI), square(PI / 2.0));
    let middle = f64::midpoint(ahead, behind);
    let crest = (aside - middle).atan2(ahead - middle);
    let height = (aside - middle).hypot(ahead - middle);
    let at = |angle: f64| (middle + height * (angle - crest).cos()).max(0.0).sqrt();
    let (lower, upper) = axis.range;
    let contains = |angle: f64| {
        let turns = ((lower - angle) / TAU).ceil();
        !turns.is_finite() || angle + TAU * turns <= upper
    };
    let ends = [lower, upper].map(|end| if end.is_finite() { at(end) } else { middle.sqrt() });
    let least = if contains(crest + PI) { (middle - height).max(0.0).sqrt() } else { ends[0].min(ends[1]) };
    let greatest = if contains(crest) { (middle + height).sqrt() } else { ends[0].max(ends[1]) };
    (least, greatest)
}

#[cfg(test)]
mod tests;
