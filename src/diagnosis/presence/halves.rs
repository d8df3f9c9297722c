//! How steady the answer is: in how many halves of the data a family is found again.
//!
//! Blocks of data are dealt into two halves, again and again, and in each half the families are searched for anew, all in
//! the forms that the whole data gave them. What is found because a few blocks happened to favour it, or because of what was found
//! before it, is found in few halves.
//!
//! Source: Shah and Samworth, Variable selection with error control: another look at stability selection, J. R. Stat. Soc. B 75
//! (2013) 55; the sweep operator: Goodnight, Am. Stat. 33 (1979) 149.

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::diagnosis::search::{MARGIN, Search, gates};
use crate::model::least_squares::NormalEquations;

/// How many times the blocks are dealt.
const DEALS: usize = 12;
/// Least share of a column's squared length that must be left beside the others.
const INDEPENDENT: f64 = 1e-8;

/// The share of halves in which each of these families, given by its groups, is found.
pub fn steadiness(search: &Search, families: &[Vec<usize>]) -> Vec<f64> {
    let mut columns: Vec<usize> = search.columns(&[]);
    let own = columns.len();
    let contender = |groups: &Vec<usize>| {
        let first = columns.len();
        columns.extend(groups.iter().flat_map(|&group| search.library.groups[group].columns.clone()));
        let price: f64 = groups.iter().map(|&group| search.price_of(group)).sum();
        Contender { groups: groups.clone(), columns: (first..columns.len()).collect(), price: 0.5 * MARGIN * price }
    };
    let contenders: Vec<Contender> = families.iter().map(contender).collect();
    let blocks: Vec<NormalEquations> = (0..search.library.equations.block_count())
        .into_par_iter()
        .map(|block| search.block_equations(block, &columns))
        .collect();
    let found: Vec<Vec<bool>> = halves(blocks.len())
        .into_par_iter()
        .map(|half| {
            let mut equations = NormalEquations::empty(columns.len());
            half.iter().for_each(|&block| equations.add(&blocks[block], 1.0));
            found_in(search, Swept::new(&equations, own), &contenders)
        })
        .collect();
    let share = |family: usize| {
        let times = found.iter().filter(|found| found[family]).count();
        times as f64 / found.len().max(1) as f64
    };
    (0..families.len()).map(share).collect()
}

/// A family that is searched for.
struct Contender {
    groups: Vec<usize>,
    /// Its columns in the equations of a half.
    columns: Vec<usize>,
    /// What it must gain.
    price: f64,
}

/// Blocks in halves, each with its counterpart; the same ones every time.
fn halves(blocks: usize) -> Vec<Vec<usize>> {
    let mut chance = ChaCha8Rng::seed_from_u64(blocks as u64);
    let mut all: Vec<usize> = (0..blocks).collect();
    let mut deal = || {
        all.shuffle(&mut chance);
        let (one, other) = all.split_at(blocks / 2);
        [one.to_vec(), other.to_vec()]
    };
    (0..DEALS).flat_map(|_| deal()).collect()
}

/// Which families a half shows: the one that gains most joins, until none is worth its price; then those leave that no longer are.
fn found_in(search: &Search, mut swept: Swept, contenders: &[Contender]) -> Vec<bool> {
    let mut is_in = vec![false; contenders.len()];
    let is_physical = |contender: &Contender, factors: &[f64]| {
        let mut rest = factors;
        contender.groups.iter().all(|&group| {
            let group = &search.library.groups[group];
            let (own, others) = rest.split_at(group.columns.len());
            rest = others;
            gates::are_physical(group.effect, own)
        })
    };
    loop {
        let score = |(number, contender): (usize, &Contender)| {
            let (gain, factors) = swept.gain(&contender.columns)?;
            let surplus = gain - contender.price;
            (surplus > 0.0 && is_physical(contender, &factors)).then_some((number, surplus))
        };
        let open = contenders.iter().enumerate().filter(|(number, _)| !is_in[*number]);
        let Some((best, _)) = open.filter_map(score).max_by(|a, b| a.1.total_cmp(&b.1)) else { break };
        contenders[best].columns.iter().for_each(|&column| swept.sweep(column));
        is_in[best] = true;
    }
    loop {
        let margin = |(number, contender): (usize, &Contender)| {
            (number, swept.loss(&contender.columns).unwrap_or(0.0) - contender.price)
        };
        let there = contenders.iter().enumerate().filter(|(number, _)| is_in[*number]);
        match there.map(margin).min_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((weakest, margin)) if margin < 0.0 => {
                contenders[weakest].columns.iter().for_each(|&column| swept.sweep(column));
                is_in[weakest] = false;
            }
            _ => return is_in,
        }
    }
}

