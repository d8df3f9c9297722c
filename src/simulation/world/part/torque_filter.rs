//! A torque reading that is smoothed before it is logged, and so comes late.

use serde::{Deserialize, Serialize};

use super::low_pass::LowPass;
use super::{Install, from_one};
use crate::simulation::world::course::{Course, Draws};
use crate::simulation::world::moment::Moment;
use crate::simulation::world::plan::{Plan, Stage};
use crate::simulation::{SimulationError, sensible};

/// A low-pass of first order between the torque and the log.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TorqueFilter {
    /// Counted from 0 (from 1 in files).
    #[serde(with = "from_one")]
    pub joint: usize,
    /// Time constant \[s\].
    pub time: f64,
}

impl TorqueFilter {
    /// Controllers log current through filters of 5 to 30 Hz, that is 5 to 30 ms.
    pub(in crate::simulation::world) fn drawn(joint: usize, _course: &Course, random: &mut Draws) -> Self {
        TorqueFilter { joint, time: random.between_logarithms(5e-3, 3e-2) }
    }
}

struct Smoothing {
    time: f64,
    filter: LowPass,
}

impl Install for TorqueFilter {
    fn install(&self, plan: &mut Plan) {
        let slot = plan.hide("actuator-lag", Some(self.joint), vec![self.time]);
        plan.joints[self.joint]
            .reading
            .push((slot, Box::new(Smoothing { time: self.time, filter: LowPass::default() })));
    }

    fn scale(&mut self, factor: f64) {
        self.time *= factor;
    }

    fn place(&self) -> Option<usize> {
        Some(self.joint)
    }

    fn is_plausible(&self) -> bool {
        self.time <= 0.03
    }

    fn check(&self) -> Result<(), SimulationError> {
        sensible("torque filter's time", self.time)
    }
}

impl Stage for Smoothing {
    fn pass(&mut self, torque: f64, now: &Moment) -> f64 {
        self.filter.follow(torque, self.time, now.step)
    }
}
