//! The models of a session: every one that was fitted to its recording, side by side, each with a name of its own.

use std::sync::Arc;

use super::error::SessionError;
use super::name::{self, unique};
use super::{Command, Generation, Session, Step};
use crate::model::Preset;
use crate::progress::{Event, Monitor};
use crate::training;
use crate::training::rollout::Rollout;

/// A model of this recording, to be compared with others and taken up again.
#[derive(Debug, Clone)]
pub struct Kept {
    /// What its ladder started from.
    pub preset: Preset,
    /// The ladder with it as the last step; never empty.
    pub ladder: Vec<Arc<Step>>,
}

impl Kept {
    /// The model.
    pub fn step(&self) -> Option<&Arc<Step>> {
        self.ladder.last()
    }

    fn is_called(&self, name: &str) -> bool {
        self.step().is_some_and(|step| step.name == name)
    }
}

impl Step {
    /// How many numbers were found from the data: weights of networks, factors and shapes of the rest.
    pub fn parameter_count(&self) -> usize {
        let networks = training::fit::networks(&self.fitted);
        networks.map_or(self.fitted.parameters.len(), |networks| networks.weights.values().map(Vec::len).sum())
    }
}

impl Session {
    /// All models, in the order in which they were made.
    pub fn all_models(&self) -> impl Iterator<Item = &Arc<Step>> {
        self.models.iter().filter_map(Kept::step)
    }

    /// The model of this name.
    pub fn model(&self, name: &str) -> Option<&Arc<Step>> {
        self.all_models().find(|step| step.name == name)
    }

    /// The model that was made then, whatever it is called now.
    pub fn model_of(&self, generation: Generation) -> Option<&Arc<Step>> {
        self.all_models().find(|step| step.generation == generation)
    }

    /// What could be made of this recording beside the models that are there.
    pub fn presets_without_model(&self) -> impl Iterator<Item = Preset> {
        let states_arm = self.recording.as_ref().is_some_and(|recording| recording.states_arm());
        let is_possible = move |preset: &Preset| *preset != Preset::StatedArm || states_arm;
        let is_missing = |preset: &Preset| self.models.iter().all(|kept| kept.preset != *preset);
        Preset::ALL.into_iter().filter(is_possible).filter(is_missing)
    }

    /// Whether a model is a step of the ladder.
    pub fn has_on_ladder(&self, step: &Step) -> bool {
        self.ladder.iter().any(|own| own.generation == step.generation)
    }

    /// This session with every step of its ladder among its models, each with a name that no other has. What was solved for
    /// before is that model again.
    pub(super) fn remembering_its_models(mut self) -> Self {
        for place in 0..self.ladder.len() {
            let step = &self.ladder[place];
            if self.all_models().any(|known| known.generation == step.generation) {
                continue;
            }
            let is_same = |known: &&Arc<Step>| known.run.is_none() && known.fitted.model == step.fitted.model;
            let same = self.all_models().find(is_same).filter(|_| step.run.is_none()).cloned();
            if let Some(known) = same {
                self.ladder[place] = known;
                continue;
            }
            let name = unique(&step.name, self.all_models().map(|known| known.name.as_str()));
            if name != step.name {
                Arc::make_mut(&mut self.ladder[place]).name = name;
            }
            self.models.push(Kept { preset: self.preset, ladder: self.ladder[..=place].to_vec() });
        }
        self
    }

    /// This session with a model as it is now, wherever it stands.
    fn with_changed(&self, step: Step) -> Session {
        let new = Arc::new(step);
        let in_ladder = |ladder: &[Arc<Step>]| -> Vec<Arc<Step>> {
            ladder.iter().map(|step| if step.generation == new.generation { &new } else { step }).cloned().collect()
        };
        let kept = |kept: &Kept| Kept { preset: kept.preset, ladder: in_ladder(&kept.ladder) };
        let models = self.models.iter().map(kept).collect();
        Session { models, ladder: in_ladder(&self.ladder), ..self.clone() }
    }

    fn kept(&self, name: &str) -> Result<&Kept, SessionError> {
        self.models.iter().find(|kept| kept.is_called(name)).ok_or_else(|| {
            let known: Vec<String> = self.all_models().map(|step| format!("“{}”", step.name)).collect();
            SessionError::NoSuchModel { asked: name.to_owned(), known: known.join(", ") }
        })
    }
}

