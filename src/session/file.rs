//! A session as a file: the recording with its sealed truth, the split, and every model of the ladder.
//!
//! An archive of `session.json`, `recording.npz` and one model file for each step; predictions and errors are computed anew
//! when it is opened. The diagnosis, curves outside the data and checkpoints of training are not in it. A file is written beside the old one
//! and then takes its place, so that a full disk or a crash never costs the old one, which is kept as `.bak`.

use std::fs::{self, File};
use std::io::{Cursor, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

use super::{Generation, Session, Step};
use crate::model::{Evaluation, ModelError, Preset, Term};
use crate::progress::{Epoch, Monitor, Stopped};
use crate::recording::check::Finding;
use crate::recording::mapping::Mapping;
use crate::recording::read::{ReadError, ReadOptions, own_recording};
use crate::recording::seal::SealError;
use crate::recording::split::Split;
use crate::recording::write::{WriteError, to_npz_bytes};
use crate::training::fit::{self, Plan};
use crate::training::{Ending, TrainError};

/// Ending of session files.
pub const ENDING: &str = "torquescope";
/// Written into every file; a file of another version is refused.
const VERSION: u32 = 1;
const CONTENTS: &str = "session.json";
const RECORDING: &str = "recording.npz";

/// A session can't be saved or opened.
#[derive(Debug, thiserror::Error)]
pub enum SessionFileError {
    /// There is nothing to save.
    #[error("there is no recording yet, so there is nothing to save")]
    Empty,
    /// The file system refuses.
    #[error("{path}: {problem}. Check the folder, its permissions and the free space", path = path.display())]
    File {
        /// Which file.
        path: PathBuf,
        /// What the system says.
        problem: std::io::Error,
    },
    /// Not a session.
    #[error(
        "this is not a session ({0}): choose a file that was saved by this program, or its copy with the ending .bak"
    )]
    Damaged(String),
    /// Another version.
    #[error("the session has version {0}, this program reads version {VERSION}: use the program that saved it")]
    Version(u64),
    /// The recording can't be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The recording can't be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A model can't be read or written.
    #[error(transparent)]
    Train(#[from] TrainError),
    /// A model does not fit the recording.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The seal is damaged.
    #[error(transparent)]
    Seal(#[from] SealError),
    /// Stopped by the user.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Contents {
    torquescope_session: u32,
    findings: Vec<Finding>,
    mapping: Option<Mapping>,
    split: Split,
    preset: Preset,
    plan: Plan,
    set_aside: Vec<Term>,
    steps: Vec<StepAbout>,
    /// Whether the user had opened the seal.
    opened: bool,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StepAbout {
    title: String,
    history: Vec<Epoch>,
    ending: Option<Ending>,
}

/// The session as bytes.
///
/// # Errors
/// [`SessionFileError`] if it is empty or a part of it can't be written.
pub fn to_bytes(session: &Session) -> Result<Vec<u8>, SessionFileError> {
    let recording = session.recording.as_deref().ok_or(SessionFileError::Empty)?;
    let about = |step: &Arc<Step>| StepAbout {
        title: step.title.clone(),
        history: step.history.clone(),
        ending: step.ending.clone(),
    };
    let contents = Contents {
        torquescope_session: VERSION,
        findings: session.findings.to_vec(),
        mapping: session.mapping.as_deref().cloned(),
        split: session.split.clone(),
        preset: session.preset,
        plan: session.plan.clone(),
        set_aside: session.set_aside.clone(),
        steps: session.ladder.iter().map(about).collect(),
        opened: session.truth.is_some(),
    };
    let json = serde_json::to_vec_pretty(&contents).map_err(|error| SessionFileError::Damaged(error.to_string()))?;
    let mut entries = vec![(CONTENTS.to_owned(), json), (RECORDING.to_owned(), to_npz_bytes(recording)?)];
    for (number, step) in session.ladder.iter().enumerate() {
        entries.push((model_name(number), fit::to_bytes(&step.fitted)?));
    }
    // Stored, with a fixed time: the same session gives the same bytes.
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    let damaged = |error: &dyn std::fmt::Display| SessionFileError::Damaged(error.to_string());
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in entries {
        let options = options.large_file(bytes.len() > u32::MAX as usize / 2);
        archive.start_file(name, options).map_err(|error| damaged(&error))?;
        archive.write_all(&bytes).map_err(|error| damaged(&error))?;
    }
    Ok(archive.finish().map_err(|error| damaged(&error))?.into_inner())
}

/// The session that was saved as these bytes, its predictions computed anew.
///
/// # Errors
/// [`SessionFileError`] says what is damaged; nothing is opened then.
pub fn from_bytes(bytes: &[u8], monitor: &Monitor) -> Result<Session, SessionFileError> {
    let damaged = |error: &dyn std::fmt::Display| SessionFileError::Damaged(error.to_string());
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| damaged(&error))?;
    let largest = ReadOptions::default().largest;
    let mut entry = |name: &str| -> Result<Vec<u8>, SessionFileError> {
        let file = archive.by_name(name).map_err(|error| damaged(&format!("{name}: {error}")))?;
        let mut content = Vec::new();
        file.take(largest).read_to_end(&mut content).map_err(|error| damaged(&error))?;
        Ok(content)
    };
    let json = entry(CONTENTS)?;
    let value: serde_json::Value = serde_json::from_slice(&json).map_err(|error| damaged(&error))?;
    match value.get("torquescope_session").and_then(serde_json::Value::as_u64) {
        None => return Err(SessionFileError::Damaged("it says no version".to_owned())),
        Some(version) if version != u64::from(VERSION) => return Err(SessionFileError::Version(version)),
        Some(_) => (),
    }
    let contents: Contents = serde_json::from_slice(&json).map_err(|error| damaged(&error))?;
    let recording = own_recording(&entry(RECORDING)?, monitor)?;
    let fits = |segment: &crate::recording::split::Segment| {
        recording
            .trajectories
            .get(segment.trajectory)
            .is_some_and(|run| segment.samples.start <= segment.samples.end && segment.samples.end <= run.len())
    };
    if !contents.split.train.iter().chain(&contents.split.held_out).all(fits) {
        return Err(SessionFileError::Damaged("its split is of another recording".to_owned()));
    }
    let count = contents.steps.len();
    let mut ladder = Vec::with_capacity(count);
    for (number, StepAbout { title, history, ending }) in contents.steps.into_iter().enumerate() {
        monitor.report(number as f32 / count as f32, &title)?;
        let fitted = fit::from_bytes(&entry(&model_name(number))?)?;
        if fitted.setting().kinds.len() != recording.joint_count() {
            return Err(SessionFileError::Damaged(format!("“{title}” is a model of another recording")));
        }
        let evaluation = Evaluation::of(&fitted, &recording, &contents.split)?;
        let generation = Generation::next();
        ladder.push(Arc::new(Step { generation, title, fitted, evaluation, history, ending, run: None }));
    }
    let seal = recording.seal.as_ref().filter(|_| contents.opened);
    let truth = seal.map(|seal| seal.open()).transpose()?.map(Arc::new);
    Ok(Session {
        recording: Some(Arc::new(recording)),
        findings: Arc::new(contents.findings),
        mapping: contents.mapping.map(Arc::new),
        split: contents.split,
        preset: contents.preset,
        plan: contents.plan,
        ladder,
        set_aside: contents.set_aside,
        truth,
        ..Session::default()
    })
}

/// Saves so that at every moment either the old or the new file is whole; the old one stays as `.bak`.
///
/// # Errors
/// [`SessionFileError`] with the file that can't be written.
pub fn save(path: &Path, session: &Session) -> Result<(), SessionFileError> {
    let bytes = to_bytes(session)?;
    let beside = |ending: &str| {
        let mut name = path.as_os_str().to_owned();
        name.push(ending);
        PathBuf::from(name)
    };
    let new = beside(".new");
    let written = File::create(&new).and_then(|mut file| file.write_all(&bytes).and_then(|()| file.sync_all()));
    let problem = |problem| SessionFileError::File { path: path.to_owned(), problem };
    if let Err(error) = written {
        let _ = fs::remove_file(&new);
        return Err(problem(error));
    }
    if path.exists() {
        // A hard link or copy would need space; the new file is whole already, so the old one may move.
        fs::rename(path, beside(".bak")).map_err(problem)?;
    }
    fs::rename(&new, path).map_err(problem)
}

/// Opens a saved session.
///
/// # Errors
/// [`SessionFileError`] says what is wrong; the file is left as it is.
pub fn open(path: &Path, monitor: &Monitor) -> Result<Session, SessionFileError> {
    let bytes = fs::read(path).map_err(|problem| SessionFileError::File { path: path.to_owned(), problem })?;
    from_bytes(&bytes, monitor)
}

fn model_name(number: usize) -> String {
    format!("step-{}.model", number + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::Command;
    use crate::simulation::{Excitation, Scenario};

    fn repaired() -> Session {
        let motion = Excitation::PaperPointToPoint { trajectories: 6, duration: 4.0, samples: 80, range: 2.0 };
        let run = |command: Command, session: &Session| command.run(session, &Monitor::new()).unwrap();
        let session =
            run(Command::Simulate(Box::new(Scenario { motion, ..Scenario::embedded() })), &Session::default());
        run(Command::AddEffect { effect: "coulomb-friction".into(), joints: vec![0, 1] }, &session)
    }

    #[test]
    fn a_session_comes_back_as_it_was() {
        let session = repaired();
        let bytes = to_bytes(&session).unwrap();
        assert_eq!(bytes, to_bytes(&session).unwrap(), "equal sessions give equal bytes");
        let back = from_bytes(&bytes, &Monitor::new()).unwrap();
        assert_eq!(back.recording, session.recording);
        assert_eq!((back.ladder.len(), &back.split), (2, &session.split));
        for (one, other) in back.ladder.iter().zip(&session.ladder) {
            assert_eq!((&one.title, &one.fitted, &one.evaluation), (&other.title, &other.fitted, &other.evaluation));
        }
    }

    #[test]
    fn damaged_files_are_refused_and_the_old_one_is_kept() {
        let session = repaired();
        let bytes = to_bytes(&session).unwrap();
        let open = |bytes: &[u8]| from_bytes(bytes, &Monitor::new());
        assert!(matches!(open(b""), Err(SessionFileError::Damaged(_))));
        for at in (0..bytes.len()).step_by(bytes.len() / 60) {
            let _ = open(&bytes[..at]).map(|_| panic!("half a file was opened"));
            let mut flipped = bytes.clone();
            flipped[at] ^= 0x40;
            // Where a number of the recording changes, the check sum of the archive tells it.
            let _ = open(&flipped);
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mine.torquescope");
        save(&path, &session).unwrap();
        let shorter = Session { ladder: session.ladder[..1].to_vec(), ..session.clone() };
        save(&path, &shorter).unwrap();
        assert_eq!(super::open(&path, &Monitor::new()).unwrap().ladder.len(), 1);
        let kept = folder.path().join("mine.torquescope.bak");
        assert_eq!(super::open(&kept, &Monitor::new()).unwrap().ladder.len(), 2);
        let nowhere = folder.path().join("no/such/folder/mine.torquescope");
        assert!(save(&nowhere, &session).unwrap_err().to_string().contains("Check the folder"));
        assert!(matches!(save(&path, &Session::default()), Err(SessionFileError::Empty)));
    }
}
