//! Recordings made from an arm, a motion, hidden effects and sensors, so that the truth is known.
//!
//! The motion is given and the torque that it needs is computed, so position, velocity, acceleration and torque are exact
//! before the sensors read them (and perhaps misread them):
//!
//! ```text
//! τ = H(q) q̈ + c(q, q̇) + g(q) + Σ effects(q, q̇, q̈) + noise
//! ```
//!
//! What was hidden goes into the recording's [`Seal`]. The same scenario gives the same recording.

mod excitation;
pub mod extrapolation;
mod hidden;
mod mystery;
mod sensor;
mod strength;
pub mod world;
mod written;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

pub use excitation::Excitation;
pub use hidden::TrueParts;
pub use mystery::{Level, Making};
pub use strength::Strength;

use crate::arm::{Arm, ArmError, GRAVITY, Link, Posture};
use crate::effect::registry::UnknownEffect;
use crate::effect::{Effect, NotApplicable, ParameterError};
use crate::progress::{Monitor, Stopped};
use crate::recording::seal::{HiddenEffect, Seal, Truth};
use crate::recording::torque::TorqueFacts;
use crate::recording::{Channels, Joint, Provenance, Recording, Trajectory};
use crate::signals::{ShapeError, Signals};
use hidden::Hidden;

/// What is simulated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Name of the recording.
    #[serde(default = "default_name")]
    pub name: String,
    /// The arm that moves.
    pub arm: Arm,
    /// How it is moved.
    pub motion: Excitation,
    /// How many times as fast the same paths are travelled; 1 is as the motion states.
    #[serde(default = "unchanged")]
    pub speed_scale: f64,
    /// What the torque holds besides the arm's; in files with joints counted from 1, such as
    /// `{ effect = "viscous-friction@1,2", parameters = [0.8] }`.
    #[serde(default, with = "written")]
    pub effects: Vec<HiddenEffect>,
    /// Standard deviation of the Gaussian torque noise, as a fraction of each joint's torque RMS: 0.02 is 2 %.
    #[serde(default)]
    pub torque_noise: f64,
    /// Steps of the encoders \[rad\]. Where it is set, only rounded positions are measured, and velocity and acceleration
    /// are derived from them; else all three are exact.
    #[serde(default)]
    pub encoder_resolution: Option<f64>,
    /// Seed of all random draws.
    #[serde(default)]
    pub seed: u64,
    /// Whether the recording states the arm. Its posture is always stated.
    #[serde(default = "stated")]
    pub stated: bool,
}

