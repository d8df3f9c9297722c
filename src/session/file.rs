//! A document as a file: the recording with its sealed truth, every model, and every session that one can go back and forth to.
//!
//! An archive of `session.json`, `recording.npz`, one model file for each step of all ladders, the checkpoint of each
//! that was trained, and the reports, proposals and curves outside the data, each once; predictions and errors are computed anew when it is
//! opened. Of the sessions before and after, those of the same recording are kept. What the file was before stays as `.bak`.

use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

use super::error::SessionFileError;
use super::history::Entry;
use super::name::unique;
use super::{Bets, Document, Generation, History, Kept, Session, Source, Step, Study, View, default_name};
use crate::diagnosis::proposal::Proposals;
use crate::diagnosis::{Evidence, Report};
use crate::effect::own;
use crate::file::{self, Unpacking};
use crate::model::file::load_own_effects;
use crate::model::{Evaluation, Preset, Term};
use crate::progress::{Epoch, Event, Monitor};
use crate::recording::finding::Finding;
use crate::recording::mapping::Mapping;
use crate::recording::read::own_recording;
use crate::recording::split::Split;
use crate::recording::write::to_npz_bytes;
use crate::simulation::extrapolation::Sweep;
use crate::training::Ending;
use crate::training::fit::{self, Plan, SavedRun};
use crate::training::rollout::Rollout;

/// Ending of session files.
pub const ENDING: &str = "torquescope";
/// Written into every file. Version 1 had no report, no sweep and no earlier trainings, version 2 one session alone, and a
/// report that told other things than one of today: it is left out. In version 3 models had sentences in place of names, and only
/// those that were trained were kept when the ladder went on without them. A newer file is refused.
const VERSION: u32 = 4;
/// The first version whose models have names.
const NAMES_SINCE: u32 = 4;
/// The first version whose reports can be read.
const REPORTS_SINCE: u32 = 3;
const CONTENTS: &str = "session.json";
const RECORDING: &str = "recording.npz";

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Contents {
    torquescope_session: u32,
    findings: Vec<Finding>,
    mapping: Option<Mapping>,
    /// Not of one that spells out what is sealed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    source: Option<Source>,
    split: Split,
    /// The files of effects of one's own; loaded before the rest, which has them by their ids.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    own_effects: Vec<String>,
    /// Every step once: those of all ladders.
    steps: Vec<StepAbout>,
    /// From the oldest that can be undone to the newest that can be done again.
    sessions: Vec<SessionAbout>,
    /// What led from each of them to the next.
    changes: Vec<String>,
    /// Which of them is the current one.
    current: usize,
    /// Whether the user had opened the seal.
    opened: bool,
    bets: Bets,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    study: Option<Study>,
    view: ViewAbout,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StepAbout {
    /// None in a file of before, which had a title that told what was added.
    #[serde(default)]
    name: Option<String>,
    #[serde(default, rename = "title", skip_serializing)]
    _title: Option<String>,
    history: Vec<Epoch>,
    ending: Option<Ending>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    rollout: Option<Rollout>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SessionAbout {
    preset: Preset,
    plan: Plan,
    set_aside: Vec<Term>,
    ladder: Vec<usize>,
    /// Before, only those that were trained.
    #[serde(alias = "runs")]
    models: Vec<KeptAbout>,
    /// Which of the reports, of the proposals and of the curves it has.
    report: Option<usize>,
    #[serde(default)]
    proposals: Option<usize>,
    sweep: Option<usize>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct KeptAbout {
    preset: Preset,
    ladder: Vec<usize>,
}

#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ViewAbout {
    screen: String,
    trajectory: usize,
    joint: usize,
    overlaid: Vec<usize>,
    layouts: serde_json::Value,
    #[serde(default)]
    setup: serde_json::Value,
    #[serde(default)]
    sight: serde_json::Value,
}

/// A file of version 1 or 2.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct OldContents {
    torquescope_session: u32,
    findings: Vec<Finding>,
    mapping: Option<Mapping>,
    split: Split,
    preset: Preset,
    plan: Plan,
    #[serde(default)]
    own_effects: Vec<String>,
    set_aside: Vec<Term>,
    steps: Vec<StepAbout>,
    /// All steps in a file of version 1.
    ladder: Option<Vec<usize>>,
    #[serde(default)]
    runs: Vec<KeptAbout>,
    opened: bool,
}

impl OldContents {
    /// The same in the form of this version, without its report; whether it had proposals or curves, its entries tell.
    fn renewed(self, [has_proposals, has_sweep]: [bool; 2]) -> Contents {
        let session = SessionAbout {
            preset: self.preset,
            plan: self.plan,
            set_aside: self.set_aside,
            ladder: self.ladder.unwrap_or_else(|| (0..self.steps.len()).collect()),
            models: self.runs,
            report: None,
            proposals: has_proposals.then_some(0),
            sweep: has_sweep.then_some(0),
        };
        Contents {
            torquescope_session: self.torquescope_session,
            findings: self.findings,
            mapping: self.mapping,
            source: None,
            split: self.split,
            own_effects: self.own_effects,
            steps: self.steps,
            sessions: vec![session],
            changes: Vec::new(),
            current: 0,
            opened: self.opened,
            bets: Bets::default(),
            study: None,
            view: ViewAbout::default(),
        }
    }
}

/// A report with the evidence that its form for people leaves out: that of each effect.
type WholeReport = (Report, Vec<Vec<Evidence>>);

fn damaged(error: impl std::fmt::Display) -> SessionFileError {
    SessionFileError::Damaged(error.to_string())
}

/// Shared parts, each once, however many sessions have it.
struct Shared<T>(Vec<Arc<T>>);

impl<T> Shared<T> {
    fn places<'a>(&mut self, parts: impl IntoIterator<Item = &'a Arc<T>>) -> Vec<usize>
    where
        T: 'a,
    {
        parts.into_iter().map(|part| self.place(part)).collect()
    }

    fn place(&mut self, part: &Arc<T>) -> usize {
        self.0.iter().position(|known| Arc::ptr_eq(known, part)).unwrap_or_else(|| {
            self.0.push(Arc::clone(part));
            self.0.len() - 1
        })
    }

    /// The parts at these places.
    fn at(&self, places: &[usize]) -> Result<Vec<Arc<T>>, SessionFileError> {
        let part = |&place: &usize| self.0.get(place).cloned().ok_or_else(|| damaged("a part of it is missing"));
        places.iter().map(part).collect()
    }

    fn at_most_one(&self, place: Option<usize>) -> Result<Option<Arc<T>>, SessionFileError> {
        Ok(self.at(place.as_slice())?.pop())
    }
}

