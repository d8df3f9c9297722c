//! A payload that swings below the tip: a tool on a hook, a hose.

use serde::{Deserialize, Serialize};

use super::Install;
use crate::simulation::world::course::{Course, Draws};
use crate::simulation::world::moment::{Forces, Moment};
use crate::simulation::world::plan::{Device, Freedom, Plan, RiderPlan};
use crate::simulation::{SimulationError, demand, sensible};

/// A mass that hangs from the tip.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pendulum {
    /// \[kg\]
    pub mass: f64,
    /// \[m\]
    pub length: f64,
    /// \[N m s/rad\]
    #[serde(default)]
    pub damping: f64,
}

impl Pendulum {
    /// Short enough to swing at 0.8 to 1.6 Hz.
    pub(in crate::simulation::world) fn drawn(_joint: usize, _course: &Course, random: &mut Draws) -> Self {
        Pendulum { mass: 1.0, length: random.between(0.1, 0.4), damping: 0.01 }
    }
}

struct Hanging {
    mass: f64,
    rider: usize,
}

impl Install for Pendulum {
    fn install(&self, plan: &mut Plan) {
        let slot = plan.hide("pendulum", None, Vec::new());
        let link = plan.arm.joint_count() - 1;
        let freedom = Freedom::Swings { length: self.length, damping: self.damping };
        let place = [plan.arm.links[link].length, 0.0];
        plan.riders.push(RiderPlan { mass: self.mass, link, place, freedom });
        plan.act(slot, Hanging { mass: self.mass, rider: plan.riders.len() - 1 });
    }

    fn scale(&mut self, factor: f64) {
        self.mass *= factor;
        self.damping *= factor;
    }

    fn check(&self) -> Result<(), SimulationError> {
        sensible("pendulum's mass", self.mass)?;
        sensible("pendulum's length", self.length)?;
        demand("pendulum's damping", self.damping, self.damping >= 0.0, "0 or more")
    }
}

impl Device for Hanging {
    /// The hook passes on what the hanging mass needs. Where its motion is not known it is taken for a mass at the hook.
    fn act(&mut self, now: &Moment, forces: &mut Forces) {
        let Some((link, state)) = now.links.iter().enumerate().next_back() else { return };
        let hook = state.point(now.tip());
        let acceleration = now.riders.get(self.rider).map_or(hook.acceleration, |rider| rider.acceleration);
        forces.carry(now, link, hook.at, now.need(self.mass, acceleration));
    }
}
