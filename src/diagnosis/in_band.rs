//! What a model leaves of a recording where models are fitted: in the band of the fit, without the ends of runs, where derived signals go
//! astray, and where a joint moves, since what dry friction holds a joint that rests with nobody can tell, and it drowns the rest.
//!
//! The motion is that of the reader, not the one in the wide band to which models are fitted: noise of an encoder that is doubly derived
//! there is weighed down by whatever dampens fast motion (elasticity), in training and where it is held out alike.

use std::ops::Range;

use crate::model::Evaluation;
use crate::model::design::Design;
use crate::model::preparation::Preparation;
use crate::model::rest::{Counting, blank};
use crate::model::working::inside;
use crate::recording::Recording;
use crate::recording::split::Split;
use crate::signals::Signals;

/// A recording where models are fitted.
pub struct InBand<'a> {
    recording: &'a Recording,
    preparations: Vec<Preparation>,
    /// Of each run which samples are not its ends.
    inside: Vec<Range<usize>>,
    /// Of each run and joint at which prepared samples it moves.
    moves: Vec<Vec<Vec<bool>>>,
    split: Split,
    /// The same in prepared samples.
    prepared: Split,
}

/// τ − τ̂ of each run, 0 at its ends \[N m\].
pub struct Left {
    /// As it was measured.
    pub whole: Vec<Signals>,
    /// Prepared; 0 where a joint rests.
    pub in_band: Vec<Signals>,
}

impl<'a> InBand<'a> {
    /// Of a recording, of which a part or all are in this design.
    pub fn of(recording: &'a Recording, split: &Split, design: &Design) -> Self {
        let preparations = Preparation::of_all(recording, design.follows_up_to());
        let moves = Counting::Moving.of_prepared(recording, &preparations);
        let prepared = split.changed(|segment| Some(segment.thinned(preparations[segment.trajectory].every)));
        let (inside, split) = (inside(recording, &preparations), split.clone());
        InBand { recording, preparations, inside, moves, split, prepared }
    }

    /// Its parts.
    pub fn split(&self) -> &Split {
        &self.split
    }

    /// Its parts, in prepared samples.
    pub fn prepared(&self) -> &Split {
        &self.prepared
    }

    /// Every how manieth sample of a run is a prepared one.
    pub fn every(&self, run: usize) -> usize {
        self.preparations[run].every
    }

    /// At which prepared samples of a run each joint moves.
    pub fn moves(&self, run: usize) -> &[Vec<bool>] {
        &self.moves[run]
    }

    /// What a model leaves of it that was held against it.
    pub fn left(&self, evaluation: &Evaluation) -> Left {
        let mut all = Left { whole: Vec::new(), in_band: Vec::new() };
        for run in 0..self.recording.trajectories.len() {
            let mut left = evaluation.residual(self.recording, run);
            // What goes astray at the ends would reach inside by the filter.
            let Range { start, end } = self.inside[run];
            for joint in 0..left.joint_count() {
                left[joint][..start].fill(0.0);
                left[joint][end..].fill(0.0);
            }
            let mut in_band = self.preparations[run].apply_all(&left);
            for (joint, moves) in self.moves[run].iter().enumerate() {
                blank(&mut in_band[joint], moves);
            }
            all.whole.push(left);
            all.in_band.push(in_band);
        }
        all
    }
}
