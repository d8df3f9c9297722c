//! Which motion would tell two explanations apart.
//!
//! The model with everything that was found predicts the torque of other motions; the rival is fitted to that prediction. What
//! it can't copy there is the evidence that such a motion would give, in units of the noise of the data at hand. It is
//! computed, so it holds for this arm, these parameters and these two effects.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::report::{Exciting, TellingMotion};
use super::search::Search;
use crate::effect::Scope;
use crate::model::design::Design;
use crate::model::{EffectTerm, Fitted, Model, Term};
use crate::recording::split::{Segment, Split};
use crate::recording::{ChannelsMut, Recording, Trajectory};
use crate::statistics::ends;

/// Most trajectories of the recording that a motion is made from.
const MOST_TRAJECTORIES: usize = 4;
/// Most samples of each, about 100 in a second.
const MOST_SAMPLES: usize = 800;
/// Rate of the motions \[Hz\], if the recording is not slower.
const RATE: f64 = 100.0;
/// A motion is worth naming if it gives so many times the evidence of the motion at hand.
const LEAST_GAIN: f64 = 1.5;
/// Amplitude of tiny reversals, as a share of the range.
const TINY: f64 = 0.02;
/// Frequency of tiny reversals \[Hz\].
const REVERSALS: f64 = 0.5;
/// Speeds of sweeps at constant velocity, as shares of the largest.
const SWEEPS: [f64; 3] = [0.1, 0.4, 0.9];

/// The motion that best tells `group` from `rival`; `None` if none does better than the motion at hand.
pub fn best_motion(search: &Search, fitted: &Fitted, group: usize, rival: usize) -> Option<TellingMotion> {
    let groups = &search.library.groups;
    let evidence = |motion: Exciting| {
        let recording = moved(search.library.design.recording(), fitted, motion)?;
        evidence(&recording, search, fitted, &groups[group].term(), &groups[rival].term(), &groups[rival].shape)
    };
    let now = evidence(Exciting::Speed { factor: 1.0 })?;
    let joint = groups[group].joint.filter(|_| groups[group].effect.scope == Scope::Joint);
    let mut motions = vec![
        Exciting::Speed { factor: 2.5 },
        Exciting::Speed { factor: 0.25 },
        Exciting::Range { factor: 1.5 },
        Exciting::TinyReversals,
        Exciting::Sweeps,
    ];
    motions.extend(joint.filter(|_| fitted.setting().kinds.len() > 1).map(|joint| Exciting::Alone { joint }));
    let tried: Vec<(Exciting, f64)> =
        motions.into_par_iter().filter_map(|motion| Some((motion, evidence(motion)?))).collect();
    let best = tried.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let gain = best.1 / now.max(f64::MIN_POSITIVE);
    (gain > LEAST_GAIN && gain.is_finite()).then(|| TellingMotion {
        motion: best.0,
        against: groups[rival].effect,
        gain,
    })
}

/// Evidence for each sample of a recording against `rival` in the place of `term`, whose torque the recording has.
fn evidence(
    recording: &Recording,
    search: &Search,
    fitted: &Fitted,
    term: &EffectTerm,
    rival: &EffectTerm,
    shape: &[f64],
) -> Option<f64> {
    let kept = |other: &Term| !matches!(other, Term::Effect(other) if other == term);
    let (mut terms, mut shapes): (Vec<Term>, Vec<Vec<f64>>) =
        fitted.model.terms.iter().cloned().zip(fitted.shapes().iter().cloned()).filter(|(term, _)| kept(term)).unzip();
    terms.push(Term::Effect(rival.clone()));
    shapes.push(shape.to_vec());
    let segment = |(trajectory, data): (usize, &Trajectory)| Segment { trajectory, samples: 0..data.len() };
    let split = Split { train: recording.trajectories.iter().enumerate().map(segment).collect(), ..Split::default() };
    let design = Design::in_setting(recording, &split, fitted.setting()).ok()?;
    let model = Model { terms };
    let columns = design.columns(&model, &shapes).ok()?;
    let equations = design.equations(&columns, &design.unexplained_torque(&model).ok()?);
    let samples: usize = (0..recording.joint_count()).map(|joint| design.sample_count(joint)).sum();
    let left = equations.total(&search.weights, |_| true).solve().residual_energy;
    (samples > 0).then(|| left / samples as f64)
}

