//! What a signal's frequencies and its own past say: power spectrum, orders over position, autocorrelation.

use std::f64::consts::TAU;

use rustfft::algorithm::Radix4;
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftDirection};

use crate::statistics::ends;

/// Longest segment of the power spectrum \[samples\].
const LONGEST_SEGMENT: usize = 4096;
/// Shortest segment \[samples\].
const SHORTEST_SEGMENT: usize = 32;
/// How many segments there should be at least, so that their mean is steady.
const SEGMENTS: usize = 6;
/// Bins over the range of positions, so that places where the joint rests do not count more.
const BINS: usize = 1024;

/// One-sided power spectral density of evenly sampled pieces: frequency \[Hz\] and power \[unit² / Hz\].
///
/// Mean over half-overlapping segments with a Hann window, each without its mean (Welch, IEEE Trans. Audio 15 (1967) 70).
/// Empty where all pieces are too short.
pub fn power(pieces: &[&[f64]], step: f64) -> Vec<[f64; 2]> {
    let longest = pieces.iter().map(|piece| piece.len()).max().unwrap_or(0);
    let samples: usize = pieces.iter().map(|piece| piece.len()).sum();
    let wanted = (2 * samples / (SEGMENTS + 1)).clamp(SHORTEST_SEGMENT, LONGEST_SEGMENT).min(longest);
    if wanted < SHORTEST_SEGMENT || step <= 0.0 || !step.is_finite() {
        return Vec::new();
    }
    // The largest power of two that fits.
    let length = 1 << wanted.ilog2();
    let window: Vec<f64> = (0..length).map(|n| 0.5 - 0.5 * (TAU * n as f64 / length as f64).cos()).collect();
    let energy: f64 = window.iter().map(|weight| weight * weight).sum();
    let transform = Radix4::new(length, FftDirection::Forward);
    let mut spectrum = vec![Complex::default(); length];
    // The upper half of a real signal's spectrum mirrors the lower one.
    let mut sums = vec![0.0; length / 2 + 1];
    let mut count = 0.0;
    for piece in pieces {
        for start in (0..=piece.len().saturating_sub(length)).step_by(length / 2) {
            let Some(segment) = piece.get(start..start + length) else { continue };
            let mean = segment.iter().sum::<f64>() / length as f64;
            if !mean.is_finite() {
                continue;
            }
            for ((bin, value), weight) in spectrum.iter_mut().zip(segment).zip(&window) {
                *bin = Complex::new((value - mean) * weight, 0.0);
            }
            transform.process(&mut spectrum);
            for (sum, value) in sums.iter_mut().zip(&spectrum) {
                *sum += value.norm_sqr();
            }
            count += 1.0;
        }
    }
    let scale = 2.0 * step / (energy * f64::max(count, 1.0));
    let frequency = |n: usize| n as f64 / (length as f64 * step);
    if count == 0.0 { Vec::new() } else { (1..sums.len()).map(|n| [frequency(n), scale * sums[n]]).collect() }
}

/// Amplitude of the parts of a value that repeat 1, 2, … `most` times in a turn of 2π: order and amplitude.
///
/// Orders that the range of positions does not hold once are left out.
pub fn orders(position: &[f64], value: &[f64], most: usize) -> Vec<[f64; 2]> {
    let [low, high] = ends(position.iter().copied());
    if high - low < 1e-9 || !(high - low).is_finite() {
        return Vec::new();
    }
    let width = (high - low) / BINS as f64;
    let mut bins = vec![[0.0, 0.0]; BINS];
    for (q, value) in position.iter().zip(value) {
        let [count, sum] = &mut bins[(((q - low) / width) as usize).min(BINS - 1)];
        (*count, *sum) = (*count + 1.0, *sum + value);
    }
    let means: Vec<(f64, f64)> = (0..BINS)
        .filter(|bin| bins[*bin][0] > 0.0)
        .map(|bin| (low + (bin as f64 + 0.5) * width, bins[bin][1] / bins[bin][0]))
        .collect();
    let mean = means.iter().map(|(_, value)| value).sum::<f64>() / means.len().max(1) as f64;
    let amplitude = |order: usize| {
        let (mut cos, mut sin) = (0.0, 0.0);
        for (q, value) in &means {
            let angle = order as f64 * q;
            cos += (value - mean) * angle.cos();
            sin += (value - mean) * angle.sin();
        }
        2.0 / means.len() as f64 * cos.hypot(sin)
    };
    let first = (TAU / (high - low)).ceil().max(1.0) as usize;
    (first..=most).map(|order| [order as f64, amplitude(order)]).collect()
}

/// Correlation of a signal with itself `lag` samples later, for the lags 0, `every`, 2 `every`, …: 1 at lag 0.
///
/// Lags longer than every piece give NaN.
pub fn autocorrelation(pieces: &[&[f64]], lags: impl Iterator<Item = usize>) -> Vec<f64> {
    let samples: usize = pieces.iter().map(|piece| piece.len()).sum();
    let mean = pieces.iter().flat_map(|piece| piece.iter()).sum::<f64>() / samples.max(1) as f64;
    let at = |lag: usize| {
        let (mut sum, mut count) = (0.0, 0.0);
        for piece in pieces.iter().filter(|piece| piece.len() > lag) {
            for (one, other) in piece.iter().zip(&piece[lag..]) {
                sum += (one - mean) * (other - mean);
            }
            count += (piece.len() - lag) as f64;
        }
        sum / count
    };
    let whole = at(0);
    lags.map(|lag| at(lag) / whole).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sine of amplitude a holds the power a²/2, at its own frequency.
    #[test]
    fn the_power_of_a_sine_is_where_it_belongs() {
        let signal: Vec<f64> = (0..20_000).map(|n| 3.0 * (TAU * 12.5 * n as f64 * 1e-3).sin() + 5.0).collect();
        let spectrum = power(&[&signal], 1e-3);
        let peak = spectrum.iter().max_by(|one, other| one[1].total_cmp(&other[1])).unwrap();
        assert!((peak[0] - 12.5).abs() < 0.3, "{peak:?}");
        let width = spectrum[1][0] - spectrum[0][0];
        let total: f64 = spectrum.iter().map(|[_, power]| power * width).sum();
        assert!((total - 4.5).abs() < 0.05, "{total}");
        assert!(power(&[&signal[..10]], 1e-3).is_empty());
    }

    #[test]
    fn a_ripple_shows_at_its_order() {
        let position: Vec<f64> = (0..30_000).map(|n| 4.0 * (n as f64 * 1e-3).sin()).collect();
        let ripple: Vec<f64> = position.iter().map(|q| 0.7 * (14.0 * q + 0.3).cos() + 2.0).collect();
        let orders = orders(&position, &ripple, 40);
        let peak = orders.iter().max_by(|one, other| one[1].total_cmp(&other[1])).unwrap();
        assert_eq!(peak[0], 14.0);
        assert!((peak[1] - 0.7).abs() < 0.05, "{peak:?}");
    }

    #[test]
    fn a_period_correlates_with_itself_and_an_alternation_does_not() {
        let signal: Vec<f64> = (0..1000).map(|n| if n % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let correlation = autocorrelation(&[&signal[..500], &signal[500..]], [0, 1, 2, 600].into_iter());
        assert!((correlation[0] - 1.0).abs() < 1e-12 && (correlation[1] + 1.0).abs() < 1e-2);
        assert!((correlation[2] - 1.0).abs() < 1e-2 && correlation[3].is_nan());
    }
}
