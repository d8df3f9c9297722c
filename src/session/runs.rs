//! Training runs: kept side by side, saved to a file while they go on, taken up again.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::{Session, Step};
use crate::file;
use crate::model::Preset;
use crate::training::TrainError;
use crate::training::fit::SavedRun;

/// How often a running training is saved.
const SAVE_EVERY: Duration = Duration::from_secs(5);

/// A training of this recording, to be compared with others and taken as the model.
#[derive(Debug, Clone)]
pub struct TrainedRun {
    /// What its ladder started from.
    pub preset: Preset,
    /// The ladder with its model as the last step.
    pub ladder: Vec<Arc<Step>>,
}

impl TrainedRun {
    /// The trained model.
    pub fn step(&self) -> Option<&Arc<Step>> {
        self.ladder.last()
    }
}

/// A file that can't be read or written, or is no run.
#[derive(Debug, thiserror::Error)]
pub enum RunFileError {
    /// Not read.
    #[error("can't read the checkpoint {}: {error}", path.display())]
    Read {
        /// Which file.
        path: PathBuf,
        /// What the system says.
        error: std::io::Error,
    },
    /// Not written.
    #[error("can't write the checkpoint {}: {error}. Check the folder and its permissions", path.display())]
    Write {
        /// Which file.
        path: PathBuf,
        /// What the system says.
        error: std::io::Error,
    },
    /// Not a run.
    #[error("{}: {error}", path.display())]
    Content {
        /// Which file.
        path: PathBuf,
        /// What is wrong with it.
        error: TrainError,
    },
}

/// Reads a run that [`save`] wrote.
///
/// # Errors
/// [`RunFileError`]
pub fn load(path: &Path) -> Result<SavedRun, RunFileError> {
    let bytes =
        file::read(path, file::LARGEST_MODEL).map_err(|error| RunFileError::Read { path: path.to_owned(), error })?;
    SavedRun::from_bytes(&bytes).map_err(|error| RunFileError::Content { path: path.to_owned(), error })
}

/// Writes a run, in the place of the one that was there.
///
/// # Errors
/// [`RunFileError`]
pub fn save(run: &SavedRun, path: &Path) -> Result<(), RunFileError> {
    let bytes = run.to_bytes().map_err(|error| RunFileError::Content { path: path.to_owned(), error })?;
    file::write(path, &bytes).map_err(|error| RunFileError::Write { path: path.to_owned(), error })
}

/// Saves a running training now and then.
pub(super) struct Keeper<'a> {
    path: Option<&'a Path>,
    last: Option<Instant>,
}

impl<'a> Keeper<'a> {
    pub fn new(path: Option<&'a Path>) -> Self {
        Keeper { path, last: None }
    }

    /// After an epoch.
    pub fn epoch(&mut self, run: &dyn Fn() -> SavedRun) -> Result<(), RunFileError> {
        match self.path {
            Some(path) if self.last.is_none_or(|last| last.elapsed() >= SAVE_EVERY) => {
                self.last = Some(Instant::now());
                save(&run(), path)
            }
            _ => Ok(()),
        }
    }

    /// At the end.
    pub fn end(&self, run: &SavedRun) -> Result<(), RunFileError> {
        self.path.map_or(Ok(()), |path| save(run, path))
    }
}

impl Session {
    /// This session with the training of its current model in the list of runs.
    pub(super) fn remembering_its_run(mut self) -> Self {
        let is_new = |step: &Arc<Step>| {
            let mut known = self.runs.iter().filter_map(TrainedRun::step);
            step.run.is_some() && !known.any(|known| known.generation == step.generation)
        };
        if self.current().is_some_and(is_new) {
            self.runs.push(TrainedRun { preset: self.preset, ladder: self.ladder.clone() });
        }
        self
    }
}
