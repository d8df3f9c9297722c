//! What a robot's file can say of a joint, and which parameters of a model are that.

use super::Format;
use crate::effect::own::{Quantity, Writer};
use crate::model::EffectTerm;

/// What a robot's file can say of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Property {
    /// In proportion to the velocity.
    Damping,
    /// The size of dry friction.
    Friction,
    /// Inertia about the joint's axis alone.
    Armature,
    /// In proportion to the position.
    Stiffness,
    /// The torque of a spring at q = 0.
    Preload,
}

impl Property {
    /// Whether the format has a word for it; a constant torque needs a spring.
    pub(super) fn is_held(self, format: Format, has_spring: bool) -> bool {
        self.attribute(format).is_some() && (self != Property::Preload || has_spring)
    }

    /// Its name in the file.
    pub(super) fn attribute(self, format: Format) -> Option<&'static str> {
        match (format, self) {
            (_, Property::Damping) => Some("damping"),
            (Format::Urdf, Property::Friction) => Some("friction"),
            (Format::Urdf, _) => None,
            (Format::Mjcf, Property::Friction) => Some("frictionloss"),
            (Format::Mjcf, Property::Armature) => Some("armature"),
            (Format::Mjcf, Property::Stiffness) => Some("stiffness"),
            (Format::Mjcf, Property::Preload) => Some("springref"),
        }
    }
}

/// For each linear parameter of an effect on one joint what it is of the joint, if it is one of these.
pub(super) fn plain_columns(placed: &EffectTerm, joints: usize) -> Vec<Option<Property>> {
    let (Some(own), Some(form)) = (placed.joint, placed.effect.closed_form()) else { return Vec::new() };
    let shape = vec![None; placed.effect.shapes().count()];
    let columns = form.write(joints, own, &shape, &mut Plain, |_, quantity, joint| {
        let of_own = match quantity {
            Quantity::Position => Some(Property::Stiffness),
            Quantity::Velocity => Some(Property::Damping),
            Quantity::Acceleration => Some(Property::Armature),
            Quantity::Direction => Some(Property::Friction),
            Quantity::PairDirection | Quantity::Load => None,
        };
        of_own.filter(|_| joint == own)
    });
    let plain = |parts: Vec<(usize, Option<Property>)>| match parts.as_slice() {
        [(joint, property)] if *joint == own => *property,
        _ => None,
    };
    columns.into_iter().flatten().map(plain).collect()
}

/// Sees whether a formula is a channel and nothing else.
struct Plain;

impl Writer for Plain {
    type Value = Option<Property>;

    fn number(&mut self, number: f64) -> Self::Value {
        (number == 1.0).then_some(Property::Preload)
    }

    fn of_one(&mut self, _: &'static str, _: Self::Value) -> Self::Value {
        None
    }

    fn of_two(&mut self, _: &'static str, _: Self::Value, _: Self::Value) -> Self::Value {
        None
    }
}
