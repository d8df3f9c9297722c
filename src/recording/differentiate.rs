//! Derivatives that the file does not hold: central difference on the actual time stamps, then a low-pass without delay, one of
//! Butterworth's run forward and backward or a Gaussian.
//!
//! The difference comes first because it is exact about uneven steps; what it returns is smooth over the sample number
//! even where the step changes, so the filter, which knows one step only, does no harm there.

use std::f64::consts::PI;
use std::ops::RangeInclusive;

use crate::signals::Signals;
use crate::statistics::median;
use nalgebra::{Matrix3, Vector3};

/// The ends of a signal are smoothed over this many periods of the cut-off before they are continued.
const END_WINDOW: f64 = 0.7;
/// The default cut-off is this many times the frequency of the motion, so that the third harmonic passes: dry friction has
/// one.
const HARMONICS: f64 = 4.0;
/// Lowest and highest default cut-off \[Hz\]. On a real double pendulum that swings at 0.7 to 1.5 Hz, sampled at 500 Hz, the
/// torque of a rigid body with friction was explained best with q̈ cut at 6 to 7 Hz.
const DEFAULT_CUTOFFS: [f64; 2] = [6.0, 20.0];
/// The default cut-off is at most this share of the sampling rate.
const HIGHEST_SHARE: f64 = 0.2;

/// The default cut-off \[Hz\] for signals of this motion: four times its frequency, which is the highest of
/// rms(q̇) / rms(q − mean q) / 2π of the joints, but at least 6 Hz, at most 20 Hz and a fifth of the sampling rate.
///
/// Noise of q̈ grows with frequency while the arm's own motion does not reach far: what is let through above it biases every
/// parameter that multiplies an acceleration.
pub fn default_cutoff(q: &Signals, qd: &Signals, time_step: f64) -> f64 {
    let power = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        values.iter().map(|value| (value - mean).powi(2)).sum::<f64>()
    };
    let frequency = |(q, qd): (&[f64], &[f64])| {
        let spread = power(q);
        if spread > 0.0 { (power(qd) / spread).sqrt() / (2.0 * PI) } else { 0.0 }
    };
    let highest = q.iter().zip(qd).map(frequency).filter(|value| value.is_finite()).fold(0.0, f64::max);
    let [low, high] = DEFAULT_CUTOFFS;
    (HARMONICS * highest).clamp(low, high).min(HIGHEST_SHARE / time_step)
}

/// [`default_cutoff`] where velocity was not measured: the frequency of the motion is then that of a rough derivative.
pub fn default_cutoff_of_positions(q: &Signals, time: &[f64]) -> f64 {
    let step = median_step(time);
    let rough = q.map_joints(|q| derivative(q, time, DEFAULT_CUTOFFS[1].min(HIGHEST_SHARE / step)));
    default_cutoff(q, &rough, step)
}

/// How a derivative is smoothed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Smoothing {
    /// [`low_pass`] with this cut-off \[Hz\].
    Butterworth(f64),
    /// [`gaussian`] of this width \[samples\].
    Gaussian(f64),
}

impl Smoothing {
    /// Where the amplitude is halved \[Hz\].
    pub fn cutoff_hz(self, time_step: f64) -> f64 {
        match self {
            Smoothing::Butterworth(cutoff_hz) => cutoff_hz,
            // e^(−(2π f σ)² / 2) = ½
            Smoothing::Gaussian(width) => (2.0 * 2.0_f64.ln()).sqrt() / (2.0 * PI * width * time_step),
        }
    }

    /// dx/dt of a sampled signal, smoothed. Times in s, strictly increasing.
    pub fn slope(self, signal: &[f64], time: &[f64]) -> Vec<f64> {
        match self {
            Smoothing::Butterworth(cutoff_hz) => derivative(signal, time, cutoff_hz),
            Smoothing::Gaussian(width) => gaussian(&central_difference(signal, time), width),
        }
    }
}

/// How a channel was derived by [`Smoothing::Gaussian`], as [`description`] says it.
pub fn gaussian_description(of: &str, width: f64) -> String {
    format!(
        "central difference of {of}, then a Gaussian filter of {width} samples (no delay); at the ends what sees one side only is \
         left out"
    )
}

