//! A plate on a link that the air, or water, holds back: its drag goes by the speed against the room, not by a joint's.

use serde::{Deserialize, Serialize};

use super::{Install, from_one};
use crate::simulation::world::course::{Course, Draws};
use crate::simulation::world::moment::{Forces, Moment};
use crate::simulation::world::plan::{Device, Plan};
use crate::simulation::{SimulationError, sensible};

/// A plate along a link, two thirds out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DragPlate {
    /// Counted from 0 (from 1 in files).
    #[serde(with = "from_one")]
    pub link: usize,
    /// Drag at 1 m/s across the plate \[N\].
    pub drag: f64,
}

impl DragPlate {
    pub(in crate::simulation::world) fn drawn(_joint: usize, course: &Course, _random: &mut Draws) -> Self {
        DragPlate { link: course.joint_count() - 1, drag: 1.0 }
    }
}

struct Plate {
    link: usize,
    place: [f64; 2],
    drag: f64,
}

impl Install for DragPlate {
    fn install(&self, plan: &mut Plan) {
        let slot = plan.hide("plate", None, Vec::new());
        let place = [2.0 / 3.0 * plan.arm.links[self.link].length, 0.0];
        plan.act(slot, Plate { link: self.link, place, drag: self.drag });
    }

    fn scale(&mut self, factor: f64) {
        self.drag *= factor;
    }

    fn place(&self) -> Option<usize> {
        Some(self.link)
    }

    fn check(&self) -> Result<(), SimulationError> {
        sensible("drag plate's drag", self.drag)
    }
}

impl Device for Plate {
    fn act(&mut self, now: &Moment, forces: &mut Forces) {
        let state = &now.links[self.link];
        let place = state.point(self.place);
        let across = [-state.axis()[1], state.axis()[0]];
        let speed = place.velocity[0] * across[0] + place.velocity[1] * across[1];
        let drag = -self.drag * speed * speed.abs();
        forces.push(self.link, place.at, [drag * across[0], drag * across[1]]);
    }
}
