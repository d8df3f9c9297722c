//! What the sensors make of the true motion: noise on the torque, steps of the encoder.

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::recording::differentiate::{
    default_cutoff, default_cutoff_of_positions, derivative, description, low_pass_joints, trusted_range,
};
use crate::recording::{Origin, Provenance, Trajectory};
use crate::signals::Signals;

/// Adds Gaussian noise of this standard deviation \[N m\] to each joint's torque.
pub(super) fn add_torque_noise(trajectory: &mut Trajectory, deviations: &[f64], random: &mut impl Rng) {
    for (torque, deviation) in trajectory.channels_mut().tau.iter_mut().zip(deviations) {
        for value in torque {
            let draw: f64 = StandardNormal.sample(random);
            *value += deviation * draw;
        }
    }
}

/// Rounds positions to whole steps of the encoder \[rad\] and derives velocity and acceleration from them, exactly as a
/// log of positions alone would be read. Gives the cut-off of the filter \[Hz\].
pub(super) fn read_encoders(trajectory: &mut Trajectory, resolution: f64) -> f64 {
    round_positions(trajectory, resolution);
    derive(trajectory, false)
}

/// Rounds positions to whole steps of the encoder \[rad\].
pub(super) fn round_positions(trajectory: &mut Trajectory, resolution: f64) {
    for value in trajectory.channels_mut().q.values_mut() {
        *value = (*value / resolution).round() * resolution;
    }
}

/// Derives acceleration, and velocity where it is not measured, as a log without them would be read, and leaves out the ends
/// that the filter spoils. Gives its cut-off \[Hz\].
pub(super) fn derive(trajectory: &mut Trajectory, velocity_is_measured: bool) -> f64 {
    let cutoff = if velocity_is_measured {
        default_cutoff(&trajectory.q, &trajectory.qd, trajectory.time_step())
    } else {
        default_cutoff_of_positions(&trajectory.q, &trajectory.time)
    };
    for joint in 0..trajectory.joint_count() {
        let mut run = trajectory.channels_mut();
        if !velocity_is_measured {
            run.qd[joint].copy_from_slice(&derivative(&run.q[joint], run.time, cutoff));
        }
        run.qdd[joint].copy_from_slice(&derivative(&run.qd[joint], run.time, cutoff));
    }
    *trajectory = trajectory.slice(trusted_range(trajectory.len(), trajectory.time_step(), cutoff));
    cutoff
}

/// What the log of a run whose derivatives were [derived](derive) can show of something else that was there at its samples: filtered as
/// they are, without the ends that were left out.
pub(super) fn as_derived(signals: &Signals, run: &Trajectory, cutoff: f64) -> Signals {
    let left_out = (signals.sample_count() - run.len()) / 2;
    low_pass_joints(signals, run.time_step(), cutoff).cut(left_out..left_out + run.len())
}

/// Where velocity and acceleration come from if acceleration is derived, from encoders with these steps \[rad\] or exact
/// positions; the cut-offs are those of the trajectories \[Hz\].
pub(super) fn provenance(velocity_is_measured: bool, resolution: Option<f64>, cutoffs: &[f64]) -> Provenance {
    let lowest = cutoffs.iter().copied().fold(f64::INFINITY, f64::min);
    let highest = cutoffs.iter().copied().fold(0.0, f64::max);
    let derived = |of: &str| Origin::Derived(description(of, lowest..=highest));
    let positions = resolution.map_or("q".to_owned(), |step| format!("q of an encoder with steps of {step} rad"));
    Provenance {
        velocity: if velocity_is_measured { Origin::Measured } else { derived(&positions) },
        acceleration: derived("q̇"),
        low_pass_hz: Some(lowest),
    }
}
