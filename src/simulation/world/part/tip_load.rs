//! A payload at the tip, all the time or picked up and put down.

use serde::{Deserialize, Serialize};

use super::Install;
use crate::simulation::world::course::{Course, Draws};
use crate::simulation::world::moment::{Forces, Moment};
use crate::simulation::world::plan::{self, Device, Plan};
use crate::simulation::{SimulationError, demand, sensible};

/// A point mass at the tip.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TipLoad {
    /// \[kg\]
    pub mass: f64,
    /// From when until when it is carried \[s\]; all the time where it is left out.
    #[serde(default)]
    pub during: Option<[f64; 2]>,
}

impl TipLoad {
    /// For a third to two thirds of the run.
    pub(in crate::simulation::world) fn picked_up(_joint: usize, course: &Course, random: &mut Draws) -> Self {
        let begin = random.between(0.1, 0.4) * course.duration();
        let end = begin + random.between(0.3, 0.6) * course.duration();
        TipLoad { mass: 1.0, during: Some([begin, end]) }
    }
}

impl Install for TipLoad {
    fn install(&self, plan: &mut Plan) {
        let slot = match self.during {
            None => plan.hide("tip-payload", None, vec![self.mass]),
            Some(_) => plan.hide("payload-picked-up", None, Vec::new()),
        };
        let load = plan::TipLoad { mass: self.mass, during: self.during.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]) };
        plan.tip_loads.push(load);
        plan.act(slot, load);
    }

    fn scale(&mut self, factor: f64) {
        self.mass *= factor;
    }

    fn check(&self) -> Result<(), SimulationError> {
        sensible("tip load's mass", self.mass)?;
        let [begin, end] = self.during.unwrap_or([0.0, 1.0]);
        demand("tip load's end", end, begin < end && begin.is_finite(), "after its beginning")
    }
}

impl Device for plan::TipLoad {
    fn act(&mut self, now: &Moment, forces: &mut Forces) {
        if let Some((link, state)) = now.links.iter().enumerate().next_back()
            && self.is_carried(now.time)
        {
            let place = state.point(now.tip());
            forces.carry(now, link, place.at, now.need(self.mass, place.acceleration));
        }
    }
}
