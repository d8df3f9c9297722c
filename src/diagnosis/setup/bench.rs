//! A recording thinned out, and how well a rigid body explains it: the bench on which set-ups are tried.
//!
//! All channels pass one low-pass and are kept a few times each period of it. A correction is applied to what is kept, and the
//! rigid body is fitted beside what every joint has (offset, viscous and Coulomb friction, a rotor); four parts of the
//! samples predict the fifth.

use nalgebra::DVector;
use rayon::prelude::*;

use crate::arm::chain::{PER_LINK, Regressor};
use crate::arm::{GRAVITY, MOST_JOINTS, Posture, regressor};
use crate::model::equations::joint_equations;
use crate::model::least_squares::NormalEquations;
use crate::recording::correction::{Correction, CorrectionError};
use crate::recording::differentiate::{central_difference, default_cutoff, low_pass_joints};
use crate::recording::{Channels, JointKind, Recording, Trajectory};
use crate::signals::Signals;

/// So many samples at most are filtered; of longer recordings pieces from everywhere.
const MOST_FILTERED: usize = 60_000;
/// Length of such a piece.
const PIECE: usize = 3_000;
/// Shorter pieces say little beside their filtered ends.
const SHORTEST_PIECE: usize = 30;
/// Samples kept for each period of the cut-off.
const KEPT_PER_PERIOD: f64 = 4.0;
/// A set-up is judged on so many samples of a planar arm, and of one in space, whose columns cost more.
const MOST_JUDGED: [usize; 2] = [900, 200];
/// The samples are cut into so many stretches; every `FOLDS`-th is predicted from the others.
const STRETCHES: usize = 20;
const FOLDS: usize = 5;
/// Columns of what every joint has: offset, viscous and Coulomb friction, rotor.
const EVERYDAY: usize = 4;
/// Below this share of its top speed the direction of a filtered velocity is smeared.
const REVERSAL: f64 = 0.03;
/// Price on large factors: what the motion hardly shows must not blow up where it is predicted.
const DAMPING: f64 = 1e-8;
/// The sign of an inertia is that of its mean over so many samples.
const SIGN_SAMPLES: usize = 12;
/// Least share of its torque (RMS) that a joint's inertia must make for its sign to say anything.
const LEAST_INERTIA: f64 = 0.1;
/// The same for friction.
const LEAST_FRICTION: f64 = 0.3;
/// The same for gravity.
const LEAST_GRAVITY: f64 = 0.1;

/// A thinned recording.
pub(super) struct Bench {
    /// Pieces from everywhere, as they were read.
    pub pieces: Recording,
    /// The same, filtered and thinned out.
    pub thin: Recording,
    /// Median time step of the first trajectory \[s\]: what a sample is.
    pub step: f64,
    /// Every how manieth kept sample is judged.
    every: usize,
}

/// How well a set-up explains the torque.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    /// Of each joint: share of the torque's variance that is left where it is predicted.
    pub errors: Vec<f64>,
    /// The same of each fold, all joints together.
    pub folds: Vec<f64>,
    /// What can't be: joints whose inertia or friction has the wrong sign.
    pub impossible: Vec<usize>,
    /// Links whose weight pulls forwards and backwards along them, where that matters.
    pub links: [usize; 2],
}

impl Fit {
    /// Whether the weight of every link pulls backwards, as if all pointed the other way.
    pub fn is_turned_over(&self) -> bool {
        self.links[0] == 0 && self.links[1] > 0
    }
}

