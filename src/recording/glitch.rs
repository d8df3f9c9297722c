//! Readings that no motion makes: single samples far from all others, jumps by whole turns, sizes beyond belief, and derivatives that
//! were measured more seldom than they were written.
//!
//! Each rule asks for what clean logs do not have at all, however they are noisy, quantised, rare in motion or full of contacts:
//! the bounds stand many times beyond what such logs show.

use std::f64::consts::TAU;

use super::check::{Finding, FindingKind, Pick, Place, Severity};
use super::{JointKind, Origin, Recording, Trajectory};
use crate::statistics::median;

/// Larger than any reading in SI units, and than any count of an encoder.
const BEYOND_BELIEF: f64 = 1e9;
/// A sample that is so many times as far from the median as nearly all others are is not of the same making.
const FAR_OUT: f64 = 10.0;
/// Share of the samples that are nearly all.
const NEARLY_ALL: f64 = 0.995;
/// A glitch is no longer than this \[samples\]; what is longer may be a motion.
const LONGEST: usize = 3;
/// How far from a whole turn a jump may be \[rad\].
const TURN: f64 = 0.3;
/// Most samples over which a derivative is taken to be held.
const LONGEST_HOLD: usize = 50;
/// From so many changes on one sees when a channel changes.
const CHANGES: usize = 40;

/// A channel with its symbol.
type Channel = (&'static str, Pick);

/// What is found on one joint.
pub(super) fn find(recording: &Recording, joint: usize) -> Vec<Finding> {
    let measured = measured(recording);
    let beyond: Vec<Finding> =
        measured.iter().filter_map(|channel| beyond_belief(recording, joint, *channel)).collect();
    if !beyond.is_empty() {
        // Beside such values nothing else can be judged.
        return beyond;
    }
    let turns = turns(recording, joint);
    let is_wound = turns.is_some();
    // A turn is told once, and not as a sample far out too.
    let others = measured.iter().filter(|(symbol, _)| !(is_wound && *symbol == "q"));
    let mut findings: Vec<Finding> = others.filter_map(|channel| far_out(recording, joint, *channel)).collect();
    findings.extend(turns);
    let derivatives = measured.iter().filter(|(symbol, _)| ["q̇", "q̈"].contains(symbol));
    findings.extend(derivatives.filter_map(|channel| held(recording, joint, *channel)));
    findings
}

/// Channels that were not computed here: what a derivative makes of a glitch is told where the glitch is.
fn measured(recording: &Recording) -> Vec<Channel> {
    let mut channels: Vec<Channel> = vec![("q", |t| &t.q), ("τ", |t| &t.tau)];
    if recording.provenance.velocity == Origin::Measured {
        channels.push(("q̇", |t| &t.qd));
    }
    if recording.provenance.acceleration == Origin::Measured {
        channels.push(("q̈", |t| &t.qdd));
    }
    channels
}

/// All samples of a channel, each with its trajectory and its number there.
fn samples(recording: &Recording, joint: usize, pick: Pick) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
    recording.trajectories.iter().enumerate().flat_map(move |(index, trajectory)| {
        pick(trajectory)[joint].iter().enumerate().map(move |(sample, value)| (index, sample, *value))
    })
}

fn at(joint: usize, trajectory: usize, samples: std::ops::Range<usize>) -> Place {
    Place { trajectory: Some(trajectory), samples: Some(samples), ..Place::joint(joint) }
}

fn beyond_belief(recording: &Recording, joint: usize, (symbol, pick): Channel) -> Option<Finding> {
    let (trajectory, sample, value) =
        samples(recording, joint, pick).max_by(|one, other| one.2.abs().total_cmp(&other.2.abs()))?;
    (value.abs() > BEYOND_BELIEF).then(|| Finding {
        severity: Severity::Error,
        kind: FindingKind::BeyondBelief,
        what: format!(
            "{symbol} of {} is {value:.3e} at sample {sample}, as no robot's is.",
            recording.joints[joint].name
        ),
        place: at(joint, trajectory, sample..sample + 1),
        remedy: "Such a value marks a missing one, or is damage: write `nan` in its place, or leave its rows out."
            .to_owned(),
        set_right: Vec::new(),
    })
}

