//! Dry friction with stiction and pre-sliding, perhaps with a Stribeck rise or different in the two directions.

use serde::{Deserialize, Serialize};

use super::bristle::Bristle;
use super::{Install, from_one, short_reach};
use crate::simulation::world::course::{Course, Draws};
use crate::simulation::world::moment::{Forces, Moment};
use crate::simulation::world::plan::{Device, Plan};
use crate::simulation::{SimulationError, demand, sensible};

/// Beyond this reach \[rad\] pre-sliding shows in the motion of an arm, so that it has a name of its own.
const LONG_REACH: f64 = 5e-3;

/// Dry friction on a joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DryFriction {
    /// Counted from 0 (from 1 in files).
    #[serde(with = "from_one")]
    pub joint: usize,
    /// While it slides fast \[N m\].
    pub torque: f64,
    /// How far it gives before it slides \[rad\].
    #[serde(default = "short_reach")]
    pub reach: f64,
    /// How much more it holds at rest \[N m\].
    #[serde(default)]
    pub stribeck_torque: f64,
    /// Velocity at which that has fallen to 1/e \[rad/s\].
    #[serde(default = "slow")]
    pub stribeck_velocity: f64,
    /// How much more it holds in the positive direction, and less in the other \[N m\].
    #[serde(default)]
    pub asymmetry: f64,
}

fn slow() -> f64 {
    0.1
}

/// Grease lets friction fall within a few hundredths to tenths of a rad/s (Bittencourt and Gunnarsson, JDSMC 134 (2012) 051013);
/// pre-sliding of geared joints is 0.1 to 1 mrad, of belts and cables 10 mrad and more (Al-Bender and Swevers, IEEE Control
/// Systems Magazine 28 (2008) 64).
impl DryFriction {
    pub(in crate::simulation::world) fn coulomb(joint: usize, _course: &Course, random: &mut Draws) -> Self {
        let reach = random.between_logarithms(1e-4, 1e-3);
        DryFriction { joint, torque: 1.0, reach, stribeck_torque: 0.0, stribeck_velocity: slow(), asymmetry: 0.0 }
    }

    pub(in crate::simulation::world) fn stribeck(joint: usize, course: &Course, random: &mut Draws) -> Self {
        let stribeck_torque = random.between(0.3, 1.2);
        let stribeck_velocity = course.speed(joint) * random.between(0.1, 0.5);
        DryFriction { stribeck_torque, stribeck_velocity, ..Self::coulomb(joint, course, random) }
    }

    pub(in crate::simulation::world) fn asymmetric(joint: usize, course: &Course, random: &mut Draws) -> Self {
        let asymmetry = random.between(0.2, 0.6) * random.sign();
        DryFriction { asymmetry, ..Self::coulomb(joint, course, random) }
    }

    pub(in crate::simulation::world) fn dahl(joint: usize, course: &Course, random: &mut Draws) -> Self {
        let reach = course.range(joint) * random.between_logarithms(0.01, 0.1);
        DryFriction { reach: reach.max(2.0 * LONG_REACH), ..Self::coulomb(joint, course, random) }
    }

    pub(in crate::simulation::world) fn lugre(joint: usize, course: &Course, random: &mut Draws) -> Self {
        DryFriction { reach: Self::dahl(joint, course, random).reach, ..Self::stribeck(joint, course, random) }
    }

    fn name(&self) -> (&'static str, Vec<f64>) {
        let ratio = self.stribeck_torque / self.torque;
        match (self.reach > LONG_REACH, self.stribeck_torque > 0.0) {
            (true, true) => ("lugre-friction", vec![self.torque, self.reach, ratio, self.stribeck_velocity]),
            (true, false) => ("dahl-hysteresis", vec![self.torque, self.reach]),
            (false, true) => ("stribeck-friction", vec![self.torque, self.stribeck_torque, self.stribeck_velocity]),
            (false, false) if self.asymmetry != 0.0 => ("asymmetric-friction", vec![self.torque, self.asymmetry]),
            (false, false) => ("coulomb-friction", vec![self.torque]),
        }
    }
}

struct Sliding {
    friction: DryFriction,
    bristle: Bristle,
}

impl Install for DryFriction {
    fn install(&self, plan: &mut Plan) {
        let (name, parameters) = self.name();
        let slot = plan.hide(name, Some(self.joint), parameters);
        plan.act(slot, Sliding { friction: self.clone(), bristle: Bristle::default() });
    }

    fn scale(&mut self, factor: f64) {
        self.torque *= factor;
        self.stribeck_torque *= factor;
        self.asymmetry *= factor;
    }

    fn place(&self) -> Option<usize> {
        Some(self.joint)
    }

    fn check(&self) -> Result<(), SimulationError> {
        sensible("dry friction's torque", self.torque)?;
        sensible("dry friction's reach", self.reach)?;
        sensible("dry friction's Stribeck velocity", self.stribeck_velocity)?;
        let rise = self.stribeck_torque;
        demand("dry friction's Stribeck torque", rise, rise >= 0.0, "0 or more")?;
        let allowed = self.asymmetry.abs() < self.torque;
        demand("dry friction's asymmetry", self.asymmetry, allowed, "less than its torque")
    }
}

impl Device for Sliding {
    fn act(&mut self, now: &Moment, forces: &mut Forces) {
        let friction = &self.friction;
        let qd = now.qd[friction.joint];
        let rise = friction.stribeck_torque * (-(qd / friction.stribeck_velocity).powi(2)).exp();
        let level = (friction.torque + rise + friction.asymmetry * qd.signum()) / friction.torque;
        let share = self.bristle.slide(qd, level, friction.reach, now.step);
        forces.resist(friction.joint, friction.torque * share);
    }
}
