//! The folder of recovery copies: one for each process that has the window open, and one for each of its documents that another took
//! the place of before it was saved.
//!
//! ```text
//! recovery-PID-TIME.torquescope   the document
//!                  .json          what it is called, and how it was left
//!                  .1.run, …      checkpoints of trainings that were at work
//!                  .lock          held by its owner as long as it lives
//! ```
//!
//! The system takes the lock away from an owner that dies, however it dies; only then the copy is offered to others. It stays until
//! somebody restores it or throws it away.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use crate::experiment::store::Owner;
use crate::file::{self, beside};
use crate::session::{Document, Generation, SessionFileError, file as document_file};

const NOTE: &str = ".json";
const LOCK: &str = ".lock";
const RUN: &str = ".run";

/// What is told of a copy.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Note {
    /// What the document is called.
    pub name: String,
    /// Whether somebody worked on it, beyond opening or simulating it.
    pub has_work: bool,
    /// Whether its window was closed; else it ended unexpectedly, or still lives.
    pub closed: bool,
    /// Whose it is, where the system knows no locks.
    #[serde(default)]
    pub owner: Option<Owner>,
}

/// A copy whose owner is gone.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Copy {
    /// The document.
    pub path: PathBuf,
    /// What is told of it.
    pub note: Note,
    /// When it was written.
    pub written: SystemTime,
}

impl Copy {
    /// Its name and when it was written, such as `mystery 7 (22:10)`.
    pub fn label(&self) -> String {
        format!("{} ({})", self.note.name, clock(self.written))
    }

    /// The newest checkpoint of a training that was at work on it.
    pub fn run(&self) -> Option<PathBuf> {
        runs(&self.path).into_iter().max_by_key(|path| file::written(path))
    }
}

/// The hour on the clock of whoever reads it, with the day if that is another one.
pub fn clock(time: SystemTime) -> String {
    let zone = jiff::tz::TimeZone::system();
    let Ok(time) = jiff::Timestamp::try_from(time).map(|time| time.to_zoned(zone.clone())) else {
        return "at an unknown time".to_owned();
    };
    let now = jiff::Timestamp::now().to_zoned(zone);
    let form = match (time.date() == now.date(), time.year() == now.year()) {
        (true, _) => "%H:%M",
        (_, true) => "%-d %b, %H:%M",
        _ => "%-d %b %Y, %H:%M",
    };
    time.strftime(form).to_string()
}

/// Names of documents that this process may have in a folder.
fn names(folder: &Path) -> impl Iterator<Item = PathBuf> {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_millis();
    let name = |number| format!("recovery-{}-{number}.{}", std::process::id(), document_file::ENDING);
    (since..).map(move |number| folder.join(name(number)))
}

/// The files of a copy are named after its document.
fn part(document: &Path, ending: &str) -> PathBuf {
    beside(&document.with_extension(""), ending)
}

/// The checkpoints beside a copy.
fn runs(document: &Path) -> Vec<PathBuf> {
    let (Some(folder), Some(stem)) = (document.parent(), document.file_stem()) else { return Vec::new() };
    let begin = format!("{}.", stem.to_string_lossy());
    let is_own = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with(&begin) && name.ends_with(RUN)
    };
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.path()).filter(is_own).collect()
}

/// Removes a copy whose lock is held, its lock last.
fn remove(document: &Path) {
    // What can't be removed is offered once more; that is better than a message at every exit.
    let last = [NOTE, LOCK].map(|ending| part(document, ending));
    let paths = [document.to_owned()].into_iter().chain(file::remains(document)).chain(runs(document)).chain(last);
    paths.for_each(|path| drop(fs::remove_file(path)));
}

/// Takes a lock of the system on an open file, or fails at once.
type TakeLock = fn(&File) -> Result<(), TryLockError>;

/// How the system is asked for locks.
#[derive(Debug, Clone, Copy)]
pub struct Locks {
    alone: TakeLock,
    shared: TakeLock,
}

impl Default for Locks {
    fn default() -> Self {
        Locks { alone: File::try_lock, shared: File::try_lock_shared }
    }
}

impl Locks {
    /// As on a file system that knows none, which some of networks don't.
    pub fn none() -> Self {
        let none: TakeLock = |_| Err(TryLockError::Error(std::io::ErrorKind::Unsupported.into()));
        Locks { alone: none, shared: none }
    }
}

/// A lock that is held.
#[derive(Debug)]
struct Held {
    document: PathBuf,
    lock: File,
    /// Whether the system knows of it. Where it knows no locks, the note says whose the document is.
    is_known: bool,
}