/// All that sessions share.
struct Parts {
    steps: Shared<Step>,
    reports: Shared<Report>,
    proposals: Shared<Proposals>,
    sweeps: Shared<Sweep>,
}

impl Parts {
    fn new() -> Self {
        Parts {
            steps: Shared(Vec::new()),
            reports: Shared(Vec::new()),
            proposals: Shared(Vec::new()),
            sweeps: Shared(Vec::new()),
        }
    }

    /// What tells a session from the others of its recording.
    fn about(&mut self, session: &Session) -> SessionAbout {
        let steps = &mut self.steps;
        let ladder = steps.places(&session.ladder);
        let kept = |kept: &Kept| KeptAbout { preset: kept.preset, ladder: steps.places(&kept.ladder) };
        SessionAbout {
            ladder,
            models: session.models.iter().map(kept).collect(),
            preset: session.preset,
            plan: session.plan.clone(),
            set_aside: session.set_aside.clone(),
            report: session.report.as_ref().map(|report| self.reports.place(report)),
            proposals: session.proposals.as_ref().map(|proposals| self.proposals.place(proposals)),
            sweep: session.sweep.as_ref().map(|sweep| self.sweeps.place(sweep)),
        }
    }

    /// A session that differs from `common` by what is told of it.
    fn session(&self, about: SessionAbout, common: &Session) -> Result<Session, SessionFileError> {
        let kept = |kept: KeptAbout| Ok(Kept { preset: kept.preset, ladder: self.steps.at(&kept.ladder)? });
        Ok(Session {
            generation: Generation::next(),
            ladder: self.steps.at(&about.ladder)?,
            models: about.models.into_iter().map(kept).collect::<Result<_, SessionFileError>>()?,
            preset: about.preset,
            plan: about.plan,
            set_aside: about.set_aside,
            report: self.reports.at_most_one(about.report)?,
            proposals: self.proposals.at_most_one(about.proposals)?,
            sweep: self.sweeps.at_most_one(about.sweep)?,
            ..common.clone()
        })
    }
}

