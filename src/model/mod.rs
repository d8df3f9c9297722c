//! A model is a **sum of torque terms**: τ̂(q, q̇, q̈) = Σ terms.
//!
//! Each term gives its torque by sample and joint. The presets are lists of terms; "add the effect" pushes one. The
//! decomposition plot, the ladder and the diagnosis all read this one list.
//!
//! [`terms`] turns terms into columns along a `working` copy of the recording, [`preparation`] filters and decimates them (up to the `reach` of the torque), a [`design`] holds it, its
//! [`equations`] add up over blocks, [`least_squares`] solves, [`mod@fit`] identifies all parameters jointly, [`evaluate`]
//! predicts and measures the error.

pub mod design;
pub mod ending;
pub mod equations;
pub mod evaluate;
pub mod file;
pub mod fit;
pub mod learned;
pub mod least_squares;
pub(crate) mod line_search;
pub mod preparation;
pub(crate) mod property;
mod reach;
pub mod rest;
pub(crate) mod reversal;
pub(crate) mod sweep;
pub mod terms;
mod waves;
pub mod whitening;
pub mod working;

use serde::{Deserialize, Serialize};

use crate::arm::stated::{Resistance, StatedArm};
use crate::effect::{self, Effect, registry};
use crate::recording::Recording;

pub use evaluate::{Evaluation, JointError, Prediction};
pub use fit::{Fitted, Parameter, fit, fit_plain};
use learned::{Layers, LearnedPreset, LearnedTerm, Positive};
use terms::Setting;

/// A list of torque terms; their order is the order in which they are shown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Model {
    /// The terms.
    pub terms: Vec<Term>,
}

/// One term of a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Term {
    /// The rigid body.
    RigidBody(RigidBody),
    /// What resists each joint by itself, as stated by the arm's maker, held fixed.
    Resistance(Vec<Resistance>),
    /// A physical effect.
    Effect(EffectTerm),
    /// A network.
    Learned(LearnedTerm),
}

/// Where the rigid body's parameters come from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RigidBody {
    /// Base parameters, identified together with everything else.
    Identified,
    /// As stated by the arm's maker, held fixed.
    Stated(StatedArm),
}

/// One effect on one joint, or on the whole arm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EffectTerm {
    /// The effect; its id in files.
    pub effect: &'static Effect,
    /// The joint (from 0); `None` for an effect of the whole arm.
    pub joint: Option<usize>,
}

/// Models to start from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// A rigid body whose base parameters are identified from the data.
    #[default]
    RigidBody,
    /// A rigid body with the parameters that the recording states.
    StatedArm,
    /// One of the paper's models, whose terms are networks.
    #[serde(untagged)]
    Learned(LearnedPreset),
}

/// The model can't be used on this recording.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// The recording has more joints than the planar arm supports.
    #[error("the planar rigid body has 1 to {most} joints, this recording has {joints}: map fewer joints", most = crate::arm::MOST_JOINTS)]
    JointCount {
        /// Of the recording.
        joints: usize,
    },
    /// The stated arm has another number of joints than the recording.
    #[error("the stated arm has {arm} joints, the recording has {recording}: state the arm that was measured")]
    OtherArm {
        /// Joints of the arm.
        arm: usize,
        /// Joints of the recording.
        recording: usize,
    },
    /// The preset needs an arm that the recording does not state.
    #[error(
        "the recording states no arm: choose the preset `rigid-body`, which identifies it, or give an arm file, or that of a robot with masses (--arm)"
    )]
    NoStatedArm,
    /// Rigid bodies of several sliding joints are not known.
    #[error("a sliding joint is supported on its own only, this recording has {joints} joints: map one joint")]
    Prismatic {
        /// Of the recording.
        joints: usize,
    },
    /// A term names a joint that the recording does not have.
    #[error("{effect} is asked for on joint {joint}, but the recording has {joints} joints")]
    NoSuchJoint {
        /// Name of the effect.
        effect: &'static str,
        /// Counted from 1.
        joint: usize,
        /// Of the recording.
        joints: usize,
    },
    /// An effect that no model can have.
    #[error(transparent)]
    NotAddable(#[from] effect::NotAddable),
    /// An effect that can't be computed for these data.
    #[error(transparent)]
    NotApplicable(#[from] effect::NotApplicable),
    /// Too few samples for the number of parameters.
    #[error("{samples} samples are too few to identify {parameters} parameters: record at least {needed}", needed = 4 * parameters)]
    TooFewSamples {
        /// After decimation, over all joints.
        samples: usize,
        /// To be identified.
        parameters: usize,
    },
    /// A model with networks was to be solved for.
    #[error("{0} is a network: it is trained, not identified by least squares")]
    Learned(String),
    /// A trained network can't be used here.
    #[error("{0}")]
    Network(String),
    /// Nothing varies.
    #[error("{0}: no parameter can be identified from it")]
    NothingToLearn(String),
    /// Stopped by the user.
    #[error(transparent)]
    Stopped(#[from] crate::progress::Stopped),
}

impl Preset {
    /// All presets, in the order in which lists show them.
    pub const ALL: [Preset; 7] = [
        Preset::RigidBody,
        Preset::StatedArm,
        Preset::Learned(LearnedPreset::FfNn),
        Preset::Learned(LearnedPreset::BlackBoxDelan),
        Preset::Learned(LearnedPreset::StructuredDelan),
        Preset::Learned(LearnedPreset::DelanFriction),
        Preset::Learned(LearnedPreset::DelanFfnn),
    ];

    /// Its name on the command line and in files.
    pub fn id(self) -> &'static str {
        match self {
            Preset::RigidBody => "rigid-body",
            Preset::StatedArm => "stated-arm",
            Preset::Learned(preset) => preset.id(),
        }
    }

    /// What it is, for lists.
    pub fn description(self) -> &'static str {
        match self {
            Preset::RigidBody => "rigid body, base parameters identified from the data",
            Preset::StatedArm => "rigid body with the masses and lengths that the recording states",
            Preset::Learned(preset) => preset.description(),
        }
    }

    /// Its name for people.
    pub fn title(self) -> &'static str {
        match self {
            Preset::RigidBody => "rigid body",
            Preset::StatedArm => "stated arm",
            Preset::Learned(preset) => preset.title(),
        }
    }

    /// The model for this recording; networks have the sizes of the paper's table 1.
    ///
    /// # Errors
    /// [`ModelError::NoStatedArm`] if the preset needs an arm that the recording does not state.
    pub fn model(self, recording: &Recording) -> Result<Model, ModelError> {
        let terms = match self {
            Preset::RigidBody => vec![Term::RigidBody(RigidBody::Identified)],
            Preset::StatedArm => {
                let setting = Setting::of(recording)?;
                let arm = setting.stated_arm().ok_or(ModelError::NoStatedArm)?;
                let resistances = setting.resistances;
                let body = Term::RigidBody(RigidBody::Stated(arm));
                let resists = (!resistances.is_empty()).then_some(Term::Resistance(resistances));
                [body].into_iter().chain(resists).collect()
            }
            Preset::Learned(preset) => {
                let architecture = preset.architecture(recording.joint_count(), &Layers::default());
                architecture.terms.into_iter().map(Term::Learned).collect()
            }
        };
        Ok(Model { terms })
    }
}

