//! How far a model is from what was measured, and from the parts of the torque where these are known.

use serde::{Deserialize, Serialize};

use crate::arm::Arm;
use crate::model::Fitted;
use crate::progress::Monitor;
use crate::recording::{JointKind, Recording, Trajectory};
use crate::signals::Signals;
use crate::training::{TrainError, components, fit};

/// Errors of a model on a test set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Σ‖τ − τ̂‖² / Σ‖τ‖²
    pub nmse_torque: f64,
    /// The same of inertial, Coriolis and gravity torque, where they are known and not zero.
    pub nmse_parts: [Option<f64>; 3],
    /// Mean of (τ − τ̂)² for each joint \[(N m)² or N²\].
    pub mse_joint: Vec<f64>,
    /// What each joint does.
    #[serde(default)]
    pub kinds: Vec<JointKind>,
    /// 1 − Σ(τ − τ̂)² / Σ(τ − mean τ)², all joints together.
    pub r2: f64,
    /// Of an ensemble: share of the samples within its 95 % band, which is wide by the spread of its members.
    pub band_coverage: Option<f64>,
}

impl Errors {
    /// Whether the model gave numbers everywhere.
    pub fn is_finite(&self) -> bool {
        let parts = self.nmse_parts.iter().flatten();
        parts.chain(&self.mse_joint).chain([&self.nmse_torque, &self.r2]).all(|value| value.is_finite())
    }
}

/// Names of the parts.
const PARTS: [&str; 3] = ["inertial", "coriolis", "gravity"];

/// Measures a model, which is the mean of its members. `arm` is the one that moved, where it is known exactly.
///
/// # Errors
/// [`TrainError`] if the test set does not fit the model, or it was stopped.
pub fn measure(
    members: &[Fitted],
    recording: &Recording,
    arm: Option<&Arm>,
    monitor: &Monitor,
) -> Result<Errors, TrainError> {
    let joints = recording.joint_count();
    let mut parts = [[0.0; 2]; 3];
    let mut by_joint = vec![[0.0; 3]; joints];
    let (mut inside, mut count) = (0.0, 0.0);
    let total = recording.trajectories.len();
    for (number, trajectory) in recording.trajectories.iter().enumerate() {
        monitor.report(number as f32 / total as f32, "measuring")?;
        let torques: Vec<Signals> =
            members.iter().map(|member| torque(member, trajectory)).collect::<Result<_, _>>()?;
        let mean = mean(&torques);
        for (joint, sums) in by_joint.iter_mut().enumerate() {
            for (sample, exact) in trajectory.tau[joint].iter().enumerate() {
                sums[0] += (exact - mean[joint][sample]).powi(2);
                sums[1] += exact;
                sums[2] += exact * exact;
                let spread = torques.iter().map(|own| (own[joint][sample] - mean[joint][sample]).powi(2)).sum::<f64>();
                let deviation = (spread / (torques.len() as f64 - 1.0).max(1.0)).sqrt();
                inside += f64::from((exact - mean[joint][sample]).abs() <= 1.96 * deviation);
                count += 1.0;
            }
        }
        if let Some(arm) = arm {
            let exact = arm.components_along(&trajectory.q, &trajectory.qd, &trajectory.qdd);
            let own: Vec<[Signals; 3]> =
                members.iter().map(|member| parts_of(member, trajectory)).collect::<Result<_, _>>()?;
            for (part, exact) in [&exact.inertial, &exact.coriolis, &exact.gravity].into_iter().enumerate() {
                let estimates: Vec<Signals> = own.iter().map(|parts| parts[part].clone()).collect();
                for (exact, estimate) in exact.iter().flatten().zip(self::mean(&estimates).iter().flatten()) {
                    parts[part][0] += (exact - estimate).powi(2);
                    parts[part][1] += exact * exact;
                }
            }
        }
    }
    let samples = recording.sample_count() as f64;
    let error: f64 = by_joint.iter().map(|sums| sums[0]).sum();
    let size: f64 = by_joint.iter().map(|sums| sums[2]).sum();
    let spread: f64 = by_joint.iter().map(|sums| sums[2] - sums[1] * sums[1] / samples).sum();
    Ok(Errors {
        nmse_torque: error / size,
        nmse_parts: parts.map(|[error, size]| (size > 0.0).then(|| error / size)),
        mse_joint: by_joint.iter().map(|sums| sums[0] / samples).collect(),
        kinds: recording.joints.iter().map(|joint| joint.kind).collect(),
        r2: 1.0 - error / spread,
        band_coverage: (members.len() > 1).then_some(inside / count),
    })
}

/// What a member says.
pub(super) fn torque(member: &Fitted, trajectory: &Trajectory) -> Result<Signals, TrainError> {
    Ok(member.predict(trajectory).map_err(|error| TrainError::Model(error.to_string()))?.total)
}

/// Inertial, Coriolis and gravity torque of a model. Where it has no H(q) and V(q) of its own they are read off its torque, as
/// Lutter and the paper do.
pub(super) fn parts_of(member: &Fitted, trajectory: &Trajectory) -> Result<[Signals; 3], TrainError> {
    if let Some(networks) = fit::networks(member) {
        let columns = fit::effect_columns(member, trajectory)?;
        let parts = networks.components(trajectory, &columns)?;
        if parts.lagrangian.as_ref().is_none_or(|inside| inside.potential.is_none()) {
            let read_off = parts.read_off;
            return Ok([read_off.inertial, read_off.coriolis, read_off.gravity]);
        }
    }
    let mut own = components(member, trajectory)?;
    Ok(PARTS.map(|part| {
        let found = own.iter_mut().find(|(name, _)| *name == part);
        found.map(|(_, torque)| std::mem::take(torque)).unwrap_or_default()
    }))
}

/// Their mean; there is at least one.
pub(super) fn mean(all: &[Signals]) -> Signals {
    let of_all = |joint: usize, sample: usize| all.iter().map(|own| own[joint][sample]).sum::<f64>();
    let (joints, samples) = (all[0].joint_count(), all[0].sample_count());
    Signals::from_fn(joints, samples, |joint, sample| of_all(joint, sample) / all.len() as f64)
}
