//! Models whose terms are networks: what they are ([`Architecture`]) and what they compute ([`torque`]).
//!
//! The paper's five models are five lists of terms; see [`LearnedPreset`].

pub mod torque;

use serde::{Deserialize, Serialize};

use crate::arm::MOST_JOINTS;
use crate::network::Activation;

/// A model whose torque is a sum of learned terms.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Architecture {
    /// How many joints the arm has, 1 to 7.
    pub joints: usize,
    /// How positions enter the networks.
    pub features: Features,
    /// What is added up.
    pub terms: Vec<LearnedTerm>,
    /// Sizes of the quantities that enter and leave; all 1 in the paper.
    pub scales: Scales,
}

/// How positions enter the networks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Features {
    /// (cos q, sin q): right for revolute joints, which come back to where they were after a turn.
    #[default]
    CosSin,
    /// (cos, sin) of every sum of neighbouring joint angles, q_i + … + q_j. These are the directions of the links, and the angles
    /// between any two of them: all that H and V of a planar arm depend on. H sees those without the first joint.
    LinkAngles,
    /// q itself: for sliding joints.
    Raw,
}

/// Typical sizes, so that the networks see and give numbers about 1.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scales {
    /// Velocities are divided by this before they enter a network \[rad/s\].
    pub velocity: f64,
    /// Accelerations are divided by this before they enter a network \[rad/s²\].
    pub acceleration: f64,
    /// Lagrangians and torques of networks are multiplied by this \[N m\].
    pub torque: f64,
    /// H of a structured Lagrangian is multiplied by this \[kg m²\], so that H q̈ begins no larger than the torque is; without
    /// it by `torque`, as in models of before, which began with an inertia that was as many times too large as accelerations
    /// are greater than 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inertia: Option<f64>,
    /// The weight of each joint, from 0 to 1, the smaller the smaller its torque is; empty: all alike. What a light joint does to the
    /// energy is as small as its torque, so a Lagrangian network sees its angle, and gives its inertia, so many times as small: else
    /// each step that suits the heavy joints shakes the light ones.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub joints: Vec<f64>,
}

impl Default for Scales {
    fn default() -> Self {
        Scales { velocity: 1.0, acceleration: 1.0, torque: 1.0, inertia: None, joints: Vec::new() }
    }
}

/// Hidden layers of one network.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Layers {
    /// Width of each hidden layer.
    pub hidden: Vec<usize>,
    /// Their activation.
    pub activation: Activation,
}

impl Default for Layers {
    /// Those of the paper's table 1.
    fn default() -> Self {
        Layers { hidden: vec![64, 64], activation: Activation::Tanh }
    }
}

/// One learned term.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LearnedTerm {
    /// L = ½ q̇ᵀ H(q) q̇ − V(q) with H = C Cᵀ + ε I from a network for the lower triangle C, and a network for V.
    StructuredLagrangian {
        /// Of both networks.
        layers: Layers,
        /// How the diagonal of C is kept positive, and H away from zero. `None`: H = C + Cᵀ, which nothing keeps positive
        /// definite; only who wants to see what becomes of that asks for it.
        positive: Option<Positive>,
    },
    /// One network for L(q, q̇).
    BlackBoxLagrangian {
        /// Of the network.
        layers: Layers,
    },
    /// One network for τ(q, q̇, q̈).
    FeedForward {
        /// Of the network.
        layers: Layers,
        /// λ: the loss grows by λ‖τ / scale‖² of this term; 0 for none.
        penalty: f64,
    },
    /// Stribeck friction of each joint, its coefficients trained: (τ_c + τ_s e^(−(q̇/v_s)²)) sign q̇ + d q̇.
    Friction,
    /// Columns of any effects (see [`crate::effect`]), each with one trained factor.
    Columns {
        /// Names of the factors, one for each column.
        names: Vec<String>,
    },
}

