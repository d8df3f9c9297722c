//! Torque readings that are none: a channel that stood still while its joint moved, or that was cut off at a limit.
//!
//! The readings show it by themselves, sample by sample. Such samples, and what a filter smears around them, belong to no
//! part of a [`super::split::Split`]: nothing is learned from them and no error is measured on them. But for the joints whose torque
//! is sound there: what is fitted joint by joint learns of them all the same.

mod noisy_limit;

use std::collections::BTreeMap;
use std::ops::Range;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::segment::{Segment, filter_memory};
use super::{Recording, Trajectory};
use crate::statistics::{ends, range};

/// What is wrong with the readings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FaultKind {
    /// The same value again and again while the joint moves; at zero the channel is dead.
    Stuck,
    /// Cut off at a limit.
    Saturated,
}

/// One kind of fault of one joint's torque channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// What is wrong.
    pub kind: FaultKind,
    /// The joint, from 0.
    pub joint: usize,
    /// Where, in the order of the trajectories.
    pub stretches: Vec<Segment>,
}

/// Fewest equal readings that are called stuck, in units of what is usual on the channel: values that are read again
/// before they are renewed, or coarse steps, repeat too.
const STUCK_RUN: usize = 8;
/// The share of all runs of equal readings that are usual.
const USUAL: f64 = 0.9;
/// So many of the smallest steps of the channel must it jump when it is loose again: a smooth torque that is read in coarse
/// steps stays on a step for long at its peaks, but goes on to the next one.
const JUMP: f64 = 3.0;
/// Least share of its range that a joint must move while its torque is stuck.
const MOVED: f64 = 0.002;
/// Fewest readings at a limit, and fewest of them in a row.
const AT_LIMIT: [usize; 2] = [20, 4];
/// So many times as many readings must lie at the limit as just below it: a natural peak has its readings below.
const PILED_UP: usize = 3;
/// How far below counts as just below, as a share of the range.
const JUST_BELOW: f64 = 0.01;
/// Time on either side of a fault \[s\] that is left out with it where nothing was derived.
const MARGIN: f64 = 0.1;

/// All faults of the torque channels. A channel that never changes at all is not among them: it has no good reading.
pub fn find(recording: &Recording) -> Vec<Fault> {
    (0..recording.joint_count()).into_par_iter().flat_map_iter(|joint| of_joint(recording, joint)).collect()
}

fn of_joint(recording: &Recording, joint: usize) -> Vec<Fault> {
    let runs = runs_of(recording, joint);
    let limits = limits(recording, joint, &runs);
    if limits.low == limits.high {
        return Vec::new();
    }
    let (saturated, others): (Vec<&Run>, Vec<&Run>) = runs.iter().partition(|run| limits.are_hit_by(run.value));
    let stuck = stuck(recording, joint, &others);
    let [stuck, mut saturated] =
        [stuck, saturated].map(|runs| runs.iter().map(|run| run.place.clone()).collect::<Vec<_>>());
    if saturated.is_empty() {
        saturated = noisy_limit::find(recording, joint);
    }
    let kinds = [(FaultKind::Stuck, stuck), (FaultKind::Saturated, saturated)].into_iter();
    kinds
        .filter(|(_, stretches)| !stretches.is_empty())
        .map(|(kind, stretches)| Fault { kind, joint, stretches })
        .collect()
}

impl Fault {
    /// How many readings are at fault.
    pub fn sample_count(&self) -> usize {
        self.stretches.iter().map(|stretch| stretch.samples.len()).sum()
    }

    /// The parameters of the effect that stands for it: how long the channel is stuck and how long it is from one time to
    /// the next \[s\], means of all; or the limit \[N m or N\].
    pub fn parameters(&self, recording: &Recording) -> Vec<f64> {
        match self.kind {
            FaultKind::Saturated => {
                let level = |stretch: &Segment| {
                    let readings = &recording.trajectories[stretch.trajectory].tau[self.joint][stretch.samples.clone()];
                    (readings.iter().sum::<f64>() / readings.len() as f64).abs()
                };
                vec![self.stretches.iter().map(level).fold(0.0, f64::max)]
            }
            FaultKind::Stuck => {
                let step = |trajectory: usize| recording.trajectories[trajectory].time_step();
                // The first of the equal readings was still a good one.
                let stuck = |stretch: &Segment| (stretch.samples.len() - 1) as f64 * step(stretch.trajectory);
                let length = |trajectory: &Trajectory| trajectory.len() as f64 * trajectory.time_step();
                let count = self.stretches.len() as f64;
                let total: f64 = recording.trajectories.iter().map(length).sum();
                vec![self.stretches.iter().map(stuck).sum::<f64>() / count, total / count]
            }
        }
    }
}

