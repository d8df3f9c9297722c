//! A stretch of one trajectory, the unit of which the parts of a recording are made, and how far a filter reaches beyond it.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::differentiate::default_cutoff;
use super::{Origin, Recording};

/// A stretch of one trajectory.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Segment {
    /// Index into [`Recording::trajectories`].
    pub trajectory: usize,
    /// Its samples.
    pub samples: Range<usize>,
}

impl Segment {
    /// The same stretch where only every so manieth sample of the trajectory is left.
    pub fn thinned(&self, every: usize) -> Segment {
        let samples = self.samples.start.div_ceil(every)..self.samples.end.div_ceil(every);
        Segment { trajectory: self.trajectory, samples }
    }
}

/// A stretch whose readings are none.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unusable {
    /// Where.
    pub stretch: Segment,
    /// The joint, from 0, whose torque alone is none there; `None` if the motion is none, which all joints feel.
    pub torque_of: Option<usize>,
}

/// How many periods of its cut-off a filter for derivatives remembers: what is further away counts for less than 3 %
/// (its slowest pole falls as exp(−2.4 t f)).
pub const MEMORY: f64 = 1.5;

/// How far a filter smeared what was measured \[s\], to either side, where velocity or acceleration was derived.
pub(super) fn filter_memory(recording: &Recording, trajectory: usize) -> Option<f64> {
    let provenance = &recording.provenance;
    if [&provenance.velocity, &provenance.acceleration].into_iter().all(|origin| *origin == Origin::Measured) {
        return None;
    }
    let run = &recording.trajectories[trajectory];
    Some(MEMORY / provenance.low_pass_hz.unwrap_or_else(|| default_cutoff(&run.q, &run.qd, run.time_step())))
}
