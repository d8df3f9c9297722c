//! Which motion would tell two explanations apart.
//!
//! The model with everything that was found predicts the torque of other motions; the rival is fitted to that prediction. What
//! it can't copy there is the evidence that such a motion would give, in units of the noise of the data at hand. It is
//! computed, so it holds for this arm, these parameters and these two effects.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::report::{Exciting, MissingEffect, TellingMotion};
use super::search::Search;
use crate::effect::{Effect, Scope};
use crate::model::design::Design;
use crate::model::{EffectTerm, Fitted, Model, Term};
use crate::progress::{Monitor, Stopped};
use crate::recording::split::Split;
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

/// Says of each effect which motion tells it from the closest of its rivals, of which each is given with the group that it stands for. What
/// is named itself is no alternative to another.
///
/// # Errors
/// [`Stopped`] if somebody stopped it.
pub fn tell_apart(
    effects: &mut [MissingEffect],
    rivals_of: Vec<Vec<(usize, usize)>>,
    search: &Search,
    fitted: &Fitted,
    monitor: &Monitor,
) -> Result<(), Stopped> {
    let places: Vec<(&Effect, Vec<usize>)> = effects.iter().map(|it| (it.effect, it.joints.clone())).collect();
    let is_named = |effect: &Effect, joint: Option<usize>| {
        joint.is_some_and(|joint| places.iter().any(|(other, joints)| *other == effect && joints.contains(&joint)))
    };
    let tell = |(effect, rivals): (&mut MissingEffect, Vec<(usize, usize)>)| {
        effect.alternatives.retain(|other| !is_named(other.effect, other.elsewhere));
        let joints = &effect.joints;
        let is_open = |&(group, rival): &(usize, usize)| {
            let [group, rival] = [group, rival].map(|it| &search.library.groups[it]);
            let stays = group.joint.is_none_or(|joint| joints.contains(&joint));
            stays && !is_named(rival.effect, rival.joint)
        };
        let closest = rivals.into_iter().find(is_open);
        effect.telling_motion = closest.and_then(|(group, rival)| best_motion(search, fitted, group, rival));
        monitor.check()
    };
    effects.par_iter_mut().zip(rivals_of).try_for_each(tell)
}