/// Stretches of a few samples that leap out of all others and back.
fn far_out(recording: &Recording, joint: usize, (symbol, pick): Channel) -> Option<Finding> {
    let values: Vec<f64> = samples(recording, joint, pick).map(|(_, _, value)| value).collect();
    let median = median(values.clone())?;
    let mut values: Vec<f64> = values.iter().map(|value| (value - median).abs()).collect();
    let nearly_all = ((values.len() as f64 * NEARLY_ALL) as usize).min(values.len() - 1);
    let spread = *values.select_nth_unstable_by(nearly_all, f64::total_cmp).1;
    // A channel that hardly ever changes has no usual size.
    if spread == 0.0 {
        return None;
    }
    let is_far = |value: f64| (value - median).abs() > FAR_OUT * spread;
    let (mut count, mut first, mut largest) = (0, None, 0.0f64);
    for (index, trajectory) in recording.trajectories.iter().enumerate() {
        let mut start = 0;
        for stretch in pick(trajectory)[joint].chunk_by(|one, other| is_far(*one) == is_far(*other)) {
            if is_far(stretch[0]) && stretch.len() <= LONGEST {
                count += stretch.len();
                first.get_or_insert((index, start));
                largest = stretch.iter().fold(largest, |far, value| far.max((value - median).abs()));
            }
            start += stretch.len();
        }
    }
    let (trajectory, sample) = first?;
    let samples = if count == 1 { "1 sample".to_owned() } else { format!("{count} samples") };
    Some(Finding {
        severity: Severity::Warning,
        kind: FindingKind::FarOut,
        what: format!(
            "{symbol} of {} leaps in {samples} {:.0} times as far as it else goes (first: sample {sample}).",
            recording.joints[joint].name,
            largest / spread
        ),
        place: at(joint, trajectory, sample..sample + 1),
        remedy: "One such sample can outweigh all others: write `nan` in its place, or leave its row out.".to_owned(),
        set_right: Vec::new(),
    })
}

/// Jumps by a whole turn between two samples, where the steps around are small.
fn turns(recording: &Recording, joint: usize) -> Option<Finding> {
    if recording.joints[joint].kind != JointKind::Revolute {
        return None;
    }
    let jumps = |trajectory: &Trajectory| {
        let q = &trajectory.q[joint];
        let step = |sample: usize| (q[sample + 1] - q[sample]).abs();
        let is_turn = |sample: &usize| {
            let around = [sample.checked_sub(1), Some(sample + 1).filter(|next| next + 1 < q.len())];
            let around = around.into_iter().flatten().map(step).fold(0.0, f64::max);
            (step(*sample) - TAU).abs() < TURN && around < TURN
        };
        (0..q.len().saturating_sub(1)).filter(is_turn).collect::<Vec<_>>()
    };
    let found: Vec<(usize, Vec<usize>)> = recording.trajectories.iter().map(jumps).enumerate().collect();
    let count: usize = found.iter().map(|(_, jumps)| jumps.len()).sum();
    let (trajectory, sample) = found.iter().find_map(|(index, jumps)| Some((*index, *jumps.first()?)))?;
    let times = if count == 1 { "once".to_owned() } else { format!("{count} times") };
    Some(Finding {
        severity: Severity::Error,
        kind: FindingKind::WholeTurn,
        what: format!(
            "q of {} jumps by a whole turn {times} (first: after sample {sample}).",
            recording.joints[joint].name
        ),
        place: at(joint, trajectory, sample..sample + 2),
        remedy: "The joint did not: the angle was wrapped. Unwrap it before (in Python `numpy.unwrap`), or its derivatives are \
                 wrong there."
            .to_owned(),
        set_right: Vec::new(),
    })
}

/// A derivative that changes at every n-th sample only, while q changes in between.
fn held(recording: &Recording, joint: usize, (symbol, pick): Channel) -> Option<Finding> {
    let trajectory = recording.trajectories.iter().max_by_key(|trajectory| trajectory.len())?;
    let hold = hold(&pick(trajectory)[joint])?;
    (self::hold(&trajectory.q[joint]).is_none_or(|own| own < hold)).then(|| Finding {
        severity: Severity::Warning,
        kind: FindingKind::Held,
        what: format!(
            "{symbol} of {} changes only at every {hold}th sample, while q changes in between.",
            recording.joints[joint].name
        ),
        place: Place::joint(joint),
        remedy: format!(
            "It was measured more seldom than it was written, and is late by half of that: derive it with `{}=-`.",
            if symbol == "q̇" { "qd" } else { "qdd" }
        ),
        set_right: Vec::new(),
    })
}

