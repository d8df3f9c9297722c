//! Charts of the same quantity have the same view: who zooms or moves one of them does so with all, on every screen.

use std::collections::HashMap;

use super::Window;

/// What stands along the horizontal axis of a chart; joints are counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Along {
    /// Time of the chosen trajectory.
    Time,
    /// Time of all trajectories, end to end.
    WholeTime,
    /// Time of the replay outside the data.
    ReplayTime,
    /// Position of a joint.
    Position(usize),
    /// Velocity of a joint.
    Velocity(usize),
    /// Acceleration of a joint.
    Acceleration(usize),
    /// Measured torque of a joint.
    Load(usize),
    /// What the model leaves of it.
    Residual(usize),
    /// Frequency.
    Frequency,
    /// How often something repeats in a turn.
    Order,
    /// Time between a value and the one it is compared with.
    Lag,
    /// Epoch of a training.
    Epoch,
    /// How much faster or wider than the data.
    Stretch,
}

/// The view of every quantity.
#[derive(Debug, Default)]
pub struct Views(HashMap<Along, Window>);

impl Views {
    /// The view of all charts of a quantity.
    pub fn of(&mut self, along: Along) -> &mut Window {
        self.0.entry(along).or_default()
    }

    /// Charts of this quantity show everything.
    pub fn fit(&mut self, along: Along) {
        self.0.remove(&along);
    }

    /// All charts show everything.
    pub fn fit_all(&mut self) {
        self.0.clear();
    }
}