/// Makes a model the current one, with the ladder that led to it.
pub(super) fn take_up(session: &Session, name: &str) -> Result<Session, SessionError> {
    let chosen = session.kept(name)?;
    let plan = chosen.step().and_then(|step| step.run.as_ref()).map(|run| run.plan.clone());
    Ok(Session {
        preset: chosen.preset,
        ladder: chosen.ladder.clone(),
        plan: plan.unwrap_or_else(|| session.plan.clone()),
        report: None,
        proposals: None,
        ..session.clone()
    })
}

/// Gives a model another name, wherever it stands.
pub(super) fn rename(session: &Session, name: &str, to: &str) -> Result<Session, SessionError> {
    let old = session.kept(name)?.step().ok_or(SessionError::NoModel)?;
    let to = to.trim();
    if to.is_empty() || to.chars().count() > name::LONGEST {
        return Err(SessionError::BadName { longest: name::LONGEST });
    }
    if session.model(to).is_some_and(|other| other.generation != old.generation) {
        return Err(SessionError::NameTaken(to.to_owned()));
    }
    let mut renamed = session.with_changed(Step { name: to.to_owned(), ..Step::clone(old) });
    if let Some(sweep) = renamed.sweep.as_mut().filter(|sweep| sweep.curves.iter().any(|curve| curve.model == name)) {
        let curves = Arc::make_mut(sweep).curves.iter_mut();
        curves.filter(|curve| curve.model == name).for_each(|curve| to.clone_into(&mut curve.model));
    }
    Ok(renamed)
}

/// Simulates the arm of every model of which that was not asked yet, from states of the held-out part.
pub(super) fn roll_out(session: &Session, monitor: &Monitor) -> Result<Session, SessionError> {
    let recording = session.recording.as_deref().ok_or(SessionError::NoRecording)?;
    let new: Vec<&Arc<Step>> = session.all_models().filter(|step| step.rollout.is_none()).collect();
    let mut simulated = session.clone();
    for (number, step) in new.iter().enumerate() {
        let share = |number: usize| number as f32 / new.len() as f32;
        let part = monitor.part(share(number)..share(number + 1));
        let rollout = Rollout::of(&step.fitted, recording, &session.split.held_out, &part)?;
        simulated = simulated.with_changed(Step { rollout: Some(rollout), ..Step::clone(step) });
    }
    Ok(simulated)
}

/// Takes a model out of the session. The ladder needs its own.
pub(super) fn delete(session: &Session, name: &str) -> Result<Session, SessionError> {
    if session.kept(name)?.step().is_some_and(|step| session.has_on_ladder(step)) {
        return Err(SessionError::OnTheLadder(name.to_owned()));
    }
    let models = session.models.iter().filter(|kept| !kept.is_called(name)).cloned().collect();
    let mut without = Session { models, ..session.clone() };
    if let Some(sweep) = &mut without.sweep {
        Arc::make_mut(sweep).curves.retain(|curve| curve.model != name);
    }
    without.sweep.take_if(|sweep| sweep.curves.is_empty());
    Ok(without)
}