/// The scenario can't be simulated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SimulationError {
    /// The arm can't exist.
    #[error("the scenario's arm can't exist: {0}")]
    Arm(#[from] ArmError),
    /// Parts of a motion that do not fit together.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// A number is out of its range.
    #[error("the scenario's {what} is {value}, but must be {must}")]
    Value {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        must: &'static str,
    },
    /// The motion is for another number of joints.
    #[error(
        "the scenario's motion states the space of {space} joints, the arm has {joints}: give one range for each joint"
    )]
    Space {
        /// Joints of the motion.
        space: usize,
        /// Joints of the arm.
        joints: usize,
    },
    /// The recording would fill the memory.
    #[error(
        "the scenario has {samples:e} samples, at most {most:e} are simulated: make it shorter or sample it less often"
    )]
    TooLarge {
        /// How many it asks for, of all trajectories together.
        samples: f64,
        /// How many there may be.
        most: f64,
    },
    /// A hidden effect is not in the registry.
    #[error("hidden effect: {0}")]
    UnknownEffect(#[from] UnknownEffect),
    /// A hidden effect has wrong parameters.
    #[error("hidden effect: {0}")]
    Parameter(#[from] ParameterError),
    /// A hidden effect can't be computed for this arm.
    #[error("hidden effect: {0}")]
    NotApplicable(#[from] NotApplicable),
    /// A hidden effect acts on a joint that the arm lacks.
    #[error("{effect} is to act on joint {joint}, but the arm has {joints}: choose a joint from 1 to {joints}")]
    NoSuchJoint {
        /// Name of the effect.
        effect: &'static str,
        /// Counted from 1.
        joint: usize,
        /// How many there are.
        joints: usize,
    },
    /// An effect of one joint has none.
    #[error("{0} acts on one joint: say on which joint, such as `@1`")]
    JointMissing(&'static str),
    /// An effect of the whole arm has a joint.
    #[error("{0} acts on the whole arm: leave out the joint")]
    JointOnWholeArm(&'static str),
    /// What would have to be late is not measured.
    #[error(
        "{0} is about measured velocities, but the scenario's encoders leave them to be derived from the positions: leave out \
         the resolution of the encoders, or the effect"
    )]
    NotMeasured(&'static str),
    /// The wanted strength can't be reached.
    #[error(
        "{effect} can't be given a strength on {}: it, or the arm, has no torque there in this motion. Let the joint move, \
         or choose another",
        joint.map_or_else(|| "the whole arm".to_owned(), |joint| format!("joint {}", joint + 1))
    )]
    NoTorque {
        /// Name of the effect.
        effect: &'static str,
        /// Counted from 0; `None` for the whole arm.
        joint: Option<usize>,
    },
    /// A part of a world can't be on a joint.
    #[error("{part} can't be on joint {joint}: choose a joint from {first} to {joints}")]
    NotThere {
        /// Name of the part.
        part: &'static str,
        /// Counted from 1.
        joint: usize,
        /// The first that can have it, counted from 1.
        first: usize,
        /// How many there are.
        joints: usize,
    },
    /// A link that an engine can't turn.
    #[error(
        "link {link} has no moment of inertia about its centre, but a world of rigid bodies needs one above 0 kg m²"
    )]
    NoInertia {
        /// Counted from 1.
        link: usize,
    },
    /// Two gears in one joint.
    #[error("joint {joint} has two parts that are its rotor (`rotor`, `elastic-gear`): leave one out")]
    TwoGears {
        /// Counted from 1.
        joint: usize,
    },
    /// The engine can't hold the arm together.
    #[error("the engine could not join the links of the world's arm")]
    Engine,
    /// The motion ran away.
    #[error(
        "the world's motion ran away from every number: its servo can't hold the arm. Give it a lower bandwidth, stiffer \
         gears, or a shorter step"
    )]
    Diverged,
    /// There is nothing to draw from.
    #[error("no effect is known that could be hidden")]
    EmptyRegistry,
    /// Somebody asked for a stop.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl Scenario {
    /// The demonstration: a three-joint arm that stands upright at q = 0, with dry friction in its first two joints.
    ///
    /// 12 runs of 8 s at 100 Hz, 2 % torque noise.
    pub fn embedded() -> Self {
        let coulomb = |joint, torque| HiddenEffect {
            effect: "coulomb-friction".to_owned(),
            joint: Some(joint),
            parameters: vec![torque],
        };
        Scenario {
            name: "three-joint demo".to_owned(),
            arm: Arm {
                links: vec![
                    Link { mass: 4.2, length: 0.40, com: 0.17, inertia: 0.060 },
                    Link { mass: 2.6, length: 0.34, com: 0.15, inertia: 0.028 },
                    Link { mass: 1.1, length: 0.20, com: 0.09, inertia: 0.004 },
                ],
                gravity: GRAVITY,
                posture: Posture::UP,
            },
            motion: Excitation::MultiSine {
                trajectories: 12,
                duration: 8.0,
                rate: 100.0,
                harmonics: 5,
                lowest_frequency: 0.1,
                highest_frequency: 1.0,
                max_position: 2.0,
                max_velocity: 3.5,
            },
            speed_scale: 1.0,
            effects: vec![coulomb(0, 2.4), coulomb(1, 1.1)],
            torque_noise: 0.02,
            encoder_resolution: None,
            seed: 1,
            stated: true,
        }
    }

    /// The training set of the paper's simulation: three uniform rods, [`Excitation::paper`], nothing hidden, no noise.
    pub fn paper(seed: u64) -> Self {
        Scenario {
            name: "paper".to_owned(),
            arm: Arm::uniform(3),
            motion: Excitation::paper(),
            effects: Vec::new(),
            torque_noise: 0.0,
            seed,
            ..Scenario::embedded()
        }
    }

    /// Checks that it can be simulated.
    ///
    /// # Errors
    /// [`SimulationError`] names the first thing that can't be.
    pub fn check(&self) -> Result<(), SimulationError> {
        self.arm.check()?;
        self.motion.check()?;
        self.motion.check_joints(self.arm.joint_count())?;
        sensible("speed scale", self.speed_scale)?;
        demand("torque noise", self.torque_noise, self.torque_noise >= 0.0, "a fraction of 0 or more")?;
        if let Some(resolution) = self.encoder_resolution {
            sensible("encoder resolution", resolution)?;
        }
        self.resolve_effects().map(drop)
    }

    fn resolve_effects(&self) -> Result<Vec<Hidden<'_>>, SimulationError> {
        let effects = hidden::resolve(&self.effects, self.arm.joint_count())?;
        effects.iter().try_for_each(|hidden| self.check_measured(hidden.effect))?;
        Ok(effects)
    }

    /// What is derived from positions can't be late.
    fn check_measured(&self, effect: &Effect) -> Result<(), SimulationError> {
        match self.encoder_resolution.is_some() && effect.facts.of_measured_derivatives {
            true => Err(SimulationError::NotMeasured(effect.name)),
            false => Ok(()),
        }
    }

    /// All runs with the torque that the bare arm needs, without effects and sensors.
    fn exact_runs(&self, monitor: &Monitor) -> Result<Vec<Trajectory>, SimulationError> {
        self.check()?;
        let mut random = random(self.seed, Draw::Motion);
        let time = self.motion.time(self.speed_scale)?;
        let (joints, speed) = (self.arm.joint_count(), self.speed_scale);
        let count = self.motion.trajectory_count();
        let mut runs = Vec::with_capacity(count);
        for run in 0..count {
            monitor.report(run as f32 / count as f32, "moving the arm")?;
            let [mut q, mut qd, mut qdd] = [(); 3].map(|()| Signals::zeros(joints, time.len()));
            for (joint, path) in self.motion.draw(joints, &mut random).iter().enumerate() {
                for (sample, t) in time.iter().enumerate() {
                    let [position, velocity, acceleration] = path.at(t * speed);
                    q[joint][sample] = position;
                    qd[joint][sample] = velocity * speed;
                    qdd[joint][sample] = acceleration * speed * speed;
                }
            }
            let tau = self.arm.inverse_dynamics_along(&q, &qd, &qdd);
            let channels = Channels { time: time.clone(), q, qd, qdd, tau };
            runs.push(Trajectory::new(format!("run {}", run + 1), channels)?);
        }
        Ok(runs)
    }
}

