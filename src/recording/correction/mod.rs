//! What is set right about a log that was read: where its zero is, which way its joints turn, which column is which joint's.
//!
//! A [`Correction`] changes the channels of a recording, or its posture, all samples alike. It is a value with a text
//! (`text`, such as `sign-torque@2`), so that it can be proposed, given as an option, saved, applied and taken back.

mod play;
mod text;
mod words;

use serde::{Deserialize, Serialize};

use super::{Recording, Trajectory};
use crate::signals::{Signals, SignalsMut};

pub use play::Play;
pub use text::CorrectionTextError;

/// One thing that is set right. Joints are counted from 0 here, and from 1 in texts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Correction {
    /// Where the first link of a planar arm points at q = 0, from +x towards +z \[rad\].
    Zero {
        /// The angle.
        angle: f64,
    },
    /// What is added to the angles of these joints.
    Offset {
        /// Which.
        joints: Vec<usize>,
        /// By how much \[rad or m\], one for each of them.
        angles: Vec<f64>,
    },
    /// The other sign.
    Sign {
        /// Of these channels.
        part: Part,
        /// Of these joints.
        joints: Vec<usize>,
    },
    /// Another order of columns.
    Order {
        /// Of these channels.
        part: Part,
        /// Joint i takes what stood at joint `order[i]`.
        order: Vec<usize>,
    },
    /// Angles are counted from elsewhere.
    Angles(Counted),
    /// Other units, or the other side of a gear.
    Factor {
        /// Of these channels.
        part: Part,
        /// Of these joints.
        joints: Vec<usize>,
        /// What they are multiplied by, one for each of them.
        factors: Vec<f64>,
    },
    /// Channels that come late: each sample takes what was read so much later.
    Delay {
        /// Which.
        part: Part,
        /// By how much \[s\]; negative if they come early.
        seconds: f64,
    },
    /// The angle of a motor in the place of its link's, behind a gear that has play.
    Play {
        /// Of this joint.
        joint: usize,
        /// How large it is, and what tells the flank.
        play: Play,
    },
}

/// Channels that are corrected together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Motion and torque.
    All,
    /// Position, velocity and acceleration.
    Motion,
    /// Position alone.
    Position,
    /// Velocity and acceleration.
    Rates,
    /// Velocity alone.
    Velocity,
    /// Acceleration alone.
    Acceleration,
    /// Torque.
    Torque,
}

/// From where the angles of a log are counted, which are taken as counted from the link before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Counted {
    /// From one direction for all links.
    Absolute,
    /// From the link before, while they were differences of such angles already.
    Relative,
}

/// The correction does not fit the recording.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CorrectionError {
    /// A joint that the recording has not.
    #[error("`{correction}` is about joint {joint}, but the recording has {joints}: choose a joint from 1 to {joints}")]
    NoSuchJoint {
        /// Its text.
        correction: String,
        /// Counted from 1.
        joint: usize,
        /// How many there are.
        joints: usize,
    },
    /// The order does not name each joint once.
    #[error("`{correction}` must name each of the {joints} joints once")]
    Order {
        /// Its text.
        correction: String,
        /// How many there are.
        joints: usize,
    },
    /// A posture for an arm that has axes in space.
    #[error(
        "`{0}` is about a planar arm, but the axes of this one are stated: shift the zero of a joint, such as `zero@2=90`"
    )]
    NotPlanar(String),
    /// Nothing would be left.
    #[error("trajectory `{trajectory}` has no three samples left after `{correction}`: it is shorter than the delay")]
    TooShort {
        /// Its text.
        correction: String,
        /// Which.
        trajectory: String,
    },
}

/// A trajectory has at least so many samples.
const FEWEST: usize = 3;

impl Correction {
    /// Whether it states what the numbers of the torque are worth.
    pub fn scales_torque(&self) -> bool {
        matches!(self, Correction::Factor { part: Part::Torque | Part::All, .. })
    }
}

impl Part {
    /// The channels of this part, to change them.
    fn of(self, trajectory: &mut Trajectory) -> Vec<SignalsMut<'_>> {
        let run = trajectory.channels_mut();
        match self {
            Part::All => vec![run.q, run.qd, run.qdd, run.tau],
            Part::Motion => vec![run.q, run.qd, run.qdd],
            Part::Position => vec![run.q],
            Part::Rates => vec![run.qd, run.qdd],
            Part::Velocity => vec![run.qd],
            Part::Acceleration => vec![run.qdd],
            Part::Torque => vec![run.tau],
        }
    }
}

