//! What was named and is not any more.

use super::report::{Ground, MissingEffect};
use crate::effect::{Effect, Family};

/// What was named and is not any more, once it was added.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Withdrawn {
    /// The effect.
    pub effect: &'static Effect,
    /// The joint, from 0; `None` for the whole arm.
    pub joint: Option<usize>,
    /// Why.
    pub ground: Ground,
}

/// Whether a family is not shown at its place once all that is named is fitted together, and none of its forms has stayed there.
pub fn is_gone(family: Family, joint: Option<usize>, withdrawn: &[Withdrawn], named: &[MissingEffect]) -> bool {
    let is_here = |effect: &Effect, at: Option<usize>| effect.family == family && at == joint;
    let left = |one: &Withdrawn| one.ground == Ground::NotShown && is_here(one.effect, one.joint);
    let stays =
        |one: &MissingEffect| one.effect.places(one.joints.iter().copied()).iter().any(|&at| is_here(one.effect, at));
    withdrawn.iter().any(left) && !named.iter().any(stays)
}
