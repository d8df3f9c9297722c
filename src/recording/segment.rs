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

    /// Whether they have a sample in common.
    pub fn meets(&self, other: &Segment) -> bool {
        let (own, theirs) = (&self.samples, &other.samples);
        self.trajectory == other.trajectory && own.start < theirs.end && theirs.start < own.end
    }

    /// Cut evenly into pieces that are not longer than this.
    pub fn pieces(&self, longest: usize) -> Vec<Segment> {
        let count = self.samples.len().div_ceil(longest.max(1));
        let cut = |piece: usize| self.samples.start + self.samples.len() * piece / count;
        let piece = |piece: usize| Segment { trajectory: self.trajectory, samples: cut(piece)..cut(piece + 1) };
        (0..count).map(piece).collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_even_and_leave_nothing_out() {
        let cut = |samples: Range<usize>, longest: usize| {
            let pieces = Segment { trajectory: 3, samples }.pieces(longest);
            assert!(pieces.iter().all(|piece| piece.trajectory == 3));
            pieces.into_iter().map(|piece| (piece.samples.start, piece.samples.end)).collect::<Vec<_>>()
        };
        assert_eq!(cut(5..15, 4), [(5, 8), (8, 11), (11, 15)]);
        assert_eq!(cut(5..15, 10), [(5, 15)]);
        assert_eq!(cut(5..7, 0), [(5, 6), (6, 7)], "none is empty");
        assert!(cut(5..5, 4).is_empty());
    }
}
