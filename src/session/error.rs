//! Why a command could not be carried out, or a session not be saved or opened.

use std::path::PathBuf;

use super::runs::RunFileError;
use crate::effect::own::OwnEffectError;
use crate::effect::registry::UnknownEffect;
use crate::model::ModelError;
use crate::progress::Stopped;
use crate::recording::correction::CorrectionError;
use crate::recording::read::ReadError;
use crate::recording::seal::SealError;
use crate::recording::split::SplitError;
use crate::recording::write::WriteError;
use crate::simulation::SimulationError;
use crate::simulation::extrapolation::ExtrapolationError;
use crate::training::TrainError;

/// A command could not be carried out; the session stays as it was.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// Nothing is loaded.
    #[error("there is no recording: open a file or simulate one first")]
    NoRecording,
    /// What was to be set right does not fit the recording.
    #[error("what is to be set right: {0}")]
    Correction(#[from] CorrectionError),
    /// Nothing was fitted.
    #[error("there is no model yet: choose a preset first")]
    NoModel,
    /// The current model has no networks.
    #[error(
        "the current model is identified by least squares, there is nothing to train: choose a preset with networks"
    )]
    NothingToTrain,
    /// The run could not go on.
    #[error("training ended: {0}. If that does not help, look for faults in the data")]
    TrainingFailed(String),
    /// The recording has no seal.
    #[error("this recording has no sealed truth: only simulated recordings have one")]
    NoSeal,
    /// A bet can't be changed.
    #[error("a bet on this model is placed already, and stays as it is")]
    BetPlaced,
    /// No lesson was begun.
    #[error("no lesson is taken in this session: begin one first")]
    NoLesson,
    /// The lesson keeps it shut until later.
    #[error("the lesson keeps {0} locked in this step: go on in the lesson first")]
    Locked(&'static str),
    /// The ladder has no such step.
    #[error("the ladder has {count} steps, there is no step {step}")]
    NoSuchStep {
        /// Counted from 1.
        step: usize,
        /// How many there are.
        count: usize,
    },
    /// The current model, or what was switched off of it, has no such term.
    #[error("the model has no such term: choose one of its {count}")]
    NoSuchTerm {
        /// How many there are.
        count: usize,
    },
    /// The base of the model is not an effect.
    #[error("{0} is what the model starts from: choose another preset instead of taking it out")]
    Base(String),
    /// Terms of a trained model were to be reordered.
    #[error("the order of a trained model's terms is fixed by its networks: reorder the terms of a rigid body")]
    FixedOrder,
    /// The session has no model of this name.
    #[error("there is no model “{asked}” in this session; there are: {known}")]
    NoSuchModel {
        /// What was asked for.
        asked: String,
        /// What there is.
        known: String,
    },
    /// A name that is none, or too long.
    #[error("a model's name has 1 to {longest} letters")]
    BadName {
        /// So many letters at most.
        longest: usize,
    },
    /// What was to be looked at is of another arm.
    #[error(
        "the joints of the other recording are moved by {has}, those of this one by {needs}: only the same arm can stand beside it"
    )]
    OtherJoints {
        /// By joint.
        has: String,
        /// By joint.
        needs: String,
    },
    /// Two models can't have the same name.
    #[error("another model has that name already: {0}")]
    NameTaken(String),
    /// The ladder stands on this model.
    #[error("{0} is a step of the ladder: use another model first, or go back to the step before it")]
    OnTheLadder(String),
    /// The current model has the effect already.
    #[error("the model has {0} already")]
    AlreadyThere(String),
    /// The base parameters or other terms can take the effect's place.
    #[error(
        "{0} can't be told apart from the rest of the model with these data: state the arm's masses and lengths, or record \
         motion that separates them"
    )]
    Absorbed(String),
    /// A joint effect without a joint.
    #[error("name at least one joint for {0}")]
    NoJoint(String),
    /// There is no such effect.
    #[error(transparent)]
    UnknownEffect(#[from] UnknownEffect),
    /// The file of an effect can't be read.
    #[error("can't read the effect {path}: {problem}", path = path.display())]
    EffectFile {
        /// Which file.
        path: PathBuf,
        /// What the system says.
        problem: std::io::Error,
    },
    /// The file of an effect says something that can't be.
    #[error("{path}: {problem}", path = path.display())]
    OwnEffect {
        /// Which file.
        path: PathBuf,
        /// What is wrong, and where.
        problem: OwnEffectError,
    },
    /// A proposal can't be an effect.
    #[error("the proposal can't be adopted: {0}")]
    Adoption(OwnEffectError),
    /// There is no such proposal.
    #[error("there are {count} proposals, there is no proposal {number}: ask first what the remainder depends on")]
    NoSuchProposal {
        /// Counted from 1.
        number: usize,
        /// How many there are.
        count: usize,
    },
    /// A file can't be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The recording can't be split as asked.
    #[error(transparent)]
    Split(#[from] SplitError),
    /// The scenario can't be simulated.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The model does not fit the recording.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Training can't begin.
    #[error(transparent)]
    Train(#[from] TrainError),
    /// The error outside the data can't be computed.
    #[error(transparent)]
    Extrapolation(#[from] ExtrapolationError),
    /// A checkpoint can't be kept.
    #[error(transparent)]
    RunFile(#[from] RunFileError),
    /// The session can't be opened.
    #[error(transparent)]
    File(#[from] SessionFileError),
    /// The seal is damaged.
    #[error(transparent)]
    Seal(#[from] SealError),
    /// Stopped by the user.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// A session can't be saved or opened.
#[derive(Debug, thiserror::Error)]
pub enum SessionFileError {
    /// There is nothing to save.
    #[error("there is no recording yet, so there is nothing to save")]
    Empty,
    /// The file system refuses.
    #[error("{path}: {problem}. Check the folder, its permissions and the free space", path = path.display())]
    File {
        /// Which file.
        path: PathBuf,
        /// What the system says.
        problem: std::io::Error,
    },
    /// Not a session.
    #[error("this is not a session ({0}): choose a file that was saved by this program")]
    Damaged(String),
    /// It can't be opened, but what it was before can.
    #[error("{problem}. What it was before can be opened: {left}", left = left.display())]
    Left {
        /// What is wrong with it.
        problem: Box<SessionFileError>,
        /// What is whole beside it.
        left: PathBuf,
    },
    /// Another version.
    #[error(
        "the session has version {version}, this program reads up to version {newest}: use the program that saved it"
    )]
    Version {
        /// Of the file.
        version: u64,
        /// The newest that can be read.
        newest: u32,
    },
    /// The recording can't be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The recording can't be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A model can't be read or written.
    #[error(transparent)]
    Train(#[from] TrainError),
    /// A model does not fit the recording.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The seal is damaged.
    #[error(transparent)]
    Seal(#[from] SealError),
    /// An effect of one's own that it brings along.
    #[error("an effect of one's own in the session: {0}")]
    OwnEffect(#[from] OwnEffectError),
    /// Stopped by the user.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}
