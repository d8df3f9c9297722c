//! What the log is made of: encoders on either side of the gear, with or without velocity, torque commanded or measured.

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

use super::part::Part;
use crate::recording::Trajectory;
use crate::recording::encoders::Side;
use crate::simulation::{SimulationError, demand, sensible, sensor};

/// The sensors of the arm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Sensors {
    /// Steps of the encoders \[rad\]; exact where it is left out.
    pub encoder_resolution: Option<f64>,
    /// On which side of the gear the encoders are.
    pub side: Side,
    /// Whether velocity is logged too; if not it is derived from position.
    pub velocity: bool,
    /// Standard deviation of the noise of velocity, as a share of each joint's RMS.
    pub velocity_noise: f64,
    /// Which torque is logged.
    pub torque: LoggedTorque,
    /// Standard deviation of the noise of torque, as a share of each joint's RMS.
    pub torque_noise: f64,
}

/// A place on the way of the torque.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LoggedTorque {
    /// What the controller asked for.
    #[default]
    Commanded,
    /// The motor's current times its stated torque constant.
    Measured,
}

impl Default for Sensors {
    fn default() -> Self {
        Sensors {
            encoder_resolution: None,
            side: Side::Link,
            velocity: true,
            velocity_noise: 0.0,
            torque: LoggedTorque::Commanded,
            torque_noise: 0.01,
        }
    }
}

impl Sensors {
    /// Whether the log can show what a part does: a current that comes late is seen in what was asked for, not in itself.
    pub(super) fn log(&self, part: &Part) -> bool {
        !matches!(part, Part::CurrentLoop(_)) || self.torque == LoggedTorque::Commanded
    }

    pub(super) fn check(&self) -> Result<(), SimulationError> {
        if let Some(resolution) = self.encoder_resolution {
            sensible("encoder resolution", resolution)?;
        }
        for (what, noise) in [("velocity noise", self.velocity_noise), ("torque noise", self.torque_noise)] {
            demand(what, noise, noise >= 0.0, "a fraction of 0 or more")?;
        }
        Ok(())
    }

    /// Makes readings of a run, whose acceleration is derived. Noise has these standard deviations of velocity \[rad/s\] and
    /// torque \[N m\]. Gives the cut-off of the filter \[Hz\].
    pub(super) fn read(&self, run: &mut Trajectory, deviations: &[Vec<f64>; 2], random: &mut impl Rng) -> f64 {
        let [of_velocity, of_torque] = deviations;
        let mut channels = run.channels_mut();
        for joint in 0..of_torque.len() {
            add_noise(&mut channels.tau[joint], of_torque[joint], random);
            add_noise(&mut channels.qd[joint], of_velocity[joint], random);
        }
        if let Some(resolution) = self.encoder_resolution {
            sensor::round_positions(run, resolution);
        }
        sensor::derive(run, self.velocity)
    }
}

fn add_noise(signal: &mut [f64], deviation: f64, random: &mut impl Rng) {
    for value in signal {
        let draw: f64 = StandardNormal.sample(random);
        *value += deviation * draw;
    }
}
