//! A spring over two joints, as muscles and balancers have.

use serde::{Deserialize, Serialize};

use super::{Install, from_one};
use crate::simulation::world::course::{Course, Draws};
use crate::simulation::world::moment::{Forces, Moment};
use crate::simulation::world::plan::{Device, Plan};
use crate::simulation::{SimulationError, demand, sensible};

/// A spring from the link before the first of two joints to the link after the second.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BiarticularSpring {
    /// The second of its joints, counted from 0 (from 1 in files).
    #[serde(with = "from_one")]
    pub joint: usize,
    /// \[N m/rad\]
    pub stiffness: f64,
    /// The sum of both angles at which it is relaxed \[rad\].
    #[serde(default)]
    pub rest: f64,
}

impl BiarticularSpring {
    pub(in crate::simulation::world) fn drawn(joint: usize, course: &Course, random: &mut Draws) -> Self {
        let joint = joint.max(1);
        let middle = course.middle(joint - 1) + course.middle(joint);
        BiarticularSpring { joint, stiffness: 1.0, rest: middle + random.between(-0.5, 0.5) }
    }
}

impl Install for BiarticularSpring {
    fn install(&self, plan: &mut Plan) {
        let slot = plan.hide("biarticular", None, Vec::new());
        plan.act(slot, self.clone());
    }

    fn scale(&mut self, factor: f64) {
        self.stiffness *= factor;
    }

    fn place(&self) -> Option<usize> {
        Some(self.joint)
    }

    fn check(&self) -> Result<(), SimulationError> {
        demand("biarticular spring's joint", self.joint as f64 + 1.0, self.joint > 0, "2 or more")?;
        demand("biarticular spring's rest", self.rest, true, "a finite angle")?;
        sensible("biarticular spring's stiffness", self.stiffness)
    }
}

impl Device for BiarticularSpring {
    fn act(&mut self, now: &Moment, forces: &mut Forces) {
        let torque = self.stiffness * (now.q[self.joint - 1] + now.q[self.joint] - self.rest);
        forces.resist(self.joint - 1, torque);
        forces.resist(self.joint, torque);
    }
}