impl Held {
    /// Takes a name in this folder that nobody has.
    fn new(folder: &Path, locks: Locks) -> std::io::Result<Held> {
        for document in names(folder) {
            // Nobody else has this number; another window of this process may.
            if !part(&document, LOCK).exists()
                && let Some(held) = Held::take(&document, locks)?
            {
                return Ok(held);
            }
        }
        Err(std::io::ErrorKind::AlreadyExists.into())
    }

    /// Takes the lock of a document; `None` if somebody else has it.
    fn take(document: &Path, locks: Locks) -> std::io::Result<Option<Held>> {
        let file = OpenOptions::new().create(true).write(true).truncate(false).open(part(document, LOCK))?;
        let is_known = match (locks.alone)(&file) {
            Ok(()) => true,
            Err(TryLockError::Error(_)) => false,
            Err(TryLockError::WouldBlock) => return Ok(None),
        };
        Ok(Some(Held { document: document.to_owned(), lock: file, is_known }))
    }
}

impl Drop for Held {
    /// Gives the lock back by name: a program that is just being started has all open files of this one for a moment, and their locks.
    fn drop(&mut self) {
        drop(self.lock.unlock());
    }
}

/// Whether the owner of a copy is gone.
fn is_left(document: &Path, note: &Note, locks: Locks) -> bool {
    let Ok(lock) = File::open(part(document, LOCK)) else { return true };
    match (locks.shared)(&lock) {
        Ok(()) => {
            drop(lock.unlock());
            true
        }
        Err(TryLockError::WouldBlock) => false,
        Err(TryLockError::Error(_)) => note.owner.as_ref().is_none_or(Owner::is_gone),
    }
}

/// The copies of a user: that of this process, and those that others left.
#[derive(Debug, Default)]
pub struct Shelf {
    folder: PathBuf,
    locks: Locks,
    own: Option<Held>,
    /// Those of sessions that another recording took the place of in this process.
    aside: Vec<(Generation, Held)>,
    /// The newest first.
    left: Vec<Copy>,
    /// What is being restored.
    taken: Option<(Held, Copy)>,
    /// How many trainings there were.
    trainings: usize,
    /// Checkpoints of trainings that are over. A training that was stopped may still write its own, so they are removed again.
    over: Vec<PathBuf>,
}

impl Shelf {
    /// The copies in this folder, which is made if it is not there.
    ///
    /// # Errors
    /// What the system says if no copies can be kept there.
    pub fn open(folder: PathBuf, locks: Locks) -> std::io::Result<Shelf> {
        fs::create_dir_all(&folder)?;
        let own = Some(Held::new(&folder, locks)?);
        let mut shelf = Shelf { folder, locks, own, ..Shelf::default() };
        shelf.look();
        Ok(shelf)
    }

    /// Whether the folder is where the system knows no locks.
    pub fn lacks_locks(&self) -> bool {
        self.own.as_ref().is_some_and(|own| !own.is_known)
    }

    /// Looks for what others left.
    fn look(&mut self) {
        let own = self.own.iter().chain(self.aside.iter().map(|(_, held)| held));
        let own: Vec<&PathBuf> = own.map(|held| &held.document).collect();
        let is_document = |path: &PathBuf| path.extension().is_some_and(|ending| ending == document_file::ENDING);
        let copy = |path: PathBuf| {
            let written = file::written(&path)?;
            let note = file::read(&part(&path, NOTE), file::LARGEST_TEXT).ok();
            let note = note.and_then(|note| serde_json::from_slice(&note).ok()).unwrap_or_else(|| Note {
                name: "a session".to_owned(),
                has_work: true,
                closed: false,
                owner: None,
            });
            is_left(&path, &note, self.locks).then_some(Copy { path, note, written })
        };
        let entries = fs::read_dir(&self.folder).into_iter().flatten().flatten().map(|entry| entry.path());
        let others = entries.filter(is_document).filter(|path| !own.contains(&path));
        self.left = others.filter_map(copy).collect();
        self.left.sort_by_key(|copy| std::cmp::Reverse(copy.written));
    }

    /// What others left, the newest first.
    pub fn left(&self) -> &[Copy] {
        &self.left
    }

    /// Where the copy of this process is; `None` if none is kept.
    pub fn own(&self) -> Option<&Path> {
        self.own.as_ref().map(|own| own.document.as_path())
    }

    /// Where a training that begins keeps itself.
    pub fn begin_training(&mut self) -> Option<PathBuf> {
        self.trainings += 1;
        Some(part(self.own()?, &format!(".{}{RUN}", self.trainings)))
    }

    /// The checkpoints of all trainings so far are not needed any more.
    pub fn end_training(&mut self) {
        self.over = self.own().map(runs).unwrap_or_default();
        self.forget_trainings();
    }

