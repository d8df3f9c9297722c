//! What the search looks at of a long recording: the beginnings of its runs, together long enough for any effect that is worth a name.
//!
//! Time and memory grow with the samples. What the search has to tell apart does not: beside a hundred thousand samples an effect of the
//! smallest share that is named has a t of hundreds. What was found is measured on the whole held-out part all the same. Runs are cut
//! from their starts, since what drifts or warms up is counted from there.

use std::borrow::Cow;

use crate::model::preparation::Preparation;
use crate::recording::Recording;
use crate::recording::split::{Segment, Split};

/// Most samples of a joint that are searched, as they are left when the torque was filtered and thinned out.
const MOST_SAMPLES: usize = 100_000;
/// Runs are left out before more than this many are shortened: blocks for validation are made of them.
const ENOUGH_RUNS: usize = 32;
/// How far a run goes on beyond its last sample that counts \[s\], so that filters have come to rest there.
const BEYOND: f64 = 1.0;

/// A part of a recording that stands for all of it in the search.
pub struct Excerpt<'a> {
    /// Its trajectories.
    pub recording: Cow<'a, Recording>,
    /// Its training part.
    pub split: Cow<'a, Split>,
    /// How much of the training part that is.
    pub share: f64,
}

impl<'a> Excerpt<'a> {
    /// The recording itself, unless it is very long.
    pub fn of(recording: &'a Recording, split: &'a Split) -> Self {
        Excerpt::of_at_most(MOST_SAMPLES, recording, split)
    }

    fn of_at_most(most: usize, recording: &'a Recording, split: &'a Split) -> Self {
        let whole = Excerpt { recording: Cow::Borrowed(recording), split: Cow::Borrowed(split), share: 1.0 };
        let all = length(&split.train);
        if all <= most {
            return whole;
        }
        let every = |trajectory: usize| Preparation::of(recording, trajectory).every;
        let every: Vec<usize> = (0..recording.trajectories.len()).map(every).collect();
        let left: usize = split.train.iter().map(|stretch| stretch.samples.len() / every[stretch.trajectory]).sum();
        if left <= most {
            return whole;
        }
        let mut runs: Vec<usize> = split.train.iter().map(|stretch| stretch.trajectory).collect();
        runs.dedup();
        let share = most as f64 / left as f64;
        let count = ((share * runs.len() as f64).ceil() as usize).max(ENOUGH_RUNS.min(runs.len()));
        let of_each = share * runs.len() as f64 / count as f64;
        let (mut trajectories, mut train) = (Vec::new(), Vec::new());
        for number in 0..count {
            let run = runs[number * runs.len() / count];
            let own: Vec<&Segment> = split.train.iter().filter(|stretch| stretch.trajectory == run).collect();
            let mut wanted = (of_each * own.iter().map(|stretch| stretch.samples.len()).sum::<usize>() as f64) as usize;
            let mut end = 0;
            for Segment { samples, .. } in own {
                let samples = samples.start..samples.end.min(samples.start + wanted);
                if !samples.is_empty() {
                    (wanted, end) = (wanted - samples.len(), samples.end);
                    train.push(Segment { trajectory: trajectories.len(), samples });
                }
            }
            let run = &recording.trajectories[run];
            let beyond = (BEYOND / run.time_step()).ceil() as usize;
            trajectories.push(run.slice(0..(end + beyond).min(run.len())));
        }
        let share = length(&train) as f64 / all as f64;
        Excerpt {
            recording: Cow::Owned(recording.with_trajectories(trajectories)),
            split: Cow::Owned(Split { train, ..Split::default() }),
            share,
        }
    }
}

/// How many samples these stretches have.
fn length(stretches: &[Segment]) -> usize {
    stretches.iter().map(|stretch| stretch.samples.len()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Monitor;
    use crate::simulation::{Excitation, Scenario, simulate};

    fn recording(trajectories: usize) -> Recording {
        let mut scenario = Scenario::embedded();
        if let Excitation::MultiSine { trajectories: count, duration, rate, .. } = &mut scenario.motion {
            (*count, *duration, *rate) = (trajectories, 12.0, 100.0);
        }
        simulate(&scenario, &Monitor::new()).unwrap()
    }

    #[test]
    fn what_is_short_is_looked_at_as_it_is() {
        let recording = recording(2);
        let split = Split::automatic(&recording);
        let excerpt = Excerpt::of(&recording, &split);
        assert!(matches!(excerpt.recording, Cow::Borrowed(_)) && excerpt.share == 1.0);
    }

    /// The held-out blocks within a run stay out.
    #[test]
    fn of_long_runs_the_beginnings_are_looked_at() {
        for runs in [1, 6] {
            let recording = recording(runs);
            let split = Split::automatic(&recording);
            let excerpt = Excerpt::of_at_most(length(&split.train) / 2, &recording, &split);
            assert!((excerpt.share - 0.5).abs() < 0.01, "{}", excerpt.share);
            for part in &excerpt.split.train {
                let run = &excerpt.recording.trajectories[part.trajectory];
                let whole = recording.trajectories.iter().find(|whole| whole.name == run.name).unwrap();
                assert!(run.len() < whole.len() && run.time[0] == whole.time[0]);
                assert_eq!(run.tau[1][part.samples.clone()], whole.tau[1][part.samples.clone()]);
                let is_training = |stretch: &&Segment| {
                    let run = &recording.trajectories[stretch.trajectory];
                    run.name == whole.name && part.samples.clone().all(|sample| stretch.samples.contains(&sample))
                };
                assert_eq!(split.train.iter().filter(is_training).count(), 1);
            }
        }
    }

    #[test]
    fn of_many_runs_some_are_looked_at_as_they_are() {
        let recording = recording(60);
        let split = Split::automatic(&recording);
        let excerpt = Excerpt::of_at_most(3 * length(&split.train) / 4, &recording, &split);
        assert!((excerpt.share - 0.75).abs() < 0.01 && excerpt.split.train.len() == 36, "{}", excerpt.share);
        assert!(excerpt.recording.trajectories.iter().all(|run| run.len() == recording.trajectories[0].len()));
    }
}
