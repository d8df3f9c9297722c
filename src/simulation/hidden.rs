//! The effects that a scenario hides: checked, computed, and drawn so that they have a wanted strength.

use rand::Rng;

use super::strength::Strength;
use super::{Draw, Scenario, SimulationError, demand, random};
use crate::arm::Arm;
use crate::arm::dynamics::Components;
use crate::effect::{Effect, Load, Motion, NotApplicable, Scope, registry};
use crate::progress::Monitor;
use crate::recording::seal::{HiddenEffect, Truth};
use crate::recording::{JointKind, Trajectory};
use crate::signals::Signals;

/// A hidden effect that was found to make sense for an arm of a number of joints.
pub(super) struct Hidden<'a> {
    pub(super) effect: &'static Effect,
    /// 0 for an effect of the whole arm, which ignores it.
    joint: usize,
    parameters: &'a [f64],
}

impl<'a> Hidden<'a> {
    fn resolve(hidden: &'a HiddenEffect, joints: usize) -> Result<Self, SimulationError> {
        let effect = registry::find(&hidden.effect)?;
        effect.check_parameters(&hidden.parameters)?;
        let joint = checked_place(effect, hidden.joint, joints)?;
        Ok(Hidden { effect, joint, parameters: &hidden.parameters })
    }

    /// By this they act one after the other: along the chain, and within a stage in an order that depends on nothing else.
    fn turn(&self) -> (usize, &'static str, usize) {
        (self.effect.stage.number(), self.effect.id, self.joint)
    }

    /// Its torque \[N m\] by its formula along the true motion of the arm, whose torque is still that of the bare arm; what a
    /// fault of the readings makes of that.
    pub(super) fn torque(&self, arm: &Arm, trajectory: &Trajectory) -> Result<Signals, SimulationError> {
        if self.effect.fault().is_some() {
            let mut read = trajectory.clone();
            self.misread(&mut read);
            let mut error = read.tau.clone();
            error.add(&trajectory.tau, -1.0);
            return Ok(error);
        }
        self.along(arm, trajectory, |motion| self.effect.torque(motion, self.joint, self.parameters))
    }

    /// What it does to the `torque` of the arm and the effects before it, along the true motion of the arm.
    pub(super) fn act(&self, arm: &Arm, trajectory: &Trajectory, torque: &mut Signals) -> Result<(), SimulationError> {
        self.along(arm, trajectory, |motion| self.effect.act(motion, self.joint, self.parameters, torque))
    }

    /// What it does to the readings.
    pub(super) fn misread(&self, reading: &mut Trajectory) {
        self.effect.misread(reading, self.joint, self.parameters);
    }

    fn along<T>(
        &self,
        arm: &Arm,
        trajectory: &Trajectory,
        work: impl FnOnce(&Motion) -> Result<T, NotApplicable>,
    ) -> Result<T, SimulationError> {
        let kinds = vec![JointKind::Revolute; arm.joint_count()];
        let load = self.effect.facts.depends_on_load.then(|| Load::of_arm(arm, trajectory));
        let motion = Motion {
            trajectory,
            kinds: &kinds,
            posture: arm.posture,
            gravity: arm.gravity,
            arm: Some(arm),
            chain: None,
            load: load.as_ref(),
            reversal_widths: &[],
        };
        Ok(work(&motion)?)
    }
}

/// What the true torque is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueParts {
    /// Of the bare arm \[N m\].
    pub arm: Components,
    /// Of each hidden effect, in the order of the truth \[N m\].
    pub effects: Vec<Signals>,
}

impl TrueParts {
    /// Along a motion.
    ///
    /// # Errors
    /// If the truth holds an effect that is not known, or that its arm can't have.
    pub fn along(truth: &Truth, motion: &Trajectory) -> Result<Self, SimulationError> {
        let arm = truth.arm.components_along(&motion.q, &motion.qd, &motion.qdd);
        let tau = truth.arm.inverse_dynamics_along(&motion.q, &motion.qd, &motion.qdd);
        let bare = motion.clone().with_torque(tau)?;
        let torque = |hidden| Hidden::resolve(hidden, truth.arm.joint_count())?.torque(&truth.arm, &bare);
        let effects = truth.effects.iter().map(torque).collect::<Result<_, SimulationError>>()?;
        Ok(TrueParts { arm, effects })
    }
}

