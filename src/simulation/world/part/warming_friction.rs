//! Dry friction that falls while the grease warms up.

use serde::{Deserialize, Serialize};

use super::bristle::Bristle;
use super::{Install, from_one, short_reach};
use crate::simulation::world::course::{Course, Draws};
use crate::simulation::world::moment::{Forces, Moment};
use crate::simulation::world::plan::{Device, Plan};
use crate::simulation::{SimulationError, sensible};

/// Friction of a joint that starts cold.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WarmingFriction {
    /// Counted from 0 (from 1 in files).
    #[serde(with = "from_one")]
    pub joint: usize,
    /// When it is warm \[N m\].
    pub torque: f64,
    /// How much more when it is cold \[N m\].
    pub cold_torque: f64,
    /// Time until that has fallen to 1/e \[s\].
    pub time: f64,
    /// How far it gives before it slides \[rad\].
    #[serde(default = "short_reach")]
    pub reach: f64,
}

impl WarmingFriction {
    /// Warming up takes from a tenth to a half of the run, so that it shows.
    pub(in crate::simulation::world) fn drawn(joint: usize, course: &Course, random: &mut Draws) -> Self {
        WarmingFriction {
            joint,
            torque: 1.0,
            cold_torque: random.between(0.5, 2.0),
            time: course.duration() * random.between(0.1, 0.5),
            reach: random.between_logarithms(1e-4, 1e-3),
        }
    }
}

struct Cooling {
    friction: WarmingFriction,
    bristle: Bristle,
}

impl Install for WarmingFriction {
    fn install(&self, plan: &mut Plan) {
        let parameters = vec![self.torque, self.cold_torque, self.time];
        let slot = plan.hide("friction-warm-up", Some(self.joint), parameters);
        plan.act(slot, Cooling { friction: self.clone(), bristle: Bristle::default() });
    }

    fn scale(&mut self, factor: f64) {
        self.torque *= factor;
        self.cold_torque *= factor;
    }

    fn place(&self) -> Option<usize> {
        Some(self.joint)
    }

    fn check(&self) -> Result<(), SimulationError> {
        sensible("warming friction's torque", self.torque)?;
        sensible("warming friction's cold torque", self.cold_torque)?;
        sensible("warming friction's time", self.time)?;
        sensible("warming friction's reach", self.reach)
    }
}

impl Device for Cooling {
    fn act(&mut self, now: &Moment, forces: &mut Forces) {
        let friction = &self.friction;
        let share = self.bristle.slide(now.qd[friction.joint], 1.0, friction.reach, now.step);
        let torque = friction.torque + friction.cold_torque * (-now.time.max(0.0) / friction.time).exp();
        forces.resist(friction.joint, torque * share);
    }
}
