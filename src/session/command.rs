//! Everything that changes a session, as values: the window and the command line send the same ones.

use std::path::PathBuf;
use std::sync::Arc;

use super::error::SessionError;
use super::step::{step, trained};
use super::study::{self, Note, SetUp};
use super::terms::{self, TermEdit};
use super::{Bets, Generation, Guess, Session, Source, Step, beside, default_name, file, models, seeds};
use crate::diagnosis;
use crate::diagnosis::proposal::propose;
use crate::effect::registry;
use crate::model::learned::LearnedPreset;
use crate::model::{Fitted, Model, ModelError, Preset};
use crate::progress::{Event, Monitor};
use crate::recording::Recording;
use crate::recording::check::{Checked, Finding, FindingKind, check};
use crate::recording::correction::Correction;
use crate::recording::read::{self, ReadOptions};
use crate::recording::split::{Segment, Split};
use crate::simulation::extrapolation::{self, Stretch};
use crate::simulation::{self, Level, Making, Scenario, world};
use crate::training;
use crate::training::fit::{Plan, SavedRun};

/// A change of the session.
#[derive(Debug, Clone)]
#[expect(clippy::large_enum_variant, reason = "there is one command at a time, so its size does not matter")]
pub enum Command {
    /// Reads files as one recording and fits the preset.
    Open {
        /// One or more files; each is a trajectory, or holds several.
        paths: Vec<PathBuf>,
        /// How to read them.
        options: ReadOptions,
        /// Names of trajectories to hold out; with none, the split is automatic.
        held_out: Vec<String>,
    },
    /// Reads files as further trajectories of the recording, all held out, and holds every model against them; none is fitted anew.
    Beside {
        /// One or more files, read as the first were.
        paths: Vec<PathBuf>,
    },
    /// Sets right how the recording is set up, and fits the preset anew.
    SetRight(Vec<Correction>),
    /// Opens a session that was saved.
    Restore {
        /// The file.
        path: PathBuf,
    },
    /// Simulates a recording and fits the preset.
    Simulate(Box<Scenario>),
    /// Lets a world of rigid bodies happen, and fits the preset to what was logged there.
    SimulateWorld(Box<world::Scenario>),
    /// Draws a mystery, simulates it and fits the preset.
    DrawMystery {
        /// How hard it is.
        level: Level,
        /// By which all of it is drawn.
        seed: u64,
    },
    /// Starts the ladder anew from another preset.
    ChoosePreset(Preset),
    /// Starts the ladder anew from a model with networks, trained by this plan.
    TrainPreset {
        /// Which.
        preset: LearnedPreset,
        /// How.
        plan: Box<Plan>,
    },
    /// Trains the current model anew, or on from where it is, by another plan.
    Train {
        /// How.
        plan: Box<Plan>,
        /// Whether the weights of the current model are where it begins.
        warm: bool,
    },
    /// Trains one model from several seeds; all are kept, the one with the smallest validation error is the current model then.
    TrainSeeds {
        /// What trains the first of them; without it, that is the current model.
        begin: Option<Box<Command>>,
        /// How many.
        seeds: u64,
    },
    /// Goes on with a training that was stopped, as if it had never been.
    Resume(Arc<SavedRun>),
    /// Makes one of the session's models the current one, with the ladder that led to it.
    TakeUp {
        /// Its name.
        name: String,
    },
    /// Gives one of the session's models another name.
    Rename {
        /// Its name.
        name: String,
        /// Its new name.
        to: String,
    },
    /// Takes a model out of the session.
    Delete {
        /// Its name.
        name: String,
    },
    /// Simulates the arm of every model of which that was not asked yet, and measures how far it runs from the recording.
    RollOut,
    /// Makes models beside the current one, to be compared with it.
    Make {
        /// Which.
        presets: Vec<Preset>,
    },
    /// Starts the ladder anew from a given model, its parameters identified from this recording.
    UseModel {
        /// The terms.
        model: Model,
    },
    /// Reads an effect of one's own, which is sought and offered from then on.
    LoadEffect {
        /// The file.
        path: PathBuf,
    },
    /// Asks what the current model lacks.
    Diagnose,
    /// Asks on what the remainder of the current model depends, and by which formula.
    Propose,
    /// Makes a proposal an effect of one's own and adds it.
    Adopt {
        /// Index into the proposals.
        proposal: usize,
    },
    /// Adds an effect and identifies all parameters anew.
    AddEffect {
        /// Its id in the registry.
        effect: String,
        /// The joints, counted from 0; ignored by effects of the whole arm.
        joints: Vec<usize>,
    },
    /// Takes a term out of the current model, switches it off or on, or moves it in the list.
    EditTerms(TermEdit),
    /// Computes how the error of these models grows outside the data.
    Extrapolate {
        /// The models.
        steps: Vec<Arc<Step>>,
        /// Faster or wider.
        stretch: Stretch,
    },
    /// Goes back to a step of the ladder; the later ones are dropped (undo brings them back).
    GoTo {
        /// Index into [`Session::ladder`].
        step: usize,
    },
    /// Shows the hidden truth.
    OpenSeal,
    /// Hides the answer of the diagnosis until one has guessed, or not.
    BetFirst(bool),
    /// Says what the current model lacks, before the answer is shown.
    PlaceBet(Guess),
    /// Begins a lesson, or goes on in it with another recording.
    SetUp(Box<SetUp>),
    /// Writes down what was done in the lesson.
    Learn(Vec<Note>),
}

