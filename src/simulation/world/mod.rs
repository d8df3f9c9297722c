//! An independent world: an arm of rigid bodies that a controller moves through motors, with whatever else is in it.
//!
//! [`crate::simulation`] prescribes the motion and computes the torque by the formulas that a diagnosis searches. Here nothing
//! of those formulas is used: a rigid-body engine moves the links (`bodies`), a servo with a model that is not quite right
//! asks for torques, drives and gears pass them on, [`part`]s act on the bodies, and sensors log. What a recording holds then
//! is also what no formula says: a motion that is not quite the one asked for, joints that stick, the twist of a gear.
//!
//! ```text
//! motion → servo → current loop → motor → gear → joint ← friction, springs, stops
//!            ↑          ↓                     ↓
//!         encoders    log of torque         links ← floor, cables, payloads
//! ```
//!
//! The sealed truth lists what was hidden, each with the share of its joint's torque that it really had; of what the catalogue does not
//! have also the share that nothing everyday could have had along that motion (`shown`).
//!
//! # Steps
//! The engine is of first order, so a world moves in steps of 0.1 ms unless the scenario says otherwise: accelerations are then
//! wrong by 1e-4 to 1e-3 of the largest. Reduced coordinates hold the joints; impulses would leave 3e-2 (see the tests).

mod bodies;
mod course;
mod draw;
mod moment;
pub mod part;
mod plan;
mod run;
mod sensors;
mod servo;
mod shown;
mod transmission;

use serde::{Deserialize, Serialize};

pub use draw::{Class, draw, mystery};
pub use part::{Kind, Part, Rank};
pub use sensors::{LoggedTorque, Sensors};
pub use servo::Servo;

use super::{Draw, Excitation, SimulationError, demand, random, sensor};
use crate::arm::Arm;
use crate::effect::registry;
use crate::progress::Monitor;
use crate::recording::seal::{Cause, HiddenEffect, Seal, Truth};
use crate::recording::torque::TorqueFacts;
use crate::recording::{Joint, Recording, Trajectory};
use crate::signals::Signals;
use plan::{Name, Plan};
use run::{Clock, Done};

/// Longest step of the engine where a scenario does not say \[s\].
const LONGEST_STEP: f64 = 1e-4;
/// So many times as short are the steps in which a run is tried, one after the other.
const SHORTER: [usize; 3] = [1, 4, 16];
/// Less than this share of the torque is nothing that a log could show.
const LEAST_SHARE: f64 = 1e-3;

/// A world and what happens in it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Name of the recording.
    #[serde(default = "default_name")]
    pub name: String,
    /// The arm, as its maker would state it.
    pub arm: Arm,
    /// The motion that the servo is asked for.
    pub motion: Excitation,
    /// How it follows.
    #[serde(default)]
    pub servo: Servo,
    /// What is logged.
    #[serde(default)]
    pub sensors: Sensors,
    /// What is there besides the arm.
    #[serde(default)]
    pub parts: Vec<Part>,
    /// Longest step of the engine \[s\].
    #[serde(default = "longest_step")]
    pub step: f64,
    /// Seed of all random draws.
    #[serde(default)]
    pub seed: u64,
    /// Whether the recording states the arm. Its posture is always stated.
    #[serde(default)]
    pub stated: bool,
}

impl Scenario {
    /// The arm, the motion and the sensors of a prescribed scenario, at speed scale 1 and with nothing hidden: the same, moved by
    /// a servo. Positions that are rounded have their velocities derived.
    pub fn of(prescribed: &super::Scenario) -> Self {
        Scenario {
            name: prescribed.name.clone(),
            arm: prescribed.arm.clone(),
            motion: prescribed.motion.clone(),
            servo: Servo::default(),
            sensors: Sensors {
                encoder_resolution: prescribed.encoder_resolution,
                velocity: prescribed.encoder_resolution.is_none(),
                torque_noise: prescribed.torque_noise,
                ..Sensors::default()
            },
            parts: Vec::new(),
            step: longest_step(),
            seed: prescribed.seed,
            stated: prescribed.stated,
        }
    }

