//! How to train: settings, and the two sets of them that are offered.

use serde::{Deserialize, Serialize};

use super::TrainError;
use super::data::Samples;
use super::optimiser::Optimiser;
use super::schedule::Schedule;
use crate::model::learned::{Architecture, Features, Layers, LearnedPreset, LearnedTerm, Positive, Scales};
use crate::network::{Activation, Element};

/// How the weight of a joint grows with its torque, and the least there is. `bench stuck --first 200 --seeds 30` set them: with powers of 0.5,
/// 0.7 and 1 the largest error of a mystery is 2.2, 1.8 and 2.1 times that of the rigid body, without weights 3.8.
const WEIGHT_BY_TORQUE: f64 = 0.7;
const LEAST_WEIGHT: f64 = 0.01;

/// How to train.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Options {
    /// How often every sample is seen.
    pub epochs: u64,
    /// Samples in a step; the short last batch of an epoch is dropped.
    pub batch: usize,
    /// Highest learning rate.
    pub rate: f64,
    /// Its course.
    pub schedule: Schedule,
    /// How weights follow from gradients.
    pub optimiser: Optimiser,
    /// Weight decay, per unit of learning rate.
    pub decay: f64,
    /// Seed of first weights and of the order of samples.
    pub seed: u64,
    /// Threads; the result does not depend on them. `None`: all cores.
    pub threads: Option<usize>,
    /// Ends the run as soon as the validation nMSE is this low.
    pub goal: Option<f64>,
}

/// Where settings come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Recipe {
    /// Table 1 of the paper: Adam at a constant rate of 1e-4 for 2,500 epochs.
    Paper,
    /// Ours: SOAP with a cosine schedule, quantities scaled to the data; converges some hundred times quicker.
    #[default]
    Ours,
    /// Ours for five times as long.
    Thorough,
}

/// What a run calculates with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Precision {
    /// Single precision: twice as fast, and as accurate on measured data.
    #[default]
    F32,
    /// Double precision.
    F64,
}

impl Options {
    /// Table 1 of the paper.
    pub fn paper() -> Self {
        Options {
            epochs: 2500,
            batch: 512,
            rate: 1e-4,
            schedule: Schedule::Constant,
            optimiser: Optimiser::ADAM_W,
            decay: 1e-5,
            seed: 0,
            threads: None,
            goal: None,
        }
    }

    /// Ours: some 10 s for 80,000 samples on two cores, a second for 10,000.
    pub fn ours() -> Self {
        Options {
            epochs: 60,
            batch: 128,
            rate: 1e-2,
            schedule: Schedule::COSINE,
            optimiser: Optimiser::SOAP,
            decay: 0.0,
            seed: 0,
            threads: None,
            goal: None,
        }
    }

    /// Ours when half a minute is no matter: as far as single precision goes on noise-free data. A slower mean of squares suits the
    /// slower rate.
    pub fn thorough() -> Self {
        Options {
            epochs: 290,
            rate: 6e-3,
            schedule: Schedule::Cosine { warm_up: 0.1 },
            optimiser: Optimiser::Soap { beta_1: 0.95, beta_2: 0.97, refresh: 30 },
            ..Options::ours()
        }
    }

    /// These options without what does not change the course of a run: threads, goal and, at a constant rate, the number of
    /// epochs.
    pub(super) fn course(&self) -> Self {
        let epochs = if self.schedule == Schedule::Constant { 0 } else { self.epochs };
        Options { threads: None, goal: None, epochs, ..self.clone() }
    }

    /// The learning rate of the last step of an epoch, counted from 1, in which the weights are changed `batches` times.
    pub fn rate_in(&self, epoch: u64, batches: u64) -> f64 {
        let step = (epoch * batches).saturating_sub(1);
        self.rate * self.schedule.factor(step, self.epochs * batches)
    }

