//! What was named and is not any more.

use super::report::Ground;
use crate::effect::Effect;

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