/// Equations of which some columns are swept: these are fitted, and of all others what they share with them is taken out.
struct Swept {
    /// Of columns of length 1. Among swept ones −(XᵀX)⁻¹, among others what is left of XᵀX.
    matrix: DMatrix<f64>,
    /// Factors of swept columns; of others their product with what is left of y.
    moment: DVector<f64>,
    scale: Vec<f64>,
    is_in: Vec<bool>,
}

impl Swept {
    /// Sweeps the first `own` columns, but those that can't be told from the ones before them.
    fn new(equations: &NormalEquations, own: usize) -> Self {
        let count = equations.moment.len();
        let scale: Vec<f64> = (0..count)
            .map(|i| equations.gram[(i, i)].max(0.0).sqrt().recip())
            .map(|s| if s.is_finite() { s } else { 0.0 })
            .collect();
        let matrix = DMatrix::from_fn(count, count, |i, j| equations.gram[(i, j)] * scale[i] * scale[j]);
        let moment = DVector::from_fn(count, |i, _| equations.moment[i] * scale[i]);
        let mut swept = Swept { matrix, moment, scale, is_in: vec![false; count] };
        for column in 0..own {
            if swept.matrix[(column, column)] > INDEPENDENT {
                swept.sweep(column);
            }
        }
        swept
    }

    /// Takes a column in, or out if it is in.
    fn sweep(&mut self, column: usize) {
        let pivot = self.matrix[(column, column)];
        let sign = if self.is_in[column] { -1.0 } else { 1.0 };
        let products = self.matrix.column(column).clone_owned();
        let moment = self.moment[column];
        for j in 0..products.len() {
            let factor = products[j] / pivot;
            if j != column && factor != 0.0 {
                self.matrix.column_mut(j).axpy(-factor, &products, 1.0);
                self.moment[j] -= factor * moment;
            }
        }
        for j in 0..products.len() {
            let value = if j == column { -1.0 / pivot } else { sign * products[j] / pivot };
            self.matrix[(column, j)] = value;
            self.matrix[(j, column)] = value;
        }
        self.moment[column] = sign * moment / pivot;
        self.is_in[column] = !self.is_in[column];
    }

    /// What columns that are not in would gain, and their factors; `None` if the data don't show them.
    fn gain(&self, columns: &[usize]) -> Option<(f64, Vec<f64>)> {
        let left = columns.iter().map(|&column| self.matrix[(column, column)]);
        if left.fold(f64::INFINITY, f64::min) <= INDEPENDENT {
            return None;
        }
        let gram = self.matrix.select_rows(columns).select_columns(columns);
        let moment = self.moment.select_rows(columns);
        let factors = gram.cholesky()?.solve(&moment);
        let scaled = factors.iter().zip(columns).map(|(factor, &column)| factor * self.scale[column]).collect();
        Some((factors.dot(&moment), scaled))
    }