/// Makes models beside the current one. One that can't be made is told of; the others are kept.
pub(super) fn make(session: &Session, presets: &[Preset], monitor: &Monitor) -> Result<Session, SessionError> {
    let mut with_new = session.clone();
    let mut first_problem = None;
    for preset in presets {
        match Command::ChoosePreset(*preset).run(&with_new, monitor) {
            Ok(made) => with_new.models = made.models,
            Err(error) => {
                monitor.check()?;
                monitor.tell(Event::Warning(format!("the model {} was not made: {error}", preset.title())));
                first_problem.get_or_insert(error);
            }
        }
    }
    match first_problem {
        Some(problem) if with_new.models.len() == session.models.len() => Err(problem),
        _ => Ok(with_new),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::extrapolation::Stretch;
    use crate::simulation::{Excitation, Scenario};

    fn run(command: &Command, session: &Session) -> Session {
        command.run(session, &Monitor::new()).unwrap()
    }

    fn names(session: &Session) -> Vec<&str> {
        session.all_models().map(|step| step.name.as_str()).collect()
    }

    fn repaired() -> Session {
        let motion = Excitation::PaperPointToPoint { trajectories: 6, duration: 4.0, samples: 80, range: 2.0 };
        let simulate = Command::Simulate(Box::new(Scenario { motion, ..Scenario::embedded() }));
        let add = Command::AddEffect { effect: "coulomb-friction".into(), joints: vec![0, 1] };
        run(&add, &run(&simulate, &Session::default()))
    }

    #[test]
    fn every_model_is_kept_once_and_taken_up_with_its_ladder() {
        let repaired = repaired();
        assert_eq!(names(&repaired), ["rigid body", "rigid body + Coulomb 1, 2"]);
        let back = run(&Command::GoTo { step: 0 }, &repaired);
        assert_eq!((back.ladder.len(), names(&back).len()), (1, 2));
        let again = run(&Command::AddEffect { effect: "coulomb-friction".into(), joints: vec![0, 1] }, &back);
        assert_eq!(names(&again), names(&repaired), "what is solved for twice is one model");
        let taken = run(&Command::TakeUp { name: "rigid body + Coulomb 1, 2".into() }, &back);
        assert_eq!(taken.current().unwrap().generation, repaired.current().unwrap().generation);
        assert_eq!(taken.ladder.len(), 2);
    }

    #[test]
    fn a_name_is_changed_wherever_it_stands_and_stays_the_only_one() {
        let repaired = repaired();
        let steps = repaired.ladder.clone();
        let swept = run(&Command::Extrapolate { steps, stretch: Stretch::Speed }, &repaired);
        let rename = |to: &str| Command::Rename { name: "rigid body".into(), to: to.into() };
        let renamed = run(&rename(" bare arm "), &swept);
        assert_eq!(names(&renamed)[0], "bare arm");
        assert_eq!(
            (renamed.ladder[0].name.as_str(), renamed.models[1].ladder[0].name.as_str()),
            ("bare arm", "bare arm")
        );
        assert_eq!(renamed.sweep.as_ref().unwrap().curves[0].model, "bare arm");
        let refused = |to: &str| rename(to).run(&swept, &Monitor::new()).unwrap_err().to_string();
        assert!(refused("rigid body + Coulomb 1, 2").contains("has that name already"));
        assert!(refused("  ").contains("1 to 60 letters"));
    }

    #[test]
    fn a_model_is_deleted_unless_the_ladder_needs_it() {
        let repaired = repaired();
        let delete = Command::Delete { name: "rigid body + Coulomb 1, 2".into() };
        let message = delete.run(&repaired, &Monitor::new()).unwrap_err().to_string();
        assert!(message.contains("is a step of the ladder"), "{message}");
        let back = run(&Command::GoTo { step: 0 }, &repaired);
        assert_eq!(names(&run(&delete, &back)), ["rigid body"]);
    }

    /// Each is simulated once; what a model lacks shows in it, and another name changes nothing of it.
    #[test]
    fn the_arms_of_all_models_are_simulated() {
        let rolled = run(&Command::RollOut, &repaired());
        let errors: Vec<f64> = rolled.all_models().map(|step| step.rollout.as_ref().unwrap().error[0]).collect();
        assert!(errors[1] < 0.5 * errors[0], "{errors:?}");
        assert!(rolled.ladder.iter().zip(&rolled.models[1].ladder).all(|(one, other)| Arc::ptr_eq(one, other)));
        let renamed = run(&Command::Rename { name: "rigid body".into(), to: "bare arm".into() }, &rolled);
        let again = run(&Command::RollOut, &run(&Command::GoTo { step: 0 }, &renamed));
        assert_eq!(again.model("bare arm").unwrap().rollout, rolled.model("rigid body").unwrap().rollout);
    }

    #[test]
    fn models_are_made_beside_the_current_one() {
        let repaired = repaired();
        let made = run(&Command::Make { presets: vec![Preset::StatedArm] }, &repaired);
        assert_eq!(names(&made), ["rigid body", "rigid body + Coulomb 1, 2", "stated arm"]);
        assert_eq!(made.current().unwrap().generation, repaired.current().unwrap().generation);
        assert_eq!(made.preset, repaired.preset);
    }
}
