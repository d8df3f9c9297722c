//! A motor whose torque constant is not the stated one.

use serde::{Deserialize, Serialize};

use super::{Install, from_one};
use crate::simulation::world::course::{Course, Draws};
use crate::simulation::world::moment::Moment;
use crate::simulation::world::plan::{Plan, Stage};
use crate::simulation::{SimulationError, demand};

/// The torque that the log states is so much too large.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TorqueConstant {
    /// Counted from 0 (from 1 in files).
    #[serde(with = "from_one")]
    pub joint: usize,
    /// Stated torque over true torque, less 1.
    pub error: f64,
}

impl TorqueConstant {
    /// Torque constants vary by 5 to 10 % from motor to motor, and fall with the magnets' temperature.
    pub(in crate::simulation::world) fn drawn(joint: usize, _course: &Course, random: &mut Draws) -> Self {
        TorqueConstant { joint, error: 0.05 * random.sign() }
    }
}

impl Install for TorqueConstant {
    fn install(&self, plan: &mut Plan) {
        let slot = plan.hide("torque-gain", Some(self.joint), vec![self.error]);
        plan.joints[self.joint].motor.push((slot, Box::new(self.clone())));
    }

    fn scale(&mut self, factor: f64) {
        self.error *= factor;
    }

    fn place(&self) -> Option<usize> {
        Some(self.joint)
    }

    fn is_plausible(&self) -> bool {
        self.error.abs() <= 0.25
    }

    fn check(&self) -> Result<(), SimulationError> {
        demand("torque constant's error", self.error, (-0.9..=9.0).contains(&self.error), "between -0.9 and 9")
    }
}

impl Stage for TorqueConstant {
    fn pass(&mut self, torque: f64, _now: &Moment) -> f64 {
        torque / (1.0 + self.error)
    }
}
