//! Readings of a signal and of its derivative that no motion has together.
//!
//! Between two samples a signal rises, on average, as steeply as its derivative says somewhere between them (the mean value theorem),
//! also where a joint runs into something. So each measured derivative lies among the slopes around it, and each slope among the
//! derivatives around it, but for noise and delay, which are there everywhere. What lies far outside in a few places only was
//! damaged there (a file that lost bytes, a line that was disturbed), repeated by a logger that had no newer reading, or read late.

use super::{at, stretches_where, usual};
use crate::recording::Pick;
use crate::recording::finding::{Finding, FindingKind, Severity};
use crate::recording::segment::Segment;
use crate::recording::{Origin, Recording, Trajectory};
use crate::statistics::{above, ends};

/// A derivative may be late or early by so much \[s\], as filters make it,
const AROUND: f64 = 0.02;
/// and by so many samples at least.
const LEAST_AROUND: usize = 2;
/// A contradiction is so many times as large as what most samples differ by
const TIMES: f64 = 3.0;
/// more than this share of what nearly all derivatives reach. With these bounds `torquescope selftest logs faults --long` reads 45 of
/// 4,500 damaged logs in silence, 107 without them, and raises no alarm at 300 clean ones.
const LEAST: f64 = 0.1;
/// The share of all samples that is most of them.
const MOST: f64 = 0.9;
/// Fewer samples tell nothing; nor does one of so many derivatives on either side.
const FEWEST: usize = 40;
/// Where a step of time is so many times the usual one, nobody knows what the derivative was meanwhile.
const GAP: f64 = 1.5;

