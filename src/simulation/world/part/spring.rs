//! A spring in a joint: a balancer, a cable bundle that bends.

use serde::{Deserialize, Serialize};

use super::{Install, from_one};
use crate::simulation::world::course::{Course, Draws};
use crate::simulation::world::moment::{Forces, Moment};
use crate::simulation::world::plan::{Device, Plan};
use crate::simulation::{SimulationError, demand};

/// A spring between a link and the one before it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spring {
    /// Counted from 0 (from 1 in files).
    #[serde(with = "from_one")]
    pub joint: usize,
    /// \[N m/rad\]
    #[serde(default)]
    pub stiffness: f64,
    /// \[N m/rad³\]
    #[serde(default)]
    pub cubic_stiffness: f64,
    /// Angle at which it is relaxed \[rad\].
    #[serde(default)]
    pub rest: f64,
}

impl Spring {
    /// Relaxed somewhere in the middle half of the motion.
    pub(in crate::simulation::world) fn linear(joint: usize, course: &Course, random: &mut Draws) -> Self {
        let rest = course.middle(joint) + course.range(joint) * random.between(-0.25, 0.25);
        Spring { joint, stiffness: 1.0, cubic_stiffness: 0.0, rest }
    }

    pub(in crate::simulation::world) fn hardening(joint: usize, _course: &Course, _random: &mut Draws) -> Self {
        Spring { joint, stiffness: 0.0, cubic_stiffness: 1.0, rest: 0.0 }
    }
}

impl Install for Spring {
    fn install(&self, plan: &mut Plan) {
        let joint = Some(self.joint);
        if self.stiffness != 0.0 {
            let slot = plan.hide("joint-spring", joint, vec![self.stiffness, -self.stiffness * self.rest]);
            plan.act(slot, Spring { cubic_stiffness: 0.0, ..self.clone() });
        }
        if self.cubic_stiffness != 0.0 {
            let parameters = if self.rest == 0.0 { vec![self.cubic_stiffness] } else { Vec::new() };
            let slot = plan.hide("hardening-spring", joint, parameters);
            plan.act(slot, Spring { stiffness: 0.0, ..self.clone() });
        }
    }

    fn scale(&mut self, factor: f64) {
        self.stiffness *= factor;
        self.cubic_stiffness *= factor;
    }

    fn place(&self) -> Option<usize> {
        Some(self.joint)
    }

    fn check(&self) -> Result<(), SimulationError> {
        for (what, value) in
            [("spring's stiffness", self.stiffness), ("spring's cubic stiffness", self.cubic_stiffness)]
        {
            demand(what, value, (0.0..1e6).contains(&value), "0 to 1e6 (SI units)")?;
        }
        demand("spring's rest", self.rest, true, "a finite angle")
    }
}

impl Device for Spring {
    fn act(&mut self, now: &Moment, forces: &mut Forces) {
        let angle = now.q[self.joint] - self.rest;
        forces.resist(self.joint, self.stiffness * angle + self.cubic_stiffness * angle.powi(3));
    }
}