/// The motion that best tells `group` from `rival`; `None` if none does better than the motion at hand.
fn best_motion(search: &Search, fitted: &Fitted, group: usize, rival: usize) -> Option<TellingMotion> {
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
    let split = Split { train: recording.runs().collect(), ..Split::default() };
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::Arm;
    use crate::diagnosis::Searched;
    use crate::diagnosis::excerpt::Excerpt;
    use crate::diagnosis::report::Alternative;
    use crate::effect::registry;
    use crate::model::{self, Preset};
    use crate::progress::Monitor;
    use crate::recording::Channels;
    use crate::recording::seal::HiddenEffect;
    use crate::signals::Signals;
    use crate::simulation::{Excitation, Scenario, simulate};

    /// One joint that swings with 0.8 Hz and amplitude 0.5 about 1, at 100 Hz.
    fn swing() -> Trajectory {
        let rate = TAU * 0.8;
        let time: Vec<f64> = (0..500).map(|sample| f64::from(sample) * 0.01).collect();
        let signal = |f: &dyn Fn(f64) -> f64| Signals::from_fn(1, time.len(), |_, sample| f(rate * time[sample]));
        let channels = Channels {
            q: signal(&|phase| 1.0 + 0.5 * phase.sin()),
            qd: signal(&|phase| 0.5 * rate * phase.cos()),
            qdd: signal(&|phase| -0.5 * rate * rate * phase.sin()),
            tau: signal(&|_| 0.0),
            time: time.clone(),
        };
        Trajectory::new("swing", channels).unwrap()
    }

    fn moved_by(motion: Exciting) -> Trajectory {
        let mut run = swing();
        apply(motion, 0, &mut run);
        run
    }

    /// Whether q̇ and q̈ are what q does, but for a share of samples where it turns round.
    fn fits_together(run: &Trajectory, turns: usize) -> bool {
        let odd = |one: &[f64], other: &[f64]| {
            let top = other.iter().fold(1e-9, |top: f64, value| top.max(value.abs()));
            let pair = |t: usize| ((one[t + 1] - one[t]) / 0.01 - 0.5 * (other[t] + other[t + 1])).abs() > 0.02 * top;
            (0..one.len() - 1).filter(|&t| pair(t)).count()
        };
        odd(&run.q[0], &run.qd[0]) <= turns && odd(&run.qd[0], &run.qdd[0]) <= turns
    }

    #[test]
    fn what_is_played_faster_or_slower_is_the_same_path() {
        let slow = moved_by(Exciting::Speed { factor: 0.25 });
        let original = swing();
        for (sample, place) in [(400, 100), (402, 100)] {
            let share = f64::from(sample % 4) / 4.0;
            let at = |signal: &[f64]| signal[place] + share * (signal[place + 1] - signal[place]);
            assert!((slow.q[0][sample as usize] - at(&original.q[0])).abs() < 1e-12);
            assert!((slow.qd[0][sample as usize] - 0.25 * at(&original.qd[0])).abs() < 1e-12);
            assert!((slow.qdd[0][sample as usize] - 0.0625 * at(&original.qdd[0])).abs() < 1e-12);
        }
        let fast = moved_by(Exciting::Speed { factor: 2.5 });
        assert!(fits_together(&slow, 0) && fits_together(&fast, 6));
        // It comes back where it ends.
        let on_the_way_back = 2 * 499 - 5 * 300 / 2;
        assert!((fast.q[0][300] - original.q[0][on_the_way_back]).abs() < 1e-9);
        assert!((fast.qd[0][300] + 2.5 * original.qd[0][on_the_way_back]).abs() < 1e-9);
    }

    #[test]
    fn other_motions_keep_to_the_range_and_fit_together() {
        let wide = moved_by(Exciting::Range { factor: 1.5 });
        assert!(fits_together(&wide, 0));
        let [low, high] = ends(wide.q[0].iter().copied());
        assert!((low - 0.25).abs() < 1e-3 && (high - 1.75).abs() < 1e-3, "{low} to {high}");
        let tiny = moved_by(Exciting::TinyReversals);
        let [low, high] = ends(tiny.q[0].iter().copied());
        assert!(fits_together(&tiny, 0) && (high - low - 2.0 * TINY).abs() < 1e-3, "{low} to {high}");
        let sweeps = moved_by(Exciting::Sweeps);
        let [low, high] = ends(sweeps.q[0].iter().copied());
        assert!(fits_together(&sweeps, 20) && low > 0.49 && high < 1.51, "{low} to {high}");
        let speed = SWEEPS[0] * swing().qd[0].iter().fold(0.0, |top: f64, qd| top.max(qd.abs()));
        assert!(sweeps.qd[0].iter().all(|qd| (qd.abs() - speed).abs() < 1e-12));
        assert_eq!(moved_by(Exciting::Alone { joint: 0 }), swing());
        let still = moved_by(Exciting::Alone { joint: 1 });
        assert!(
            still.q[0].iter().all(|q| (q - 1.0).abs() < 1e-3)
                && still.qd[0].iter().chain(&still.qdd[0]).all(|rate| *rate == 0.0)
        );
    }

    #[test]
    fn a_fast_log_is_thinned_to_a_moderate_rate() {
        let channels = |count: usize| {
            let signal = Signals::zeros(1, count);
            let time = (0..count).map(|sample| sample as f64 * 0.002).collect();
            Channels { time, q: signal.clone(), qd: signal.clone(), qdd: signal.clone(), tau: signal }
        };
        let thin = thinned(&Trajectory::new("fast", channels(10_000)).unwrap());
        assert_eq!(thin.len(), MOST_SAMPLES);
        assert!((thin.time_step() - 1.0 / RATE).abs() < 1e-12);
    }

    /// The peak of Stribeck friction near standstill is seen by slow motion; viscous friction, which is named itself, is no alternative.
    #[test]
    fn the_motion_that_tells_a_peak_near_standstill_is_slow() {
        let motion = Excitation::PaperPointToPoint { trajectories: 8, duration: 4.0, samples: 100, range: 2.0 };
        let hidden =
            HiddenEffect { effect: "stribeck-friction".into(), joint: Some(0), parameters: vec![1.5, 1.2, 0.05] };
        let scenario = Scenario { motion, arm: Arm::uniform(1), effects: vec![hidden], ..Scenario::embedded() };
        let (recording, monitor) = (simulate(&scenario, &Monitor::new()).unwrap(), Monitor::new());
        let split = Split::automatic(&recording);
        let [coulomb, viscous, stribeck] =
            ["coulomb-friction", "viscous-friction", "stribeck-friction"].map(|id| registry::find(id).unwrap());
        let fit = |model: &Model| model::fit(model, &recording, &split, &monitor).unwrap();
        let body = Preset::RigidBody.model(&recording).unwrap();
        let whole = fit(&body.with_effect(stribeck, &[0]).unwrap());
        let excerpt = Excerpt::of(&recording, &split);
        let searched = Searched::new(&[coulomb, viscous, stribeck], &fit(&body), &excerpt, &monitor).unwrap();
        let groups = &searched.search.library.groups;
        let [rival, named, group] =
            [coulomb, viscous, stribeck].map(|effect| groups.iter().position(|it| it.effect == effect).unwrap());
        let alternative = |effect, elsewhere| Alternative { effect, elsewhere, joints: Vec::new() };
        let open = alternative(coulomb, None);
        let alternatives = vec![open.clone(), alternative(viscous, Some(0))];
        let peak = MissingEffect { alternatives, ..MissingEffect::example(stribeck.id) };
        let mut effects = [peak, MissingEffect::example(viscous.id)];
        let rivals_of = vec![vec![(group, named), (group, rival)], Vec::new()];
        tell_apart(&mut effects, rivals_of, &searched.search, &whole, &monitor).unwrap();
        assert_eq!(effects[0].alternatives, [open]);
        assert_eq!(effects[1].telling_motion, None);
        let told = effects[0].telling_motion.unwrap();
        assert_eq!(told.against, coulomb);
        assert!(told.gain > LEAST_GAIN && told.gain.is_finite(), "{told:?}");
        let is_slow = |motion| match motion {
            Exciting::Speed { factor } => factor < 1.0,
            Exciting::TinyReversals | Exciting::Sweeps => true,
            Exciting::Range { .. } | Exciting::Alone { .. } => false,
        };
        assert!(is_slow(told.motion), "{told:?}");
    }
}