    /// Checks that the settings can be used.
    ///
    /// # Errors
    /// [`TrainError::Option`] names the first that can't.
    pub fn check(&self) -> Result<(), TrainError> {
        let demands = [
            ("the learning rate", self.rate, self.rate > 0.0 && self.rate <= 10.0, "above 0 and at most 10"),
            ("the weight decay", self.decay, (0.0..=10.0).contains(&self.decay), "between 0 and 10"),
            ("the number of epochs", self.epochs as f64, self.epochs > 0, "at least 1"),
            ("the batch", self.batch as f64, (1..=1 << 20).contains(&self.batch), "between 1 and 1048576 samples"),
            ("the number of threads", self.threads.unwrap_or(1) as f64, self.threads != Some(0), "at least 1"),
        ];
        for (option, value, met, must) in demands {
            if !met {
                return Err(TrainError::Option { option, value, must });
            }
        }
        Ok(())
    }
}

impl Recipe {
    /// The options of this recipe.
    pub fn options(self) -> Options {
        match self {
            Recipe::Paper => Options::paper(),
            Recipe::Ours => Options::ours(),
            Recipe::Thorough => Options::thorough(),
        }
    }

    /// Whether quantities are scaled to the data; the paper takes them as they are.
    pub fn normalises(self) -> bool {
        self != Recipe::Paper
    }

    /// How positions enter the networks of a preset; `None`: as suits the arm.
    pub fn features(self) -> Option<Features> {
        (self == Recipe::Paper).then_some(Features::CosSin)
    }

    /// Hidden layers of the networks of a preset: as wide as the paper's. Ours are softplus, which bends less than tanh where there was
    /// nothing to learn from: few runs of a real or simulated arm leave most of its configurations unseen (RESULTS, "Trainings that
    /// get stuck").
    pub fn layers(self) -> Layers {
        let activation = if self == Recipe::Paper { Activation::Tanh } else { Activation::Softplus };
        Layers { activation, ..Layers::default() }
    }

    /// The architecture of a preset for these data; ours is scaled to them.
    pub fn architecture<E: Element>(self, preset: LearnedPreset, joints: usize, samples: &Samples<E>) -> Architecture {
        let mut architecture = preset.architecture(joints, &self.layers());
        if self.normalises() {
            scale_to(&mut architecture, samples);
        }
        architecture
    }
}

/// Scales an architecture so that its networks see and give numbers about 1, and so that the diagonal of H may be as small as light
/// joints need.
pub fn scale_to<E: Element>(architecture: &mut Architecture, samples: &Samples<E>) {
    let n = architecture.joints;
    let mean_squares = |channel: usize| -> Vec<f64> {
        let mean_square = |joint| {
            let (mean, variance) = samples.mean_and_variance(channel, joint);
            mean * mean + variance
        };
        (0..n).map(mean_square).collect()
    };
    let typical = |mean_squares: &[f64]| {
        let size = (mean_squares.iter().sum::<f64>() / n as f64).sqrt();
        if size > 0.0 && size.is_finite() { size } else { 1.0 }
    };
    let [velocities, accelerations, torques] = [1, 2, 3].map(mean_squares);
    let [velocity, acceleration, torque] = [&velocities, &accelerations, &torques].map(|squares| typical(squares));
    let is_lagrangian = architecture.terms.iter().any(LearnedTerm::is_lagrangian);
    let joints = if is_lagrangian { weights(&torques) } else { Vec::new() };
    // Of a slow arm gravity makes the torque, which says nothing of its inertia.
    architecture.scales =
        Scales { velocity, acceleration, torque, inertia: Some(torque / acceleration.max(1.0)), joints };
    for term in &mut architecture.terms {
        if let LearnedTerm::StructuredLagrangian { positive: Some(positive), .. } = term {
            *positive = Positive { shift: 0.0, floor: 1e-3, inertia: 0.0 };
        }
    }
}

/// How much each joint weighs in the energy ([`Scales::joints`]), by the mean square of its torque.
fn weights(mean_squares: &[f64]) -> Vec<f64> {
    let sizes: Vec<f64> = mean_squares.iter().map(|square| square.sqrt()).collect();
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    let weight = |size: f64| (size / largest).powf(WEIGHT_BY_TORQUE).max(LEAST_WEIGHT);
    sizes.into_iter().map(|size| if largest > 0.0 { weight(size) } else { 1.0 }).collect()
}