impl Bench {
    /// `None` if the recording is none of a rigid body that is known, or too short to say anything.
    pub fn of(recording: &Recording) -> Option<Bench> {
        Body::of(recording)?;
        let chunks: Vec<(&Trajectory, usize)> = recording
            .trajectories
            .iter()
            .flat_map(|trajectory| (0..trajectory.len()).step_by(PIECE).map(move |start| (trajectory, start)))
            .collect();
        let every = recording.sample_count().div_ceil(MOST_FILTERED);
        let pieces = chunks.into_iter().step_by(every).filter_map(|(trajectory, start)| {
            let end = (start + PIECE).min(trajectory.len());
            (end - start >= SHORTEST_PIECE).then(|| trajectory.slice(start..end))
        });
        let pieces = recording.with_trajectories(pieces.collect());
        let thin = recording.with_trajectories(pieces.trajectories.iter().filter_map(thinned).collect());
        let kept = thin.sample_count();
        let most = MOST_JUDGED[usize::from(thin.spatial().is_some())];
        let step = recording.trajectories.first()?.time_step();
        (kept >= 10 * STRETCHES).then_some(Bench { pieces, thin, step, every: kept.div_ceil(most) })
    }

    /// The set-up as it is stated.
    pub fn stated(&self) -> Option<Fit> {
        self.fit(&self.thin)
    }

    /// The set-up with these corrections, one after the other.
    pub fn corrected(&self, corrections: &[Correction]) -> Option<Fit> {
        let correct = || {
            let mut thin = self.thin.clone();
            corrections.iter().try_for_each(|correction| correction.apply(&mut thin))?;
            Ok::<_, CorrectionError>(thin)
        };
        self.fit(&correct().ok()?)
    }

    /// The set-up with all runs changed before they are filtered, by what is quicker than what is kept.
    pub fn changed(&self, change: impl Fn(&mut Trajectory)) -> Option<Fit> {
        let mut runs = self.pieces.trajectories.clone();
        runs.iter_mut().for_each(change);
        self.fit(&self.pieces.with_trajectories(runs.iter().filter_map(thinned).collect()))
    }

    /// The same bench with some of its pieces, from everywhere: so many samples at most.
    pub fn short(&self, most: usize) -> Option<Bench> {
        let every = self.pieces.sample_count().div_ceil(most).max(1);
        let some = self.pieces.trajectories.iter().step_by(every).cloned().collect();
        Bench::of(&self.pieces.with_trajectories(some))
    }

    /// The set-up as stated with a torque that lags by this first-order time constant \[s\] made quick again.
    pub fn without_lag(&self, seconds: f64) -> Option<Fit> {
        let mut thin = self.thin.clone();
        for run in &mut thin.trajectories {
            let mut tau = run.tau.clone();
            tau.add(&run.tau.map_joints(|joint| central_difference(joint, &run.time)), seconds);
            run.set_torque(tau).ok()?;
        }
        self.fit(&thin)
    }

    /// The same bench with every so manieth sample, for long searches.
    pub fn coarse(&self, every: usize) -> Bench {
        Bench { pieces: self.pieces.clone(), thin: self.thin.clone(), step: self.step, every: every * self.every }
    }

    /// Where the first link points at q = 0.
    pub fn posture(&self) -> Posture {
        self.thin.assumed_posture()
    }

    /// Fits a thinned recording and predicts each part of it from the others.
    pub fn fit(&self, thin: &Recording) -> Option<Fit> {
        let body = Body::of(thin)?;
        let joints = thin.joint_count();
        let parts = Parts::of(&body, thin, self.every);
        let weight = |variance: &f64| if *variance > 0.0 { 1.0 / variance } else { 0.0 };
        let weights: Vec<f64> = parts.variances.iter().map(weight).collect();
        let totals: Vec<NormalEquations> = (0..FOLDS).map(|fold| parts.total(fold, &weights)).collect();
        let mut whole = NormalEquations::empty(parts.columns());
        totals.iter().for_each(|total| whole.add(total, 1.0));
        let factors_without = |total: &NormalEquations| whole.without(total).damped(DAMPING).solve().factors;
        let without: Vec<DVector<f64>> = totals.iter().map(factors_without).collect();
        let left = |fold: usize, joint: usize| parts.residual(fold, joint, &without[fold]) * weights[joint];
        let counts = &parts.counts;
        let all: usize = counts.iter().sum();
        let errors = (0..joints).map(|joint| (0..FOLDS).map(|fold| left(fold, joint)).sum::<f64>() / all as f64);
        let folds =
            (0..FOLDS).map(|fold| (0..joints).map(|joint| left(fold, joint)).sum::<f64>() / counts[fold] as f64);
        let (errors, folds): (Vec<f64>, Vec<f64>) = (errors.collect(), folds.collect());
        if errors.iter().any(|error| !error.is_finite()) {
            return None;
        }
        let signs = Signs { body: &body, thin, parts: &parts, factors: &without };
        Some(Fit { errors, folds, impossible: signs.impossible(), links: signs.links() })
    }
}

