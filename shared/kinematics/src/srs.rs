//! Closed-form inverse kinematics of arms built like a human's: spherical shoulder, elbow, spherical wrist.

use model::{Pose, Robot};
use nalgebra::{Matrix3, Point3, Rotation3, UnitQuaternion, Vector3};

use crate::descent::descend;
use crate::elbow::Elbow;
use crate::line::{Line, angle_about, meeting_point, perpendicular, rotation};
use crate::serial::SerialChain;
use crate::spherical::SphericalJoint;

/// Distance (m) by which axes that should meet may miss each other (rounded numbers in a URDF).
const MISS: f64 = 1e-4;
/// Distance (m) up to which axes count as meeting exactly; above it, solutions are polished.
const EXACT: f64 = 1e-12;
/// Sine of the least angle between consecutive axes, and least arm of the elbow (m).
const DEGENERATE: f64 = 1e-3;
/// Distance of wrist and shoulder (m) below which no direction from one to the other is defined.
const FOLDED: f64 = 1e-9;
/// Greatest error (m or rad) of a polished solution.
const TOLERANCE: f64 = 1e-9;
/// Difference of joint values (rad) below which two branches are the same.
const SAME: f64 = 1e-7;

/// An arm of seven turning joints whose first three axes meet in the shoulder and last three in the wrist centre.
///
/// For one pose of the hand the arm can still swivel about the line from shoulder to wrist. The swivel angle is that of
/// the elbow's axis about this line, measured from a reference direction that is carried from the arm's pole (the first
/// axis, away from the root) to the line by the shortest rotation: it is smooth everywhere but where the wrist is exactly
/// opposite the pole. It stays defined where the elbow is straight.
#[derive(Clone, Debug)]
pub struct SrsArm {
    chain: SerialChain,
    shoulder: Point3<f64>,
    wrist: Point3<f64>,
    shoulder_joint: SphericalJoint,
    elbow: Elbow,
    wrist_joint: SphericalJoint,
    /// Pose of the end effector's parent link in the root where all joints are zero.
    root_from_link_at_zero: Pose,
    pole: Vector3<f64>,
    /// Direction of swivel zero at the pole.
    reference_at_pole: Vector3<f64>,
    /// Whether the axes meet exactly.
    exact: bool,
}

impl SrsArm {
    /// The arm that carries the robot's end effector, if it is of this kind: whatever its zero angles, frames and axis signs.
    #[must_use]
    pub fn recognise(robot: &Robot) -> Option<Self> {
        let chain = SerialChain::of(robot);
        let (lines, root_from_link_at_zero) = chain.at_zero();
        let lines: [Line; 7] = lines.try_into().ok()?;
        let direct = |i: usize| {
            let joint = &chain.joints[i];
            let alone = chain.joints.iter().filter(|other| other.index == joint.index).count() == 1;
            joint.turns && alone && joint.scale == 1.0 && joint.offset == 0.0
        };
        let crossing = |i: usize| lines[i].axis.cross(&lines[i + 1].axis).norm() > DEGENERATE;
        if !(0..7).all(direct) || ![0, 1, 4, 5].into_iter().all(crossing) {
            return None;
        }
        let (shoulder, shoulder_miss) = meeting_point(&lines[..3])?;
        let (wrist, wrist_miss) = meeting_point(&lines[4..])?;
        let elbow = Elbow::new(lines[3], &shoulder, &wrist);
        if shoulder_miss.max(wrist_miss) > MISS || elbow.least_arm() < DEGENERATE {
            return None;
        }
        let upwards = if lines[0].axis.dot(&shoulder.coords) < 0.0 { -1.0 } else { 1.0 };
        let pole = lines[0].axis * upwards;
        let axes = |first: usize| [first, first + 1, first + 2].map(|i| lines[i].axis);
        Some(Self {
            shoulder_joint: SphericalJoint::new(axes(0)),
            wrist_joint: SphericalJoint::new(axes(4)),
            reference_at_pole: perpendicular(&lines[1].axis, &pole).normalize(),
            exact: shoulder_miss.max(wrist_miss) <= EXACT,
            chain,
            shoulder,
            wrist,
            elbow,
            root_from_link_at_zero,
            pole,
        })
    }

    /// All arm configurations (coordinates after the base, rad) that bring the end effector's parent link to
    /// `root_from_link` with the swivel angle `swivel` (rad), within 1e-9 m and rad.
    ///
    /// At most eight, within the limits, by elbow, shoulder and wrist branch. Of values a whole turn apart, the one nearest
    /// zero that is within the limits. None where the wrist centre falls on the shoulder.
    #[must_use]
    pub fn solve(&self, root_from_link: &Pose, swivel: f64) -> Vec<Vec<f64>> {
        self.branches(root_from_link, swivel, None)
    }

