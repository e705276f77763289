//! Damped least squares: a few steps downhill in the hand's pose error.

use model::Pose;
use nalgebra::{Matrix6, Vector6};

use crate::serial::SerialChain;

/// Pose error (m and rad) at which the descent ends.
const REACHED: f64 = 1e-11;
/// Greatest change of a coordinate in one step (rad or m).
const LONGEST_STEP: f64 = 0.7;
/// Steps after which the error must have fallen to [`PROGRESS`] of what it was.
const PATIENCE: usize = 8;
/// See [`PATIENCE`].
const PROGRESS: f64 = 0.8;

/// Moves `arm` towards the pose `root_from_link` by at most `most_steps` steps within the limits; returns the pose error
/// left, the greater of metres and radians.
///
/// Levenberg-Marquardt with the damping proportional to the squared error (Sugihara, "Solvability-unconcerned inverse
/// kinematics by the Levenberg-Marquardt method", 2011); a coordinate that presses against its limit is held there.
pub(crate) fn descend(chain: &SerialChain, root_from_link: &Pose, arm: &mut [f64], most_steps: usize) -> f64 {
    let numbers = root_from_link.translation.vector.iter().chain(root_from_link.rotation.coords.iter());
    if !numbers.chain(arm.iter()).all(|x| x.is_finite()) {
        return f64::INFINITY;
    }
    let mut columns = Vec::with_capacity(arm.len());
    let mut earlier = f64::INFINITY;
    for step in 0.. {
        let pose = chain.pose_and_columns(arm, &mut columns);
        let error = difference(root_from_link, &pose);
        let size = size(&error);
        let stalled = step % PATIENCE == PATIENCE - 1 && size > PROGRESS * std::mem::replace(&mut earlier, size);
        if size <= REACHED || step == most_steps || stalled {
            return size;
        }
        hold_at_limits(chain, arm, &error, &mut columns);
        let Some(change) = damped_step(&columns, &error) else { return size };
        let longest = change.clone().fold(0.0_f64, |longest, x| longest.max(x.abs()));
        let scale = if longest > LONGEST_STEP { LONGEST_STEP / longest } else { 1.0 };
        for ((x, range), change) in arm.iter_mut().zip(&chain.ranges).zip(change) {
            *x = range.nearest(*x + scale * change);
        }
    }
    f64::INFINITY
}

/// Translation (m) and rotation vector (rad), in the root frame, that take `pose` to `target`.
fn difference(target: &Pose, pose: &Pose) -> Vector6<f64> {
    let moved = target.translation.vector - pose.translation.vector;
    let turned = (target.rotation * pose.rotation.inverse()).scaled_axis();
    Vector6::new(moved.x, moved.y, moved.z, turned.x, turned.y, turned.z)
}

/// The greater of metres and radians.
fn size(error: &Vector6<f64>) -> f64 {
    error.fixed_rows::<3>(0).norm().max(error.fixed_rows::<3>(3).norm())
}

/// Clears the columns of coordinates that the error presses against their limits.
fn hold_at_limits(chain: &SerialChain, arm: &[f64], error: &Vector6<f64>, columns: &mut [Vector6<f64>]) {
    for ((x, range), column) in arm.iter().zip(&chain.ranges).zip(columns) {
        let push = column.dot(error);
        if (*x >= range.upper && push > 0.0) || (*x <= range.lower && push < 0.0) {
            column.fill(0.0);
        }
    }
}

/// Jᵀ (J Jᵀ + λ)⁻¹ error.
fn damped_step(columns: &[Vector6<f64>], error: &Vector6<f64>) -> Option<impl Iterator<Item = f64> + Clone> {
    let damping = 0.5 * error.norm_squared() + 1e-12;
    let mut gram = Matrix6::from_diagonal_element(damping);
    for column in columns {
        gram.ger(1.0, column, column, 1.0);
    }
    let weights = gram.cholesky()?.solve(error);
    Some(columns.iter().map(move |column| column.dot(&weights)))
}