impl Command {
    /// Opens these files as one recording, or a saved session if that is what they are.
    ///
    /// ```
    /// use torquescope::prelude::*;
    ///
    /// let log = Command::open(vec!["run-1.csv".into(), "run-2.csv".into()], ReadOptions::default(), Vec::new());
    /// assert_eq!(log.title(), "open run-1.csv and 1 more");
    /// let session = Command::open(vec!["mine.torquescope".into()], ReadOptions::default(), Vec::new());
    /// assert!(matches!(session, Command::Restore { .. }));
    /// ```
    pub fn open(mut paths: Vec<PathBuf>, options: ReadOptions, held_out: Vec<String>) -> Self {
        if paths.len() == 1 && file::is_session(&paths[0]) {
            return Command::Restore { path: paths.remove(0) };
        }
        Command::Open { paths, options, held_out }
    }

    /// The session after this command. The old one is untouched, also if it fails.
    ///
    /// # Errors
    /// [`SessionError`] says what can't be done and how to mend it.
    pub fn run(&self, session: &Session, monitor: &Monitor) -> Result<Session, SessionError> {
        if let Some(lock) = session.study.as_ref().and_then(|study| study.lock_on(self)) {
            return Err(SessionError::Locked(lock.words()));
        }
        let changed = self.carry_out(session, monitor)?.remembering_its_models();
        Ok(Session { generation: Generation::next(), ..changed })
    }

