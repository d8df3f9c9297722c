//! A bet: what somebody thinks is missing, said before the answer is shown. What was said stays said.

use serde::{Deserialize, Serialize};

use super::Session;
use super::error::SessionError;
use crate::model::Model;

/// What is thought to be missing.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Guess {
    /// Nothing.
    Nothing,
    /// None of the effects that are known.
    Unknown,
    /// An effect, by its id in the registry.
    Effect(String),
}

/// A guess that was placed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bet {
    /// What it was said of: asked once, whatever is undone or trained anew.
    pub model: Model,
    /// What was said.
    pub guess: Guess,
}

/// The bets of a recording.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bets {
    /// Whether the answer is hidden until one has guessed.
    pub first: bool,
    /// What was guessed so far.
    pub placed: Vec<Bet>,
}

impl Session {
    /// What was guessed of the current model.
    pub fn guess(&self) -> Option<&Guess> {
        let model = &self.current()?.fitted.model;
        self.bets.placed.iter().find(|bet| bet.model == *model).map(|bet| &bet.guess)
    }

    /// Whether the answer is there, and is to be kept back until one has guessed.
    pub fn withholds_answer(&self) -> bool {
        self.bets.first && self.report.is_some() && self.guess().is_none()
    }

    /// This session with a guess of its current model.
    pub(super) fn with_guess(&self, guess: &Guess) -> Result<Session, SessionError> {
        let model = self.current().ok_or(SessionError::NoModel)?.fitted.model.clone();
        if self.guess().is_some() {
            return Err(SessionError::BetPlaced);
        }
        let mut bets = self.bets.clone();
        bets.placed.push(Bet { model, guess: guess.clone() });
        Ok(Session { bets, ..self.clone() })
    }
}
