//! Friction by speed: grease, seals, air.

use serde::{Deserialize, Serialize};

use super::{Install, from_one};
use crate::simulation::world::course::{Course, Draws};
use crate::simulation::world::moment::{Forces, Moment};
use crate::simulation::world::plan::{Device, Plan};
use crate::simulation::{SimulationError, sensible};

/// Friction of a joint that grows as |q̇| to some power.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedFriction {
    /// Counted from 0 (from 1 in files).
    #[serde(with = "from_one")]
    pub joint: usize,
    /// At 1 rad/s \[N m\].
    pub coefficient: f64,
    /// Power of the speed: 1 is viscous, 2 is drag, less than 1 is a grease that thins.
    #[serde(default = "viscous")]
    pub exponent: f64,
}

fn viscous() -> f64 {
    1.0
}

impl SpeedFriction {
    pub(in crate::simulation::world) fn viscous(joint: usize, _course: &Course, _random: &mut Draws) -> Self {
        SpeedFriction { joint, coefficient: 1.0, exponent: 1.0 }
    }

    pub(in crate::simulation::world) fn quadratic(joint: usize, _course: &Course, _random: &mut Draws) -> Self {
        SpeedFriction { joint, coefficient: 1.0, exponent: 2.0 }
    }

    /// Grease of robot gears thins under shear, with powers of 0.4 to 0.7 (Carvalho Bittencourt and Axelsson, Modeling and
    /// Experiment Design for Identification of Wear in a Robot Joint, 2014).
    pub(in crate::simulation::world) fn thinning(joint: usize, _course: &Course, random: &mut Draws) -> Self {
        SpeedFriction { joint, coefficient: 1.0, exponent: random.between(0.4, 0.7) }
    }

    fn name(&self) -> (&'static str, Vec<f64>) {
        match self.exponent {
            1.0 => ("viscous-friction", vec![self.coefficient]),
            2.0 => ("quadratic-drag", vec![self.coefficient]),
            exponent if exponent < 1.0 => ("concave-friction", vec![self.coefficient, exponent]),
            _ => ("thickening-grease", Vec::new()),
        }
    }
}

impl Install for SpeedFriction {
    fn install(&self, plan: &mut Plan) {
        let (name, parameters) = self.name();
        let slot = plan.hide(name, Some(self.joint), parameters);
        plan.act(slot, self.clone());
    }

    fn scale(&mut self, factor: f64) {
        self.coefficient *= factor;
    }

    fn place(&self) -> Option<usize> {
        Some(self.joint)
    }

    fn check(&self) -> Result<(), SimulationError> {
        sensible("speed friction's coefficient", self.coefficient)?;
        sensible("speed friction's exponent", self.exponent)
    }
}

impl Device for SpeedFriction {
    fn act(&mut self, now: &Moment, forces: &mut Forces) {
        let qd = now.qd[self.joint];
        forces.resist(self.joint, self.coefficient * qd.abs().powf(self.exponent) * qd.signum());
    }
}
