//! A gear that twists, with the rotor before it, and perhaps with play between its teeth.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use super::{Install, from_one};
use crate::recording::encoders::Side;
use crate::simulation::world::course::{Course, Draws};
use crate::simulation::world::moment::{Forces, Moment};
use crate::simulation::world::plan::{Device, Plan};
use crate::simulation::world::transmission::{Gear, Transmission};
use crate::simulation::{SimulationError, demand, sensible};

/// Below this ratio of rotor inertia to stiffness \[s²\] the twist can't be seen in the motion of an arm, and has no name: the
/// rotor swings at 40 Hz or faster.
const STIFF: f64 = 1.6e-5;

/// Rotor, elasticity and backlash of a joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ElasticGear {
    /// Counted from 0 (from 1 in files).
    #[serde(with = "from_one")]
    pub joint: usize,
    /// Of the rotor, times the gear ratio squared \[kg m²\].
    pub inertia: f64,
    /// \[N m/rad\]
    pub stiffness: f64,
    /// Damping ratio of the rotor while the link is held.
    #[serde(default = "metal")]
    pub damping_ratio: f64,
    /// Play between the teeth \[rad\].
    #[serde(default)]
    pub play: f64,
}

fn metal() -> f64 {
    0.05
}

/// Links of industrial arms swing on their gears at 5 to 20 Hz (Moberg, Modeling and Control of Flexible Manipulators, 2010);
/// play is a minute of arc in precision gears and half a degree in worn ones.
impl ElasticGear {
    pub(in crate::simulation::world) fn elastic(joint: usize, course: &Course, random: &mut Draws) -> Self {
        let stiffness = course.inertia(joint) * (TAU * random.between_logarithms(5.0, 15.0)).powi(2);
        ElasticGear { joint, inertia: 1.0, stiffness, damping_ratio: random.between(0.03, 0.15), play: 0.0 }
    }

    pub(in crate::simulation::world) fn with_play(joint: usize, course: &Course, random: &mut Draws) -> Self {
        let stiffness = course.inertia(joint) * (TAU * 25.0).powi(2);
        let play = random.between_logarithms(1e-3, 1e-2);
        ElasticGear { joint, inertia: 1.0, stiffness, damping_ratio: random.between(0.1, 0.3), play }
    }
}

impl Install for ElasticGear {
    fn install(&self, plan: &mut Plan) {
        let joint = Some(self.joint);
        let rotor = plan.hide("rotor-inertia", joint, vec![self.inertia]);
        plan.act(rotor, Rotating { joint: self.joint, inertia: self.inertia });
        let [loose, soft] = match plan.side {
            Side::Link => [("backlash", Vec::new()), ("joint-elasticity", vec![self.inertia / self.stiffness])],
            Side::Motor => {
                [("motor-side-backlash", vec![self.play]), ("motor-side-elasticity", vec![1.0 / self.stiffness])]
            }
        };
        let slot = if self.play > 0.0 {
            plan.hide(loose.0, joint, loose.1)
        } else if self.inertia > STIFF * self.stiffness {
            plan.hide(soft.0, joint, soft.1)
        } else {
            rotor
        };
        plan.joints[self.joint].transmission = Transmission::Elastic(Gear {
            inertia: self.inertia,
            stiffness: self.stiffness,
            damping: 2.0 * self.damping_ratio * (self.stiffness * self.inertia).sqrt(),
            play: self.play,
            slot,
            position: 0.0,
            velocity: 0.0,
            acceleration: 0.0,
        });
    }

    fn scale(&mut self, factor: f64) {
        self.inertia *= factor;
    }

    fn place(&self) -> Option<usize> {
        Some(self.joint)
    }

    fn check(&self) -> Result<(), SimulationError> {
        sensible("elastic gear's inertia", self.inertia)?;
        sensible("elastic gear's stiffness", self.stiffness)?;
        demand("elastic gear's damping ratio", self.damping_ratio, self.damping_ratio >= 0.0, "0 or more")?;
        demand("elastic gear's play", self.play, (0.0..1.0).contains(&self.play), "0 to 1 rad")
    }
}

/// What the rotor would need if it turned with the link.
struct Rotating {
    joint: usize,
    inertia: f64,
}

impl Device for Rotating {
    fn act(&mut self, now: &Moment, forces: &mut Forces) {
        forces.note(self.joint, self.inertia * now.qdd[self.joint]);
    }
}
