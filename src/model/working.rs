//! The recording as models are fitted to it: in a band that is wider than that of the torque, at a rate that is enough for it.
//!
//! Columns are formed along these signals and then filtered as the torque is ([`super::preparation`]), since the filter of a
//! product is not the product of what was filtered: the direction of friction is smeared over a reversal just as the torque is.
//! Derivatives that the reader made for the eye, at the cut-off of the torque, are made anew here in the wide band. Many samples
//! in a band that needs few say nothing more and cost time: a log of 5 kHz is thinned out sixty times.
//!
//! At the ends of a run a derivative sees one side only, and what it makes of that is many times what is left elsewhere: in recording 21 of
//! the forty, in which nothing is missing, one sample left 10 of 24 N m (RMS of the torque). Taken for noise, that hides what is there and
//! makes what is not there look like noise. So the ends of derived signals count for nothing.

use std::borrow::Cow;
use std::ops::Range;

use super::preparation::Preparation;
use crate::recording::differentiate::{derivative, low_pass_joints};
use crate::recording::split::{MEMORY, Segment, Split};
use crate::recording::{Channels, Origin, Provenance, Recording, Trajectory};
use crate::signals::Signals;

/// The wide band reaches so many times as far as the torque's, and ends below this share of the sampling rate.
const WIDER: f64 = 2.5;
const HIGHEST_SHARE: f64 = 0.4;
/// Samples for each period of the torque's cut-off that are kept at least: five for each of the wide band.
const RATE: f64 = 12.5;

/// A trajectory keeps its ends if it is not so many times as long as what each of them leaves out.
const SHORTEST: usize = 8;

/// A recording in the wide band, with its split and the preparation of each trajectory.
pub struct Working<'a> {
    /// The recording.
    pub recording: Cow<'a, Recording>,
    /// Its training and held-out parts.
    pub split: Split,
    /// What its torque and columns pass through.
    pub preparations: Vec<Preparation>,
}

impl<'a> Working<'a> {
    /// Of a recording whose derivatives were measured at a moderate rate it is the recording itself. The band of the torque does
    /// not reach beyond `highest` \[Hz\], if that is given.
    pub fn of(recording: &'a Recording, split: &Split, highest: Option<f64>) -> Self {
        let preparations = Preparation::of_all(recording, highest);
        let bands = bands(recording, &preparations);
        if bands.iter().all(Option::is_none) {
            return Working { recording: Cow::Borrowed(recording), split: split.clone(), preparations };
        }
        let trajectories = in_wide_band(recording, &preparations);
        let every = |trajectory: usize| bands[trajectory].as_ref().map_or(1, |band| band.every);
        let of_band = |segment: &Segment| match &bands[segment.trajectory] {
            Some(band) => band.left_of(segment, recording.trajectories[segment.trajectory].len()),
            None => Some(segment.clone()),
        };
        let of_trajectory = |(trajectory, preparation): (usize, &Preparation)| preparation.after(every(trajectory));
        Working {
            split: split.changed(of_band),
            recording: Cow::Owned(recording.with_trajectories(trajectories)),
            preparations: preparations.iter().enumerate().map(of_trajectory).collect(),
        }
    }
}

impl<'a> Working<'a> {
    /// The recording itself, all of it to learn from.
    pub fn plain(recording: &'a Recording) -> Self {
        let preparation = |trajectory| Preparation::plain(recording, trajectory);
        let preparations = (0..recording.trajectories.len()).map(preparation).collect();
        Working { recording: Cow::Borrowed(recording), split: Split::whole(recording), preparations }
    }
}

/// The trajectories of a recording in the wide band and thinned out, where that gains anything, if its torque passes through these.
pub fn in_wide_band(recording: &Recording, preparations: &[Preparation]) -> Vec<Trajectory> {
    let apply = |(trajectory, band): (&Trajectory, &Option<Band>)| {
        band.as_ref().map_or_else(|| trajectory.clone(), |band| band.apply(trajectory, &recording.provenance))
    };
    recording.trajectories.iter().zip(&bands(recording, preparations)).map(apply).collect()
}

/// Whether accelerations in the wide band come from what was measured, and not from derivatives that the reader made, if the torque passes
/// through these.
pub fn are_derivatives_made_anew(recording: &Recording, preparations: &[Preparation]) -> bool {
    recording.provenance.acceleration == Origin::Measured || bands(recording, preparations).iter().all(Option::is_some)
}

fn bands(recording: &Recording, preparations: &[Preparation]) -> Vec<Option<Band>> {
    preparations.iter().map(|preparation| Band::of(preparation, &recording.provenance)).collect()
}

/// Which samples of each trajectory of a recording count, whose torque passes through these: all but its ends.
pub fn inside(recording: &Recording, preparations: &[Preparation]) -> Vec<Range<usize>> {
    let of_trajectory = |(trajectory, band): (&Trajectory, Option<Band>)| {
        let count = trajectory.len();
        band.map_or(0..count, |band| band.inside(count))
    };
    recording.trajectories.iter().zip(bands(recording, preparations)).map(of_trajectory).collect()
}

/// What is done to the signals of one trajectory.
struct Band {
    /// The end of the wide band \[Hz\].
    cutoff: f64,
    /// Every how manieth sample is kept.
    every: usize,
    /// So many samples at either end count for nothing: there the filter of a derivative sees one side only.
    ends: usize,
}

impl Band {
    /// `None` where there is nothing to gain.
    fn of(preparation: &Preparation, provenance: &Provenance) -> Option<Band> {
        let rate = 1.0 / preparation.time_step;
        let narrow = preparation.cutoff?;
        let cutoff = WIDER * narrow;
        let every = ((rate / (RATE * narrow)) as usize).max(1);
        let is_derived = matches!(provenance.acceleration, Origin::Derived(_));
        let ends = if is_derived { (MEMORY / (narrow * preparation.time_step)).ceil() as usize } else { 0 };
        (every > 1 || is_derived && cutoff < HIGHEST_SHARE * rate).then_some(Band { cutoff, every, ends })
    }

