//! What a log can show of an effect: the band in which models are held against it, and what is left beside what every robot has.
//!
//! Above that band accelerations are noise, and so is what a lag or an elastic joint would make of them, or the torque does not follow
//! the motion: an effect is as strong as it is within the band. And what a rigid body takes up together with the friction and the
//! offsets that nearly every joint has, where models learn, nobody can find; nor what acts where they don't.

use rayon::prelude::*;

use super::TrialError;
use crate::effect::{Effect, Family, registry};
use crate::model::design::Design;
use crate::model::preparation::Preparation;
use crate::model::{self, Model, Preset};
use crate::progress::Monitor;
use crate::recording::Recording;
use crate::recording::split::{Segment, Split};
use crate::signals::Signals;

/// The band of a log, and what models of what every robot has leave of it.
pub(super) struct Shown {
    bands: Vec<Preparation>,
    beside: Vec<Beside>,
}

/// A rigid body with what nearly every joint has, but for one family.
struct Beside {
    without: Option<Family>,
    model: Model,
    /// What it leaves of the log as it is, by run, within the band.
    left: Vec<Signals>,
}

impl Shown {
    /// What this log can show.
    ///
    /// # Errors
    /// [`TrialError`] if no rigid body fits it.
    pub(super) fn of(recording: &Recording, split: &Split) -> Result<Shown, TrialError> {
        let highest = Design::new(recording, split)?.follows_up_to().unwrap_or(f64::INFINITY);
        // No sample is left out: where an effect acts is drawn along the whole way.
        let band = |run: usize| Preparation { every: 1, ..Preparation::of(recording, run).within(highest) };
        let bands: Vec<Preparation> = (0..recording.trajectories.len()).map(band).collect();
        let common: Vec<&'static Effect> = registry::addable().filter(|effect| effect.is_common()).collect();
        let mut families: Vec<Option<Family>> = common.iter().map(|effect| Some(effect.family)).chain([None]).collect();
        families.dedup();
        let joints: Vec<usize> = (0..recording.joint_count()).collect();
        let beside = |without: Option<Family>| {
            let others = common.iter().filter(|effect| Some(effect.family) != without);
            let body = Preset::RigidBody.model(recording)?;
            let model = others.into_iter().try_fold(body, |model, effect| model.with_effect(effect, &joints))?;
            let left = left_by(&model, recording, split, &bands)?;
            Ok(Beside { without, model, left })
        };
        let beside = families.into_par_iter().map(beside).collect::<Result<_, TrialError>>()?;
        Ok(Shown { bands, beside })
    }

    /// What of the signals of a run lies within the band.
    pub(super) fn heard(&self, run: usize, signals: &Signals) -> Signals {
        self.bands[run].apply_all(signals)
    }

    /// The share of an effect, which makes this change within the band (by run), that what every robot has leaves of it in training,
    /// identified anew in the recording into which it was planted: RMS there over RMS of the change everywhere.
    ///
    /// # Errors
    /// [`TrialError`] if nothing fits the recording any more.
    pub(super) fn left_of(
        &self,
        effect: &Effect,
        change: &[Signals],
        planted: &Recording,
        split: &Split,
    ) -> Result<f64, TrialError> {
        let is_it = |beside: &&Beside| beside.without == Some(effect.family);
        let all = self.beside.iter().find(|beside| beside.without.is_none());
        let Some(beside) = self.beside.iter().find(is_it).or(all) else { return Ok(0.0) };
        let mut left = left_by(&beside.model, planted, split, &self.bands)?;
        left.iter_mut().zip(&beside.left).for_each(|(now, before)| now.add(before, -1.0));
        let everywhere: Vec<Segment> = planted.runs().collect();
        Ok((mean_square(&left, &split.train) / mean_square(change, &everywhere)).sqrt())
    }
}

/// What a model leaves of each run within the bands, once it is fitted.
fn left_by(
    model: &Model,
    recording: &Recording,
    split: &Split,
    bands: &[Preparation],
) -> Result<Vec<Signals>, TrialError> {
    let fitted = model::fit(model, recording, split, &Monitor::new())?;
    let of_run = |(trajectory, band): (_, &Preparation)| {
        let predicted = fitted.predict(trajectory)?.total;
        let mut left = trajectory.tau.clone();
        left.add(&predicted, -1.0);
        Ok(band.apply_all(&left))
    };
    recording.trajectories.iter().zip(bands).map(of_run).collect()
}

/// Mean square of these signals (by run) on a part of the recording, all joints together.
fn mean_square(signals: &[Signals], part: &[Segment]) -> f64 {
    let samples: usize = part.iter().map(|segment| segment.samples.len()).sum();
    let of_segment = |segment: &Segment| -> f64 {
        let joints = 0..signals[segment.trajectory].joint_count();
        let values = joints.flat_map(|joint| &signals[segment.trajectory][joint][segment.samples.clone()]);
        values.map(|value| value * value).sum()
    };
    part.iter().map(of_segment).sum::<f64>() / samples.max(1) as f64
}