/// How a channel was derived by [`Smoothing::Butterworth`], in the words of [`super::Origin::Derived`]. `of` is what was
/// differentiated; the cut-offs \[Hz\] differ where the default was taken for trajectories of different sampling rates.
pub fn description(of: &str, cutoffs_hz: RangeInclusive<f64>) -> String {
    let (lowest, highest) = cutoffs_hz.into_inner();
    let tidy = |hertz: f64| (hertz * 1e3).round() / 1e3;
    let (lowest, highest) = (tidy(lowest), tidy(highest));
    let cutoff = if lowest == highest { lowest.to_string() } else { format!("{lowest} to {highest}") };
    format!(
        "central difference of {of}, then a 4th-order Butterworth low-pass run forward and backward (no delay), \
         cut-off {cutoff} Hz; the first and last {END_WINDOW} periods of the cut-off, which see one side only, are left out"
    )
}

/// The samples of a derived signal that have seen both sides: all but `END_WINDOW` periods of the cut-off at each end.
/// Short signals, of which that would leave less than half, are kept whole.
pub fn trusted_range(samples: usize, time_step: f64, cutoff_hz: f64) -> std::ops::Range<usize> {
    let edge = (END_WINDOW / (cutoff_hz * time_step)).ceil() as usize;
    if edge.saturating_mul(4) > samples { 0..samples } else { edge..samples - edge }
}

/// dx/dt of a sampled signal: [`central_difference`], then [`low_pass`] at `cutoff_hz`. Times in s, strictly increasing.
pub fn derivative(signal: &[f64], time: &[f64], cutoff_hz: f64) -> Vec<f64> {
    low_pass(&central_difference(signal, time), median_step(time), cutoff_hz)
}

/// The slope at each sample of the parabola through it and its neighbours; at the ends of the parabola through the
/// outermost three. Exact for parabolas on any time steps. `time` \[s\] must strictly increase.
pub fn central_difference(signal: &[f64], time: &[f64]) -> Vec<f64> {
    let count = signal.len().min(time.len());
    if count < 3 {
        let slope = if count == 2 { (signal[1] - signal[0]) / (time[1] - time[0]) } else { 0.0 };
        return vec![slope; count];
    }
    (0..count)
        .map(|sample| {
            let middle = sample.clamp(1, count - 2);
            let (before, after) = (time[middle] - time[middle - 1], time[middle + 1] - time[middle]);
            let left = (signal[middle] - signal[middle - 1]) / before;
            let right = (signal[middle + 1] - signal[middle]) / after;
            let curvature = (right - left) / (before + after);
            let slope = (left * after + right * before) / (before + after);
            slope + 2.0 * curvature * (time[sample] - time[middle])
        })
        .collect()
}

/// Low-pass without delay: a 4th-order Butterworth filter run forward and backward, so the amplitude at `cutoff_hz` is
/// halved. The ends are continued by reflection through their smoothed values, which keeps value and slope.
///
/// `time_step` in s. The signal comes back unchanged where there is nothing to filter: fewer than two samples, or a
/// cut-off that is not between 0 and half the sampling rate. Samples must be finite: a NaN spreads to all others.
pub fn low_pass(signal: &[f64], time_step: f64, cutoff_hz: f64) -> Vec<f64> {
    low_pass_together(&[signal], time_step, cutoff_hz).pop().unwrap_or_default()
}

/// So many signals pass [`low_pass_together`] in hardly more time than one.
pub const TOGETHER: usize = 4;

/// [`low_pass`] of signals of one length. A filter waits for each output before it begins the next: meanwhile it works on others.
///
/// # Panics
/// If one signal is longer than another.
pub fn low_pass_together(signals: &[&[f64]], time_step: f64, cutoff_hz: f64) -> Vec<Vec<f64>> {
    let relative = cutoff_hz * time_step;
    let count = signals.first().map_or(0, |signal| signal.len());
    assert!(signals.iter().all(|signal| signal.len() == count), "signals of different lengths");
    if count < 2 || !(relative > 0.0 && relative < 0.5) {
        return signals.iter().map(|signal| signal.to_vec()).collect();
    }
    let passed = |group: &[&[f64]]| match group {
        [_] => passed::<1>(group, relative),
        _ => passed::<TOGETHER>(group, relative),
    };
    signals.chunks(TOGETHER).flat_map(passed).collect()
}

/// [`low_pass`] of each joint.
pub fn low_pass_joints(signals: &Signals, time_step: f64, cutoff_hz: f64) -> Signals {
    signals.map_together(|joints| low_pass_together(joints, time_step, cutoff_hz))
}

