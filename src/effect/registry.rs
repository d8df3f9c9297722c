//! Every effect that the program knows. A new effect is one new file and one line here.

use super::*;

/// All effects, in the order in which help and lists show them.
pub static ALL: &[&dyn Effect] = &[
    &viscous_friction::ViscousFriction,
    &coulomb_friction::CoulombFriction,
    &stribeck_friction::StribeckFriction,
    &joint_spring::JointSpring,
    &torque_offset::TorqueOffset,
    &tip_payload::TipPayload,
    &rotor_inertia::RotorInertia,
];

/// No effect has this id.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no effect `{id}`; known effects: {known}")]
pub struct UnknownEffect {
    /// What was asked for.
    pub id: String,
    /// What there is.
    pub known: String,
}

/// The effect with this id.
///
/// # Errors
/// [`UnknownEffect`] lists the ids that exist.
pub fn find(id: &str) -> Result<&'static dyn Effect, UnknownEffect> {
    ALL.iter().copied().find(|effect| effect.spec().id == id).ok_or_else(|| UnknownEffect {
        id: id.to_owned(),
        known: ALL.iter().map(|effect| effect.spec().id).collect::<Vec<_>>().join(", "),
    })
}
