//! Trials: the diagnosis answers where the truth is known, and is judged by it.
//!
//! | truth | who made it | judged by |
//! |---|---|---|
//! | [`blind`] | a seed hides effects of the catalogue in a recording that is simulated | [`rates`]: all of them and nothing else |
//! | [`world`] | a seed draws an arm of rigid bodies that a servo moves, and what is in its drives and joints | [`verdict`] on each name |
//! | [`foreign`] | recordings of other engines, with a file that says what is in each | [`verdict`] on each name; a form of the right effect is told apart from a false one |
//! | [`planted`] | a seed plants effects into a log of a real arm, or into a twin of it whose truth is known | [`verdict`] on each name; what was named before anything was planted counts neither way |
//! | [`stability`] | nobody: the same log is cut, thinned out and filtered in other ways | whether a name is given again |
//!
//! [`calibration`] learns from the same truths how sure a diagnosis may be.
//!
//! The diagnosis sees recordings only; the truth is looked at when it has spoken. Everything here is data: commands word it, tests
//! read it.

pub mod blind;
pub mod calibration;
pub mod foreign;
pub mod kin;
pub mod planted;
pub mod rates;
pub mod stability;
pub mod verdict;
pub mod world;

use std::collections::BTreeSet;

use crate::diagnosis::MissingEffect;
use crate::model::ModelError;
use crate::progress::Stopped;
use crate::recording::read::ReadError;
use crate::recording::seal::SealError;
use crate::recording::split::SplitError;
use crate::simulation::SimulationError;

/// Effects with the places where they act: a joint from 0, or `None` for the whole arm.
pub type Answer = BTreeSet<(String, Option<usize>)>;

/// An effect that was named, at each of its places.
pub fn answer_of(named: &MissingEffect) -> Answer {
    named.places().into_iter().map(|place| (named.effect.id.to_owned(), place)).collect()
}

/// A trial can't be held.
#[derive(Debug, thiserror::Error)]
pub enum TrialError {
    /// The truth of a recording can't be read.
    #[error("{file} does not say what is hidden in its recording: {problem}")]
    Truth {
        /// Its name.
        file: String,
        /// What is wrong with it.
        problem: serde_json::Error,
    },
    /// A recording can't be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A recording can't be simulated.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// It can't be held out as the diagnosis advised.
    #[error(transparent)]
    Split(#[from] SplitError),
    /// The model does not fit, or the diagnosis fails.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The seal is damaged.
    #[error(transparent)]
    Seal(#[from] SealError),
    /// A log that nothing can be planted into.
    #[error(
        "none of {tries} effects that were drawn could be planted into `{log}` at {percent} % of the torque: joints that hardly \
         move feel nothing, or a rigid body takes up what they feel. Record a motion that moves all joints"
    )]
    NotPlantable {
        /// Name of the recording.
        log: String,
        /// How many were tried.
        tries: usize,
        /// The strength that they were to have \[%\].
        percent: f64,
    },
    /// Somebody stopped it.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}
