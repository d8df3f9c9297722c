//! What stands along charts: those of the same quantity have the same view, and may have the same lines.

use std::fmt;

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
    /// Position of the joint that goes while the others stand.
    Slice,
    /// How much faster or wider than the data.
    Stretch,
}

/// Its name as a link of axes.
impl fmt::Display for Along {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{self:?}")
    }
}
