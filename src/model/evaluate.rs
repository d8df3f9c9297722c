//! Predictions, errors on training and held-out data, and the noise floor.
//!
//! Errors are measured on the raw torque, not on the filtered one that models are fitted to.

use rayon::prelude::*;
use serde::Serialize;

use super::{Fitted, ModelError};
use crate::recording::Recording;
use crate::recording::split::{Segment, Split};
use crate::signals::Signals;
use crate::statistics::white_noise;

/// Torque of a model along one trajectory.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// Sum of all terms \[N m\].
    pub total: Signals,
    /// Each term alone, in the order of the model \[N m\].
    pub terms: Vec<Signals>,
}

/// A model held against a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluation {
    /// One for each trajectory of the recording.
    pub predictions: Vec<Prediction>,
    /// Error of each joint on the training part.
    pub train: Vec<JointError>,
    /// Error of each joint on the held-out part.
    pub held_out: Vec<JointError>,
    /// Error of all joints together on the training part.
    pub all_train: JointError,
    /// Error of all joints together on the held-out part.
    pub all_held_out: JointError,
    /// nMSE on the held-out part that would be left if only the white noise of the torque were left; `None` if there are
    /// too few samples to tell.
    pub noise_floor_nmse: Option<Vec<f64>>,
}

/// Error of one joint, or of all together: then means and sums are over samples and joints, and each joint's spread is about its own
/// mean. All are NaN if the part has no samples.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct JointError {
    /// Mean squared error \[(N m)²\].
    pub mse: f64,
    /// Σ(τ − τ̂)² / Στ².
    pub nmse: f64,
    /// 1 − Σ(τ − τ̂)² / Σ(τ − mean τ)².
    pub r2: f64,
}

impl Prediction {
    /// Adds up the terms; `zero` is the torque of no term.
    pub(super) fn sum_of(terms: Vec<Signals>, zero: Signals) -> Self {
        let mut total = zero;
        terms.iter().for_each(|term| total.add(term, 1.0));
        Prediction { total, terms }
    }
}

impl Evaluation {
    /// Predicts all trajectories and measures the error on both parts.
    ///
    /// # Errors
    /// [`ModelError`] if a term can't be computed for a trajectory.
    pub fn of(fitted: &Fitted, recording: &Recording, split: &Split) -> Result<Self, ModelError> {
        let predictions = recording
            .trajectories
            .iter()
            .map(|trajectory| fitted.predict(trajectory))
            .collect::<Result<Vec<_>, _>>()?;
        let errors = |segments: &[Segment]| {
            let of_joint = |joint| joint_error(recording, &predictions, segments, joint);
            (0..recording.joint_count()).into_par_iter().map(of_joint).collect()
        };
        let (train, held_out): (Vec<_>, Vec<JointError>) = (errors(&split.train), errors(&split.held_out));
        let noise_floor_nmse = noise_floor(recording, &predictions, &split.held_out);
        let [all_train, all_held_out] = [&split.train, &split.held_out].map(|segments| {
            let of_joint = |joint| Sums::of(recording, &predictions, segments, joint);
            Sums::all((0..recording.joint_count()).map(of_joint)).error()
        });
        Ok(Evaluation { predictions, train, held_out, all_train, all_held_out, noise_floor_nmse })
    }

    /// Residual τ − τ̂ of one trajectory.
    pub fn residual(&self, recording: &Recording, trajectory: usize) -> Signals {
        let mut residual = recording.trajectories[trajectory].tau.clone();
        residual.add(&self.predictions[trajectory].total, -1.0);
        residual
    }

    /// Held-out nMSE of each joint.
    pub fn held_out_nmse(&self) -> Vec<f64> {
        self.held_out.iter().map(|error| error.nmse).collect()
    }
}

fn joint_error(recording: &Recording, predictions: &[Prediction], segments: &[Segment], joint: usize) -> JointError {
    Sums::of(recording, predictions, segments, joint).error()
}

/// What errors are made of.
#[derive(Default)]
struct Sums {
    count: f64,
    /// Σ τ²
    energy: f64,
    /// Σ (τ − mean τ)²
    spread: f64,
    squared_error: f64,
}

impl Sums {
    fn of(recording: &Recording, predictions: &[Prediction], segments: &[Segment], joint: usize) -> Sums {
        let (mut sums, mut sum) = (Sums::default(), 0.0);
        for segment in segments {
            let tau = &recording.trajectories[segment.trajectory].tau[joint][segment.samples.clone()];
            let model = &predictions[segment.trajectory].total[joint][segment.samples.clone()];
            for (tau, model) in tau.iter().zip(model) {
                sums.count += 1.0;
                sum += tau;
                sums.energy += tau * tau;
                sums.squared_error += (tau - model).powi(2);
            }
        }
        sums.spread = sums.energy - sum * sum / sums.count;
        sums
    }

    /// Those of several joints together.
    fn all(joints: impl Iterator<Item = Sums>) -> Sums {
        joints.fold(Sums::default(), |all, own| Sums {
            count: all.count + own.count,
            energy: all.energy + own.energy,
            spread: all.spread + own.spread,
            squared_error: all.squared_error + own.squared_error,
        })
    }

    fn error(&self) -> JointError {
        let Sums { count, energy, spread, squared_error } = self;
        JointError { mse: squared_error / count, nmse: squared_error / energy, r2: 1.0 - squared_error / spread }
    }
}

/// White noise of the torque, as what changes fast in the residual tells it, over its energy.
fn noise_floor(recording: &Recording, predictions: &[Prediction], segments: &[Segment]) -> Option<Vec<f64>> {
    let of_joint = |joint: usize| {
        let mut residuals: Vec<Vec<f64>> = Vec::new();
        let mut energy = 0.0;
        let mut count = 0.0;
        for segment in segments {
            let tau = &recording.trajectories[segment.trajectory].tau[joint][segment.samples.clone()];
            let model = &predictions[segment.trajectory].total[joint][segment.samples.clone()];
            residuals.push(tau.iter().zip(model).map(|(tau, model)| tau - model).collect());
            energy += tau.iter().map(|tau| tau * tau).sum::<f64>();
            count += tau.len() as f64;
        }
        let deviation = white_noise(residuals).filter(|_| energy != 0.0)?;
        Some(deviation.powi(2) * count / energy)
    };
    (0..recording.joint_count()).into_par_iter().map(of_joint).collect()
}