impl Correction {
    /// Sets it right in a recording.
    ///
    /// # Errors
    /// [`CorrectionError`] if it does not fit; the recording is as it was then.
    pub fn apply(&self, recording: &mut Recording) -> Result<(), CorrectionError> {
        self.check(recording)?;
        let joints = recording.joint_count();
        match self {
            Correction::Zero { angle } => {
                let mut posture = recording.assumed_posture();
                posture.zero_angle = *angle;
                recording.posture = Some(posture);
            }
            Correction::Offset { joints, angles } => {
                for run in &mut recording.trajectories {
                    let mut q = run.channels_mut().q;
                    for (joint, angle) in joints.iter().zip(angles) {
                        q[*joint].iter_mut().for_each(|q| *q += angle);
                    }
                }
            }
            Correction::Sign { part, joints } => {
                recording.trajectories.iter_mut().for_each(|run| scale(*part, run, joints, |_| -1.0));
            }
            Correction::Factor { part, joints, factors } => {
                recording.trajectories.iter_mut().for_each(|run| scale(*part, run, joints, |place| factors[place]));
            }
            Correction::Order { part, order } => {
                if *part == Part::All {
                    recording.joints = order.iter().map(|&joint| recording.joints[joint].clone()).collect();
                }
                for run in &mut recording.trajectories {
                    let samples = run.len();
                    for mut channel in part.of(run) {
                        let before = Signals::from_fn(joints, samples, |joint, sample| channel[joint][sample]);
                        for (joint, &from) in order.iter().enumerate() {
                            channel[joint].copy_from_slice(&before[from]);
                        }
                    }
                }
            }
            Correction::Angles(counted) => {
                for run in &mut recording.trajectories {
                    for mut channel in Part::Motion.of(run) {
                        count_anew(&mut channel, joints, *counted);
                    }
                }
            }
            Correction::Play { joint, play } => {
                recording.trajectories.iter_mut().for_each(|run| play.take_out(run, *joint));
            }
            Correction::Delay { part, seconds } => {
                let in_time = |run: &Trajectory| {
                    let (correction, trajectory) = (self.to_string(), run.name.clone());
                    advanced(run, *part, *seconds).ok_or(CorrectionError::TooShort { correction, trajectory })
                };
                recording.trajectories = recording.trajectories.iter().map(in_time).collect::<Result<_, _>>()?;
            }
        }
        Ok(())
    }

    fn check(&self, recording: &Recording) -> Result<(), CorrectionError> {
        let joints = recording.joint_count();
        let correction = || self.to_string();
        match self {
            Correction::Zero { .. } if recording.spatial().is_some() => Err(CorrectionError::NotPlanar(correction())),
            Correction::Order { order, .. } => {
                let mut sorted = order.clone();
                sorted.sort_unstable();
                let is_whole = sorted.into_iter().eq(0..joints);
                if is_whole { Ok(()) } else { Err(CorrectionError::Order { correction: correction(), joints }) }
            }
            Correction::Offset { joints: which, .. }
            | Correction::Sign { joints: which, .. }
            | Correction::Factor { joints: which, .. } => match which.iter().find(|joint| **joint >= joints) {
                Some(joint) => Err(CorrectionError::NoSuchJoint { correction: correction(), joint: joint + 1, joints }),
                None => Ok(()),
            },
            Correction::Play { joint, .. } if *joint >= joints => {
                Err(CorrectionError::NoSuchJoint { correction: correction(), joint: joint + 1, joints })
            }
            Correction::Play { .. } => Ok(()),
            Correction::Zero { .. } | Correction::Angles(_) | Correction::Delay { .. } => Ok(()),
        }
    }
}

/// Multiplies some joints of some channels; `factor` is told the place in `joints`.
fn scale(part: Part, trajectory: &mut Trajectory, joints: &[usize], factor: impl Fn(usize) -> f64) {
    for mut channel in part.of(trajectory) {
        for (place, joint) in joints.iter().enumerate() {
            channel[*joint].iter_mut().for_each(|value| *value *= factor(place));
        }
    }
}

/// Differences of neighbouring joints in the place of their values, or the sums of all up to each.
fn count_anew(channel: &mut SignalsMut, joints: usize, counted: Counted) {
    let pairs: Vec<usize> = match counted {
        Counted::Absolute => (1..joints).rev().collect(),
        Counted::Relative => (1..joints).collect(),
    };
    for joint in pairs {
        let before = channel[joint - 1].to_vec();
        for (value, before) in channel[joint].iter_mut().zip(before) {
            *value += if counted == Counted::Absolute { -before } else { before };
        }
    }
}