    /// As [`Self::solve`] with the swivel angle of `arm`: the branch nearest to `arm` (greatest joint difference), values
    /// a whole turn apart taken as near to it as the limits allow.
    #[must_use]
    pub fn nearest(&self, root_from_link: &Pose, arm: &[f64]) -> Option<Vec<f64>> {
        let branches = self.branches(root_from_link, self.swivel_of(arm), Some(arm));
        branches.into_iter().min_by(|a, b| greatest_difference(a, arm).total_cmp(&greatest_difference(b, arm)))
    }

    /// The swivel angle (rad, -π..=π) of an arm configuration (coordinates after the base).
    #[must_use]
    pub fn swivel_of(&self, arm: &[f64]) -> f64 {
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| arm[self.chain.joints[i].index]);
        let upper_arm = self.shoulder_joint.compose([a, b, c]);
        let line = self.elbow.line.turn(&self.wrist, d) - self.shoulder;
        let Some(line) = line.try_normalize(FOLDED) else { return 0.0 };
        let line = upper_arm * line;
        angle_about(&line, &self.reference(&line), &(upper_arm * self.elbow.line.axis))
    }

    /// The direction of swivel zero for the unit vector `line` from shoulder to wrist, at right angles to it.
    fn reference(&self, line: &Vector3<f64>) -> Vector3<f64> {
        let sum = self.pole + line;
        let carried = if sum.norm_squared() > 1e-24 {
            self.reference_at_pole - sum * (2.0 * sum.dot(&self.reference_at_pole) / sum.norm_squared())
        } else {
            self.reference_at_pole
        };
        perpendicular(&carried, line).normalize()
    }

    /// Solutions of all branches; with `near`, as near to it as whole turns and aligned axes allow.
    fn branches(&self, root_from_link: &Pose, swivel: f64, near: Option<&[f64]>) -> Vec<Vec<f64>> {
        let mut found = Vec::new();
        let moved = root_from_link * self.root_from_link_at_zero.inverse();
        let line = moved * self.wrist - self.shoulder;
        let distance = line.norm();
        let Some(angles) = self.elbow.angles(distance).filter(|_| distance > FOLDED && swivel.is_finite()) else {
            return found;
        };
        let direction = line / distance;
        let elbow_axis = rotation(&direction, swivel) * self.reference(&direction);
        let hint = |joint: usize| near.map(|arm| arm[self.chain.joints[joint].index]);
        for elbow in angles {
            let Some(upper_arm) = self.upper_arm(elbow, &direction, &elbow_axis) else { continue };
            let Some(shoulders) = self.shoulder_joint.split(&upper_arm, hint(0)) else { continue };
            let forearm = upper_arm * rotation(&self.elbow.line.axis, elbow);
            let Some(wrists) = self.wrist_joint.split(&(forearm.inverse() * moved.rotation), hint(4)) else { continue };
            for [a, b, c] in shoulders {
                for [e, f, g] in wrists {
                    self.admit(&mut found, root_from_link, [a, b, c, elbow, e, f, g], near);
                }
            }
        }
        found
    }

    /// The shoulder's rotation that points the bent arm along `direction` with the elbow's axis towards `elbow_axis`.
    fn upper_arm(
        &self,
        elbow: f64,
        direction: &Vector3<f64>,
        elbow_axis: &Vector3<f64>,
    ) -> Option<UnitQuaternion<f64>> {
        let line = (self.elbow.line.turn(&self.wrist, elbow) - self.shoulder).try_normalize(FOLDED)?;
        let axis = perpendicular(&self.elbow.line.axis, &line).try_normalize(FOLDED)?;
        let before = Matrix3::from_columns(&[line, axis, line.cross(&axis)]);
        let after = Matrix3::from_columns(&[*direction, *elbow_axis, direction.cross(elbow_axis)]);
        let turned = Rotation3::from_matrix_unchecked(after * before.transpose());
        Some(UnitQuaternion::from_rotation_matrix(&turned))
    }

    /// Adds the solution with these joint values if the limits allow it and it is not there already.
    fn admit(&self, found: &mut Vec<Vec<f64>>, root_from_link: &Pose, values: [f64; 7], near: Option<&[f64]>) {
        let mut arm = near.unwrap_or(&self.chain.rest).to_vec();
        for (joint, value) in self.chain.joints.iter().zip(values) {
            let near = near.map_or(0.0, |near| near[joint.index]);
            let Some(value) = self.chain.ranges[joint.index].nearest_turn(value, near) else { return };
            arm[joint.index] = value;
        }
        let fits = self.exact || descend(&self.chain, root_from_link, &mut arm, 8) <= TOLERANCE;
        if fits && found.iter().all(|other| greatest_difference(other, &arm) > SAME) {
            found.push(arm);
        }
    }
}

/// Greatest difference of two configurations in one coordinate.
pub(crate) fn greatest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}