    /// Checks that it can be simulated.
    ///
    /// # Errors
    /// [`SimulationError`] names the first thing that can't be.
    pub fn check(&self) -> Result<(), SimulationError> {
        let joints = self.arm.joint_count();
        self.arm.check()?;
        self.motion.check()?;
        self.motion.check_joints(joints)?;
        self.servo.check()?;
        self.sensors.check()?;
        demand("step", self.step, (1e-6..=2e-3).contains(&self.step), "1e-6 to 2e-3 s")?;
        if let Some(link) = self.arm.links.iter().position(|link| link.inertia <= 0.0) {
            return Err(SimulationError::NoInertia { link: link + 1 });
        }
        let mut geared = vec![0; joints];
        for part in &self.parts {
            part.as_install().check()?;
            let place = part.as_install().place().unwrap_or_default();
            if place >= joints {
                return Err(SimulationError::NoSuchJoint { effect: "a part of the world", joint: place + 1, joints });
            }
            geared[place] += usize::from(matches!(part, Part::Rotor(_) | Part::ElasticGear(_)));
        }
        match geared.iter().position(|count| *count > 1) {
            Some(joint) => Err(SimulationError::TwoGears { joint: joint + 1 }),
            None => Ok(()),
        }
    }

    /// What its parts are called, in their order; with parameters where the catalogue of effects has all of them.
    pub fn hidden(&self) -> Vec<HiddenEffect> {
        let hidden = |Name { effect, joint, parameters }| HiddenEffect { effect: effect.to_owned(), joint, parameters };
        self.plan().hidden.into_iter().map(hidden).collect()
    }

    fn plan(&self) -> Plan {
        let mut plan = Plan { side: self.sensors.side, ..Plan::bare(&self.arm) };
        self.parts.iter().for_each(|part| part.as_install().install(&mut plan));
        plan
    }

    fn clock(&self) -> Result<Clock, SimulationError> {
        let time = self.motion.time(1.0)?;
        let sample_step = time.get(1).copied().unwrap_or(self.step);
        let steps_a_sample = (sample_step / self.step - 1e-9).ceil().max(1.0) as usize;
        Ok(Clock { samples: time.len(), sample_step, steps_a_sample })
    }
}

/// Does a run again in shorter steps, with the same draws, where it diverges in those that are asked for.
fn in_steps_that_hold<R: Clone, T>(
    clock: Clock,
    random: &mut R,
    run: impl Fn(Clock, &mut R) -> Result<T, SimulationError>,
) -> Result<T, SimulationError> {
    let drawn = random.clone();
    for shorter in SHORTER {
        random.clone_from(&drawn);
        match run(Clock { steps_a_sample: clock.steps_a_sample * shorter, ..clock }, random) {
            Err(SimulationError::Diverged) => {}
            result => return result,
        }
    }
    Err(SimulationError::Diverged)
}

/// Lets a world happen.
///
/// # Errors
/// [`SimulationError`] says what in the scenario can't be, or that somebody stopped it.
pub fn simulate(scenario: &Scenario, monitor: &Monitor) -> Result<Recording, SimulationError> {
    scenario.check()?;
    let clock = scenario.clock()?;
    let joints = scenario.arm.joint_count();
    let names = scenario.plan().hidden;
    let [mut motion, mut model] = [Draw::Motion, Draw::Model].map(|draw| random(scenario.seed, draw));
    let count = scenario.motion.trajectory_count();
    let (mut runs, mut done) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for number in 0..count {
        let paths = scenario.motion.draw(joints, &mut motion);
        let share = number as f32 / count as f32..(number + 1) as f32 / count as f32;
        let (mut run, did) = in_steps_that_hold(clock, &mut model, |clock, model| {
            let Scenario { servo, sensors, .. } = scenario;
            run::run(scenario.plan(), &paths, clock, servo, sensors, model, monitor, share.clone())
        })?;
        run.name = format!("run {}", number + 1);
        runs.push(run);
        done.push(did);
    }
    let deviations = deviations(&scenario.sensors, &runs);
    let logged = squares(&runs.iter().map(|run| &run.tau).collect::<Vec<_>>());
    let mut noise = random(scenario.seed, Draw::Noise);
    let cutoffs: Vec<f64> = runs.iter_mut().map(|run| scenario.sensors.read(run, &deviations, &mut noise)).collect();
    let [_, torque_noise] = deviations;
    let of_slot = |slot: usize| done.iter().map(|did: &Done| &did[slot]).collect::<Vec<&Signals>>();
    let did: Vec<Vec<&Signals>> = (0..names.len()).map(of_slot).collect();
    // What is faster than the log is not in it, and need not be where masses take up a jerk.
    let seen = |torque: &[&Signals]| -> Vec<Signals> {
        let logs = runs.iter().zip(&cutoffs);
        torque.iter().zip(logs).map(|(torque, (run, &cutoff))| sensor::as_derived(torque, run, cutoff)).collect()
    };
    let causes = causes(&names, &did, &logged, |torque| shown::left(&scenario.arm, &runs, &seen(torque)));
    Ok(Recording {
        name: scenario.name.clone(),
        joints: (1..=joints).map(Joint::numbered).collect(),
        trajectories: runs,
        provenance: sensor::provenance(scenario.sensors.velocity, scenario.sensors.encoder_resolution, &cutoffs),
        posture: Some(scenario.arm.posture),
        stated_arm: scenario.stated.then(|| scenario.arm.clone()),
        chain: None,
        torque: TorqueFacts::default(),
        encoders: None,
        seal: Some(Seal::close(&Truth {
            arm: scenario.arm.clone(),
            effects: causes.iter().filter_map(in_the_catalogue).collect(),
            causes,
            torque_noise,
            seed: scenario.seed,
            set_up: Vec::new(),
        })),
    })
}

