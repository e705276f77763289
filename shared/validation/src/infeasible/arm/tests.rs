use super::*;
use crate::random::Random;

/// Where the hand is for joint values relative to those at which the axes are given.
fn hand_at(axes: &[Axis], hand: DVec3, values: &[f64]) -> DVec3 {
    axes.iter().zip(values).rev().fold(hand, |p, (axis, value)| match axis.turns {
        true => axis.point + DMat3::from_axis_angle(axis.direction, *value) * (p - axis.point),
        false => p + axis.direction * *value,
    })
}

fn random_chain(random: &mut Random) -> (Vec<Axis>, DVec3, DVec3) {
    let mut at = DVec3::ZERO;
    let mut axes = Vec::new();
    for _ in 0..1 + random.below(7) {
        at += DVec3::from(random.vector(0.4));
        let turns = random.below(5) > 0;
        let limit = if turns { std::f64::consts::PI } else { 0.3 };
        let lower = random.between(-limit, limit);
        let upper = random.between(lower, limit);
        axes.push(Axis { point: at, direction: random.direction(), turns, range: (lower, upper) });
    }
    (axes, DVec3::from(random.vector(0.3)), at + DVec3::from(random.vector(0.4)))
}

#[test]
fn no_configuration_of_a_random_chain_is_outside_of_its_range() {
    let mut informative = [0; 2];
    for seed in 0..500 {
        let mut random = Random(seed);
        let (axes, shoulder, hand) = random_chain(&mut random);
        let (least, greatest) = distance_range(&axes, shoulder, hand);
        let mut seen = (f64::INFINITY, 0.0_f64);
        for _ in 0..2000 {
            let values: Vec<f64> = axes.iter().map(|axis| random.between(axis.range.0, axis.range.1)).collect();
            let distance = hand_at(&axes, hand, &values).distance(shoulder);
            assert!(least <= distance && distance <= greatest, "seed {seed}: {distance} not in {least}..{greatest}");
            seen = (seen.0.min(distance), seen.1.max(distance));
        }
        informative[0] += usize::from(least > 0.5 * seen.0);
        informative[1] += usize::from(greatest < 1.5 * seen.1);
    }
    assert!(informative.iter().all(|count| *count > 100), "{informative:?}");
}

#[test]
fn an_arm_with_a_shoulder_an_elbow_and_a_wrist_is_bounded_by_its_elbow() {
    // Upper arm and forearm of 0.4 m, hand of 0.126 m; the elbow bends by 120° at most.
    let axis = |z: f64, direction: DVec3, limit: f64| Axis {
        point: DVec3::new(0.0, 0.0, z),
        direction,
        turns: true,
        range: (-limit, limit),
    };
    let directions = [DVec3::Z, DVec3::Y, DVec3::Z, DVec3::NEG_Y, DVec3::Z, DVec3::Y, DVec3::Z];
    let heights = [0.34, 0.34, 0.34, 0.74, 0.74, 1.14, 1.14];
    let axes: Vec<Axis> = (0..7).map(|i| axis(heights[i], directions[i], 2.094_395_102)).collect();
    let (least, greatest) = distance_range(&axes, DVec3::new(0.0, 0.0, 0.34), DVec3::new(0.0, 0.0, 1.266));
    assert!((greatest - 0.926).abs() < 1e-6, "{greatest}");
    assert!((least - 0.274).abs() < 1e-6, "{least}");
}

#[test]
fn a_slide_without_limits_reaches_any_distance() {
    let axis =
        Axis { point: DVec3::ZERO, direction: DVec3::Z, turns: false, range: (f64::NEG_INFINITY, f64::INFINITY) };
    let (least, greatest) = distance_range(&[axis], DVec3::X, DVec3::Z);
    assert!((least - 1.0).abs() < 1e-6 && greatest == f64::INFINITY);
}