/// A piece through the low-pass, at a few samples each period of it.
fn thinned(piece: &Trajectory) -> Option<Trajectory> {
    let step = piece.time_step();
    if step <= 0.0 {
        return None;
    }
    let cutoff = default_cutoff(&piece.q, &piece.qd, step);
    let every = ((1.0 / (step * KEPT_PER_PERIOD * cutoff)) as usize).max(1);
    let signals = piece.signals().into_par_iter();
    let smooth: Vec<Signals> = signals.map(|(_, signal)| low_pass_joints(signal, step, cutoff)).collect();
    let [q, qd, qdd, tau] = <[Signals; 4]>::try_from(smooth).ok()?;
    let smooth = Trajectory::new(piece.name.clone(), Channels { time: piece.time.clone(), q, qd, qdd, tau }).ok()?;
    Some(smooth.thinned(every))
}

/// The rigid body's torque as a linear function of its parameters.
enum Body {
    Planar(Posture),
    InSpace { regressor: Regressor, weightless: Regressor },
    Slide,
}

impl Body {
    /// `None` for a recording of an arm that no rigid body of ours describes.
    fn of(recording: &Recording) -> Option<Body> {
        let joints = recording.joint_count();
        let slides: Vec<bool> = recording.joints.iter().map(|joint| joint.kind == JointKind::Prismatic).collect();
        if let Some(chain) = recording.spatial() {
            let mut weightless = chain.clone();
            weightless.gravity = [0.0; 3];
            return Some(Body::InSpace {
                regressor: chain.regressor(&slides),
                weightless: weightless.regressor(&slides),
            });
        }
        match slides[..] {
            [true] => Some(Body::Slide),
            _ if slides.contains(&true) || !(1..=MOST_JOINTS).contains(&joints) => None,
            _ => Some(Body::Planar(recording.assumed_posture())),
        }
    }

    /// How many parameters it has.
    fn width(&self, joints: usize) -> usize {
        match self {
            Body::Planar(_) => regressor::parameter_count(joints),
            Body::InSpace { .. } => PER_LINK * joints,
            Body::Slide => 1,
        }
    }

    /// `rows[joint][parameter]` of one state, with or without gravity.
    fn fill(&self, weighs: bool, [q, qd, qdd]: [&[f64]; 3], rows: &mut [f64]) {
        match self {
            Body::Planar(posture) => regressor::fill(*posture, if weighs { GRAVITY } else { 0.0 }, q, qd, qdd, rows),
            Body::InSpace { regressor, .. } if weighs => regressor.fill(q, qd, qdd, rows),
            Body::InSpace { weightless, .. } => weightless.fill(q, qd, qdd, rows),
            Body::Slide => rows.copy_from_slice(qdd),
        }
    }
}

/// Normal equations by fold and joint, in the columns that act on the joint: the body's, then its own everyday ones.
struct Parts {
    width: usize,
    joints: usize,
    equations: Vec<Vec<NormalEquations>>,
    /// Samples of each fold.
    counts: Vec<usize>,
    /// Variance of the torque of each joint.
    variances: Vec<f64>,
    /// Greatest speed of each joint.
    fastest: Vec<f64>,
}

