//! How the error of models grows outside the data they were identified from.
//!
//! Where the recording was simulated, the held-out runs are travelled again, faster, wider or under load, and the exact torque is computed
//! from the sealed arm and effects: a new experiment on the same arm, which tells nothing of what is hidden. Where it was
//! measured, nobody can drive the arm again, so the held-out data are cut into blocks and sorted by how fast (or how far out)
//! they are.

use serde::{Deserialize, Serialize};

use super::hidden;
use super::{SimulationError, demand};
use crate::model::{Fitted, ModelError};
use crate::progress::{Monitor, Stopped};
use crate::recording::seal::{SealError, Truth};
use crate::recording::split::{Segment, Split};
use crate::recording::{Recording, Trajectory};
use crate::signals::Signals;

/// The scales at which simulated runs are travelled again.
pub const SCALES: [f64; 9] = [1.0, 1.25, 1.5, 1.75, 2.0, 2.25, 2.5, 2.75, 3.0];
/// Length of a block \[s\].
const BLOCK: f64 = 1.0;
/// Fewest samples of a block.
const FEWEST_IN_BLOCK: usize = 20;
/// Into how many groups the blocks of a measured recording are sorted, at most.
const GROUPS: usize = 8;
/// Fewest blocks of a group.
const FEWEST_IN_GROUP: usize = 4;
/// The band holds the blocks between these quantiles.
const BAND: [f64; 2] = [0.1, 0.9];

/// In which way the motion leaves the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stretch {
    /// The same paths, travelled so many times as fast.
    #[default]
    Speed,
    /// Paths so many times as wide about their middle, in the same time.
    Range,
    /// The same paths with a last link so many times as heavy.
    Load,
}

impl Stretch {
    /// All.
    pub const ALL: [Stretch; 3] = [Stretch::Speed, Stretch::Range, Stretch::Load];

    /// What is scaled, in a word.
    pub fn name(self) -> &'static str {
        match self {
            Stretch::Speed => "speed",
            Stretch::Range => "range",
            Stretch::Load => "load",
        }
    }
}

/// Where the torque of the curves is from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Basis {
    /// Exact, from the sealed truth of a simulated recording.
    Simulated,
    /// Measured: held-out blocks sorted by their speed or range.
    Measured,
}

/// Error over scale, for one model or several.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sweep {
    /// What is scaled.
    pub stretch: Stretch,
    /// Where the torque is from.
    pub basis: Basis,
    /// One for each model.
    pub curves: Vec<Curve>,
}

/// The errors of one model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Its name.
    pub model: String,
    /// By ascending scale.
    pub points: Vec<Point>,
}

/// The error at one scale.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Times the speed (range) of the data; of a measured recording relative to the mean of its training part.
    pub scale: f64,
    /// nMSE of each joint: Σ(τ − τ̂)² / Στ².
    pub joints: Vec<f64>,
    /// nMSE of all joints together.
    pub overall: f64,
    /// Between these lies the error of four in five blocks of about a second, in the unit of `overall`.
    pub band: [f64; 2],
}

/// One trajectory at one scale.
#[derive(Debug, Clone, PartialEq)]
pub struct Replay {
    /// The motion; its torque is exact for a simulated recording, else as measured at scale 1.
    pub motion: Trajectory,
    /// Torque of the model \[N m\].
    pub predicted: Signals,
    /// Whether the motion's torque is that at this scale.
    pub exact: bool,
}

