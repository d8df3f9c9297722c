//! Normal equations of prepared columns, by block and joint, so that blocks can be left out and joints weighted.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::least_squares::{NormalEquations, dot};
use crate::signals::Signals;

/// Longest lag of the residual's autocorrelation, in prepared samples.
const MOST_LAG: usize = 100;

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
    pub(super) parts: Vec<Vec<(usize, Vec<f64>)>>,
}

/// Normal equations of a list of columns, by block and joint, so that blocks can be left out and joints weighted. Only
/// products within a joint are stored: most columns act on one joint.
#[derive(Debug, Clone)]
pub struct Equations {
    /// How many columns there are.
    count: usize,
    blocks: Vec<Block>,
    /// The columns that act on each joint, ascending.
    on_joint: Vec<Vec<usize>>,
    /// `[block][joint]`, in the columns that act on the joint.
    parts: Vec<Vec<NormalEquations>>,
}

impl Equations {
    /// The normal equations of these columns against `torque` (prepared, by trajectory), on these blocks.
    pub fn new(blocks: &[Block], joints: usize, columns: &[PreparedColumn], torque: &[Signals]) -> Self {
        let acting = |joint: usize| (0..columns.len()).filter(|&column| columns[column].acts_on(joint)).collect();
        let on_joint: Vec<Vec<usize>> = (0..joints).map(acting).collect();
        let of_block = |block: &Block| {
            let of_joint = |(joint, acting): (usize, &Vec<usize>)| {
                let cut: Vec<&[f64]> = acting.iter().map(|&column| columns[column].cut(block, joint)).collect();
                joint_equations(&cut, &torque[block.trajectory][joint][block.samples.clone()])
            };
            on_joint.iter().enumerate().map(of_joint).collect()
        };
        let parts = blocks.par_iter().map(of_block).collect();
        Equations { count: columns.len(), blocks: blocks.to_vec(), on_joint, parts }
    }

    /// Computes anew what changes when the columns `changed` (ascending) were replaced by others on the same joints.
    pub fn update(&mut self, columns: &[PreparedColumn], changed: &[usize], torque: &[Signals]) {
        let on_joint = &self.on_joint;
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
        self.blocks.par_iter().zip(&mut self.parts).for_each(update);
    }

    /// Takes another torque into the equations of these columns.
    pub fn replace_torque(&mut self, columns: &[PreparedColumn], torque: &[Signals]) {
        let on_joint = &self.on_joint;
        let replace = |(block, parts): (&Block, &mut Vec<NormalEquations>)| {
            for (joint, (part, acting)) in parts.iter_mut().zip(on_joint).enumerate() {
                let torque = &torque[block.trajectory][joint][block.samples.clone()];
                part.energy = dot(torque, torque);
                for (moment, &column) in part.moment.iter_mut().zip(acting) {
                    *moment = dot(columns[column].cut(block, joint), torque);
                }
            }
        };
        self.blocks.par_iter().zip(&mut self.parts).for_each(replace);
    }

    /// Computes anew the last rows and columns of the weighted `sum` over all blocks, those of the columns `new`, which
    /// come after the columns `kept`.
    pub(super) fn complete(
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
        let correlations = self.correlations(columns, factors, torque, joint, MOST_LAG);
        1.0 + 2.0 * correlations.into_iter().take_while(|&rho| rho > 0.0).sum::<f64>()
    }

    /// The autocorrelations ρ₁, ρ₂ … of what these factors of all columns leave of a joint's torque; none if nothing is left.
    pub fn correlations(
        &self,
        columns: &[PreparedColumn],
        factors: &DVector<f64>,
        torque: &[Signals],
        joint: usize,
        lags: usize,
    ) -> Vec<f64> {
        let mut products = vec![0.0; lags + 1];
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
            return Vec::new();
        }
        products[1..].iter().map(|product| product / products[0]).collect()
    }

    /// How many blocks there are.
    pub fn block_count(&self) -> usize {
        self.parts.len()
    }

    /// The weighted sum over all joints and the blocks for which `included` holds.
    pub fn total(&self, weights: &[f64], included: impl Fn(usize) -> bool) -> NormalEquations {
        let mut sum = NormalEquations::empty(self.count);
        for block in (0..self.parts.len()).filter(|&block| included(block)) {
            self.add_block(block, weights, &mut sum);
        }
        sum
    }

    /// The weighted sum over all joints of each block, in the place of those of other weights or columns.
    pub fn by_block(&self, weights: &[f64], mut blocks: Vec<NormalEquations>) -> Vec<NormalEquations> {
        // Memory that is there is quicker than memory that is asked for anew.
        blocks.resize_with(self.parts.len(), || NormalEquations::empty(self.count));
        blocks.par_iter_mut().enumerate().for_each(|(block, sum)| {
            sum.clear(self.count);
            self.add_block(block, weights, sum);
        });
        blocks
    }

    fn add_block(&self, block: usize, weights: &[f64], sum: &mut NormalEquations) {
        for (joint, &weight) in weights.iter().enumerate() {
            self.add_part(block, joint, weight, sum);
        }
    }

    /// Adds `weight` times the equations of one block and joint to `sum`, which is in all columns.
    pub fn add_part(&self, block: usize, joint: usize, weight: f64, sum: &mut NormalEquations) {
        let (part, acting) = (&self.parts[block][joint], &self.on_joint[joint]);
        let columns = part.gram.as_slice().chunks_exact(acting.len().max(1));
        for (&to, (own, moment)) in acting.iter().zip(columns.zip(&part.moment)) {
            let mut column = sum.gram.column_mut(to);
            let column = column.as_mut_slice();
            acting.iter().zip(own).for_each(|(&from, value)| column[from] += weight * value);
            sum.moment[to] += weight * moment;
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
    pub fn cut(&self, block: &Block, joint: usize) -> &[f64] {
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

/// The normal equations of one joint: of columns, those that are zero by construction empty, against its torque.
pub fn joint_equations(columns: &[&[f64]], torque: &[f64]) -> NormalEquations {
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