    fn carry_out(&self, session: &Session, monitor: &Monitor) -> Result<Session, SessionError> {
        match self {
            Command::Open { paths, options, held_out } => {
                let import = read::read(paths, options, monitor)?;
                let mut findings = import.findings;
                let split = split(&import.recording, &import.unusable, held_out, &mut findings, monitor)?;
                let loaded = Session {
                    recording: Some(Arc::new(import.recording)),
                    findings: Arc::new(findings),
                    source: Source::of(self).map(Arc::new),
                    mapping: Some(Arc::new(import.mapping)),
                    split,
                    checkpoint_file: session.checkpoint_file.clone(),
                    ..emptied(session)
                };
                fitted_if_possible(loaded, monitor)
            }
            Command::Beside { paths } => beside::add(session, paths, monitor),
            Command::SetRight(corrections) => set_right(session, corrections, monitor),
            Command::Restore { path } => {
                let document = file::open(path, monitor)?.document.knowing(&session.own_effects);
                Ok(document.history.current().clone())
            }
            Command::Simulate(scenario) => self.simulated(session, simulation::simulate(scenario, monitor)?, monitor),
            Command::SimulateWorld(scenario) => self.simulated(session, world::simulate(scenario, monitor)?, monitor),
            Command::DrawMystery { level, seed } => {
                self.simulated(session, Making::mystery(*level, *seed)?.simulate(monitor)?, monitor)
            }
            Command::ChoosePreset(preset) => {
                let recording = session.recording.as_ref().ok_or(SessionError::NoRecording)?;
                let model = session.plan.shaped(&preset.model(recording)?);
                let step = step(model, None, session, monitor)?;
                Ok(Session { preset: *preset, ladder: vec![step], report: None, proposals: None, ..session.clone() })
            }
            Command::TrainPreset { preset, plan } => {
                let planned = Session { plan: plan.as_ref().clone(), ..session.clone() };
                Command::ChoosePreset(Preset::Learned(*preset)).run(&planned, monitor)
            }
            Command::Train { plan, warm } => {
                let current = session.current().ok_or(SessionError::NoModel)?;
                if !current.fitted.model.is_learned() {
                    return Err(SessionError::NothingToTrain);
                }
                let planned = Session { plan: plan.as_ref().clone(), ..session.clone() };
                let (before, model) = match warm {
                    // Only networks of the same size can begin with its weights.
                    true => (Some(&current.fitted), current.fitted.model.clone()),
                    false => (None, plan.shaped(&current.fitted.model)),
                };
                let step = step(model, before, &planned, monitor)?;
                let mut ladder = session.ladder.clone();
                ladder.pop();
                ladder.push(step);
                Ok(Session { ladder, report: None, proposals: None, ..planned })
            }
            Command::TrainSeeds { begin, seeds } => seeds::train(session, begin.as_deref(), *seeds, monitor),
            Command::Resume(run) => {
                let recording = session.recording.as_deref().ok_or(SessionError::NoRecording)?;
                let is_current = |step: &Arc<Step>| step.run.as_ref().is_some_and(|current| Arc::ptr_eq(current, run));
                let mut ladder = session.ladder.clone();
                if ladder.pop_if(|step| is_current(step)).is_none() {
                    ladder.clear();
                }
                // Who watches sees the whole run.
                run.checkpoint.history.iter().for_each(|epoch| monitor.tell(Event::Epoch(*epoch)));
                ladder.push(trained(session, monitor, &mut |keep| {
                    training::fit::resume(run, recording, &session.split, monitor, keep)
                })?);
                Ok(Session { ladder, report: None, proposals: None, plan: run.plan.clone(), ..session.clone() })
            }
            Command::TakeUp { name } => models::take_up(session, name),
            Command::Rename { name, to } => models::rename(session, name, to),
            Command::Delete { name } => models::delete(session, name),
            Command::RollOut => models::roll_out(session, monitor),
            Command::Make { presets } => models::make(session, presets, monitor),
            Command::UseModel { model } => {
                let step = step(model.clone(), None, session, monitor)?;
                Ok(Session { ladder: vec![step], report: None, proposals: None, ..session.clone() })
            }
            Command::Diagnose => {
                let recording = session.recording.as_ref().ok_or(SessionError::NoRecording)?;
                let current = session.current().ok_or(SessionError::NoModel)?;
                let sought = [registry::sought(), session.own_effects.clone()].concat();
                let report = diagnosis::diagnose_among(&sought, &current.fitted, recording, &session.split, monitor)?;
                Ok(Session { report: Some(Arc::new(report)), ..session.clone() })
            }
            Command::LoadEffect { path } => terms::load(session, path),
            Command::Propose => {
                let recording = session.recording.as_ref().ok_or(SessionError::NoRecording)?;
                let current = session.current().ok_or(SessionError::NoModel)?;
                let proposals = propose(&current.fitted, recording, &session.split, monitor)?;
                Ok(Session { proposals: Some(Arc::new(proposals)), ..session.clone() })
            }
            Command::Adopt { proposal } => terms::adopt(session, *proposal, monitor),
            Command::AddEffect { effect, joints } => terms::add(session, effect, joints, monitor),
            Command::EditTerms(edit) => terms::edit(session, *edit, monitor),
            Command::Extrapolate { steps, stretch } => {
                let recording = session.recording.as_ref().ok_or(SessionError::NoRecording)?;
                let models: Vec<(String, &Fitted)> =
                    steps.iter().map(|step| (step.name.clone(), &step.fitted)).collect();
                if models.is_empty() {
                    return Err(SessionError::NoModel);
                }
                let sweep = extrapolation::sweep(recording, &session.split, &models, *stretch, monitor)?;
                Ok(Session { sweep: Some(Arc::new(sweep)), ..session.clone() })
            }
            Command::GoTo { step } => {
                let count = session.ladder.len();
                if *step >= count {
                    return Err(SessionError::NoSuchStep { step: step + 1, count });
                }
                Ok(Session {
                    ladder: session.ladder[..=*step].to_vec(),
                    report: None,
                    proposals: None,
                    ..session.clone()
                })
            }
            Command::OpenSeal => {
                let recording = session.recording.as_ref().ok_or(SessionError::NoRecording)?;
                let truth = recording.seal.as_ref().ok_or(SessionError::NoSeal)?.open()?;
                Ok(Session { truth: Some(Arc::new(truth)), ..session.clone() })
            }
            Command::BetFirst(first) => {
                Ok(Session { bets: Bets { first: *first, ..session.bets.clone() }, ..session.clone() })
            }
            Command::PlaceBet(guess) => session.with_guess(guess),
            Command::SetUp(wanted) => set_up(session, wanted, monitor),
            Command::Learn(notes) => {
                let study = session.study.as_deref().ok_or(SessionError::NoLesson)?.clone();
                let study = notes.iter().fold(study, |study, note| study.with(note.clone()));
                Ok(Session { study: Some(Arc::new(study)), ..session.clone() })
            }
        }
    }

