//! Torque and columns of the training stretches, prepared alike, and their normal equations by block and joint.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::least_squares::NormalEquations;
use super::preparation::Preparation;
use super::terms::Setting;
use super::{Model, ModelError, RigidBody, Term};
use crate::effect::Column;
use crate::recording::split::{Segment, Split};
use crate::recording::{PerJoint, Recording, Trajectory};

/// Below this speed \[rad/s or m/s\] the sign of a measured velocity is noise, so samples of that joint do not count.
const STANDSTILL: f64 = 0.01;
/// Blocks for validation and standard errors are by training stretch if there are at least this many, else by time.
const FEWEST_BLOCKS: usize = 10;
/// How many time blocks are cut otherwise, over all stretches.
const TIME_BLOCKS: usize = 16;

/// The data that models are fitted to: filtered, thinned out, cut into blocks.
#[derive(Debug, Clone)]
pub struct Design<'a> {
    /// The recording behind it.
    pub recording: &'a Recording,
    /// What terms need to know of it.
    pub setting: Setting,
    /// Stretches that are kept together in validation.
    pub blocks: Vec<Block>,
    /// Prepared torque, by trajectory; zero where a sample does not count.
    pub torque: Vec<PerJoint>,
    /// Whether a prepared sample counts: `counts[trajectory][joint][sample]`.
    counts: Vec<Vec<Vec<bool>>>,
    preparations: Vec<Preparation>,
}

/// A stretch of one trajectory, in prepared samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// Which trajectory.
    pub trajectory: usize,
    /// Which prepared samples.
    pub samples: Range<usize>,
}

/// One prepared column: `parts[trajectory]` holds the joints where it acts.
#[derive(Debug, Clone)]
pub struct PreparedColumn {
    parts: Vec<Vec<(usize, Vec<f64>)>>,
}

/// Normal equations of a list of columns, by block and joint, so that blocks can be left out and joints weighted.
#[derive(Debug, Clone)]
pub struct Equations {
    /// `[block][joint]`.
    parts: Vec<Vec<NormalEquations>>,
}

impl<'a> Design<'a> {
    /// Prepares the training part of a recording.
    ///
    /// # Errors
    /// [`ModelError`] if no planar rigid body fits the recording or the torque never changes.
    pub fn new(recording: &'a Recording, split: &Split) -> Result<Self, ModelError> {
        let setting = Setting::of(recording)?;
        let preparations: Vec<_> =
            (0..recording.trajectories.len()).map(|index| Preparation::of(recording, index)).collect();
        let mut counts = Vec::new();
        let mut torque = Vec::new();
        for (trajectory, preparation) in recording.trajectories.iter().zip(&preparations) {
            let moves = |qd: &Vec<f64>| preparation.thin_out(qd).iter().map(|qd| qd.abs() >= STANDSTILL).collect();
            let moving: Vec<Vec<bool>> = trajectory.qd.iter().map(moves).collect();
            let mut prepared = preparation.apply_all(&trajectory.tau);
            for (joint, values) in prepared.iter_mut().enumerate() {
                blank(values, &moving[joint]);
            }
            counts.push(moving);
            torque.push(prepared);
        }
        let blocks = cut_into_blocks(&split.train, &preparations);
        let design = Design { recording, setting, blocks, torque, counts, preparations };
        if (0..recording.joint_count()).all(|joint| design.energy(joint) == 0.0) {
            return Err(ModelError::NothingToLearn(
                "the torque is zero, or no joint moves, in all training samples".to_owned(),
            ));
        }
        Ok(design)
    }

    /// Σ τ² of a joint over the training samples that count.
    pub fn energy(&self, joint: usize) -> f64 {
        let block_energy = |block: &Block| {
            self.torque[block.trajectory][joint][block.samples.clone()].iter().map(|tau| tau * tau).sum::<f64>()
        };
        self.blocks.iter().map(block_energy).sum()
    }

    /// How many training samples of a joint count.
    pub fn sample_count(&self, joint: usize) -> usize {
        let counting = |block: &Block| {
            self.counts[block.trajectory][joint][block.samples.clone()].iter().filter(|&&counts| counts).count()
        };
        self.blocks.iter().map(counting).sum()
    }

