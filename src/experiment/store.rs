//! The folder of results. Any number of processes, on any number of machines that share it, work on it at once.
//!
//! ```text
//! cells/KEY/inputs.json      what the key is the hash of
//!           model-1, …       the trained models
//!           training.json    how they were trained, and what the diagnosis named
//!           test-KEY.json    the errors on one test set
//!           failed.json      why it could not be done
//!           claim-1, …       who works on it
//! ```
//!
//! Whoever works on a cell owns the claim of the highest number. A claim is made by creating its file, which only one process can
//! do; an abandoned one is not removed but outnumbered, so that two who find it abandoned can't both win. Signs of life are told by
//! the clock of the folder alone, since those of the machines may differ.

use std::fs::{self, File};
use std::io::{ErrorKind, Seek, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::ExperimentError;
use crate::file;

/// A claim that shows no sign of life for so long is abandoned.
const ABANDONED: Duration = Duration::from_secs(600);
/// A claim that says nothing of its owner is being written, or is none: after so long it is none.
const UNFINISHED: Duration = Duration::from_secs(10);
/// How often a claim shows a sign of life.
const BEAT: Duration = Duration::from_secs(10);

/// A folder of results.
#[derive(Debug, Clone)]
pub struct Store {
    folder: PathBuf,
}

/// Who works on a cell.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Owner {
    /// Name of the machine.
    pub host: String,
    /// Number of the process there.
    pub process: u32,
    /// Where that number counts, if the system tells: containers that share the name of a machine count their processes apart, and
    /// a machine that was started anew counts from the beginning.
    #[serde(default)]
    pub counted: Option<String>,
}

/// The right to work on a cell; given back when dropped.
#[derive(Debug)]
pub struct Claim {
    path: PathBuf,
    file: File,
    owner: Vec<u8>,
    last_beat: std::sync::Mutex<Instant>,
}

impl Owner {
    /// This process.
    pub fn this() -> Owner {
        let start = fs::read_to_string("/proc/sys/kernel/random/boot_id").ok();
        let container = fs::read_link("/proc/self/ns/pid").ok();
        let counted =
            start.zip(container).map(|(start, container)| format!("{} {}", start.trim(), container.display()));
        let host = gethostname::gethostname().to_string_lossy().into_owned();
        Owner { host, process: std::process::id(), counted }
    }

    /// Whether it is known to be gone: only of processes that are counted where this one is, and only where the system tells.
    pub fn is_gone(&self) -> bool {
        let this = Owner::this();
        self.host == this.host
            && self.counted.is_some()
            && self.counted == this.counted
            && !Path::new("/proc").join(self.process.to_string()).exists()
    }
}

impl Store {
    /// The results in this folder, which need not exist yet.
    pub fn new(folder: impl Into<PathBuf>) -> Store {
        Store { folder: folder.into() }
    }

    fn cell(&self, key: &str) -> PathBuf {
        self.folder.join("cells").join(key)
    }

    fn path(&self, key: &str, file: &str) -> PathBuf {
        self.cell(key).join(file)
    }

    /// Whether a cell has this file.
    pub fn has(&self, key: &str, file: &str) -> bool {
        self.path(key, file).is_file()
    }

    /// A file of a cell, or `None` if it has none.
    ///
    /// # Errors
    /// [`ExperimentError::Store`] if it can't be read.
    pub fn bytes(&self, key: &str, file: &str) -> Result<Option<Vec<u8>>, ExperimentError> {
        if self.has(key, file) { read(&self.path(key, file)).map(Some) } else { Ok(None) }
    }

    /// A JSON file of a cell, or `None` if it has none.
    ///
    /// # Errors
    /// [`ExperimentError::Damaged`] if it is not what it should be.
    pub fn json<T: DeserializeOwned>(&self, key: &str, file: &str) -> Result<Option<T>, ExperimentError> {
        let Some(bytes) = self.bytes(key, file)? else { return Ok(None) };
        serde_json::from_slice(&bytes).map(Some).map_err(|problem| self.damaged(key, file, &problem))
    }

    /// The error of a file that is not what it should be.
    pub fn damaged(&self, key: &str, file: &str, problem: &dyn std::fmt::Display) -> ExperimentError {
        ExperimentError::Damaged { path: self.path(key, file), problem: problem.to_string() }
    }

    /// Writes a file of a cell, whole or not at all.
    ///
    /// # Errors
    /// [`ExperimentError::Store`]
    pub fn write(&self, key: &str, file: &str, bytes: &[u8]) -> Result<(), ExperimentError> {
        let path = self.path(key, file);
        file::write(&path, bytes).map_err(|problem| ExperimentError::Store { path, problem })
    }

    /// [`Store::write`] of a value as JSON.
    ///
    /// # Errors
    /// As [`Store::write`].
    pub fn write_json(&self, key: &str, file: &str, value: &impl Serialize) -> Result<(), ExperimentError> {
        let text = serde_json::to_vec_pretty(value).map_err(|problem| self.damaged(key, file, &problem))?;
        self.write(key, file, &text)
    }

