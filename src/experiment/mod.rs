//! Experiments: data × models × seeds, measured on test sets that leave the training data, and held against the paper.
//!
//! [`mod@file`] reads an experiment (TOML; those of the paper are in [`catalogue`]) → [`cell`] resolves it into cells, each with a
//! key that is the hash of all its inputs → [`mod@run`] trains and measures the cells that the [`store`] lacks, beside any number of
//! other processes on the same folder → [`summary`] joins what the store holds into means, intervals and the paper's values, and [`figures`] draws it.

pub mod catalogue;
pub mod cell;
pub mod figures;
pub mod file;
pub mod metrics;
pub mod run;
pub mod store;
pub mod summary;

use std::path::PathBuf;

use crate::effect::place::PlaceError;
use crate::effect::registry::UnknownEffect;
use crate::model::ModelError;
use crate::progress::Stopped;
use crate::recording::read::ReadError;
use crate::signals::ShapeError;
use crate::simulation::SimulationError;
use crate::training::TrainError;

pub use cell::{Cell, plan};
pub use file::Experiment;
pub use run::{Report, Shard, run};
pub use store::Store;
pub use summary::{Curve, Row, summarise};

/// An experiment can't be read, run or joined.
#[derive(Debug, thiserror::Error)]
pub enum ExperimentError {
    /// The file is not an experiment.
    #[error("{file}: {problem}")]
    File {
        /// Its name.
        file: String,
        /// What is wrong, on which line, and what is possible there.
        problem: String,
    },
    /// Predictions of different arms.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// No experiment of this name is built in.
    #[error("there is no experiment `{name}`; built in: {known}, or give a TOML file")]
    Unknown {
        /// What was asked for.
        name: String,
        /// What there is.
        known: String,
    },
    /// Recordings are needed, and nobody said where they are.
    #[error(
        "this experiment needs recordings that do not come with the program ({files}): give their folder with --data"
    )]
    NoData {
        /// The files that it asks for.
        files: String,
    },
    /// A file that was asked for holds fewer runs.
    #[error("{file} has {runs} runs, but the experiment takes runs {first} to {last} of it: choose others")]
    NoSuchRuns {
        /// Its name.
        file: String,
        /// How many it has.
        runs: usize,
        /// Counted from 0.
        first: usize,
        /// Counted from 0.
        last: usize,
    },
    /// The folder of results can't be used.
    #[error("{path}: {problem}; check the folder and its permissions", path = path.display())]
    Store {
        /// Which path.
        path: PathBuf,
        /// What the system says.
        problem: std::io::Error,
    },
    /// A result in the folder is not one.
    #[error("{path} is damaged ({problem}): run the experiment, and it is done anew", path = path.display())]
    Damaged {
        /// Which file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// Training could not go on.
    #[error("training ended: {0}")]
    TrainingFailed(String),
    /// A model or its test set gives no numbers.
    #[error("the error on `{0}` is not a finite number: the model explodes there, or the torque is zero")]
    NotFinite(String),
    /// A recording can't be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A scenario can't be simulated.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// There is no such effect.
    #[error(transparent)]
    UnknownEffect(#[from] UnknownEffect),
    /// An effect of a model is to act where it can't.
    #[error(transparent)]
    Place(#[from] PlaceError),
    /// A model does not fit the data.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A network can't be trained.
    #[error(transparent)]
    Train(#[from] TrainError),
    /// Somebody stopped it.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl ExperimentError {
    /// Whether the work was stopped, rather than failed.
    pub fn is_stop(&self) -> bool {
        matches!(
            self,
            ExperimentError::Stopped(_)
                | ExperimentError::Read(ReadError::Stopped(_))
                | ExperimentError::Simulation(SimulationError::Stopped(_))
                | ExperimentError::Model(ModelError::Stopped(_))
                | ExperimentError::Train(TrainError::Stopped(_))
        )
    }
}
