//! What the noise of the readings makes of the torque that a model leaves.
//!
//! A model that lacks nothing leaves the noise of the torque, and what its terms make of the noise of the motion. What it leaves beyond
//! that is missing, however white it looks in the band of the fit: a gap that is crossed, a liquid that sloshes at every reversal. So the
//! readings are disturbed once more, by noise of the size that they have, and go the same way as they went: derivatives, filters, model.
//! What that changes in the residual is what their own noise did.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use crate::model::design::Design;
use crate::model::preparation::Preparation;
use crate::model::working::{are_derivatives_made_anew, in_wide_band};
use crate::model::{Fitted, ModelError};
use crate::recording::{Origin, Recording, Trajectory};
use crate::signals::{Signals, SignalsMut};
use crate::statistics::white_noise_of_smooth;

/// What lies within the band of the fit is smooth over so many of the periods of its cut-off.
const SMOOTH: f64 = 0.1;
/// One draw of it is as good as another.
const SEED: u64 = 1;

/// RMS of what noise of the readings makes of the residual of a model over that of the measured torque, by joint, where the model was
/// fitted to the `design` of a `log`. `None` where the readings don't tell their noise, since they were filtered or interpolated, and of a joint
/// that never moves.
///
/// # Errors
/// [`ModelError`] if a term can't be computed for a trajectory.
pub fn of_readings(model: &Fitted, log: &Recording, design: &Design) -> Result<Vec<Option<f64>>, ModelError> {
    let preparations = Preparation::of_all(log, design.follows_up_to());
    let smooth_over =
        |preparation: &Preparation| preparation.cutoff.map_or(0.0, |cutoff| SMOOTH / (cutoff * preparation.time_step));
    let widest = preparations.iter().map(smooth_over).fold(f64::INFINITY, f64::min) as usize;
    let noise = are_derivatives_made_anew(log, &preparations).then(|| Noise::of(log, widest)).flatten();
    let Some(noise) = noise else { return Ok(vec![None; log.joint_count()]) };
    let noisy = in_wide_band(&noise.more_of_it(log), &preparations);
    let change = |(clean, noisy): (&Trajectory, &Trajectory)| {
        let mut change = noisy.tau.clone();
        change.add(&clean.tau, -1.0);
        change.add(&model.predict(noisy)?.total, -1.0);
        change.add(&model.predict(clean)?.total, 1.0);
        Ok(change)
    };
    let changes = design.recording().trajectories.par_iter().zip(&noisy).map(change);
    let shares = design.shares_of(&changes.collect::<Result<Vec<Signals>, ModelError>>()?);
    let told = |(share, tau): (f64, Option<f64>)| tau.map(|_| share).filter(|share| share.is_finite());
    Ok(shares.into_iter().zip(noise.tau).map(told).collect())
}

/// Deviations of the white noise of each joint's readings, in their units.
struct Noise {
    q: Vec<f64>,
    /// Of a velocity that was measured.
    qd: Option<Vec<f64>>,
    /// Of an acceleration that was measured.
    qdd: Option<Vec<f64>>,
    /// Where it tells its noise.
    tau: Vec<Option<f64>>,
}

impl Noise {
    /// By differences of samples that are not further apart than the `widest` step. `None` where that of the motion of a joint can't be told:
    /// it makes torque on all others.
    fn of(log: &Recording, widest: usize) -> Option<Noise> {
        let of_channel = |channel: fn(&Trajectory) -> &Signals| -> Vec<Option<f64>> {
            let of_joint = |joint: usize| {
                let runs: Vec<&[f64]> = log.trajectories.iter().map(|run| &channel(run)[joint]).collect();
                white_noise_of_smooth(&runs, widest)
            };
            (0..log.joint_count()).into_par_iter().map(of_joint).collect()
        };
        let all = |noise: Vec<Option<f64>>| noise.into_iter().collect::<Option<Vec<f64>>>();
        let (mut qd, mut qdd) = (None, None);
        if log.provenance.velocity == Origin::Measured {
            qd = Some(all(of_channel(|run| &run.qd))?);
        }
        if log.provenance.acceleration == Origin::Measured {
            qdd = Some(all(of_channel(|run| &run.qdd))?);
        }
        Some(Noise { q: all(of_channel(|run| &run.q))?, qd, qdd, tau: of_channel(|run| &run.tau) })
    }

