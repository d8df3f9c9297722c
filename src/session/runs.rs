//! Training runs: saved to a file while they go on, read to be resumed.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::file;
use crate::progress::{Event, Monitor};
use crate::training::TrainError;
use crate::training::fit::SavedRun;

/// How often a running training is saved.
const SAVE_EVERY: Duration = Duration::from_secs(5);

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

/// Saves a running training now and then. Where that fails (the disk is full, a folder was taken away) the training goes on: its
/// model is worth more than its checkpoint. It is said once, and tried again.
pub(super) struct Keeper<'a> {
    path: Option<&'a Path>,
    last: Option<Instant>,
    failed: bool,
}

impl<'a> Keeper<'a> {
    /// Keeps a training in this file, if any.
    ///
    /// # Errors
    /// [`RunFileError::Write`] if it has no folder: that is a mistake, and better told before the training than in it.
    pub fn new(path: Option<&'a Path>) -> Result<Self, RunFileError> {
        let folder = path.and_then(Path::parent).filter(|folder| !folder.as_os_str().is_empty());
        if let (Some(path), Some(folder)) = (path, folder)
            && !folder.is_dir()
        {
            let error = std::io::Error::other("there is no such folder");
            return Err(RunFileError::Write { path: path.to_owned(), error });
        }
        Ok(Keeper { path, last: None, failed: false })
    }

    /// After an epoch.
    pub fn epoch(&mut self, run: &dyn Fn() -> SavedRun, monitor: &Monitor) {
        if self.path.is_some() && self.last.is_none_or(|last| last.elapsed() >= SAVE_EVERY) {
            self.last = Some(Instant::now());
            self.save(&run(), monitor);
        }
    }

    /// At the end.
    pub fn end(&mut self, run: &SavedRun, monitor: &Monitor) {
        self.save(run, monitor);
    }

    fn save(&mut self, run: &SavedRun, monitor: &Monitor) {
        let Some(path) = self.path else { return };
        let told = match (save(run, path), self.failed) {
            (Err(error), false) => format!("{error}. The training goes on, and this is tried again"),
            (Ok(()), true) => format!("the checkpoint {} is written again", path.display()),
            (result, _) => {
                self.failed = result.is_err();
                return;
            }
        };
        self.failed = !self.failed;
        monitor.tell(Event::Warning(told));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::learned::{Layers, LearnedPreset};
    use crate::session::{Command, Session};
    use crate::simulation::{Excitation, Scenario};
    use crate::training::fit::Plan;
    use crate::training::{Ending, Options};

    fn warnings(monitor: &Monitor) -> Vec<String> {
        let text = |event| if let Event::Warning(text) = event { Some(text) } else { None };
        monitor.take_events().into_iter().filter_map(text).collect()
    }

    /// A short training that keeps itself in a file.
    fn trained(checkpoint_file: &Path, monitor: &Monitor) -> Session {
        let motion = Excitation::PaperPointToPoint { trajectories: 6, duration: 4.0, samples: 80, range: 2.0 };
        let simulate = Command::Simulate(Box::new(Scenario { motion, ..Scenario::embedded() }));
        let session = simulate.run(&Session::default(), &Monitor::new()).unwrap();
        let options = Options { epochs: 3, batch: 20, ..Options::ours() };
        let plan = Plan { options, layers: Layers { hidden: vec![4], ..Layers::default() }, ..Plan::default() };
        let train = Command::TrainPreset { preset: LearnedPreset::FfNn, plan: Box::new(plan) };
        train.run(&Session { checkpoint_file: Some(checkpoint_file.to_owned()), ..session }, monitor).unwrap()
    }

    /// The device that is always full.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_training_survives_a_full_disk() {
        let monitor = Monitor::new();
        let session = trained(Path::new("/dev/full"), &monitor);
        let step = session.current().unwrap();
        assert_eq!((&step.ending, step.history.len()), (&Some(Ending::Finished), 3));
        let told = warnings(&monitor);
        assert!(told.len() == 1 && told[0].contains("can't write the checkpoint /dev/full"), "{told:?}");
    }

    #[test]
    fn a_checkpoint_that_fails_is_told_once_and_tried_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.npz");
        let session = trained(&path, &Monitor::new());
        let run = session.current().unwrap().run.as_ref().unwrap();
        assert_eq!(load(&path).unwrap(), **run);
        let monitor = Monitor::new();
        let mut keeper = Keeper::new(Some(&path)).unwrap();
        std::fs::remove_dir_all(folder.path()).unwrap();
        (0..2).for_each(|_| keeper.end(run, &monitor));
        assert!(matches!(warnings(&monitor).as_slice(), [told] if told.contains("is tried again")));
        std::fs::create_dir(folder.path()).unwrap();
        (0..2).for_each(|_| keeper.end(run, &monitor));
        assert!(matches!(warnings(&monitor).as_slice(), [told] if told.contains("is written again")));
        assert_eq!(load(&path).unwrap(), **run);
        assert!(Keeper::new(Some(&folder.path().join("no/such/folder"))).is_err());
    }
}