/// Standard deviations of the noise of velocity \[rad/s\] and torque \[N m\] of each joint.
fn deviations(sensors: &Sensors, runs: &[Trajectory]) -> [Vec<f64>; 2] {
    let samples: usize = runs.iter().map(Trajectory::len).sum();
    let of = |share: f64, signal: fn(&Trajectory) -> &Signals| -> Vec<f64> {
        let squares = squares(&runs.iter().map(signal).collect::<Vec<_>>());
        squares.into_iter().map(|sum| share * (sum / samples as f64).sqrt()).collect()
    };
    [of(sensors.velocity_noise, |run| &run.qd), of(sensors.torque_noise, |run| &run.tau)]
}

/// Σ signal² of each joint over all runs.
fn squares(runs: &[&Signals]) -> Vec<f64> {
    let joints = runs.first().map_or(0, |run| run.joint_count());
    let of = |joint: usize| runs.iter().flat_map(|run| &run[joint]).map(|value| value * value).sum();
    (0..joints).map(of).collect()
}

/// What was hidden and really `did` something, each by run. What acts on the whole arm and is not in the catalogue is told for each joint
/// that feels it; `left` says how much (RMS by joint \[N m\]) the everyday leaves of it.
fn causes(names: &[Name], did: &[Vec<&Signals>], logged: &[f64], left: impl Fn(&[&Signals]) -> Vec<f64>) -> Vec<Cause> {
    let mut causes = Vec::new();
    for (name, torque) in names.iter().zip(did) {
        let done = squares(torque);
        let share = |joints: &[usize]| {
            let sum = |sums: &[f64]| joints.iter().map(|joint| sums[*joint]).sum::<f64>();
            (sum(&done) / sum(logged)).sqrt()
        };
        let feeling: Vec<usize> = (0..done.len()).filter(|joint| share(&[*joint]) > LEAST_SHARE).collect();
        let is_known = registry::find(name.effect).is_ok();
        let samples = torque.iter().map(|run| run.sample_count()).sum::<usize>() as f64;
        let left = if is_known || feeling.is_empty() { None } else { Some(left(torque)) };
        let mut push = |joint: Option<usize>, share: f64| {
            if share > LEAST_SHARE {
                let (effect, parameters) = (name.effect.to_owned(), name.parameters.clone());
                let beside =
                    joint.zip(left.as_ref()).map(|(joint, left)| left[joint] / (logged[joint] / samples).sqrt());
                causes.push(Cause { effect, joint, parameters, share, beside_everyday: beside });
            }
        };
        match name.joint {
            Some(joint) if is_known => push(Some(joint), share(&[joint])),
            None if is_known => push(None, share(&feeling)),
            _ => feeling.iter().for_each(|joint| push(Some(*joint), share(&[*joint]))),
        }
    }
    causes
}

/// The same in the words of the catalogue, where it has all of them.
fn in_the_catalogue(cause: &Cause) -> Option<HiddenEffect> {
    let effect = registry::find(&cause.effect).ok()?;
    effect.check_parameters(&cause.parameters).ok()?;
    Some(HiddenEffect { effect: cause.effect.clone(), joint: cause.joint, parameters: cause.parameters.clone() })
}

fn default_name() -> String {
    "world".to_owned()
}

fn longest_step() -> f64 {
    LONGEST_STEP
}

#[cfg(test)]
mod tests;
