//! Which samples of a joint count: those where it moves.
//!
//! Dry friction holds a joint that rests with any torque up to its own, most often that which it had on arriving. No column of the
//! present motion can say which, and what none can say draws false effects.

use std::collections::VecDeque;

use super::preparation::Preparation;
use crate::recording::{Recording, Trajectory};

/// Below this speed \[rad/s or m/s\] the sign of a measured velocity is noise.
const STANDSTILL: f64 = 0.01;
/// A joint rests, however noisy its velocity is, if within this time \[s\]
const WINDOW: f64 = 0.2;
/// it goes no further than this share of what it goes at its highest speed. A swing turns round in less, but for one below 0.03 Hz.
const STILL: f64 = 0.005;

/// Which samples count.
#[derive(Debug, Clone, Copy)]
pub enum Counting {
    /// Those where the joint moves.
    Moving,
    /// Those where it is not slower than this \[rad/s or m/s\].
    NotSlower(f64),
}

impl Counting {
    /// Whether each sample of a joint counts, whose highest speed is `top_speed`.
    pub fn of(self, trajectory: &Trajectory, joint: usize, top_speed: f64) -> Vec<bool> {
        let qd = &trajectory.qd[joint];
        let not_slower = |least: f64| qd.iter().map(move |qd| qd.abs() >= least);
        match self {
            Counting::NotSlower(least) => not_slower(least).collect(),
            Counting::Moving => {
                let rests = rests(&trajectory.q[joint], trajectory.time_step(), top_speed);
                not_slower(STANDSTILL).zip(rests).map(|(moves, rests)| moves && !rests).collect()
            }
        }
    }

    /// The same of prepared samples: by trajectory, joint and sample.
    pub fn of_prepared(self, recording: &Recording, preparations: &[Preparation]) -> Vec<Vec<Vec<bool>>> {
        let tops: Vec<f64> = (0..recording.joint_count()).map(|joint| recording.top_speed(joint)).collect();
        let of_trajectory = |(trajectory, preparation): (&Trajectory, &Preparation)| {
            let of_joint = |(joint, top): (usize, &f64)| preparation.thin_out(&self.of(trajectory, joint, *top));
            tops.iter().enumerate().map(of_joint).collect()
        };
        recording.trajectories.iter().zip(preparations).map(of_trajectory).collect()
    }
}

/// Zeros the samples that do not count: there they say nothing.
pub fn blank(values: &mut [f64], counts: &[bool]) {
    for (value, counts) in values.iter_mut().zip(counts) {
        if !counts {
            *value = 0.0;
        }
    }
}

fn rests(q: &[f64], time_step: f64, top_speed: f64) -> Vec<bool> {
    let mut rests = vec![false; q.len()];
    if time_step <= 0.0 {
        return rests;
    }
    let steps = ((WINDOW / time_step).round() as usize).clamp(1, q.len());
    // Of the window that ends at a sample: the samples that may yet be its least or its most, the least and the most first.
    let (mut least, mut most): (VecDeque<usize>, VecDeque<usize>) = Default::default();
    for (end, &now) in q.iter().enumerate() {
        let start = end.saturating_sub(steps);
        enter(&mut least, end, start, |other| q[other] < now);
        enter(&mut most, end, start, |other| q[other] > now);
        let is_whole = end >= steps;
        if is_whole && q[most[0]] - q[least[0]] < STILL * WINDOW * top_speed {
            let marked = if rests[end - 1] { end } else { start };
            rests[marked..=end].fill(true);
        }
    }
    rests
}

/// A sample enters a sliding window that begins at `start`. Those before it that do not `outdo` it leave: they never will be the first again.
fn enter(window: &mut VecDeque<usize>, sample: usize, start: usize, outdo: impl Fn(usize) -> bool) {
    while window.back().is_some_and(|&last| !outdo(last)) {
        window.pop_back();
    }
    window.push_back(sample);
    while window.front().is_some_and(|&first| first < start) {
        window.pop_front();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Channels;
    use crate::signals::Signals;

    /// As if each window were looked through.
    #[test]
    fn the_sliding_window_is_every_window() {
        let q: Vec<f64> =
            (0..500u32).map(|t| f64::from(t * t % 97).sin() * f64::from(t / 50 % 2) + 0.01 * f64::from(t)).collect();
        let mut shares = Vec::new();
        for top_speed in [30.0, 210.0, 1900.0, 3000.0] {
            let mut expected = vec![false; q.len()];
            for (start, window) in q.windows(21).enumerate() {
                let [least, most] = [f64::min, f64::max].map(|of| window.iter().copied().reduce(of).unwrap());
                if most - least < STILL * WINDOW * top_speed {
                    expected[start..start + 21].fill(true);
                }
            }
            assert_eq!(rests(&q, 0.01, top_speed), expected, "{top_speed}");
            shares.push(expected.iter().filter(|rests| **rests).count() as f64 / q.len() as f64);
        }
        assert!(shares[0] < 0.2 && shares[3] > 0.8 && shares.is_sorted(), "{shares:?}");
    }

    /// Strokes of a second and rests of a second, with the noise of an encoder of 14 bits.
    #[test]
    fn a_noisy_rest_does_not_count_and_a_reversal_does() {
        let time: Vec<f64> = (0..2000).map(|t| f64::from(t) * 0.005).collect();
        let rests = |t: f64| t % 2.0 >= 1.0;
        // It swings there and back within a stroke.
        let swing = |t: f64| if rests(t) { 0.0 } else { 0.5 - 0.5 * (std::f64::consts::TAU * (t % 2.0)).cos() };
        let noise = |sample: usize| 2e-4 * ((sample as f64 * 12.9898).sin() * 43758.5453).fract();
        let q: Vec<f64> = time.iter().enumerate().map(|(sample, &t)| swing(t) + noise(sample)).collect();
        let qd: Vec<f64> =
            (0..q.len()).map(|t| (q[(t + 1).min(q.len() - 1)] - q[t.saturating_sub(1)]) / 0.01).collect();
        let alone = |signal: Vec<f64>| Signals::from_joints([signal]).unwrap();
        let none = || Signals::zeros(1, time.len());
        let channels = Channels { q: alone(q), qd: alone(qd), qdd: none(), tau: none(), time: time.clone() };
        let run = Trajectory::new("strokes", channels).unwrap();
        let counts = Counting::Moving.of(&run, 0, std::f64::consts::PI);
        let share = |of: &dyn Fn(f64) -> bool| {
            let kept: Vec<bool> =
                time.iter().zip(&counts).filter(|(t, _)| of(**t)).map(|(_, counts)| *counts).collect();
            kept.iter().filter(|counts| **counts).count() as f64 / kept.len() as f64
        };
        assert_eq!(share(&|t| t % 2.0 > 1.1 && t % 2.0 < 1.9), 0.0);
        assert!(share(&|t| (0.1..0.9).contains(&(t % 2.0))) > 0.98, "but where the velocity is read as nearly nothing");
        assert!(share(&|t| (0.4..0.6).contains(&(t % 2.0))) > 0.9);
        let slow = Counting::NotSlower(0.0).of(&run, 0, std::f64::consts::PI);
        assert!(slow.iter().all(|counts| *counts));
    }
}