/// C_ii = softplus(o + shift) + floor, H = C Cᵀ + inertia · I.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Positive {
    /// Added before the softplus.
    pub shift: f64,
    /// Smallest diagonal entry of C.
    pub floor: f64,
    /// Added to the diagonal of H \[kg m²\].
    pub inertia: f64,
}

impl Positive {
    /// As in the published DeLaN code: bounds the diagonal of H by 0.01 kg m² from below.
    pub const PAPER: Positive = Positive { shift: 2.0, floor: 0.1, inertia: 0.0 };
}

/// The paper's models.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LearnedPreset {
    /// τ from one network.
    FfNn,
    /// One network for the Lagrangian.
    BlackBoxDelan,
    /// Networks for H and V.
    StructuredDelan,
    /// The same, with Stribeck friction.
    DelanFriction,
    /// The same, with a network for the rest.
    DelanFfnn,
}

impl LearnedPreset {
    /// All of them, in the paper's order.
    pub const ALL: [LearnedPreset; 5] = [
        LearnedPreset::FfNn,
        LearnedPreset::BlackBoxDelan,
        LearnedPreset::StructuredDelan,
        LearnedPreset::DelanFriction,
        LearnedPreset::DelanFfnn,
    ];

    /// Its name on the command line and in files.
    pub fn id(self) -> &'static str {
        match self {
            LearnedPreset::FfNn => "ff-nn",
            LearnedPreset::BlackBoxDelan => "black-box-delan",
            LearnedPreset::StructuredDelan => "structured-delan",
            LearnedPreset::DelanFriction => "delan-friction",
            LearnedPreset::DelanFfnn => "delan-ffnn",
        }
    }

    /// Its name for people, as in the paper.
    pub fn title(self) -> &'static str {
        match self {
            LearnedPreset::FfNn => "FF-NN",
            LearnedPreset::BlackBoxDelan => "black-box DeLaN",
            LearnedPreset::StructuredDelan => "structured DeLaN",
            LearnedPreset::DelanFriction => "DeLaN-Friction",
            LearnedPreset::DelanFfnn => "DeLaN-FFNN",
        }
    }

    /// What it learns, for lists.
    pub fn description(self) -> &'static str {
        match self {
            LearnedPreset::FfNn => "one network gives the torque from q, q̇, q̈",
            LearnedPreset::BlackBoxDelan => "one network gives the Lagrangian, the torque follows from it",
            LearnedPreset::StructuredDelan => {
                "networks give the mass matrix and the potential energy, the torque follows"
            }
            LearnedPreset::DelanFriction => "structured DeLaN with Stribeck friction whose coefficients are trained",
            LearnedPreset::DelanFfnn => "structured DeLaN with a network for what it can't explain",
        }
    }

    /// The preset with this name.
    pub fn parse(id: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|preset| preset.id() == id)
    }

    /// The preset's terms, with the paper's definitions and λ = 0.1 (the paper prints none).
    pub fn architecture(self, joints: usize, layers: &Layers) -> Architecture {
        let layers = || layers.clone();
        let structured = || LearnedTerm::StructuredLagrangian { layers: layers(), positive: Some(Positive::PAPER) };
        let terms = match self {
            LearnedPreset::FfNn => vec![LearnedTerm::FeedForward { layers: layers(), penalty: 0.0 }],
            LearnedPreset::BlackBoxDelan => vec![LearnedTerm::BlackBoxLagrangian { layers: layers() }],
            LearnedPreset::StructuredDelan => vec![structured()],
            LearnedPreset::DelanFriction => vec![structured(), LearnedTerm::Friction],
            LearnedPreset::DelanFfnn => {
                vec![structured(), LearnedTerm::FeedForward { layers: layers(), penalty: 0.1 }]
            }
        };
        Architecture { joints, features: Features::CosSin, terms, scales: Scales::default() }
    }
}