/// Where a derivative and its signal contradict each other.
pub(super) struct Contradiction {
    /// Symbols of the signal and the derivative.
    symbols: [&'static str; 2],
    /// Where; never empty.
    pub places: Vec<Segment>,
}

/// All contradictions of one joint.
pub(super) fn find(recording: &Recording, joint: usize) -> Vec<Contradiction> {
    let is_measured = |origin: &Origin| *origin == Origin::Measured;
    let velocity = is_measured(&recording.provenance.velocity);
    let acceleration = velocity && is_measured(&recording.provenance.acceleration);
    let pairs: [(bool, [&'static str; 2], Pick, Pick); 2] = [
        (velocity, ["q", "q̇"], |run| &run.q, |run| &run.qd),
        (acceleration, ["q̇", "q̈"], |run| &run.qd, |run| &run.qdd),
    ];
    let told =
        pairs.into_iter().filter(|(is_measured, ..)| *is_measured).filter_map(|(_, symbols, signal, derivative)| {
            let places = places(recording, joint, signal, derivative);
            (!places.is_empty()).then_some(Contradiction { symbols, places })
        });
    told.collect()
}

impl Contradiction {
    /// What is to be said of it.
    pub fn finding(&self, recording: &Recording, joint: usize) -> Finding {
        let [signal, derivative] = self.symbols;
        let count: usize = self.places.iter().map(|place| place.samples.len()).sum();
        let first = &self.places[0];
        Finding {
            severity: Severity::Warning,
            kind: FindingKind::Contradiction,
            what: format!(
                "{signal} and {derivative} of {} contradict each other in {count} samples (first: sample {}): no motion has both.",
                recording.joints[joint].name, first.samples.start
            ),
            place: at(joint, first),
            remedy: "One of the two is damaged there, repeated, or read at another moment than its time says: these samples and \
                     some around them train nothing and count in no error. Copy the file again, or check the sensor and its clock."
                .to_owned(),
            set_right: Vec::new(),
        }
    }
}

fn places(recording: &Recording, joint: usize, signal: Pick, derivative: Pick) -> Vec<Segment> {
    let Some((_, reach)) = usual(recording, joint, derivative).filter(|_| recording.sample_count() >= FEWEST) else {
        return Vec::new();
    };
    let runs = recording.trajectories.iter();
    let pairs: Vec<Pair> = runs.map(|run| Pair::of(run, &signal(run)[joint], &derivative(run)[joint])).collect();
    let [of_derivatives, of_slopes] = [Pair::derivative_differs, Pair::slope_differs].map(|differs| {
        let all = pairs.iter().flat_map(|pair| (0..pair.slopes.len()).map(|at| differs(pair, at)));
        LEAST * reach + TIMES * above(all.collect(), MOST).unwrap_or(0.0)
    });
    let of_run = |(trajectory, pair): (usize, &Pair)| {
        let mut is_odd = vec![false; pair.derivatives.len()];
        for at in 0..pair.slopes.len() {
            is_odd[at] |=
                pair.derivative_differs(at) > of_derivatives && pair.derivative_is_outside(at) > of_derivatives;
            if pair.slope_differs(at) > of_slopes && pair.slope_is_outside(at) > of_slopes {
                is_odd[at..at + 2].fill(true);
            }
        }
        let stretches = stretches_where(&is_odd, |is_odd| *is_odd);
        stretches.into_iter().map(|samples| Segment { trajectory, samples }).collect::<Vec<_>>()
    };
    pairs.iter().enumerate().flat_map(of_run).collect()
}

/// A derivative in one run beside the slopes of its signal.
struct Pair<'a> {
    derivatives: &'a [f64],
    /// From each sample to the next; NaN over a gap.
    slopes: Vec<f64>,
    /// So many samples on either side are around.
    around: usize,
}

impl<'a> Pair<'a> {
    fn of(run: &Trajectory, signal: &[f64], derivatives: &'a [f64]) -> Pair<'a> {
        let usual = run.time_step();
        let slope = |at: usize| {
            let step = run.time[at] - run.time[at - 1];
            if step > GAP * usual { f64::NAN } else { (signal[at] - signal[at - 1]) / step }
        };
        let slopes = (1..signal.len()).map(slope).collect();
        let around = ((AROUND / usual.max(f64::MIN_POSITIVE)) as usize).clamp(LEAST_AROUND, FEWEST);
        Pair { derivatives, slopes, around }
    }

    /// How far the derivative at a sample is from the nearer of the slopes on both of its sides.
    fn derivative_differs(&self, at: usize) -> f64 {
        distance(self.derivatives[at], &self.slopes[at.saturating_sub(1)..=at])
    }

    /// How far the slope behind a sample is from the nearer of the derivatives at both of its ends.
    fn slope_differs(&self, at: usize) -> f64 {
        distance(self.slopes[at], &self.derivatives[at..at + 2])
    }

    /// How far the derivative at a sample is from all that lies between the slopes around it.
    fn derivative_is_outside(&self, at: usize) -> f64 {
        let near = at.saturating_sub(self.around)..(at + self.around).min(self.slopes.len());
        outside(self.derivatives[at], &self.slopes[near])
    }

    /// How far the slope behind a sample is from all that lies between the derivatives around it.
    fn slope_is_outside(&self, at: usize) -> f64 {
        let near = (at + 1).saturating_sub(self.around)..(at + 1 + self.around).min(self.derivatives.len());
        outside(self.slopes[at], &self.derivatives[near])
    }
}

/// How far a value is from the nearest of the others; 0 if one of them is not known.
fn distance(value: f64, others: &[f64]) -> f64 {
    let nearest = others.iter().map(|other| (value - other).abs()).fold(f64::INFINITY, f64::min);
    if nearest.is_finite() { nearest } else { 0.0 }
}

/// How far a value is from all that lies between the others; 0 if none of them is known.
fn outside(value: f64, others: &[f64]) -> f64 {
    let [low, high] = ends(others.iter().copied());
    if low <= high { (low - value).max(value - high).max(0.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Channels;
    use crate::signals::Signals;

    /// One joint that swings and rests, runs into a stop, and is late by two samples in q̇; with noise on both.
    fn honest() -> Recording {
        let step = 0.005;
        let noise = |sample: usize, salt: f64| ((sample as f64 * salt).sin() * 43758.5453).fract() - 0.5;
        let angle = |t: f64| ((0.8 * t).sin().max(0.0) * ((2.0 * t).sin() + 0.4 * (5.0 * t).cos())).min(0.7);
        let time: Vec<f64> = (0..3000).map(|sample| step * sample as f64).collect();
        let speed = |t: f64| (angle(t + 1e-5) - angle(t - 1e-5)) / 2e-5;
        let q = Signals::from_fn(1, 3000, |_, sample| angle(time[sample]) + 1e-4 * noise(sample, 12.9898));
        let qd =
            Signals::from_fn(1, 3000, |_, sample| speed(time[sample.saturating_sub(2)]) + 0.02 * noise(sample, 78.233));
        let (qdd, tau) = (qd.map(|qd| 3.0 * qd), qd.map(|qd| 2.0 * qd));
        let run = Trajectory::new("swing", Channels { time, q, qd, qdd, tau }).unwrap();
        let mut recording = Recording::of_runs(vec![run]);
        recording.provenance.acceleration = Origin::Derived("in this test".to_owned());
        recording
    }

    #[test]
    fn noise_delay_rests_and_impacts_are_no_contradiction() {
        assert_eq!(places(&honest(), 0, |run| &run.q, |run| &run.qd), []);
    }

    #[test]
    fn what_was_damaged_is_found_on_either_channel() {
        for (damage, expected) in [
            ((|mut run| run.q[0][1000] += 0.05) as fn(crate::recording::ChannelsMut), 999..1002),
            (|mut run| run.qd[0][1000] += 1.5, 1000..1001),
            (|mut run| run.qd[0].copy_within(400..430, 1000), 1000..1030),
            (|mut run| run.q[0].copy_within(400..430, 1000), 1000..1030),
        ] {
            let mut recording = honest();
            damage(recording.trajectories[0].channels_mut());
            let found = find(&recording, 0);
            let places: Vec<usize> =
                found.iter().flat_map(|one| &one.places).flat_map(|place| place.samples.clone()).collect();
            assert!(!places.is_empty(), "{expected:?}");
            let near = expected.start - 3..expected.end + 3;
            assert!(places.iter().all(|sample| near.contains(sample)), "{expected:?}: {places:?}");
            assert!(found[0].finding(&recording, 0).what.starts_with("q and q̇"), "{expected:?}");
        }
    }

    #[test]
    fn a_derivative_of_another_unit_contradicts_everywhere_and_so_nowhere() {
        let mut recording = honest();
        recording.trajectories[0].channels_mut().qd[0].iter_mut().for_each(|qd| *qd *= 57.3);
        assert!(find(&recording, 0).is_empty());
    }
}