/// Up to `N` signals of one length through the filter.
fn passed<const N: usize>(signals: &[&[f64]], relative_cutoff: f64) -> Vec<Vec<f64>> {
    let sections = butterworth(relative_cutoff);
    let count = signals[0].len();
    // After six periods of the cut-off the slowest pole has forgotten all but a millionth of the start.
    let margin = ((6.0 / relative_cutoff).ceil() as usize).min(count - 1);
    let mut padded = vec![[0.0; N]; count + 2 * margin];
    for (lane, signal) in signals.iter().enumerate() {
        let continued = continued(signal, margin, relative_cutoff);
        padded.iter_mut().zip(continued).for_each(|(values, value)| values[lane] = value);
    }
    run(&sections, padded.iter_mut());
    run(&sections, padded.iter_mut().rev());
    let inner = &padded[margin..margin + count];
    (0..signals.len()).map(|lane| inner.iter().map(|values| values[lane]).collect()).collect()
}

/// Weighted mean over the neighbours, the weights a Gaussian of standard deviation `width` \[samples\] that ends at four of them; at
/// the ends the signal is mirrored. The same as `scipy.ndimage.gaussian_filter1d`, by which published models of dynamics derive q̈.
///
/// The signal comes back unchanged where `width` is not a number above 0. Samples must be finite.
pub fn gaussian(signal: &[f64], width: f64) -> Vec<f64> {
    const REACH: f64 = 4.0;
    if signal.is_empty() || !(width > 0.0 && width.is_finite()) {
        return signal.to_vec();
    }
    // Farther than the whole signal there is nothing new.
    let reach = ((REACH * width).round() as usize).min(signal.len());
    let weights: Vec<f64> = (0..=reach).map(|distance| (-0.5 * (distance as f64 / width).powi(2)).exp()).collect();
    let sum = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
    // … c b a | a b c …
    let last = signal.len() - 1;
    let before = |sample: usize, distance: usize| match sample.checked_sub(distance) {
        Some(before) => before,
        None => (distance - sample - 1).min(last),
    };
    let behind = |sample: usize, distance: usize| match sample + distance {
        behind if behind <= last => behind,
        beyond => (2 * last + 1).saturating_sub(beyond),
    };
    let mean = |sample: usize| {
        let pair = |(distance, weight): (usize, &f64)| {
            weight * (signal[before(sample, distance)] + signal[behind(sample, distance)])
        };
        (weights[0] * signal[sample] + weights.iter().enumerate().skip(1).map(pair).sum::<f64>()) / sum
    };
    (0..signal.len()).map(mean).collect()
}

/// `signal` with `margin` samples more at each end, reflected through its smoothed end points. The end samples themselves
/// would not do: the filter would pass their noise, because it is the same on both sides.
fn continued(signal: &[f64], margin: usize, relative_cutoff: f64) -> impl Iterator<Item = f64> {
    let window = ((END_WINDOW / relative_cutoff).ceil() as usize).min(signal.len());
    let first = end_value(signal[..window].iter());
    let last = end_value(signal[signal.len() - window..].iter().rev());
    reflected(signal, margin, [first, last])
}

/// `signal` with `margin` samples more at each end, fewer than it has, reflected through these values there.
pub(crate) fn reflected(signal: &[f64], margin: usize, [first, last]: [f64; 2]) -> impl Iterator<Item = f64> {
    let head = signal[1..=margin].iter().rev().map(move |value| 2.0 * first - value);
    let tail = signal.iter().rev().skip(1).take(margin).map(move |value| 2.0 * last - value);
    head.chain(signal.iter().copied()).chain(tail)
}

/// The value at the first of these samples of the parabola that fits them best; of fewer than four samples the first.
fn end_value<'a>(samples: impl ExactSizeIterator<Item = &'a f64> + Clone) -> f64 {
    let count = samples.len();
    if count < 4 {
        return samples.clone().next().copied().unwrap_or(0.0);
    }
    let mut gram = Matrix3::zeros();
    let mut moment = Vector3::zeros();
    for (index, value) in samples.clone().enumerate() {
        let place = index as f64 / (count - 1) as f64;
        let powers = Vector3::new(1.0, place, place * place);
        gram += powers * powers.transpose();
        moment += powers * *value;
    }
    gram.cholesky().map_or_else(|| samples.clone().next().copied().unwrap_or(0.0), |root| root.solve(&moment)[0])
}

/// One second-order section.
#[derive(Clone, Copy)]
struct Section {
    b: [f64; 3],
    a: [f64; 2],
}

