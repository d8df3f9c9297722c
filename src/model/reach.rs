//! Up to which frequency the torque follows the motion.
//!
//! A motion that was measured says more than the arm did: gears rattle, encoders are uneven, and what is derived from them makes that
//! louder the faster it is. Where a rigid body asks for more torque along such a motion than was measured at all, nothing can be
//! learned of the torque, but every factor of an acceleration is drawn towards zero, and whatever is large when that is small
//! (a gain, a dead zone) passes for the reason. So the band of a fit ends where the torque does not follow the motion any more.

use super::preparation::Preparation;
use crate::recording::spectrum::power;
use crate::signals::Signals;

/// The rigid body leaves so many times the power of the torque where that does not follow: motion that no torque caused leaves all that
/// it asks for, and a body twice too heavy no more than there is. Reasoned, looked at on the DFKI pendulum, and tried on what RESULTS.md
/// tells: forty arms of another engine, worlds, and effects planted into four real logs.
const NOT_FOLLOWED: f64 = 2.0;
/// No band ends below this share of where it would end by the motion alone, which is at least four times the frequency of the motion: the
/// arm's own motion has its second harmonic there, as products of two joints have.
const LOWEST: f64 = 0.5;
/// A band that ends above this share of that is all of it: what lies between says little, and other equations cost more.
const ALL: f64 = 0.9;
/// So many samples that do not count are bridged, such as those of a reversal.
const MOST_BRIDGED: usize = 3;

/// The highest frequency at which the torque follows the motion on half of the joints at least \[Hz\], as far as that is clearly below
/// the cut-off of all trajectories; `None` where it follows up to there, or nothing can be told.
///
/// One joint that is near the bound does not decide for all: parts of a log would end elsewhere than the whole of it.
///
/// `left` is what a rigid body with the commonest friction leaves of the prepared torque, by trajectory; samples that do not count
/// (`counts[trajectory][joint][sample]`) are zero in both.
pub(super) fn reach(
    preparations: &[Preparation],
    counts: &[Vec<Vec<bool>>],
    torque: &[Signals],
    left: &[Signals],
) -> Option<f64> {
    let mut cutoffs = preparations.iter().map(|preparation| preparation.cutoff);
    let lowest = cutoffs.try_fold(f64::INFINITY, |lowest, cutoff| Some(lowest.min(cutoff?)))?;
    let step = preparations.iter().map(|preparation| preparation.time_step * preparation.every as f64);
    // Spectra of trajectories of other rates don't add up.
    let steps = step.fold([f64::INFINITY, 0.0], |[low, high]: [f64; 2], step| [low.min(step), high.max(step)]);
    if steps[1] > 1.01 * steps[0] {
        return None;
    }
    let spectrum = |signals: &[Signals], joint: usize| {
        let of_run = |(signals, counts): (&Signals, &Vec<Vec<bool>>)| pieces(&signals[joint], &counts[joint]);
        let pieces: Vec<Vec<f64>> = signals.iter().zip(counts).flat_map(of_run).collect();
        power(&pieces.iter().map(Vec::as_slice).collect::<Vec<_>>(), steps[0])
    };
    let of_joint = |joint: usize| {
        let [torque, left] = [torque, left].map(|signals| spectrum(signals, joint));
        let (mut asked, mut there, mut end) = (0.0, 0.0, lowest);
        for ([frequency, torque], [_, left]) in torque.iter().zip(&left).rev().filter(|([at, _], _)| *at <= lowest) {
            (there, asked) = (there + torque, asked + left);
            if asked <= NOT_FOLLOWED * there {
                break;
            }
            end = *frequency;
        }
        end
    };
    let joints = torque.first().map_or(0, Signals::joint_count);
    let mut ends: Vec<f64> = (0..joints).map(of_joint).collect();
    ends.sort_by(f64::total_cmp);
    let reach = ends.get(joints / 2).copied().unwrap_or(lowest);
    (reach < ALL * lowest).then_some(reach.max(LOWEST * lowest))
}

