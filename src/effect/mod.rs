//! Physical effects: one file each, all in one [`registry`], and the chain in which they act.
//!
//! The simulator, the models, the diagnosis, the lessons and the help text read the same file. To add an effect, copy
//! the file that is nearest to it and add one line to the registry.
//!
//! Effects act along a chain, body → drive → reading, and each says its [`Stage`]. In a model the torque of every effect has
//! the form
//!
//! ```text
//! τ = Σₖ θₖ · φₖ(motion; shape)
//! ```
//!
//! with linear parameters θ (a friction torque, a stiffness) and shape parameters (a Stribeck velocity). An effect gives
//! the columns φ; whoever fits it solves for θ by least squares and searches the shape. A column is computed along a whole
//! trajectory, so effects with an inner state (hysteresis, lag) can simulate it.

pub mod own;
pub mod place;
pub mod registry;

mod closed_form;
mod column;
mod family;
mod motion;
mod parameter;
mod stage;
#[cfg(test)]
pub(crate) mod testing;

mod actuator_lag;
mod asymmetric_friction;
mod backlash;
mod base_tilt;
mod bouc_wen_hysteresis;
mod cogging;
mod com_offset;
mod concave_friction;
mod coulomb_friction;
mod dahl_hysteresis;
mod dead_zone;
mod derivative_delay;
mod friction_coupling;
mod friction_drift;
mod friction_warm_up;
mod frictional_heating;
mod hardening_spring;
mod inertia_coupling;
mod joint_elasticity;
mod joint_spring;
mod load_friction;
mod lower_stop;
mod lugre_friction;
mod maxwell_slip;
mod motor_side;
mod motor_side_backlash;
mod motor_side_elasticity;
mod offset_drift;
mod position_friction;
mod quadratic_drag;
mod rotor_inertia;
mod stribeck_friction;
mod stuck_channel;
mod tip_payload;
mod torque_coupling;
mod torque_gain;
mod torque_offset;
mod torque_saturation;
mod upper_stop;
mod viscous_friction;

use std::fmt;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::recording::differentiate::central_difference;
use crate::recording::encoders::Side;
use crate::recording::fault::FaultKind;
use crate::recording::{Channels, JointKind, Recording, Trajectory};

pub use closed_form::ClosedForm;
pub use column::Column;
pub use coulomb_friction::sign;
pub use family::{Family, Group};
pub use motion::{Lack, Load, Motion, NotApplicable};
pub use parameter::{Dimension, MOST_PEAKS, ParameterError, ParameterSpec, Role, Starts, Way};
pub use stage::{AddsTorque, ChangesReading, ChangesTorque, NotAddable, Remedy, SetsRight, Stage};

/// A physical effect: its texts and parameters, what it does, and all that a rule needs to know of it.
///
/// Two are equal if they have the same id; in files an effect is its id.
pub struct Effect {
    /// Stable name for files and the command line, such as `coulomb-friction`.
    pub id: &'static str,
    /// Name for people, such as `Coulomb friction`.
    pub name: &'static str,
    /// Formula in plain text.
    pub formula: &'static str,
    /// Formula in TeX.
    pub typeset: &'static str,
    /// What it is and where it comes from, in a sentence or two.
    pub description: &'static str,
    /// What its residual looks like, and in which view.
    pub fingerprint: &'static str,
    /// What base parameters or a learned Lagrangian can absorb of it.
    pub absorbed: &'static str,
    /// Where the formula stands.
    pub source: &'static str,
    /// Where in the chain it stands, and what it does there.
    pub stage: Stage,
    /// What it is hardly told from.
    pub family: Family,
    /// One joint or the whole arm.
    pub scope: Scope,
    /// The state over which its residual shows best.
    pub axis: Axis,
    /// Linear parameters first, then shape parameters.
    pub parameters: &'static [ParameterSpec],
    /// What rules need to know of it.
    pub facts: Facts,
}

