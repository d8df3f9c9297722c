//! A session as a file: the recording with its sealed truth, the split, and every model of the ladder.
//!
//! An archive of `session.json`, `recording.npz`, one model file for each step of the ladder and of earlier trainings, the
//! checkpoint of each that was trained, `report.cbor`, `proposals.cbor` and `sweep.cbor`; predictions and errors are computed anew when it is
//! opened. What the file was before is kept as `.bak`.

use std::io::{Cursor, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

use super::{Generation, Session, Step, TrainedRun};
use crate::diagnosis::{Evidence, Report};
use crate::effect::own::{self, OwnEffectError};
use crate::file;
use crate::model::file::load_own_effects;
use crate::model::{Evaluation, ModelError, Preset, Term};
use crate::progress::{Epoch, Monitor, Stopped};
use crate::recording::check::Finding;
use crate::recording::mapping::Mapping;
use crate::recording::read::{ReadError, ReadOptions, own_recording};
use crate::recording::seal::SealError;
use crate::recording::split::Split;
use crate::recording::write::{WriteError, to_npz_bytes};
use crate::training::fit::{self, Plan, SavedRun};
use crate::training::{Ending, TrainError};

/// Ending of session files.
pub const ENDING: &str = "torquescope";
/// Written into every file. Version 1 had no report, no sweep and no earlier trainings; a newer file is refused.
const VERSION: u32 = 2;
const CONTENTS: &str = "session.json";
const RECORDING: &str = "recording.npz";
const REPORT: &str = "report.cbor";
const PROPOSALS: &str = "proposals.cbor";
const SWEEP: &str = "sweep.cbor";

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
    #[error("the session has version {0}, this program reads up to version {VERSION}: use the program that saved it")]
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
    /// An effect of one's own that it brings along.
    #[error("an effect of one's own in the session: {0}")]
    OwnEffect(#[from] OwnEffectError),
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
    /// The files of effects of one's own; loaded before the rest, which has them by their ids.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    own_effects: Vec<String>,
    set_aside: Vec<Term>,
    /// Every step once: those of the ladder, and of earlier trainings.
    steps: Vec<StepAbout>,
    /// Which of them are the ladder; all in a file of version 1.
    #[serde(default)]
    ladder: Option<Vec<usize>>,
    #[serde(default)]
    runs: Vec<RunAbout>,
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

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RunAbout {
    preset: Preset,
    ladder: Vec<usize>,
}

/// A report with the evidence that its form for people leaves out: that of each effect.
type WholeReport = (Report, Vec<Vec<Evidence>>);

fn damaged(error: impl std::fmt::Display) -> SessionFileError {
    SessionFileError::Damaged(error.to_string())
}

/// Each step once, however many lists have it.
#[derive(Default)]
struct Steps(Vec<Arc<Step>>);

impl Steps {
    fn places(&mut self, ladder: &[Arc<Step>]) -> Vec<usize> {
        ladder.iter().map(|step| self.place(step)).collect()
    }

    fn place(&mut self, step: &Arc<Step>) -> usize {
        self.0.iter().position(|known| Arc::ptr_eq(known, step)).unwrap_or_else(|| {
            self.0.push(Arc::clone(step));
            self.0.len() - 1
        })
    }

    /// The steps at these places; `None` if one is not there.
    fn at(&self, places: &[usize]) -> Option<Vec<Arc<Step>>> {
        places.iter().map(|&place| self.0.get(place).cloned()).collect()
    }
}

/// The session as bytes.
///
/// # Errors
/// [`SessionFileError`] if it is empty or a part of it can't be written.
pub fn to_bytes(session: &Session) -> Result<Vec<u8>, SessionFileError> {
    let recording = session.recording.as_deref().ok_or(SessionFileError::Empty)?;
    let mut steps = Steps::default();
    let ladder = steps.places(&session.ladder);
    let run = |run: &TrainedRun| RunAbout { preset: run.preset, ladder: steps.places(&run.ladder) };
    let runs = session.runs.iter().map(run).collect();
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
        own_effects: own_effects(session),
        set_aside: session.set_aside.clone(),
        steps: steps.0.iter().map(about).collect(),
        ladder: Some(ladder),
        runs,
        opened: session.truth.is_some(),
    };
    let json = serde_json::to_vec_pretty(&contents).map_err(damaged)?;
    let mut entries = vec![(CONTENTS.to_owned(), json), (RECORDING.to_owned(), to_npz_bytes(recording)?)];
    for (number, step) in steps.0.iter().enumerate() {
        entries.push((model_name(number), fit::to_bytes(&step.fitted)?));
        if let Some(run) = &step.run {
            entries.push((run_name(number), run.to_bytes()?));
        }
    }
    if let Some(report) = session.report.as_deref() {
        let evidence: Vec<&Vec<Evidence>> = report.effects.iter().map(|effect| &effect.evidence).collect();
        entries.push((REPORT.to_owned(), to_cbor(&(report, evidence))?));
    }
    if let Some(proposals) = session.proposals.as_deref() {
        entries.push((PROPOSALS.to_owned(), to_cbor(proposals)?));
    }
    if let Some(sweep) = session.sweep.as_deref() {
        entries.push((SWEEP.to_owned(), to_cbor(sweep)?));
    }
    // Stored, with a fixed time: the same session gives the same bytes.
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in entries {
        let options = options.large_file(bytes.len() > u32::MAX as usize / 2);
        archive.start_file(name, options).map_err(damaged)?;
        archive.write_all(&bytes).map_err(damaged)?;
    }
    Ok(archive.finish().map_err(damaged)?.into_inner())
}

/// The files of all effects of one's own that the session knows or has in a model.
fn own_effects(session: &Session) -> Vec<String> {
    let runs = session.runs.iter().flat_map(|run| &run.ladder);
    let models = session.ladder.iter().chain(runs).flat_map(|step| step.fitted.model.effects());
    let set_aside = session.set_aside.iter().filter_map(|term| match term {
        Term::Effect(term) => Some(term),
        Term::RigidBody(_) | Term::Learned(_) => None,
    });
    let in_models = models.chain(set_aside).map(|term| term.effect);
    own::texts(session.own_effects.iter().copied().chain(in_models))
}

fn to_cbor(value: &impl Serialize) -> Result<Vec<u8>, SessionFileError> {
    let mut bytes = Vec::new();
    ciborium::into_writer(value, &mut bytes).map_err(damaged)?;
    Ok(bytes)
}

/// The entries of a session's archive.
struct Entries<'a>(ZipArchive<Cursor<&'a [u8]>>);

