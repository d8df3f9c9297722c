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
//! Whoever works on a cell owns the claim of
//! the highest number. A claim is made by creating its file, which only one process can do; an abandoned one is not removed but
//! outnumbered, so that two who find it abandoned can't both win.

use std::fs::{self, File, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::ExperimentError;
use crate::file;

/// A claim that shows no sign of life for so long is abandoned.
const ABANDONED: Duration = Duration::from_secs(600);
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
}

/// The right to work on a cell; given back when dropped.
#[derive(Debug)]
pub struct Claim {
    path: PathBuf,
    file: File,
    last_beat: std::sync::Mutex<SystemTime>,
}

impl Owner {
    /// This process.
    pub fn this() -> Owner {
        Owner { host: gethostname::gethostname().to_string_lossy().into_owned(), process: std::process::id() }
    }

    /// Whether it is known to be gone: only of processes on this machine, and only where the system tells.
    pub fn is_gone(&self) -> bool {
        let processes = Path::new("/proc");
        self.host == Owner::this().host
            && processes.join("self").exists()
            && !processes.join(self.process.to_string()).exists()
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
        let number = match &newest {
            Some((_, path)) if is_held(path) => return Ok(None),
            Some((number, _)) => number + 1,
            None => 1,
        };
        let path = folder.join(format!("claim-{number}"));
        let mut file = match OpenOptions::new().write(true).create_new(true).open(&path) {
            Err(problem) if problem.kind() == ErrorKind::AlreadyExists => return Ok(None),
            other => other.map_err(failed(&path))?,
        };
        let owner = serde_json::to_vec(&Owner::this()).unwrap_or_default();
        file.write_all(&owner).map_err(failed(&path))?;
        if let Some((_, abandoned)) = newest {
            // Somebody else may have removed it by now.
            let _ = fs::remove_file(abandoned);
        }
        Ok(Some(Claim { path, file, last_beat: std::sync::Mutex::new(SystemTime::now()) }))
    }

    /// Who works on a cell.
    ///
    /// # Errors
    /// [`ExperimentError::Store`] if the folder can't be read.
    pub fn owner(&self, key: &str) -> Result<Option<Owner>, ExperimentError> {
        let newest = self.newest_claim(key)?.filter(|(_, path)| is_held(path));
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
fn is_held(claim: &Path) -> bool {
    // A claim that vanished was given back.
    let Ok(about) = fs::metadata(claim) else { return false };
    if owner_in(claim).is_some_and(|owner| owner.is_gone()) {
        return false;
    }
    // A clock that is behind that of the folder makes no claim old.
    about.modified().ok().and_then(|beat| beat.elapsed().ok()).is_none_or(|silent| silent < ABANDONED)
}

impl Claim {
    /// Shows that its owner still works; cheap enough to be called often.
    pub fn beat(&self) {
        let Ok(mut last) = self.last_beat.lock() else { return };
        let now = SystemTime::now();
        if now.duration_since(*last).is_ok_and(|silent| silent >= BEAT) {
            // If this fails once, the next beat is in time.
            let _ = self.file.set_modified(now);
            *last = now;
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
        let far = Owner { host: "another machine".into(), process: 1 };
        fs::create_dir_all(folder.path().join("cells/a")).unwrap();
        let path = folder.path().join("cells/a/claim-1");
        fs::write(&path, serde_json::to_vec(&far).unwrap()).unwrap();
        assert!(store.claim("a").unwrap().is_none());
        File::options().write(true).open(&path).unwrap().set_modified(SystemTime::now() - 2 * ABANDONED).unwrap();
        assert!(store.claim("a").unwrap().is_some());
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
