//! One run: controller, drives, parts and bodies, step by step.

use std::ops::Range;

use super::bodies::Bodies;
use super::moment::{Forces, Moment};
use super::plan::{Plan, Slot, Stages};
use super::sensors::{LoggedTorque, Sensors};
use super::servo::{Controller, Servo};
use super::transmission::Transmission;
use crate::progress::Monitor;
use crate::recording::encoders::Side;
use crate::recording::{Channels, Trajectory};
use crate::signals::Signals;
use crate::simulation::SimulationError;
use crate::simulation::excitation::Path;
use rand::Rng;

/// How long the arm is held still before a run, so that drives, bristles and riders are at rest \[s\].
const SETTLING: f64 = 0.6;
/// How many steps pass between looks at the monitor.
const STEPS_A_LOOK: usize = 2000;

/// What every hidden thing did to the torque \[N m\], by slot, at the moments that are logged.
pub(super) type Done = Vec<Signals>;

/// Times of a run.
#[derive(Debug, Clone, Copy)]
pub(super) struct Clock {
    /// How many samples are logged.
    pub(super) samples: usize,
    /// From one to the next \[s\].
    pub(super) sample_step: f64,
    /// Steps of the world in one of those.
    pub(super) steps_a_sample: usize,
}

impl Clock {
    /// Step of the world \[s\].
    pub(super) fn step(&self) -> f64 {
        self.sample_step / self.steps_a_sample as f64
    }
}

/// No arm goes so far \[rad\], so fast \[rad/s\], or pushes so hard \[N m\]: its bodies fly apart, since the steps are too long.
const BEYOND_BELIEF: f64 = 1e6;

/// A run in progress.
struct Run<'a> {
    plan: Plan,
    sensors: &'a Sensors,
    controller: Controller,
    bodies: Bodies,
    now: Moment,
    /// Of each device.
    forces: Vec<Forces>,
    /// In this step, by slot and joint.
    done: Vec<Vec<f64>>,
}

/// Lets the arm follow paths; gives what is to be logged, without noise of sensors, and what every part did. `share` is its part
/// of the work that the monitor is told of.
pub(super) fn run(
    plan: Plan,
    paths: &[Path],
    clock: Clock,
    servo: &Servo,
    sensors: &Sensors,
    random: &mut impl Rng,
    monitor: &Monitor,
    share: Range<f32>,
) -> Result<(Trajectory, Done), SimulationError> {
    let joints = paths.len();
    let start = target(paths, 0.0);
    let drives = plan.joints.iter().map(|joint| &joint.transmission);
    let controller = Controller::new(servo, &plan.arm, drives, clock.step(), random);
    let bodies = Bodies::build(&plan, &start[0], &start[1], clock.step()).ok_or(SimulationError::Engine)?;
    let mut run = Run {
        now: Moment::new(&plan.arm, plan.tilt, clock.step()),
        forces: vec![Forces::none(joints); plan.devices.len()],
        done: vec![vec![0.0; joints]; plan.hidden.len()],
        plan,
        sensors,
        controller,
        bodies,
    };
    run.wind_up(&start[0]);
    let settling = (SETTLING / clock.step()).ceil() as usize;
    for step in 0..settling {
        run.step(-((settling - step) as f64) * clock.step(), &start);
    }
    let [mut q, mut qd, mut tau] = [(); 3].map(|()| Signals::zeros(joints, clock.samples));
    let mut done = vec![Signals::zeros(joints, clock.samples); run.done.len()];
    for sample in 0..clock.samples {
        for part in 0..clock.steps_a_sample {
            let step = sample * clock.steps_a_sample + part;
            if step.is_multiple_of(STEPS_A_LOOK) {
                let way = sample as f32 / clock.samples as f32;
                monitor.report(share.start + way * (share.end - share.start), "moving the arm")?;
            }
            let time = step as f64 * clock.step();
            let logged = run.step(time, &target(paths, time));
            if part == 0 {
                let [q_read, qd_read] = run.seen();
                for joint in 0..joints {
                    (q[joint][sample], qd[joint][sample]) = (q_read[joint], qd_read[joint]);
                    tau[joint][sample] = logged[joint];
                }
                run.count_twists();
                for (trace, done) in done.iter_mut().zip(&run.done) {
                    (0..joints).for_each(|joint| trace[joint][sample] = done[joint]);
                }
            }
        }
    }
    let is_believable = |value: &f64| value.abs() < BEYOND_BELIEF;
    if ![&q, &qd, &tau].iter().all(|signals| signals.values().iter().all(is_believable)) {
        return Err(SimulationError::Diverged);
    }
    let time = (0..clock.samples).map(|sample| sample as f64 * clock.sample_step).collect();
    let qdd = Signals::zeros(joints, clock.samples);
    Ok((Trajectory::new("", Channels { time, q, qd, qdd, tau })?, done))
}

