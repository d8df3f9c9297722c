//! A limit that the torque ran into before noise was added on its way to the log: its flat ends are not equal readings but noise about
//! one level.
//!
//! Over such a level the mean of a few readings stays within its own noise, again and again, while the joint moves on with changing
//! speed. A peak of a smooth torque has about half as much just below it as within its top; what ends at a limit has nearly nothing
//! below. On forty arms of `../shared/world` and sixty drawn worlds the largest ratio of a peak in motion was 3.6, the least of a
//! limit 8.4.

use std::ops::Range;

use rayon::prelude::*;

use super::super::segment::Segment;
use super::super::{Recording, Trajectory};
use crate::statistics::{ends, median, range, white_noise};

/// Over so long the mean of readings is taken \[s\].
const MEAN_OVER: f64 = 0.02;
/// Half the width of a level, in deviations of a mean.
const WIDTH: f64 = 3.0;
/// Down to here counts as just below the level, in deviations of a mean.
const BELOW: f64 = 9.0;
/// So many times as many means must lie at the level as just below.
const PILED_UP: f64 = 6.0;
/// Fewest means at a limit.
const FEWEST: usize = 20;
/// Times that the level is found anew from what lies at it.
const ROUNDS: usize = 6;
/// Least share of the range of positions, and of that of speeds, over which a joint stays at its limit at least once: what drives it
/// changes on the way, and a joint that rests or goes steadily has reason for a steady torque.
const CHANGES: f64 = 0.05;

/// Stretches of the readings of a joint's torque that lie at a limit; empty if there is none.
pub(super) fn find(recording: &Recording, joint: usize) -> Vec<Segment> {
    let runs = recording.trajectories.iter().map(|run| &run.tau[joint]);
    let Some(deviation) = white_noise(runs).filter(|deviation| *deviation > 0.0) else { return Vec::new() };
    let means: Vec<Means> = recording.trajectories.iter().map(|run| Means::of(run, joint)).collect();
    let at_end = |side| at_end(recording, joint, &means, side, deviation);
    let mut stretches: Vec<Segment> = [-1.0, 1.0].into_par_iter().flat_map_iter(at_end).collect();
    stretches.sort_by_key(|stretch| (stretch.trajectory, stretch.samples.start));
    stretches
}

/// The means of a run's torque over a few readings each.
struct Means {
    values: Vec<f64>,
    /// How many readings are in each.
    count: usize,
}

impl Means {
    fn of(run: &Trajectory, joint: usize) -> Means {
        let count = (MEAN_OVER / run.time_step().max(f64::MIN_POSITIVE)).round().clamp(1.0, run.len().max(1) as f64);
        let values = run.tau[joint].windows(count as usize).map(|few| few.iter().sum::<f64>() / count);
        Means { values: values.collect(), count: count as usize }
    }

    /// The readings whose means lie at the level.
    fn at(&self, is_at: impl Fn(f64) -> bool) -> Vec<Range<usize>> {
        let mut stretches: Vec<Range<usize>> = Vec::new();
        for (start, _) in self.values.iter().enumerate().filter(|(_, mean)| is_at(**mean)) {
            match stretches.last_mut() {
                Some(last) if start <= last.end => last.end = start + self.count,
                _ => stretches.push(start..start + self.count),
            }
        }
        stretches
    }
}

/// What lies at the limit at the upper end of the readings, or at the lower end with `side` -1.
fn at_end(recording: &Recording, joint: usize, means: &[Means], side: f64, deviation: f64) -> Vec<Segment> {
    let fewest = means.iter().map(|means| means.count).min().unwrap_or(1);
    let spread = deviation / (fewest as f64).sqrt();
    let all = || means.iter().flat_map(|means| means.values.iter().map(|mean| side * mean));
    let [_, top] = ends(all());
    let mut level = top - 2.0 * spread;
    for _ in 0..ROUNDS {
        level = median(all().filter(|mean| *mean > level - WIDTH * spread).collect()).unwrap_or(level);
    }
    let is_at = |mean: f64| (side * mean - level).abs() <= WIDTH * spread;
    let of_run = |(trajectory, means): (usize, &Means)| -> Vec<Segment> {
        means.at(is_at).into_iter().map(|samples| Segment { trajectory, samples }).collect()
    };
    let stretches: Vec<Segment> = means.iter().enumerate().flat_map(of_run).collect();
    let means_in = |stretch: &Segment| stretch.samples.len() + 1 - means[stretch.trajectory].count;
    let below = all().filter(|mean| (WIDTH * spread..BELOW * spread).contains(&(level - mean))).count();
    // A torque that rests at zero is at no limit.
    let is_piled_up = |at: usize| level.abs() > BELOW * spread && at >= FEWEST && at as f64 > PILED_UP * below as f64;
    if !is_piled_up(stretches.iter().map(means_in).sum()) {
        return Vec::new();
    }
    let runs = || recording.trajectories.iter();
    let ranges = [range(runs().flat_map(|run| &run.q[joint])), range(runs().flat_map(|run| &run.qd[joint]))];
    let changes = |stretch: &&Segment| {
        let run = &recording.trajectories[stretch.trajectory];
        let signals = [&run.q[joint], &run.qd[joint]];
        signals.iter().zip(ranges).all(|(signal, whole)| range(&signal[stretch.samples.clone()]) >= CHANGES * whole)
    };
    let in_motion = stretches.iter().filter(changes).map(means_in).sum();
    if is_piled_up(in_motion) { stretches } else { Vec::new() }
}