    /// Removes checkpoints that are over, also where they were written once more.
    pub fn forget_trainings(&self) {
        self.over.iter().for_each(|path| drop(fs::remove_file(path)));
    }

    /// Takes a copy, so that no other window restores it too; `false` if one does already.
    pub fn take(&mut self, copy: &Path) -> bool {
        // Another window may have given it back, or thrown it away.
        self.look();
        let known = self.left.iter().find(|other| other.path == copy).cloned();
        let held = Held::take(copy, self.locks).ok().flatten();
        self.taken = held.zip(known);
        self.look();
        self.taken.is_some()
    }

    /// What is being restored.
    pub fn taken(&self) -> Option<&Copy> {
        self.taken.as_ref().map(|(_, copy)| copy)
    }

    /// Leaves it where it is: it was not restored.
    pub fn give_back(&mut self) {
        self.taken = None;
        self.look();
    }

    /// Removes what was taken: it is in the copy of this process now.
    pub fn remove_taken(&mut self) {
        if let Some((held, _)) = self.taken.take() {
            remove(&held.document);
            self.look();
        }
    }

    /// Throws a copy away, unless another window has it.
    pub fn throw_away(&mut self, copy: &Path) {
        // Where the system knows no locks, only the look tells that it has an owner.
        self.look();
        if self.left.iter().any(|other| other.path == copy)
            && let Ok(Some(held)) = Held::take(copy, self.locks)
        {
            remove(&held.document);
        }
        self.look();
    }

    /// Writes the copy of this process.
    ///
    /// # Errors
    /// Why it could not be written.
    pub fn write(own: &Path, document: &Document, note: &Note) -> Result<(), SessionFileError> {
        let problem = |problem| SessionFileError::File { path: own.to_owned(), problem };
        file::write(own, &document_file::to_bytes(document)?).map_err(problem)?;
        Shelf::describe(own, note).map_err(problem)
    }

    /// Another document takes the place of this session: its copy stays as it is, and the other one gets a copy of its own.
    ///
    /// # Errors
    /// What the system says if there can be no other; then there is one copy, as before.
    pub fn set_aside(&mut self, generation: Generation) -> std::io::Result<()> {
        let other = Held::new(&self.folder, self.locks)?;
        self.aside.extend(self.own.replace(other).map(|own| (generation, own)));
        Ok(())
    }

    /// Whether there is a copy of its own of this session, which another document took the place of.
    pub fn has_aside(&self, generation: Generation) -> bool {
        self.aside.iter().any(|(other, _)| *other == generation)
    }

    /// Removes the copies of all sessions but these, of those that were set aside.
    pub fn keep_aside(&mut self, wanted: &[Generation]) {
        let is_spare = |(generation, _): &mut (Generation, Held)| !wanted.contains(generation);
        self.aside.extract_if(.., is_spare).for_each(|(_, held)| remove(&held.document));
    }

    /// Gives the copy of a session that another took the place of to whoever comes next.
    ///
    /// # Errors
    /// As [`Shelf::write`].
    pub fn leave_aside(&mut self, document: &Document, note: &Note) -> Result<(), SessionFileError> {
        let generation = document.history.current().generation;
        if !self.has_aside(generation)
            && let Ok(held) = Held::new(&self.folder, self.locks)
        {
            self.aside.push((generation, held));
        }
        let place = self.aside.iter().position(|(other, _)| *other == generation);
        let Some((_, held)) = place.map(|place| self.aside.swap_remove(place)) else { return Ok(()) };
        Shelf::write(&held.document, document, note)
    }

    /// Writes what is told of the copy of this process.
    ///
    /// # Errors
    /// What the system says.
    pub fn describe(own: &Path, note: &Note) -> std::io::Result<()> {
        let note = Note { owner: Some(Owner::this()), ..note.clone() };
        file::write(&part(own, NOTE), &serde_json::to_vec(&note).unwrap_or_default())
    }

    /// Gives the copy of this process to whoever comes next. Of those that nobody worked on, the newest is enough.
    pub fn leave(&mut self, has_work: bool) {
        self.forget_trainings();
        if !has_work {
            self.look();
            let idle = self.left.iter().filter(|copy| copy.note.closed && !copy.note.has_work);
            for copy in idle.map(|copy| copy.path.clone()).collect::<Vec<_>>() {
                self.throw_away(&copy);
            }
        }
        self.own = None;
    }

