//! What of each joint's torque is neither inertia, Coriolis nor gravity, over its velocity: as it was measured, as a model has
//! it, and as it truly is. Mostly that is friction, and its curve shows which.

use super::{TrainError, components};
use crate::model::fit::interval_quantile;
use crate::model::{Fitted, Prediction};
use crate::recording::Trajectory;
use crate::signals::Signals;

/// So many stretches of velocity, each with its own value.
const STRETCHES: usize = 41;
/// A stretch with fewer samples has none.
const FEWEST: usize = 5;
/// A stretch that was passed fewer times has no interval.
const FEWEST_PASSES: usize = 3;
/// Samples that are asked of all runs together, at most.
const MOST_SAMPLES: usize = 40_000;
/// The band holds what lies between these parts of the samples of a stretch.
const BAND: [f64; 2] = [0.1, 0.9];

/// What is left of a joint's torque, over its velocity; NaN where hardly anything was recorded.
#[derive(Debug, Clone, PartialEq)]
pub struct FrictionCurve {
    /// The middles of the stretches \[rad/s or m/s\].
    pub velocity: Vec<f64>,
    /// Of the measured torque less the model's inertia, Coriolis and gravity: velocity, and between which torques eight of ten
    /// samples lie \[N m or N\].
    pub band: Vec<[f64; 3]>,
    /// Its mean \[N m or N\].
    pub measured: Vec<f64>,
    /// Velocity, and between which torques that mean lies with a probability of 95 %, where the stretch was passed often enough to
    /// tell. Samples of one pass through a stretch are not independent, so the passes are counted, as clusters of unequal size
    /// (Cochran, Sampling Techniques, 3rd ed., ch. 9A) \[N m or N\].
    pub interval: Vec<[f64; 3]>,
    /// The same part of the model's torque, in the mean \[N m or N\].
    pub model: Vec<f64>,
}

/// The curves of all joints, from all runs together; `predictions` are those of the model along them.
///
/// # Errors
/// [`TrainError`] if a run is of another arm.
pub fn curves(
    fitted: &Fitted,
    runs: &[Trajectory],
    predictions: &[Prediction],
) -> Result<Vec<FrictionCurve>, TrainError> {
    let mut joints: Vec<Vec<Vec<[f64; 3]>>> = vec![Vec::new(); runs.first().map_or(0, Trajectory::joint_count)];
    let every = thinning(runs);
    for (run, prediction) in runs.iter().zip(predictions) {
        let few = run.thinned(every);
        let rigid = rigid_part(fitted, &few)?;
        for (joint, samples) in joints.iter_mut().enumerate() {
            let left = |sample: usize| {
                let rigid = rigid[joint][sample];
                let model = prediction.total[joint][sample * every];
                [few.qd[joint][sample], few.tau[joint][sample] - rigid, model - rigid]
            };
            samples.push((0..few.len()).map(left).collect());
        }
    }
    Ok(joints.into_iter().map(|samples| FrictionCurve::of(&samples)).collect())
}

/// The mean of torques over the velocity of each joint, in the stretches of its curve: `torques[run]` is as long as that run.
pub fn means(curves: &[FrictionCurve], runs: &[Trajectory], torques: &[Signals]) -> Vec<Vec<f64>> {
    let every = thinning(runs);
    let mean = |(joint, curve): (usize, &FrictionCurve)| {
        let mut stretches = vec![Vec::new(); curve.velocity.len()];
        for (run, torque) in runs.iter().zip(torques) {
            for sample in (0..run.len()).step_by(every) {
                if let Some(stretch) = curve.stretch_of(run.qd[joint][sample]) {
                    stretches[stretch].push(torque[joint][sample]);
                }
            }
        }
        stretches.iter().map(|values| mean_of(values)).collect()
    };
    curves.iter().enumerate().map(mean).collect()
}

