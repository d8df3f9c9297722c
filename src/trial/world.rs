//! Worlds of rigid bodies that a seed draws: the diagnosis sees the log, and is judged by what the parts really did.
//!
//! What is weak beside its joint's torque may be named or not: a strong part may do little in the motion that was drawn, and a weak
//! one is there to disturb.

use super::TrialError;
use super::foreign::{Answered, lacking_as_advised};
use super::kin::{self, Place};
use super::verdict::{Planted, Truth};
use crate::progress::Monitor;
use crate::recording::Recording;
use crate::recording::seal::{Cause, HiddenEffect};
use crate::simulation::world::{self, Class, Scenario};

/// A world and the class that it is drawn from.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldTrial {
    /// How much is hidden.
    pub class: Class,
    /// What is simulated.
    pub scenario: Scenario,
}

impl WorldTrial {
    /// Draws a world; where no class is asked for they take turns with the seeds.
    ///
    /// # Errors
    /// [`TrialError`] if none can be drawn.
    pub fn draw(seed: u64, class: Option<Class>) -> Result<Self, TrialError> {
        let class = class.unwrap_or(Class::ALL[(seed % Class::ALL.len() as u64) as usize]);
        Ok(WorldTrial { class, scenario: world::draw(seed, class)? })
    }

    /// Simulates the world, asks what a rigid body lacks in its log, and judges the answer.
    ///
    /// # Errors
    /// [`TrialError`] if it can't be simulated, fitted or diagnosed.
    pub fn run(&self, monitor: &Monitor) -> Result<Answered, TrialError> {
        let recording = world::simulate(&self.scenario, monitor)?;
        let (report, seconds) = lacking_as_advised(&recording, monitor)?;
        // Only now, after the diagnosis has spoken, is the seal opened.
        let truth = self.truth(&recording)?;
        Ok(Answered::new(self.scenario.name.clone(), &truth, &report, seconds))
    }

    /// The log of the world, and what is hidden in it.
    ///
    /// # Errors
    /// [`TrialError`] if it can't be simulated.
    pub fn simulated(&self) -> Result<(Recording, Truth), TrialError> {
        let recording = world::simulate(&self.scenario, &Monitor::new())?;
        let truth = self.truth(&recording)?;
        Ok((recording, truth))
    }

    fn truth(&self, recording: &Recording) -> Result<Truth, TrialError> {
        truth_of(recording, self.class.name(), self.scenario.sensors.velocity)
    }
}

/// What the seal of a simulated recording says is hidden in it.
///
/// # Errors
/// [`TrialError::Seal`] if the seal is damaged.
pub fn truth_of(recording: &Recording, kind: &str, with_speed: bool) -> Result<Truth, TrialError> {
    let opened = recording.seal.as_ref().map(|seal| seal.open()).transpose()?;
    let mut causes = Vec::new();
    if let Some(truth) = opened {
        // What formulas hide they hide as strongly as it says.
        let whole = |HiddenEffect { effect, joint, parameters }| Cause {
            effect,
            joint,
            parameters,
            share: 1.0,
            beside_everyday: None,
        };
        causes = if truth.causes.is_empty() { truth.effects.into_iter().map(whole).collect() } else { truth.causes };
    }
    let planted = causes.iter().map(|cause| planted(cause, recording.joint_count())).collect();
    Ok(Truth { kind: kind.to_owned(), with_speed, planted })
}

/// A cause in the words of the judge.
fn planted(cause: &Cause, joints: usize) -> Planted {
    let place = Place { effect: &cause.effect, joint: cause.joint.map(|joint| joint + 1), joints };
    let parameters = kin::parameters(&cause.effect, &cause.parameters);
    let planted = place.planted(cause.share, parameters);
    Planted { absorbed: place.is_absorbed(), beside_everyday: cause.beside_everyday, ..planted }
}

#[cfg(test)]
mod tests {
    use super::super::verdict::Verdict;
    use super::*;
    use crate::simulation::Excitation;
    use crate::simulation::world::Part;
    use crate::simulation::world::part::SpeedFriction;

    /// A short world with viscous friction, and with something that no catalogue has.
    #[test]
    fn a_world_is_simulated_diagnosed_and_judged() {
        let mut trial = WorldTrial::draw(2, Some(Class::None)).unwrap();
        let joint = 0;
        trial.scenario.parts = vec![Part::SpeedFriction(SpeedFriction { joint, coefficient: 4.0, exponent: 1.0 })];
        trial.scenario.step = 1e-3;
        if let Excitation::MultiSine { duration, .. } | Excitation::Stops { duration, .. } = &mut trial.scenario.motion
        {
            *duration = 8.0;
        }
        let answered = trial.run(&Monitor::new()).unwrap();
        assert_eq!(answered.wanted.len(), 1, "{answered:?}");
        assert_eq!((answered.wanted[0].effect.as_str(), answered.wanted[0].joint), ("viscous-friction", Some(1)));
        let verdict = answered.names.iter().find(|name| name.effect == "viscous-friction").map(|name| name.verdict);
        assert_eq!(verdict, Some(Verdict::Right), "{answered:?}");
    }

    #[test]
    fn causes_are_put_in_the_words_of_the_judge() {
        let cause = |effect: &str, joint, share| Cause {
            effect: effect.to_owned(),
            joint,
            parameters: vec![1.0],
            share,
            beside_everyday: None,
        };
        let friction = planted(&cause("coulomb-friction", Some(1), 0.1), 3);
        assert_eq!(friction.judge("dahl-hysteresis", Some(2)), Verdict::Form);
        assert_eq!(friction.judge("dahl-hysteresis", Some(1)), Verdict::WrongJoint);
        assert_eq!(friction.parameters["coulomb_torque"], 1.0);
        assert!(friction.strong && !planted(&cause("coulomb-friction", Some(1), 0.02), 3).strong);
        assert!(planted(&cause("cable", Some(1), 0.1), 3).unknown);
        assert!(planted(&cause("rotor-inertia", Some(0), 0.1), 3).absorbed);
    }
}
