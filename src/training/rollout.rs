//! How far the arm that a model simulates runs from the measured one.
//!
//! From states along a part of a recording, the arm of the model is moved by the torque that was measured: q̈ is what makes the
//! model's torque that one. After [`HORIZON`] it is told how far its joints are from where they were measured,
//!
//! ```text
//! eⱼ = √( mean over the starts of (q̂ⱼ(t + T) − qⱼ(t + T))² ),  T = 0.25 s
//! ```
//!
//! A small error of the torque that always pulls the same way moves the arm further than a large one that changes its sign, so
//! this is not the torque's error again. Between samples the torque is a straight line: where a log is coarser than some 10 ms, or dry
//! friction jumps between two samples, the truth itself runs a little off.
//!
//! Terms that remember (hysteresis, lag) or know the time (drift) can't be asked for a state alone. They act as they did along the measured
//! motion.

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::TrainError;
use super::inside::RUNS_AWAY;
use crate::model::{Fitted, Model, Term};
use crate::progress::Monitor;
use crate::recording::split::Segment;
use crate::recording::{Channels, Recording, Trajectory};
use crate::signals::Signals;

/// How long the arm is simulated from each start \[s\]. An arm that is above its joint falls from there by itself, ever faster: after a
/// second the right model of the demonstration arm is radians off, and the number says nothing of the model any more.
pub const HORIZON: f64 = 0.25;
/// Most starts; they are spread evenly over all that there are.
const MOST_STARTS: usize = 24;
/// Steps of the integration (classical Runge–Kutta) from a start to its end.
const STEPS: usize = 50;

/// How far the arm of a model is from the measured one, [`HORIZON`] after states that were measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rollout {
    /// RMS over the starts of q̂ − q at the end, of each joint \[rad or m\]; empty if the arm ran away from every start.
    pub error: Vec<f64>,
    /// From how many states it was simulated.
    pub starts: usize,
    /// From how many of them it ran away, faster than any arm; they are not in the error.
    pub ran_away: usize,
}

/// A measured state to start from.
struct Start {
    trajectory: usize,
    /// When \[s\].
    time: f64,
    q: Vec<f64>,
    qd: Vec<f64>,
    qdd: Vec<f64>,
}

/// The arms of all starts side by side: q and q̇ of each, one joint after the other.
#[derive(Clone)]
struct State {
    q: Vec<f64>,
    qd: Vec<f64>,
}

/// A model that is asked for q̈.
struct Arms<'a> {
    fitted: &'a Fitted,
    /// Which of its terms follow from what moves now.
    asked: Vec<bool>,
    recording: &'a Recording,
    /// The measured torque of each trajectory without that of the other terms.
    torque: Vec<Signals>,
    starts: Vec<Start>,
}

impl Rollout {
    /// Of a model, from states along these parts of a recording.
    ///
    /// # Errors
    /// [`TrainError::TooShort`] if no part lasts as long as [`HORIZON`], [`TrainError`] if the recording is of another arm, or it was
    /// stopped.
    pub fn of(
        fitted: &Fitted,
        recording: &Recording,
        parts: &[Segment],
        monitor: &Monitor,
    ) -> Result<Rollout, TrainError> {
        let arms = Arms::new(fitted, recording, parts)?;
        let (mut state, mut guess) = arms.begin();
        let mut is_lost = vec![false; arms.starts.len()];
        for step in 0..STEPS {
            monitor.report(step as f32 / STEPS as f32, "simulating the arm of the model")?;
            state = arms.step(&state, &mut guess, step as f64 * HORIZON / STEPS as f64)?;
            arms.catch(&mut state, &mut guess, &mut is_lost);
        }
        Ok(arms.measured(&state, &is_lost))
    }
}

/// Whether the torque of a term follows from q, q̇ and q̈ at one time. What the rigid body would absorb is one.
fn follows_from_state(term: &Term) -> bool {
    match term {
        Term::RigidBody(_) | Term::Resistance(_) | Term::Learned(_) => true,
        Term::Effect(term) => term.effect.facts.absorbed_by_body || term.effect.closed_form().is_some(),
    }
}