impl Entries<'_> {
    fn bytes(&mut self, name: &str) -> Result<Vec<u8>, SessionFileError> {
        let file = self.0.by_name(name).map_err(|error| damaged(format!("{name}: {error}")))?;
        let mut content = Vec::new();
        file.take(ReadOptions::default().largest).read_to_end(&mut content).map_err(damaged)?;
        Ok(content)
    }

    /// An entry that not every session has.
    fn if_there(&mut self, name: &str) -> Result<Option<Vec<u8>>, SessionFileError> {
        let is_there = self.0.index_for_name(name).is_some();
        is_there.then(|| self.bytes(name)).transpose()
    }

    fn cbor<T: DeserializeOwned>(&mut self, name: &str) -> Result<Option<T>, SessionFileError> {
        let bytes = self.if_there(name)?;
        bytes
            .map(|bytes| ciborium::from_reader(&bytes[..]).map_err(|error| damaged(format!("{name}: {error}"))))
            .transpose()
    }

    fn contents(&mut self) -> Result<Contents, SessionFileError> {
        let json = self.bytes(CONTENTS)?;
        let value: serde_json::Value = serde_json::from_slice(&json).map_err(damaged)?;
        match value.get("torquescope_session").and_then(serde_json::Value::as_u64) {
            None => Err(damaged("it says no version")),
            Some(version) if !(1..=u64::from(VERSION)).contains(&version) => Err(SessionFileError::Version(version)),
            Some(_) => {
                load_own_effects(&value)?;
                serde_json::from_slice(&json).map_err(damaged)
            }
        }
    }
}

