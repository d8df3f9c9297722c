//! A recording as files: as one where its form holds several runs, or as a folder with a CSV of each.

use std::path::{Path, PathBuf};

use super::files::Files;
use crate::recording::Recording;
use crate::recording::write::{self, Form, UnknownForm, WriteError};

/// A recording can't be made into files.
#[derive(Debug, thiserror::Error)]
pub enum RecordedError {
    /// The ending of the path names no form.
    #[error("{0}, or name a folder")]
    Form(#[from] UnknownForm),
    /// One CSV can't hold it.
    #[error("{problem}; for a CSV of each run name a folder, such as -o {folder}", folder = folder.display())]
    SeveralRuns {
        /// Why.
        problem: WriteError,
        /// What could be named.
        folder: PathBuf,
    },
    /// It can't be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// A recording as the ending of the path says; without one, a folder with a CSV of each run.
///
/// # Errors
/// [`RecordedError`] if it says nothing that is known, or the recording has several runs and the path names one CSV.
pub fn files(recording: &Recording, path: &Path) -> Result<Files, RecordedError> {
    // What is there and no folder, such as a pipe, holds one file.
    let is_one = path.extension().is_none() && path.exists() && !path.is_dir();
    match Form::of(path)?.or(is_one.then_some(Form::Npz)) {
        Some(form) => match write::to_bytes(recording, form) {
            Err(problem @ WriteError::SeveralRuns(_)) => {
                Err(RecordedError::SeveralRuns { problem, folder: path.with_extension("") })
            }
            bytes => Ok(Files::one(path, bytes?)),
        },
        None => {
            let runs = recording.trajectories.iter();
            Ok(Files::within(path, runs.map(|run| (file_name(&run.name), write::to_csv_bytes(run)))))
        }
    }
}

/// What of the recording files at this path don't hold, in words; empty if they hold all.
pub fn lacks(path: &Path) -> &'static str {
    Form::of(path).ok().flatten().unwrap_or(Form::Csv).lacks()
}

/// The file of a run: its name without what names of files can't have.
fn file_name(run: &str) -> String {
    let kept = |letter: char| if letter.is_alphanumeric() || "-_.#".contains(letter) { letter } else { '-' };
    format!("{}.csv", run.chars().map(kept).collect::<String>())
}