impl<'a> Arms<'a> {
    fn new(fitted: &'a Fitted, recording: &'a Recording, parts: &[Segment]) -> Result<Self, TrainError> {
        let starts = starts(recording, parts);
        if starts.is_empty() {
            return Err(TrainError::TooShort);
        }
        let Model { terms } = &fitted.model;
        let asked: Vec<bool> = terms.iter().map(follows_from_state).collect();
        let mut torque = Vec::new();
        for run in &recording.trajectories {
            let mut moving = run.tau.clone();
            if asked.contains(&false) {
                let prediction = fitted.predict(run).map_err(|error| TrainError::Model(error.to_string()))?;
                let others = prediction.terms.iter().zip(&asked).filter(|(_, asked)| !**asked);
                others.for_each(|(term, _)| moving.add(term, -1.0));
            }
            torque.push(moving);
        }
        Ok(Arms { fitted, asked, recording, torque, starts })
    }

    /// The measured states, and the accelerations with which the search for q̈ begins.
    fn begin(&self) -> (State, Vec<f64>) {
        let all = |of: fn(&Start) -> &Vec<f64>| self.starts.iter().flat_map(|start| of(start).clone()).collect();
        (State { q: all(|start| &start.q), qd: all(|start| &start.qd) }, all(|start| &start.qdd))
    }

    /// A step of classical Runge–Kutta, from so long after the starts.
    fn step(&self, from: &State, guess: &mut Vec<f64>, since: f64) -> Result<State, TrainError> {
        let step = HORIZON / STEPS as f64;
        let moved = |by: &State, share: f64| {
            let add =
                |from: &[f64], by: &[f64]| from.iter().zip(by).map(|(from, by)| from + share * step * by).collect();
            State { q: add(&from.q, &by.q), qd: add(&from.qd, &by.qd) }
        };
        let mut slope = |at: &State, share: f64| -> Result<State, TrainError> {
            *guess = self.accelerations(at, guess, since + share * step)?;
            Ok(State { q: at.qd.clone(), qd: guess.clone() })
        };
        let first = slope(from, 0.0)?;
        let second = slope(&moved(&first, 0.5), 0.5)?;
        let third = slope(&moved(&second, 0.5), 0.5)?;
        let fourth = slope(&moved(&third, 1.0), 1.0)?;
        let mean = |of: fn(&State) -> &Vec<f64>| {
            let all = of(&first).iter().zip(of(&second)).zip(of(&third).iter().zip(of(&fourth)));
            all.map(|((first, second), (third, fourth))| (first + 2.0 * (second + third) + fourth) / 6.0).collect()
        };
        Ok(moved(&State { q: mean(|slope| &slope.q), qd: mean(|slope| &slope.qd) }, 1.0))
    }

    /// q̈ of all arms: one step of Newton's from a guess, exact where the torque is linear in q̈. An arm whose H has no inverse
    /// runs away.
    fn accelerations(&self, at: &State, guess: &[f64], since: f64) -> Result<Vec<f64>, TrainError> {
        let n = self.recording.joint_count();
        let torque = self.torque_of(at, guess)?;
        let mut accelerations = Vec::with_capacity(guess.len());
        for (number, start) in self.starts.iter().enumerate() {
            let first = number * (n + 1);
            let run = &self.recording.trajectories[start.trajectory].time;
            let wanted = |joint: usize| line(run, &self.torque[start.trajectory][joint], start.time + since);
            let mass = DMatrix::from_fn(n, n, |row, column| torque[row][first + column] - torque[row][first + n]);
            let lacks = DVector::from_fn(n, |joint, _| wanted(joint) - torque[joint][first + n]);
            let change = mass.lu().solve(&lacks).unwrap_or_else(|| DVector::from_element(n, f64::INFINITY));
            accelerations.extend(change.iter().zip(&guess[number * n..]).map(|(change, guess)| guess + change));
        }
        Ok(accelerations)
    }

    /// The model's torque for each arm with the guess, and before it with a unit more of each joint's acceleration.
    fn torque_of(&self, at: &State, guess: &[f64]) -> Result<Signals, TrainError> {
        let n = self.recording.joint_count();
        let asked = n + 1;
        let count = self.starts.len() * asked;
        let signal = |values: &[f64], unit: f64| {
            Signals::from_fn(n, count, |joint, sample| {
                let more = if sample % asked == joint { unit } else { 0.0 };
                values[sample / asked * n + joint] + more
            })
        };
        let motion = Trajectory::new(
            "rollout",
            Channels {
                time: (0..count).map(|sample| sample as f64).collect(),
                q: signal(&at.q, 0.0),
                qd: signal(&at.qd, 0.0),
                qdd: signal(guess, 1.0),
                tau: Signals::zeros(n, count),
            },
        )?;
        let prediction = self.fitted.predict(&motion).map_err(|error| TrainError::Model(error.to_string()))?;
        let mut torque = Signals::zeros(n, count);
        let terms = prediction.terms.iter().zip(&self.asked).filter(|(_, asked)| **asked);
        terms.for_each(|(term, _)| torque.add(term, 1.0));
        Ok(torque)
    }

