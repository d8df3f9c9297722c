//! Worlds of rigid bodies that a seed draws: the diagnosis sees the log, and is judged by what the parts really did.
//!
//! What is weaker than `TO_BE_NAMED` of its joint's torque may be named or not: a strong part may do little in the motion that
//! was drawn, and a weak one is there to disturb.

use super::TrialError;
use super::foreign::{Answered, lacking};
use super::verdict::{Planted, Truth};
use crate::effect::registry;
use crate::progress::Monitor;
use crate::recording::Recording;
use crate::recording::seal::{Cause, HiddenEffect};
use crate::simulation::world::{self, Class, Scenario};

/// Share of the torque from which on an effect has to be named.
const TO_BE_NAMED: f64 = 0.03;

/// Friction that stays when the speed falls. In a motion that does not dwell on what tells them apart each is a form of the others.
const DRY: [&str; 11] = [
    "coulomb-friction",
    "asymmetric-friction",
    "stribeck-friction",
    "dahl-hysteresis",
    "maxwell-slip",
    "bouc-wen-hysteresis",
    "lugre-friction",
    "friction-drift",
    "friction-warm-up",
    "load-friction",
    "position-friction",
];

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
        let (report, seconds) = lacking(&recording, monitor)?;
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
pub(super) fn truth_of(recording: &Recording, kind: &str, with_speed: bool) -> Result<Truth, TrialError> {
    let opened = recording.seal.as_ref().map(|seal| seal.open()).transpose()?;
    let mut causes = Vec::new();
    if let Some(truth) = opened {
        // What formulas hide they hide as strongly as it says.
        let whole = |HiddenEffect { effect, joint, parameters }| Cause { effect, joint, parameters, share: 1.0 };
        causes = if truth.causes.is_empty() { truth.effects.into_iter().map(whole).collect() } else { truth.causes };
    }
    let planted = causes.iter().map(|cause| planted(cause, recording.joint_count())).collect();
    Ok(Truth { kind: kind.to_owned(), with_speed, planted })
}

/// A cause in the words of the judge.
fn planted(cause: &Cause, joints: usize) -> Planted {
    let known = registry::find(&cause.effect).ok();
    let names = known.iter().flat_map(|effect| effect.parameters);
    let joint = cause.joint.map(|joint| joint + 1);
    let [equal, also] = kin(&cause.effect, joint, joints);
    Planted {
        effect: cause.effect.clone(),
        joint,
        strong: cause.share >= TO_BE_NAMED,
        equal,
        also,
        unknown: known.is_none(),
        // The rotor of the first joint turns with the first link.
        absorbed: cause.effect == "tip-payload" || (cause.effect == "rotor-inertia" && joint == Some(1)),
        parameters: names.map(|parameter| parameter.name.to_owned()).zip(cause.parameters.iter().copied()).collect(),
    }
}

/// Names with their places.
type Names = Vec<(String, Option<usize>)>;

/// What else says the same of the motion, and what goes with it.
fn kin(effect: &str, joint: Option<usize>, joints: usize) -> [Names; 2] {
    let here = |names: &[&str]| -> Names { names.iter().map(|name| ((*name).to_owned(), joint)).collect() };
    let of_arm = |name: &str| vec![(name.to_owned(), None)];
    match effect {
        _ if DRY.contains(&effect) => {
            // Different in the two directions is the same friction with an offset.
            let also = if effect == "asymmetric-friction" { here(&["torque-offset"]) } else { Vec::new() };
            [here(&DRY), also]
        }
        "viscous-friction" => [here(&["quadratic-drag"]), Vec::new()],
        "quadratic-drag" => [here(&["viscous-friction"]), Vec::new()],
        "joint-spring" | "hardening-spring" | "end-stop" => {
            [here(&["joint-spring", "hardening-spring", "end-stop"]), here(&["torque-offset"])]
        }
        "torque-offset" => [here(&["offset-drift", "joint-spring"]), Vec::new()],
        "offset-drift" => [here(&["torque-offset"]), Vec::new()],
        "joint-elasticity" => [here(&["backlash"]), here(&["rotor-inertia"])],
        "backlash" => [here(&["joint-elasticity"]), here(&["rotor-inertia"])],
        "actuator-lag" => [of_arm("derivative-delay"), Vec::new()],
        "base-tilt" => {
            let leaning = (1..=joints).map(|joint| ("com-offset".to_owned(), Some(joint)));
            [leaning.collect(), Vec::new()]
        }
        "com-offset" => [of_arm("base-tilt"), Vec::new()],
        _ => [Vec::new(), Vec::new()],
    }
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
    fn every_kin_is_in_the_catalogue_and_is_not_itself_alone() {
        for effect in registry::ALL {
            let id = effect.id;
            for (name, _) in kin(id, Some(1), 3).concat() {
                assert!(registry::find(&name).is_ok(), "{id}: {name}");
            }
        }
        let cause =
            |effect: &str, joint, share| Cause { effect: effect.to_owned(), joint, parameters: vec![1.0], share };
        let friction = planted(&cause("coulomb-friction", Some(1), 0.1), 3);
        assert_eq!(friction.judge("dahl-hysteresis", Some(2)), Verdict::Form);
        assert_eq!(friction.judge("dahl-hysteresis", Some(1)), Verdict::WrongJoint);
        assert_eq!(friction.parameters["coulomb_torque"], 1.0);
        assert!(friction.strong && !planted(&cause("coulomb-friction", Some(1), 0.02), 3).strong);
        assert!(planted(&cause("cable", Some(1), 0.1), 3).unknown);
        assert!(planted(&cause("rotor-inertia", Some(0), 0.1), 3).absorbed);
    }
}
