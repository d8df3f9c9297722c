//! Derivatives that the file does not hold: central difference on the actual time stamps, then a zero-phase low-pass.
//!
//! The difference comes first because it is exact about uneven steps; what it returns is smooth over the sample number
//! even where the step changes, so the filter, which knows one step only, does no harm there.

use std::f64::consts::PI;
use std::ops::RangeInclusive;

/// Highest cut-off that is used when the user does not choose \[Hz\]. On a real double pendulum sampled at 500 Hz the
/// torque predicted for held-out time was best with q̈ cut at 8 to 10 Hz; 20 Hz was worse by a third.
pub const HIGHEST_DEFAULT_CUTOFF: f64 = 10.0;

/// The default cut-off for signals of this time step \[s\]: a fifth of the sampling rate, at most
/// [`HIGHEST_DEFAULT_CUTOFF`] \[Hz\].
pub fn default_cutoff(time_step: f64) -> f64 {
    (0.2 / time_step).min(HIGHEST_DEFAULT_CUTOFF)
}

/// How a channel was derived, in the words of [`super::Origin::Derived`]. `of` is what was differentiated; the cut-offs
/// \[Hz\] differ where the default was taken for trajectories of different sampling rates.
pub fn description(of: &str, cutoffs_hz: RangeInclusive<f64>) -> String {
    let (lowest, highest) = cutoffs_hz.into_inner();
    let tidy = |hertz: f64| (hertz * 1e3).round() / 1e3;
    let (lowest, highest) = (tidy(lowest), tidy(highest));
    let cutoff = if lowest == highest { lowest.to_string() } else { format!("{lowest} to {highest}") };
    format!(
        "central difference of {of}, then a 4th-order Butterworth low-pass run forward and backward (no delay), \
         cut-off {cutoff} Hz"
    )
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
/// halved. The ends are continued by point reflection, which keeps their value and slope.
///
/// `time_step` in s. The signal comes back unchanged where there is nothing to filter: fewer than two samples, or a
/// cut-off that is not between 0 and half the sampling rate. Samples must be finite: a NaN spreads to all others.
pub fn low_pass(signal: &[f64], time_step: f64, cutoff_hz: f64) -> Vec<f64> {
    let relative = cutoff_hz * time_step;
    if signal.len() < 2 || !(relative > 0.0 && relative < 0.5) {
        return signal.to_vec();
    }
    let sections = butterworth(relative);
    // After six periods of the cut-off the slowest pole has forgotten all but a millionth of the start.
    let margin = ((6.0 / relative).ceil() as usize).min(signal.len() - 1);
    let mut padded = continued(signal, margin);
    for _ in 0..2 {
        for section in sections {
            section.run(&mut padded);
        }
        padded.reverse();
    }
    padded[margin..margin + signal.len()].to_vec()
}

/// `signal` with `margin` samples more at each end, reflected through its end points.
fn continued(signal: &[f64], margin: usize) -> Vec<f64> {
    let (first, last) = (signal[0], signal[signal.len() - 1]);
    let head = signal[1..=margin].iter().rev().map(|value| 2.0 * first - value);
    let tail = signal.iter().rev().skip(1).take(margin).map(|value| 2.0 * last - value);
    head.chain(signal.iter().copied()).chain(tail).collect()
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

impl Section {
    /// Filters in place, starting as if the first value had been there for ever.
    fn run(&self, signal: &mut [f64]) {
        let Section { b, a } = self;
        let start = signal[0];
        let mut second = (b[2] - a[1]) * start;
        let mut first = (b[1] - a[0]) * start + second;
        for value in signal {
            let input = *value;
            let output = b[0] * input + first;
            first = b[1] * input - a[0] * output + second;
            second = b[2] * input - a[1] * output;
            *value = output;
        }
    }
}

/// Median time step \[s\]; 0 with fewer than two samples.
pub(super) fn median_step(time: &[f64]) -> f64 {
    let mut steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if steps.is_empty() {
        return 0.0;
    }
    let middle = steps.len() / 2;
    *steps.select_nth_unstable_by(middle, f64::total_cmp).1
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

    #[test]
    fn the_default_cut_off_follows_the_sampling_rate_up_to_a_bound() {
        assert_eq!(default_cutoff(0.04), 5.0);
        assert_eq!(default_cutoff(0.001), HIGHEST_DEFAULT_CUTOFF);
    }
}
