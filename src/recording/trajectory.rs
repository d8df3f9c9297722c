//! One run of an arm: its clock and four channels of one shape.

use std::ops::{Deref, Range};

use super::differentiate;
use super::error::RecordingError;
use crate::signals::{ShapeError, Signals, SignalsMut};
use crate::statistics::ends;

/// Takes a channel out of a trajectory.
pub(crate) type Pick = fn(&Trajectory) -> &Signals;

/// One run without interruption of its clock. All channels have as many joints as each other and a sample for each time stamp,
/// because nothing else can be built; they are read as fields: `trajectory.q[joint][sample]`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trajectory {
    /// Name for tables and legends.
    pub name: String,
    channels: Channels,
}

/// What is known at each sample.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Channels {
    /// Time stamps \[s\], strictly increasing.
    pub time: Vec<f64>,
    /// Joint position \[rad or m\].
    pub q: Signals,
    /// Joint velocity \[rad/s or m/s\].
    pub qd: Signals,
    /// Joint acceleration \[rad/s² or m/s²\].
    pub qdd: Signals,
    /// Joint torque \[N m or N\].
    pub tau: Signals,
}

/// The channels of a trajectory, whose values may be changed, but not their shape.
#[derive(Debug)]
pub struct ChannelsMut<'a> {
    /// Time stamps \[s\].
    pub time: &'a mut [f64],
    /// Joint position \[rad or m\].
    pub q: SignalsMut<'a>,
    /// Joint velocity \[rad/s or m/s\].
    pub qd: SignalsMut<'a>,
    /// Joint acceleration \[rad/s² or m/s²\].
    pub qdd: SignalsMut<'a>,
    /// Joint torque \[N m or N\].
    pub tau: SignalsMut<'a>,
}

impl Deref for Trajectory {
    type Target = Channels;

    fn deref(&self) -> &Channels {
        &self.channels
    }
}

impl Channels {
    /// The four signals and their symbols.
    pub fn signals(&self) -> [(&'static str, &Signals); 4] {
        [("q", &self.q), ("qd", &self.qd), ("qdd", &self.qdd), ("tau", &self.tau)]
    }
}

impl Trajectory {
    /// How many samples it has.
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Whether it has no sample at all.
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// How many joints it has.
    pub fn joint_count(&self) -> usize {
        self.q.joint_count()
    }

    /// Puts a clock and channels together.
    ///
    /// # Errors
    /// [`ShapeError`] names the first channel that has not as many joints as q or as many samples as the clock.
    pub fn new(name: impl Into<String>, channels: Channels) -> Result<Self, ShapeError> {
        let name = name.into();
        for (channel, signal) in channels.signals() {
            check(&name, channel, signal, channels.q.joint_count(), channels.time.len())?;
        }
        Ok(Trajectory { name, channels })
    }

    /// The values of the channels, to change them.
    pub fn channels_mut(&mut self) -> ChannelsMut<'_> {
        let Channels { time, q, qd, qdd, tau } = &mut self.channels;
        let [q, qd, qdd, tau] = [q, qd, qdd, tau].map(SignalsMut::of);
        ChannelsMut { time, q, qd, qdd, tau }
    }

    /// Gives it another torque \[N m or N\].
    ///
    /// # Errors
    /// [`ShapeError`] if that has another number of joints or samples; the torque stays as it was then.
    pub fn set_torque(&mut self, tau: Signals) -> Result<(), ShapeError> {
        check(&self.name, "tau", &tau, self.joint_count(), self.len())?;
        self.channels.tau = tau;
        Ok(())
    }

    /// The same run with another torque \[N m or N\].
    ///
    /// # Errors
    /// As [`Trajectory::set_torque`].
    pub fn with_torque(mut self, tau: Signals) -> Result<Self, ShapeError> {
        self.set_torque(tau)?;
        Ok(self)
    }

    /// The same motion with a torque of zero, for what depends on the motion alone.
    pub fn without_torque(&self) -> Self {
        let mut motion = self.clone();
        motion.channels.tau.values_mut().fill(0.0);
        motion
    }

    /// Median time step \[s\]; 0 with fewer than two samples.
    pub fn time_step(&self) -> f64 {
        differentiate::median_step(&self.time)
    }

    /// Time since the first sample \[s\], of each sample.
    pub fn since_start(&self) -> impl Iterator<Item = f64> {
        let start = self.time.first().copied().unwrap_or(0.0);
        self.time.iter().map(move |time| time - start)
    }

