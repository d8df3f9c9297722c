//! What is left when all named effects are in the model: noise, or something that is not in the catalogue?
//!
//! White noise has the same power at all frequencies. Physics moves as slowly as the arm. So the power of the held-out
//! residual at low frequencies, compared with the white floor, tells whether there is something left.

use crate::model::Evaluation;
use crate::recording::Recording;
use crate::recording::differentiate::low_pass;
use crate::recording::split::Split;

/// Below this frequency \[Hz\] the residual should be as weak as the white noise.
const LOW: f64 = 1.5;
/// Low-frequency power over that of the white floor, from which on something is left.
const MOST_EXCESS: f64 = 2.0;
/// Smallest share of the joint's torque (RMS) that is worth reporting.
const LEAST_SHARE: f64 = 0.02;

/// The joints (from 0) where the held-out residual holds more than noise.
pub fn joints_with_structure(recording: &Recording, split: &Split, evaluation: &Evaluation) -> Vec<usize> {
    let Some(floor) = &evaluation.noise_floor_nmse else { return Vec::new() };
    let has_structure = |&joint: &usize| {
        let (mut energy, mut low_energy, mut count, mut white_part) = (0.0, 0.0, 0.0, 0.0);
        for segment in &split.held_out {
            let trajectory = &recording.trajectories[segment.trajectory];
            let step = trajectory.time_step();
            if step <= 0.0 || step * LOW >= 0.25 {
                continue;
            }
            let predicted = &evaluation.predictions[segment.trajectory].total[joint];
            let tau = &trajectory.tau[joint];
            let residual: Vec<f64> = segment.samples.clone().map(|sample| tau[sample] - predicted[sample]).collect();
            low_energy += low_pass(&residual, step, LOW).iter().map(|value| value * value).sum::<f64>();
            energy += tau[segment.samples.clone()].iter().map(|tau| tau * tau).sum::<f64>();
            count += residual.len() as f64;
            white_part += residual.len() as f64 * 2.0 * LOW * step;
        }
        if count == 0.0 || energy == 0.0 {
            return false;
        }
        let expected = floor[joint] * energy * white_part / count;
        let excess = (low_energy - expected).max(0.0);
        low_energy > MOST_EXCESS * expected && (excess / energy).sqrt() > LEAST_SHARE
    };
    (0..recording.joint_count()).filter(has_structure).collect()
}
