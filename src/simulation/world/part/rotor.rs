//! A rotor that turns with the joint behind a stiff gear.

use serde::{Deserialize, Serialize};

use super::{Install, from_one};
use crate::simulation::world::course::{Course, Draws};
use crate::simulation::world::moment::{Forces, Moment};
use crate::simulation::world::plan::{Device, Plan};
use crate::simulation::world::transmission::Transmission;
use crate::simulation::{SimulationError, sensible};

/// The inertia of a rotor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rotor {
    /// Counted from 0 (from 1 in files).
    #[serde(with = "from_one")]
    pub joint: usize,
    /// Times the gear ratio squared \[kg m²\].
    pub inertia: f64,
}

impl Rotor {
    pub(in crate::simulation::world) fn drawn(joint: usize, _course: &Course, _random: &mut Draws) -> Self {
        Rotor { joint, inertia: 1.0 }
    }
}

impl Install for Rotor {
    fn install(&self, plan: &mut Plan) {
        let slot = plan.hide("rotor-inertia", Some(self.joint), vec![self.inertia]);
        plan.joints[self.joint].transmission = Transmission::Stiff { inertia: self.inertia };
        plan.act(slot, self.clone());
    }

    fn scale(&mut self, factor: f64) {
        self.inertia *= factor;
    }

    fn place(&self) -> Option<usize> {
        Some(self.joint)
    }

    fn check(&self) -> Result<(), SimulationError> {
        sensible("rotor's inertia", self.inertia)
    }
}

impl Device for Rotor {
    fn act(&mut self, now: &Moment, forces: &mut Forces) {
        forces.note(self.joint, self.inertia * now.qdd[self.joint]);
    }
}