    /// Arms that run away are put back to their starts, so that all numbers stay some; they are lost.
    fn catch(&self, state: &mut State, guess: &mut [f64], is_lost: &mut [bool]) {
        let n = self.recording.joint_count();
        for (number, start) in self.starts.iter().enumerate() {
            let own = number * n..(number + 1) * n;
            let is_wild = |value: &f64| value.is_nan() || value.abs() >= RUNS_AWAY;
            is_lost[number] |= state.qd[own.clone()].iter().any(is_wild);
            if is_lost[number] {
                state.q[own.clone()].copy_from_slice(&start.q);
                state.qd[own.clone()].copy_from_slice(&start.qd);
                guess[own].copy_from_slice(&start.qdd);
            }
        }
    }

    /// Where the arms are, beside where they were measured then.
    fn measured(&self, state: &State, is_lost: &[bool]) -> Rollout {
        let n = self.recording.joint_count();
        let ran_away = is_lost.iter().filter(|lost| **lost).count();
        let squared = |joint: usize| -> f64 {
            let stayed = self.starts.iter().enumerate().filter(|(number, _)| !is_lost[*number]);
            let off = |(number, start): (usize, &Start)| {
                let run = &self.recording.trajectories[start.trajectory];
                state.q[number * n + joint] - curve(run, joint, start.time + HORIZON)
            };
            stayed.map(|start| off(start).powi(2)).sum()
        };
        let stayed = self.starts.len() - ran_away;
        let joints = if stayed == 0 { 0..0 } else { 0..n };
        let error = joints.map(|joint| (squared(joint) / stayed as f64).sqrt()).collect();
        Rollout { error, starts: self.starts.len(), ran_away }
    }
}

/// Measured states after which a part goes on for [`HORIZON`].
fn starts(recording: &Recording, parts: &[Segment]) -> Vec<Start> {
    let of_part = |part: &Segment| {
        let time = &recording.trajectories[part.trajectory].time[part.samples.clone()];
        let last = time.last().copied().unwrap_or(0.0) - HORIZON;
        let first = part.samples.start;
        let count = time.partition_point(|at| *at <= last);
        let trajectory = part.trajectory;
        (first..first + count).map(move |sample| (trajectory, sample)).collect::<Vec<_>>()
    };
    let all: Vec<(usize, usize)> = parts.iter().flat_map(of_part).collect();
    let count = all.len().min(MOST_STARTS);
    let spread = (0..count).map(|number| all[number * all.len() / count]);
    let start = |(trajectory, sample): (usize, usize)| {
        let run = &recording.trajectories[trajectory];
        let at = |signal: &Signals| signal.at(sample).collect();
        Start { trajectory, time: run.time[sample], q: at(&run.q), qd: at(&run.qd), qdd: at(&run.qdd) }
    };
    spread.map(start).collect()
}

/// The sample before a time, and how far it is on the way to the next one, 0 to 1.
fn between(time: &[f64], at: f64) -> (usize, f64) {
    let after = time.partition_point(|sample| *sample <= at).clamp(1, time.len() - 1);
    let share = (at - time[after - 1]) / (time[after] - time[after - 1]);
    (after - 1, share.clamp(0.0, 1.0))
}

/// On the straight line between two samples.
fn line(time: &[f64], values: &[f64], at: f64) -> f64 {
    let (before, share) = between(time, at);
    values[before] + share * (values[before + 1] - values[before])
}