    /// Removes a file of a cell, if it is there.
    ///
    /// # Errors
    /// [`ExperimentError::Store`]
    pub fn remove(&self, key: &str, file: &str) -> Result<(), ExperimentError> {
        let path = self.path(key, file);
        match fs::remove_file(&path) {
            Err(problem) if problem.kind() != ErrorKind::NotFound => Err(ExperimentError::Store { path, problem }),
            _ => Ok(()),
        }
    }

    /// The right to work on a cell, or `None` if somebody else has it.
    ///
    /// # Errors
    /// [`ExperimentError::Store`] if the folder can't be used.
    pub fn claim(&self, key: &str) -> Result<Option<Claim>, ExperimentError> {
        let folder = self.cell(key);
        let failed = |path: &Path| {
            let path = path.to_owned();
            move |problem| ExperimentError::Store { path, problem }
        };
        fs::create_dir_all(&folder).map_err(failed(&folder))?;
        let newest = self.newest_claim(key)?;
        let now = file::clock(&folder).map_err(failed(&folder))?;
        let number = match &newest {
            Some((_, path)) if is_held(path, now) => return Ok(None),
            Some((number, _)) => number + 1,
            None => 1,
        };
        let path = folder.join(format!("claim-{number}"));
        let owner = serde_json::to_vec(&Owner::this()).unwrap_or_default();
        let file = match file::create(&path, &owner) {
            Err(problem) if problem.kind() == ErrorKind::AlreadyExists => return Ok(None),
            other => other.map_err(failed(&path))?,
        };
        if let Some((_, abandoned)) = newest {
            // Somebody else may have removed it by now.
            let _ = fs::remove_file(abandoned);
        }
        // Whoever was killed while it wrote left them.
        file::remove_drafts(&folder, now - ABANDONED);
        Ok(Some(Claim { path, file, owner, last_beat: std::sync::Mutex::new(Instant::now()) }))
    }

    /// Who works on a cell.
    ///
    /// # Errors
    /// [`ExperimentError::Store`] if the folder can't be read.
    pub fn owner(&self, key: &str) -> Result<Option<Owner>, ExperimentError> {
        let newest = self.newest_claim(key)?.filter(|(_, path)| is_held(path, SystemTime::now()));
        Ok(newest.and_then(|(_, path)| owner_in(&path)))
    }

    fn newest_claim(&self, key: &str) -> Result<Option<(u64, PathBuf)>, ExperimentError> {
        let folder = self.cell(key);
        let entries = match fs::read_dir(&folder) {
            Err(problem) if problem.kind() == ErrorKind::NotFound => return Ok(None),
            other => other.map_err(|problem| ExperimentError::Store { path: folder.clone(), problem })?,
        };
        let number = |path: &Path| path.file_name()?.to_str()?.strip_prefix("claim-")?.parse::<u64>().ok();
        let claims = entries.filter_map(|entry| Some(entry.ok()?.path()));
        Ok(claims.filter_map(|path| Some((number(&path)?, path))).max())
    }
}

fn owner_in(claim: &Path) -> Option<Owner> {
    serde_json::from_slice(&fs::read(claim).ok()?).ok()
}

/// Whether the owner of a claim still works.
fn is_held(claim: &Path, now: SystemTime) -> bool {
    // A claim that vanished was given back.
    let Ok(about) = fs::metadata(claim) else { return false };
    let longest = match owner_in(claim) {
        Some(owner) if owner.is_gone() => return false,
        Some(_) => ABANDONED,
        None => UNFINISHED,
    };
    let Ok(beat) = about.modified() else { return true };
    // A sign of life that is far ahead was given before the clock was set back: it would never grow old.
    now.duration_since(beat).unwrap_or_else(|ahead| ahead.duration()) < longest
}

impl Claim {
    /// Shows that its owner still works; cheap enough to be called often.
    pub fn beat(&self) {
        let Ok(mut last) = self.last_beat.lock() else { return };
        if last.elapsed() >= BEAT {
            // The same once more, so that the folder's own clock says when. If this fails once, the next beat is in time.
            let mut file = &self.file;
            let _ = file.rewind().and_then(|()| file.write_all(&self.owner));
            *last = Instant::now();
        }
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        // What can't be removed is found abandoned later.
        let _ = fs::remove_file(&self.path);
    }
}

