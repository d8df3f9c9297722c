//! Learning: loss, optimisers, schedules, the training run with its stop rules, checkpoints, and what a trained model says.
//!
//! [`mod@fit`] trains a model of the session; inside it
//! [`data`] (samples, checked) → [`learn`] (a run: [`loss`], [`optimiser`], [`schedule`]) → [`learned::LearnedModel`] → [`predict`]
//! (torque and components), which [`inside`], [`friction`] and [`rollout`] look into; `restart` begins anew what got stuck. [`options`] holds the two recipes, the paper's and ours.

mod components;
pub mod data;
pub mod effects;
pub mod fit;
pub mod friction;
pub mod inside;
pub mod learn;
pub mod learned;
pub mod loss;
pub mod optimiser;
pub mod options;
pub mod predict;
mod restart;
pub mod rollout;
pub mod schedule;

use crate::model::learned::ArchitectureError;
use crate::signals::ShapeError;

pub use components::components;
pub use data::Samples;
pub use learn::{Ending, Outcome, TrainingData, train};
pub use learned::LearnedModel;
pub use options::{Options, Precision, Recipe};
pub use restart::OtherStart;

/// Training can't start.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TrainError {
    /// Model and data disagree.
    #[error(
        "the model has {model} joints, but trajectory `{name}` has {data}: map the same joints or choose another model"
    )]
    JointCount {
        /// Of the model.
        model: usize,
        /// Of the data.
        data: usize,
        /// Of the trajectory.
        name: String,
    },
    /// A channel is missing or too short.
    #[error("trajectory `{name}` lacks a channel (q, q̇, q̈, τ or an effect): derive or map it first")]
    Incomplete {
        /// Of the trajectory.
        name: String,
    },
    /// Parts of a motion that do not fit together.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// A gap in the data.
    #[error("the {channel} of trajectory `{name}` is not a number at t = {time} s: cut out or repair that part")]
    NotANumber {
        /// Which channel.
        channel: &'static str,
        /// Of the trajectory.
        name: String,
        /// When \[s\].
        time: f64,
    },
    /// A torque that never changes.
    #[error(
        "the torque of joint {joint} is always {value} N m (N where it slides), so there is nothing to learn: leave the joint out"
    )]
    ConstantTorque {
        /// Counted from 1.
        joint: usize,
        /// Its value.
        value: f64,
    },
    /// Fewer samples than a batch.
    #[error("{samples} samples are fewer than a batch of {batch}: choose a batch of at most {samples}")]
    TooFewSamples {
        /// There are.
        samples: usize,
        /// Asked for.
        batch: usize,
    },
    /// An option out of its range.
    #[error("{option} is {value}, but must be {must}")]
    Option {
        /// Which.
        option: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        must: &'static str,
    },
    /// An architecture that can't be built.
    #[error(transparent)]
    Architecture(#[from] ArchitectureError),
    /// A checkpoint of something else.
    #[error(
        "the checkpoint is of another {what}: it has {checkpoint}, this run {run}. Train anew, or choose what it has"
    )]
    OtherCheckpoint {
        /// What differs.
        what: String,
        /// In the checkpoint.
        checkpoint: String,
        /// In this run.
        run: String,
    },
    /// Bytes that are not a checkpoint or model.
    #[error("this is not a trained model or checkpoint ({0}): choose a file that was saved by training")]
    Damaged(String),
    /// A checkpoint where a model is expected, or the other way round.
    #[error("this is {is}, but {needed} is needed: `train` saves models with --output, checkpoints with --checkpoint")]
    OtherFile {
        /// What the file is.
        is: &'static str,
        /// What was expected.
        needed: &'static str,
    },
    /// Nothing is long enough to be simulated.
    #[error(
        "no part of the data that is held out lasts {} s without a gap, so nothing can be simulated: hold out longer runs",
        rollout::HORIZON
    )]
    TooShort,
    /// The model of the session can't be trained on this recording.
    #[error("{0}")]
    Model(String),
    /// Somebody stopped it.
    #[error(transparent)]
    Stopped(#[from] crate::progress::Stopped),
    /// The model has effect columns, but the data brings another number of them.
    #[error("the model has {model} effect columns, the data has {data}: compute the columns of the same effects")]
    ColumnCount {
        /// Of the model.
        model: usize,
        /// Of the data.
        data: usize,
    },
}
