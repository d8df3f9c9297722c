//! Which experiment is shown, and where its results are.

use std::path::PathBuf;

use crate::experiment::{Experiment, ExperimentError, Store, catalogue};

/// Which experiment is shown, and where its results are.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    /// Name of a built-in experiment, or a TOML file.
    pub experiment: String,
    /// The small version.
    pub quick: bool,
    /// Folder of the results, as for the command line.
    pub results: String,
    /// Folder of the recordings, for experiments that need some.
    pub data: String,
}

impl Default for Shown {
    fn default() -> Self {
        let (experiment, results) = (catalogue::ALL[0].0.to_owned(), "experiments".to_owned());
        Shown { experiment, quick: true, results, data: String::new() }
    }
}

impl Shown {
    /// The experiment itself.
    ///
    /// # Errors
    /// [`ExperimentError`] if there is none of this name, or its file can't be read.
    pub fn open(&self) -> Result<Experiment, ExperimentError> {
        let whole = catalogue::open(&self.experiment)?;
        Ok(if self.quick { whole.quick() } else { whole })
    }

    /// Its results.
    pub fn store(&self) -> Store {
        Store::new(self.results.trim())
    }

    /// Its recordings, if it needs some.
    pub fn data(&self) -> Option<PathBuf> {
        Some(self.data.trim()).filter(|path| !path.is_empty()).map(PathBuf::from)
    }
}
