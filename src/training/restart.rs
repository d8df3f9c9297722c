//! A training that got stuck is noticed, and begun anew from another start.
//!
//! How well a training could end is known beforehand: networks can learn any rigid body, so that one with the same effects,
//! which is solved for, leaves about as much of the training data unexplained as they should. A training that leaves far more
//! did not learn the arm. That may be the start, of which another one is better, or the model or the time it was given, of
//! which none is: so what another start gives decides whether a third is worth its time.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::fit::Trained;
use super::{Ending, TrainError};
use crate::model::{self, Evaluation, Model, ModelError, RigidBody, Term};
use crate::progress::Monitor;
use crate::recording::Recording;
use crate::recording::split::Split;

/// A training that leaves less than this share of the torque's variance unexplained has learned the arm, whatever is possible.
const LEARNED: f64 = 0.02;
/// A training is stuck if it leaves so many times what the rigid body leaves.
const FAR: f64 = 4.0;
/// Shorter trainings [epochs] are not judged: what they leave says nothing of their start.
const LEAST_EPOCHS: u64 = 20;
/// Another start is worth a third only if it left less than this share of what the one before did.
const BETTER: f64 = 0.7;
/// Most starts that are tried.
const MOST_STARTS: usize = 3;
/// How far the seeds of starts of one training are apart, so that those of neighbouring trainings stay their own.
const NEXT_SEED: u64 = 1_000;

/// A start that was tried, and led to less than the one that was kept.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct OtherStart {
    /// Its seed.
    pub seed: u64,
    /// How much of the torque's variance it left unexplained in the training data, mean of the joints.
    pub unexplained: f64,
}

impl fmt::Display for OtherStart {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "seed {} {:.1} %", self.seed, 100.0 * self.unexplained)
    }
}

/// Share of the torque's variance that a training leaves unexplained in what it learned from, mean of the joints.
pub(super) fn unexplained(trained: &Trained) -> f64 {
    let joints = trained.fitted.setting().kinds.len().max(1) as f64;
    let losses = trained.history.iter().map(|epoch| epoch.loss);
    losses.fold(f64::INFINITY, f64::min) / joints
}

/// What would be left by a training that learned the arm; `None` if nobody can tell.
fn possible(model: &Model, recording: &Recording, split: &Split, monitor: &Monitor) -> Result<Option<f64>, TrainError> {
    let effects = model.effects().cloned().map(Term::Effect);
    let body = Model { terms: [Term::RigidBody(RigidBody::Identified)].into_iter().chain(effects).collect() };
    let learned_from = Split { held_out: Vec::new(), ..split.clone() };
    let solved = model::fit(&body, recording, &learned_from, monitor)
        .and_then(|fitted| Evaluation::of(&fitted, recording, &learned_from));
    match solved {
        Ok(evaluation) => {
            let joints = &evaluation.train;
            Ok(Some(joints.iter().map(|error| 1.0 - error.r2).sum::<f64>() / joints.len().max(1) as f64))
        }
        Err(ModelError::Stopped(stopped)) => Err(stopped.into()),
        Err(_) => Ok(None),
    }
}

/// The seed of the next start, if this training got stuck.
pub(super) fn next_start(
    trained: &Trained,
    recording: &Recording,
    split: &Split,
    monitor: &Monitor,
) -> Result<Option<u64>, TrainError> {
    let (run, left) = (&trained.run, unexplained(trained));
    let is_judged = trained.ending == Ending::Finished && run.plan.options.epochs >= LEAST_EPOCHS && !run.is_warm;
    let is_worth_it = run.other_starts.iter().all(|other| left < BETTER * other.unexplained);
    if !is_judged || !is_worth_it || run.other_starts.len() + 1 >= MOST_STARTS || left <= LEARNED {
        return Ok(None);
    }
    let possible = possible(&run.model, recording, split, monitor)?;
    let is_stuck = possible.is_some_and(|possible| left > FAR * possible);
    Ok(is_stuck.then_some(run.plan.options.seed + NEXT_SEED))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::learned::LearnedPreset;
    use crate::progress::Event;
    use crate::session::{Command, Session};
    use crate::simulation::{Excitation, Scenario};
    use crate::training::fit::Plan;

    /// A network that learns nothing, since its steps are next to none, trained for so long.
    fn stuck(epochs: u64) -> (Vec<OtherStart>, u64, Vec<String>) {
        let motion = Excitation::PaperPointToPoint { trajectories: 6, duration: 2.0, samples: 50, range: 2.0 };
        let arm = crate::arm::Arm::uniform(2);
        let scenario = Scenario { arm, motion, effects: Vec::new(), ..Scenario::embedded() };
        let simulated = Command::Simulate(Box::new(scenario)).run(&Session::default(), &Monitor::new()).unwrap();
        let mut plan = Plan::default();
        (plan.options.epochs, plan.options.batch, plan.options.rate) = (epochs, 64, 1e-12);
        let monitor = Monitor::new();
        let train = Command::TrainPreset { preset: LearnedPreset::FfNn, plan: Box::new(plan) };
        let trained = train.run(&simulated, &monitor).unwrap();
        let run = trained.current().unwrap().run.clone().unwrap();
        let warnings = monitor.take_events().into_iter().filter_map(|event| match event {
            Event::Warning(warning) => Some(warning),
            _ => None,
        });
        (run.other_starts.clone(), run.plan.options.seed, warnings.collect())
    }

    /// A second start is tried and told of; since it is as bad, there is no third. The better of the two is kept, with what the
    /// other one left.
    #[test]
    fn a_training_that_got_stuck_begins_anew_and_says_so() {
        let (others, kept, warnings) = stuck(LEAST_EPOCHS);
        assert_eq!(others.len(), 1);
        let mut seeds = [kept, others[0].seed];
        seeds.sort_unstable();
        assert_eq!(seeds, [0, NEXT_SEED]);
        assert!(others[0].unexplained > LEARNED);
        assert_eq!(warnings.len(), 1);
        assert!(warnings[0].contains("got stuck") && warnings[0].contains("seed 1000 instead of 0"), "{warnings:?}");
        // Too short to be judged.
        let (others, kept, warnings) = stuck(LEAST_EPOCHS - 1);
        assert!(others.is_empty() && kept == 0 && warnings.is_empty());
    }
}