/// The session that was saved as these bytes, its predictions computed anew.
///
/// # Errors
/// [`SessionFileError`] says what is damaged; nothing is opened then.
pub fn from_bytes(bytes: &[u8], monitor: &Monitor) -> Result<Session, SessionFileError> {
    let mut entries = Entries(ZipArchive::new(Cursor::new(bytes)).map_err(damaged)?);
    let contents = entries.contents()?;
    let recording = own_recording(&entries.bytes(RECORDING)?, monitor)?;
    let fits = |segment: &crate::recording::split::Segment| {
        recording
            .trajectories
            .get(segment.trajectory)
            .is_some_and(|run| segment.samples.start <= segment.samples.end && segment.samples.end <= run.len())
    };
    if !contents.split.train.iter().chain(&contents.split.held_out).all(fits) {
        return Err(damaged("its split is of another recording"));
    }
    let own_effects = contents.own_effects.iter().map(|text| own::load(text)).collect::<Result<_, _>>()?;
    let count = contents.steps.len();
    let mut steps = Steps::default();
    for (number, StepAbout { title, history, ending }) in contents.steps.into_iter().enumerate() {
        monitor.report(number as f32 / count as f32, &title)?;
        let fitted = fit::from_bytes(&entries.bytes(&model_name(number))?)?;
        if fitted.setting().kinds.len() != recording.joint_count() {
            return Err(damaged(format!("“{title}” is a model of another recording")));
        }
        let run = entries.if_there(&run_name(number))?.map(|bytes| SavedRun::from_bytes(&bytes)).transpose()?;
        let evaluation = Evaluation::of(&fitted, &recording, &contents.split)?;
        let (generation, run) = (Generation::next(), run.map(Arc::new));
        steps.0.push(Arc::new(Step { generation, title, fitted, evaluation, history, ending, run }));
    }
    let missing = || damaged("a step is missing");
    let ladder = steps.at(&contents.ladder.unwrap_or_else(|| (0..count).collect())).ok_or_else(missing)?;
    let run = |run: RunAbout| {
        let ladder = steps.at(&run.ladder).ok_or_else(missing)?;
        Ok(TrainedRun { preset: run.preset, ladder })
    };
    let runs = contents.runs.into_iter().map(run).collect::<Result<_, SessionFileError>>()?;
    let seal = recording.seal.as_ref().filter(|_| contents.opened);
    let truth = seal.map(|seal| seal.open()).transpose()?.map(Arc::new);
    Ok(Session {
        recording: Some(Arc::new(recording)),
        findings: Arc::new(contents.findings),
        mapping: contents.mapping.map(Arc::new),
        split: contents.split,
        preset: contents.preset,
        plan: contents.plan,
        own_effects,
        ladder,
        runs,
        set_aside: contents.set_aside,
        report: entries.cbor(REPORT)?.map(with_evidence).map(Arc::new),
        proposals: entries.cbor(PROPOSALS)?.map(Arc::new),
        sweep: entries.cbor(SWEEP)?.map(Arc::new),
        truth,
        ..Session::default()
    })
}

fn with_evidence((mut report, evidence): WholeReport) -> Report {
    for (effect, evidence) in report.effects.iter_mut().zip(evidence) {
        effect.evidence = evidence;
    }
    report
}

/// Saves so that at every moment either the old or the new file is whole; the old one stays as `.bak`.
///
/// # Errors
/// [`SessionFileError`] with the file that can't be written.
pub fn save(path: &Path, session: &Session) -> Result<(), SessionFileError> {
    let problem = |problem| SessionFileError::File { path: path.to_owned(), problem };
    file::write_keeping_old(path, &to_bytes(session)?).map_err(problem)
}

/// Opens a saved session.
///
/// # Errors
/// [`SessionFileError`] says what is wrong; the file is left as it is.
pub fn open(path: &Path, monitor: &Monitor) -> Result<Session, SessionFileError> {
    let bytes =
        file::read(path, file::LARGEST).map_err(|problem| SessionFileError::File { path: path.to_owned(), problem })?;
    from_bytes(&bytes, monitor)
}

fn model_name(number: usize) -> String {
    format!("step-{}.model", number + 1)
}