    /// What counts of a trajectory of so many samples.
    fn inside(&self, count: usize) -> Range<usize> {
        let ends = if count < SHORTEST * self.ends { 0 } else { self.ends };
        ends..count - ends
    }

    /// What is left of a stretch of a trajectory of so many samples.
    fn left_of(&self, segment: &Segment, count: usize) -> Option<Segment> {
        let inside = self.inside(count);
        let samples = segment.samples.start.max(inside.start)..segment.samples.end.min(inside.end);
        let counts = Segment { trajectory: segment.trajectory, samples };
        (!counts.samples.is_empty()).then(|| counts.thinned(self.every))
    }

    fn apply(&self, trajectory: &Trajectory, provenance: &Provenance) -> Trajectory {
        let Channels { time, q, qd, qdd, tau } = &**trajectory;
        let step = trajectory.time_step();
        let smooth = |signal: &Signals| low_pass_joints(signal, step, self.cutoff);
        let derived = |signal: &Signals| signal.map_joints(|signal| derivative(signal, time, self.cutoff));
        let (q, tau) = rayon::join(|| smooth(q), || smooth(tau));
        let qd = match provenance.velocity {
            Origin::Measured => smooth(qd),
            Origin::Derived(_) => derived(&q),
        };
        let qdd = match provenance.acceleration {
            Origin::Measured => smooth(qdd),
            Origin::Derived(_) => derived(&qd),
        };
        let channels = Channels { time: time.clone(), q, qd, qdd, tau };
        // All channels are filtered alike, so their shapes agree as those of the trajectory did.
        Trajectory::new(trajectory.name.as_str(), channels).unwrap_or_else(|_| trajectory.clone()).thinned(self.every)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Monitor;
    use crate::simulation::{Excitation, Scenario, simulate};

    fn log(rate: f64) -> Recording {
        lasting(rate, 4.0)
    }

    fn lasting(rate: f64, seconds: f64) -> Recording {
        let mut scenario = Scenario::embedded();
        if let Excitation::MultiSine { trajectories, duration, rate: at, .. } = &mut scenario.motion {
            (*trajectories, *duration, *at) = (2, seconds, rate);
        }
        simulate(&scenario, &Monitor::new()).unwrap()
    }

    #[test]
    fn a_slow_recording_with_measured_derivatives_is_itself() {
        let recording = log(100.0);
        let split = Split::automatic(&recording);
        assert!(matches!(Working::of(&recording, &split, None).recording, Cow::Borrowed(_)));
    }

    /// With accelerations that are to be derived anew, all of it to learn from; and with those that were simulated.
    fn derived_anew(rate: f64, seconds: f64) -> [Recording; 2] {
        let truth = lasting(rate, seconds);
        let mut derived = truth.clone();
        derived.provenance.acceleration = Origin::Derived("rough".to_owned());
        [derived, truth]
    }

    #[test]
    fn where_a_derivative_sees_one_side_only_nothing_is_learned() {
        let [derived, truth] = derived_anew(500.0, 4.0);
        let working = Working::of(&derived, &Split::whole(&derived), None);
        let (thin, full) = (&working.recording.trajectories[0], &truth.trajectories[0]);
        let every = full.len().div_ceil(thin.len());
        let worst = |samples: Range<usize>| {
            let off = |t: usize| (thin.qdd[1][t] - full.qdd[1][t * every]).abs();
            samples.map(off).fold(0.0, f64::max)
        };
        let inside = working.split.train[0].samples.clone();
        assert!(inside.start > 0 && inside.end < thin.len(), "{inside:?}");
        let [in_it, at_ends] = [worst(inside.clone()), worst(0..inside.start).max(worst(inside.end..thin.len()))];
        assert!(2.0 * in_it < at_ends, "{in_it} rad/s² inside, {at_ends} at the ends");
        let measured = Working::of(&truth, &Split::whole(&truth), None);
        assert_eq!(measured.split.train[0].samples, 0..measured.recording.trajectories[0].len());
    }

    #[test]
    fn a_short_run_keeps_its_ends() {
        let [derived, _] = derived_anew(500.0, 0.5);
        let working = Working::of(&derived, &Split::whole(&derived), None);
        assert_eq!(working.split.train[0].samples, 0..working.recording.trajectories[0].len());
    }

    /// Thinned out, it is the same motion: velocity and acceleration are derivatives of the position, and no later.
    #[test]
    fn a_fast_one_is_thinned_out_and_derived_anew() {
        let mut recording = log(1000.0);
        recording.provenance.acceleration = Origin::Derived("rough".to_owned());
        for trajectory in &mut recording.trajectories {
            trajectory.channels_mut().qdd.values_mut().fill(0.0);
        }
        let truth = log(1000.0);
        let split = Split::automatic(&recording);
        let working = Working::of(&recording, &split, None);
        let (thin, full) = (&working.recording.trajectories[0], &truth.trajectories[0]);
        let every = full.len().div_ceil(thin.len());
        assert!(every > 2, "{every}");
        assert!(working.split.train.iter().all(|segment| segment.samples.end <= thin.len()));
        let largest = full.qdd[1].iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        for t in thin.len() / 4..thin.len() * 3 / 4 {
            assert_eq!(thin.time[t], full.time[t * every]);
            let [is, was] = [thin.qdd[1][t], full.qdd[1][t * every]];
            assert!((is - was).abs() < 0.02 * largest, "{is} is not {was}");
        }
    }
}