impl Parts {
    fn of(body: &Body, thin: &Recording, every: usize) -> Parts {
        let joints = thin.joint_count();
        let width = body.width(joints);
        let places: Vec<(&Trajectory, usize)> = thin
            .trajectories
            .iter()
            .flat_map(|run| (0..run.len()).map(move |sample| (run, sample)))
            .step_by(every)
            .collect();
        let fastest: Vec<f64> = (0..joints).map(|joint| thin.top_speed(joint)).collect();
        let count = width + EVERYDAY;
        let mut columns = vec![vec![vec![Vec::new(); count + 1]; joints]; FOLDS];
        let mut counts = vec![0; FOLDS];
        let mut rows = vec![0.0; joints * width];
        for (number, (run, sample)) in places.iter().enumerate() {
            let fold = number * STRETCHES / places.len() % FOLDS;
            counts[fold] += 1;
            let [q, qd, qdd, tau] = state(run, *sample);
            body.fill(true, [&q[..joints], &qd[..joints], &qdd[..joints]], &mut rows);
            for joint in 0..joints {
                let own = [1.0, qd[joint], direction(qd[joint], fastest[joint]), qdd[joint], tau[joint]];
                let values = rows[joint * width..(joint + 1) * width].iter().chain(&own);
                columns[fold][joint].iter_mut().zip(values).for_each(|(column, value)| column.push(*value));
            }
        }
        let variance = |joint: usize| {
            let torque = || columns.iter().flat_map(|fold| &fold[joint][count]);
            let mean = torque().sum::<f64>() / places.len() as f64;
            torque().map(|tau| (tau - mean).powi(2)).sum::<f64>() / places.len() as f64
        };
        let variances = (0..joints).map(variance).collect();
        // The last column of a joint is its torque.
        let of_columns = |columns: &[Vec<f64>]| {
            let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
            joint_equations(&columns[..count], columns[count])
        };
        let equations = columns.iter().map(|fold| fold.iter().map(|joint| of_columns(joint)).collect()).collect();
        Parts { width, joints, equations, counts, variances, fastest }
    }

    /// Where a joint's column stands among all.
    fn place(&self, joint: usize, column: usize) -> usize {
        if column < self.width { column } else { column + EVERYDAY * joint }
    }

    /// How many columns there are: the body's, and the everyday ones of all joints.
    fn columns(&self) -> usize {
        self.width + EVERYDAY * self.joints
    }

    /// The weighted sum of one fold over all joints, in all columns.
    fn total(&self, fold: usize, weights: &[f64]) -> NormalEquations {
        let mut sum = NormalEquations::empty(self.columns());
        for (joint, part) in self.equations[fold].iter().enumerate() {
            let weight = weights[joint];
            for i in 0..part.moment.len() {
                let row = self.place(joint, i);
                sum.moment[row] += weight * part.moment[i];
                for j in 0..part.moment.len() {
                    sum.gram[(row, self.place(joint, j))] += weight * part.gram[(i, j)];
                }
            }
            sum.energy += weight * part.energy;
        }
        sum
    }

    /// What these factors leave of one fold and joint.
    fn residual(&self, fold: usize, joint: usize, factors: &DVector<f64>) -> f64 {
        let part = &self.equations[fold][joint];
        part.residual_energy(&DVector::from_fn(part.moment.len(), |column, _| factors[self.place(joint, column)]))
    }
}

/// q, q̇, q̈ and τ of one sample.
fn state(run: &Trajectory, sample: usize) -> [[f64; MOST_JOINTS]; 4] {
    run.signals().map(|(_, signal)| {
        let mut state = [0.0; MOST_JOINTS];
        state.iter_mut().zip(signal.at(sample)).for_each(|(place, value)| *place = value);
        state
    })
}

/// The sign of a velocity that has passed a low-pass.
fn direction(qd: f64, fastest: f64) -> f64 {
    if fastest > 0.0 { (qd / (REVERSAL * fastest)).tanh() } else { 0.0 }
}