/// The hidden effects in the order in which they act, checked against an arm of a number of joints.
pub(super) fn resolve(hidden: &[HiddenEffect], joints: usize) -> Result<Vec<Hidden<'_>>, SimulationError> {
    let mut effects = hidden.iter().map(|hidden| Hidden::resolve(hidden, joints)).collect::<Result<Vec<_>, _>>()?;
    effects.sort_by_key(Hidden::turn);
    Ok(effects)
}

/// Lets all hidden effects act on the torque of the bare arm, one after the other.
pub(super) fn add(effects: &[Hidden], arm: &Arm, run: &mut Trajectory) -> Result<(), SimulationError> {
    let mut torque = run.tau.clone();
    effects.iter().try_for_each(|effect| effect.act(arm, run, &mut torque))?;
    Ok(run.set_torque(torque)?)
}

/// The joint (from 0) where an effect acts on an arm of a number of joints; 0 for an effect of the whole arm.
fn checked_place(effect: &Effect, joint: Option<usize>, joints: usize) -> Result<usize, SimulationError> {
    let first = usize::from(effect.scope == Scope::Pair);
    match (effect.scope, joint) {
        (Scope::Joint | Scope::Pair, Some(joint)) if (first..joints).contains(&joint) => Ok(joint),
        (Scope::Joint | Scope::Pair, Some(joint)) => {
            Err(SimulationError::NoSuchJoint { effect: effect.name, joint: joint + 1, joints })
        }
        (Scope::Joint | Scope::Pair, None) => Err(SimulationError::JointMissing(effect.name)),
        (Scope::Arm, None) => Ok(0),
        (Scope::Arm, Some(_)) => Err(SimulationError::JointOnWholeArm(effect.name)),
    }
}

impl Scenario {
    /// Hides an effect with these parameters; [`Scenario::check`] says whether it can be.
    pub fn hide(&mut self, effect: &str, joint: Option<usize>, parameters: Vec<f64>) {
        self.effects.push(HiddenEffect { effect: effect.to_owned(), joint, parameters });
    }

    /// An effect with parameters such that the RMS of its torque on this scenario's motion is `strength` times the RMS of
    /// the torque that the bare arm needs: of each joint in `joints` (counted from 0) for itself, or of all joints together
    /// for an effect of the whole arm, which ignores `joints`.
    ///
    /// Shape parameters and the proportions of the linear ones are drawn, by the scenario's seed.
    ///
    /// # Errors
    /// [`SimulationError`] if the scenario, the effect or a joint does not exist, or if the effect makes no torque here.
    pub fn hide_by_strength(
        &self,
        effect: &str,
        joints: &[usize],
        strength: f64,
    ) -> Result<Vec<HiddenEffect>, SimulationError> {
        demand("strength of the hidden effect", strength, strength > 0.0, "a finite number above 0")?;
        let effect = registry::find(effect)?;
        self.check_measured(effect)?;
        let places = effect.places(joints.iter().copied());
        if places.is_empty() {
            return Err(SimulationError::JointMissing(effect.name));
        }
        let runs = self.exact_runs(&Monitor::new())?;
        let mut random = random(self.seed, Draw::Effects);
        places.into_iter().map(|joint| self.scaled(effect, joint, strength, &runs, &mut random)).collect()
    }

