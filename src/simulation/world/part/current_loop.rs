//! A drive whose current follows the command late.

use serde::{Deserialize, Serialize};

use super::low_pass::LowPass;
use super::{Install, from_one};
use crate::simulation::world::course::{Course, Draws};
use crate::simulation::world::moment::Moment;
use crate::simulation::world::plan::{Plan, Stage};
use crate::simulation::{SimulationError, sensible};

/// A current loop of first order. Only a log of the command shows it: it leads the torque.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CurrentLoop {
    /// Counted from 0 (from 1 in files).
    #[serde(with = "from_one")]
    pub joint: usize,
    /// Time constant \[s\].
    pub time: f64,
}

impl CurrentLoop {
    /// Good drives have 0.2 to 2 ms; slow ones, and torque interfaces over a bus, 5 to 20 ms.
    pub(in crate::simulation::world) fn drawn(joint: usize, _course: &Course, random: &mut Draws) -> Self {
        CurrentLoop { joint, time: random.between_logarithms(2e-3, 2e-2) }
    }
}

struct Following {
    time: f64,
    filter: LowPass,
}

impl Install for CurrentLoop {
    fn install(&self, plan: &mut Plan) {
        let slot = plan.hide("actuator-lag", Some(self.joint), vec![-self.time]);
        plan.joints[self.joint]
            .current
            .push((slot, Box::new(Following { time: self.time, filter: LowPass::default() })));
    }

    fn scale(&mut self, factor: f64) {
        self.time *= factor;
    }

    fn place(&self) -> Option<usize> {
        Some(self.joint)
    }

    fn is_plausible(&self) -> bool {
        self.time <= 0.02
    }

    fn check(&self) -> Result<(), SimulationError> {
        sensible("current loop's time", self.time)
    }
}

impl Stage for Following {
    fn pass(&mut self, torque: f64, now: &Moment) -> f64 {
        self.filter.follow(torque, self.time, now.step)
    }
}
