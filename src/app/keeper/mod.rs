//! Keeps the work: saves the document where the user asks for it, and after every change a copy that neither a crash nor a closed
//! window can take.

mod copies;

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

pub use copies::{Copy, Locks, Note, Shelf, clock};

use crate::file::{self, Mark};
use crate::session::{Document, Generation, Session, View, file as document_file};
use crate::work::{self, Job, Outcome};

/// Saves in the background.
#[derive(Default)]
pub struct Keeper {
    shelf: Shelf,
    running: Option<(Job<Option<Mark>>, Target)>,
    /// Where the user asked for it.
    saves: VecDeque<(PathBuf, Document)>,
    /// What is in no copy yet: the newest state of the document, after that of one which it took the place of.
    copies: VecDeque<Draft>,
    /// Which session the copy is of, and where one looked.
    copied: Option<(Generation, View)>,
    /// The same of the copy that was asked for last, whatever became of it.
    asked: Option<(Generation, View)>,
    /// The sessions that had copies of their own then.
    left: Vec<Generation>,
    /// Whether the last copy could not be written.
    copy_failed: bool,
    /// The session that was restored from another copy, which goes as soon as it is in this one.
    restored: Option<Generation>,
}

/// Which session a document is at, and where one looks in it.
fn seen(document: &Document) -> (Generation, View) {
    (document.history.current().generation, document.view.clone())
}

/// A copy to be written.
struct Draft {
    path: PathBuf,
    document: Document,
    note: Note,
}

/// What is being written.
struct Target {
    path: PathBuf,
    document: (Generation, View),
    is_copy: bool,
}

/// What became of saving.
pub enum Kept {
    /// The session is in this file.
    Saved {
        /// Which file.
        path: PathBuf,
        /// As it was written.
        mark: Option<Mark>,
        /// Which session, and where one looked.
        saved: (Generation, View),
    },
    /// It is not, and why.
    Failed(String),
    /// The copy could not be written; told once until it can be again.
    NoCopy(String),
}

impl Keeper {
    /// Keeps a copy in this folder.
    ///
    /// # Errors
    /// What the system says if that can't be.
    pub fn with_copies(folder: PathBuf, locks: Locks) -> std::io::Result<Self> {
        Ok(Keeper { shelf: Shelf::open(folder, locks)?, ..Keeper::default() })
    }

    /// Whether the folder of the copies is where the system knows no locks.
    pub fn lacks_locks(&self) -> bool {
        self.shelf.lacks_locks()
    }

    /// Where the copies of this user are.
    pub fn usual_place() -> Option<PathBuf> {
        let home = || std::env::var_os("HOME").map(|home| Path::new(&home).join(".local/state"));
        let folder =
            std::env::var_os("XDG_STATE_HOME").map(PathBuf::from).filter(|path| path.is_absolute()).or_else(home)?;
        Some(folder.join("torquescope"))
    }

    /// What other windows left behind, the newest first.
    pub fn left_behind(&self) -> &[Copy] {
        self.shelf.left()
    }

    /// Takes a copy that is to be restored; `false` if another window has it.
    pub fn take(&mut self, copy: &Path) -> bool {
        self.shelf.take(copy)
    }

    /// The copy that is being restored.
    pub fn taken(&self) -> Option<&Copy> {
        self.shelf.taken()
    }

    /// The copy that was taken was not restored.
    pub fn give_back(&mut self) {
        self.shelf.give_back();
    }

    /// What was taken is this session now.
    pub fn restored(&mut self, generation: Generation) {
        self.restored = Some(generation);
    }

    /// Throws a copy away that another window left.
    pub fn throw_away(&mut self, copy: &Path) {
        self.shelf.throw_away(copy);
    }

    /// Where a training that begins keeps itself.
    pub fn begin_training(&mut self) -> Option<PathBuf> {
        self.shelf.begin_training()
    }

    /// The training is over.
    pub fn end_training(&mut self) {
        self.shelf.end_training();
    }

    /// Saves into a file that the user chose.
    pub fn save(&mut self, path: PathBuf, document: Document) {
        self.saves.push_back((path, document));
        self.start();
    }

