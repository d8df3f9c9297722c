//! A torque reading that ends at the range of its converter.

use serde::{Deserialize, Serialize};

use super::{Install, from_one};
use crate::simulation::world::course::{Course, Draws};
use crate::simulation::world::moment::Moment;
use crate::simulation::world::plan::{Plan, Stage};
use crate::simulation::{SimulationError, sensible};

/// Beyond the limit the log holds the limit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SaturatedReading {
    /// Counted from 0 (from 1 in files).
    #[serde(with = "from_one")]
    pub joint: usize,
    /// \[N m\]
    pub limit: f64,
}

impl SaturatedReading {
    /// Between half and nearly all of the largest torque.
    pub(in crate::simulation::world) fn drawn(joint: usize, course: &Course, random: &mut Draws) -> Self {
        SaturatedReading { joint, limit: course.largest_torque(joint) * random.between(0.6, 0.95) }
    }
}

impl Install for SaturatedReading {
    fn install(&self, plan: &mut Plan) {
        let slot = plan.hide("torque-saturation", Some(self.joint), vec![self.limit]);
        plan.joints[self.joint].reading.push((slot, Box::new(self.clone())));
    }

    /// The largest torque of the motion decides how much is cut off.
    fn scale(&mut self, _factor: f64) {}

    fn place(&self) -> Option<usize> {
        Some(self.joint)
    }

    fn check(&self) -> Result<(), SimulationError> {
        sensible("saturated reading's limit", self.limit)
    }
}

impl Stage for SaturatedReading {
    fn pass(&mut self, torque: f64, _now: &Moment) -> f64 {
        torque.clamp(-self.limit, self.limit)
    }
}
