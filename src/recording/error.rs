//! What keeps arrays from being a recording.

use crate::arm::ArmError;
use crate::arm::chain::ChainError;
use crate::signals::ShapeError;

/// A recording does not keep what its types promise.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RecordingError {
    /// It has no joint.
    #[error("the recording has no joint; at least one is needed")]
    NoJoint,
    /// It has no trajectory.
    #[error("the recording has no trajectory; at least one is needed")]
    NoTrajectory,
    /// A channel of a trajectory has the wrong shape.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// A value is NaN or infinite.
    #[error(
        "trajectory `{trajectory}`: {channel} of joint {joint} is {value} at sample {sample}; cut the trajectory there"
    )]
    NotFinite {
        /// Name of the trajectory.
        trajectory: String,
        /// Which channel.
        channel: &'static str,
        /// Counted from 1.
        joint: usize,
        /// Counted from 0.
        sample: usize,
        /// The value.
        value: f64,
    },
    /// The clock stands still, goes back or is not a number.
    #[error("trajectory `{trajectory}`: time goes from {before} s to {after} s at sample {sample}, but must increase")]
    Clock {
        /// Name of the trajectory.
        trajectory: String,
        /// The later of the two samples, counted from 0.
        sample: usize,
        /// Its predecessor's time \[s\].
        before: f64,
        /// Its time \[s\].
        after: f64,
    },
    /// The stated arm can't exist.
    #[error("the stated arm: {0}")]
    Arm(#[from] ArmError),
    /// The stated axes can't exist, or belong to another arm.
    #[error("the stated axes: {0}")]
    Chain(#[from] ChainError),
    /// The posture's angle is not a number.
    #[error("the posture's angle at q = 0 is {0} rad, but must be finite")]
    Posture(f64),
}
