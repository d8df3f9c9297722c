//! The controller of the arm: feed-forward with a model that is not quite right, and a PD controller for the rest.
//!
//! It works at every step of the world, as joint servos do at 10 kHz and more, so that what it holds between two moments is
//! nothing beside the motion.

use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

use super::transmission::Transmission;
use crate::arm::Arm;
use crate::simulation::{SimulationError, demand, sensible};

/// How the arm is made to follow its motion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Servo {
    /// Natural frequency of each joint's error, with the inertia of the outstretched arm \[Hz\].
    pub bandwidth: f64,
    /// Damping ratio of that.
    pub damping_ratio: f64,
    /// By how much the model's masses may be wrong, as a share of each: the feed-forward is not the truth.
    pub model_error: f64,
}

impl Default for Servo {
    fn default() -> Self {
        Servo { bandwidth: 5.0, damping_ratio: 0.8, model_error: 0.15 }
    }
}

impl Servo {
    pub(super) fn check(&self) -> Result<(), SimulationError> {
        sensible("servo's bandwidth", self.bandwidth)?;
        sensible("servo's damping ratio", self.damping_ratio)?;
        let error = self.model_error;
        demand("servo's model error", error, (0.0..1.0).contains(&error), "0 to 1")
    }
}

/// The controller at work.
pub(super) struct Controller {
    model: Arm,
    stiffness: Vec<f64>,
    damping: Vec<f64>,
}

impl Controller {
    /// For an arm whose masses it misjudges at random. A rotor by itself is light, so it can't bear the whole damping for a
    /// step of the world.
    pub(super) fn new<'a>(
        servo: &Servo,
        arm: &Arm,
        drives: impl Iterator<Item = &'a Transmission>,
        step: f64,
        random: &mut impl Rng,
    ) -> Self {
        let mut model = arm.clone();
        for link in &mut model.links {
            let factor = 1.0 + servo.model_error * random.random_range(-1.0..=1.0);
            link.mass *= factor;
            link.inertia *= factor;
        }
        let inertia = model.mass_matrix(&vec![0.0; arm.joint_count()]);
        let frequency = std::f64::consts::TAU * servo.bandwidth;
        let (mut stiffness, mut damping) = (Vec::new(), Vec::new());
        for (joint, drive) in drives.enumerate() {
            let whole = 2.0 * servo.damping_ratio * frequency * inertia[(joint, joint)];
            let borne = match drive {
                Transmission::Elastic(gear) => whole.min(0.5 * gear.inertia / step),
                Transmission::Direct | Transmission::Stiff { .. } => whole,
            };
            damping.push(borne);
            stiffness.push(borne * frequency / (2.0 * servo.damping_ratio));
        }
        Controller { model, stiffness, damping }
    }

    /// Torque of each joint \[N m\] to follow q, q̇, q̈ of `target` from where the encoders see it.
    pub(super) fn command(&self, target: &[Vec<f64>; 3], q: &[f64], qd: &[f64]) -> Vec<f64> {
        let [q_target, qd_target, qdd_target] = target;
        let mut torque = self.model.inverse_dynamics(q_target, qd_target, qdd_target);
        for (joint, torque) in torque.iter_mut().enumerate() {
            *torque += self.stiffness[joint] * (q_target[joint] - q[joint])
                + self.damping[joint] * (qd_target[joint] - qd[joint]);
        }
        torque
    }
}
