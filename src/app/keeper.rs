//! Keeps the work: saves a session where the user asks for it, and after every change a copy that a crash can't take.

use std::path::{Path, PathBuf};

use crate::session::{Session, file};
use crate::work::{Job, Outcome};

/// Saves in the background.
#[derive(Default)]
pub struct Keeper {
    /// Where the copy is; `None` keeps none.
    copy: Option<PathBuf>,
    /// Whether a copy was found that another run left behind, and nobody has decided about yet.
    found: bool,
    running: Option<(Job<()>, PathBuf)>,
    waiting: Option<(PathBuf, Session)>,
}

/// What became of saving.
pub enum Kept {
    /// The session is in this file.
    Saved(PathBuf),
    /// It is not, and why.
    Failed(String),
}

impl Keeper {
    /// Keeps the copy in this file; one that is there already was left behind by a crash.
    pub fn with_copy(path: PathBuf) -> Self {
        Keeper { found: path.exists(), copy: Some(path), ..Keeper::default() }
    }

    /// Where the copy of this user is.
    pub fn usual_place() -> Option<PathBuf> {
        let home = || std::env::var_os("HOME").map(|home| Path::new(&home).join(".local/state"));
        let folder =
            std::env::var_os("XDG_STATE_HOME").map(PathBuf::from).filter(|path| path.is_absolute()).or_else(home)?;
        Some(folder.join("torquescope").join(format!("recovery.{}", file::ENDING)))
    }

    /// The copy that was left behind.
    pub fn left_behind(&self) -> Option<&Path> {
        self.copy.as_deref().filter(|_| self.found)
    }

    /// The user decided about the copy that was left behind.
    pub fn decided(&mut self) {
        self.found = false;
    }

    /// Saves into a file that the user chose.
    pub fn save(&mut self, path: PathBuf, session: &Session) {
        self.waiting = Some((path, session.clone()));
        self.start();
    }

    /// Saves the copy, unless one is there that nobody has decided about.
    pub fn copy(&mut self, session: &Session) {
        let Some(path) = self.copy.clone().filter(|_| !self.found && session.recording.is_some()) else { return };
        let asked = self.waiting.as_ref().is_some_and(|(waiting, _)| *waiting != path);
        // What the user asked for goes first; the next change makes a copy again.
        if !asked {
            self.waiting = Some((path, session.clone()));
        }
        self.start();
    }

    fn start(&mut self) {
        if self.running.is_some() {
            return;
        }
        let Some((path, session)) = self.waiting.take() else { return };
        let target = path.clone();
        let job = Job::spawn(
            "save",
            || (),
            move |_| {
                if let Some(folder) = target.parent().filter(|folder| !folder.as_os_str().is_empty()) {
                    // Where this fails, saving says why.
                    let _ = std::fs::create_dir_all(folder);
                }
                file::save(&target, &session)
            },
        );
        self.running = Some((job, path));
    }

    /// What became of the last order to save; copies are silent.
    pub fn poll(&mut self) -> Option<Kept> {
        let (job, _) = self.running.as_mut()?;
        let outcome = job.poll()?;
        let (_, path) = self.running.take()?;
        self.start();
        let silent = Some(&path) == self.copy.as_ref();
        match outcome {
            Outcome::Done(()) if silent => None,
            Outcome::Done(()) => Some(Kept::Saved(path)),
            Outcome::Failed(message) | Outcome::Panicked(message) if !silent => Some(Kept::Failed(message)),
            _ => None,
        }
    }

    /// Whether something is being saved.
    pub fn is_busy(&self) -> bool {
        self.running.is_some()
    }

    /// Removes the copy: the window is closed as it should be.
    pub fn close(&self) {
        if let Some(path) = self.copy.as_deref().filter(|_| !self.found) {
            let _ = std::fs::remove_file(path);
        }
    }
}