    /// Brings the copy up to date. What is left are sessions that are in no file and that other recordings took the place of: each keeps
    /// the copy that it has.
    pub fn copy(&mut self, document: Document, note: Note, left: Vec<Generation>) {
        if document.history.current().recording.is_none() {
            return;
        }
        if let Some((before, _)) = self.asked
            && left.contains(&before)
            && !self.shelf.has_aside(before)
        {
            // Should there be no place for another, then this one is overwritten; closing the window writes it once more.
            let _ = self.shelf.set_aside(before);
        }
        let Some(path) = self.shelf.own().map(Path::to_owned) else { return };
        self.asked = Some(seen(&document));
        self.copies.retain(|draft| draft.path != path);
        self.left = left;
        self.copies.push_back(Draft { path, document, note });
        self.start();
    }

    /// Whether something was set up to be looked at that is not in the copy of this session, nor asked to be.
    pub fn lacks(&self, session: &Session, set_up: &View) -> bool {
        let is_other =
            |(generation, view): &(Generation, View)| *generation == session.generation && !view.is_set_up_as(set_up);
        self.asked.as_ref().is_some_and(is_other)
    }

    fn start(&mut self) {
        if self.running.is_some() {
            return;
        }
        // What the user asked for goes first.
        if let Some((path, document)) = self.saves.pop_front() {
            let target = Target { path: path.clone(), document: seen(&document), is_copy: false };
            let save = move || document_file::save(&path, &document).map(|()| file::mark(&path));
            self.running = Some((Job::spawn("save", || (), move |_| save()), target));
        } else if let Some(Draft { path, document, note }) = self.copies.pop_front() {
            let target = Target { path: path.clone(), document: seen(&document), is_copy: true };
            let write = move || Shelf::write(&path, &document, &note).map(|()| None);
            self.running = Some((Job::spawn("copy", || (), move |_| write()), target));
        }
    }

    /// What became of the last order to save; copies are silent as long as they succeed.
    pub fn poll(&mut self) -> Option<Kept> {
        let outcome = self.running.as_mut()?.0.poll()?;
        let (_, Target { path, document, is_copy }) = self.running.take()?;
        let kept = match (outcome, is_copy) {
            (Outcome::Done(mark), false) => Some(Kept::Saved { path, mark, saved: document }),
            (Outcome::Done(_), true) => {
                if self.shelf.own() == Some(&path) {
                    self.has_copied(document);
                }
                // Who undoes and does again at once still needs what lay aside before.
                if self.copies.is_empty() {
                    self.shelf.keep_aside(&self.left);
                }
                None
            }
            (Outcome::Failed(message) | Outcome::Panicked(message) | Outcome::Stopped(message), true) => {
                let is_new = !std::mem::replace(&mut self.copy_failed, true);
                is_new.then_some(Kept::NoCopy(message))
            }
            (Outcome::Failed(message) | Outcome::Panicked(message) | Outcome::Stopped(message), false) => {
                Some(Kept::Failed(message))
            }
        };
        self.start();
        kept
    }

    fn has_copied(&mut self, document: (Generation, View)) {
        let generation = document.0;
        (self.copied, self.copy_failed) = (Some(document), false);
        self.shelf.forget_trainings();
        if self.restored.is_some_and(|restored| restored <= generation) {
            self.restored = None;
            self.shelf.remove_taken();
        }
    }

    /// Whether something is being saved.
    pub fn is_busy(&self) -> bool {
        self.running.is_some()
    }

    /// Ends: what is being saved is saved, and the copy is left as it should be for the next window, or removed if there is nothing
    /// to keep; and so are copies of other documents that the window had.
    pub fn close(&mut self, keep: Option<(Document, Note)>, others: &[(Document, Note)]) {
        while self.is_busy() {
            self.poll();
            work::pause();
        }
        let Some(own) = self.shelf.own().map(Path::to_owned) else { return };
        for (document, note) in others {
            // There is nobody left to tell; what can't be written now could not be at any change either, and that was told.
            let _ = self.shelf.leave_aside(document, note);
        }
        self.shelf.keep_aside(&[]);
        let Some((document, note)) = keep else { return self.shelf.clear() };
        let (generation, view) = seen(&document);
        let is_as_copied = |(copied, then): &(Generation, View)| *copied == generation && then.is_like(&view);
        let written = match self.copied.as_ref().is_some_and(is_as_copied) {
            true => Shelf::describe(&own, &note).is_ok(),
            false => Shelf::write(&own, &document, &note).is_ok(),
        };
        if written {
            self.has_copied((generation, view));
        }
        self.shelf.leave(note.has_work);
    }
}