/// Over how many samples a signal is held: its changes all fall on every n-th sample, and on most of these it changes. A quantised
/// signal changes at any.
fn hold(values: &[f64]) -> Option<usize> {
    let changes: Vec<usize> =
        (1..values.len()).filter(|sample| values[*sample].to_bits() != values[sample - 1].to_bits()).collect();
    if changes.len() < CHANGES {
        return None;
    }
    let mut steps: Vec<usize> = changes.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = steps.len() / 2;
    let usual = *steps.select_nth_unstable(middle).1;
    let on_beat = changes.iter().filter(|sample| **sample % usual == changes[middle] % usual).count();
    let is_held = (2..=LONGEST_HOLD).contains(&usual) && on_beat * 100 > changes.len() * 95;
    is_held.then_some(usual)
}

#[cfg(test)]
mod tests {
    use super::super::Channels;
    use super::*;
    use crate::signals::Signals;

    /// One joint that swings, with noise.
    fn swinging() -> Recording {
        let time: Vec<f64> = (0..4800).map(|sample| sample as f64 * 0.002).collect();
        let noise = |sample: usize| ((sample as f64 * 12.9898).sin() * 43758.5453).fract();
        let signal = |f: &dyn Fn(f64) -> f64| {
            Signals::from_fn(1, time.len(), |_, sample| f(time[sample]) + 1e-3 * noise(sample))
        };
        let channels = Channels {
            q: signal(&|t| 2.0 * (3.0 * t).sin()),
            qd: signal(&|t| 6.0 * (3.0 * t).cos()),
            qdd: signal(&|t| -18.0 * (3.0 * t).sin()),
            tau: signal(&|t| 5.0 * (3.0 * t).sin() + (3.0 * t).cos().signum()),
            time: time.clone(),
        };
        Recording::of_runs(vec![Trajectory::new("swing", channels).unwrap()])
    }

    fn kinds(recording: &Recording) -> Vec<FindingKind> {
        find(recording, 0).into_iter().map(|finding| finding.kind).collect()
    }

    #[test]
    fn a_clean_log_has_none() {
        assert_eq!(kinds(&swinging()), []);
    }

    #[test]
    fn one_torque_far_out_is_found_where_it_is() {
        let mut recording = swinging();
        recording.trajectories[0].channels_mut().tau[0][1234] = 400.0;
        let found = find(&recording, 0);
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].kind, found[0].place.samples.clone()), (FindingKind::FarOut, Some(1234..1235)));
        assert!(found[0].what.contains("1 sample"), "{}", found[0].what);
        // Ten samples in a row may be a contact.
        recording.trajectories[0].channels_mut().tau[0][2000..2010].fill(400.0);
        let beside = find(&recording, 0);
        assert!(beside[0].place == found[0].place && beside[0].what.contains("1 sample"), "{}", beside[0].what);
    }

    #[test]
    fn a_wrapped_angle_is_found() {
        let mut recording = swinging();
        recording.trajectories[0].channels_mut().q[0].iter_mut().skip(3000).for_each(|q| *q += TAU);
        let found = find(&recording, 0);
        assert_eq!(kinds(&recording), [FindingKind::WholeTurn]);
        assert_eq!(found[0].place.samples, Some(2999..3001));
        recording.joints[0].kind = JointKind::Prismatic;
        assert_eq!(kinds(&recording), []);
    }

    #[test]
    fn sizes_beyond_belief_are_told_alone() {
        let mut recording = swinging();
        recording.trajectories[0].channels_mut().tau[0][7] = -1e301;
        assert_eq!(kinds(&recording), [FindingKind::BeyondBelief]);
    }

    #[test]
    fn a_derivative_that_was_measured_seldom_is_found() {
        let mut recording = swinging();
        let mut run = recording.trajectories[0].channels_mut();
        let qd = run.qd[0].to_vec();
        run.qd[0].iter_mut().enumerate().for_each(|(sample, value)| *value = qd[sample / 10 * 10]);
        let found = find(&recording, 0);
        assert_eq!(kinds(&recording), [FindingKind::Held]);
        assert!(found[0].what.contains("every 10th"), "{}", found[0].what);
        // Quantised velocity stands still too, but not in step.
        let mut coarse = swinging();
        coarse.trajectories[0].channels_mut().qd[0]
            .iter_mut()
            .for_each(|value| *value = (*value * 20.0).round() / 20.0);
        assert_eq!(kinds(&coarse), []);
    }
}