    /// A session with a recording that this command just simulated.
    fn simulated(&self, session: &Session, recording: Recording, monitor: &Monitor) -> Result<Session, SessionError> {
        let (split, source) = (Split::automatic(&recording), Source::of(self).map(Arc::new));
        let loaded = Session { recording: Some(Arc::new(recording)), split, source, ..emptied(session) };
        fitted_if_possible(loaded, monitor)
    }

    /// What it does, for undo and for the status line.
    pub fn title(&self) -> String {
        match self {
            Command::Open { paths, .. } => {
                let name = paths.first().and_then(|path| path.file_name()).unwrap_or_default().to_string_lossy();
                if paths.len() > 1 {
                    format!("open {name} and {} more", paths.len() - 1)
                } else {
                    format!("open {name}")
                }
            }
            Command::Beside { paths } => {
                let name = paths.first().and_then(|path| path.file_name()).unwrap_or_default().to_string_lossy();
                format!("look at {name} beside it")
            }
            Command::SetRight(corrections) => {
                let texts: Vec<String> = corrections.iter().map(Correction::to_string).collect();
                format!("set right {}", texts.join(" "))
            }
            Command::Restore { path } => {
                format!("open the session {}", path.file_name().unwrap_or_default().to_string_lossy())
            }
            Command::Simulate(_) => "simulate a recording".to_owned(),
            Command::SimulateWorld(_) => "simulate a world of rigid bodies".to_owned(),
            Command::DrawMystery { .. } => "draw a mystery".to_owned(),
            Command::ChoosePreset(preset) => format!("start from {}", preset.title()),
            Command::TrainPreset { preset, .. } => format!("train {}", preset.title()),
            Command::Train { warm, .. } => if *warm { "train on" } else { "train anew" }.to_owned(),
            Command::TrainSeeds { seeds, .. } => format!("train {seeds} seeds"),
            Command::Resume(_) => "resume training".to_owned(),
            Command::TakeUp { name } => format!("use {name}"),
            Command::Rename { name, to } => format!("rename {name} to {}", to.trim()),
            Command::Delete { name } => format!("delete {name}"),
            Command::RollOut => "simulate the models".to_owned(),
            Command::Make { presets } => {
                let names: Vec<&str> = presets.iter().map(|preset| preset.title()).collect();
                format!("make {}", names.join(", "))
            }
            Command::UseModel { model } => format!("start from {}", default_name(model)),
            Command::LoadEffect { path } => {
                format!("load the effect {}", path.file_name().unwrap_or_default().to_string_lossy())
            }
            Command::Diagnose => "diagnose".to_owned(),
            Command::Propose => "propose formulas".to_owned(),
            Command::Adopt { proposal } => format!("adopt proposal {}", proposal + 1),
            Command::AddEffect { effect, joints } => {
                let name = registry::find(effect).map_or(effect.clone(), |effect| terms::effect_text(effect, joints));
                format!("add {name}")
            }
            Command::EditTerms(edit) => edit.title().to_owned(),
            Command::Extrapolate { .. } => "extrapolate".to_owned(),
            Command::GoTo { step } => format!("go back to step {}", step + 1),
            Command::OpenSeal => "open the seal".to_owned(),
            Command::BetFirst(_) => "bet first".to_owned(),
            Command::PlaceBet(_) => "place a bet".to_owned(),
            Command::SetUp(wanted) => wanted.title(),
            Command::Learn(_) => "write into the lesson's journal".to_owned(),
        }
    }

    /// Whether what it gives is another document, which is in no file yet. A recording that is set right is still that recording.
    pub fn begins_anew(&self) -> bool {
        match self {
            Command::Open { .. } | Command::Simulate(_) | Command::SimulateWorld(_) | Command::DrawMystery { .. } => {
                true
            }
            Command::SetUp(wanted) => wanted.begins.is_some(),
            _ => false,
        }
    }