/// One sample in so many is asked.
fn thinning(runs: &[Trajectory]) -> usize {
    runs.iter().map(Trajectory::len).sum::<usize>().div_ceil(MOST_SAMPLES).max(1)
}

/// Inertial, Coriolis and gravity torque of a model together.
fn rigid_part(fitted: &Fitted, run: &Trajectory) -> Result<Signals, TrainError> {
    let mut sum = Signals::zeros(run.joint_count(), run.len());
    let named = components(fitted, run)?;
    for (_, torque) in named.iter().filter(|(name, _)| ["inertial", "coriolis", "gravity"].contains(name)) {
        sum.add(torque, 1.0);
    }
    Ok(sum)
}

fn mean_of(values: &[f64]) -> f64 {
    if values.len() < FEWEST { f64::NAN } else { values.iter().sum::<f64>() / values.len() as f64 }
}

/// Half the interval that holds the mean of all samples with a probability of 95 %; `passes` are sums and numbers of samples.
fn half_interval(passes: &[[f64; 2]]) -> Option<f64> {
    if passes.len() < FEWEST_PASSES {
        return None;
    }
    let [sum, samples] = [0, 1].map(|of| passes.iter().map(|pass| pass[of]).sum::<f64>());
    let (mean, count) = (sum / samples, passes.len() as f64);
    let squares: f64 = passes.iter().map(|[sum, samples]| (sum - mean * samples).powi(2)).sum();
    Some(interval_quantile(passes.len()) * (count / (count - 1.0) * squares).sqrt() / samples)
}

/// The value below which a part of sorted values lies.
fn quantile(sorted: &[f64], part: f64) -> f64 {
    sorted.get((part * (sorted.len() - 1) as f64).round() as usize).copied().unwrap_or(f64::NAN)
}

impl FrictionCurve {
    /// Of the samples of each run: velocity, what is left of the measured and what of the predicted torque.
    fn of(runs: &[Vec<[f64; 3]>]) -> Self {
        let fastest = runs.iter().flatten().map(|[velocity, ..]| velocity.abs()).fold(0.0, f64::max);
        let middle = |stretch: usize| fastest * ((2 * stretch + 1) as f64 / STRETCHES as f64 - 1.0);
        let velocity: Vec<f64> = (0..STRETCHES).map(middle).collect();
        let empty = || vec![f64::NAN; STRETCHES];
        let mut curve =
            FrictionCurve { velocity, band: Vec::new(), measured: empty(), interval: Vec::new(), model: empty() };
        let mut stretches = vec![[const { Vec::new() }; 2]; STRETCHES];
        // Of each pass through a stretch: the sum of its samples and their number.
        let mut passes: Vec<Vec<[f64; 2]>> = vec![Vec::new(); STRETCHES];
        for run in runs {
            let mut before = None;
            for [velocity, measured, model] in run {
                let Some(stretch) = curve.stretch_of(*velocity) else { continue };
                stretches[stretch][0].push(*measured);
                stretches[stretch][1].push(*model);
                if before != Some(stretch) {
                    passes[stretch].push([0.0; 2]);
                }
                if let Some([sum, count]) = passes[stretch].last_mut() {
                    (*sum, *count) = (*sum + measured, *count + 1.0);
                }
                before = Some(stretch);
            }
        }
        for (stretch, [mut measured, model]) in stretches.into_iter().enumerate() {
            curve.model[stretch] = mean_of(&model);
            if measured.len() < FEWEST {
                continue;
            }
            measured.sort_by(f64::total_cmp);
            curve.measured[stretch] = mean_of(&measured);
            curve.interval.extend(
                half_interval(&passes[stretch]).map(|half| {
                    [curve.velocity[stretch], curve.measured[stretch] - half, curve.measured[stretch] + half]
                }),
            );
            let [low, high] = BAND.map(|part| quantile(&measured, part));
            curve.band.push([curve.velocity[stretch], low, high]);
        }
        curve
    }