/// What rules need to know of an effect, so that none needs its id. Most effects are as in [`Facts::USUAL`].
pub struct Facts {
    /// Whether it needs `Motion::load`, which changes with the rigid body's parameters.
    pub depends_on_load: bool,
    /// Whether nearly every real joint has it, so that it comes to mind before any other: friction, the zero of the torque
    /// reading, the inertia of a geared motor.
    pub everyday: bool,
    /// Whether it is a constant error of the torque reading, which takes the mean of whatever else is wrong there.
    pub is_offset: bool,
    /// Whether base parameters that are identified beside it absorb it, wholly or on some joint, so that only a stated arm shows
    /// it.
    pub absorbed_by_body: bool,
    /// Whether only what one joint has of it more than another shows: of all joints at once base parameters that are identified beside
    /// it absorb it.
    pub is_relative: bool,
    /// Whether the friction that a network learns stands for it, among others.
    pub learned_friction: bool,
    /// The side of the gear on which its formula takes the encoder to be, if that matters.
    pub encoder: Option<Side>,
    /// The id of what it is called where the encoder is on the other side.
    pub other_side: Option<&'static str>,
    /// Whether it is an error of measured velocities or accelerations: those that are derived from the position by no filter that runs
    /// forward only can't have it.
    pub of_measured_derivatives: bool,
    /// Ids of effects whose columns this one contains, so that it replaces them.
    pub includes: &'static [&'static str],
    /// What usual data can hardly tell from it, so that whoever names it must name these too.
    pub look_alikes: &'static [LookAlike],
    /// Ids of effects of other families that say the same of most motions, so that either name is right.
    pub also_said_as: &'static [&'static str],
    /// Ids of effects that may be named beside this one, since a fit shares it out among them.
    pub goes_with: &'static [&'static str],
    /// Id of the effect by which it was named before the catalogue had it: a truth of then means either.
    pub formerly: Option<&'static str>,
    /// An effect whose formula is only so exact that it leaves a little of this one.
    pub left_by: Option<LeftBy>,
    /// The text of the file that states it, if it is one of somebody's own: whatever is saved with it keeps the text, too.
    pub written: Option<&'static str>,
}

/// Effects that together do nearly what another one does.
#[derive(Debug)]
pub struct LookAlike {
    /// Their ids; on the same joint.
    pub effects: &'static [&'static str],
    /// The data that tell, a sentence.
    pub told_by: &'static str,
}

/// No drive, bus or filter of a controller is later \[s\]: current loops take about a millisecond, buses a few, filters of velocities
/// some tens. A log that is later is set up wrong ([`crate::recording::correction`] sets it right).
const LONGEST_DELAY: f64 = 0.1;

/// Up to this share above the least wave number that can be shown a search has come to its end there.
const AT_LEAST: f64 = 0.01;

/// What tells models of hysteresis from each other.
const PRE_SLIDING: &str = "Many small reversals, of less than the breakaway distance, at different speeds.";

/// What tells friction that falls with the way that is rubbed from friction that changes with time.
const WARMING: &str =
    "Runs at different speeds: what rubs heats the joint more in fast ones, while time passes alike in all.";

/// The effect whose formula leaves a little of another one on the same joint.
pub struct LeftBy {
    /// Its id.
    pub effect: &'static str,
    /// Whether these linear parameters of the other one, beside those of this one, are no more than what it leaves.
    pub is_left: fn(&[f64], &[f64]) -> bool,
}

/// What an effect acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// One joint's motion makes torque on that joint.
    Joint,
    /// A joint and the one before it; the later one names the pair.
    Pair,
    /// The whole arm.
    Arm,
}

/// A state to draw a residual over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    /// t
    Time,
    /// q
    Position,
    /// q̇
    Velocity,
    /// q̈
    Acceleration,
}