/// The architecture is not one that can be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ArchitectureError {
    /// Too few or too many joints.
    #[error("a learned model has 1 to {MOST_JOINTS} joints, not {0}")]
    JointCount(usize),
    /// Nothing to add up.
    #[error("the model has no terms: add a Lagrangian, a feed-forward network or effects")]
    NoTerms,
    /// The same kind of term twice: their parameters could not be told apart.
    #[error("the model has two terms of the kind `{0}`: keep one")]
    Twice(&'static str),
    /// A layer without neurons, or so many that it can only be a mistake.
    #[error("a hidden layer of {0} neurons: choose between 1 and {MOST_NEURONS}")]
    Width(usize),
    /// More hidden layers than is sensible.
    #[error("{0} hidden layers: choose between 0 and {MOST_LAYERS}")]
    Depth(usize),
    /// Weights of other joints.
    #[error("there are {weights} weights of joints for {joints} joints: one for each, or none")]
    Weights {
        /// How many weights there are.
        weights: usize,
        /// How many joints.
        joints: usize,
    },
    /// A number out of its range.
    #[error("{quantity} is {value}, but must be {must}")]
    Number {
        /// Which.
        quantity: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        must: &'static str,
    },
}

/// Widest hidden layer.
pub const MOST_NEURONS: usize = 4096;
/// Deepest network.
pub const MOST_LAYERS: usize = 16;

impl LearnedTerm {
    /// Its kind, for names and messages.
    pub fn kind(&self) -> &'static str {
        match self {
            LearnedTerm::StructuredLagrangian { .. } => "structured Lagrangian",
            LearnedTerm::BlackBoxLagrangian { .. } => "black-box Lagrangian",
            LearnedTerm::FeedForward { .. } => "feed-forward",
            LearnedTerm::Friction => "friction",
            LearnedTerm::Columns { .. } => "effects",
        }
    }

    /// Whether its torque follows from a Lagrangian.
    pub fn is_lagrangian(&self) -> bool {
        matches!(self, LearnedTerm::StructuredLagrangian { .. } | LearnedTerm::BlackBoxLagrangian { .. })
    }

    /// Its hidden layers, if it is a network.
    pub fn layers(&self) -> Option<&Layers> {
        match self {
            LearnedTerm::StructuredLagrangian { layers, .. }
            | LearnedTerm::BlackBoxLagrangian { layers }
            | LearnedTerm::FeedForward { layers, .. } => Some(layers),
            LearnedTerm::Friction | LearnedTerm::Columns { .. } => None,
        }
    }

    /// This term with other hidden layers, if it has any.
    pub fn with_layers(mut self, other: &Layers) -> Self {
        match &mut self {
            LearnedTerm::StructuredLagrangian { layers, .. }
            | LearnedTerm::BlackBoxLagrangian { layers }
            | LearnedTerm::FeedForward { layers, .. } => layers.clone_from(other),
            LearnedTerm::Friction | LearnedTerm::Columns { .. } => {}
        }
        self
    }

    /// This term with another way to keep H positive definite, or none, if it has an H.
    pub fn with_positive(mut self, other: Option<Positive>) -> Self {
        if let LearnedTerm::StructuredLagrangian { positive, .. } = &mut self {
            *positive = other;
        }
        self
    }
}