    /// A recording with as much noise once more.
    fn more_of_it(&self, log: &Recording) -> Recording {
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        let tau: Vec<f64> = self.tau.iter().map(|noise| noise.unwrap_or(0.0)).collect();
        let mut noisy = log.clone();
        for run in &mut noisy.trajectories {
            let channels = run.channels_mut();
            let mut disturb = |mut signals: SignalsMut, noise: &[f64]| {
                for (values, deviation) in signals.iter_mut().zip(noise) {
                    for value in values {
                        let draw: f64 = StandardNormal.sample(&mut random);
                        *value += deviation * draw;
                    }
                }
            };
            disturb(channels.q, &self.q);
            if let Some(noise) = &self.qd {
                disturb(channels.qd, noise);
            }
            if let Some(noise) = &self.qdd {
                disturb(channels.qdd, noise);
            }
            disturb(channels.tau, &tau);
        }
        noisy
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{self, Preset};
    use crate::progress::Monitor;
    use crate::recording::differentiate::low_pass_joints;
    use crate::recording::split::Split;
    use crate::simulation::{Excitation, Scenario, simulate};

    /// Two runs at 500 Hz in which nothing is hidden, with so much noise of the torque and such encoders.
    fn log(torque_noise: f64, encoder_resolution: f64) -> Recording {
        let mut scenario =
            Scenario { torque_noise, encoder_resolution: Some(encoder_resolution), ..Scenario::embedded() };
        scenario.effects.clear();
        if let Excitation::MultiSine { trajectories, duration, rate, .. } = &mut scenario.motion {
            (*trajectories, *duration, *rate) = (2, 16.0, 500.0);
        }
        simulate(&scenario, &Monitor::new()).unwrap()
    }

    /// What a rigid body leaves of each joint, and what noise makes of that.
    fn left(log: &Recording) -> Vec<(f64, Option<f64>)> {
        let split = Split::automatic(log);
        let design = Design::new(log, &split).unwrap();
        let body = model::fit::fit_design(&Preset::RigidBody.model(log).unwrap(), &design, &Monitor::new()).unwrap();
        let residual = |run: &Trajectory| {
            let mut residual = run.tau.clone();
            residual.add(&body.predict(run).unwrap().total, -1.0);
            residual
        };
        let residuals: Vec<Signals> = design.recording().trajectories.iter().map(residual).collect();
        design.shares_of(&residuals).into_iter().zip(of_readings(&body, log, &design).unwrap()).collect()
    }

    #[test]
    fn a_model_that_lacks_nothing_leaves_what_noise_of_the_readings_makes() {
        for (torque_noise, encoder_resolution) in [(0.05, 1e-5), (1e-3, 1e-3), (0.02, 3e-4)] {
            for (left, noise) in left(&log(torque_noise, encoder_resolution)) {
                let times = left / noise.unwrap();
                assert!(
                    (0.8..1.25).contains(&times),
                    "{torque_noise}, {encoder_resolution} rad: × {times} of {noise:?}"
                );
            }
        }
    }

    /// Its encoder is noisy all the same.
    #[test]
    fn of_a_joint_that_rests_nothing_is_told() {
        let mut resting = log(0.02, 3e-4);
        let mut random = ChaCha8Rng::seed_from_u64(2);
        for run in &mut resting.trajectories {
            let mut channels = run.channels_mut();
            channels.q[1].fill_with(|| 1e-6 * Distribution::<f64>::sample(&StandardNormal, &mut random));
            channels.qd[1].fill(0.0);
            channels.qdd[1].fill(0.0);
        }
        let told: Vec<bool> = left(&resting).iter().map(|(_, noise)| noise.is_some()).collect();
        assert_eq!(told, [true, false, true]);
    }

    #[test]
    fn what_was_filtered_does_not_tell_its_noise() {
        let mut filtered = log(0.02, 3e-4);
        for run in &mut filtered.trajectories {
            let smooth = low_pass_joints(&run.tau, 0.002, 30.0);
            run.set_torque(smooth).unwrap();
        }
        assert!(left(&filtered).iter().all(|(left, noise)| *left > 0.0 && noise.is_none()));
    }
}