    /// Prepares columns that are computed for one trajectory at a time.
    ///
    /// # Errors
    /// Those of `columns`.
    pub fn prepare(
        &self,
        columns: impl Fn(&Trajectory) -> Result<Vec<Column>, ModelError>,
    ) -> Result<Vec<PreparedColumn>, ModelError> {
        let mut prepared: Vec<PreparedColumn> = Vec::new();
        for (index, trajectory) in self.recording.trajectories.iter().enumerate() {
            for (number, column) in columns(trajectory)?.iter().enumerate() {
                if prepared.len() <= number {
                    prepared.push(PreparedColumn { parts: vec![Vec::new(); index] });
                }
                let mut column = self.preparations[index].apply_column(column);
                for (joint, values) in &mut column.parts {
                    blank(values, &self.counts[index][*joint]);
                }
                prepared[number].parts.push(column.parts);
            }
        }
        Ok(prepared)
    }

    /// The torque of terms that are known beforehand, prepared like the rest; `None` if there are none.
    pub fn known_torque(&self, model: &Model) -> Option<Vec<PerJoint>> {
        let bodies: Vec<&RigidBody> = model
            .terms
            .iter()
            .filter_map(|term| match term {
                Term::RigidBody(body @ RigidBody::Stated(_)) => Some(body),
                _ => None,
            })
            .collect();
        let body = bodies.first()?;
        let of_trajectory = |(index, trajectory): (usize, &Trajectory)| {
            let torque = body.known_torque(&self.setting, trajectory)?;
            let mut prepared = self.preparations[index].apply_all(&torque);
            for (joint, values) in prepared.iter_mut().enumerate() {
                blank(values, &self.counts[index][joint]);
            }
            Some(prepared)
        };
        self.recording.trajectories.iter().enumerate().map(of_trajectory).collect()
    }

    /// The normal equations of these columns against `torque` (prepared, by trajectory).
    pub fn equations(&self, columns: &[PreparedColumn], torque: &[PerJoint]) -> Equations {
        let joints = self.recording.joint_count();
        let of_block = |block: &Block| {
            (0..joints)
                .map(|joint| {
                    let cut: Vec<_> = columns.iter().map(|column| column.cut(block, joint)).collect();
                    joint_equations(&cut, &torque[block.trajectory][joint][block.samples.clone()])
                })
                .collect()
        };
        Equations { parts: self.blocks.iter().map(of_block).collect() }
    }

    /// Computes anew what changed in `equations` when the columns `changed` were replaced.
    pub fn update_equations(
        &self,
        equations: &mut Equations,
        columns: &[PreparedColumn],
        changed: Range<usize>,
        torque: &[PerJoint],
    ) {
        for (block, parts) in self.blocks.iter().zip(&mut equations.parts) {
            for (joint, part) in parts.iter_mut().enumerate() {
                let cut: Vec<_> = columns.iter().map(|column| column.cut(block, joint)).collect();
                for i in changed.clone() {
                    part.moment[i] = cut[i]
                        .map_or(0.0, |values| dot(values, &torque[block.trajectory][joint][block.samples.clone()]));
                    for j in 0..cut.len() {
                        let product = cut[i].zip(cut[j]).map_or(0.0, |(first, second)| dot(first, second));
                        part.gram[(i, j)] = product;
                        part.gram[(j, i)] = product;
                    }
                }
            }
        }
    }

    /// RMS speed of each block relative to the mean of all, so that slow and fast blocks can be told apart.
    pub fn block_speeds(&self) -> Vec<f64> {
        let joints = self.recording.joint_count();
        let speed = |block: &Block, joint: usize| {
            let preparation = &self.preparations[block.trajectory];
            let qd = &self.recording.trajectories[block.trajectory].qd[joint];
            let range = block.samples.start * preparation.every..(block.samples.end * preparation.every).min(qd.len());
            let cut = &qd[range];
            (cut.iter().map(|qd| qd * qd).sum::<f64>() / cut.len().max(1) as f64).sqrt()
        };
        let mut speeds = vec![0.0; self.blocks.len()];
        for joint in 0..joints {
            let of_joint: Vec<f64> = self.blocks.iter().map(|block| speed(block, joint)).collect();
            let mean = of_joint.iter().sum::<f64>() / of_joint.len() as f64;
            if mean > 0.0 {
                for (sum, value) in speeds.iter_mut().zip(&of_joint) {
                    *sum += value / mean / joints as f64;
                }
            }
        }
        speeds
    }
}

