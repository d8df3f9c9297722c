//! A mass that slides in the last link on a spring: a liquid in a vessel, a loose tool.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use super::Install;
use crate::simulation::world::course::{Course, Draws};
use crate::simulation::world::moment::{Forces, Moment};
use crate::simulation::world::plan::{Device, Freedom, Plan, RiderPlan};
use crate::simulation::{SimulationError, demand, sensible};

/// A mass on a spring along the last link.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sloshing {
    /// \[kg\]
    pub mass: f64,
    /// Its own frequency \[Hz\].
    pub frequency: f64,
    /// Damping ratio of that.
    #[serde(default)]
    pub damping_ratio: f64,
}

impl Sloshing {
    /// The first mode of a liquid in a vessel of 5 to 30 cm (Ibrahim, Liquid Sloshing Dynamics, 2005).
    pub(in crate::simulation::world) fn drawn(_joint: usize, _course: &Course, random: &mut Draws) -> Self {
        Sloshing { mass: 1.0, frequency: random.between(1.5, 4.0), damping_ratio: random.between(0.02, 0.1) }
    }
}

struct Sliding {
    mass: f64,
    rider: usize,
    place: [f64; 2],
}

impl Install for Sloshing {
    fn install(&self, plan: &mut Plan) {
        let slot = plan.hide("slosh", None, Vec::new());
        let link = plan.arm.joint_count() - 1;
        let place = [plan.arm.links[link].length, 0.0];
        let stiffness = self.mass * (TAU * self.frequency).powi(2);
        let damping = 2.0 * self.damping_ratio * (stiffness * self.mass).sqrt();
        plan.riders.push(RiderPlan { mass: self.mass, link, place, freedom: Freedom::Slides { stiffness, damping } });
        plan.act(slot, Sliding { mass: self.mass, rider: plan.riders.len() - 1, place });
    }

    fn scale(&mut self, factor: f64) {
        self.mass *= factor;
    }

    fn check(&self) -> Result<(), SimulationError> {
        sensible("sloshing's mass", self.mass)?;
        sensible("sloshing's frequency", self.frequency)?;
        demand("sloshing's damping ratio", self.damping_ratio, self.damping_ratio >= 0.0, "0 or more")
    }
}

impl Device for Sliding {
    /// The vessel passes on what the mass needs, where the mass is.
    fn act(&mut self, now: &Moment, forces: &mut Forces) {
        let Some((link, state)) = now.links.iter().enumerate().next_back() else { return };
        let resting = state.point(self.place);
        let (at, acceleration) = now
            .riders
            .get(self.rider)
            .map_or((resting.at, resting.acceleration), |rider| (rider.at, rider.acceleration));
        forces.carry(now, link, at, now.need(self.mass, acceleration));
    }
}