/// The document as bytes.
///
/// # Errors
/// [`SessionFileError`] if it is empty or a part of it can't be written.
pub fn to_bytes(document: &Document) -> Result<Vec<u8>, SessionFileError> {
    let Document { history, view } = document;
    let session = &history.current;
    let recording = session.recording.as_deref().ok_or(SessionFileError::Empty)?;
    let is_of_it = |entry: &&Entry| entry.session.has_recording_of(session);
    let past: Vec<&Entry> = history.past.iter().rev().take_while(is_of_it).collect();
    let future: Vec<&Entry> = history.future.iter().rev().take_while(is_of_it).collect();
    let mut parts = Parts::new();
    let before = past.iter().rev().map(|entry| &entry.session);
    let known: Vec<&Session> = before.chain([session]).chain(future.iter().map(|entry| &entry.session)).collect();
    let sessions = known.iter().map(|session| parts.about(session)).collect();
    let changes = past.iter().rev().chain(&future).map(|entry| entry.change.clone()).collect();
    let view = ViewAbout {
        screen: view.screen.clone(),
        trajectory: view.trajectory,
        joint: view.joint,
        overlaid: parts.steps.places(&view.overlaid),
        layouts: view.layouts.clone(),
        setup: view.setup.clone(),
        sight: view.sight.clone(),
    };
    let about = |step: &Arc<Step>| StepAbout {
        name: Some(step.name.clone()),
        _title: None,
        history: step.history.clone(),
        ending: step.ending.clone(),
        rollout: step.rollout.clone(),
    };
    let contents = Contents {
        torquescope_session: VERSION,
        findings: session.findings.to_vec(),
        mapping: session.mapping.as_deref().cloned(),
        source: source(session),
        split: session.split.clone(),
        own_effects: own_effects(&known, &parts),
        steps: parts.steps.0.iter().map(about).collect(),
        sessions,
        changes,
        current: past.len(),
        opened: session.truth.is_some(),
        bets: session.bets.clone(),
        study: session.study.as_deref().cloned(),
        view,
    };
    let json = serde_json::to_vec_pretty(&contents).map_err(damaged)?;
    let mut entries = vec![(CONTENTS.to_owned(), json), (RECORDING.to_owned(), to_npz_bytes(recording)?)];
    for (number, step) in parts.steps.0.iter().enumerate() {
        entries.push((model_name(number), fit::to_bytes(&step.fitted)?));
        if let Some(run) = &step.run {
            entries.push((run_name(number), run.to_bytes()?));
        }
    }
    for (number, report) in parts.reports.0.iter().enumerate() {
        let evidence: Vec<&Vec<Evidence>> = report.effects.iter().map(|effect| &effect.evidence).collect();
        entries.push((report_name(number), to_cbor(&(report.as_ref(), evidence))?));
    }
    for (number, proposals) in parts.proposals.0.iter().enumerate() {
        entries.push((proposals_name(number), to_cbor(proposals.as_ref())?));
    }
    for (number, sweep) in parts.sweeps.0.iter().enumerate() {
        entries.push((sweep_name(number), to_cbor(sweep.as_ref())?));
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

/// Where its recording comes from, unless that spells out what nobody looked at yet.
fn source(session: &Session) -> Option<Source> {
    let source = session.source.as_deref()?;
    (session.truth.is_some() || !source.tells_the_truth()).then(|| source.clone())
}

/// The files of all effects of one's own that the sessions know or have in a model.
fn own_effects(sessions: &[&Session], parts: &Parts) -> Vec<String> {
    let in_models = parts.steps.0.iter().flat_map(|step| step.fitted.model.effects());
    let set_aside = sessions.iter().flat_map(|session| &session.set_aside).filter_map(|term| match term {
        Term::Effect(term) => Some(term),
        Term::RigidBody(_) | Term::Resistance(_) | Term::Learned(_) => None,
    });
    let known = sessions.iter().flat_map(|session| session.own_effects.iter().copied());
    own::texts(known.chain(in_models.chain(set_aside).map(|term| term.effect)))
}

fn to_cbor(value: &impl Serialize) -> Result<Vec<u8>, SessionFileError> {
    let mut bytes = Vec::new();
    ciborium::into_writer(value, &mut bytes).map_err(damaged)?;
    Ok(bytes)
}

/// The entries of a session's archive.
struct Entries<'a>(ZipArchive<Cursor<&'a [u8]>>, Unpacking);

impl<'a> Entries<'a> {
    fn of(bytes: &'a [u8]) -> Result<Self, SessionFileError> {
        Ok(Entries(ZipArchive::new(Cursor::new(bytes)).map_err(damaged)?, Unpacking::of(bytes.len())))
    }

    fn bytes(&mut self, name: &str) -> Result<Vec<u8>, SessionFileError> {
        let part = self.0.by_name(name).map_err(|error| damaged(format!("{name}: {error}")))?;
        self.1.part(part).map_err(|error| damaged(format!("{name}: {error}")))
    }

    fn has(&self, name: &str) -> bool {
        self.0.index_for_name(name).is_some()
    }

    /// An entry that not every session has.
    fn if_there(&mut self, name: &str) -> Result<Option<Vec<u8>>, SessionFileError> {
        self.has(name).then(|| self.bytes(name)).transpose()
    }

    fn cbor<T: DeserializeOwned>(&mut self, name: &str) -> Result<T, SessionFileError> {
        let bytes = self.bytes(name)?;
        ciborium::from_reader(&bytes[..]).map_err(|error| damaged(format!("{name}: {error}")))
    }

    fn contents(&mut self) -> Result<Contents, SessionFileError> {
        let json = self.bytes(CONTENTS)?;
        let value: serde_json::Value = serde_json::from_slice(&json).map_err(damaged)?;
        match value.get("torquescope_session").and_then(serde_json::Value::as_u64) {
            None => Err(damaged("it says no version")),
            Some(version) if !(1..=u64::from(VERSION)).contains(&version) => {
                Err(SessionFileError::Version { version, newest: VERSION })
            }
            Some(1 | 2) => {
                load_own_effects(&value)?;
                let old: OldContents = serde_json::from_slice(&json).map_err(damaged)?;
                Ok(old.renewed([proposals_name(0), sweep_name(0)].map(|name| self.has(&name))))
            }
            Some(_) => {
                load_own_effects(&value)?;
                serde_json::from_slice(&json).map_err(damaged)
            }
        }
    }

    /// Parts that are counted, as many as there are.
    fn counted<T: DeserializeOwned>(&mut self, name: fn(usize) -> String) -> Result<Vec<T>, SessionFileError> {
        let mut parts = Vec::new();
        while self.has(&name(parts.len())) {
            parts.push(self.cbor(&name(parts.len()))?);
        }
        Ok(parts)
    }
}

/// The document that was saved as these bytes, its predictions computed anew.
///
/// # Errors
/// [`SessionFileError`] says what is damaged; nothing is opened then.
pub fn from_bytes(bytes: &[u8], monitor: &Monitor) -> Result<Document, SessionFileError> {
    let mut entries = Entries::of(bytes)?;
    let contents = entries.contents()?;
    let has_readable_reports = contents.torquescope_session >= REPORTS_SINCE;
    if !has_readable_reports && entries.has(&report_name(0)) {
        monitor.tell(Event::Warning(format!(
            "the session has version {}, whose report of a diagnosis can't be read any more and is left out: diagnose again",
            contents.torquescope_session
        )));
    }
    let recording = own_recording(&entries.bytes(RECORDING)?, monitor)?;
    let fits = |segment: &crate::recording::split::Segment| {
        recording
            .trajectories
            .get(segment.trajectory)
            .is_some_and(|run| segment.samples.start <= segment.samples.end && segment.samples.end <= run.len())
    };
    if !contents.split.stretches().all(fits) {
        return Err(damaged("its split is of another recording"));
    }
    let own_effects = contents.own_effects.iter().map(|text| own::load(text)).collect::<Result<_, _>>()?;
    let count = contents.steps.len();
    let mut parts = Parts::new();
    for (number, StepAbout { name, history, ending, rollout, .. }) in contents.steps.into_iter().enumerate() {
        let fitted = fit::from_bytes(&entries.bytes(&model_name(number))?)?;
        let name = name.unwrap_or_else(|| {
            let taken = parts.steps.0.iter().map(|known| known.name.as_str());
            unique(&default_name(&fitted.model), taken)
        });
        monitor.report(number as f32 / count as f32, &name)?;
        if fitted.setting().kinds.len() != recording.joint_count() {
            return Err(damaged(format!("“{name}” is a model of another recording")));
        }
        let run = entries.if_there(&run_name(number))?.map(|bytes| SavedRun::from_bytes(&bytes)).transpose()?;
        let evaluation = Evaluation::of(&fitted, &recording, &contents.split)?;
        let (generation, run) = (Generation::next(), run.map(Arc::new));
        parts.steps.0.push(Arc::new(Step { generation, name, fitted, evaluation, history, ending, rollout, run }));
    }
    if has_readable_reports {
        parts.reports.0.extend(entries.counted(report_name)?.into_iter().map(with_evidence).map(Arc::new));
    }
    parts.proposals.0.extend(entries.counted(proposals_name)?.into_iter().map(Arc::new));
    parts.sweeps.0.extend(entries.counted(sweep_name)?.into_iter().map(Arc::new));
    let seal = recording.seal.as_ref().filter(|_| contents.opened);
    let truth = seal.map(|seal| seal.open()).transpose()?.map(Arc::new);
    let ViewAbout { screen, trajectory, joint, overlaid, layouts, setup, sight } = contents.view;
    let view = View { screen, trajectory, joint, overlaid: parts.steps.at(&overlaid)?, layouts, setup, sight };
    if trajectory >= recording.trajectories.len() || joint >= recording.joint_count() {
        return Err(damaged("it looks at a trajectory or joint that is not there"));
    }
    let common = Session {
        recording: Some(Arc::new(recording)),
        findings: Arc::new(contents.findings),
        mapping: contents.mapping.map(Arc::new),
        source: contents.source.map(Arc::new),
        split: contents.split,
        own_effects,
        truth,
        bets: contents.bets,
        study: contents.study.map(Arc::new),
        ..Session::default()
    };
    let mut sessions: Vec<Session> =
        contents.sessions.into_iter().map(|about| parts.session(about, &common)).collect::<Result<_, _>>()?;
    if contents.torquescope_session < NAMES_SINCE {
        keep_models(&mut sessions);
    }
    let history = History::of(sessions, contents.changes, contents.current);
    Ok(Document { history: history.ok_or_else(|| damaged("its sessions do not follow each other"))?, view })
}

/// Of sessions of before, each keeps the models of those that led to it, as it would have done.
fn keep_models(sessions: &mut [Session]) {
    let mut known: Vec<Kept> = Vec::new();
    for session in sessions {
        let is_new = |kept: &Kept| !known.iter().any(|old| old.step().map(Arc::as_ptr) == kept.step().map(Arc::as_ptr));
        let own: Vec<Kept> = session.models.iter().filter(|kept| is_new(kept)).cloned().collect();
        let models = [known.as_slice(), &own].concat();
        *session = Session { models, ..std::mem::take(session) }.remembering_its_models();
        known.clone_from(&session.models);
    }
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
pub fn save(path: &Path, document: &Document) -> Result<(), SessionFileError> {
    let problem = |problem| SessionFileError::File { path: path.to_owned(), problem };
    file::write_keeping_old(path, &to_bytes(document)?).map_err(problem)
}

/// Whether a file is a session by its name, or what is left of one beside it.
pub fn is_session(path: &Path) -> bool {
    let has_ending = |path: &Path| path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(ENDING));
    has_ending(path) || file::owner(path).is_some_and(|owner| has_ending(&owner))
}

/// What was opened.
#[derive(Debug, Clone)]
pub struct Opened {
    /// What the file holds.
    pub document: Document,
    /// By which one tells later whether the file was changed; `None` if the file itself is gone.
    pub mark: Option<file::Mark>,
    /// What was opened in its place: what it was to become when its saving was cut off, or what is left of a file that is gone.
    pub instead: Option<PathBuf>,
}

/// Opens a saved document. What was whole when its saving was cut off is opened in its place, as is what is left of a file that is
/// gone; a warning tells so.
///
/// # Errors
/// [`SessionFileError`] says what is wrong; the file is left as it is.
pub fn open(path: &Path, monitor: &Monitor) -> Result<Opened, SessionFileError> {
    // What is written while this reads is another file.
    let mark = file::mark(path);
    let first_whole = |of: Vec<PathBuf>| {
        let whole = |path: PathBuf| Some((read(&path, &monitor.quiet()).ok()?, path));
        of.into_iter().find_map(whole)
    };
    let opened = |(document, instead): (Document, PathBuf), why: &str| {
        let warning = format!("{} {why}: {} was opened in its place", path.display(), instead.display());
        monitor.tell(Event::Warning(warning));
        Ok(Opened { document, mark, instead: Some(instead) })
    };
    if let Some(newer) = first_whole(file::unfinished(path)) {
        return opened(newer, "is as it was before its last saving, which was cut off");
    }
    let problem = match read(path, monitor) {
        Ok(document) => return Ok(Opened { document, mark, instead: None }),
        Err(SessionFileError::Stopped(stopped)) => return Err(stopped.into()),
        Err(problem) => problem,
    };
    match (first_whole(file::remains(path)), mark) {
        (Some(left), None) => opened(left, "is gone"),
        (Some((_, left)), Some(_)) => Err(SessionFileError::Left { problem: Box::new(problem), left }),
        (None, _) => Err(problem),
    }
}

fn read(path: &Path, monitor: &Monitor) -> Result<Document, SessionFileError> {
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

fn report_name(number: usize) -> String {
    numbered("report", number)
}

fn proposals_name(number: usize) -> String {
    numbered("proposals", number)
}

fn sweep_name(number: usize) -> String {
    numbered("sweep", number)
}

/// The first without a number, as in files of version 2, which had no other.
fn numbered(name: &str, number: usize) -> String {
    if number == 0 { format!("{name}.cbor") } else { format!("{name}-{}.cbor", number + 1) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::learned::{Layers, LearnedPreset};
    use crate::session::{Command, Guess};
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

    /// The bytes of a session that nobody has looked at, and the session that they give.
    fn bytes_of(session: &Session) -> Vec<u8> {
        to_bytes(&session.clone().into()).unwrap()
    }

    fn back_from(bytes: &[u8]) -> Session {
        from_bytes(bytes, &Monitor::new()).unwrap().history.current().clone()
    }

    #[test]
    fn a_session_comes_back_as_it_was() {
        let session = repaired();
        let bytes = bytes_of(&session);
        assert_eq!(bytes, bytes_of(&session), "equal sessions give equal bytes");
        let back = back_from(&bytes);
        assert_eq!(back.recording, session.recording);
        assert_eq!((back.ladder.len(), &back.split), (2, &session.split));
        for (one, other) in back.ladder.iter().zip(&session.ladder) {
            assert_eq!((&one.name, &one.fitted, &one.evaluation), (&other.name, &other.fitted, &other.evaluation));
        }
    }

    /// Trains a small network, so that a run is a moment's work.
    fn train() -> Command {
        let options = Options { epochs: 2, batch: 20, ..Options::ours() };
        let plan = Plan { options, layers: Layers { hidden: vec![4], ..Layers::default() }, ..Plan::default() };
        Command::TrainPreset { preset: LearnedPreset::FfNn, plan: Box::new(plan) }
    }

    fn run(command: Command, session: &Session) -> Session {
        command.run(session, &Monitor::new()).unwrap()
    }

    /// What was found, computed and trained takes minutes, so it is kept too.
    #[test]
    fn report_sweep_and_trainings_are_kept() {
        let mut trained = repaired();
        for _ in 0..4 {
            trained = run(train(), &trained);
        }
        let solved = run(Command::ChoosePreset(Preset::RigidBody), &trained);
        let mut session = run(Command::Diagnose, &solved);
        let steps = session.ladder.clone();
        session = run(Command::Extrapolate { steps, stretch: Stretch::Speed }, &session);
        if let Some(sweep) = session.sweep.as_mut().map(Arc::make_mut) {
            // A model that explodes.
            sweep.curves[0].points[0].overall = f64::INFINITY;
        }
        let back = back_from(&bytes_of(&session));
        assert!(session.report.as_ref().is_some_and(|report| !report.effects[0].evidence.is_empty()));
        assert_eq!((&back.report, &back.sweep), (&session.report, &session.sweep));
        let names = ["rigid body", "rigid body + Coulomb 1, 2", "FF-NN", "FF-NN (2)", "FF-NN (3)", "FF-NN (4)"];
        assert!(back.all_models().map(|step| step.name.as_str()).eq(names));
        assert_eq!(back.ladder.len(), 1);
        for (one, other) in back.all_models().zip(session.all_models()) {
            assert_eq!((&one.evaluation, &one.run, &one.history), (&other.evaluation, &other.run, &other.history));
        }
        // A training that is the current model is still the same one.
        let chosen = run(Command::TakeUp { name: "FF-NN (2)".to_owned() }, &session);
        let back = back_from(&bytes_of(&chosen));
        assert!(Arc::ptr_eq(back.current().unwrap(), back.model("FF-NN (2)").unwrap()));
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
        let loaded = run(Command::LoadEffect { path }, &repaired());
        assert_eq!(loaded.own_effects.len(), 1);
        let session = run(Command::AddEffect { effect: "magnet".into(), joints: vec![1] }, &loaded);
        let back = back_from(&bytes_of(&session));
        assert_eq!(back.own_effects, session.own_effects);
        assert_eq!(back.ladder[2].evaluation, session.ladder[2].evaluation);
        // The text comes with the file: a changed one is another effect, which can't be had beside the first.
        let mut entries = bytes_of(&session);
        let place = entries.windows(10).position(|window| window == b"sin(2 * q)").unwrap();
        entries[place + 4] = b'3';
        let message = from_bytes(&entries, &Monitor::new()).map(|_| ()).unwrap_err().to_string();
        assert!(!message.is_empty(), "the check sum or the id tells it");
    }

    /// What can be undone and done again, what was said and seen, and where one looked.
    #[test]
    fn the_whole_document_is_kept() {
        let first = repaired();
        let mut history = History::new(Session::default());
        history.push(first.clone(), "simulate");
        history.settle(run(Command::BetFirst(true), history.current()));
        for command in [Command::GoTo { step: 0 }, train(), Command::Diagnose, Command::ChoosePreset(Preset::RigidBody)]
        {
            let title = command.title();
            history.push(run(command, history.current()), &title);
        }
        history.undo();
        history.settle(run(Command::OpenSeal, history.current()));
        let guess = Guess::Effect("backlash".to_owned());
        history.settle(run(Command::PlaceBet(guess.clone()), history.current()));
        let view = View {
            screen: "compare".to_owned(),
            trajectory: 1,
            joint: 2,
            overlaid: vec![Arc::clone(&first.ladder[1])],
            layouts: serde_json::json!({ "compare": [1, 2] }),
            setup: serde_json::json!({ "beside": 0 }),
            sight: serde_json::json!({ "cursor": 1.5 }),
        };
        let bytes = to_bytes(&Document { history: history.clone(), view: view.clone() }).unwrap();
        let back = from_bytes(&bytes, &Monitor::new()).unwrap();
        assert_eq!((back.view.screen, back.view.layouts), (view.screen, view.layouts));
        assert_eq!((back.view.setup, back.view.sight), (view.setup, view.sight));
        assert_eq!((back.view.trajectory, back.view.joint), (view.trajectory, view.joint));
        let (mut own, mut back_history) = (history, back.history);
        assert_eq!(back_history.current().guess(), Some(&guess));
        assert!(back_history.current().bets.first && back_history.current().truth.is_some());
        let of = |history: &History| {
            let session = history.current();
            let names: Vec<String> = session.ladder.iter().map(|step| step.name.clone()).collect();
            (names, session.report.clone(), session.truth.clone(), session.preset, session.models.len())
        };
        for _ in 0..3 {
            let all = [&own, &back_history].map(|history| (of(history), history.redo_text().map(str::to_owned)));
            assert_eq!(all[0], all[1]);
            [&mut own, &mut back_history].into_iter().for_each(History::redo);
            assert_eq!(of(&own), of(&back_history));
            for history in [&mut own, &mut back_history] {
                (0..2).for_each(|_| history.undo());
            }
        }
        // The model that was drawn over the current one is one of those that can be gone back to.
        assert!(back_history.current().ladder.iter().any(|step| Arc::ptr_eq(step, &back.view.overlaid[0])));
        let before = [own.undo_text(), back_history.undo_text()];
        assert_eq!(before, [Some("simulate"), None], "what was before the recording is of another file");
    }

    /// Files of versions 1 to 3, as the program wrote them before.
    #[test]
    fn older_files_still_open() {
        let session = run_diagnosis(&run(train(), &repaired()));
        let bytes = bytes_of(&session);
        let mut entries = Entries::of(&bytes).unwrap();
        let mut whole: serde_json::Value = serde_json::from_slice(&entries.bytes(CONTENTS).unwrap()).unwrap();
        // The only one that was kept then: the trained one, which has the first place.
        whole["steps"].as_array_mut().unwrap().truncate(1);
        let step = whole["steps"][0].as_object_mut().unwrap();
        step.remove("name").unwrap();
        step.insert("title".into(), "one network gives the torque".into());
        let own = whole["sessions"][0].as_object_mut().unwrap();
        let mut runs = own.remove("models").unwrap();
        runs.as_array_mut().unwrap().drain(..2);
        own.insert("runs".into(), runs);
        let mut old_file = |version: u32| {
            let mut contents = whole.clone();
            let fields = contents.as_object_mut().unwrap();
            fields.insert("torquescope_session".into(), version.into());
            if version < 3 {
                let own = fields.remove("sessions").unwrap()[0].clone();
                ["changes", "current", "bets", "view"].iter().for_each(|name| drop(fields.remove(*name).unwrap()));
                let kept = ["preset", "plan", "set_aside", "ladder", "runs"];
                for name in &kept[..if version == 1 { 3 } else { 5 }] {
                    fields.insert((*name).into(), own[*name].clone());
                }
            }
            let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
            let names: Vec<String> = (0..entries.0.len())
                .map(|index| entries.0.by_index(index).unwrap().name().unwrap().into_owned())
                .filter(|name| version > 1 || !(name.ends_with(".run") || name.ends_with(".cbor")))
                .collect();
            for name in names {
                archive.start_file(&name, SimpleFileOptions::default()).unwrap();
                let entry = entries.bytes(&name).unwrap();
                let old = match name.as_str() {
                    CONTENTS => serde_json::to_vec(&contents).unwrap(),
                    "report.cbor" if version < REPORTS_SINCE => old_report(&entry),
                    _ => entry,
                };
                archive.write_all(&old).unwrap();
            }
            archive.finish().unwrap().into_inner()
        };
        let monitor = Monitor::new();
        let open = |version: u32| from_bytes(&old_file(version), &monitor).unwrap().history.current().clone();
        let all = [1, 2, 3].map(open);
        for (version, old) in (1..).zip(&all) {
            assert_eq!((old.ladder.len(), old.models.len(), old.report.is_none()), (1, 1, version < REPORTS_SINCE));
            assert_eq!((old.ladder[0].name.as_str(), old.models[0].ladder.len()), ("FF-NN", 1), "version {version}");
            assert_eq!(old.ladder[0].evaluation, session.ladder[0].evaluation);
        }
        let second = &all[1];
        assert_eq!((second.preset, &second.plan), (session.preset, &session.plan));
        let text = |event| if let Event::Warning(text) = event { Some(text) } else { None };
        let told: Vec<String> = monitor.take_events().into_iter().filter_map(text).collect();
        assert!(matches!(told.as_slice(), [text] if text.contains("version 2, whose report")), "{told:?}");
    }

    /// A report as the program wrote it before it told presence and form apart; it can't be read as one of today.
    fn old_report(entry: &[u8]) -> Vec<u8> {
        let mut whole: serde_json::Value = ciborium::from_reader(entry).unwrap();
        let report = whole[0].as_object_mut().unwrap();
        ["presence", "completeness"].iter().for_each(|name| drop(report.remove(*name).unwrap()));
        for effect in report["effects"].as_array_mut().unwrap() {
            let effect = effect.as_object_mut().unwrap();
            effect.remove("form").unwrap();
            let presence = effect.remove("presence").unwrap();
            effect.insert("confidence".to_owned(), presence);
        }
        let old = to_cbor(&whole).unwrap();
        assert!(ciborium::from_reader::<WholeReport, _>(&old[..]).is_err());
        old
    }

    #[test]
    fn what_is_left_of_a_file_is_opened_in_its_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mine.torquescope");
        let document = Document::from(repaired());
        save(&path, &document).unwrap();
        let known = super::open(&path, &Monitor::new()).unwrap();
        assert_eq!((known.instead, known.mark), (None, file::mark(&path)));
        save(&path, &document).unwrap();
        std::fs::remove_file(&path).unwrap();
        // A newer one that was never finished is passed over.
        std::fs::write(folder.path().join("mine.torquescope.12-0.new"), b"PK").unwrap();
        let found = super::open(&path, &Monitor::new()).unwrap();
        assert_eq!((found.instead, found.mark), (Some(folder.path().join("mine.torquescope.bak")), None));
        assert_eq!(found.document.history.current().ladder.len(), 2);
        // One that is there and damaged is not passed over, but its old one is named.
        std::fs::write(&path, b"PK").unwrap();
        let damaged = super::open(&path, &Monitor::new()).unwrap_err();
        assert!(matches!(damaged, SessionFileError::Left { .. }) && damaged.to_string().contains("torquescope.bak"));
        let nothing = super::open(&folder.path().join("other.torquescope"), &Monitor::new());
        assert!(matches!(nothing, Err(SessionFileError::File { .. })));
    }

    /// A kill between writing and renaming: what was to be saved is there, and whole.
    #[test]
    fn what_was_being_saved_is_opened_and_told() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let path = at("mine.torquescope");
        let session = repaired();
        let shorter = Session { ladder: session.ladder[..1].to_vec(), ..session.clone() };
        save(&path, &shorter.into()).unwrap();
        let mine = file::mark(&path);
        let drafts = [at("mine.torquescope.12-0.new"), at("mine.torquescope.12-1.new")];
        let seconds = |late: u64| mine.unwrap().written().unwrap() + std::time::Duration::from_secs(late);
        for (draft, bytes, late) in [(&drafts[0], bytes_of(&session), 1), (&drafts[1], b"PK".to_vec(), 2)] {
            std::fs::write(draft, bytes).unwrap();
            std::fs::File::options().write(true).open(draft).unwrap().set_modified(seconds(late)).unwrap();
        }
        let monitor = Monitor::new();
        let opened = super::open(&path, &monitor).unwrap();
        assert_eq!((opened.instead, opened.mark), (Some(drafts[0].clone()), mine));
        assert_eq!(opened.document.history.current().ladder.len(), 2);
        assert!(
            monitor
                .take_events()
                .iter()
                .any(|event| matches!(event, Event::Warning(text) if text.contains("12-0.new")))
        );
        assert!(is_session(&drafts[0]) && is_session(&path) && !is_session(&at("log.csv.bak")));
    }

    fn run_diagnosis(session: &Session) -> Session {
        Command::Diagnose.run(session, &Monitor::new()).unwrap()
    }

    #[test]
    fn damaged_files_are_refused_and_the_old_one_is_kept() {
        let session = repaired();
        let bytes = bytes_of(&session);
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
        save(&path, &session.clone().into()).unwrap();
        let shorter = Session { ladder: session.ladder[..1].to_vec(), ..session.clone() };
        save(&path, &shorter.into()).unwrap();
        let ladder = |path: &Path| super::open(path, &Monitor::new()).unwrap().document.history.current().ladder.len();
        assert_eq!(ladder(&path), 1);
        assert_eq!(ladder(&folder.path().join("mine.torquescope.bak")), 2);
        let nowhere = folder.path().join("no/such/folder/mine.torquescope");
        assert!(save(&nowhere, &session.into()).unwrap_err().to_string().contains("Check the folder"));
        assert!(matches!(save(&path, &Session::default().into()), Err(SessionFileError::Empty)));
    }
}
