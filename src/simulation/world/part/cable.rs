//! A cable or hose from the ceiling to a link, which pulls when it is tight.

use serde::{Deserialize, Serialize};

use super::{Install, from_one};
use crate::simulation::world::course::{Course, Draws};
use crate::simulation::world::moment::{Forces, Moment, Planar};
use crate::simulation::world::plan::{Device, Plan};
use crate::simulation::{SimulationError, demand, sensible};

/// A cable between a fixed point and the end of a link.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cable {
    /// Counted from 0 (from 1 in files).
    #[serde(with = "from_one")]
    pub link: usize,
    /// Where it is fixed \[x, z\] \[m\].
    pub anchor: Planar,
    /// How long it is when it just isn't tight \[m\].
    pub length: f64,
    /// \[N/m\]
    pub stiffness: f64,
}

impl Cable {
    /// From above the base; tight for a half of the way between the nearest and the farthest place of the link's end.
    pub(in crate::simulation::world) fn drawn(_joint: usize, course: &Course, random: &mut Draws) -> Self {
        let link = course.joint_count() - 1;
        let anchor = [random.between(-0.3, 0.3), course.reach() * random.between(0.6, 1.2)];
        let [nearest, farthest] = course.distances(link, anchor);
        let length = nearest + (farthest - nearest) * random.between(0.3, 0.6);
        Cable { link, anchor, length, stiffness: 1.0 }
    }
}

struct Pulling {
    cable: Cable,
    end: Planar,
}

impl Install for Cable {
    fn install(&self, plan: &mut Plan) {
        let slot = plan.hide("cable", None, Vec::new());
        let end = [plan.arm.links[self.link].length, 0.0];
        plan.act(slot, Pulling { cable: self.clone(), end });
    }

    fn scale(&mut self, factor: f64) {
        self.stiffness *= factor;
    }

    fn place(&self) -> Option<usize> {
        Some(self.link)
    }

    fn check(&self) -> Result<(), SimulationError> {
        sensible("cable's length", self.length)?;
        sensible("cable's stiffness", self.stiffness)?;
        self.anchor.iter().try_for_each(|place| demand("cable's anchor", *place, place.abs() < 1e3, "below 1 km"))
    }
}

impl Device for Pulling {
    fn act(&mut self, now: &Moment, forces: &mut Forces) {
        let Cable { link, anchor, length, stiffness } = self.cable;
        let at = now.links[link].point(self.end).at;
        let way = [anchor[0] - at[0], anchor[1] - at[1]];
        let distance = way[0].hypot(way[1]);
        if distance > length {
            let pull = stiffness * (distance - length) / distance;
            forces.push(link, at, [pull * way[0], pull * way[1]]);
        }
    }
}
