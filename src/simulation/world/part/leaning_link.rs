//! A link whose centre of mass lies beside the line between its joints: a motor at its side, a bend.

use serde::{Deserialize, Serialize};

use super::{Install, from_one};
use crate::simulation::world::course::{Course, Draws};
use crate::simulation::world::moment::{Forces, Moment};
use crate::simulation::world::plan::{Device, Plan};
use crate::simulation::{SimulationError, demand};

/// The centre of mass of a link, beside its line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LeaningLink {
    /// Counted from 0 (from 1 in files).
    #[serde(with = "from_one")]
    pub link: usize,
    /// A quarter turn counter-clockwise from the line \[m\].
    pub beside: f64,
}

impl LeaningLink {
    pub(in crate::simulation::world) fn drawn(link: usize, _course: &Course, random: &mut Draws) -> Self {
        LeaningLink { link, beside: 0.01 * random.sign() }
    }
}

struct Beside {
    link: usize,
    mass: f64,
    com: f64,
    beside: f64,
}

impl Install for LeaningLink {
    fn install(&self, plan: &mut Plan) {
        let link = &plan.arm.links[self.link];
        let (mass, com) = (link.mass, link.com);
        let carried: f64 = plan.arm.links[self.link + 1..].iter().map(|link| link.mass).sum();
        let moment = mass * com + link.length * carried;
        let lean = plan.arm.posture.sign() * mass * self.beside / moment;
        let slot = plan.hide("com-offset", Some(self.link), vec![lean]);
        plan.beside[self.link] = self.beside;
        plan.act(slot, Beside { link: self.link, mass, com, beside: self.beside });
    }

    fn scale(&mut self, factor: f64) {
        self.beside *= factor;
    }

    fn place(&self) -> Option<usize> {
        Some(self.link)
    }

    fn check(&self) -> Result<(), SimulationError> {
        demand("leaning link's distance", self.beside, self.beside.abs() < 100.0, "a distance below 100 m")
    }
}

impl Device for Beside {
    fn act(&mut self, now: &Moment, forces: &mut Forces) {
        for (beside, factor) in [(self.beside, 1.0), (0.0, -1.0)] {
            let place = now.links[self.link].point([self.com, beside]);
            let force = now.need(self.mass, place.acceleration);
            forces.carry(now, self.link, place.at, [factor * force[0], factor * force[1]]);
        }
    }
}