impl Architecture {
    /// Checks that it can be built.
    ///
    /// # Errors
    /// [`ArchitectureError`] says what can't be.
    pub fn check(&self) -> Result<(), ArchitectureError> {
        if !(1..=MOST_JOINTS).contains(&self.joints) {
            return Err(ArchitectureError::JointCount(self.joints));
        }
        if self.terms.is_empty() {
            return Err(ArchitectureError::NoTerms);
        }
        for (index, term) in self.terms.iter().enumerate() {
            if self.terms[..index].iter().any(|other| other.kind() == term.kind()) {
                return Err(ArchitectureError::Twice(term.kind()));
            }
            let hidden = term.layers().map_or(&[][..], |layers| &layers.hidden);
            if hidden.len() > MOST_LAYERS {
                return Err(ArchitectureError::Depth(hidden.len()));
            }
            if let Some(width) = hidden.iter().find(|width| !(1..=MOST_NEURONS).contains(*width)) {
                return Err(ArchitectureError::Width(*width));
            }
            let (floor, inertia, penalty) = match term {
                LearnedTerm::StructuredLagrangian { positive: Some(positive), .. } => {
                    (positive.floor, positive.inertia, 0.0)
                }
                LearnedTerm::FeedForward { penalty, .. } => (0.0, 0.0, *penalty),
                _ => (0.0, 0.0, 0.0),
            };
            for (quantity, value) in
                [("the floor of the diagonal", floor), ("the added inertia", inertia), ("the penalty", penalty)]
            {
                if !(value >= 0.0 && value.is_finite()) {
                    return Err(ArchitectureError::Number { quantity, value, must: "a finite number of 0 or more" });
                }
            }
        }
        let Scales { velocity, acceleration, torque, inertia, joints } = &self.scales;
        if ![0, self.joints].contains(&joints.len()) {
            return Err(ArchitectureError::Weights { weights: joints.len(), joints: self.joints });
        }
        let scales = [
            ("velocity scale", *velocity),
            ("acceleration scale", *acceleration),
            ("torque scale", *torque),
            ("inertia scale", inertia.unwrap_or(*torque)),
        ];
        for (quantity, value) in scales.into_iter().chain(joints.iter().map(|weight| ("weight of a joint", *weight))) {
            if !(value > 0.0 && value.is_finite()) {
                return Err(ArchitectureError::Number { quantity, value, must: "a finite number above 0" });
            }
        }
        Ok(())
    }

    /// How many effect columns a sample carries.
    pub fn column_count(&self) -> usize {
        self.terms.iter().map(|term| if let LearnedTerm::Columns { names } = term { names.len() } else { 0 }).sum()
    }