    /// Whether undo can't take it back: what was seen was seen, and what was said was said.
    pub fn is_final(&self) -> bool {
        matches!(self, Command::OpenSeal | Command::BetFirst(_) | Command::PlaceBet(_) | Command::Learn(_))
    }

    /// Whether it trains networks, of whose epochs it then tells.
    pub fn trains(&self, session: &Session) -> bool {
        match self {
            Command::ChoosePreset(preset) => matches!(preset, Preset::Learned(_)),
            Command::TrainPreset { .. } | Command::Train { .. } | Command::TrainSeeds { .. } | Command::Resume(_) => {
                true
            }
            Command::Make { presets } => presets.iter().any(|preset| matches!(preset, Preset::Learned(_))),
            Command::UseModel { model } => model.is_learned(),
            Command::AddEffect { .. } | Command::Adopt { .. } | Command::EditTerms(_) => {
                session.current().is_some_and(|step| step.fitted.model.is_learned())
            }
            _ => false,
        }
    }

    /// The plan of the training that it begins, if it does.
    pub fn plan<'a>(&'a self, session: &'a Session) -> Option<&'a Plan> {
        match self {
            Command::TrainPreset { plan, .. } | Command::Train { plan, .. } => Some(plan),
            Command::TrainSeeds { begin: Some(begin), .. } => begin.plan(session),
            Command::Resume(run) => Some(&run.plan),
            _ => self.trains(session).then_some(&session.plan),
        }
    }

    /// Whether it takes less than a few milliseconds, so that no job is needed.
    pub fn is_quick(&self) -> bool {
        let is_of_models = matches!(self, Command::TakeUp { .. } | Command::Rename { .. } | Command::Delete { .. });
        self.is_final() || is_of_models || matches!(self, Command::GoTo { .. } | Command::LoadEffect { .. })
    }
}

/// Fits the preset right after loading. A recording that no preset fits (eight joints, say) is still worth looking at, so
/// the session then has no ladder; choosing a preset tells why.
fn fitted_if_possible(mut session: Session, monitor: &Monitor) -> Result<Session, SessionError> {
    let states_arm = session.recording.as_ref().is_some_and(|recording| recording.states_arm());
    if session.preset != Preset::StatedArm || !states_arm {
        // Networks are trained on order only: that takes longer than opening a file may.
        session.preset = Preset::RigidBody;
    }
    match Command::ChoosePreset(session.preset).run(&session, monitor) {
        Err(SessionError::Model(ModelError::Stopped(stopped))) => Err(stopped.into()),
        Err(SessionError::Model(_)) => Ok(session),
        other => other,
    }
}

/// An empty session in which still holds what was chosen for any recording.
fn emptied(session: &Session) -> Session {
    Session {
        preset: session.preset,
        plan: session.plan.clone(),
        own_effects: session.own_effects.clone(),
        bets: Bets { first: session.bets.first, ..Bets::default() },
        study: session.study.clone(),
        ..Session::default()
    }
}

/// The session with the recording of a case of a lesson, if it has one, and a journal that says so.
fn set_up(session: &Session, wanted: &SetUp, monitor: &Monitor) -> Result<Session, SessionError> {
    let mut study = match &wanted.begins {
        Some(study) => study.clone(),
        None => session.study.as_deref().ok_or(SessionError::NoLesson)?.clone(),
    };
    if let Some(note) = &wanted.note {
        study = study.with(note.clone());
    }
    let Some(case) = &wanted.case else {
        return Ok(Session { study: Some(Arc::new(study)), ..emptied(session) });
    };
    let mut recording = case.making.simulate(monitor)?;
    read::set_right(&mut recording, &case.faults)?;
    let deed = study::Deed::SetUp { case: case.name.clone(), recording: study::fingerprint(&recording) };
    let at = study.journal().last().map_or(0, |entry| entry.note.at);
    study = study.continued(at, deed);
    let split = Split::automatic(&recording);
    let (recording, study) = (Some(Arc::new(recording)), Some(Arc::new(study)));
    let plan = case.plan.clone().unwrap_or_else(|| session.plan.clone());
    fitted_if_possible(Session { recording, split, study, plan, ..emptied(session) }, monitor)
}

/// Splits a recording, automatically if no trajectory is named. What there is to be said of that, and of how the recording is
/// set up, is added to its findings.
fn split(
    recording: &Recording,
    unusable: &[Segment],
    held_out: &[String],
    findings: &mut Vec<Finding>,
    monitor: &Monitor,
) -> Result<Split, SessionError> {
    if held_out.is_empty() {
        findings.extend(Split::findings(recording));
    }
    let split = Split::as_asked(recording, held_out, unusable)?;
    let set_up = diagnosis::setup::check(recording, findings, monitor)?;
    findings.extend(set_up);
    Ok(split)
}