    fn scaled(
        &self,
        effect: &'static Effect,
        joint: Option<usize>,
        share: f64,
        runs: &[Trajectory],
        random: &mut impl Rng,
    ) -> Result<HiddenEffect, SimulationError> {
        let place = checked_place(effect, joint, self.arm.joint_count())?;
        let torque = |parameters: &[f64]| {
            let hidden = Hidden { effect, joint: place, parameters };
            runs.iter().map(|run| hidden.torque(&self.arm, run)).collect()
        };
        let parameters = Strength { effect, joint, share, runs }.draw(random, torque)?;
        Ok(HiddenEffect { effect: effect.id.to_owned(), joint, parameters })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::Role;

    fn rms_ratio(scenario: &Scenario, hidden: &HiddenEffect) -> f64 {
        let runs = scenario.exact_runs(&Monitor::new()).unwrap();
        let effect = Hidden::resolve(hidden, scenario.arm.joint_count()).unwrap();
        let (mut of_effect, mut of_arm) = (0.0, 0.0);
        let torques: Vec<Signals> = runs.iter().map(|run| effect.torque(&scenario.arm, run).unwrap()).collect();
        // Some runs may not reach an end stop; its joint feels it all the same.
        let feels = |joint: usize| torques.iter().any(|torque| torque[joint].iter().any(|value| *value != 0.0));
        for (run, torque) in runs.iter().zip(&torques) {
            for joint in 0..run.joint_count() {
                if feels(joint) {
                    of_effect += torque[joint].iter().map(|x| x * x).sum::<f64>();
                    of_arm += run.tau[joint].iter().map(|x| x * x).sum::<f64>();
                }
            }
        }
        (of_effect / of_arm).sqrt()
    }

    #[test]
    fn every_effect_can_be_hidden_at_a_wanted_strength() {
        let scenario = Scenario { effects: Vec::new(), ..Scenario::embedded() };
        let runs = scenario.exact_runs(&Monitor::new()).unwrap();
        for effect in registry::ALL {
            for hidden in scenario.hide_by_strength(effect.id, &[0, 2], 0.07).unwrap() {
                assert_eq!(hidden.joint.is_none(), effect.scope == Scope::Arm);
                let ratio = rms_ratio(&scenario, &hidden);
                // Readings are faulty as a whole or not at all.
                let tolerance = if effect.fault().is_some() { 0.01 } else { 1e-9 };
                assert!((ratio - 0.07).abs() < tolerance, "{}: {ratio}", effect.id);
                for (parameter, value) in effect.parameters.iter().zip(&hidden.parameters) {
                    if let Role::Shape { starts, .. } = parameter.role {
                        let way = Trajectory::way(&runs, hidden.joint.unwrap_or(0));
                        let values = starts.values(way);
                        assert!((values[0]..=values[values.len() - 1]).contains(value), "{} {value}", parameter.name);
                    }
                    assert!(*value != 0.0, "{} is 0", parameter.name);
                }
            }
        }
    }

    #[test]
    fn what_can_not_be_hidden_is_named() {
        let scenario = Scenario::embedded();
        let message = |effect, joints: &[usize], strength| {
            scenario.hide_by_strength(effect, joints, strength).unwrap_err().to_string()
        };
        assert!(message("magic", &[0], 0.1).contains("there is no effect `magic`; known effects: viscous-friction"));
        assert_eq!(
            message("viscous-friction", &[3], 0.1),
            "viscous friction is to act on joint 4, but the arm has 3: choose a joint from 1 to 3"
        );
        assert!(message("viscous-friction", &[], 0.1).contains("say on which joint"));
        assert!(message("viscous-friction", &[0], 0.0).contains("strength of the hidden effect is 0"));

        let mut weightless = scenario.clone();
        weightless.arm.gravity = 0.0;
        for link in &mut weightless.arm.links {
            link.mass = 1e-200;
            link.inertia = 0.0;
        }
        let message = weightless.hide_by_strength("viscous-friction", &[0], 0.1).unwrap_err().to_string();
        assert!(message.contains("can't be given a strength on joint 1"), "{message}");
    }

    #[test]
    fn mysteries_differ_and_repeat() {
        let drawn: Vec<Scenario> = (0..300).map(|seed| Scenario::mystery(seed).unwrap()).collect();
        for (seed, scenario) in drawn.iter().enumerate().take(30) {
            assert_eq!(scenario, &Scenario::mystery(seed as u64).unwrap());
            assert!((1..=2).contains(&scenario.effects.len()));
            for hidden in &scenario.effects {
                let ratio = rms_ratio(scenario, hidden);
                assert!((0.03..=0.2).contains(&ratio), "seed {seed}: {ratio}");
            }
        }
        for effect in registry::ALL {
            let id = effect.id;
            assert!(drawn.iter().any(|scenario| scenario.effects[0].effect == id), "{id} was never drawn");
        }
    }
}