impl Equations {
    /// How many blocks there are.
    pub fn block_count(&self) -> usize {
        self.parts.len()
    }

    /// The weighted sum over all joints and the blocks for which `included` holds.
    pub fn total(&self, weights: &[f64], included: impl Fn(usize) -> bool) -> NormalEquations {
        let factors = self.parts.first().and_then(|joints| joints.first()).map_or(0, |part| part.moment.len());
        let mut sum = NormalEquations::empty(factors);
        for (_, joints) in self.parts.iter().enumerate().filter(|(block, _)| included(*block)) {
            for (part, &weight) in joints.iter().zip(weights) {
                sum.add(part, weight);
            }
        }
        sum
    }

    /// The equations of one block and joint.
    pub fn part(&self, block: usize, joint: usize) -> &NormalEquations {
        &self.parts[block][joint]
    }
}

impl PreparedColumn {
    /// The column on one block and joint; `None` where it is zero by construction.
    fn cut(&self, block: &Block, joint: usize) -> Option<&[f64]> {
        let parts = &self.parts[block.trajectory];
        parts.iter().find(|(on, _)| *on == joint).map(|(_, values)| &values[block.samples.clone()])
    }

    /// Σ factors · (above − below) / step: the derivative of an effect's torque by a shape parameter.
    pub fn slope(below: &[PreparedColumn], above: &[PreparedColumn], factors: &[f64], step: f64) -> PreparedColumn {
        let mut slope = above[0].clone();
        for (trajectory, parts) in slope.parts.iter_mut().enumerate() {
            for (part, (_, values)) in parts.iter_mut().enumerate() {
                for (sample, value) in values.iter_mut().enumerate() {
                    let difference = |(number, factor): (usize, &f64)| {
                        let at = |columns: &[PreparedColumn]| columns[number].parts[trajectory][part].1[sample];
                        factor * (at(above) - at(below)) / step
                    };
                    *value = factors.iter().enumerate().map(difference).sum();
                }
            }
        }
        PreparedColumn { parts: slope.parts }
    }
}

/// Zeros the samples that do not count, on both sides of the equations: there they say nothing.
fn blank(values: &mut [f64], counts: &[bool]) {
    for (value, counts) in values.iter_mut().zip(counts) {
        if !counts {
            *value = 0.0;
        }
    }
}

fn joint_equations(columns: &[Option<&[f64]>], torque: &[f64]) -> NormalEquations {
    let mut gram = DMatrix::zeros(columns.len(), columns.len());
    let mut moment = DVector::zeros(columns.len());
    for (i, first) in columns.iter().enumerate() {
        let Some(first) = first else { continue };
        moment[i] = dot(first, torque);
        for (j, second) in columns.iter().enumerate().take(i + 1) {
            let Some(second) = second else { continue };
            let product = dot(first, second);
            gram[(i, j)] = product;
            gram[(j, i)] = product;
        }
    }
    NormalEquations { gram, moment, energy: dot(torque, torque) }
}

/// Dot product in eight partial sums, which the compiler turns into vector instructions.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (a_chunks, b_chunks) = (a.chunks_exact(8), b.chunks_exact(8));
    let tail: f64 = a_chunks.remainder().iter().zip(b_chunks.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a_chunks.zip(b_chunks) {
        for lane in 0..8 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums.iter().sum::<f64>() + tail
}

fn cut_into_blocks(train: &[Segment], preparations: &[Preparation]) -> Vec<Block> {
    let stretches = train.iter().map(|segment| Block {
        trajectory: segment.trajectory,
        samples: preparations[segment.trajectory].range(&segment.samples),
    });
    if train.len() >= FEWEST_BLOCKS {
        return stretches.collect();
    }
    let total: usize = stretches.clone().map(|stretch| stretch.samples.len()).sum();
    let mut blocks = Vec::new();
    for stretch in stretches {
        let length = stretch.samples.len();
        let pieces = ((TIME_BLOCKS * length) as f64 / total.max(1) as f64).round().max(1.0) as usize;
        for piece in 0..pieces {
            let cut = |part: usize| stretch.samples.start + length * part / pieces;
            blocks.push(Block { trajectory: stretch.trajectory, samples: cut(piece)..cut(piece + 1) });
        }
    }
    blocks
}