/// What the signs of identified parameters say, each time in all folds.
struct Signs<'a> {
    body: &'a Body,
    thin: &'a Recording,
    parts: &'a Parts,
    /// Found without each fold.
    factors: &'a [DVector<f64>],
}

impl Signs<'_> {
    /// Joints that would need power to be moved by hand, or less torque to be accelerated the more they are.
    fn impossible(&self) -> Vec<usize> {
        let (joints, width) = (self.parts.joints, self.parts.width);
        let samples: Vec<(&Trajectory, usize)> = self.samples().collect();
        let mut rows = vec![0.0; joints * width];
        // H_jj as a row of the body's parameters, its mean over the motion.
        let mut inertias = vec![vec![0.0; width]; joints];
        let (still, mut unit) = ([0.0; MOST_JOINTS], [0.0; MOST_JOINTS]);
        let mut powers = vec![[0.0; 3]; joints]; // Σ q̇², Σ |q̇| smeared, Σ q̈²
        for (run, sample) in &samples {
            let [q, qd, qdd, _] = state(run, *sample);
            for joint in 0..joints {
                unit[joint] = 1.0;
                self.body.fill(false, [&q[..joints], &still[..joints], &unit[..joints]], &mut rows);
                unit[joint] = 0.0;
                let row = &rows[joint * width..(joint + 1) * width];
                inertias[joint].iter_mut().zip(row).for_each(|(sum, value)| *sum += value / samples.len() as f64);
                let smeared = qd[joint] * direction(qd[joint], self.parts.fastest[joint]);
                let own = [qd[joint].powi(2), smeared, qdd[joint].powi(2)];
                powers[joint].iter_mut().zip(own).for_each(|(sum, value)| *sum += value / samples.len() as f64);
            }
        }
        let is_impossible = |joint: &usize| {
            let joint = *joint;
            let torque = self.parts.variances[joint].sqrt();
            let [speed, smeared, acceleration] = powers[joint];
            let negative = |value: &dyn Fn(&DVector<f64>) -> f64, least: f64| {
                self.factors.iter().all(|factors| value(factors) < -least)
            };
            let own = |factors: &DVector<f64>, column: usize| factors[self.parts.place(joint, width + column)];
            let inertia = |factors: &DVector<f64>| {
                let body: f64 = inertias[joint].iter().zip(factors.iter()).map(|(row, factor)| row * factor).sum();
                (body + own(factors, 3)) * acceleration.sqrt()
            };
            let friction = |factors: &DVector<f64>| {
                (own(factors, 1) * speed + own(factors, 2) * smeared) / speed.sqrt().max(f64::MIN_POSITIVE)
            };
            negative(&inertia, LEAST_INERTIA * torque) || negative(&friction, LEAST_FRICTION * torque)
        };
        (0..joints).filter(is_impossible).collect()
    }

    /// How many links of a planar arm have their weight along them, and how many against, where it matters.
    fn links(&self) -> [usize; 2] {
        let Body::Planar(_) = self.body else { return [0; 2] };
        let joints = self.parts.joints;
        let first = self.parts.width - joints;
        let matters = |link: usize, sign: f64| {
            let torque = self.parts.variances[link].sqrt();
            self.factors.iter().all(|factors| sign * GRAVITY * factors[first + link] > LEAST_GRAVITY * torque)
        };
        [1.0, -1.0].map(|sign| (0..joints).filter(|&link| matters(link, sign)).count())
    }

    /// Some samples from everywhere.
    fn samples(&self) -> impl Iterator<Item = (&Trajectory, usize)> {
        let every = (self.thin.sample_count() / SIGN_SAMPLES).max(1);
        let all = self.thin.trajectories.iter().flat_map(|run| (0..run.len()).map(move |sample| (run, sample)));
        all.step_by(every)
    }
}
