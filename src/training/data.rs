//! The samples that a network learns from: checked, in one piece of memory, ready to be dealt into tiles.

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::TrainError;
use crate::model::learned::Architecture;
use crate::network::kernel::PAD;
use crate::network::{Buffer, Element, Kernels, TILE};
use crate::recording::Trajectory;
use crate::signals::Signals;

/// Samples of motion and torque, one after the other.
#[derive(Debug, Clone)]
pub struct Samples<E: Element> {
    /// q, q̇, q̈, τ, effect columns of each sample, padded to whole vectors: one row, so that a sample is mostly one cache line.
    values: Buffer<E>,
    joints: usize,
    columns: usize,
    count: usize,
}

/// What tells the samples of one run from those of another.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mark {
    joints: usize,
    train: usize,
    #[serde(default)]
    validation: usize,
    held_out: usize,
    /// Of all values: FNV-1a by words, turned so that all digits take part.
    hash: u64,
}

impl Mark {
    /// The mark of the samples of a run.
    pub(super) fn of<E: Element>(train: &Samples<E>, watched: [Option<&Samples<E>>; 2]) -> Self {
        let values = train.values.iter().chain(watched.into_iter().flatten().flat_map(|samples| samples.values.iter()));
        let [validation, held_out] = watched.map(|samples| samples.map_or(0, Samples::len));
        let mix =
            |hash: u64, value: &E| (hash ^ value.to_f64().to_bits()).wrapping_mul(0x0100_0000_01b3).rotate_left(29);
        Mark {
            joints: train.joints,
            train: train.len(),
            validation,
            held_out,
            hash: values.fold(0xcbf2_9ce4_8422_2325, mix),
        }
    }

    /// In a few words, for messages.
    pub(super) fn describe(&self) -> String {
        let Mark { joints, train, validation, held_out, hash } = self;
        format!(
            "{train} training, {validation} validation and {held_out} held-out samples of {joints} joints, check sum {hash:016x}"
        )
    }
}

/// Effect columns of one trajectory: `columns[column][joint][sample]`, see [`crate::effect`].
pub type Columns = Vec<Signals>;

impl<E: Element> Samples<E> {
    /// Puts trajectories together. `columns` has one entry for each trajectory, or none at all.
    ///
    /// # Errors
    /// [`TrainError`] if a trajectory has another number of joints, or a value is not a number.
    pub fn new(joints: usize, trajectories: &[Trajectory], columns: &[Columns]) -> Result<Self, TrainError> {
        let column_count = columns.first().map_or(0, Vec::len);
        let count: usize = trajectories.iter().map(Trajectory::len).sum();
        let width = (4 + column_count) * joints;
        let row = width.next_multiple_of(PAD);
        let mut values = Buffer::zeros(count * row);
        let mut at = 0;
        for (index, trajectory) in trajectories.iter().enumerate() {
            if trajectory.joint_count() != joints {
                let (model, data, name) = (joints, trajectory.joint_count(), trajectory.name.clone());
                return Err(TrainError::JointCount { model, data, name });
            }
            let own = [&trajectory.q, &trajectory.qd, &trajectory.qdd, &trajectory.tau];
            let added = columns.get(index).into_iter().flatten();
            let signals: Vec<&[f64]> = own.into_iter().chain(added).flatten().collect();
            if signals.len() != width || signals.iter().any(|signal| signal.len() != trajectory.len()) {
                return Err(TrainError::Incomplete { name: trajectory.name.clone() });
            }
            for sample in 0..trajectory.len() {
                for (channel, signal) in signals.iter().enumerate() {
                    if !signal[sample].is_finite() {
                        let channel =
                            ["position", "velocity", "acceleration", "torque", "effect"][(channel / joints).min(4)];
                        let (name, time) = (trajectory.name.clone(), trajectory.time[sample]);
                        return Err(TrainError::NotANumber { channel, name, time });
                    }
                    values[at + channel] = E::from_f64(signal[sample]);
                }
                at += row;
            }
        }
        Ok(Samples { values, joints, columns: column_count, count })
    }

    /// How many samples there are.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Elements of a sample, padding included.
    fn row(&self) -> usize {
        ((4 + self.columns) * self.joints).next_multiple_of(PAD)
    }

    /// Mean and variance of one channel (0 position, 1 velocity, 2 acceleration, 3 torque) of one joint.
    pub fn mean_and_variance(&self, channel: usize, joint: usize) -> (f64, f64) {
        let at = channel * self.joints + joint;
        let values = || (0..self.count).map(|sample| self.values[sample * self.row() + at].to_f64());
        let mean = values().sum::<f64>() / self.count.max(1) as f64;
        let variance = values().map(|value| (value - mean).powi(2)).sum::<f64>() / self.count.max(1) as f64;
        (mean, variance)
    }

    /// Whether a model can learn from these samples.
    ///
    /// # Errors
    /// [`TrainError`] if it has other joints or effect columns.
    pub fn check(&self, architecture: &Architecture) -> Result<(), TrainError> {
        if self.joints != architecture.joints {
            let (model, data) = (architecture.joints, self.joints);
            return Err(TrainError::JointCount { model, data, name: "all".into() });
        }
        if self.columns != architecture.column_count() {
            return Err(TrainError::ColumnCount { model: architecture.column_count(), data: self.columns });
        }
        Ok(())
    }

    /// One channel block (q, q̇, q̈, τ, columns) of all samples, sample after sample.
    pub fn channel(&self, block: usize) -> Vec<E> {
        let first = block * self.joints;
        let last = if block < 4 { first + self.joints } else { first + self.columns * self.joints };
        self.values.chunks_exact(self.row().max(1)).flat_map(|sample| sample[first..last].iter().copied()).collect()
    }

    /// Deals the samples `picks` into a tile of states. What they do not fill repeats the last one.
    pub(super) fn deal(&self, kernels: &Kernels<E>, picks: &[u32], tile: &mut [E]) {
        let last = picks.last().copied().unwrap_or(0);
        let mut all = [last; TILE];
        all[..picks.len()].copy_from_slice(picks);
        (kernels.gather)(&self.values, self.row(), &all, tile);
    }
}

/// The order in which an epoch takes its samples: the same for the same seed, whatever came before.
pub(super) fn order(samples: usize, seed: u64, epoch: u64) -> Vec<u32> {
    let mut order: Vec<u32> = (0..samples as u32).collect();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(epoch + 1);
    order.shuffle(&mut random);
    order
}
