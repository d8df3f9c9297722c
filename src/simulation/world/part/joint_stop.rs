//! The end of a joint's way: a rubber buffer.

use serde::{Deserialize, Serialize};

use super::{Install, from_one};
use crate::simulation::world::course::{Course, Draws};
use crate::simulation::world::moment::{Forces, Moment};
use crate::simulation::world::plan::{Device, Plan};
use crate::simulation::{SimulationError, demand, sensible};

/// A buffer that a joint runs into, at one end of its way or at both.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointStop {
    /// Counted from 0 (from 1 in files).
    #[serde(with = "from_one")]
    pub joint: usize,
    /// Angle at which the lower buffer begins \[rad\].
    #[serde(default)]
    pub low: Option<f64>,
    /// Angle at which the upper buffer begins \[rad\].
    #[serde(default)]
    pub high: Option<f64>,
    /// \[N m/rad\]
    pub stiffness: f64,
    /// \[N m s/rad\]
    #[serde(default)]
    pub damping: f64,
}

impl JointStop {
    /// In the last fifth of the way, which is where buffers are; their rubber loses a tenth to a third of a blow.
    pub(in crate::simulation::world) fn drawn(joint: usize, course: &Course, random: &mut Draws) -> Self {
        let inset = course.range(joint) * random.between(0.08, 0.2);
        let [least, most] = course.ends(joint);
        let (low, high) = match random.sign() {
            1.0 => (None, Some(most - inset)),
            _ => (Some(least + inset), None),
        };
        JointStop { joint, low, high, stiffness: 1.0, damping: 0.01 }
    }
}

impl Install for JointStop {
    fn install(&self, plan: &mut Plan) {
        let sides = [("upper-stop", None, self.high), ("lower-stop", self.low, None)];
        for (effect, low, high) in sides {
            if let Some(place) = low.or(high) {
                let slot = plan.hide(effect, Some(self.joint), vec![self.stiffness, place]);
                plan.act(slot, JointStop { low, high, ..self.clone() });
            }
        }
    }

    fn scale(&mut self, factor: f64) {
        self.stiffness *= factor;
        self.damping *= factor;
    }

    fn place(&self) -> Option<usize> {
        Some(self.joint)
    }

    fn check(&self) -> Result<(), SimulationError> {
        sensible("joint stop's stiffness", self.stiffness)?;
        demand("joint stop's damping", self.damping, self.damping >= 0.0, "0 or more")?;
        let [low, high] = [self.low.unwrap_or(-1e6), self.high.unwrap_or(1e6)];
        demand("joint stop's upper end", high, low < high && low.is_finite(), "above its lower end")
    }
}

impl Device for JointStop {
    fn act(&mut self, now: &Moment, forces: &mut Forces) {
        let (q, qd) = (now.q[self.joint], now.qd[self.joint]);
        let [low, high] = [self.low.unwrap_or(f64::NEG_INFINITY), self.high.unwrap_or(f64::INFINITY)];
        let depth = q - q.clamp(low, high);
        if depth != 0.0 {
            // A buffer pushes, it doesn't pull.
            let torque = self.stiffness * depth + self.damping * qd;
            forces.resist(self.joint, if torque * depth > 0.0 { torque } else { 0.0 });
        }
    }
}