/// The recording with these corrections, judged and fitted as if it had been read with them.
fn set_right(session: &Session, corrections: &[Correction], monitor: &Monitor) -> Result<Session, SessionError> {
    let mut recording = session.recording.as_deref().ok_or(SessionError::NoRecording)?.clone();
    // What the import said of its files, and what was set right before, still holds; the rest is asked anew.
    let still_holds = |finding: &&Finding| finding.place.file.is_some() || finding.kind == FindingKind::SetRight;
    let mut findings: Vec<Finding> = session.findings.iter().filter(still_holds).cloned().collect();
    findings.extend(read::set_right(&mut recording, corrections)?);
    let Checked { findings: odd, unusable } = check(&recording);
    findings.extend(odd);
    let trains = |index: usize| session.split.train.iter().any(|segment| segment.trajectory == index);
    let held_out = (0..recording.trajectories.len()).filter(|&index| !trains(index));
    let held_out: Vec<String> = held_out.map(|index| recording.trajectories[index].name.clone()).collect();
    let split = split(&recording, &unusable, &held_out, &mut findings, monitor)?;
    let source = session.source.as_ref().map(|source| Arc::new(source.set_right(corrections, held_out)));
    let loaded = Session {
        recording: Some(Arc::new(recording)),
        findings: Arc::new(findings),
        source,
        mapping: session.mapping.clone(),
        split,
        checkpoint_file: session.checkpoint_file.clone(),
        truth: session.truth.clone(),
        ..emptied(session)
    };
    fitted_if_possible(loaded, monitor)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::Excitation;

    #[test]
    fn commands_on_an_empty_session_say_what_to_do_first() {
        let monitor = Monitor::new();
        let empty = Session::default();
        for command in [Command::Diagnose, Command::OpenSeal, Command::ChoosePreset(Preset::RigidBody)] {
            let message = command.run(&empty, &monitor).unwrap_err().to_string();
            assert!(message.contains("open a file or simulate"), "{message}");
        }
    }

    fn simulate() -> Command {
        let motion = Excitation::PaperPointToPoint { trajectories: 6, duration: 4.0, samples: 80, range: 2.0 };
        Command::Simulate(Box::new(Scenario { motion, ..Scenario::embedded() }))
    }

    /// They are of the user, and not of the recording.
    #[test]
    fn effects_of_ones_own_stay_with_another_recording() {
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("examples/own_stribeck.toml");
        let simulated = simulate().run(&Session::default(), &Monitor::new()).unwrap();
        let loaded = Command::LoadEffect { path }.run(&simulated, &Monitor::new()).unwrap();
        assert_eq!(loaded.own_effects.len(), 1);
        let set_right = Command::SetRight(vec!["sign-torque@1".parse().unwrap()]);
        for command in [set_right, simulate()] {
            let session = command.run(&loaded, &Monitor::new()).unwrap();
            assert!(!session.has_recording_of(&loaded));
            assert_eq!(session.own_effects, loaded.own_effects, "{}", command.title());
        }
    }

    /// Also where a saved session is opened.
    #[test]
    fn effects_of_ones_own_stay_with_a_session_that_is_opened() {
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("examples/own_stribeck.toml");
        let load = Command::LoadEffect { path };
        let given = load.run(&Session::default(), &Monitor::new()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let mine = folder.path().join("mine.torquescope");
        let simulated = simulate().run(&Session::default(), &Monitor::new()).unwrap();
        file::save(&mine, &simulated.into()).unwrap();
        let opened = Command::Restore { path: mine }.run(&given, &Monitor::new()).unwrap();
        assert_eq!((&opened.own_effects, opened.ladder.len()), (&given.own_effects, 1));
    }

    #[test]
    fn a_diagnosis_tells_what_it_finds_while_it_searches() {
        let session = simulate().run(&Session::default(), &Monitor::new()).unwrap();
        let monitor = Monitor::new();
        let report = Command::Diagnose.run(&session, &monitor).unwrap().report.unwrap();
        let found = monitor.take_events().into_iter().filter_map(|event| match event {
            Event::Found(found) => Some(found),
            _ => None,
        });
        let steps: Vec<Vec<String>> = found.collect();
        assert!(!report.effects.is_empty() && steps[0].len() == 1, "{steps:?}");
    }
}