/// The error can't be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ExtrapolationError {
    /// There is nothing to judge by.
    #[error("no data are held out, so there is nothing to judge the model by: hold out a trajectory")]
    NothingHeldOut,
    /// Too little is held out to be sorted.
    #[error(
        "the held-out data are {blocks} blocks of a second, too few to be sorted by speed: hold out {FEWEST_IN_GROUP} s or more"
    )]
    TooShort {
        /// How many there are.
        blocks: usize,
    },
    /// A model can't be used on the motion.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The truth can't be read.
    #[error(transparent)]
    Seal(#[from] SealError),
    /// The truth can't be simulated.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// Stopped by the user.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// Error of every model over scale, on the held-out part of the recording.
///
/// # Errors
/// [`ExtrapolationError`] says what is lacking.
pub fn sweep(
    recording: &Recording,
    split: &Split,
    models: &[(String, &Fitted)],
    stretch: Stretch,
    monitor: &Monitor,
) -> Result<Sweep, ExtrapolationError> {
    if split.held_out.is_empty() {
        return Err(ExtrapolationError::NothingHeldOut);
    }
    let (basis, points) = match &recording.seal {
        Some(seal) => (Basis::Simulated, simulated(recording, split, &seal.open()?, models, stretch, monitor)?),
        None => (Basis::Measured, measured(recording, split, models, stretch, monitor)?),
    };
    let curve = |((name, _), points): (&(String, &Fitted), Vec<Point>)| Curve { model: name.clone(), points };
    Ok(Sweep { stretch, basis, curves: models.iter().zip(points).map(curve).collect() })
}

/// One trajectory at one scale, with the torque that it needs and the torque that the model predicts.
///
/// # Errors
/// [`ExtrapolationError`] if the scale is not positive, or truth or model can't be computed.
pub fn replay(
    recording: &Recording,
    trajectory: usize,
    stretch: Stretch,
    scale: f64,
    fitted: &Fitted,
) -> Result<Replay, ExtrapolationError> {
    demand("scale", scale, scale > 0.0, "a finite number above 0")?;
    let mut motion = stretched(&recording.trajectories[trajectory], stretch, scale);
    if let Some(seal) = &recording.seal {
        set_exact_torque(&mut motion, &loaded(seal.open()?, stretch, scale))?;
    }
    let predicted = fitted.predict(&motion)?.total;
    Ok(Replay { exact: recording.seal.is_some() || scale == 1.0, motion, predicted })
}

/// Squared error and squared torque of one block, by joint, and its length.
struct Block {
    error: Vec<f64>,
    torque: Vec<f64>,
    samples: usize,
}

fn simulated(
    recording: &Recording,
    split: &Split,
    truth: &Truth,
    models: &[(String, &Fitted)],
    stretch: Stretch,
    monitor: &Monitor,
) -> Result<Vec<Vec<Point>>, ExtrapolationError> {
    let mut curves = vec![Vec::new(); models.len()];
    for (number, scale) in SCALES.into_iter().enumerate() {
        let truth = loaded(truth.clone(), stretch, scale);
        let mut blocks: Vec<Vec<Block>> = models.iter().map(|_| Vec::new()).collect();
        for trajectory in trajectories(&split.held_out) {
            monitor.report(number as f32 / SCALES.len() as f32, &format!("scale {scale}"))?;
            let mut run = stretched(&recording.trajectories[trajectory], stretch, scale);
            set_exact_torque(&mut run, &truth)?;
            for ((_, fitted), blocks) in models.iter().zip(&mut blocks) {
                monitor.check()?;
                let predicted = fitted.predict(&run)?.total;
                for segment in split.held_out.iter().filter(|segment| segment.trajectory == trajectory) {
                    // Blocks of the original clock, so that each holds the same piece of the path at every scale.
                    for samples in cut(&recording.trajectories[trajectory], segment) {
                        blocks.push(Block::of(&run.tau, &predicted, samples));
                    }
                }
            }
        }
        for (curve, blocks) in curves.iter_mut().zip(&blocks) {
            curve.push(point(scale, &blocks.iter().collect::<Vec<_>>()));
        }
    }
    Ok(curves)
}

fn measured(
    recording: &Recording,
    split: &Split,
    models: &[(String, &Fitted)],
    stretch: Stretch,
    monitor: &Monitor,
) -> Result<Vec<Vec<Point>>, ExtrapolationError> {
    let usual = Usual::of(recording, split, stretch);
    let mut places = Vec::new();
    for segment in &split.held_out {
        let run = &recording.trajectories[segment.trajectory];
        places.extend(cut(run, segment).into_iter().map(|samples| {
            (usual.distance(run, samples.clone()), Segment { trajectory: segment.trajectory, samples })
        }));
    }
    if places.len() < FEWEST_IN_GROUP {
        return Err(ExtrapolationError::TooShort { blocks: places.len() });
    }
    places.sort_by(|one, other| one.0.total_cmp(&other.0));
    let groups = (places.len() / FEWEST_IN_GROUP).min(GROUPS);
    let mut curves = Vec::new();
    for (number, (name, fitted)) in models.iter().enumerate() {
        monitor.report(number as f32 / models.len() as f32, name)?;
        let mut predictions: Vec<Option<Signals>> = vec![None; recording.trajectories.len()];
        for trajectory in trajectories(&split.held_out) {
            monitor.check()?;
            predictions[trajectory] = Some(fitted.predict(&recording.trajectories[trajectory])?.total);
        }
        let block = |(_, segment): &(f64, Segment)| {
            let predicted = predictions[segment.trajectory].as_ref()?;
            let measured = &recording.trajectories[segment.trajectory].tau;
            Some(Block::of(measured, predicted, segment.samples.clone()))
        };
        let points = (0..groups).map(|group| {
            let members = &places[places.len() * group / groups..places.len() * (group + 1) / groups];
            let scale = members.iter().map(|member| member.0).sum::<f64>() / members.len() as f64;
            let blocks: Vec<Block> = members.iter().filter_map(block).collect();
            point(scale, &blocks.iter().collect::<Vec<_>>())
        });
        curves.push(points.collect());
    }
    Ok(curves)
}

/// The trajectories of these segments, each once.
fn trajectories(segments: &[Segment]) -> Vec<usize> {
    let mut numbers: Vec<usize> = segments.iter().map(|segment| segment.trajectory).collect();
    numbers.dedup();
    numbers
}

/// The same path, faster or wider.
fn stretched(run: &Trajectory, stretch: Stretch, scale: f64) -> Trajectory {
    let multiply = |values: &mut [f64], factor: f64| values.iter_mut().for_each(|value| *value *= factor);
    let mut new = run.clone();
    let mut channels = new.channels_mut();
    match stretch {
        Stretch::Speed => {
            channels.time.iter_mut().for_each(|time| *time /= scale);
            multiply(channels.qd.values_mut(), scale);
            multiply(channels.qdd.values_mut(), scale * scale);
        }
        Stretch::Range => {
            for joint in channels.q.iter_mut() {
                let middle = joint.iter().sum::<f64>() / joint.len().max(1) as f64;
                joint.iter_mut().for_each(|q| *q = middle + scale * (*q - middle));
            }
            multiply(channels.qd.values_mut(), scale);
            multiply(channels.qdd.values_mut(), scale);
        }
        // The arm changes, not its path.
        Stretch::Load => (),
    }
    new
}

/// The arm with a heavier last link, where the load is what is scaled.
fn loaded(mut truth: Truth, stretch: Stretch, scale: f64) -> Truth {
    if let (Stretch::Load, Some(last)) = (stretch, truth.arm.links.last_mut()) {
        (last.mass, last.inertia) = (scale * last.mass, scale * last.inertia);
    }
    truth
}

/// Gives the run the torque that the true arm with its hidden effects needs for it, without noise.
fn set_exact_torque(run: &mut Trajectory, truth: &Truth) -> Result<(), SimulationError> {
    run.set_torque(truth.arm.inverse_dynamics_along(&run.q, &run.qd, &run.qdd))?;
    let effects = hidden::resolve(&truth.effects, truth.arm.joint_count())?;
    hidden::add(&effects, &truth.arm, run)
}

/// The segment in blocks of about a second.
fn cut(run: &Trajectory, segment: &Segment) -> Vec<std::ops::Range<usize>> {
    let samples = segment.samples.len();
    let length = ((BLOCK / run.time_step().max(1e-9)) as usize).max(FEWEST_IN_BLOCK);
    let count = (samples / length).max(1);
    let start = segment.samples.start;
    (0..count).map(|block| start + samples * block / count..start + samples * (block + 1) / count).collect()
}

impl Block {
    fn of(tau: &Signals, predicted: &Signals, samples: std::ops::Range<usize>) -> Self {
        let squares = |joint: usize| {
            let (tau, model) = (&tau[joint][samples.clone()], &predicted[joint][samples.clone()]);
            tau.iter().zip(model).map(|(tau, model)| (tau - model).powi(2)).sum::<f64>()
        };
        let energy = |joint: usize| tau[joint][samples.clone()].iter().map(|tau| tau * tau).sum::<f64>();
        let joints = 0..tau.joint_count();
        Block {
            error: joints.clone().map(squares).collect(),
            torque: joints.map(energy).collect(),
            samples: samples.len(),
        }
    }
}

fn point(scale: f64, blocks: &[&Block]) -> Point {
    let joints = blocks.first().map_or(0, |block| block.error.len());
    let sum = |pick: fn(&Block) -> &[f64], joint: usize| blocks.iter().map(|block| pick(block)[joint]).sum::<f64>();
    let (errors, torques): (Vec<f64>, Vec<f64>) =
        (0..joints).map(|joint| (sum(|block| &block.error, joint), sum(|block| &block.torque, joint))).unzip();
    let samples: usize = blocks.iter().map(|block| block.samples).sum();
    // A block's own torque may be next to nothing, so its error is measured by the mean torque of all blocks.
    let mean_torque = torques.iter().sum::<f64>() / samples.max(1) as f64;
    let mut sizes: Vec<f64> = blocks
        .iter()
        .map(|block| block.error.iter().sum::<f64>() / block.samples.max(1) as f64 / mean_torque)
        .collect();
    sizes.sort_by(f64::total_cmp);
    let quantile = |share: f64| {
        let place = share * sizes.len().saturating_sub(1) as f64;
        let (low, high) = (sizes[place.floor() as usize], sizes[place.ceil() as usize]);
        low + (high - low) * place.fract()
    };
    Point {
        scale,
        joints: errors.iter().zip(&torques).map(|(error, torque)| error / torque).collect(),
        overall: errors.iter().sum::<f64>() / torques.iter().sum::<f64>(),
        band: BAND.map(quantile),
    }
}

/// What is usual in the training part: mean and size of q, or size of q̇ or τ, by joint.
struct Usual {
    stretch: Stretch,
    centre: Vec<f64>,
    size: Vec<f64>,
}

impl Usual {
    fn of(recording: &Recording, split: &Split, stretch: Stretch) -> Self {
        let segments = if split.train.is_empty() { &split.held_out } else { &split.train };
        let of_joint = |joint: usize| {
            let values = || {
                segments.iter().flat_map(move |segment| {
                    let run = &recording.trajectories[segment.trajectory];
                    &Self::signal(run, stretch)[joint][segment.samples.clone()]
                })
            };
            let count = values().count().max(1) as f64;
            let centre = if stretch == Stretch::Range { values().sum::<f64>() / count } else { 0.0 };
            (centre, (values().map(|value| (value - centre).powi(2)).sum::<f64>() / count).sqrt())
        };
        let (centre, size) = (0..recording.joint_count()).map(of_joint).unzip();
        Usual { stretch, centre, size }
    }

    fn signal(run: &Trajectory, stretch: Stretch) -> &Signals {
        match stretch {
            Stretch::Speed => &run.qd,
            Stretch::Range => &run.q,
            Stretch::Load => &run.tau,
        }
    }

    /// Root mean square over samples and joints, in units of what is usual.
    fn distance(&self, run: &Trajectory, samples: std::ops::Range<usize>) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for (joint, signal) in Self::signal(run, self.stretch).iter().enumerate() {
            for value in signal[samples.clone()].iter().filter(|_| self.size[joint] > 0.0) {
                sum += ((value - self.centre[joint]) / self.size[joint]).powi(2);
                count += 1.0;
            }
        }
        if count > 0.0 { (sum / count).sqrt() } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Scenario, simulate};
    use super::*;
    use crate::model::{Preset, fit};

    fn fitted(recording: &Recording, split: &Split, effect: Option<&str>) -> Fitted {
        let mut model = Preset::RigidBody.model(recording).unwrap();
        if let Some(effect) = effect {
            model = model.with_effect(crate::effect::registry::find(effect).unwrap(), &[0, 1]).unwrap();
        }
        fit(&model, recording, split, &Monitor::new()).unwrap()
    }

    /// Constant friction matters less the faster the arm moves, and the repaired model holds everywhere.
    #[test]
    fn the_error_of_missing_friction_falls_with_speed_and_the_repaired_model_stays() {
        let recording = simulate(&Scenario::embedded(), &Monitor::new()).unwrap();
        let split = Split::automatic(&recording);
        let (bare, repaired) = (fitted(&recording, &split, None), fitted(&recording, &split, Some("coulomb-friction")));
        let models = [("bare".to_owned(), &bare), ("repaired".to_owned(), &repaired)];
        let sweep = sweep(&recording, &split, &models, Stretch::Speed, &Monitor::new()).unwrap();
        assert_eq!((sweep.basis, sweep.curves.len()), (Basis::Simulated, 2));
        let overall = |curve: usize| sweep.curves[curve].points.iter().map(|point| point.overall).collect::<Vec<_>>();
        assert!(overall(0)[0] > 10.0 * overall(0)[8], "{:?}", overall(0));
        assert!(overall(1).iter().all(|error| *error < 1e-3), "{:?}", overall(1));
        for point in &sweep.curves[0].points {
            assert!(point.band[0] <= point.overall && point.overall <= 2.0 * point.band[1] && point.joints.len() == 3);
        }
    }

    /// At scale 1 the replay is the recording without its noise.
    #[test]
    fn a_replay_at_scale_one_is_the_recording() {
        let scenario = Scenario { torque_noise: 0.0, ..Scenario::embedded() };
        let recording = simulate(&scenario, &Monitor::new()).unwrap();
        let model = fitted(&recording, &Split::automatic(&recording), None);
        let at = |stretch, scale| replay(&recording, 1, stretch, scale, &model).unwrap();
        for stretch in Stretch::ALL {
            let replay = at(stretch, 1.0);
            for (one, other) in replay.motion.tau.iter().flatten().zip(recording.trajectories[1].tau.iter().flatten()) {
                assert!((one - other).abs() < 1e-9);
            }
        }
        let fast = at(Stretch::Speed, 2.0).motion;
        let heavy = at(Stretch::Load, 2.0).motion;
        assert_eq!(heavy.q, recording.trajectories[1].q);
        let size = |tau: &Signals| tau[2].iter().map(|tau| tau * tau).sum::<f64>().sqrt();
        let ratio = size(&heavy.tau) / size(&recording.trajectories[1].tau);
        assert!((ratio - 2.0).abs() < 1e-9, "the last joint bears its own link only: {ratio}");
        let central = (fast.q[0][101] - fast.q[0][99]) / (fast.time[101] - fast.time[99]);
        assert!((central - fast.qd[0][100]).abs() < 1e-2, "{central} {}", fast.qd[0][100]);
        assert!(replay(&recording, 1, Stretch::Speed, 0.0, &model).is_err());
    }

    #[test]
    fn measured_recordings_are_sorted_by_speed() {
        let mut recording = simulate(&Scenario::embedded(), &Monitor::new()).unwrap();
        recording.seal = None;
        let split = Split::automatic(&recording);
        let bare = fitted(&recording, &split, None);
        let sweep = sweep(&recording, &split, &[("bare".into(), &bare)], Stretch::Speed, &Monitor::new()).unwrap();
        let points = &sweep.curves[0].points;
        assert_eq!((sweep.basis, points.len()), (Basis::Measured, 4));
        assert!(points.windows(2).all(|pair| pair[0].scale < pair[1].scale));
        let nothing = Split { held_out: Vec::new(), ..split };
        let error = super::sweep(&recording, &nothing, &[], Stretch::Speed, &Monitor::new()).unwrap_err();
        assert_eq!(error, ExtrapolationError::NothingHeldOut);
    }
}
