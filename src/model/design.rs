//! Torque and columns of the training stretches, prepared alike, and their normal equations by block and joint.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::least_squares::{NormalEquations, dot};
use super::preparation::Preparation;
use super::terms::{Alteration, Found, Setting};
use super::{Model, ModelError, RigidBody, Term};
use crate::effect::{Column, Load};
use crate::recording::split::{Segment, Split};
use crate::recording::{Recording, Trajectory};
use crate::signals::Signals;

/// Below this speed \[rad/s or m/s\] the sign of a measured velocity is noise, so samples of that joint do not count.
const STANDSTILL: f64 = 0.01;
/// Blocks for validation and standard errors are by training stretch if there are at least this many, else by time.
const FEWEST_BLOCKS: usize = 10;
/// Longest lag of the residual's autocorrelation, in prepared samples.
const MOST_LAG: usize = 100;
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
    pub torque: Vec<Signals>,
    /// Whether a prepared sample counts: `counts[trajectory][joint][sample]`.
    counts: Vec<Vec<Vec<bool>>>,
    preparations: Vec<Preparation>,
    /// The effects that are in the torque, roughly: they pass through those that change what others do.
    pub found: Vec<Found>,
    /// What the rigid body needs, by trajectory.
    loads: Vec<Option<Load>>,
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