/// The run with a part of it as it was read `seconds` later, where there is such a reading; between two samples on the straight
/// line. `None` if too few samples have one.
fn advanced(trajectory: &Trajectory, part: Part, seconds: f64) -> Option<Trajectory> {
    let time = &trajectory.time;
    let (first, last) = (time.first()?, time.last()?);
    // Rounding must not cost a sample that has its reading.
    let slack = 1e-9 * trajectory.time_step();
    let start = time.partition_point(|t| t + seconds < first - slack);
    let end = time.partition_point(|t| t + seconds <= last + slack);
    if end < start + FEWEST {
        return None;
    }
    let mut kept = trajectory.slice(start..end);
    let places: Vec<(usize, f64)> = time[start..end].iter().map(|t| place_in(time, t + seconds)).collect();
    let mut whole = trajectory.clone();
    for (channel, source) in part.of(&mut kept).iter_mut().zip(part.of(&mut whole)) {
        for joint in 0..trajectory.joint_count() {
            let read = &source[joint];
            for (value, &(before, share)) in channel[joint].iter_mut().zip(&places) {
                let next = read[(before + 1).min(read.len() - 1)];
                *value = read[before] + share * (next - read[before]);
            }
        }
    }
    Some(kept)
}

/// The sample at or before a moment, and how far the moment is on the way to the next one, 0 to 1.
fn place_in(time: &[f64], moment: f64) -> (usize, f64) {
    let before = time.partition_point(|t| *t <= moment).saturating_sub(1);
    let Some(next) = time.get(before + 1) else { return (before, 0.0) };
    (before, ((moment - time[before]) / (next - time[before])).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::Posture;
    use crate::recording::Channels;

    /// Two joints, four samples a second; each value names its channel, joint and sample.
    fn recording() -> Recording {
        let channel = |hundreds: usize| {
            Signals::from_fn(2, 6, |joint, sample| (100 * hundreds + 10 * (joint + 1) + sample) as f64)
        };
        let time = (0..6).map(|sample| 0.25 * f64::from(sample)).collect();
        let channels = Channels { time, q: channel(1), qd: channel(2), qdd: channel(3), tau: channel(4) };
        Recording::of_runs(vec![Trajectory::new("run", channels).unwrap()])
    }

    fn corrected(text: &str) -> Recording {
        let mut recording = recording();
        text.parse::<Correction>().unwrap().apply(&mut recording).unwrap();
        recording.verify().unwrap();
        recording
    }

    /// The first sample of both joints of q, q̇, q̈ and τ.
    fn first(text: &str) -> [[f64; 2]; 4] {
        let recording = corrected(text);
        recording.trajectories[0].signals().map(|(_, signal)| [signal[0][0], signal[1][0]])
    }

    #[test]
    fn each_changes_its_channels_and_no_other() {
        let [q, qd, qdd, tau] = [[110.0, 120.0], [210.0, 220.0], [310.0, 320.0], [410.0, 420.0]];
        assert_eq!(corrected("zero=down").posture, Some(Posture::DOWN));
        let half = std::f64::consts::PI;
        assert_eq!(first("zero@2=180"), [[110.0, 120.0 + half], qd, qdd, tau]);
        assert_eq!(first("sign-motion@2"), [[110.0, -120.0], [210.0, -220.0], [310.0, -320.0], tau]);
        assert_eq!(first("sign-torque@1,2"), [q, qd, qdd, [-410.0, -420.0]]);
        assert_eq!(first("order-torque=2,1"), [q, qd, qdd, [420.0, 410.0]]);
        assert_eq!(first("angles=absolute"), [[110.0, 10.0], [210.0, 10.0], [310.0, 10.0], tau]);
        assert_eq!(first("angles=relative"), [[110.0, 230.0], [210.0, 430.0], [310.0, 630.0], tau]);
        assert_eq!(first("factor-velocity@1=0.5"), [q, [105.0, 220.0], qdd, tau]);
        let turned = corrected("order=2,1");
        assert_eq!((turned.joints[0].name.as_str(), turned.trajectories[0].tau[0][0]), ("joint 2", 420.0));
    }

    #[test]
    fn what_comes_late_is_taken_from_later_and_the_rest_is_cut() {
        let late = &corrected("delay-torque=0.5").trajectories[0];
        assert_eq!((late.len(), late.time[0]), (4, 0.0));
        assert_eq!((late.tau[0][0], late.q[0][0]), (412.0, 110.0), "what was read two samples later");
        let early = &corrected("delay-rates=-0.25").trajectories[0];
        assert_eq!((early.len(), early.time[0], early.qd[1][0], early.q[1][0]), (5, 0.25, 220.0, 121.0));
        let between = &corrected("delay-position=0.125").trajectories[0];
        assert_eq!((between.len(), between.q[0][0]), (5, 110.5));
    }

    #[test]
    fn what_does_not_fit_is_refused_and_changes_nothing() {
        for (text, words) in [
            ("sign-torque@3", "joint 3, but the recording has 2"),
            ("play@3=0.3,0.1,0.04", "joint 3, but the recording has 2"),
            ("order=1,1", "each of the 2 joints once"),
            ("order=1,2,3", "each of the 2 joints once"),
            ("delay-torque=2", "`run` has no three samples left"),
        ] {
            let mut unchanged = recording();
            let error = text.parse::<Correction>().unwrap().apply(&mut unchanged).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
            assert_eq!(unchanged, recording());
        }
    }
}