/// The recording with another motion and the torque that the model predicts for it.
fn moved(recording: &Recording, fitted: &Fitted, motion: Exciting) -> Option<Recording> {
    let mut trajectories = Vec::new();
    for (number, original) in recording.trajectories.iter().take(MOST_TRAJECTORIES).enumerate() {
        let mut trajectory = thinned(original);
        if trajectory.len() < 3 {
            continue;
        }
        apply(motion, number, &mut trajectory);
        trajectory.set_torque(fitted.predict(&trajectory).ok()?.total).ok()?;
        trajectories.push(trajectory);
    }
    (!trajectories.is_empty()).then(|| recording.with_trajectories(trajectories))
}

/// The start of a trajectory, at a moderate rate.
fn thinned(trajectory: &Trajectory) -> Trajectory {
    let every = (1.0 / (RATE * trajectory.time_step().max(1e-9))).round().max(1.0) as usize;
    trajectory.slice(0..trajectory.len().min(every * MOST_SAMPLES)).thinned(every)
}

/// Replaces the motion of one trajectory.
fn apply(motion: Exciting, number: usize, trajectory: &mut Trajectory) {
    let joints = trajectory.joint_count();
    let ChannelsMut { time, mut q, mut qd, mut qdd, .. } = trajectory.channels_mut();
    for joint in 0..joints {
        let (q, qd, qdd) = (&mut q[joint], &mut qd[joint], &mut qdd[joint]);
        let [low, high] = ends(q.iter().copied());
        let (middle, range) = (0.5 * (low + high), high - low);
        match motion {
            Exciting::Speed { factor } => {
                play_at(factor, [q, qd, qdd]);
            }
            Exciting::Range { factor } => {
                q.iter_mut().for_each(|q| *q = middle + factor * (*q - middle));
                let rates = qd.iter_mut().chain(qdd);
                rates.for_each(|rate| *rate *= factor);
            }
            Exciting::Alone { joint: moving } if joint == moving => {}
            Exciting::Alone { .. } => {
                q.fill(middle);
                qd.fill(0.0);
                qdd.fill(0.0);
            }
            Exciting::TinyReversals => {
                let (size, rate) = (TINY * range, TAU * REVERSALS);
                for (t, time) in time.iter().enumerate() {
                    let phase = rate * time + joint as f64;
                    // Each trajectory about another place of the range.
                    let place = middle + (number as f64 / MOST_TRAJECTORIES as f64 - 0.4) * 0.8 * range;
                    q[t] = place + size * phase.sin();
                    qd[t] = size * rate * phase.cos();
                    qdd[t] = -size * rate * rate * phase.sin();
                }
            }
            Exciting::Sweeps => {
                let fastest = qd.iter().fold(0.0, |most: f64, qd| most.max(qd.abs()));
                let speed = SWEEPS[(number + joint) % SWEEPS.len()] * fastest;
                for (t, time) in time.iter().enumerate() {
                    // Distance travelled, folded into the range.
                    let travelled = (speed * time + 0.3 * joint as f64 * range).rem_euclid(2.0 * range.max(1e-9));
                    let forward = travelled < range;
                    q[t] = if forward { low + travelled } else { low + 2.0 * range - travelled };
                    qd[t] = if forward { speed } else { -speed };
                    qdd[t] = 0.0;
                }
            }
        }
    }
}

/// Plays position, velocity and acceleration at another speed, back and forth where they end.
fn play_at(factor: f64, [q, qd, qdd]: [&mut [f64]; 3]) {
    let last = (q.len() - 1) as f64;
    let originals = [q.to_vec(), qd.to_vec(), qdd.to_vec()];
    for t in 0..q.len() {
        let along = (factor * t as f64).rem_euclid(2.0 * last);
        let (place, direction) = if along <= last { (along, 1.0) } else { (2.0 * last - along, -1.0) };
        let (before, share) = (place.floor() as usize, place.fract());
        let at =
            |signal: &[f64]| signal[before] + share * (signal[(before + 1).min(signal.len() - 1)] - signal[before]);
        q[t] = at(&originals[0]);
        qd[t] = direction * factor * at(&originals[1]);
        qdd[t] = factor * factor * at(&originals[2]);
    }
}
