//! At which fast wave numbers the torque of a joint seems to repeat along its way.
//!
//! Magnets of a motor behind a gear repeat so often that no list of start values reaches them, and a search between two start values
//! finds nothing: a wave is seen only within a period or so over the joint's way of its own wave number. So what the rigid body and the
//! commonest friction leave is laid beside waves of every wave number (the periodogram of Lomb and Scargle over the position in place of
//! time), and those that stand out are tried as start values.
//!
//! Source: Scargle, The Astrophysical Journal 263 (1982) 835.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::design::Design;
use crate::effect::{MOST_PEAKS, Starts, Way};
use crate::signals::Signals;
use crate::statistics::median;

/// Wave numbers are so far apart, over the length of the way: a quarter of what tells two of them apart.
const STEP: f64 = 0.5 * PI;
/// The fastest wave repeats so often over the way.
const MOST_PERIODS: f64 = 100.0;
/// And turns at most this far between two samples, in the middle: positions come at uneven steps, so that faster waves are not mistaken for
/// slower ones at once, but of them the filter leaves little.
const MOST_PHASE: f64 = 2.0 * PI;
/// A wave stands out that explains so many times what the median one does. Of white noise the greatest of 400 does so in one of ten cases.
const STANDS_OUT: f64 = 12.0;

/// The way of each joint with the peaks of the periodogram of what is `left` of its prepared torque (by trajectory).
pub(super) fn with_peaks(design: &Design, left: &[Signals]) -> Vec<Way> {
    let way = |joint| Peaks::new(design, left, joint).way();
    (0..design.joint_count()).into_par_iter().map(way).collect()
}

struct Peaks<'a> {
    design: &'a Design<'a>,
    left: &'a [Signals],
    joint: usize,
    way: Way,
    /// Its prepared position, by trajectory.
    q: Vec<Vec<f64>>,
}

impl<'a> Peaks<'a> {
    fn new(design: &'a Design, left: &'a [Signals], joint: usize) -> Self {
        let runs = design.preparations().iter().zip(&design.recording().trajectories);
        let q = runs.map(|(preparation, run)| preparation.thin_out(&run.q[joint])).collect();
        Peaks { design, left, joint, way: design.way(Some(joint)), q }
    }

    fn way(&self) -> Way {
        let length = self.way.high - self.way.low;
        let samples = self.samples();
        let Some(first) = Starts::Waves.values(self.way).last().copied() else { return self.way };
        let step = STEP / length;
        let last = (MOST_PERIODS * 2.0 * PI / length).min(MOST_PHASE / self.middle_move());
        if samples.is_empty() || !(length > 0.0 && last > first + 2.0 * step) {
            return self.way;
        }
        let powers = powers(&samples, first, step, ((last - first) / step) as usize);
        Way { peaks: greatest(&powers).map(|place| if place > 0.0 { first + step * place } else { 0.0 }), ..self.way }
    }

    /// Position and what is left, where the sample counts.
    fn samples(&self) -> Vec<(f64, f64)> {
        let mut samples = Vec::new();
        for block in self.design.blocks() {
            let q = &self.q[block.trajectory];
            let left = &self.left[block.trajectory][self.joint];
            let range = block.samples.clone();
            // Samples that do not count are blank.
            samples.extend(range.filter(|&sample| left[sample] != 0.0).map(|sample| (q[sample], left[sample])));
        }
        samples
    }

    /// How far the joint moves from sample to sample, in the middle.
    fn middle_move(&self) -> f64 {
        let moves = self.q.iter().flat_map(|q| q.windows(2).map(|pair| (pair[1] - pair[0]).abs()));
        median(moves.filter(|far| *far > 0.0).collect()).unwrap_or(f64::INFINITY)
    }
}

/// What a wave explains of the samples' energy, for so many wave numbers.
fn powers(samples: &[(f64, f64)], first: f64, step: f64, count: usize) -> Vec<f64> {
    // The wave of the next wave number is this one turned by a step.
    let mut waves: Vec<(f64, f64)> = samples.iter().map(|(q, _)| (first * q).sin_cos()).collect();
    let turns: Vec<(f64, f64)> = samples.iter().map(|(q, _)| (step * q).sin_cos()).collect();
    let mut powers = Vec::with_capacity(count);
    for _ in 0..count {
        let [mut along_sin, mut along_cos, mut of_sin, mut of_cos, mut of_both] = [0.0; 5];
        for (((sin, cos), (turn_sin, turn_cos)), (_, left)) in waves.iter_mut().zip(&turns).zip(samples) {
            along_sin += *sin * left;
            along_cos += *cos * left;
            of_sin += *sin * *sin;
            of_cos += *cos * *cos;
            of_both += *sin * *cos;
            (*sin, *cos) = (*sin * turn_cos + *cos * turn_sin, *cos * turn_cos - *sin * turn_sin);
        }
        let determinant = of_sin * of_cos - of_both * of_both;
        let explained =
            of_cos * along_sin * along_sin - 2.0 * of_both * along_sin * along_cos + of_sin * along_cos * along_cos;
        powers.push(if determinant > 0.0 { explained / determinant } else { 0.0 });
    }
    powers
}

/// The places of the greatest peaks that stand out, ascending, between the steps; 0 for those that are not there.
fn greatest(powers: &[f64]) -> [f64; MOST_PEAKS] {
    let bar = STANDS_OUT * median(powers.to_vec()).unwrap_or(f64::INFINITY);
    let is_peak = |place: &usize| {
        let [before, here, after] = [powers[place - 1], powers[*place], powers[place + 1]];
        here > bar && here >= before && here > after
    };
    let mut peaks: Vec<usize> = (1..powers.len().saturating_sub(1)).filter(is_peak).collect();
    peaks.sort_by(|one, other| powers[*other].total_cmp(&powers[*one]));
    peaks.truncate(MOST_PEAKS);
    peaks.sort_unstable();
    let mut places = [0.0; MOST_PEAKS];
    for (place, peak) in places.iter_mut().zip(peaks) {
        // The top of the parabola through the peak and its neighbours.
        let [before, here, after] = [powers[peak - 1], powers[peak], powers[peak + 1]];
        *place = peak as f64 + 0.5 * (before - after) / (before - 2.0 * here + after).min(-f64::MIN_POSITIVE);
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fast_wave_in_noise_is_found_and_noise_alone_is_not() {
        let samples = |size: f64| -> Vec<(f64, f64)> {
            let mut state = 12345_u64;
            let mut noise = || {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                (state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
            };
            (0..4000)
                .map(|i| (f64::from(i) * 0.01).sin() * 1.3)
                .map(|q| (q, size * (77.3 * q + 0.4).cos() + noise()))
                .collect()
        };
        let step = STEP / 2.6;
        let found = |size| greatest(&powers(&samples(size), 20.0, step, 250)).map(|place| 20.0 + step * place);
        assert!(found(0.1).iter().any(|wave| (wave - 77.3).abs() < 0.3), "{:?}", found(0.1));
        assert_eq!(found(0.0), [20.0; MOST_PEAKS]);
    }
}
