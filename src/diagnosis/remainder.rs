//! What is left when all named effects are in the model: noise, or something that is not in the catalogue?
//!
//! Two signs of the latter. On the training part a flexible basis of the state predicts left-out blocks ([`super::flexible`]).
//! On the held-out part the residual is stronger at low frequencies than white noise is: physics moves as slowly as the arm.

use rayon::prelude::*;

use super::flexible;
use super::search::Search;
use crate::model::{Evaluation, ModelError};
use crate::recording::Recording;
use crate::recording::differentiate::low_pass;
use crate::recording::split::Split;

/// Below this frequency \[Hz\] the residual should be as weak as the white noise.
const LOW: f64 = 1.5;
/// Low-frequency power over that of the white floor, from which on something is left.
const MOST_EXCESS: f64 = 2.0;
/// Smallest share of the joint's torque (RMS) that is worth reporting at low frequencies.
const LEAST_SHARE: f64 = 0.02;
/// Share of the residual's energy that the flexible basis must predict.
const LEAST_PREDICTED: f64 = 0.12;
/// Smallest share of the joint's torque (RMS) that is worth reporting if the basis predicts it.
const LEAST_PREDICTED_SHARE: f64 = 0.002;

/// The joints (from 0) where more is left than noise beside the effects found.
///
/// # Errors
/// [`ModelError`] if a column of the flexible basis can't be computed.
pub fn joints_with_structure(
    search: &Search,
    recording: &Recording,
    split: &Split,
    evaluation: &Evaluation,
) -> Result<Vec<usize>, ModelError> {
    let mut joints = slow_remainders(recording, split, evaluation);
    let design = &search.library.design;
    let structures: Vec<_> =
        (0..recording.joint_count()).into_par_iter().map(|joint| flexible::structure(search, joint)).collect();
    for (joint, structure) in structures.into_iter().enumerate() {
        let structure = structure?;
        let torque = (design.energy(joint) / design.sample_count(joint).max(1) as f64).sqrt();
        if structure.share > LEAST_PREDICTED && structure.size > LEAST_PREDICTED_SHARE * torque {
            joints.push(joint);
        }
    }
    joints.sort_unstable();
    joints.dedup();
    Ok(joints)
}

/// The joints (from 0) whose held-out residual is stronger at low frequencies than its white noise.
fn slow_remainders(recording: &Recording, split: &Split, evaluation: &Evaluation) -> Vec<usize> {
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
