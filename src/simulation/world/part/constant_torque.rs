//! A torque that is always there: an unbalanced brake, a hose that pulls, an amplifier that drifts.

use serde::{Deserialize, Serialize};

use super::{Install, from_one};
use crate::simulation::world::course::{Course, Draws};
use crate::simulation::world::moment::{Forces, Moment};
use crate::simulation::world::plan::{Device, Plan};
use crate::simulation::{SimulationError, demand};

/// A torque against the drive of a joint, whatever the joint does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConstantTorque {
    /// Counted from 0 (from 1 in files).
    #[serde(with = "from_one")]
    pub joint: usize,
    /// \[N m\]
    pub torque: f64,
    /// How it changes \[N m/s\].
    #[serde(default)]
    pub rate: f64,
}

impl ConstantTorque {
    pub(in crate::simulation::world) fn steady(joint: usize, _course: &Course, random: &mut Draws) -> Self {
        ConstantTorque { joint, torque: random.sign(), rate: 0.0 }
    }

    /// It changes by once or twice itself during the run.
    pub(in crate::simulation::world) fn drifting(joint: usize, course: &Course, random: &mut Draws) -> Self {
        let rate = random.between(1.0, 2.0) * random.sign() / course.duration();
        ConstantTorque { joint, torque: random.sign(), rate }
    }
}

impl Install for ConstantTorque {
    fn install(&self, plan: &mut Plan) {
        let (name, parameters) = match self.rate {
            0.0 => ("torque-offset", vec![self.torque]),
            rate => ("offset-drift", vec![self.torque, rate]),
        };
        let slot = plan.hide(name, Some(self.joint), parameters);
        plan.act(slot, self.clone());
    }

    fn scale(&mut self, factor: f64) {
        self.torque *= factor;
        self.rate *= factor;
    }

    fn place(&self) -> Option<usize> {
        Some(self.joint)
    }

    fn check(&self) -> Result<(), SimulationError> {
        demand("constant torque", self.torque, self.torque.abs() < 1e6, "a finite torque")?;
        demand("constant torque's rate", self.rate, self.rate.abs() < 1e6, "a finite rate")
    }
}

impl Device for ConstantTorque {
    fn act(&mut self, now: &Moment, forces: &mut Forces) {
        forces.resist(self.joint, self.torque + self.rate * now.time.max(0.0));
    }
}