    /// Removes the copy of this process.
    pub fn clear(&mut self) {
        if let Some(own) = self.own.take() {
            remove(&own.document);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A copy as its process writes it; what is in it does not matter here.
    fn keep(shelf: &Shelf, name: &str, has_work: bool, closed: bool) -> PathBuf {
        let own = shelf.own().unwrap().to_owned();
        fs::write(&own, name).unwrap();
        Shelf::describe(&own, &Note { name: name.to_owned(), has_work, closed, owner: None }).unwrap();
        own
    }

    fn names(shelf: &Shelf) -> Vec<&str> {
        shelf.left().iter().map(|copy| copy.note.name.as_str()).collect()
    }

    #[test]
    fn what_has_an_owner_is_neither_offered_nor_taken_nor_thrown_away() {
        let folder = tempfile::tempdir().unwrap();
        let open = || Shelf::open(folder.path().to_owned(), Locks::default()).unwrap();
        let first = open();
        let copy = keep(&first, "mine", true, false);
        let mut second = open();
        assert_ne!(first.own(), second.own(), "no two share one");
        assert!(second.left().is_empty() && !second.take(&copy));
        second.throw_away(&copy);
        assert!(copy.exists());
        // Its process dies; whatever else lives, only one gets what it left.
        drop(first);
        let (mut third, mut fourth) = (open(), open());
        assert_eq!((names(&third), names(&fourth)), (vec!["mine"], vec!["mine"]));
        assert!(third.take(&copy) && !fourth.take(&copy));
        assert!(fourth.left().is_empty());
        // It was not restored after all.
        third.give_back();
        assert!(fourth.take(&copy));
        fourth.remove_taken();
        assert!(!copy.exists() && names(&open()).is_empty());
    }

    #[test]
    fn of_closed_windows_without_work_only_the_newest_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let open = || Shelf::open(folder.path().to_owned(), Locks::default()).unwrap();
        for (name, has_work) in [("a", false), ("b", true), ("c", false), ("d", false)] {
            let mut shelf = open();
            keep(&shelf, name, has_work, true);
            shelf.leave(has_work);
        }
        let crashed = open();
        keep(&crashed, "e", false, false);
        drop(crashed);
        let shelf = open();
        let mut left = names(&shelf);
        left.sort();
        assert_eq!(left, ["b", "d", "e"]);
        assert!(shelf.left()[0].label().contains(':'), "{}", shelf.left()[0].label());
        let mut other = open();
        keep(&other, "f", true, false);
        other.clear();
        assert_eq!(names(&open()).len(), 3, "what is in a file needs no copy");
    }

    #[test]
    fn trainings_that_are_over_leave_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let mut shelf = Shelf::open(folder.path().to_owned(), Locks::default()).unwrap();
        let own = keep(&shelf, "mine", true, false);
        let first = shelf.begin_training().unwrap();
        fs::write(&first, "1").unwrap();
        shelf.end_training();
        assert!(!first.exists());
        let second = shelf.begin_training().unwrap();
        assert_ne!(first, second);
        // The one that was stopped ends only now.
        [&first, &second].iter().for_each(|path| fs::write(path, "2").unwrap());
        shelf.forget_trainings();
        drop(shelf);
        let mut next = Shelf::open(folder.path().to_owned(), Locks::default()).unwrap();
        assert_eq!(next.left()[0].run(), Some(second.clone()));
        next.throw_away(&own);
        assert!(!second.exists() && next.left().is_empty());
    }

    /// As on a network's file system that knows no locks: the note says whose a copy is, and whether that process lives.
    #[cfg(target_os = "linux")]
    #[test]
    fn without_locks_the_note_tells_whether_the_owner_is_gone() {
        let folder = tempfile::tempdir().unwrap();
        let open = || Shelf::open(folder.path().to_owned(), Locks::none()).unwrap();
        let first = open();
        assert!(first.lacks_locks());
        let copy = keep(&first, "mine", true, false);
        let mut second = open();
        assert_ne!(first.own(), second.own(), "no two share one");
        assert!(second.left().is_empty() && !second.take(&copy), "its process lives");
        second.throw_away(&copy);
        assert!(copy.exists());
        let mut gone = std::process::Command::new("true").spawn().unwrap();
        let process = gone.id();
        gone.wait().unwrap();
        let owner = Some(Owner { process, ..Owner::this() });
        let note = Note { name: "mine".to_owned(), has_work: true, closed: false, owner };
        fs::write(part(&copy, NOTE), serde_json::to_vec(&note).unwrap()).unwrap();
        let mut third = open();
        assert_eq!(names(&third), ["mine"]);
        assert!(third.take(&copy));
        third.remove_taken();
        assert!(!copy.exists());
    }

    /// As the program of before left it: without a lock, and without a note.
    #[test]
    fn a_copy_without_a_lock_is_offered() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("recovery.torquescope"), "PK").unwrap();
        let shelf = Shelf::open(folder.path().to_owned(), Locks::default()).unwrap();
        assert_eq!(names(&shelf), ["a session"]);
    }
}
