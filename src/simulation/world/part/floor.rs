//! A floor, or a wall, that the tip of the arm runs into.

use serde::{Deserialize, Serialize};

use super::Install;
use crate::simulation::world::course::{Course, Draws};
use crate::simulation::world::moment::{Forces, Moment, Planar};
use crate::simulation::world::plan::{Device, Obstacle, Plan, TIP_RADIUS};
use crate::simulation::{SimulationError, demand};

/// A half-plane that the tip can't enter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Floor {
    /// A point of its surface \[x, z\] \[m\].
    pub at: Planar,
    /// The direction that leads out of it, from +x towards +z \[rad\]; π/2 is a floor.
    #[serde(default = "upward")]
    pub facing: f64,
}

fn upward() -> f64 {
    std::f64::consts::FRAC_PI_2
}

impl Floor {
    /// A little above the lowest place of the tip.
    pub(in crate::simulation::world) fn drawn(_joint: usize, course: &Course, random: &mut Draws) -> Self {
        let [lowest, highest] = course.heights();
        let depth = (highest - lowest) * random.between(0.004, 0.015);
        Floor { at: [0.0, lowest + depth - TIP_RADIUS], facing: upward() }
    }
}

struct Touched;

impl Install for Floor {
    fn install(&self, plan: &mut Plan) {
        let slot = plan.hide("floor-contact", None, Vec::new());
        plan.obstacles.push(Obstacle { at: self.at, normal: [self.facing.cos(), self.facing.sin()] });
        plan.act(slot, Touched);
    }

    /// How hard it is touched is for the servo to decide.
    fn scale(&mut self, _factor: f64) {}

    fn check(&self) -> Result<(), SimulationError> {
        demand("floor's direction", self.facing, true, "a finite angle")?;
        self.at.iter().try_for_each(|place| demand("floor's place", *place, place.abs() < 1e3, "below 1 km"))
    }
}

impl Device for Touched {
    /// The contacts have pushed already; what they pushed is counted.
    fn act(&mut self, now: &Moment, forces: &mut Forces) {
        for (link, at, force) in &now.touches {
            forces.carry(now, *link, *at, [-force[0], -force[1]]);
        }
    }
}