impl Model {
    /// Whether the torque of one of its effects follows from that of the rigid body.
    pub fn depends_on_load(&self) -> bool {
        self.effects().any(|term| term.effect.facts.depends_on_load)
    }

    /// Friction that nearly every joint has, of the kinds that the joints with friction have not: dry friction where it grows with the
    /// speed only, and the other way round. None where resistance is stated.
    pub(crate) fn common_friction_beside(&self, joints: usize) -> Vec<EffectTerm> {
        if self.terms.iter().any(|term| matches!(term, Term::Resistance(_))) {
            return Vec::new();
        }
        let common: Vec<&'static Effect> = registry::addable().filter(|effect| effect.is_common_friction()).collect();
        let has = |joint: usize, effect: &Effect| {
            self.effects().any(|term| term.joint == Some(joint) && term.effect.family == effect.family)
        };
        let lacking = |joint: usize| {
            let (own, other): (Vec<_>, Vec<_>) = common.iter().partition(|effect| has(joint, effect));
            let lacking = if own.is_empty() { Vec::new() } else { other };
            lacking.into_iter().map(move |effect| EffectTerm { effect, joint: Some(joint) })
        };
        (0..joints).flat_map(lacking).collect()
    }

    /// This model with an effect more: on each of `joints`, or on the whole arm if the effect is one of the whole arm.
    ///
    /// Effects that the new one includes (Stribeck includes Coulomb) are replaced. An effect that is there already is
    /// not added twice.
    ///
    /// # Errors
    /// [`ModelError::NotAddable`] if it is a fault of the readings.
    pub fn with_effect(&self, effect: &'static Effect, joints: &[usize]) -> Result<Model, ModelError> {
        effect.check_addable()?;
        let mut model = self.clone();
        for joint in effect.places(joints.iter().copied()) {
            let covers = |old: &EffectTerm| old.joint == joint && (old.effect == effect || old.effect.contains(effect));
            if model.effects().any(covers) {
                continue;
            }
            model.terms.retain(|term| match term {
                Term::Effect(old) => old.joint != joint || !effect.contains(old.effect),
                Term::RigidBody(_) | Term::Resistance(_) | Term::Learned(_) => true,
            });
            model.terms.push(Term::Effect(EffectTerm { effect, joint }));
        }
        Ok(model)
    }

    /// Hidden layers of its first network, if it has any.
    pub fn layers(&self) -> Option<&Layers> {
        self.terms.iter().find_map(|term| if let Term::Learned(term) = term { term.layers() } else { None })
    }

    /// This model with other hidden layers in all its networks.
    pub fn with_layers(&self, layers: &Layers) -> Model {
        let change = |term: &Term| match term {
            Term::Learned(term) => Term::Learned(term.clone().with_layers(layers)),
            other => other.clone(),
        };
        Model { terms: self.terms.iter().map(change).collect() }
    }