    /// In a few words, for messages.
    pub fn describe(&self) -> String {
        let terms: Vec<String> = self
            .terms
            .iter()
            .map(|term| match term.layers() {
                Some(layers) => format!("{} {:?} {:?}", term.kind(), layers.hidden, layers.activation).to_lowercase(),
                None => term.kind().to_owned(),
            })
            .collect();
        format!("{} joints, {}", self.joints, terms.join(" + "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layers(hidden: &[usize]) -> Layers {
        Layers { hidden: hidden.to_vec(), ..Layers::default() }
    }

    #[test]
    fn presets_are_found_by_their_names() {
        for preset in LearnedPreset::ALL {
            assert_eq!(LearnedPreset::parse(preset.id()), Some(preset));
            assert_eq!(serde_json::to_value(preset).unwrap(), preset.id());
            let others = LearnedPreset::ALL.iter().filter(|other| **other != preset);
            assert!(
                others.into_iter().all(|it| (it.title(), it.description()) != (preset.title(), preset.description()))
            );
            assert!(!preset.title().is_empty() && !preset.description().is_empty());
            assert_eq!(preset.architecture(3, &layers(&[8])).check(), Ok(()));
        }
        assert_eq!(LearnedPreset::parse("delan"), None);
    }

    #[test]
    fn the_terms_of_the_presets_are_those_of_the_paper() {
        let kinds = |preset: LearnedPreset| -> Vec<&str> {
            preset.architecture(2, &layers(&[8])).terms.iter().map(LearnedTerm::kind).collect()
        };
        assert_eq!(kinds(LearnedPreset::FfNn), ["feed-forward"]);
        assert_eq!(kinds(LearnedPreset::BlackBoxDelan), ["black-box Lagrangian"]);
        assert_eq!(kinds(LearnedPreset::StructuredDelan), ["structured Lagrangian"]);
        assert_eq!(kinds(LearnedPreset::DelanFriction), ["structured Lagrangian", "friction"]);
        assert_eq!(kinds(LearnedPreset::DelanFfnn), ["structured Lagrangian", "feed-forward"]);
        let of_energy = LearnedPreset::ALL.map(|preset| {
            preset.architecture(2, &layers(&[8])).terms.iter().filter(|term| term.is_lagrangian()).count()
        });
        assert_eq!(of_energy, [0, 1, 1, 1, 1]);
        let architecture = LearnedPreset::DelanFriction.architecture(2, &layers(&[8, 4]));
        assert_eq!(architecture.describe(), "2 joints, structured lagrangian [8, 4] tanh + friction");
        assert_eq!(architecture.terms[0].layers(), Some(&layers(&[8, 4])));
        assert_eq!((architecture.terms[1].layers(), architecture.column_count()), (None, 0));
        let names = vec!["one".to_owned(), "two".to_owned(), "three".to_owned()];
        let columns = LearnedTerm::Columns { names };
        assert_eq!((columns.kind(), columns.is_lagrangian(), columns.layers()), ("effects", false, None));
        let with_columns = Architecture { terms: vec![columns], ..architecture };
        assert_eq!(with_columns.column_count(), 3);
        // q, q̇, q̈, τ and three columns of two joints each, in whole vectors.
        let features = with_columns.state_features();
        assert!((14..14 + 8).contains(&features) && features.is_multiple_of(4), "{features}");
    }

    #[test]
    fn what_can_not_be_built_is_refused_with_its_reason() {
        let sound = LearnedPreset::DelanFfnn.architecture(2, &layers(&[8]));
        let refused = |change: &dyn Fn(&mut Architecture)| {
            let mut changed = sound.clone();
            change(&mut changed);
            changed.check().unwrap_err()
        };
        for joints in [0, MOST_JOINTS + 1] {
            assert_eq!(refused(&|it| it.joints = joints), ArchitectureError::JointCount(joints));
        }
        assert_eq!(refused(&|it| it.terms.clear()), ArchitectureError::NoTerms);
        let twice = refused(&|it| it.terms.extend([LearnedTerm::Friction, LearnedTerm::Friction]));
        assert_eq!(twice, ArchitectureError::Twice("friction"));
        let hidden = |sizes: Vec<usize>| refused(&|it| it.terms[1] = it.terms[1].clone().with_layers(&layers(&sizes)));
        assert_eq!(hidden(vec![1; MOST_LAYERS + 1]), ArchitectureError::Depth(MOST_LAYERS + 1));
        for width in [0, MOST_NEURONS + 1] {
            assert_eq!(hidden(vec![8, width]), ArchitectureError::Width(width));
        }
        let number = |error: ArchitectureError| match error {
            ArchitectureError::Number { quantity, .. } => quantity,
            other => panic!("{other}"),
        };
        let positive = |floor, inertia| Some(Positive { shift: 0.0, floor, inertia });
        let held = |positive| number(refused(&|it| it.terms[0] = it.terms[0].clone().with_positive(positive)));
        assert_eq!(held(positive(-0.1, 0.0)), "the floor of the diagonal");
        assert_eq!(held(positive(0.1, f64::INFINITY)), "the added inertia");
        let penalty = LearnedTerm::FeedForward { layers: layers(&[8]), penalty: f64::NAN };
        assert_eq!(number(refused(&|it| it.terms[1] = penalty.clone())), "the penalty");
        let weights = refused(&|it| it.scales.joints = vec![1.0; 3]);
        assert_eq!(weights, ArchitectureError::Weights { weights: 3, joints: 2 });
        assert_eq!(number(refused(&|it| it.scales.joints = vec![1.0, 0.0])), "weight of a joint");
        assert_eq!(number(refused(&|it| it.scales.velocity = 0.0)), "velocity scale");
        assert_eq!(number(refused(&|it| it.scales.acceleration = -1.0)), "acceleration scale");
        assert_eq!(number(refused(&|it| it.scales.torque = f64::NAN)), "torque scale");
        assert_eq!(number(refused(&|it| it.scales.inertia = Some(f64::INFINITY))), "inertia scale");
    }
}
