//! Which parameters of an effect are a plain property of its joint: in proportion to one channel of it and to nothing else.

use super::EffectTerm;
use crate::effect::own::{Quantity, Writer};

/// A plain property of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Property {
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

/// For each linear parameter of an effect on one joint what it is of the joint, if it is one of these.
pub(crate) fn plain_columns(placed: &EffectTerm, joints: usize) -> Vec<Option<Property>> {
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

#[cfg(test)]
mod tests {
    use super::*;

    use crate::effect::registry;

    #[test]
    fn plain_properties_are_told_from_formulas() {
        let of = |id: &str| {
            let effect = registry::find(id).unwrap();
            plain_columns(&EffectTerm { effect, joint: Some(1) }, 3)
        };
        assert_eq!(of("viscous-friction"), [Some(Property::Damping)]);
        assert_eq!(of("coulomb-friction"), [Some(Property::Friction)]);
        let spring = of("joint-spring");
        assert!(spring.contains(&Some(Property::Stiffness)) && spring.contains(&Some(Property::Preload)), "{spring:?}");
        assert!(of("hardening-spring").contains(&None), "a cube is no plain property");
        let nowhere = EffectTerm { effect: registry::find("viscous-friction").unwrap(), joint: None };
        assert_eq!(plain_columns(&nowhere, 3), []);
    }
}
