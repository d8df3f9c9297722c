//! Dry friction that grows with the torque that the joint transmits: the pressure on teeth and bearings.

use serde::{Deserialize, Serialize};

use super::bristle::Bristle;
use super::{Install, from_one, short_reach};
use crate::simulation::world::course::{Course, Draws};
use crate::simulation::world::moment::{Forces, Moment};
use crate::simulation::world::plan::{Device, Plan};
use crate::simulation::{SimulationError, sensible};

/// Load-dependent friction on a joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadFriction {
    /// Counted from 0 (from 1 in files).
    #[serde(with = "from_one")]
    pub joint: usize,
    /// Friction over transmitted torque.
    pub ratio: f64,
    /// How far it gives before it slides \[rad\].
    #[serde(default = "short_reach")]
    pub reach: f64,
}

impl LoadFriction {
    pub(in crate::simulation::world) fn drawn(joint: usize, _course: &Course, random: &mut Draws) -> Self {
        LoadFriction { joint, ratio: 0.1, reach: random.between_logarithms(1e-4, 1e-3) }
    }
}

struct Pressed {
    friction: LoadFriction,
    bristle: Bristle,
}

impl Install for LoadFriction {
    fn install(&self, plan: &mut Plan) {
        let slot = plan.hide("load-friction", Some(self.joint), vec![self.ratio]);
        plan.act(slot, Pressed { friction: self.clone(), bristle: Bristle::default() });
    }

    fn scale(&mut self, factor: f64) {
        self.ratio *= factor;
    }

    fn place(&self) -> Option<usize> {
        Some(self.joint)
    }

    fn is_plausible(&self) -> bool {
        self.ratio <= 0.3
    }

    fn check(&self) -> Result<(), SimulationError> {
        sensible("load friction's ratio", self.ratio)?;
        sensible("load friction's reach", self.reach)
    }
}

impl Device for Pressed {
    fn act(&mut self, now: &Moment, forces: &mut Forces) {
        let LoadFriction { joint, ratio, reach } = self.friction;
        let share = self.bristle.slide(now.qd[joint], 1.0, reach, now.step);
        forces.resist(joint, ratio * now.sent[joint].abs() * share);
    }
}
