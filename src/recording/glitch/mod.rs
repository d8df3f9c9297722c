//! Readings that no motion makes: single samples far from all others, jumps by whole turns, sizes beyond belief, and derivatives that
//! were measured more seldom than they were written.
//!
//! Each rule asks for what clean logs do not have at all, however they are noisy, quantised, rare in motion or full of contacts:
//! the bounds stand many times beyond what such logs show.

mod contradiction;

use std::f64::consts::TAU;
use std::ops::Range;

use rayon::prelude::*;

use contradiction::Contradiction;

use super::finding::{Finding, FindingKind, Place, Severity};
use super::segment::Segment;
use super::trajectory::Pick;
use super::{JointKind, Origin, Recording, Trajectory};
use crate::statistics::{above, median};

/// Larger than any reading in SI units, and than any count of an encoder.
const BEYOND_BELIEF: f64 = 1e9;
/// Smaller than any reading but none at all: bytes that were shifted or overwritten are such numbers,
const BELOW_BELIEF: f64 = 1e-40;
/// where they stand beside readings of at least this size,
const BELIEVED: f64 = 1e-12;
/// and beside none that is within this factor of them: what fades away in a filter's memory gets there step by step, and the arm may
/// start at once from there.
const STEP_OF_FADING: f64 = 1e6;
/// A sample that is so many times as far from the median as nearly all others are is not of the same making.
const FAR_OUT: f64 = 10.0;
/// Share of the samples that are nearly all.
const NEARLY_ALL: f64 = 0.995;
/// A glitch is no longer than this \[samples\]; what is longer may be a motion.
const LONGEST: usize = 3;
/// A sample leaps out of its neighbours if it does so further than this many times what any other near it does,
const LEAP: f64 = 8.0;
/// and further than this share of what nearly all samples of the channel go.
const LEAST_LEAP: f64 = 0.25;
/// It has come back if its neighbours differ by no more than this share of its leap: an impact dies away more slowly.
const COME_BACK: f64 = 0.25;
/// How many samples on either side are near.
const NEAR: usize = 12;
/// A channel of which more than this share leaps does so by nature.
const BY_NATURE: f64 = 0.002;
/// How far from a whole turn a jump may be \[rad\].
const TURN: f64 = 0.3;
/// Most samples over which a derivative is taken to be held.
const LONGEST_HOLD: usize = 50;
/// From so many changes on one sees when a channel changes.
const CHANGES: usize = 40;