/// Normal equations of a list of columns, by block and joint, so that blocks can be left out and joints weighted. Only
/// products within a joint are stored: most columns act on one joint.
#[derive(Debug, Clone)]
pub struct Equations {
    /// How many columns there are.
    count: usize,
    /// The columns that act on each joint, ascending.
    on_joint: Vec<Vec<usize>>,
    /// `[block][joint]`, in the columns that act on the joint.
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
            let moves = |qd: &[f64]| preparation.thin_out(qd).iter().map(|qd| qd.abs() >= STANDSTILL).collect();
            counts.push(trajectory.qd.iter().map(moves).collect::<Vec<Vec<bool>>>());
            torque.push(preparation.apply_all(&trajectory.tau));
        }
        for (trajectory, moving) in counts.iter_mut().enumerate() {
            let stretches = split.train.iter().filter(|segment| segment.trajectory == trajectory);
            let trains: Vec<_> = stretches.map(|segment| preparations[trajectory].range(&segment.samples)).collect();
            for (joint, counts) in moving.iter_mut().enumerate() {
                for (sample, counts) in counts.iter_mut().enumerate() {
                    *counts &= trains.iter().any(|range| range.contains(&sample));
                }
                blank(&mut torque[trajectory][joint], counts);
            }
        }
        let blocks = cut_into_blocks(&joined(split), &preparations);
        let loads = vec![None; recording.trajectories.len()];
        let design = Design { recording, setting, blocks, torque, counts, preparations, found: Vec::new(), loads };
        if (0..recording.joint_count()).all(|joint| design.energy(joint) == 0.0) {
            return Err(ModelError::NothingToLearn(
                "the torque is zero, or no joint moves, in all training samples".to_owned(),
            ));
        }
        let body = design.rough_body()?;
        Ok(design.with_body(Some(body), Vec::new()))
    }

    /// The same data with the load of another rigid body (`None` stands for the stated arm) and with these effects that change
    /// what the others do.
    pub fn with_body(&self, body: Option<Vec<f64>>, alterations: Vec<Alteration>) -> Design<'a> {
        let mut design = self.clone();
        design.setting.body = body;
        design.setting.alterations = alterations;
        design.loads = self.recording.trajectories.iter().map(|trajectory| design.setting.load(trajectory)).collect();
        design
    }

    /// Factors of the rigid body, identified beside the commonest friction and offsets so that these do not bias it much.
    fn rough_body(&self) -> Result<Vec<f64>, ModelError> {
        let joints = self.recording.joint_count();
        let mut columns = self.prepare(|trajectory, _| Ok(RigidBody::Identified.columns(&self.setting, trajectory)))?;
        let count = columns.len();
        columns.extend(self.prepare(|trajectory, _| {
            let common = |joint: usize| {
                let qd = &trajectory.qd[joint];
                let column = |value: fn(f64) -> f64| Column::on_joint(joint, qd.iter().map(move |&qd| value(qd)));
                [column(|_| 1.0), column(|qd| qd), column(f64::signum)]
            };
            Ok((0..joints).flat_map(common).collect())
        })?);
        let equations = self.equations(&columns, &self.torque);
        let inverse = |energy: f64| if energy > 0.0 { 1.0 / energy } else { 0.0 };
        let mut weights: Vec<f64> = (0..joints).map(|joint| inverse(self.energy(joint))).collect();
        let rough = equations.total(&weights, |_| true).solve().factors;
        weights = super::fit::residual_weights(self, &equations, &rough);
        let factors = equations.total(&weights, |_| true).solve().factors;
        Ok(factors.iter().take(count).copied().collect())
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
        columns: impl Fn(&Trajectory, Option<&Load>) -> Result<Vec<Column>, ModelError>,
    ) -> Result<Vec<PreparedColumn>, ModelError> {
        let mut prepared: Vec<PreparedColumn> = Vec::new();
        for (index, trajectory) in self.recording.trajectories.iter().enumerate() {
            for (number, column) in columns(trajectory, self.loads[index].as_ref())?.iter().enumerate() {
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
    pub fn known_torque(&self, model: &Model) -> Option<Vec<Signals>> {
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
    pub fn equations(&self, columns: &[PreparedColumn], torque: &[Signals]) -> Equations {
        let joints = self.recording.joint_count();
        let acting = |joint: usize| (0..columns.len()).filter(|&column| columns[column].acts_on(joint)).collect();
        let on_joint: Vec<Vec<usize>> = (0..joints).map(acting).collect();
        let of_block = |block: &Block| {
            let of_joint = |(joint, acting): (usize, &Vec<usize>)| {
                let cut: Vec<&[f64]> = acting.iter().map(|&column| columns[column].cut(block, joint)).collect();
                joint_equations(&cut, &torque[block.trajectory][joint][block.samples.clone()])
            };
            on_joint.iter().enumerate().map(of_joint).collect()
        };
        let parts = self.blocks.par_iter().map(of_block).collect();
        Equations { count: columns.len(), on_joint, parts }
    }

    /// Computes anew what changed in `equations` when the columns `changed` (ascending) were replaced by others on the same
    /// joints.
    pub fn update_equations(
        &self,
        equations: &mut Equations,
        columns: &[PreparedColumn],
        changed: &[usize],
        torque: &[Signals],
    ) {
        let on_joint = &equations.on_joint;
        let update = |(block, parts): (&Block, &mut Vec<NormalEquations>)| {
            for (joint, (part, acting)) in parts.iter_mut().zip(on_joint).enumerate() {
                let is_changed = |&place: &usize| changed.binary_search(&acting[place]).is_ok();
                let places: Vec<usize> = (0..acting.len()).filter(is_changed).collect();
                if places.is_empty() {
                    continue;
                }
                let torque = &torque[block.trajectory][joint][block.samples.clone()];
                let cut = |&column: &usize| columns[column].cut(block, joint);
                let all = side_by_side(acting.iter().map(cut), torque.len());
                let new = side_by_side(places.iter().map(|&place| cut(&acting[place])), torque.len()).transpose();
                let (products, moments) = (&new * &all, new * DVector::from_column_slice(torque));
                for (row, &place) in places.iter().enumerate() {
                    part.moment[place] = moments[row];
                    part.gram.set_row(place, &products.row(row));
                    part.gram.set_column(place, &products.row(row).transpose());
                }
            }
        };
        self.blocks.par_iter().zip(&mut equations.parts).for_each(update);
    }

    /// Takes another torque into the equations of these columns.
    pub fn replace_torque(&self, equations: &mut Equations, columns: &[PreparedColumn], torque: &[Signals]) {
        let on_joint = &equations.on_joint;
        let replace = |(block, parts): (&Block, &mut Vec<NormalEquations>)| {
            for (joint, (part, acting)) in parts.iter_mut().zip(on_joint).enumerate() {
                let torque = &torque[block.trajectory][joint][block.samples.clone()];
                part.energy = dot(torque, torque);
                for (moment, &column) in part.moment.iter_mut().zip(acting) {
                    *moment = dot(columns[column].cut(block, joint), torque);
                }
            }
        };
        self.blocks.par_iter().zip(&mut equations.parts).for_each(replace);
    }

    /// Computes anew the last rows and columns of the weighted `sum` over all blocks, those of the columns `new`, which
    /// come after the columns `kept`.
    pub fn complete(
        &self,
        sum: &mut NormalEquations,
        kept: &[&PreparedColumn],
        new: &[PreparedColumn],
        torque: &[Signals],
        weights: &[f64],
    ) {
        let first = kept.len();
        let all: Vec<&PreparedColumn> = kept.iter().copied().chain(new).collect();
        for i in first..all.len() {
            sum.moment[i] = 0.0;
            sum.gram.row_mut(i).fill(0.0);
            sum.gram.column_mut(i).fill(0.0);
        }
        for block in &self.blocks {
            for (joint, &weight) in weights.iter().enumerate() {
                for i in (first..all.len()).filter(|&i| all[i].acts_on(joint)) {
                    let values = all[i].cut(block, joint);
                    sum.moment[i] += weight * dot(values, &torque[block.trajectory][joint][block.samples.clone()]);
                    for j in (0..=i).filter(|&j| all[j].acts_on(joint)) {
                        sum.gram[(i, j)] += weight * dot(values, all[j].cut(block, joint));
                    }
                }
            }
        }
        for i in first..all.len() {
            for j in 0..i {
                sum.gram[(j, i)] = sum.gram[(i, j)];
            }
        }
    }

    /// How many samples of a joint's residual count as one, because neighbours resemble each other: the integrated
    /// autocorrelation 1 + 2 Σ ρₖ up to the first ρₖ that is not positive. 1 for white noise.
    pub fn correlation(
        &self,
        columns: &[PreparedColumn],
        factors: &DVector<f64>,
        torque: &[Signals],
        joint: usize,
    ) -> f64 {
        let mut products = vec![0.0; MOST_LAG + 1];
        for block in &self.blocks {
            let mut residual = torque[block.trajectory][joint][block.samples.clone()].to_vec();
            for (column, factor) in columns.iter().zip(factors).filter(|(_, factor)| **factor != 0.0) {
                for (left, value) in residual.iter_mut().zip(column.cut(block, joint)) {
                    *left -= factor * value;
                }
            }
            for (lag, product) in products.iter_mut().enumerate().take(residual.len()) {
                *product += dot(&residual[lag..], &residual[..residual.len() - lag]);
            }
        }
        if products[0] <= 0.0 {
            return 1.0;
        }
        let positive = products[1..].iter().map(|product| product / products[0]).take_while(|&rho| rho > 0.0);
        1.0 + 2.0 * positive.sum::<f64>()
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
        let mut sum = NormalEquations::empty(self.count);
        for block in (0..self.parts.len()).filter(|&block| included(block)) {
            for (joint, &weight) in weights.iter().enumerate() {
                self.add_part(block, joint, weight, &mut sum);
            }
        }
        sum
    }

    /// Adds `weight` times the equations of one block and joint to `sum`, which is in all columns.
    pub fn add_part(&self, block: usize, joint: usize, weight: f64, sum: &mut NormalEquations) {
        let (part, acting) = (&self.parts[block][joint], &self.on_joint[joint]);
        for (j, &to) in acting.iter().enumerate() {
            for (i, &from) in acting.iter().enumerate() {
                sum.gram[(from, to)] += weight * part.gram[(i, j)];
            }
            sum.moment[to] += weight * part.moment[j];
        }
        sum.energy += weight * part.energy;
    }

    /// The equations of one joint on all blocks, and the columns that act there, in which they are written.
    pub fn of_joint(&self, joint: usize) -> (&[usize], NormalEquations) {
        let acting = &self.on_joint[joint];
        let mut sum = NormalEquations::empty(acting.len());
        self.parts.iter().for_each(|joints| sum.add(&joints[joint], 1.0));
        (acting, sum)
    }

    /// The equations of one block and joint in a selection of columns.
    pub fn select(&self, block: usize, joint: usize, columns: &[usize]) -> NormalEquations {
        let (part, acting) = (&self.parts[block][joint], &self.on_joint[joint]);
        let places: Vec<Option<usize>> = columns.iter().map(|column| acting.binary_search(column).ok()).collect();
        NormalEquations {
            gram: DMatrix::from_fn(columns.len(), columns.len(), |i, j| {
                places[i].zip(places[j]).map_or(0.0, |(i, j)| part.gram[(i, j)])
            }),
            moment: DVector::from_fn(columns.len(), |i, _| places[i].map_or(0.0, |i| part.moment[i])),
            energy: part.energy,
        }
    }

    /// Weighted products of one column with `others` on one block, and its moment.
    pub fn column(&self, block: usize, number: usize, others: &[usize], weights: &[f64]) -> (DVector<f64>, f64) {
        let (mut products, mut sum) = (DVector::zeros(others.len()), 0.0);
        for (joint, &weight) in weights.iter().enumerate() {
            let (part, acting) = (&self.parts[block][joint], &self.on_joint[joint]);
            let Ok(here) = acting.binary_search(&number) else { continue };
            sum += weight * part.moment[here];
            for (product, other) in products.iter_mut().zip(others) {
                *product += acting.binary_search(other).map_or(0.0, |other| weight * part.gram[(here, other)]);
            }
        }
        (products, sum)
    }

    /// What these factors (of all columns) leave of one block and joint.
    pub fn residual_energy(&self, block: usize, joint: usize, factors: &DVector<f64>) -> f64 {
        let acting = &self.on_joint[joint];
        let here = DVector::from_fn(acting.len(), |i, _| factors[acting[i]]);
        self.parts[block][joint].residual_energy(&here)
    }
}

impl PreparedColumn {
    /// Whether the column is anything but zero by construction on this joint.
    fn acts_on(&self, joint: usize) -> bool {
        self.parts.iter().any(|parts| parts.iter().any(|(on, _)| *on == joint))
    }

    /// The column on one block and joint; empty where it is zero by construction.
    fn cut(&self, block: &Block, joint: usize) -> &[f64] {
        let parts = &self.parts[block.trajectory];
        parts.iter().find(|(on, _)| *on == joint).map_or(&[], |(_, values)| &values[block.samples.clone()])
    }

    /// Adds `factor` times the column to a prepared torque, by trajectory.
    pub fn add_to(&self, torque: &mut [Signals], factor: f64) {
        for (torque, parts) in torque.iter_mut().zip(&self.parts) {
            for (joint, values) in parts {
                for (sum, value) in torque[*joint].iter_mut().zip(values) {
                    *sum += factor * value;
                }
            }
        }
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

fn joint_equations(columns: &[&[f64]], torque: &[f64]) -> NormalEquations {
    let columns = side_by_side(columns.iter().copied(), torque.len());
    let rows = columns.transpose();
    let torque = DVector::from_column_slice(torque);
    NormalEquations { gram: &rows * &columns, moment: rows * &torque, energy: torque.norm_squared() }
}

/// Columns of so many samples as a matrix; those that are zero by construction come empty.
fn side_by_side<'a>(columns: impl Iterator<Item = &'a [f64]>, samples: usize) -> DMatrix<f64> {
    let (mut values, mut count) = (Vec::new(), 0);
    for column in columns {
        values.extend_from_slice(column);
        count += 1;
        values.resize(count * samples, 0.0);
    }
    DMatrix::from_vec(samples, count, values)
}

/// The training stretches; those of one trajectory that only faulty readings part are one. What lies between does not count.
fn joined(split: &Split) -> Vec<Segment> {
    let mut stretches: Vec<Segment> = Vec::new();
    for segment in &split.train {
        let is_held_out = |between: Range<usize>| {
            let meets = |held: &Segment| held.samples.start < between.end && between.start < held.samples.end;
            split.held_out.iter().any(|held| held.trajectory == segment.trajectory && meets(held))
        };
        match stretches.last_mut() {
            Some(last)
                if last.trajectory == segment.trajectory
                    && last.samples.end <= segment.samples.start
                    && !is_held_out(last.samples.end..segment.samples.start) =>
            {
                last.samples.end = segment.samples.end;
            }
            _ => stretches.push(segment.clone()),
        }
    }
    stretches
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
