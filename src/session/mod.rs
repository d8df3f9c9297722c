//! The document: a recording, a model that grows by steps, and what the diagnosis says of it.
//!
//! A [`Session`] is a value. A [`Command`] takes one and gives a new one; [`History`] keeps the old ones for undo, and a
//! [`Document`] is what a [`mod@file`] keeps of all that. Large parts are shared, so a session costs little to keep. The window and the
//! command line run the same commands.

mod again;
mod beside;
mod bet;
mod carry_out;
mod command;
mod document;
mod error;
pub mod file;
mod generation;
mod history;
mod hold_out;
mod models;
mod name;
pub mod runs;
mod seeds;
mod source;
mod step;
pub mod study;
mod terms;

use std::path::PathBuf;
use std::sync::Arc;

pub use again::again;
pub use bet::{Bet, Bets, Guess};
pub use command::Command;
pub use document::{Document, View};
pub use error::{SessionError, SessionFileError};
pub use generation::Generation;
pub use history::History;
pub use models::Kept;
pub use name::default_name;
pub use seeds::Spread;
pub use source::{Origin, Source};
pub use study::{SetUp, Study};
pub use terms::TermEdit;

use crate::diagnosis::Report;
use crate::diagnosis::proposal::Proposals;
use crate::effect::Effect;
use crate::model::{Evaluation, Fitted, Preset, Term};
use crate::progress::Epoch;
use crate::recording::Recording;
use crate::recording::finding::Finding;
use crate::recording::mapping::Mapping;
use crate::recording::seal::Truth;
use crate::recording::split::Split;
use crate::simulation::extrapolation::Sweep;
use crate::training::Ending;
use crate::training::fit::{Plan, SavedRun};
use crate::training::rollout::Rollout;

/// The document.
#[derive(Debug, Clone, Default)]
pub struct Session {
    /// Which session it is: a change makes another one, a copy is the same.
    pub generation: Generation,
    /// What was measured; `None` in an empty session.
    pub recording: Option<Arc<Recording>>,
    /// What was found at import.
    pub findings: Arc<Vec<Finding>>,
    /// Where it comes from; `None` where that can't be said in a word, as in a lesson.
    pub source: Option<Arc<Source>>,
    /// Which columns of the file are which channels; `None` for simulated recordings.
    pub mapping: Option<Arc<Mapping>>,
    /// Which part trains and which is held out.
    pub split: Split,
    /// What the ladder starts from.
    pub preset: Preset,
    /// How networks are trained.
    pub plan: Plan,
    /// Effects of one's own, which the diagnosis seeks beside those of the catalogue.
    pub own_effects: Vec<&'static Effect>,
    /// Where training saves itself while it runs, if anywhere.
    pub checkpoint_file: Option<PathBuf>,
    /// All models of this recording, the newest last.
    pub models: Vec<Kept>,
    /// The models, each with one effect more than the one before. The first is the bare preset, the last is the current
    /// model. Empty until the first fit.
    pub ladder: Vec<Arc<Step>>,
    /// Terms that were switched off; they can be switched on again.
    pub set_aside: Vec<Term>,
    /// What the diagnosis says of the current model.
    pub report: Option<Arc<Report>>,
    /// What the remainder of the current model depends on, once it was asked for.
    pub proposals: Option<Arc<Proposals>>,
    /// How the error of models grows outside the data, once it was asked for.
    pub sweep: Option<Arc<Sweep>>,
    /// The truth, once the user opened the seal.
    pub truth: Option<Arc<Truth>>,
    /// What was guessed before the answer was shown.
    pub bets: Bets,
    /// The lesson that is taken in it, if there is one.
    pub study: Option<Arc<Study>>,
}

/// One step of the ladder.
#[derive(Debug, Clone)]
pub struct Step {
    /// Which model it is, as long as the program runs.
    pub generation: Generation,
    /// What it is called, everywhere; see [`default_name`]. No two models of a session have the same.
    pub name: String,
    /// The model with all parameters identified anew.
    pub fitted: Fitted,
    /// Its errors and predictions.
    pub evaluation: Evaluation,
    /// The epochs of its training; empty if it was identified by least squares.
    pub history: Vec<Epoch>,
    /// How its training ended; `None` if it was identified by least squares.
    pub ending: Option<Ending>,
    /// How far its arm runs from the measured one, once that was asked for.
    pub rollout: Option<Rollout>,
    /// Where its training can be resumed; `None` if it was identified by least squares.
    pub run: Option<Arc<SavedRun>>,
}

impl Step {
    /// Why its training ended before its time; `None` if it did not.
    pub fn early_end(&self) -> Option<String> {
        match &self.ending {
            Some(Ending::Failed(reason) | Ending::Stopped(reason)) => Some(format!(
                "{reason}. What is kept are the best weights so far, of {} epochs",
                self.history.last().map_or(0, |epoch| epoch.epoch)
            )),
            _ => None,
        }
    }
}

impl Session {
    /// The current model.
    pub fn current(&self) -> Option<&Arc<Step>> {
        self.ladder.last()
    }

    /// Whether another session is about the same recording.
    pub fn has_recording_of(&self, other: &Session) -> bool {
        match (&self.recording, &other.recording) {
            (Some(own), Some(other)) => Arc::ptr_eq(own, other),
            (None, None) => true,
            _ => false,
        }
    }

    /// Whether another session hides the same truth.
    pub fn has_seal_of(&self, other: &Session) -> bool {
        let [own, other] = [self, other].map(|session| session.recording.as_ref()?.seal.as_ref());
        own.is_some() && own == other
    }
}