/// The position of a joint between two samples, on the curve of third degree that has their velocities.
fn curve(run: &Trajectory, joint: usize, at: f64) -> f64 {
    let (before, share) = between(&run.time, at);
    let step = run.time[before + 1] - run.time[before];
    let (q, qd) = (&run.q[joint], &run.qd[joint]);
    let (rest, way) = (1.0 - share, q[before + 1] - q[before]);
    let bend = rest * (qd[before] * step - way) - share * (qd[before + 1] * step - way);
    q[before] + share * way + share * rest * bend
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::Arm;
    use crate::model::{self, Preset, RigidBody};
    use crate::recording::split::Split;
    use crate::simulation::{Excitation, Scenario, simulate};

    fn scenario(rate: f64) -> Scenario {
        let motion = Excitation::MultiSine {
            trajectories: 5,
            duration: 4.0,
            rate,
            harmonics: 3,
            lowest_frequency: 0.2,
            highest_frequency: 0.8,
            max_position: 1.5,
            max_velocity: 3.0,
        };
        Scenario { effects: Vec::new(), torque_noise: 0.0, motion, ..Scenario::embedded() }
    }

    fn identified(recording: &Recording, model: &Model) -> Fitted {
        model::fit(model, recording, &Split::automatic(recording), &Monitor::new()).unwrap()
    }

    fn rollout(fitted: &Fitted, recording: &Recording) -> Rollout {
        let split = Split::automatic(recording);
        Rollout::of(fitted, recording, &split.held_out, &Monitor::new()).unwrap()
    }

    /// The arm that made the recording travels it again; the finer the log, the nearer, since between samples the torque is a line.
    #[test]
    fn the_true_arm_stays_with_the_recording() {
        let largest = |rate: f64| {
            let scenario = scenario(rate);
            let recording = simulate(&scenario, &Monitor::new()).unwrap();
            use crate::arm::stated::StatedArm;
            let truth = Model { terms: vec![Term::RigidBody(RigidBody::Stated(StatedArm::Planar(scenario.arm)))] };
            let Rollout { error, starts, ran_away } = rollout(&identified(&recording, &truth), &recording);
            assert_eq!((starts, ran_away), (MOST_STARTS, 0));
            error.into_iter().fold(0.0, f64::max)
        };
        let (coarse, fine) = (largest(50.0), largest(200.0));
        assert!(fine < 5e-4 && fine < 0.1 * coarse, "{coarse} rad, {fine} rad");
    }

    /// By hand: a rod whose inertia is twice the true one, without gravity, goes half the way.
    #[test]
    fn an_arm_that_is_too_heavy_lags_behind() {
        let light = Arm { gravity: 0.0, ..Arm::uniform(1) };
        let mut heavy = light.clone();
        (heavy.links[0].mass, heavy.links[0].inertia) = (2.0 * light.links[0].mass, 2.0 * light.links[0].inertia);
        let count = 301;
        let time: Vec<f64> = (0..count).map(|sample| sample as f64 * 0.01).collect();
        let signal = |value: &dyn Fn(f64) -> f64| Signals::from_fn(1, count, |_, sample| value(time[sample]));
        let acceleration = 1.6;
        let inertia = light.inverse_dynamics(&[0.0], &[0.0], &[1.0])[0];
        let channels = Channels {
            q: signal(&|t| 0.5 * acceleration * t * t),
            qd: signal(&|t| acceleration * t),
            qdd: signal(&|_| acceleration),
            tau: signal(&|_| acceleration * inertia),
            time: time.clone(),
        };
        let recording = Recording::of_runs(vec![Trajectory::new("push", channels).unwrap()]);
        let recording = Recording { stated_arm: Some(heavy), ..recording };
        let fitted = identified(&recording, &Preset::StatedArm.model(&recording).unwrap());
        let whole = [Segment { trajectory: 0, samples: 0..count }];
        let rolled = Rollout::of(&fitted, &recording, &whole, &Monitor::new()).unwrap();
        // ½ (a − a / 2) T².
        assert!((rolled.error[0] - 0.25 * acceleration * HORIZON.powi(2)).abs() < 1e-9, "{rolled:?}");
    }

    /// A model that lacks friction runs further off than the one that has it, and that one nearly stays.
    #[test]
    fn what_a_model_lacks_takes_it_away() {
        let mut scenario = scenario(100.0);
        scenario.hide("viscous-friction", Some(1), vec![1.5]);
        let recording = simulate(&scenario, &Monitor::new()).unwrap();
        let rigid = Preset::RigidBody.model(&recording).unwrap();
        let viscous = crate::effect::registry::find("viscous-friction").unwrap();
        let whole = rigid.with_effect(viscous, &[1]).unwrap();
        let [lacking, whole] =
            [rigid, whole].map(|model| rollout(&identified(&recording, &model), &recording).error[1]);
        assert!(whole < 1e-4 && lacking > 0.01, "{whole} rad, {lacking} rad");
    }

    #[test]
    fn a_part_that_is_too_short_is_told() {
        let recording = simulate(&scenario(50.0), &Monitor::new()).unwrap();
        let fitted = identified(&recording, &Preset::RigidBody.model(&recording).unwrap());
        let short = [Segment { trajectory: 0, samples: 0..10 }];
        let error = Rollout::of(&fitted, &recording, &short, &Monitor::new()).unwrap_err().to_string();
        assert!(error.contains("lasts 0.25 s"), "{error}");
    }
}