    /// This model with another way to keep a learned H positive definite, or none.
    pub fn with_positive(&self, positive: Option<Positive>) -> Model {
        let change = |term: &Term| match term {
            Term::Learned(term) => Term::Learned(term.clone().with_positive(positive)),
            other => other.clone(),
        };
        Model { terms: self.terms.iter().map(change).collect() }
    }

    /// This model with the rigid body held at the stated arm.
    pub fn pinned_to(&self, arm: &StatedArm) -> Model {
        let mut model = self.clone();
        for term in &mut model.terms {
            if let Term::RigidBody(body) = term {
                *body = RigidBody::Stated(arm.clone());
            }
        }
        model
    }

    /// The effects in it.
    pub fn effects(&self) -> impl Iterator<Item = &EffectTerm> {
        self.terms.iter().filter_map(|term| match term {
            Term::Effect(effect) => Some(effect),
            Term::RigidBody(_) | Term::Resistance(_) | Term::Learned(_) => None,
        })
    }

    /// Whether some of its terms are networks, so that it is trained and not solved for.
    pub fn is_learned(&self) -> bool {
        self.terms.iter().any(|term| matches!(term, Term::Learned(_)))
    }

    /// Whether its rigid body is held at a stated arm.
    pub fn is_pinned(&self) -> bool {
        self.terms.iter().any(|term| matches!(term, Term::RigidBody(RigidBody::Stated(_))))
    }
}

impl Term {
    /// Name for legends and tables, such as `Coulomb friction, joint 2`.
    pub fn label(&self) -> String {
        match self {
            Term::RigidBody(RigidBody::Identified) => "rigid body".to_owned(),
            Term::RigidBody(RigidBody::Stated(_)) => "stated rigid body".to_owned(),
            Term::Resistance(_) => "stated resistance of joints".to_owned(),
            Term::Learned(term) => term.kind().to_owned(),
            Term::Effect(EffectTerm { effect, joint: Some(joint) }) => format!("{}, joint {}", effect.name, joint + 1),
            Term::Effect(EffectTerm { effect, joint: None }) => effect.name.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::registry;

    #[test]
    fn a_fault_of_the_readings_is_refused_as_a_term() {
        let model = Model { terms: vec![Term::RigidBody(RigidBody::Identified)] };
        for id in ["stuck-channel", "torque-saturation"] {
            let effect = registry::find(id).unwrap();
            let error = model.with_effect(effect, &[0]).unwrap_err();
            assert_eq!(error, ModelError::NotAddable(effect::NotAddable { effect: effect.name }));
            assert!(error.to_string().contains("is a fault of the readings"), "{error}");
            assert!(registry::addable().all(|addable| addable != effect));
        }
    }

    #[test]
    fn an_effect_that_is_not_known_ends_with_the_file() {
        let text = |id: &str| format!(r#"{{"terms":[{{"effect":{{"effect":"{id}","joint":0}}}}]}}"#);
        let model: Model = serde_json::from_str(&text("coulomb-friction")).unwrap();
        assert_eq!(serde_json::to_string(&model).unwrap(), text("coulomb-friction"));
        let error = serde_json::from_str::<Model>(&text("magic")).unwrap_err().to_string();
        assert!(error.contains("there is no effect `magic`; known effects: viscous-friction"), "{error}");
    }

    #[test]
    fn terms_and_presets_have_names_of_their_own() {
        for preset in Preset::ALL {
            let others = Preset::ALL.iter().filter(|other| **other != preset);
            let texts = |preset: Preset| [preset.id(), preset.title(), preset.description()];
            assert!(texts(preset).iter().all(|text| !text.is_empty()));
            assert!(
                others.into_iter().all(|other| texts(*other).iter().zip(texts(preset)).all(|(one, own)| *one != own))
            );
        }
        let effect = |id: &str, joint| Term::Effect(EffectTerm { effect: registry::find(id).unwrap(), joint });
        assert_eq!(effect("coulomb-friction", Some(1)).label(), "Coulomb friction, joint 2");
        assert_eq!(effect("actuator-lag", None).label(), registry::find("actuator-lag").unwrap().name);
        assert_eq!(Term::RigidBody(RigidBody::Identified).label(), "rigid body");
        assert_eq!(Term::Learned(LearnedTerm::Friction).label(), "friction");
    }

    #[test]
    fn other_layers_are_those_of_all_networks_and_of_nothing_else() {
        let layers = Layers { hidden: vec![7], ..Layers::default() };
        let terms = LearnedPreset::DelanFfnn.architecture(2, &Layers::default()).terms.into_iter().map(Term::Learned);
        let body = Term::RigidBody(RigidBody::Identified);
        let model = Model { terms: [body.clone()].into_iter().chain(terms).collect() };
        let changed = model.with_layers(&layers);
        assert_eq!((model.layers(), changed.layers()), (Some(&Layers::default()), Some(&layers)));
        assert!(
            changed.terms[1..].iter().all(|term| matches!(term, Term::Learned(term) if term.layers() == Some(&layers)))
        );
        assert_eq!((&changed.terms[0], Model { terms: vec![body.clone()] }.layers()), (&body, None));
    }
}