/// Simulates a scenario.
///
/// # Errors
/// [`SimulationError`] says what in the scenario can't be, or that somebody stopped it.
pub fn simulate(scenario: &Scenario, monitor: &Monitor) -> Result<Recording, SimulationError> {
    let mut runs = scenario.exact_runs(monitor)?;
    let effects = scenario.resolve_effects()?;
    let joints = scenario.arm.joint_count();
    let mut squares = vec![0.0; joints];
    for run in &mut runs {
        monitor.check()?;
        hidden::add(&effects, &scenario.arm, run)?;
        for (square, torque) in squares.iter_mut().zip(&run.tau) {
            *square += torque.iter().map(|value| value * value).sum::<f64>();
        }
    }
    let samples = runs.iter().map(Trajectory::len).sum::<usize>() as f64;
    let deviations: Vec<f64> = squares.iter().map(|sum| scenario.torque_noise * (sum / samples).sqrt()).collect();
    let mut random = random(scenario.seed, Draw::Noise);
    let mut cutoffs = Vec::new();
    for run in &mut runs {
        monitor.check()?;
        sensor::add_torque_noise(run, &deviations, &mut random);
        if let Some(resolution) = scenario.encoder_resolution {
            cutoffs.push(sensor::read_encoders(run, resolution));
        }
        effects.iter().for_each(|effect| effect.misread(run));
    }
    Ok(Recording {
        name: scenario.name.clone(),
        joints: (1..=joints).map(Joint::numbered).collect(),
        trajectories: runs,
        provenance: match scenario.encoder_resolution {
            Some(resolution) => sensor::provenance(false, Some(resolution), &cutoffs),
            None => Provenance::MEASURED,
        },
        posture: Some(scenario.arm.posture),
        stated_arm: scenario.stated.then(|| scenario.arm.clone()),
        chain: None,
        torque: TorqueFacts::default(),
        encoders: None,
        seal: Some(Seal::close(&Truth {
            arm: scenario.arm.clone(),
            effects: scenario.effects.clone(),
            causes: Vec::new(),
            torque_noise: deviations,
            seed: scenario.seed,
            set_up: Vec::new(),
        })),
    })
}

/// What random numbers are for. Each use has its own stream, so that a change of one leaves the others as they were.
#[derive(Clone, Copy)]
enum Draw {
    Motion,
    Noise,
    Effects,
    Mystery,
    Model,
    World,
}

fn random(seed: u64, draw: Draw) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(draw as u64);
    random
}

fn demand(what: &'static str, value: f64, met: bool, must: &'static str) -> Result<(), SimulationError> {
    if met && value.is_finite() { Ok(()) } else { Err(SimulationError::Value { what, value, must }) }
}

/// A quantity that is positive and not beyond what any arm does, so that nothing overflows later.
fn sensible(what: &'static str, value: f64) -> Result<(), SimulationError> {
    demand(what, value, (1e-9..=1e6).contains(&value), "between 1e-9 and 1e6 (SI units)")
}

fn default_name() -> String {
    "simulated".to_owned()
}

fn unchanged() -> f64 {
    1.0
}

fn stated() -> bool {
    true
}

#[cfg(test)]
mod tests;