/// The two sections of a 4th-order Butterworth low-pass; the cut-off is given in cycles per sample.
fn butterworth(relative_cutoff: f64) -> [Section; 2] {
    let k = (PI * relative_cutoff).tan();
    [PI / 8.0, 3.0 * PI / 8.0].map(|angle| {
        let damping = 2.0 * angle.cos() * k;
        let scale = 1.0 / (1.0 + damping + k * k);
        let b0 = k * k * scale;
        Section { b: [b0, 2.0 * b0, b0], a: [2.0 * (k * k - 1.0) * scale, (1.0 - damping + k * k) * scale] }
    })
}

/// Filters in place, starting as if the first values had been there for ever. All sections and signals go along together: while one
/// waits for its last output, the others work.
fn run<'a, const N: usize>(sections: &[Section; 2], signals: impl Iterator<Item = &'a mut [f64; N]>) {
    let mut signals = signals.peekable();
    let Some(start) = signals.peek().map(|values| **values) else { return };
    let mut states = sections.map(|Section { b, a }| {
        let second = start.map(|start| (b[2] - a[1]) * start);
        let first = std::array::from_fn(|lane| (b[1] - a[0]) * start[lane] + second[lane]);
        [first, second]
    });
    for values in signals {
        for (Section { b, a }, [first, second]) in sections.iter().zip(&mut states) {
            for lane in 0..N {
                let input = values[lane];
                let output = b[0] * input + first[lane];
                first[lane] = b[1] * input - a[0] * output + second[lane];
                second[lane] = b[2] * input - a[1] * output;
                values[lane] = output;
            }
        }
    }
}