/// The stretches of a signal that count, with a straight line where only a few samples between do not: what is blanked there would be a
/// jump with all frequencies.
fn pieces(signal: &[f64], counts: &[bool]) -> Vec<Vec<f64>> {
    let mut pieces: Vec<Vec<f64>> = Vec::new();
    let mut last: Option<usize> = None;
    for (sample, value) in signal.iter().enumerate().filter(|(sample, _)| counts[*sample]) {
        match (last.filter(|last| sample - last <= MOST_BRIDGED + 1), pieces.last_mut()) {
            (Some(last), Some(piece)) => {
                let [from, steps] = [signal[last], (sample - last) as f64];
                piece.extend((1..=sample - last).map(|step| from + (value - from) * step as f64 / steps));
            }
            _ => pieces.push(vec![*value]),
        }
        last = Some(sample);
    }
    pieces
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::model::design::Design;
    use crate::model::{Preset, fit};
    use crate::progress::Monitor;
    use crate::recording::split::Split;
    use crate::recording::{Origin, Recording};
    use crate::simulation::{Excitation, Scenario, simulate};

    /// Swings of at most 1.5 Hz whose acceleration has to be derived, and a rattle of this size \[rad\] on some joints that no torque causes.
    fn log(rattle: f64, joints: &[usize]) -> (Recording, Split) {
        let mut scenario = Scenario { effects: Vec::new(), ..Scenario::embedded() };
        if let Excitation::MultiSine { duration, rate, .. } = &mut scenario.motion {
            (*duration, *rate) = (10.0, 200.0);
        }
        let mut recording = simulate(&scenario, &Monitor::new()).unwrap();
        recording.provenance.acceleration = Origin::Derived("from the velocity".to_owned());
        for (run, trajectory) in recording.trajectories.iter_mut().enumerate() {
            let time = trajectory.time.clone();
            let mut channels = trajectory.channels_mut();
            for &joint in joints {
                for (number, frequency) in [3.7, 4.3, 4.9, 5.3, 5.9, 6.7, 7.9, 9.1].iter().enumerate() {
                    let phase = |t: f64| TAU * frequency * t + (number * 5 + joint * 3 + run) as f64;
                    for (sample, &t) in time.iter().enumerate() {
                        channels.q[joint][sample] += rattle * phase(t).sin();
                        channels.qd[joint][sample] += rattle * TAU * frequency * phase(t).cos();
                    }
                }
            }
        }
        let split = Split::automatic(&recording);
        (recording, split)
    }

    /// The largest difference of a base parameter from what is found in the log without rattle, as a share of that.
    fn worst(with: &Recording, split: &Split) -> f64 {
        let body = |recording: &Recording| {
            let model = Preset::RigidBody.model(recording).unwrap();
            fit(&model, recording, split, &Monitor::new()).unwrap().parameters
        };
        let (clean, rattling) = (body(&log(0.0, &[]).0), body(with));
        let error = |(clean, rattling): (&fit::Parameter, &fit::Parameter)| (rattling.value / clean.value - 1.0).abs();
        clean.iter().zip(&rattling).map(error).fold(0.0, f64::max)
    }

    #[test]
    fn a_band_ends_where_most_joints_rattle() {
        let (clean, split) = log(0.0, &[]);
        let up_to = |recording: &Recording| Design::new(recording, &split).unwrap().follows_up_to();
        assert_eq!(up_to(&clean), None);
        let (rattling, _) = log(2e-3, &[0, 1, 2]);
        let reach = up_to(&rattling).unwrap();
        assert!((2.9..4.5).contains(&reach), "{reach}");
        assert!(worst(&rattling, &split) < 0.1, "{}", worst(&rattling, &split));
        // What one joint rattles shakes all that hang on it, as long as their torque is less than that.
        assert!(up_to(&log(2e-3, &[1]).0).is_some());
        assert_eq!(up_to(&log(1e-5, &[1]).0), None);
    }

    /// Torque of about 1 Hz with a tenth of about 5 Hz on each of so many joints; of those that don't follow a body leaves ten times that
    /// tenth.
    #[test]
    fn half_of_the_joints_decide() {
        let preparation = Preparation { time_step: 0.05, cutoff: Some(6.0), every: 1 };
        let up_to = |joints: usize, not_following: usize| {
            let wave = |frequency: f64, sample: usize| (TAU * frequency * 0.05 * sample as f64).sin();
            let torque = Signals::from_fn(joints, 400, |_, sample| wave(1.03, sample) + 0.1 * wave(4.97, sample));
            let size = |joint: usize| if joint < not_following { 1.0 } else { 0.05 };
            let left = Signals::from_fn(joints, 400, |joint, sample| size(joint) * wave(4.97, sample));
            reach(&[preparation], &[vec![vec![true; 400]; joints]], &[torque], &[left])
        };
        for (joints, most) in [(1, 0), (2, 1), (3, 1), (4, 2), (6, 3), (7, 3)] {
            assert_eq!(up_to(joints, most), None, "{most} of {joints}");
            let reach = up_to(joints, most + 1).unwrap();
            assert!((LOWEST * 6.0..5.0).contains(&reach), "{most} and one of {joints}: {reach}");
        }
    }

    #[test]
    fn what_does_not_count_for_a_moment_is_bridged() {
        let signal = [1.0, 2.0, 0.0, 4.0, 0.0, 0.0, 0.0, 0.0, 9.0, 8.0];
        let counts = signal.map(|value| value != 0.0);
        assert_eq!(pieces(&signal, &counts), [vec![1.0, 2.0, 3.0, 4.0], vec![9.0, 8.0]]);
        assert!(pieces(&signal, &[false; 10]).is_empty());
    }
}