/// Parts of `segments` that keep clear of all these stretches.
pub fn without(recording: &Recording, stretches: &[Segment], segments: Vec<Segment>) -> Vec<Segment> {
    let mut bad: BTreeMap<usize, Vec<Range<usize>>> = BTreeMap::new();
    for stretch in stretches {
        let margin = margin(recording, stretch.trajectory);
        let widened = stretch.samples.start.saturating_sub(margin)..stretch.samples.end + margin;
        bad.entry(stretch.trajectory).or_default().push(widened);
    }
    bad.values_mut().for_each(|ranges| ranges.sort_by_key(|range| range.start));
    let mut clear = Vec::new();
    for segment in segments {
        let Some(ranges) = bad.get(&segment.trajectory) else {
            clear.push(segment);
            continue;
        };
        let least = margin(recording, segment.trajectory);
        let mut start = segment.samples.start;
        let ends = ranges.iter().map(|range| (range.start, range.end));
        for (end, next) in ends.chain([(segment.samples.end, segment.samples.end)]) {
            let end = end.min(segment.samples.end);
            // Scraps between two faults are not worth keeping.
            if end > start + least {
                clear.push(Segment { trajectory: segment.trajectory, samples: start..end });
            }
            start = start.max(next);
        }
    }
    clear
}

/// How many samples on either side of a fault a filter may have smeared.
fn margin(recording: &Recording, trajectory: usize) -> usize {
    let step = recording.trajectories[trajectory].time_step();
    let seconds = filter_memory(recording, trajectory).unwrap_or(MARGIN);
    if step > 0.0 { (seconds / step).round() as usize } else { 0 }
}

/// Equal readings in a row.
struct Run {
    place: Segment,
    value: f64,
}

/// All runs of a joint's torque; a reading unlike its neighbours is a run of one.
fn runs_of(recording: &Recording, joint: usize) -> Vec<Run> {
    let mut runs = Vec::new();
    for (index, trajectory) in recording.trajectories.iter().enumerate() {
        let tau = &trajectory.tau[joint];
        let mut start = 0;
        for end in 1..=tau.len() {
            if end == tau.len() || tau[end] != tau[start] {
                runs.push(Run { place: Segment { trajectory: index, samples: start..end }, value: tau[start] });
                start = end;
            }
        }
    }
    runs
}

/// The extreme readings of a channel, and whether it was cut off there.
struct Limits {
    low: f64,
    high: f64,
    cut_low: bool,
    cut_high: bool,
}

impl Limits {
    fn are_hit_by(&self, value: f64) -> bool {
        (self.cut_low && value == self.low) || (self.cut_high && value == self.high)
    }
}

fn limits(recording: &Recording, joint: usize, runs: &[Run]) -> Limits {
    let [low, high] = ends(runs.iter().map(|run| run.value));
    let readings = || recording.trajectories.iter().flat_map(|trajectory| &trajectory.tau[joint]);
    let is_cut = |limit: f64| {
        let lengths = || runs.iter().filter(|run| run.value == limit).map(|run| run.place.samples.len());
        let at: usize = lengths().sum();
        if at < AT_LIMIT[0] || lengths().max().unwrap_or(0) < AT_LIMIT[1] {
            return false;
        }
        let next = readings().map(|tau| (tau - limit).abs()).filter(|gap| *gap > 0.0).fold(f64::INFINITY, f64::min);
        let below = (JUST_BELOW * (high - low)).max(1.5 * next);
        let near = readings().filter(|tau| **tau != limit && (*tau - limit).abs() <= below).count();
        at > PILED_UP * near
    };
    // A dead channel that only ever reads zero or above rests at zero; that is no limit.
    let [cut_low, cut_high] = [low, high].map(|limit| limit != 0.0 && low < high && is_cut(limit));
    // A drive has one limit either way, and may reach it seldom on one side.
    let is_one = low == -high && (cut_low || cut_high);
    Limits { low, high, cut_low: cut_low || is_one, cut_high: cut_high || is_one }
}