/// q, q̇ and q̈ that the paths ask for.
fn target(paths: &[Path], time: f64) -> [Vec<f64>; 3] {
    let mut target = [(); 3].map(|()| vec![0.0; paths.len()]);
    for (joint, path) in paths.iter().enumerate() {
        let state = path.at(time);
        (0..3).for_each(|order| target[order][joint] = state[order]);
    }
    target
}

impl Run<'_> {
    /// Rotors begin where their gears hold the weight of the arm.
    fn wind_up(&mut self, q: &[f64]) {
        let weight = self.plan.arm.gravity_torque(q);
        for (joint, drive) in self.plan.joints.iter_mut().enumerate() {
            if let Transmission::Elastic(gear) = &mut drive.transmission {
                gear.rest(q[joint], weight[joint]);
            }
        }
    }

    /// Position and velocity as seen by the encoders.
    fn seen(&self) -> [Vec<f64>; 2] {
        match self.sensors.side {
            Side::Link => [self.now.q.clone(), self.now.qd.clone()],
            Side::Motor => self.at_motors(),
        }
    }

    /// Position and velocity of the motors, which the servo follows.
    fn at_motors(&self) -> [Vec<f64>; 2] {
        let mut seen = [self.now.q.clone(), self.now.qd.clone()];
        for (joint, drive) in self.plan.joints.iter().enumerate() {
            if let Transmission::Elastic(gear) = &drive.transmission {
                (seen[0][joint], seen[1][joint]) = (gear.position, gear.velocity);
            }
        }
        seen
    }

    /// Moves the world to the next moment; gives the torque that is logged at this one \[N m\].
    fn step(&mut self, time: f64, target: &[Vec<f64>; 3]) -> Vec<f64> {
        self.now.time = time;
        self.bodies.take_up(time);
        self.bodies.read(&mut self.now);
        self.done.iter_mut().for_each(|done| done.fill(0.0));

        let [q, qd] = self.at_motors();
        let mut torques = self.controller.command(target, &q, &qd);
        let logged = self.drive(&mut torques);
        self.now.sent.copy_from_slice(&torques);
        for ((slot, device), forces) in self.plan.devices.iter_mut().zip(&mut self.forces) {
            forces.clear();
            device.act(&self.now, forces);
            for joint in 0..torques.len() {
                torques[joint] -= forces.resisting[joint];
                self.done[*slot][joint] += forces.needed(&self.now, joint);
            }
        }
        self.bodies.step(&torques, self.forces.iter().flat_map(|forces| &forces.pushes));
        logged
    }

    /// From commands to what reaches the links; gives what is logged of it.
    fn drive(&mut self, torques: &mut [f64]) -> Vec<f64> {
        let commanded = self.sensors.torque == LoggedTorque::Commanded;
        let (now, done) = (&self.now, &mut self.done);
        let mut logged = vec![0.0; torques.len()];
        for (joint, (torque, drive)) in torques.iter_mut().zip(&mut self.plan.joints).enumerate() {
            let asked = *torque;
            *torque = pass(&mut drive.current, *torque, now, |slot, change| {
                done[slot][joint] -= if commanded { change } else { 0.0 };
            });
            logged[joint] = if commanded { asked } else { *torque };
            *torque = pass(&mut drive.motor, *torque, now, |slot, change| done[slot][joint] -= change);
            if let Transmission::Elastic(gear) = &mut drive.transmission {
                *torque = gear.turn(*torque, now.q[joint], now.qd[joint], now.step);
                done[gear.slot][joint] += gear.inertia * (gear.acceleration - now.qdd[joint]);
            }
            let reading = pass(&mut drive.reading, logged[joint], now, |slot, change| done[slot][joint] += change);
            logged[joint] = reading;
        }
        logged
    }

    /// Counts what the twist of gears does to the torque that the arm would need along what encoders on the motors see.
    fn count_twists(&mut self) {
        if self.sensors.side != Side::Motor {
            return;
        }
        let [q, qd] = self.at_motors();
        let mut qdd = self.now.qdd.clone();
        let mut gears = Vec::new();
        for (joint, drive) in self.plan.joints.iter().enumerate() {
            if let Transmission::Elastic(gear) = &drive.transmission {
                qdd[joint] = gear.acceleration;
                gears.push((joint, gear.slot));
            }
        }
        let arm = &self.plan.arm;
        let truly = arm.inverse_dynamics(&self.now.q, &self.now.qd, &self.now.qdd);
        let seemingly = arm.inverse_dynamics(&q, &qd, &qdd);
        for (joint, slot) in gears {
            self.done[slot][joint] += truly[joint] - seemingly[joint];
        }
    }
}

/// Lets a torque pass stages; `changed` hears what each adds.
fn pass(stages: &mut Stages, torque: f64, now: &Moment, mut changed: impl FnMut(Slot, f64)) -> f64 {
    stages.iter_mut().fold(torque, |torque, (slot, stage)| {
        let passed = stage.pass(torque, now);
        changed(*slot, passed - torque);
        passed
    })
}