    /// The least and the greatest position of a joint in all of these runs; of a joint that is not there the least lies above.
    pub fn way<'a>(runs: impl IntoIterator<Item = &'a Trajectory>, joint: usize) -> [f64; 2] {
        ends(runs.into_iter().filter_map(|run| run.q.get(joint)).flatten().copied())
    }

    /// The samples of `range` as a trajectory of their own.
    ///
    /// # Panics
    /// If there are no such samples.
    pub fn slice(&self, range: Range<usize>) -> Trajectory {
        let cut = |signal: &Signals| signal.cut(range.clone());
        let channels = Channels {
            time: self.time[range.clone()].to_vec(),
            q: cut(&self.q),
            qd: cut(&self.qd),
            qdd: cut(&self.qdd),
            tau: cut(&self.tau),
        };
        Trajectory { name: self.name.clone(), channels }
    }

    /// Every so manieth sample, from the first.
    pub fn thinned(&self, every: usize) -> Trajectory {
        let thin = |signal: &Signals| signal.map_joints(|values| values.iter().copied().step_by(every).collect());
        let channels = Channels {
            time: self.time.iter().copied().step_by(every).collect(),
            q: thin(&self.q),
            qd: thin(&self.qd),
            qdd: thin(&self.qdd),
            tau: thin(&self.tau),
        };
        Trajectory { name: self.name.clone(), channels }
    }

    /// Checks that it is a run of so many joints, with finite values and a clock that increases.
    pub(super) fn verify(&self, joints: usize) -> Result<(), RecordingError> {
        let trajectory = || self.name.clone();
        if self.is_empty() {
            let (found, expected) = ("no sample".to_owned(), "at least 1".to_owned());
            return Err(ShapeError { what: format!("trajectory `{}`: time", self.name), found, expected }.into());
        }
        for (channel, signals) in self.signals() {
            check(&self.name, channel, signals, joints, self.len())?;
            for (index, signal) in signals.iter().enumerate() {
                if let Some(sample) = signal.iter().position(|value| !value.is_finite()) {
                    let (joint, value) = (index + 1, signal[sample]);
                    return Err(RecordingError::NotFinite { trajectory: trajectory(), channel, joint, sample, value });
                }
            }
        }
        let clock = |sample: usize, before: f64, after: f64| {
            Err(RecordingError::Clock { trajectory: trajectory(), sample, before, after })
        };
        let goes_on = |pair: &[f64]| pair[1] > pair[0] && pair[1].is_finite();
        match self.time.windows(2).position(|pair| !goes_on(pair)) {
            Some(before) => clock(before + 1, self.time[before], self.time[before + 1]),
            None if self.time.first().is_some_and(|start| !start.is_finite()) => clock(0, self.time[0], self.time[0]),
            None => Ok(()),
        }
    }
}

fn check(trajectory: &str, channel: &str, signal: &Signals, joints: usize, samples: usize) -> Result<(), ShapeError> {
    let wrong =
        |found, expected| Err(ShapeError { what: format!("trajectory `{trajectory}`: {channel}"), found, expected });
    if signal.joint_count() != joints {
        return wrong(format!("{} joints", signal.joint_count()), joints.to_string());
    }
    if signal.sample_count() != samples {
        return wrong(format!("{} samples", signal.sample_count()), samples.to_string());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channels() -> Channels {
        let signal = || Signals::zeros(2, 3);
        Channels { time: vec![0.0, 0.1, 0.2], q: signal(), qd: signal(), qdd: signal(), tau: signal() }
    }

    #[test]
    fn channels_that_disagree_are_never_a_trajectory() {
        let other_joints = Channels { qd: Signals::zeros(1, 3), ..channels() };
        let message = Trajectory::new("run 1", other_joints).unwrap_err().to_string();
        assert_eq!(message, "trajectory `run 1`: qd has 1 joints, but 2 are needed");
        let message = Trajectory::new("run 1", Channels { time: vec![0.0], ..channels() }).unwrap_err().to_string();
        assert_eq!(message, "trajectory `run 1`: q has 3 samples, but 1 are needed");
        let trajectory = Trajectory::new("run 1", channels()).unwrap();
        assert!(trajectory.clone().with_torque(Signals::zeros(2, 4)).is_err());
        assert_eq!(trajectory.clone().with_torque(Signals::zeros(2, 3)), Ok(trajectory));
    }

    #[test]
    fn values_change_in_their_places() {
        let mut trajectory = Trajectory::new("run 1", channels()).unwrap();
        let mut run = trajectory.channels_mut();
        run.time[2] = 0.3;
        run.tau[1].copy_from_slice(&[1.0, 2.0, 3.0]);
        run.q.iter_mut().for_each(|joint| joint[0] = 5.0);
        assert_eq!(trajectory.slice(0..1).q.values(), [5.0, 5.0]);
        assert_eq!((trajectory.time[2], trajectory.tau[1][2]), (0.3, 3.0));
    }
}
