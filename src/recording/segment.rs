//! A stretch of one trajectory, the unit of which the parts of a recording are made.

use std::ops::Range;

use serde::{Deserialize, Serialize};

/// A stretch of one trajectory.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Segment {
    /// Index into [`super::Recording::trajectories`].
    pub trajectory: usize,
    /// Its samples.
    pub samples: Range<usize>,
}
