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
    /// `[joint][column]`: where the column stands among those that act on the joint.
    places: Vec<Vec<Option<usize>>>,
    /// `[block][joint]`, in the columns that act on the joint.
    parts: Vec<Vec<NormalEquations>>,
}

impl Equations {
    /// The normal equations of these columns against `torque` (prepared, by trajectory), on these blocks.
    pub fn new(blocks: &[Block], joints: usize, columns: &[PreparedColumn], torque: &[Signals]) -> Self {
        let acting = |joint: usize| (0..columns.len()).filter(|&column| columns[column].acts_on(joint)).collect();
        let on_joint: Vec<Vec<usize>> = (0..joints).map(acting).collect();
        let placed = |acting: &Vec<usize>| {
            let mut places = vec![None; columns.len()];
            acting.iter().enumerate().for_each(|(place, &column)| places[column] = Some(place));
            places
        };
        let places = on_joint.iter().map(placed).collect();
        let of_block = |block: &Block| {
            let of_joint = |(joint, acting): (usize, &Vec<usize>)| {
                let cut: Vec<&[f64]> = acting.iter().map(|&column| columns[column].cut(block, joint)).collect();
                joint_equations(&cut, &torque[block.trajectory][joint][block.samples.clone()])
            };
            on_joint.iter().enumerate().map(of_joint).collect()
        };
        let parts = blocks.par_iter().map(of_block).collect();
        Equations { count: columns.len(), blocks: blocks.to_vec(), on_joint, places, parts }
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
        let parts: Vec<_> = (0..self.parts.len()).filter(|&block| included(block)).map(|it| &self.parts[it]).collect();
        let mut sum = NormalEquations::empty(self.count);
        let (gram, moment) = (sum.gram.as_mut_slice(), sum.moment.as_mut_slice());
        gram.par_chunks_exact_mut(self.count.max(1)).zip(moment).enumerate().for_each(|(number, (column, moment))| {
            for of_joints in &parts {
                for (joint, (part, weight)) in of_joints.iter().zip(weights).enumerate() {
                    let Some(here) = self.places[joint][number] else { continue };
                    let products = part.gram.column(here);
                    let acting = self.on_joint[joint].iter();
                    acting.zip(&products).for_each(|(&other, product)| column[other] += weight * product);
                    *moment += weight * part.moment[here];
                }
            }
        });
        let energies = parts.iter().flat_map(|of_joints| of_joints.iter().zip(weights));
        sum.energy = energies.map(|(part, weight)| weight * part.energy).sum();
        sum
    }

    /// The weighted sum over all joints of one block, in a selection of columns.
    pub fn of_block(&self, block: usize, columns: &[usize], weights: &[f64]) -> NormalEquations {
        let mut sum = NormalEquations::empty(columns.len());
        for (joint, (part, &weight)) in self.parts[block].iter().zip(weights).enumerate() {
            let place = |(to, &column): (usize, &usize)| Some((to, self.places[joint][column]?));
            let placed: Vec<(usize, usize)> = columns.iter().enumerate().filter_map(place).collect();
            for &(to, here) in &placed {
                let (mut column, products) = (sum.gram.column_mut(to), part.gram.column(here));
                placed.iter().for_each(|&(from, there)| column[from] += weight * products[there]);
                sum.moment[to] += weight * part.moment[here];
            }
            sum.energy += weight * part.energy;
        }
        sum
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
        let part = &self.parts[block][joint];
        let places: Vec<Option<usize>> = columns.iter().map(|&column| self.places[joint][column]).collect();
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
            let (part, places) = (&self.parts[block][joint], &self.places[joint]);
            let Some(here) = places[number] else { continue };
            let own = part.gram.column(here);
            sum += weight * part.moment[here];
            for (product, &other) in products.iter_mut().zip(others) {
                *product += places[other].map_or(0.0, |there| weight * own[there]);
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

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLES: usize = 40;
    const WEIGHTS: [f64; 2] = [0.5, 3.0];

    /// The value of a column on a joint; 0 where it does not act: the first acts on both, the second on joint 1, the third on joint 2.
    fn value(column: usize, joint: usize, sample: usize) -> f64 {
        let acts = column == 0 || column == joint + 1;
        if acts { ((sample * (column + 2) + 5 * joint) as f64 * 0.37).sin() } else { 0.0 }
    }

    fn torque(joint: usize, sample: usize) -> f64 {
        ((sample + 3 * joint) as f64 * 0.21).cos()
    }

    fn equations() -> Equations {
        let part = |column: usize, joint: usize| {
            (joint, (0..SAMPLES).map(|sample| value(column, joint, sample)).collect::<Vec<f64>>())
        };
        let column = |(number, joints): (usize, &[usize])| PreparedColumn {
            parts: vec![joints.iter().map(|&joint| part(number, joint)).collect()],
        };
        let columns: Vec<PreparedColumn> =
            [[0, 1].as_slice(), &[0], &[1]].into_iter().enumerate().map(column).collect();
        let blocks = [0..15, 15..SAMPLES].map(|samples| Block { trajectory: 0, samples });
        Equations::new(&blocks, 2, &columns, &[Signals::from_fn(2, SAMPLES, torque)])
    }

    /// The same from all rows at once.
    fn expected(samples: Range<usize>, columns: &[usize]) -> NormalEquations {
        let rows: Vec<(usize, usize)> = samples.flat_map(|sample| [(0, sample), (1, sample)]).collect();
        let scale = |row: usize| WEIGHTS[rows[row].0].sqrt();
        let x = DMatrix::from_fn(rows.len(), columns.len(), |row, column| {
            scale(row) * value(columns[column], rows[row].0, rows[row].1)
        });
        let y = DVector::from_fn(rows.len(), |row, _| scale(row) * torque(rows[row].0, rows[row].1));
        NormalEquations { gram: x.transpose() * &x, moment: x.transpose() * &y, energy: y.norm_squared() }
    }

    fn assert_alike(one: &NormalEquations, other: &NormalEquations) {
        assert!((&one.gram - &other.gram).amax() < 1e-12, "{} {}", one.gram, other.gram);
        assert!((&one.moment - &other.moment).amax() < 1e-12 && (one.energy - other.energy).abs() < 1e-12);
    }

    #[test]
    fn sums_of_joints_and_blocks_are_those_of_all_rows() {
        let (equations, all) = (equations(), [0, 1, 2]);
        assert_alike(&equations.total(&WEIGHTS, |_| true), &expected(0..SAMPLES, &all));
        assert_alike(&equations.total(&WEIGHTS, |block| block == 1), &expected(15..SAMPLES, &all));
    }

    #[test]
    fn of_a_block_in_any_order_of_columns() {
        let (equations, columns) = (equations(), [2, 0]);
        let expected = expected(0..15, &columns);
        assert_alike(&equations.of_block(0, &columns, &WEIGHTS), &expected);
        let (products, moment) = equations.column(0, 0, &columns, &WEIGHTS);
        assert!((products - expected.gram.column(1)).amax() < 1e-12 && (moment - expected.moment[1]).abs() < 1e-12);
    }
}
