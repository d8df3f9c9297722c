//! The motor's torque ripples with its angle: magnets and teeth.

use serde::{Deserialize, Serialize};

use super::{Install, from_one};
use crate::simulation::world::course::{Course, Draws};
use crate::simulation::world::moment::Moment;
use crate::simulation::world::plan::{Plan, Stage};
use crate::simulation::{SimulationError, demand, sensible};

/// A wave that the motor adds to its torque.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cogging {
    /// Counted from 0 (from 1 in files).
    #[serde(with = "from_one")]
    pub joint: usize,
    /// Amplitude at the joint \[N m\].
    pub torque: f64,
    /// Radians of the wave over radians of the joint: pole pairs or slots, times the gear ratio.
    pub wave_number: f64,
    /// Its phase at q = 0 \[rad\].
    #[serde(default)]
    pub phase: f64,
}

impl Cogging {
    /// From direct drives with few poles to gears of 20 or so; at least two waves over the motion, or it is a spring.
    pub(in crate::simulation::world) fn drawn(joint: usize, course: &Course, random: &mut Draws) -> Self {
        let least = 2.0 * std::f64::consts::TAU / course.range(joint);
        let wave_number = random.between_logarithms(least.max(4.0), (2.0 * least).max(40.0));
        Cogging { joint, torque: 1.0, wave_number, phase: random.between(0.0, std::f64::consts::TAU) }
    }
}

impl Install for Cogging {
    fn install(&self, plan: &mut Plan) {
        // What the motor adds its current need not give.
        let (sin, cos) = self.phase.sin_cos();
        let parameters = vec![-self.torque * cos, -self.torque * sin, self.wave_number];
        let slot = plan.hide("cogging", Some(self.joint), parameters);
        plan.joints[self.joint].motor.push((slot, Box::new(self.clone())));
    }

    fn scale(&mut self, factor: f64) {
        self.torque *= factor;
    }

    fn place(&self) -> Option<usize> {
        Some(self.joint)
    }

    fn check(&self) -> Result<(), SimulationError> {
        sensible("cogging's torque", self.torque)?;
        sensible("cogging's wave number", self.wave_number)?;
        demand("cogging's phase", self.phase, true, "a finite angle")
    }
}

impl Stage for Cogging {
    fn pass(&mut self, torque: f64, now: &Moment) -> f64 {
        torque + self.torque * (self.wave_number * now.q[self.joint] + self.phase).sin()
    }
}