/// The runs in which the joint moved on while its torque did not change.
fn stuck<'a>(recording: &Recording, joint: usize, runs: &[&'a Run]) -> Vec<&'a Run> {
    let mut lengths: Vec<usize> = runs.iter().map(|run| run.place.samples.len()).collect();
    if lengths.is_empty() {
        return Vec::new();
    }
    let place = (USUAL * (lengths.len() - 1) as f64) as usize;
    let usual = *lengths.select_nth_unstable(place).1;
    let jumps = |place: &Segment| {
        let tau = &recording.trajectories[place.trajectory].tau[joint];
        tau.get(place.samples.end).map(|next| (next - tau[place.samples.start]).abs())
    };
    let smallest = runs.iter().filter_map(|run| jumps(&run.place)).fold(f64::INFINITY, f64::min);
    let whole = range(recording.trajectories.iter().flat_map(|trajectory| &trajectory.q[joint]));
    let is_stuck = |run: &&&Run| {
        let Segment { trajectory, samples } = &run.place;
        samples.len() >= STUCK_RUN * usual
            && jumps(&run.place).is_none_or(|jump| jump > JUMP * smallest)
            && range(&recording.trajectories[*trajectory].q[joint][samples.clone()]) > MOVED * whole
    };
    runs.iter().filter(is_stuck).copied().collect()
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::recording::Channels;
    use crate::signals::Signals;

    /// One joint that swings for 20 s at 100 Hz; its torque is read in steps.
    fn swinging(step: f64) -> Recording {
        let time: Vec<f64> = (0..2000).map(|sample| 0.01 * f64::from(sample)).collect();
        let wave = |scale: f64, shift: f64| {
            let value = |t: f64| scale * ((1.3 * t + shift).sin() + 0.4 * (3.1 * t + shift).cos());
            Signals::from_fn(1, time.len(), |_, sample| value(time[sample]))
        };
        let tau = wave(8.0, 0.7).map(|tau| if step > 0.0 { (tau / step).round() * step } else { tau });
        let (q, qd, qdd) = (wave(1.0, 0.0), wave(1.0, 1.0), wave(1.0, 2.0));
        let trajectory = Trajectory::new("swing", Channels { time, q, qd, qdd, tau }).unwrap();
        Recording::of_runs(vec![trajectory])
    }

    fn stretches(faults: &[Fault]) -> Vec<(FaultKind, Range<usize>)> {
        faults.iter().flat_map(|f| f.stretches.iter().map(|s| (f.kind, s.samples.clone()))).collect()
    }

    #[test]
    fn good_readings_have_no_faults_be_they_fine_coarse_or_repeated() {
        for step in [0.0, 0.01, 0.1, 1.0] {
            assert_eq!(find(&swinging(step)), [], "steps of {step}");
        }
        let mut repeated = swinging(0.0);
        let mut run = repeated.trajectories[0].channels_mut();
        let tau = &mut run.tau[0];
        for sample in 0..tau.len() {
            tau[sample] = tau[sample / 10 * 10];
        }
        assert_eq!(find(&repeated), []);
    }

    #[test]
    fn a_joint_at_rest_may_repeat_its_torque() {
        let mut resting = swinging(0.0);
        let mut run = resting.trajectories[0].channels_mut();
        run.q[0][300..600].fill(0.4);
        run.tau[0][300..600].fill(1.5);
        assert_eq!(find(&resting), []);
    }

    #[test]
    fn stuck_and_dead_stretches_are_found() {
        let mut recording = swinging(0.01);
        let mut run = recording.trajectories[0].channels_mut();
        let tau = &mut run.tau[0];
        let held = tau[400];
        tau[400..440].fill(held);
        tau[1000..1100].fill(0.0);
        let found = find(&recording);
        assert_eq!(stretches(&found), [(FaultKind::Stuck, 400..440), (FaultKind::Stuck, 1000..1100)]);
        let [duration, period] = found[0].parameters(&recording)[..] else { panic!() };
        assert!((duration - 0.69).abs() < 1e-9 && (period - 10.0).abs() < 1e-9, "{duration}, {period}");
    }

    #[test]
    fn a_cut_off_torque_is_found_with_its_limit() {
        let mut recording = swinging(0.0);
        recording.trajectories[0].channels_mut().tau[0].iter_mut().for_each(|tau| *tau = tau.clamp(-9.0, 9.0));
        let found = find(&recording);
        assert!(matches!(&found[..], [fault] if fault.kind == FaultKind::Saturated), "{found:?}");
        assert_eq!(found[0].parameters(&recording), [9.0]);
        let at_limit = recording.trajectories[0].tau[0].iter().filter(|tau| tau.abs() == 9.0).count();
        assert_eq!(found[0].sample_count(), at_limit);
    }

    /// On one side the limit cuts off whole peaks, on the other fifteen readings of one peak.
    #[test]
    fn a_limit_that_one_side_hardly_reaches_is_the_same_limit() {
        let mut recording = swinging(0.0);
        let mut run = recording.trajectories[0].channels_mut();
        run.tau[0].iter_mut().for_each(|tau| *tau = (*tau + 1.0).clamp(-9.9, 9.9));
        assert_eq!(run.tau[0].iter().filter(|tau| **tau == -9.9).count(), 15);
        let at_limit = run.tau[0].iter().filter(|tau| tau.abs() == 9.9).count();
        let found = find(&recording);
        assert!(matches!(&found[..], [fault] if fault.kind == FaultKind::Saturated), "{found:?}");
        assert_eq!(found[0].sample_count(), at_limit);
    }

    /// Read in steps, the torque passes the value of its lower limit on the other side, too, and goes on.
    #[test]
    fn what_goes_beyond_is_at_no_limit() {
        let mut recording = swinging(0.5);
        recording.trajectories[0].channels_mut().tau[0].iter_mut().for_each(|tau| *tau = tau.max(-8.0));
        let tau = &recording.trajectories[0].tau[0];
        let at = |level: f64| tau.iter().filter(|tau| **tau == level).count();
        assert!(at(8.0) > 0 && tau.iter().any(|tau| *tau > 8.0));
        let found = find(&recording);
        assert!(matches!(&found[..], [fault] if fault.kind == FaultKind::Saturated), "{found:?}");
        assert_eq!(found[0].sample_count(), at(-8.0));
    }

    /// Noise as of an amplifier behind the limit, of up to one per cent of the range.
    #[test]
    fn a_limit_is_found_beneath_noise_and_none_where_there_is_none() {
        for deviation in [0.01, 0.05, 0.1] {
            let mut random = ChaCha8Rng::seed_from_u64(3);
            let mut noisy = |limit: f64| {
                let mut recording = swinging(0.0);
                recording.trajectories[0].channels_mut().tau[0].iter_mut().for_each(|tau| {
                    let noise: f64 = StandardNormal.sample(&mut random);
                    *tau = tau.clamp(-limit, limit) + deviation * noise;
                });
                recording
            };
            assert_eq!(find(&noisy(f64::INFINITY)), [], "noise of {deviation}");
            let found = find(&noisy(8.0));
            assert!(matches!(&found[..], [fault] if fault.kind == FaultKind::Saturated), "{deviation}: {found:?}");
            assert!((found[0].parameters(&noisy(8.0))[0] - 8.0).abs() < 3.0 * deviation);
        }
    }

    #[test]
    fn a_steady_torque_at_rest_or_at_a_steady_speed_is_no_limit() {
        let mut random = ChaCha8Rng::seed_from_u64(4);
        let mut steady = swinging(0.0);
        let mut run = steady.trajectories[0].channels_mut();
        run.tau[0].fill(0.0);
        for start in [200, 900, 1500] {
            run.tau[0][start..start + 200].fill(5.0);
            run.qd[0][start..start + 200].fill(0.7);
        }
        run.tau[0].iter_mut().for_each(|tau| *tau += 0.05 * Distribution::<f64>::sample(&StandardNormal, &mut random));
        assert_eq!(find(&steady), []);
    }

    #[test]
    fn what_is_left_keeps_clear_of_the_faults() {
        let recording = swinging(0.0);
        let stretch = |samples| Segment { trajectory: 0, samples };
        let faults = [stretch(100..120), stretch(145..150)];
        let clear = without(&recording, &faults, vec![stretch(0..1000), stretch(1000..2000)]);
        // Ten samples either side, and the scrap between the two is dropped.
        assert_eq!(clear, [stretch(0..90), stretch(160..1000), stretch(1000..2000)]);
    }
}