    /// In which stretch a velocity lies.
    fn stretch_of(&self, velocity: f64) -> Option<usize> {
        let (first, last) = (self.velocity.first()?, self.velocity.last()?);
        let width = (last - first) / (self.velocity.len() - 1) as f64;
        let place = ((velocity - first) / width).round();
        (place >= 0.0 && place < self.velocity.len() as f64).then_some(place as usize)
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution as _, StandardNormal};

    use super::*;
    use crate::model::{self, Evaluation, Preset};
    use crate::progress::Monitor;
    use crate::recording::seal::HiddenEffect;
    use crate::recording::split::Split;
    use crate::simulation::{Excitation, Scenario, simulate};

    /// The interval holds the true mean about as often as it says, although the samples of a pass go together.
    #[test]
    fn the_interval_counts_passes_and_not_samples() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let draws = 400;
        let mut held = 0;
        for _ in 0..draws {
            let pass = |random: &mut ChaCha8Rng| {
                let (offset, samples) = (StandardNormal.sample(random), random.random_range(5..30));
                let offset: f64 = offset;
                [f64::from(samples) * offset, f64::from(samples)]
            };
            let passes: Vec<[f64; 2]> = (0..12).map(|_| pass(&mut random)).collect();
            let [sum, samples] = [0, 1].map(|of| passes.iter().map(|pass| pass[of]).sum::<f64>());
            held += usize::from((sum / samples).abs() < half_interval(&passes).unwrap());
        }
        let share = held as f64 / draws as f64;
        assert!((0.89..0.99).contains(&share), "{share}");
        assert_eq!(half_interval(&[[1.0, 1.0], [2.0, 1.0]]), None, "two passes tell nothing");
    }

    /// A rigid body with the true friction has it as its curve, and the measurement lies on it; a bare one has none.
    #[test]
    fn the_curve_of_a_known_friction_is_found() {
        let motion = Excitation::PaperPointToPoint { trajectories: 8, duration: 4.0, samples: 400, range: 3.0 };
        let mut scenario = Scenario { effects: Vec::new(), torque_noise: 0.0, motion, ..Scenario::embedded() };
        scenario.effects.push(HiddenEffect {
            effect: "viscous-friction".to_owned(),
            joint: Some(1),
            parameters: vec![0.8],
        });
        let recording = simulate(&scenario, &Monitor::new()).unwrap();
        let bare = Preset::StatedArm.model(&recording).unwrap();
        let split = Split::automatic(&recording);
        let fitted = model::fit(&bare, &recording, &split, &Monitor::new()).unwrap();
        let evaluation = Evaluation::of(&fitted, &recording, &split).unwrap();
        let runs = &recording.trajectories;
        let found = curves(&fitted, runs, &evaluation.predictions).unwrap();
        let known = |values: &[f64]| values.iter().filter(|value| value.is_finite()).count();
        for (joint, factor) in [0.0, 0.8, 0.0].into_iter().enumerate() {
            let curve = &found[joint];
            assert!(known(&curve.measured) > 20 && curve.band.len() == known(&curve.measured));
            let width = curve.velocity[1] - curve.velocity[0];
            for (velocity, measured) in
                curve.velocity.iter().zip(&curve.measured).filter(|(_, value)| value.is_finite())
            {
                assert!(
                    (measured - factor * velocity).abs() < factor * width + 1e-6,
                    "{joint}: {measured} at {velocity}"
                );
            }
            assert!(curve.model.iter().filter(|value| value.is_finite()).all(|value| value.abs() < 1e-6));
        }
        let torques: Vec<Signals> = runs.iter().map(|run| run.qd.map(|velocity| 0.8 * velocity)).collect();
        let truth = means(&found, runs, &torques);
        let width = found[1].velocity[1] - found[1].velocity[0];
        let near = |(own, truth): (&f64, &f64)| own.is_nan() || (own - truth).abs() < width;
        assert!(found[1].measured.iter().zip(&truth[1]).all(near));
    }
}
