//! A part of a recording: what a model learns from, or where its error is measured.

use std::borrow::Cow;

use crate::recording::split::{Segment, Split};
use crate::recording::{Recording, Trajectory};

/// A part of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// All of it.
    Whole,
    /// What a model learns from.
    Training,
    /// Where its error is measured.
    HeldOut,
}

/// Nothing of the recording is in the part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("nothing of this recording is in that part")]
pub struct EmptyPart;

impl Part {
    /// All of them.
    pub const ALL: [Part; 3] = [Part::Whole, Part::Training, Part::HeldOut];

    /// Its name in commands.
    pub fn name(self) -> &'static str {
        match self {
            Part::Whole => "whole",
            Part::Training => "training",
            Part::HeldOut => "held-out",
        }
    }

    /// Its name for people.
    pub fn title(self) -> &'static str {
        match self {
            Part::Whole => "all of it",
            Part::Training => "training part",
            Part::HeldOut => "held-out part",
        }
    }

    /// What it is.
    pub fn about(self) -> &'static str {
        match self {
            Part::Whole => "all of it",
            Part::Training => "what a model learns from",
            Part::HeldOut => "where its error is measured",
        }
    }

    /// The stretches of a recording that are in it.
    ///
    /// # Errors
    /// [`EmptyPart`] if none are.
    pub fn stretches(self, recording: &Recording, split: &Split) -> Result<Vec<Segment>, EmptyPart> {
        let stretches = match self {
            Part::Whole => recording.runs().collect(),
            Part::Training => split.train.clone(),
            Part::HeldOut => split.held_out.clone(),
        };
        if stretches.is_empty() { Err(EmptyPart) } else { Ok(stretches) }
    }

    /// The part as a recording: stretches as runs of their own, named after the runs that they are of.
    ///
    /// # Errors
    /// [`EmptyPart`] if nothing is in it.
    pub fn cut<'a>(self, recording: &'a Recording, split: &Split) -> Result<Cow<'a, Recording>, EmptyPart> {
        if self == Part::Whole {
            return Ok(Cow::Borrowed(recording));
        }
        let runs = self.stretches(recording, split)?.into_iter().map(|stretch| run_of(recording, stretch));
        Ok(Cow::Owned(recording.with_trajectories(runs.collect())))
    }
}

fn run_of(recording: &Recording, stretch: Segment) -> Trajectory {
    let whole = &recording.trajectories[stretch.trajectory];
    let from = whole.time.get(stretch.samples.start).copied().unwrap_or_default();
    let is_whole = stretch.samples.len() == whole.len();
    let mut run = whole.slice(stretch.samples);
    if !is_whole {
        run.name = format!("{} from {from:.3} s", whole.name);
    }
    run
}