impl Facts {
    /// Of an effect that no rule singles out.
    pub const USUAL: Facts = Facts {
        depends_on_load: false,
        everyday: false,
        is_offset: false,
        absorbed_by_body: false,
        is_relative: false,
        learned_friction: false,
        encoder: None,
        other_side: None,
        of_measured_derivatives: false,
        includes: &[],
        look_alikes: &[],
        also_said_as: &[],
        goes_with: &[],
        formerly: None,
        left_by: None,
        written: None,
    };
}

impl Effect {
    /// It and its place, in words: `Coulomb friction on joint 2`.
    pub fn placed(&self, joint: Option<usize>) -> String {
        match (self.scope, joint) {
            (Scope::Joint, Some(joint)) => format!("{} on joint {}", self.name, joint + 1),
            (Scope::Pair, Some(joint)) => format!("{} of joints {} and {}", self.name, joint, joint + 1),
            _ => self.name.to_owned(),
        }
    }

    /// What a recording lacks for its formula to hold there, whatever the arm and the motion: encoders on the side that it speaks of,
    /// derivatives that were measured.
    pub fn lack_in(&self, recording: &Recording) -> Option<Lack> {
        let side = self.facts.encoder.filter(|own| recording.encoders.is_some_and(|side| side != *own));
        let derived = recording.provenance.is_derived() && self.facts.of_measured_derivatives;
        side.map(|side| Lack::Encoders { side }).or(derived.then_some(Lack::MeasuredDerivatives))
    }

    /// Whether nearly every joint has it, in proportion to what is known of the motion, and a rigid body does not take it up.
    pub fn is_common(&self) -> bool {
        let facts = &self.facts;
        facts.everyday && self.scope == Scope::Joint && self.shapes().next().is_none() && !facts.absorbed_by_body
    }

    /// Whether it is friction that nearly every joint has.
    pub fn is_common_friction(&self) -> bool {
        self.is_common() && !self.facts.is_offset
    }

    /// Whether each of the two alone does nearly what the other does.
    pub fn looks_like(&self, other: &Effect) -> bool {
        self.facts.look_alikes.iter().any(|look_alike| look_alike.effects == [other.id])
    }

