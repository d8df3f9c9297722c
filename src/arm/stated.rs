//! What the maker of an arm states: what its links weigh, what resists its joints, and how far, how fast and how strongly they move.
//!
//! A planar arm is stated by its links ([`Arm`]), one in space by rows beside its axes ([`Chain`]); both are torques that are known
//! without any identification ([`StatedArm`]).

use serde::{Deserialize, Serialize};

use super::Arm;
use super::chain::{Chain, PER_LINK};

/// What is stated of a joint and of what moves with it; nothing of what is `None`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Stated {
    /// The ten parameters of all that moves with this joint and with none behind it, in the frame of its axis and about its origin: m,
    /// m x, m y, m z \[kg, kg m\], Ixx, Ixy, Ixz, Iyy, Iyz, Izz \[kg m²\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub link: Option<[f64; PER_LINK]>,
    /// What resists its motion.
    #[serde(skip_serializing_if = "Resistance::is_none")]
    pub resistance: Resistance,
    /// How far, how fast and how strongly it moves.
    #[serde(skip_serializing_if = "Limits::is_none")]
    pub limits: Limits,
    /// Where what moves with it ends, in the frame of its axis \[m\]: the place of a tool.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tip: Option<[f64; 3]>,
}

/// What resists the motion of a joint beside its links: τ = rotor_inertia q̈ + damping q̇ + friction sign(q̇) + stiffness q + preload.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Resistance {
    /// The motor's own inertia, seen through the gear \[kg m², or kg where the joint slides\].
    #[serde(skip_serializing_if = "is_nothing")]
    pub rotor_inertia: f64,
    /// In proportion to speed \[N m s/rad or N s/m\].
    #[serde(skip_serializing_if = "is_nothing")]
    pub damping: f64,
    /// The size of dry friction \[N m or N\].
    #[serde(skip_serializing_if = "is_nothing")]
    pub friction: f64,
    /// Of a spring in the joint \[N m/rad or N/m\].
    #[serde(skip_serializing_if = "is_nothing")]
    pub stiffness: f64,
    /// The torque of that spring at q = 0 \[N m or N\].
    #[serde(skip_serializing_if = "is_nothing")]
    pub preload: f64,
}

/// Within what a joint moves.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Limits {
    /// Lowest and highest position \[rad or m\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 2]>,
    /// Highest speed \[rad/s or m/s\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<f64>,
    /// Largest torque \[N m\] or force \[N\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effort: Option<f64>,
}

/// An arm of which is stated what its links weigh.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum StatedArm {
    /// Links in a plane.
    Planar(Arm),
    /// Links about axes that each state one.
    Spatial(Chain),
}

fn is_nothing(value: &f64) -> bool {
    *value == 0.0
}

impl Stated {
    /// Whether all its numbers are finite.
    pub fn is_finite(&self) -> bool {
        let Stated { link, resistance, limits, tip } = self;
        let Resistance { rotor_inertia, damping, friction, stiffness, preload } = *resistance;
        let of_limits = limits.position.iter().flatten().chain(&limits.velocity).chain(&limits.effort);
        link.iter()
            .flatten()
            .chain(tip.iter().flatten())
            .chain(of_limits)
            .chain(&[rotor_inertia, damping, friction, stiffness, preload])
            .all(|value| value.is_finite())
    }

    /// What is stated, if anything is.
    pub fn if_any(self) -> Option<Self> {
        Some(self).filter(|stated| *stated != Stated::default())
    }
}

impl Resistance {
    /// Whether nothing resists.
    pub fn is_none(&self) -> bool {
        *self == Resistance::default()
    }

    /// The torque \[N m or N\] at this position, speed and acceleration; `direction` is that of the motion, −1 to 1.
    pub fn torque(&self, [q, qd, qdd]: [f64; 3], direction: f64) -> f64 {
        let Resistance { rotor_inertia, damping, friction, stiffness, preload } = self;
        rotor_inertia * qdd + damping * qd + friction * direction + stiffness * q + preload
    }
}

impl Limits {
    /// Whether nothing limits it.
    pub fn is_none(&self) -> bool {
        *self == Limits::default()
    }
}

impl StatedArm {
    /// How many joints it has.
    pub fn joint_count(&self) -> usize {
        match self {
            StatedArm::Planar(arm) => arm.joint_count(),
            StatedArm::Spatial(chain) => chain.axes.len(),
        }
    }

    /// Whether it can be an arm of so many joints.
    pub fn can_be_of(&self, joints: usize) -> bool {
        self.joint_count() == joints
            && match self {
                StatedArm::Planar(arm) => arm.check().is_ok(),
                StatedArm::Spatial(chain) => chain.check().is_ok() && chain.states_links(),
            }
    }

    /// Its parameters in the order of the identified ones: [`Arm::lumped_parameters`], or ten for each link of a [`Chain`].
    pub fn parameters(&self) -> Vec<f64> {
        match self {
            StatedArm::Planar(arm) => arm.lumped_parameters(),
            StatedArm::Spatial(chain) => chain.stated_parameters(),
        }
    }
}
