//! What each command does: the session after it, made from the one before, which stays as it was.

use std::path::PathBuf;
use std::sync::Arc;

use super::error::SessionError;
use super::step::{step, trained};
use super::study::{self, SetUp};
use super::{Bets, Command, Generation, Session, Step, beside, file, hold_out, models, seeds, terms};
use crate::diagnosis;
use crate::diagnosis::proposal::propose;
use crate::effect::registry;
use crate::model::{Fitted, ModelError, Preset};
use crate::progress::{Event, Monitor};
use crate::recording::Recording;
use crate::recording::check::{Checked, check};
use crate::recording::correction::Correction;
use crate::recording::finding::{Finding, FindingKind};
use crate::recording::hold_out::HoldOut;
use crate::recording::read::{self, ReadOptions};
use crate::recording::split::{Split, Unusable};
use crate::simulation::extrapolation;
use crate::simulation::{self, Making, world};
use crate::training;

impl Command {
    /// The session after this command. The old one is untouched, also if it fails.
    ///
    /// # Errors
    /// [`SessionError`] says what can't be done and how to mend it.
    pub fn run(&self, session: &Session, monitor: &Monitor) -> Result<Session, SessionError> {
        if let Some(lock) = session.study.as_ref().and_then(|study| self.locked_by(study)) {
            return Err(SessionError::Locked(lock.words()));
        }
        let changed = self.carry_out(session, monitor)?.remembering_its_models();
        Ok(Session { generation: Generation::next(), ..changed })
    }

    fn carry_out(&self, session: &Session, monitor: &Monitor) -> Result<Session, SessionError> {
        match self {
            Command::Open { paths, options, held_out } => {
                fitted_if_possible(self.read(paths, options, held_out, session, monitor)?, monitor)
            }
            Command::Beside { paths } => beside::add(session, paths, monitor),
            Command::SetRight(corrections) => set_right(session, corrections, monitor),
            Command::HoldOut(asked) => hold_out::hold_out(session, asked, monitor),
            Command::Restore { path } => {
                let document = file::open(path, monitor)?.document.knowing(&session.own_effects);
                Ok(document.history.current().clone())
            }
            Command::BeginAnew => Ok(emptied(session)),
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

    /// The session with what this command opens, before anything is identified from it: all that looking at a recording needs.
    ///
    /// # Errors
    /// As [`Command::run`].
    pub fn opened(&self, session: &Session, monitor: &Monitor) -> Result<Session, SessionError> {
        match self {
            Command::Open { paths, options, held_out } => self.read(paths, options, held_out, session, monitor),
            other => other.run(session, monitor),
        }
    }

    fn read(
        &self,
        paths: &[PathBuf],
        options: &ReadOptions,
        held_out: &HoldOut,
        session: &Session,
        monitor: &Monitor,
    ) -> Result<Session, SessionError> {
        let import = read::read(paths, options, monitor)?;
        let mut findings = import.findings;
        let split = split(&import.recording, &import.unusable, held_out, &mut findings, monitor)?;
        Ok(Session {
            recording: Some(Arc::new(import.recording)),
            findings: Arc::new(findings),
            source: self.source().map(Arc::new),
            mapping: Some(Arc::new(import.mapping)),
            split,
            checkpoint_file: session.checkpoint_file.clone(),
            ..emptied(session)
        })
    }

    /// A session with a recording that this command just simulated.
    fn simulated(&self, session: &Session, recording: Recording, monitor: &Monitor) -> Result<Session, SessionError> {
        let (split, source) = (Split::automatic(&recording), self.source().map(Arc::new));
        let loaded = Session { recording: Some(Arc::new(recording)), split, source, ..emptied(session) };
        fitted_if_possible(loaded, monitor)
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

/// Splits a recording. What there is to be said of that, and of how the recording is set up, is added to its findings.
fn split(
    recording: &Recording,
    unusable: &[Unusable],
    held_out: &HoldOut,
    findings: &mut Vec<Finding>,
    monitor: &Monitor,
) -> Result<Split, SessionError> {
    if matches!(held_out, HoldOut::Fifth(_)) {
        findings.extend(Split::findings(recording));
    }
    let split = Split::as_asked(recording, held_out, unusable)?;
    let set_up = diagnosis::setup::check(recording, findings, monitor)?;
    findings.extend(set_up);
    let gains = diagnosis::setup::gains(recording, &split, findings, monitor)?;
    findings.extend(gains);
    Ok(split)
}

/// The recording with these corrections, judged and fitted as if it had been read with them.
fn set_right(session: &Session, corrections: &[Correction], monitor: &Monitor) -> Result<Session, SessionError> {
    let mut recording = session.recording.as_deref().ok_or(SessionError::NoRecording)?.clone();
    // What the import said of its files, and what was set right before, still holds; the rest is asked anew.
    let is_scaled = corrections.iter().any(Correction::scales_torque);
    let still_holds = |finding: &&Finding| match finding.kind {
        FindingKind::SetRight => true,
        FindingKind::Amperes => !is_scaled,
        _ => finding.place.file.is_some(),
    };
    let mut findings: Vec<Finding> = session.findings.iter().filter(still_holds).cloned().collect();
    findings.extend(read::set_right(&mut recording, corrections)?);
    let Checked { findings: odd, unusable } = check(&recording);
    findings.extend(odd);
    let by_source = session.source.as_ref().map(|source| source.held_out.clone());
    let held_out = by_source.unwrap_or_else(|| beside::held_out(&recording, &session.split));
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
    use crate::simulation::{Excitation, Scenario};

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
