//! A model that was saved: alone in a file of its own, or with others in a session.

use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, anyhow};
use clap::Args;

use super::failure::OrUsage;
use super::progress;
use crate::file;
use crate::model::Fitted;
use crate::recording::Recording;
use crate::session::{Command, Session, SessionError, file::is_session};
use crate::training;

/// Which model of a saved session.
#[derive(Args, Debug, Clone)]
pub struct Of {
    /// Of a saved session (.torquescope): this one of its models, by name; without it the current one.
    #[arg(long, value_name = "NAME")]
    of: Option<String>,
}

/// A model that was saved.
pub struct Saved {
    /// The model.
    pub fitted: Fitted,
    /// What it was fitted to, if that was saved with it.
    pub recording: Option<Arc<Recording>>,
}

impl Of {
    /// Reads a model that `train` saved, or one of a session that the window saved.
    pub fn read(&self, path: &Path) -> anyhow::Result<Saved> {
        if !is_session(path) {
            self.refuse_without_session()?;
            let bytes = file::read(path, file::LARGEST_MODEL)
                .with_context(|| format!("can't read {}", path.display()))
                .or_usage()?;
            let fitted = training::fit::from_bytes(&bytes).with_context(|| path.display().to_string()).or_usage()?;
            return Ok(Saved { fitted, recording: None });
        }
        let restore = Command::Restore { path: path.to_owned() };
        let session = self.taken_up(&progress::run(restore, &Session::default()).or_usage()?)?;
        let step = session.current().ok_or(SessionError::NoModel).with_context(|| path.display().to_string());
        Ok(Saved { fitted: step.or_usage()?.fitted.clone(), recording: session.recording.clone() })
    }

    /// The session with the model that was named as its current one.
    pub fn taken_up(&self, session: &Session) -> anyhow::Result<Session> {
        match &self.of {
            Some(name) => progress::run(Command::TakeUp { name: name.clone() }, session).or_usage(),
            None => Ok(session.clone()),
        }
    }

    /// Nothing else has models to choose from.
    pub fn refuse_without_session(&self) -> anyhow::Result<()> {
        match &self.of {
            Some(name) => Err(anyhow!(
                "--of {name} names a model of a saved session (.torquescope), and none is given: leave it out, or name the session"
            ))
            .or_usage(),
            None => Ok(()),
        }
    }
}
