//! Dry friction that falls as its own heat warms the grease.

use serde::{Deserialize, Serialize};

use super::bristle::Bristle;
use super::{Install, from_one, short_reach};
use crate::simulation::world::course::{Course, Draws};
use crate::simulation::world::moment::{Forces, Moment};
use crate::simulation::world::plan::{Device, Plan};
use crate::simulation::{SimulationError, sensible};

/// Friction of a joint that is warmed by the power that it takes, and cools to what is around it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HeatingFriction {
    /// Counted from 0 (from 1 in files).
    #[serde(with = "from_one")]
    pub joint: usize,
    /// When it is hot \[N m\].
    pub torque: f64,
    /// How much more when it is cold \[N m\].
    pub cold_torque: f64,
    /// Heat that lets that fall to 1/e \[J\].
    pub heat: f64,
    /// Time in which it loses all but 1/e of its heat \[s\].
    pub cooling_time: f64,
    /// How far it gives before it slides \[rad\].
    #[serde(default = "short_reach")]
    pub reach: f64,
}

impl HeatingFriction {
    /// It cools within a tenth to a half of the run, and at the speed of the run it gets hot enough to show.
    pub(in crate::simulation::world) fn drawn(joint: usize, course: &Course, random: &mut Draws) -> Self {
        let (torque, cold_torque) = (1.0, random.between(0.5, 2.0));
        let cooling_time = course.duration() * random.between(0.1, 0.5);
        let power = course.speed(joint) * (torque + 0.5 * cold_torque);
        let heat = power * cooling_time / random.between(1.0, 3.0);
        let reach = random.between_logarithms(1e-4, 1e-3);
        HeatingFriction { joint, torque, cold_torque, heat, cooling_time, reach }
    }
}

/// A joint, and how many times [`HeatingFriction::heat`] it holds.
struct Heated {
    friction: HeatingFriction,
    bristle: Bristle,
    held: f64,
}

impl Install for HeatingFriction {
    /// The catalogue's formula counts the way, not the power: its parameters are not these.
    fn install(&self, plan: &mut Plan) {
        let slot = plan.hide("frictional-heating", Some(self.joint), Vec::new());
        plan.act(slot, Heated { friction: self.clone(), bristle: Bristle::default(), held: 0.0 });
    }

    fn scale(&mut self, factor: f64) {
        self.torque *= factor;
        self.cold_torque *= factor;
        self.heat *= factor;
    }

    fn place(&self) -> Option<usize> {
        Some(self.joint)
    }

    fn check(&self) -> Result<(), SimulationError> {
        sensible("heating friction's torque", self.torque)?;
        sensible("heating friction's cold torque", self.cold_torque)?;
        sensible("heating friction's heat", self.heat)?;
        sensible("heating friction's cooling time", self.cooling_time)?;
        sensible("heating friction's reach", self.reach)
    }
}

impl Device for Heated {
    fn act(&mut self, now: &Moment, forces: &mut Forces) {
        let friction = &self.friction;
        let qd = now.qd[friction.joint];
        let share = self.bristle.slide(qd, 1.0, friction.reach, now.step);
        let torque = (friction.torque + friction.cold_torque * (-self.held).exp()) * share;
        // What bends the bristles comes back; what is rubbed does not.
        let power = (torque * qd).max(0.0);
        self.held += now.step * (power / friction.heat - self.held / friction.cooling_time);
        forces.resist(friction.joint, torque);
    }
}
