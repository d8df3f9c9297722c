//! Dry friction that changes with the angle: a bent shaft, a worn place of the gear.

use serde::{Deserialize, Serialize};

use super::bristle::Bristle;
use super::{Install, from_one, short_reach};
use crate::simulation::world::course::{Course, Draws};
use crate::simulation::world::moment::{Forces, Moment};
use crate::simulation::world::plan::{Device, Plan};
use crate::simulation::{SimulationError, demand, sensible};

/// Friction of a joint with a wave over its angle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UnevenFriction {
    /// Counted from 0 (from 1 in files).
    #[serde(with = "from_one")]
    pub joint: usize,
    /// Mean \[N m\].
    pub torque: f64,
    /// Amplitude of the wave \[N m\].
    pub wave: f64,
    /// Radians of the wave over radians of the joint.
    pub wave_number: f64,
    /// Its phase at q = 0 \[rad\].
    #[serde(default)]
    pub phase: f64,
    /// How far it gives before it slides \[rad\].
    #[serde(default = "short_reach")]
    pub reach: f64,
}

impl UnevenFriction {
    /// One to five waves a turn, as eccentric shafts and wheels give them.
    pub(in crate::simulation::world) fn drawn(joint: usize, _course: &Course, random: &mut Draws) -> Self {
        UnevenFriction {
            joint,
            torque: 1.0,
            wave: random.between(0.4, 0.8),
            wave_number: random.between(1.0, 5.99).floor(),
            phase: random.between(0.0, std::f64::consts::TAU),
            reach: random.between_logarithms(1e-4, 1e-3),
        }
    }
}

/// The mean or the wave; both bend the same bristles in the same way.
struct Uneven {
    friction: UnevenFriction,
    bristle: Bristle,
    level: fn(&UnevenFriction, f64) -> f64,
}

impl Install for UnevenFriction {
    fn install(&self, plan: &mut Plan) {
        let (sin, cos) = self.phase.sin_cos();
        let mut add = |name, parameters, level| {
            let slot = plan.hide(name, Some(self.joint), parameters);
            plan.act(slot, Uneven { friction: self.clone(), bristle: Bristle::default(), level });
        };
        add("coulomb-friction", vec![self.torque], |friction, _| friction.torque);
        add("position-friction", vec![self.wave * cos, self.wave * sin, self.wave_number], |friction, q| {
            friction.wave * (friction.wave_number * q + friction.phase).sin()
        });
    }

    fn scale(&mut self, factor: f64) {
        self.torque *= factor;
        self.wave *= factor;
    }

    fn place(&self) -> Option<usize> {
        Some(self.joint)
    }

    fn check(&self) -> Result<(), SimulationError> {
        sensible("uneven friction's torque", self.torque)?;
        sensible("uneven friction's wave number", self.wave_number)?;
        sensible("uneven friction's reach", self.reach)?;
        demand("uneven friction's phase", self.phase, true, "a finite angle")?;
        demand("uneven friction's wave", self.wave, (0.0..=self.torque).contains(&self.wave), "0 to its torque")
    }
}

impl Device for Uneven {
    fn act(&mut self, now: &Moment, forces: &mut Forces) {
        let friction = &self.friction;
        let share = self.bristle.slide(now.qd[friction.joint], 1.0, friction.reach, now.step);
        forces.resist(friction.joint, (self.level)(friction, now.q[friction.joint]) * share);
    }
}