/// The bytes of a file.
///
/// # Errors
/// [`ExperimentError::Store`]
pub fn read(path: &Path) -> Result<Vec<u8>, ExperimentError> {
    file::read(path, file::LARGEST_MODEL).map_err(|problem| ExperimentError::Store { path: path.to_owned(), problem })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_has_one_owner_at_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path());
        let claim = store.claim("a").unwrap().unwrap();
        assert!(store.claim("a").unwrap().is_none());
        assert_eq!(store.owner("a").unwrap(), Some(Owner::this()));
        assert!(store.claim("b").unwrap().is_some());
        drop(claim);
        assert_eq!(store.owner("a").unwrap(), None);
        assert!(store.claim("a").unwrap().is_some());
    }

    #[test]
    fn of_many_who_want_a_cell_one_gets_it() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path());
        // Abandoned by a process that can't exist.
        let gone = Owner { process: u32::MAX, ..Owner::this() };
        fs::create_dir_all(folder.path().join("cells/a")).unwrap();
        fs::write(folder.path().join("cells/a/claim-1"), serde_json::to_vec(&gone).unwrap()).unwrap();
        let won: Vec<Option<Claim>> = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..16).map(|_| scope.spawn(|| store.claim("a").unwrap())).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        });
        assert_eq!(won.iter().flatten().count(), 1);
    }

    #[test]
    fn silence_makes_a_claim_of_another_machine_abandoned() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path());
        let far = Owner { host: "another machine".into(), process: 1, counted: None };
        fs::create_dir_all(folder.path().join("cells/a")).unwrap();
        let path = folder.path().join("cells/a/claim-1");
        fs::write(&path, serde_json::to_vec(&far).unwrap()).unwrap();
        assert!(store.claim("a").unwrap().is_none());
        File::options().write(true).open(&path).unwrap().set_modified(SystemTime::now() - 2 * ABANDONED).unwrap();
        assert!(store.claim("a").unwrap().is_some());
    }

    #[test]
    fn a_claim_that_names_nobody_or_is_of_the_future_blocks_no_cell() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path());
        let far = Owner { host: "another machine".into(), process: 1, counted: None };
        let whole = serde_json::to_vec(&far).unwrap();
        let cell = folder.path().join("cells/a");
        fs::create_dir_all(&cell).unwrap();
        let claim_at = |number: u64, content: &[u8], time: SystemTime| {
            let path = cell.join(format!("claim-{number}"));
            fs::write(&path, content).unwrap();
            File::options().write(true).open(&path).unwrap().set_modified(time).unwrap();
        };
        let now = SystemTime::now();
        for (number, content) in [(1, &b""[..]), (3, &whole[..whole.len() / 2]), (5, b"somebody else's notes")] {
            claim_at(number, content, now);
            assert!(store.claim("a").unwrap().is_none(), "it may be being written");
            claim_at(number, content, now - 2 * UNFINISHED);
            assert!(store.claim("a").unwrap().is_some(), "{}", String::from_utf8_lossy(content));
        }
        claim_at(7, &whole, now + 2 * ABANDONED);
        assert!(store.claim("a").unwrap().is_some(), "its clock was ahead");
    }

    #[test]
    fn processes_of_another_container_are_not_known_to_be_gone() {
        let gone = Owner { process: u32::MAX, ..Owner::this() };
        let elsewhere = Owner { counted: Some("another container".into()), ..gone.clone() };
        let of_before = Owner { counted: None, ..gone.clone() };
        assert_eq!(
            (gone.is_gone(), elsewhere.is_gone(), of_before.is_gone()),
            (Path::new("/proc/self").exists(), false, false)
        );
        assert!(!Owner::this().is_gone());
        let read: Owner = serde_json::from_str(r#"{"host": "a", "process": 1}"#).unwrap();
        assert_eq!(read.counted, None);
    }

    #[test]
    fn a_sign_of_life_is_told_by_the_clock_of_the_folder() {
        let folder = tempfile::tempdir().unwrap();
        let claim = Store::new(folder.path()).claim("a").unwrap().unwrap();
        claim.file.set_modified(SystemTime::now() - 2 * ABANDONED).unwrap();
        *claim.last_beat.lock().unwrap() = Instant::now().checked_sub(2 * BEAT).unwrap();
        claim.beat();
        assert!(is_held(&claim.path, SystemTime::now()));
        assert_eq!(owner_in(&claim.path), Some(Owner::this()));
    }

    #[test]
    fn drafts_of_the_killed_are_removed_and_those_of_others_stay() {
        let folder = tempfile::tempdir().unwrap();
        let cell = folder.path().join("cells/a");
        fs::create_dir_all(&cell).unwrap();
        for (name, age) in [("model-1.17-0.new", 2 * ABANDONED), ("x.json.18-3.new", BEAT), ("x.json", 2 * ABANDONED)] {
            fs::write(cell.join(name), b"half").unwrap();
            File::options().write(true).open(cell.join(name)).unwrap().set_modified(SystemTime::now() - age).unwrap();
        }
        let claim = Store::new(folder.path()).claim("a").unwrap();
        let mut names: Vec<_> = fs::read_dir(&cell).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        assert_eq!(names, ["claim-1", "x.json", "x.json.18-3.new"]);
        drop(claim);
    }

    #[test]
    fn what_is_written_is_read_and_nothing_is_left_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path());
        let claim = store.claim("a").unwrap();
        store.write_json("a", "x.json", &[1, 2]).unwrap();
        drop(claim);
        assert_eq!(store.json::<Vec<i32>>("a", "x.json").unwrap(), Some(vec![1, 2]));
        assert_eq!(store.json::<Vec<i32>>("a", "y.json").unwrap(), None);
        assert_eq!(fs::read_dir(folder.path().join("cells/a")).unwrap().count(), 1);
        store.write("a", "x.json", b"[").unwrap();
        let message = store.json::<Vec<i32>>("a", "x.json").unwrap_err().to_string();
        assert!(message.contains("x.json is damaged") && message.contains("it is done anew"), "{message}");
    }
}