fn run_name(number: usize) -> String {
    format!("step-{}.run", number + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::learned::{Layers, LearnedPreset};
    use crate::session::Command;
    use crate::simulation::extrapolation::Stretch;
    use crate::simulation::{Excitation, Scenario};
    use crate::training::Options;

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

    /// What was found, computed and trained takes minutes, so it is kept too.
    #[test]
    fn report_sweep_and_trainings_are_kept() {
        let run = |command: Command, session: &Session| command.run(session, &Monitor::new()).unwrap();
        let options = Options { epochs: 2, batch: 20, ..Options::ours() };
        let plan = Plan { options, layers: Layers { hidden: vec![4], ..Layers::default() }, ..Plan::default() };
        let train = Command::TrainPreset { preset: LearnedPreset::FfNn, plan: Box::new(plan) };
        let trained = run(train.clone(), &run(train, &repaired()));
        let solved = run(Command::ChoosePreset(Preset::RigidBody), &trained);
        let mut session = run(Command::Diagnose, &solved);
        let steps = session.ladder.clone();
        session = run(Command::Extrapolate { steps, stretch: Stretch::Speed }, &session);
        if let Some(sweep) = session.sweep.as_mut().map(Arc::make_mut) {
            // A model that explodes.
            sweep.curves[0].points[0].overall = f64::INFINITY;
        }
        let back = from_bytes(&to_bytes(&session).unwrap(), &Monitor::new()).unwrap();
        assert!(session.report.as_ref().is_some_and(|report| !report.effects[0].evidence.is_empty()));
        assert_eq!((&back.report, &back.sweep), (&session.report, &session.sweep));
        assert_eq!((back.runs.len(), back.ladder.len()), (2, 1));
        for (one, other) in back.runs.iter().zip(&session.runs) {
            let [one, other] = [one, other].map(|run| run.step().unwrap());
            assert_eq!((&one.evaluation, &one.run, &one.history), (&other.evaluation, &other.run, &other.history));
        }
        // A training that is the current model is still the same one.
        let chosen = run(Command::UseRun { run: 1 }, &session);
        let back = from_bytes(&to_bytes(&chosen).unwrap(), &Monitor::new()).unwrap();
        assert!(Arc::ptr_eq(back.current().unwrap(), back.runs[1].step().unwrap()));
        let resume = Command::Resume(back.current().unwrap().run.clone().unwrap());
        assert_eq!(run(resume, &back).current().unwrap().ending, Some(Ending::Finished));
    }

    /// Who opens it elsewhere has not the file of the effect.
    #[test]
    fn an_effect_of_ones_own_is_brought_along() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("magnet.toml");
        let text = "id = \"magnet\"\ndescription = \"d\"\nsource = \"s\"\n[[linear]]\nname = \"k\"\nunit = \"N m\"\ncolumn = \"sin(2 * q)\"\n";
        std::fs::write(&path, text).unwrap();
        let run = |command: Command, session: &Session| command.run(session, &Monitor::new()).unwrap();
        let loaded = run(Command::LoadEffect { path }, &repaired());
        assert_eq!(loaded.own_effects.len(), 1);
        let session = run(Command::AddEffect { effect: "magnet".into(), joints: vec![1] }, &loaded);
        let back = from_bytes(&to_bytes(&session).unwrap(), &Monitor::new()).unwrap();
        assert_eq!(back.own_effects, session.own_effects);
        assert_eq!(back.ladder[2].evaluation, session.ladder[2].evaluation);
        // The text comes with the file: a changed one is another effect, which can't be had beside the first.
        let mut entries = to_bytes(&session).unwrap();
        let place = entries.windows(10).position(|window| window == b"sin(2 * q)").unwrap();
        entries[place + 4] = b'3';
        let message = from_bytes(&entries, &Monitor::new()).map(|_| ()).unwrap_err().to_string();
        assert!(!message.is_empty(), "the check sum or the id tells it");
    }

    /// A file of version 1, as the program wrote it before.
    #[test]
    fn older_files_still_open() {
        let session = run_diagnosis(&repaired());
        let bytes = to_bytes(&session).unwrap();
        let mut entries = Entries(ZipArchive::new(Cursor::new(&bytes[..])).unwrap());
        let mut contents: serde_json::Value = serde_json::from_slice(&entries.bytes(CONTENTS).unwrap()).unwrap();
        let fields = contents.as_object_mut().unwrap();
        fields.insert("torquescope_session".into(), 1.into());
        assert!(fields.remove("ladder").is_some() && fields.remove("runs").is_some());
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        for name in [CONTENTS, RECORDING, "step-1.model", "step-2.model"] {
            archive.start_file(name, SimpleFileOptions::default()).unwrap();
            let entry = entries.bytes(name).unwrap();
            let old = if name == CONTENTS { serde_json::to_vec(&contents).unwrap() } else { entry };
            archive.write_all(&old).unwrap();
        }
        let back = from_bytes(&archive.finish().unwrap().into_inner(), &Monitor::new()).unwrap();
        assert_eq!((back.ladder.len(), back.runs.len(), back.report.is_none()), (2, 0, true));
        assert_eq!(back.ladder[1].evaluation, session.ladder[1].evaluation);
    }

    fn run_diagnosis(session: &Session) -> Session {
        Command::Diagnose.run(session, &Monitor::new()).unwrap()
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