/// A channel with its symbol.
type Channel = (&'static str, Pick);

/// What is found on one joint, and where no motion made its readings.
pub(super) fn find(recording: &Recording, joint: usize) -> (Vec<Finding>, Vec<Segment>) {
    let glitches = Glitches::of(recording, joint);
    let places = glitches.places();
    let Glitches { odd, turns, held, contradictions } = glitches;
    let beyond: Vec<Finding> = odd.iter().filter_map(|odd| odd.unbelievable(recording, joint)).collect();
    if !beyond.is_empty() {
        // Beside such values nothing else can be judged.
        return (beyond, places);
    }
    let is_wound = turns.is_some();
    // A turn is told once, and not as a sample far out too.
    let others = odd.iter().filter(|odd| !(is_wound && odd.channel.0 == "q"));
    let mut findings: Vec<Finding> = others.filter_map(|odd| odd.leap(recording, joint)).collect();
    findings.extend(turns);
    findings.extend(contradictions.iter().map(|contradiction| contradiction.finding(recording, joint)));
    findings.extend(held);
    (findings, places)
}

/// Where no motion made the readings of any channel: nothing is learned from them, since a single one can outweigh all others.
pub(super) fn places(recording: &Recording) -> Vec<Segment> {
    let joints = (0..recording.joint_count()).into_par_iter();
    joints.flat_map_iter(|joint| Glitches::of(recording, joint).places()).collect()
}

/// What no motion makes, on one joint.
struct Glitches {
    odd: Vec<Odd>,
    turns: Option<Finding>,
    held: Vec<Finding>,
    /// Between channels of which none is odd by itself.
    contradictions: Vec<Contradiction>,
}

impl Glitches {
    fn of(recording: &Recording, joint: usize) -> Glitches {
        let odd: Vec<Odd> = measured(recording).into_iter().map(|channel| Odd::of(recording, joint, channel)).collect();
        let turns = turns(recording, joint);
        let derivatives = odd.iter().map(|odd| odd.channel).filter(|(symbol, _)| ["q̇", "q̈"].contains(symbol));
        let held: Vec<Finding> = derivatives.filter_map(|channel| held(recording, joint, channel)).collect();
        let is_odd = |odd: &Odd| odd.channel.0 != "τ" && odd.places().next().is_some();
        let is_told = turns.is_some() || !held.is_empty() || odd.iter().any(is_odd);
        let contradictions = if is_told { Vec::new() } else { contradiction::find(recording, joint) };
        Glitches { odd, turns, held, contradictions }
    }

    fn places(&self) -> Vec<Segment> {
        let contradicted = self.contradictions.iter().flat_map(|contradiction| contradiction.places.iter().cloned());
        self.odd.iter().flat_map(Odd::places).chain(contradicted).collect()
    }
}

/// What is odd about the readings of one channel.
struct Odd {
    channel: Channel,
    /// Where they are beyond belief,
    beyond: Vec<Segment>,
    /// and, if they are nowhere, which leap away and back.
    single: Option<Single>,
}

impl Odd {
    fn of(recording: &Recording, joint: usize, channel: Channel) -> Odd {
        let beyond = beyond_belief(recording, joint, channel.1);
        let single = beyond.is_empty().then(|| single(recording, joint, channel.1)).flatten();
        Odd { channel, beyond, single }
    }

    fn places(&self) -> impl Iterator<Item = Segment> {
        self.single.as_ref().map_or(&self.beyond, |single| &single.places).iter().cloned()
    }

    fn unbelievable(&self, recording: &Recording, joint: usize) -> Option<Finding> {
        let (symbol, pick) = self.channel;
        let reading = |place: &Segment| pick(&recording.trajectories[place.trajectory])[joint][place.samples.start];
        let worst = self.beyond.iter().max_by(|one, other| reading(one).abs().total_cmp(&reading(other).abs()))?;
        Some(Finding {
            severity: Severity::Error,
            kind: FindingKind::BeyondBelief,
            what: format!(
                "{symbol} of {} is {:.3e} at sample {}, as no robot's is.",
                recording.joints[joint].name,
                reading(worst),
                worst.samples.start
            ),
            place: at(joint, worst),
            remedy: "Such a value marks a missing one, or is damage: write `nan` in its place, or leave its rows out."
                .to_owned(),
            set_right: Vec::new(),
        })
    }

    fn leap(&self, recording: &Recording, joint: usize) -> Option<Finding> {
        let Single { places, how } = self.single.as_ref()?;
        let symbol = self.channel.0;
        let count: usize = places.iter().map(|place| place.samples.len()).sum();
        let samples = if count == 1 { "1 sample".to_owned() } else { format!("{count} samples") };
        let first = Segment { samples: places[0].samples.start..places[0].samples.start + 1, ..places[0] };
        Some(Finding {
            severity: Severity::Warning,
            kind: FindingKind::FarOut,
            what: format!(
                "{symbol} of {} leaps in {samples} {how} (first: sample {}).",
                recording.joints[joint].name, first.samples.start
            ),
            place: at(joint, &first),
            remedy:
                "These samples and some around them train nothing and count in no error; check the sensor and its line."
                    .to_owned(),
            set_right: Vec::new(),
        })
    }
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

/// All values of a channel.
fn values(recording: &Recording, joint: usize, pick: Pick) -> impl Iterator<Item = f64> + '_ {
    recording.trajectories.iter().flat_map(move |trajectory| pick(trajectory)[joint].iter().copied())
}

fn at(joint: usize, place: &Segment) -> Place {
    Place { trajectory: Some(place.trajectory), samples: Some(place.samples.clone()), ..Place::joint(joint) }
}

/// Stretches of a channel, of one trajectory after the other.
fn stretches(
    recording: &Recording,
    joint: usize,
    pick: Pick,
    of_run: impl Fn(&[f64]) -> Vec<Range<usize>>,
) -> Vec<Segment> {
    let runs = recording.trajectories.iter().enumerate();
    let of_run = |(trajectory, run): (usize, &Trajectory)| {
        let found = of_run(&pick(run)[joint]).into_iter();
        found.map(|samples| Segment { trajectory, samples }).collect::<Vec<_>>()
    };
    runs.flat_map(of_run).collect()
}

/// Where a channel has values that no robot has, too large or too small.
fn beyond_belief(recording: &Recording, joint: usize, pick: Pick) -> Vec<Segment> {
    let is_below = |value: f64| value != 0.0 && value.abs() < BELOW_BELIEF;
    stretches(recording, joint, pick, |values| {
        let is_beside = |at: usize| {
            let around = [at.checked_sub(1), Some(at + 1)].into_iter().flatten().filter_map(|at| values.get(at));
            let fades = |other: &f64| {
                let ratio = (other / values[at]).abs();
                (STEP_OF_FADING.recip()..STEP_OF_FADING).contains(&ratio)
            };
            around.clone().any(|value| value.abs() > BELIEVED) && !around.copied().any(|other| fades(&other))
        };
        let is_beyond = |at: &usize| values[*at].abs() > BEYOND_BELIEF || is_below(values[*at]) && is_beside(*at);
        (0..values.len()).filter(is_beyond).map(|at| at..at + 1).collect()
    })
}

/// Single readings that leap away and back.
struct Single {
    places: Vec<Segment>,
    /// How they leap, in words that go on after how many there are.
    how: String,
}

fn single(recording: &Recording, joint: usize, pick: Pick) -> Option<Single> {
    let (median, spread) = usual(recording, joint, pick)?;
    let from = |value: f64| (value - median).abs();
    let far = stretches(recording, joint, pick, |values| far_out(values, |value| from(value) > FAR_OUT * spread));
    if !far.is_empty() {
        let readings =
            |place: &Segment| pick(&recording.trajectories[place.trajectory])[joint][place.samples.clone()].to_vec();
        let largest = far.iter().flat_map(readings).map(from).fold(0.0, f64::max);
        return Some(Single { places: far, how: format!("{:.0} times as far as it else goes", largest / spread) });
    }
    let near = stretches(recording, joint, pick, |values| leaps(values, spread).map(|at| at..at + 1).collect());
    let is_by_nature = near.len() as f64 > BY_NATURE * recording.sample_count() as f64 && near.len() > 1;
    (!near.is_empty() && !is_by_nature)
        .then(|| Single { places: near, how: "out of its neighbours and back".to_owned() })
}

/// The median of a channel, and how far nearly all of its samples are from it; `None` of a channel that hardly ever changes: it has no
/// usual size.
fn usual(recording: &Recording, joint: usize, pick: Pick) -> Option<(f64, f64)> {
    let values: Vec<f64> = values(recording, joint, pick).collect();
    let median = median(values.clone())?;
    let spread = above(values.iter().map(|value| (value - median).abs()).collect(), NEARLY_ALL)?;
    (spread > 0.0).then_some((median, spread))
}

/// Stretches of a few samples that leap out of all others and back.
fn far_out(values: &[f64], is_far: impl Fn(f64) -> bool) -> Vec<Range<usize>> {
    let mut stretches = stretches_where(values, |value| is_far(*value));
    stretches.retain(|stretch| stretch.len() <= LONGEST);
    stretches
}

/// Where something is so, one stretch after the other.
fn stretches_where<T>(values: &[T], is_so: impl Fn(&T) -> bool) -> Vec<Range<usize>> {
    let (mut found, mut start) = (Vec::new(), 0);
    for stretch in values.chunk_by(|one, other| is_so(one) == is_so(other)) {
        if is_so(&stretch[0]) {
            found.push(start..start + stretch.len());
        }
        start += stretch.len();
    }
    found
}

/// Where a signal leaps out of its neighbours and back, within what it else goes. What a sample is beside the middle of its two
/// neighbours is S at a leap and −S/2 before and after it; a step, as of dry friction, has two of opposite signs in turn.
fn leaps(values: &[f64], spread: f64) -> impl Iterator<Item = usize> {
    let beside = |at: usize| values[at] - 0.5 * (values[at - 1] + values[at + 1]);
    let inner = 1..values.len().saturating_sub(1);
    let bends: Vec<f64> = inner.map(beside).collect();
    let is_leap = move |at: usize| {
        let size = bends[at];
        if size.abs() <= LEAST_LEAP * spread {
            return false;
        }
        let is_answered = [bends[at - 1], bends[at + 1]].iter().all(|bend| (0.25..0.75).contains(&(-bend / size)));
        let has_come_back = (values[at + 2] - values[at]).abs() < COME_BACK * size.abs();
        let near = at.saturating_sub(NEAR)..(at + NEAR + 1).min(bends.len());
        let others = near.filter(|other| other.abs_diff(at) > 1).map(|other| bends[other].abs());
        is_answered && has_come_back && size.abs() > LEAP * others.fold(0.0, f64::max)
    };
    let count = values.len().saturating_sub(2);
    (1..count.saturating_sub(1)).filter(move |at| is_leap(*at)).map(|at| at + 1)
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
        place: at(joint, &Segment { trajectory, samples: sample..sample + 2 }),
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

    /// A stretch that is longer than a few samples is motion, not a leap.
    #[test]
    fn what_leaps_out_for_a_few_samples_is_found() {
        let values = [0.0, 9.0, 0.0, 9.0, 9.0, 9.0, 0.0, 9.0, 9.0, 9.0, 9.0];
        assert_eq!(far_out(&values, |value| value > 5.0), [1..2, 3..6]);
    }

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
        find(recording, 0).0.into_iter().map(|finding| finding.kind).collect()
    }

    #[test]
    fn a_clean_log_has_none() {
        assert_eq!(kinds(&swinging()), []);
    }

    #[test]
    fn one_torque_far_out_is_found_where_it_is() {
        let mut recording = swinging();
        recording.trajectories[0].channels_mut().tau[0][1234] = 400.0;
        let found = find(&recording, 0).0;
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].kind, found[0].place.samples.clone()), (FindingKind::FarOut, Some(1234..1235)));
        assert!(found[0].what.contains("1 sample"), "{}", found[0].what);
        // Ten samples in a row may be a contact.
        recording.trajectories[0].channels_mut().tau[0][2000..2010].fill(400.0);
        let beside = find(&recording, 0).0;
        assert!(beside[0].place == found[0].place && beside[0].what.contains("1 sample"), "{}", beside[0].what);
    }

    /// One reading in the place of another, as a flipped bit or a digit makes it, is no larger than others are.
    #[test]
    fn a_sample_that_leaps_out_of_its_neighbours_is_found() {
        for (sample, factor) in [(1234, 2.0), (700, 0.5), (2345, -1.0)] {
            let mut recording = swinging();
            recording.trajectories[0].channels_mut().tau[0][sample] *= factor;
            let found = find(&recording, 0).0;
            assert_eq!(kinds(&recording), [FindingKind::FarOut], "{factor}");
            assert_eq!(found[0].place.samples, Some(sample..sample + 1));
        }
        // Dry friction steps, and a contact bends; neither comes back at once.
        let mut recording = swinging();
        recording.trajectories[0].channels_mut().tau[0][2000..].iter_mut().for_each(|tau| *tau += 4.0);
        assert_eq!(kinds(&recording), []);
    }

    #[test]
    fn a_wrapped_angle_is_found() {
        let mut recording = swinging();
        recording.trajectories[0].channels_mut().q[0].iter_mut().skip(3000).for_each(|q| *q += TAU);
        let found = find(&recording, 0).0;
        assert_eq!(kinds(&recording), [FindingKind::WholeTurn]);
        assert_eq!(found[0].place.samples, Some(2999..3001));
        recording.joints[0].kind = JointKind::Prismatic;
        assert_eq!(kinds(&recording), [FindingKind::Contradiction]);
    }

    #[test]
    fn sizes_beyond_belief_are_told_alone() {
        let mut recording = swinging();
        recording.trajectories[0].channels_mut().tau[0][7] = -1e301;
        assert_eq!(kinds(&recording), [FindingKind::BeyondBelief]);
        recording.trajectories[0].channels_mut().tau[0][7] = 2.6e-260;
        let found = find(&recording, 0).0;
        assert!(found.len() == 1 && found[0].what.contains("2.600e-260 at sample 7"), "{found:?}");
        // What fades away to nothing is no damage, nor is the start of motion after it.
        let mut run = recording.trajectories[0].channels_mut();
        let fading = |at: usize| if at < 4000 { (-0.1 * at as f64).exp() } else { 1.0 };
        run.tau[0].iter_mut().enumerate().for_each(|(at, tau)| *tau = fading(at));
        assert!(!kinds(&recording).contains(&FindingKind::BeyondBelief));
    }

    #[test]
    fn a_derivative_that_was_measured_seldom_is_found() {
        let mut recording = swinging();
        let mut run = recording.trajectories[0].channels_mut();
        let qd = run.qd[0].to_vec();
        run.qd[0].iter_mut().enumerate().for_each(|(sample, value)| *value = qd[sample / 10 * 10]);
        let found = find(&recording, 0).0;
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
