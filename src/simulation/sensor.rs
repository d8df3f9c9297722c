//! What the sensors make of the true motion: noise on the torque, steps of the encoder.

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::recording::differentiate::{default_cutoff, derivative, description};
use crate::recording::{Origin, Provenance, Trajectory};

/// Adds Gaussian noise of this standard deviation \[N m\] to each joint's torque.
pub(super) fn add_torque_noise(trajectory: &mut Trajectory, deviations: &[f64], random: &mut impl Rng) {
    for (torque, deviation) in trajectory.tau.iter_mut().zip(deviations) {
        for value in torque {
            let draw: f64 = StandardNormal.sample(random);
            *value += deviation * draw;
        }
    }
}

/// Rounds positions to whole steps of the encoder \[rad\] and derives velocity and acceleration from them, exactly as a
/// log of positions alone would be read.
pub(super) fn read_encoders(trajectory: &mut Trajectory, resolution: f64) {
    let cutoff = default_cutoff(trajectory.time_step());
    for joint in 0..trajectory.joint_count() {
        for value in &mut trajectory.q[joint] {
            *value = (*value / resolution).round() * resolution;
        }
        trajectory.qd[joint] = derivative(&trajectory.q[joint], &trajectory.time, cutoff);
        trajectory.qdd[joint] = derivative(&trajectory.qd[joint], &trajectory.time, cutoff);
    }
}

/// Where velocity and acceleration come from, with or without encoders, for recordings of this time step \[s\].
pub(super) fn provenance(encoder_resolution: Option<f64>, time_step: f64) -> Provenance {
    let Some(resolution) = encoder_resolution else {
        return Provenance { velocity: Origin::Measured, acceleration: Origin::Measured };
    };
    let cutoff = default_cutoff(time_step);
    let derived = |of: &str| Origin::Derived(description(of, cutoff..=cutoff));
    Provenance {
        velocity: derived(&format!("q of an encoder with steps of {resolution} rad")),
        acceleration: derived("q̇"),
    }
}