    /// What taking out columns that are in would lose.
    fn loss(&self, columns: &[usize]) -> Option<f64> {
        let inverse = -self.matrix.select_rows(columns).select_columns(columns);
        let factors = self.moment.select_rows(columns);
        Some(factors.dot(&inverse.cholesky()?.solve(&factors)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::sightings;
    use crate::effect::Family;
    use crate::model::{self, Preset};
    use crate::progress::Monitor;
    use crate::recording::split::Split;
    use crate::simulation::{Scenario, simulate};

    /// y of six columns, the last two of them alike.
    fn equations() -> NormalEquations {
        let mut chance = ChaCha8Rng::seed_from_u64(5);
        let mut number = || rand::RngExt::random_range(&mut chance, -1.0..1.0);
        let mut x = DMatrix::from_fn(40, 6, |_, column| 10f64.powi(column as i32 - 2) * number());
        let alike = 3.0 * x.column(4);
        x.set_column(5, &alike);
        let y = DVector::from_fn(40, |row, _| x[(row, 0)] + 2.0 * x[(row, 2)] - 0.1 * x[(row, 3)] + 0.1 * number());
        NormalEquations { gram: x.transpose() * &x, moment: x.transpose() * &y, energy: y.norm_squared() }
    }

    /// Gains and losses are those of least squares, and a column that comes and goes leaves nothing behind.
    #[test]
    fn sweeping_is_least_squares() {
        let equations = equations();
        let left = |columns: &[usize]| equations.select(columns).solve().residual_energy;
        let mut swept = Swept::new(&equations, 2);
        let (gain, factors) = swept.gain(&[2, 3]).unwrap();
        assert!((gain - (left(&[0, 1]) - left(&[0, 1, 2, 3]))).abs() < 1e-10);
        let solution = equations.select(&[0, 1, 2, 3]).solve();
        assert!((factors[0] - solution.factors[2]).abs() < 1e-10 && (factors[1] - solution.factors[3]).abs() < 1e-10);
        let before = (swept.matrix.clone(), swept.moment.clone());
        [2, 3].iter().for_each(|&column| swept.sweep(column));
        assert!((swept.loss(&[2]).unwrap() - (left(&[0, 1, 3]) - left(&[0, 1, 2, 3]))).abs() < 1e-10);
        assert!((swept.gain(&[4]).unwrap().0 - (left(&[0, 1, 2, 3]) - left(&[0, 1, 2, 3, 4]))).abs() < 1e-10);
        [3, 2].iter().for_each(|&column| swept.sweep(column));
        assert!((&swept.matrix - before.0).amax() < 1e-10 && (&swept.moment - before.1).amax() < 1e-10);
        swept.sweep(4);
        assert_eq!(swept.gain(&[5]), None, "it says nothing that the one before does not say");
    }

    #[test]
    fn halves_share_nothing_and_leave_nothing_out() {
        for pair in halves(7).chunks(2) {
            let mut all = pair.concat();
            all.sort_unstable();
            assert_eq!(all, (0..7).collect::<Vec<_>>());
        }
        assert_eq!(halves(7), halves(7));
    }

    /// Coulomb friction on joints 1 and 2 is hidden in the sample, and nothing else.
    #[test]
    fn what_is_there_is_found_in_every_half() {
        let recording = simulate(&Scenario::embedded(), &Monitor::new()).unwrap();
        let split = Split::automatic(&recording);
        let body = Preset::RigidBody.model(&recording).unwrap();
        let body = model::fit(&body, &recording, &split, &Monitor::new()).unwrap();
        let (seen, _) = sightings(&body, &recording, &split, &Monitor::new()).unwrap();
        let clue = super::super::CLUES.iter().position(|clue| clue.contains("halves")).unwrap();
        let told: Vec<_> = seen.iter().map(|one| (one.family, one.joint, one.clues[clue])).collect();
        for &(family, joint, steady) in &told {
            let is_there = family == Family::DryFriction && joint.is_some_and(|joint| joint < 2);
            assert!(if is_there { steady == 1.0 } else { steady < 0.5 }, "{told:?}");
        }
    }
}
