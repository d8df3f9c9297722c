//! What was named and is not any more.

use super::report::Ground;
use crate::effect::Effect;

/// How likely what the held-out part contradicts is there after all: see RESULTS.md, "What is held out has a say".
pub const AFTER_ALL: f64 = 0.25;

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

impl Withdrawn {
    /// How likely it is there after all, if it was so likely `before`.
    pub fn presence(&self, before: f64) -> f64 {
        if matches!(self.ground, Ground::Contradicted { .. }) { before.min(AFTER_ALL) } else { before }
    }
}
