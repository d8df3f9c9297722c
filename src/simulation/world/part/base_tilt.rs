//! A base that does not stand upright.

use serde::{Deserialize, Serialize};

use super::Install;
use crate::simulation::world::course::{Course, Draws};
use crate::simulation::world::moment::{Forces, Moment, turn};
use crate::simulation::world::plan::{Device, Plan};
use crate::simulation::{SimulationError, demand};

/// The whole arm leans.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BaseTilt {
    /// From +x towards +z \[rad\].
    pub angle: f64,
}

impl BaseTilt {
    pub(in crate::simulation::world) fn drawn(_joint: usize, _course: &Course, random: &mut Draws) -> Self {
        BaseTilt { angle: 0.05 * random.sign() }
    }
}

/// The weights of the links, as they are and as they would be on a base that stands upright.
struct Leaning {
    angle: f64,
    /// Mass \[kg\] and distance of its centre from the joint \[m\] of each link.
    links: Vec<(f64, f64)>,
}

impl Install for BaseTilt {
    fn install(&self, plan: &mut Plan) {
        let slot = plan.hide("base-tilt", None, vec![self.angle]);
        plan.tilt = self.angle;
        let links = plan.arm.links.iter().map(|link| (link.mass, link.com)).collect();
        plan.act(slot, Leaning { angle: self.angle, links });
    }

    fn scale(&mut self, factor: f64) {
        self.angle *= factor;
    }

    fn is_plausible(&self) -> bool {
        self.angle.abs() <= 0.2
    }

    fn check(&self) -> Result<(), SimulationError> {
        demand("base tilt's angle", self.angle, self.angle.abs() <= 0.5, "at most 0.5 rad")
    }
}

impl Device for Leaning {
    fn act(&mut self, now: &Moment, forces: &mut Forces) {
        let (sin, cos) = self.angle.sin_cos();
        for (link, (mass, com)) in self.links.iter().enumerate() {
            let at = now.links[link].point([*com, 0.0]).at;
            let weight = now.weight(*mass);
            // Seen from the leaning arm, the upright base's weight leans with it.
            let upright = turn([cos, sin], weight);
            forces.carry(now, link, at, [weight[0] - upright[0], weight[1] - upright[1]]);
        }
    }
}