    /// The others whose sum no data tell it from, by their ids; it is then named as that sum.
    pub fn sum(&self) -> Option<&'static [&'static str]> {
        self.facts.look_alikes.iter().map(|others| others.effects).find(|effects| effects.len() > 1)
    }

    /// Whether its columns hold those of the other one and more (Stribeck has Coulomb).
    pub fn contains(&self, other: &Effect) -> bool {
        self.facts.includes.contains(&other.id)
    }

    /// Whether it, with these linear parameters, is no more than what the formula of another effect on the same joint leaves.
    pub fn is_left_by(&self, own: &[f64], other: &Effect, others: &[f64]) -> bool {
        self.facts.left_by.as_ref().is_some_and(|left| left.effect == other.id && (left.is_left)(own, others))
    }

    /// Checks that these are as many parameters as the effect has, each within its bounds.
    ///
    /// # Errors
    /// [`ParameterError`] names the first that is not.
    pub fn check_parameters(&self, parameters: &[f64]) -> Result<(), ParameterError> {
        if parameters.len() != self.parameters.len() {
            let names: Vec<_> = self.parameters.iter().map(|parameter| parameter.name).collect();
            let expected = names.join(", ");
            return Err(ParameterError::Count { effect: self.name, expected, given: parameters.len() });
        }
        for (spec, &value) in self.parameters.iter().zip(parameters) {
            if !value.is_finite() || !(spec.min..=spec.max).contains(&value) {
                let ParameterSpec { name: parameter, min, max, .. } = *spec;
                return Err(ParameterError::Bounds { effect: self.name, parameter, value, min, max });
            }
        }
        Ok(())
    }

    /// Where the effect acts if it is to act on `joints` (from 0); `None` stands for the whole arm. For the pair of the
    /// first joint, which has none before it, its pair with the second is taken.
    pub fn places(&self, joints: impl IntoIterator<Item = usize>) -> Vec<Option<usize>> {
        let joints = joints.into_iter();
        match self.scope {
            Scope::Arm => vec![None],
            Scope::Joint => joints.map(Some).collect(),
            Scope::Pair => {
                let mut places: Vec<_> = joints.map(|joint| Some(joint.max(1))).collect();
                places.sort_unstable();
                places.dedup();
                places
            }
        }
    }

    /// The linear parameters.
    pub fn linear(&self) -> impl Iterator<Item = &'static ParameterSpec> {
        self.parameters.iter().filter(|parameter| matches!(parameter.role, Role::Linear))
    }

    /// The shape parameters and where the search for them starts.
    pub fn shapes(&self) -> impl Iterator<Item = (&'static ParameterSpec, Starts)> {
        self.parameters.iter().filter_map(|parameter| match parameter.role {
            Role::Shape { starts, .. } => Some((parameter, starts)),
            Role::Linear | Role::Reading => None,
        })
    }

    /// The least values of the shape parameters that a motion along this way of the joint can show.
    pub fn least_shape(&self, way: impl Into<Way>) -> Vec<f64> {
        let way = way.into();
        let least = |parameter: &ParameterSpec| match parameter.role {
            Role::Shape { least_shown, .. } => Some(parameter.min.max(least_shown(way))),
            Role::Linear | Role::Reading => None,
        };
        self.parameters.iter().filter_map(least).collect()
    }

    /// Whether each wave of this shape repeats along this way of the joint: not where its number is the least that such a motion can show,
    /// or below, since what fits it then may be something else that bows.
    pub fn repeats_along(&self, way: impl Into<Way>, shape: &[f64]) -> bool {
        let way = way.into();
        let mut waves = self.shapes().zip(self.least_shape(way)).zip(shape);
        waves.all(|(((_, starts), least), &value)| !matches!(starts, Starts::Waves) || value > (1.0 + AT_LEAST) * least)
    }

    /// Linear and shape parameters among all.
    fn parted<'a>(&self, parameters: &'a [f64]) -> Result<[&'a [f64]; 2], NotApplicable> {
        if parameters.len() != self.parameters.len() {
            let lack = Lack::Parameters { needed: self.parameters.len(), given: parameters.len() };
            return Err(NotApplicable { effect: self.name, lack });
        }
        let (linear, shape) = parameters.split_at(self.linear().count());
        Ok([linear, shape])
    }
}

impl PartialEq for Effect {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

impl Eq for Effect {}

impl fmt::Debug for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.id)
    }
}

impl Serialize for Effect {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.id)
    }
}

impl<'de> Deserialize<'de> for &'static Effect {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let id = String::deserialize(deserializer)?;
        registry::find(&id).map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::testing::Sample;
    use super::*;

    #[test]
    fn parameters_are_counted_and_kept_in_bounds() {
        let spec = registry::find("stribeck-friction").unwrap();
        assert_eq!(spec.check_parameters(&[1.0, 0.5, 0.1]), Ok(()));
        assert_eq!(
            spec.check_parameters(&[1.0]).unwrap_err().to_string(),
            "Stribeck friction takes the parameters coulomb_torque, stribeck_torque, stribeck_velocity, in this order; 1 were \
             given"
        );
        for wrong in [-1.0, f64::NAN, f64::INFINITY] {
            let message = spec.check_parameters(&[1.0, wrong, 0.1]).unwrap_err().to_string();
            assert!(message.starts_with("stribeck_torque of Stribeck friction is"), "{message}");
        }
        let sample = Sample::new();
        let effect = registry::find("viscous-friction").unwrap();
        assert!(effect.torque(&sample.motion(), 0, &[]).unwrap_err().to_string().contains("1 parameters, 0 were"));
    }

    #[test]
    fn units_follow_the_kind_of_joint() {
        assert_eq!(Dimension::Stiffness.unit(JointKind::Revolute), "N m/rad");
        assert_eq!(Dimension::Stiffness.unit(JointKind::Prismatic), "N/m");
        assert_eq!(Dimension::Mass.unit(JointKind::Revolute), "kg");
    }
}