/// Median time step \[s\]; 0 with fewer than two samples.
pub fn median_step(time: &[f64]) -> f64 {
    median(time.windows(2).map(|pair| pair[1] - pair[0]).collect()).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 0.002;

    fn sine(frequency: f64, time: &[f64]) -> Vec<f64> {
        time.iter().map(|t| (2.0 * PI * frequency * t).sin()).collect()
    }

    fn even(count: usize) -> Vec<f64> {
        (0..count).map(|sample| sample as f64 * STEP).collect()
    }

    /// Amplitude and phase \[rad\] of `signal` at a frequency, away from the ends.
    fn amplitude_and_phase(signal: &[f64], frequency: f64) -> (f64, f64) {
        let (mut sine, mut cosine) = (0.0, 0.0);
        let inner = 1000..2000; // whole periods of all frequencies used below
        for sample in inner.clone() {
            let angle = 2.0 * PI * frequency * sample as f64 * STEP;
            sine += signal[sample] * angle.sin();
            cosine += signal[sample] * angle.cos();
        }
        let scale = 2.0 / inner.len() as f64;
        ((sine.hypot(cosine)) * scale, cosine.atan2(sine))
    }

    #[test]
    fn passes_slow_sines_stops_fast_ones_and_delays_neither() {
        let time = even(3000);
        for (frequency, expected) in [(1.0, 1.0), (3.0, 1.0), (10.0, 0.5), (20.0, 1.0 / 257.0)] {
            let filtered = low_pass(&sine(frequency, &time), STEP, 10.0);
            let (amplitude, phase) = amplitude_and_phase(&filtered, frequency);
            assert!((amplitude - expected).abs() < 2e-3, "{frequency} Hz: {amplitude}");
            assert!(phase.abs() < 1e-6, "{frequency} Hz: {phase} rad");
        }
    }

    #[test]
    fn keeps_constants_and_ramps_to_the_very_ends() {
        for slope in [0.0, 3.0] {
            let ramp: Vec<f64> = even(400).iter().map(|t| 1.5 + slope * t).collect();
            for (raw, filtered) in ramp.iter().zip(low_pass(&ramp, STEP, 10.0)) {
                assert!((raw - filtered).abs() < 1e-6, "{raw} became {filtered}");
            }
        }
    }

    #[test]
    fn differentiates_parabolas_exactly_on_uneven_steps() {
        let time = [0.0, 0.1, 0.15, 0.4, 0.45, 0.9];
        let signal: Vec<f64> = time.iter().map(|t| 1.0 - 2.0 * t + 3.0 * t * t).collect();
        for (t, slope) in time.iter().zip(central_difference(&signal, &time)) {
            assert!((slope - (6.0 * t - 2.0)).abs() < 1e-12, "{slope} at {t}");
        }
    }

    #[test]
    fn the_derivative_of_a_sine_is_its_cosine_also_at_the_ends_and_on_a_jittering_clock() {
        for jitter in [0.0, 0.3] {
            let time: Vec<f64> =
                (0..3000).map(|sample| STEP * (sample as f64 + jitter * (sample as f64 * 1.7).sin())).collect();
            let derived = derivative(&sine(1.0, &time), &time, 10.0);
            for (sample, (t, slope)) in time.iter().zip(&derived).enumerate() {
                let truth = 2.0 * PI * (2.0 * PI * t).cos();
                let inside = (100..2900).contains(&sample);
                // What jitters faster than the cut-off is smoothed: at most the shift of a sample times the growth.
                let allowed = if inside { 0.01 + jitter * STEP * 40.0 } else { 0.2 };
                assert!((slope - truth).abs() < allowed, "jitter {jitter}, sample {sample}: {slope}, not {truth}");
            }
        }
    }

    #[test]
    fn nothing_to_filter_comes_back_unchanged() {
        assert!(low_pass(&[], STEP, 10.0).is_empty());
        assert_eq!(low_pass(&[7.0], STEP, 10.0), [7.0]);
        for cutoff in [0.0, -1.0, 250.0, 1e9, f64::NAN, f64::INFINITY] {
            assert_eq!(low_pass(&[1.0, 2.0, 4.0], STEP, cutoff), [1.0, 2.0, 4.0]);
        }
        assert_eq!(low_pass(&[1.0, 2.0], STEP, 1e-3).len(), 2);
        assert_eq!(central_difference(&[1.0], &[0.0]), [0.0]);
        assert_eq!(central_difference(&[1.0, 2.0], &[0.0, 0.5]), [2.0, 2.0]);
    }

    /// Values of SciPy 1.17, `gaussian_filter1d(x, 1.0)`.
    #[test]
    fn the_gaussian_is_that_of_scipy_and_halves_at_its_cut_off() {
        let expected = [
            0.8161838821349054,
            1.022546063170181,
            1.2650539347213945,
            0.8704221297683791,
            1.0552786887343086,
            2.891784258353488,
            5.078731043117344,
        ];
        for (ours, theirs) in gaussian(&[1.0, 0.0, 3.0, 0.0, 0.0, 2.0, 7.0], 1.0).iter().zip(expected) {
            assert!((ours - theirs).abs() < 1e-12, "{ours} is not {theirs}");
        }
        let time = even(3000);
        let cutoff = Smoothing::Gaussian(5.0).cutoff_hz(STEP);
        let (amplitude, phase) = amplitude_and_phase(&gaussian(&sine(cutoff, &time), 5.0), cutoff);
        assert!((amplitude - 0.5).abs() < 5e-3 && phase.abs() < 1e-3, "{amplitude}, {phase}");
        for width in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(gaussian(&[1.0, 2.0], width), [1.0, 2.0]);
        }
        assert!((gaussian(&[3.0], 50.0)[0] - 3.0).abs() < 1e-12);
        assert!(gaussian(&[1.0, 2.0], 1e9).iter().all(|value| (1.0..=2.0).contains(value)));
    }

    #[test]
    fn the_default_cut_off_follows_the_motion_within_bounds() {
        let swing = |hertz: f64, step: f64| {
            let phase = |sample: usize| 2.0 * PI * hertz * step * sample as f64;
            let q = Signals::from_fn(1, 2000, |_, sample| phase(sample).sin());
            let qd = Signals::from_fn(1, 2000, |_, sample| 2.0 * PI * hertz * phase(sample).cos());
            default_cutoff(&q, &qd, step)
        };
        assert!((swing(2.0, 0.001) - 8.0).abs() < 0.1);
        assert_eq!(swing(0.1, 0.01), 6.0);
        assert_eq!(swing(20.0, 0.001), 20.0);
        assert_eq!(swing(2.0, 0.04), 5.0);
        assert_eq!(default_cutoff(&Signals::from_fn(1, 10, |_, _| 1.0), &Signals::zeros(1, 10), 0.001), 6.0);
    }

    #[test]
    fn what_was_derived_says_how() {
        let said = description("q", 2.0..=2.0);
        assert!(said.starts_with("central difference of q,") && said.contains("cut-off 2 Hz"), "{said}");
        assert!(description("q", 2.0..=3.00004).contains("cut-off 2 to 3 Hz"));
        assert!(gaussian_description("qd", 4.0).contains("of qd, then a Gaussian filter of 4 samples"));
    }

    #[test]
    fn a_gaussian_says_its_width() {
        let text = gaussian_description("q", 2.5);
        assert!(text.starts_with("central difference of q, then a Gaussian filter of 2.5 samples"), "{text}");
    }
}
