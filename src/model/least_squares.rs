//! Linear least squares by normal equations, which add up over blocks of data.
//!
//! A block's equations are computed once; any selection of blocks (all, all but one, the slow ones) is then a sum of small
//! matrices, so cross-validation and the jackknife cost next to nothing.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

/// XᵀX, Xᵀy and yᵀy of a linear model y ≈ Xβ.
#[derive(Debug, Clone, PartialEq)]
pub struct NormalEquations {
    /// XᵀX.
    pub gram: DMatrix<f64>,
    /// Xᵀy.
    pub moment: DVector<f64>,
    /// yᵀy.
    pub energy: f64,
}

/// The least-squares solution.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// β; 0 where the data can't show the factor.
    pub factors: DVector<f64>,
    /// Whether each factor is one that the data can show.
    pub identified: Vec<bool>,
    /// What is left of yᵀy.
    pub residual_energy: f64,
}

impl Solution {
    /// How many factors the data can show.
    pub fn rank(&self) -> usize {
        self.identified.iter().filter(|&&identified| identified).count()
    }
}

/// Least share of a column's squared length that must be left after the columns before it, for it to count as independent.
const INDEPENDENT: f64 = 1e-10;

/// So many columns are eliminated one by one before the others hear of them.
const PANEL: usize = 16;

impl NormalEquations {
    /// No data: `factors` columns, all zero.
    pub fn empty(factors: usize) -> Self {
        NormalEquations { gram: DMatrix::zeros(factors, factors), moment: DVector::zeros(factors), energy: 0.0 }
    }

    /// Adds `weight` times other data.
    pub fn add(&mut self, other: &NormalEquations, weight: f64) {
        self.gram.zip_apply(&other.gram, |sum, value| *sum += weight * value);
        self.moment.axpy(weight, &other.moment, 1.0);
        self.energy += weight * other.energy;
    }

    /// The same without a part of its data.
    pub fn without(&self, part: &NormalEquations) -> NormalEquations {
        let mut rest = self.clone();
        rest.add(part, -1.0);
        rest
    }

    /// The equations of a selection of columns.
    pub fn select(&self, columns: &[usize]) -> NormalEquations {
        let (rows, count) = (self.moment.len(), columns.len());
        let mut gram = Vec::with_capacity(count * count);
        for &column in columns {
            let whole = &self.gram.as_slice()[column * rows..(column + 1) * rows];
            gram.extend(columns.iter().map(|&row| whole[row]));
        }
        NormalEquations {
            gram: DMatrix::from_vec(count, count, gram),
            moment: DVector::from_fn(count, |i, _| self.moment[columns[i]]),
            energy: self.energy,
        }
    }

    /// ‖y − Xβ‖² for given factors; never negative.
    pub fn residual_energy(&self, factors: &DVector<f64>) -> f64 {
        self.residual_energy_with(&[], factors)
    }

    /// The same with further columns: of each its products with all columns before it and with itself, and its moment. What
    /// equations in all these columns would leave, without a copy of these.
    pub fn residual_energy_with(&self, further: &[(DVector<f64>, f64)], factors: &DVector<f64>) -> f64 {
        let own = self.moment.len();
        let first = factors.rows(0, own);
        let mut left = self.energy - 2.0 * first.dot(&self.moment) + first.dot(&(&self.gram * first));
        for (number, (products, moment)) in further.iter().enumerate() {
            let (before, factor) = (factors.rows(0, own + number), factors[own + number]);
            let shared = products.rows(0, own + number).dot(&before);
            left += factor * (2.0 * (shared - moment) + factor * products[own + number]);
        }
        left.max(0.0)
    }

    /// The equations of the same data with a price on large factors: `share` of its squared length for each column. So many
    /// columns that hardly differ can't blow each other up.
    pub fn damped(&self, share: f64) -> NormalEquations {
        let mut damped = self.clone();
        for i in 0..self.moment.len() {
            damped.gram[(i, i)] *= 1.0 + share;
        }
        damped
    }

    /// Least squares by Cholesky on scaled columns. Of columns that can't be told apart the first is kept, the others get
    /// the factor 0 and are marked as not identified.
    pub fn solve(&self) -> Solution {
        self.eliminate().solution()
    }

    /// How far each factor moves, in the mean, for noise of deviation 1 in y: the roots of the diagonal of (XᵀX)⁻¹; 0 for what the
    /// data can't show.
    pub fn spreads(&self) -> Vec<f64> {
        let identified = self.solve().identified;
        let kept: Vec<usize> = (0..identified.len()).filter(|&column| identified[column]).collect();
        let scale: Vec<f64> = kept.iter().map(|&column| self.gram[(column, column)].sqrt()).collect();
        let scaled =
            DMatrix::from_fn(kept.len(), kept.len(), |i, j| self.gram[(kept[i], kept[j])] / (scale[i] * scale[j]));
        let mut spreads = vec![0.0; identified.len()];
        if let Some(inverse) = scaled.cholesky().map(|cholesky| cholesky.inverse()) {
            for (i, &column) in kept.iter().enumerate() {
                spreads[column] = inverse[(i, i)].sqrt() / scale[i];
            }
        }
        spreads
    }

    /// Eliminates all columns, so that more of them can be tried beside these.
    ///
    /// The same as pushing one column after the other, but what a panel of columns shares with all before it is one product of
    /// matrices.
    pub fn eliminate(&self) -> Elimination {
        let count = self.moment.len();
        let scale: Vec<f64> = (0..count).map(|column| self.gram[(column, column)].max(0.0).sqrt()).collect();
        let inverse = |column: usize| if scale[column] > 0.0 { 1.0 / scale[column] } else { 0.0 };
        let inverse: Vec<f64> = (0..count).map(inverse).collect();
        // Cholesky's factor of the scaled equations takes their place from the left; the last row is that of y.
        let mut left = DMatrix::from_fn(count + 1, count, |row, column| {
            let value = if row < count { self.gram[(row, column)] * inverse[row] } else { self.moment[column] };
            value * inverse[column]
        });
        let mut identified = vec![false; count];
        for start in (0..count).step_by(PANEL) {
            let end = (start + PANEL).min(count);
            let (done, mut panel) = left.columns_range_pair_mut(..start, start..end);
            if start > 0 {
                let shared = done.view((start, 0), (end - start, start)).transpose();
                panel.rows_mut(start, count + 1 - start).gemm(-1.0, &done.rows(start, count + 1 - start), &shared, 1.0);
            }
            for column in start..end {
                let pivot = if scale[column] > 0.0 { panel[(column, column - start)] } else { 0.0 };
                identified[column] = pivot > INDEPENDENT;
                let (mut own, mut later) = panel.columns_range_pair_mut(column - start, column + 1 - start..);
                if !identified[column] {
                    own.fill(0.0);
                    continue;
                }
                own.rows_mut(column, count + 1 - column).unscale_mut(pivot.sqrt());
                for (number, mut later) in later.column_iter_mut().enumerate() {
                    let next = column + 1 + number;
                    let rest = count + 1 - next;
                    later.rows_mut(next, rest).axpy(-own[next], &own.rows(next, rest), 1.0);
                }
            }
        }
        let row = |row: usize| -> Arc<[f64]> {
            if identified[row] {
                left.row(row).iter().take(row + 1).copied().collect()
            } else {
                vec![0.0; row + 1].into()
            }
        };
        Elimination {
            rows: (0..count).map(row).collect(),
            half: left.row(count).iter().copied().collect(),
            scale,
            identified,
            energy: self.energy,
        }
    }
}

/// Columns of which all that earlier ones share was taken out, one after the other (the rows of Cholesky's factor).
#[derive(Debug, Clone, Default)]
pub struct Elimination {
    scale: Vec<f64>,
    /// Shared with what goes on from here: hundreds of candidates are tried beside the same columns.
    rows: Vec<Arc<[f64]>>,
    half: Vec<f64>,
    identified: Vec<bool>,
    energy: f64,
}

impl Elimination {
    /// One more column: its products with all earlier ones, with itself and with y.
    pub fn push(&mut self, products: &[f64], square: f64, moment: f64) {
        let count = self.rows.len();
        let scale = square.max(0.0).sqrt();
        let mut row = vec![0.0; count + 1];
        if scale > 0.0 {
            for j in (0..count).filter(|&j| self.identified[j]) {
                let rest = dot(&row[..j], &self.rows[j][..j]);
                row[j] = (products[j] / (scale * self.scale[j]) - rest) / self.rows[j][j];
            }
        }
        let pivot = if scale > 0.0 { 1.0 - dot(&row, &row) } else { 0.0 };
        let identified = pivot > INDEPENDENT;
        let mut half = 0.0;
        if identified {
            row[count] = pivot.sqrt();
            half = (moment / scale - dot(&row[..count], &self.half)) / row[count];
        } else {
            row.fill(0.0);
        }
        self.scale.push(scale);
        self.rows.push(row.into());
        self.half.push(half);
        self.identified.push(identified);
    }

    /// The next column of these equations, of which all earlier ones are in.
    pub fn push_column(&mut self, equations: &NormalEquations, column: usize) {
        let products: Vec<f64> = (0..column).map(|earlier| equations.gram[(earlier, column)]).collect();
        self.push(&products, equations.gram[(column, column)], equations.moment[column]);
    }

    /// Least squares with all columns.
    pub fn solution(self) -> Solution {
        Solution {
            factors: DVector::from_vec(self.factors_from(0)),
            residual_energy: self.residual_energy(),
            identified: self.identified,
        }
    }

    /// What is left of yᵀy.
    pub fn residual_energy(&self) -> f64 {
        (self.energy - dot(&self.half, &self.half)).max(0.0)
    }

    /// Whether each factor is one that the data can show.
    pub fn identified(&self) -> &[bool] {
        &self.identified
    }

    /// The factors of the columns from `first` on.
    pub fn factors_from(&self, first: usize) -> Vec<f64> {
        let mut factors = self.half.clone();
        for i in (first..self.rows.len()).rev() {
            let row = &self.rows[i];
            factors[i] = if self.identified[i] { factors[i] / row[i] } else { 0.0 };
            let factor = factors[i];
            factors[first..i].iter_mut().zip(&row[first..i]).for_each(|(rest, value)| *rest -= factor * value);
        }
        let unscaled = |(factor, scale): (&f64, &f64)| if *scale > 0.0 { factor / scale } else { 0.0 };
        factors.iter().zip(&self.scale).skip(first).map(unscaled).collect()
    }
}

/// Dot product in eight partial sums, which the compiler turns into vector instructions.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn equations(x: &DMatrix<f64>, y: &DVector<f64>) -> NormalEquations {
        NormalEquations { gram: x.transpose() * x, moment: x.transpose() * y, energy: y.norm_squared() }
    }

    /// Of two columns with a known Gram matrix, and a third that is the sum of both.
    #[test]
    fn spreads_are_those_of_the_inverse() {
        let gram = DMatrix::from_row_slice(3, 3, &[4.0, 1.0, 5.0, 1.0, 2.0, 3.0, 5.0, 3.0, 8.0]);
        let equations = NormalEquations { gram, moment: DVector::from_element(3, 1.0), energy: 9.0 };
        let spreads = equations.spreads();
        assert!(
            (spreads[0] - (2.0f64 / 7.0).sqrt()).abs() < 1e-12 && (spreads[1] - (4.0f64 / 7.0).sqrt()).abs() < 1e-12
        );
        assert_eq!(spreads[2], 0.0);
    }

    #[test]
    fn further_columns_leave_the_same_without_a_copy() {
        let x = DMatrix::from_fn(30, 6, |i, j| ((i * (j + 2)) as f64 * 0.37).sin());
        let whole = equations(&x, &DVector::from_fn(30, |i, _| (i as f64 * 0.1).cos()));
        let factors = DVector::from_vec(vec![0.3, 0.0, -1.2, 0.4, 0.7, -0.2]);
        let column =
            |column: usize| (whole.gram.view((0, column), (column + 1, 1)).column(0).into(), whole.moment[column]);
        let left = whole.select(&[0, 1, 2, 3]).residual_energy_with(&[column(4), column(5)], &factors);
        let expected = whole.residual_energy(&factors);
        assert!((left - expected).abs() < 1e-12 * expected);
    }

    #[test]
    fn solves_what_nalgebra_solves() {
        let x = DMatrix::from_fn(40, 4, |i, j| ((i * (j + 2)) as f64 * 0.37).sin() * 10f64.powi(j as i32 * 2));
        let y = DVector::from_fn(40, |i, _| (i as f64 * 0.1).cos());
        let expected = x.clone().svd(true, true).solve(&y, 1e-14).unwrap();
        let solution = equations(&x, &y).solve();
        assert!((&solution.factors - &expected).component_div(&expected).amax() < 1e-9);
        assert!((solution.residual_energy - (&y - &x * &expected).norm_squared()).abs() < 1e-9);
    }

    /// More columns than a panel has, some of them sums of others and one of zeros.
    #[test]
    fn all_at_once_is_one_after_the_other() {
        let independent =
            DMatrix::from_fn(120, 40, |i, j| ((i * (j + 3)) as f64 * 0.61).sin() * 10f64.powi(j as i32 % 5));
        let mut x = independent.clone().resize_horizontally(45, 0.0);
        for (sum, of) in [(40, [0, 7]), (41, [20, 21]), (43, [3, 39]), (44, [16, 31])] {
            let column = independent.column(of[0]) + independent.column(of[1]);
            x.set_column(sum, &column);
        }
        x.swap_columns(5, 42);
        x.swap_columns(19, 40);
        let y = DVector::from_fn(120, |i, _| (i as f64 * 0.1).cos());
        let equations = equations(&x, &y);
        let at_once = equations.eliminate();
        let mut one_by_one = Elimination { energy: equations.energy, ..Elimination::default() };
        (0..45).for_each(|column| one_by_one.push_column(&equations, column));
        assert_eq!(at_once.identified, one_by_one.identified);
        assert_eq!(at_once.identified.iter().filter(|&&identified| identified).count(), 40);
        assert!((at_once.residual_energy() - one_by_one.residual_energy()).abs() < 1e-9 * equations.energy);
        for (one, other) in at_once.rows.iter().zip(&one_by_one.rows) {
            assert_eq!(one.len(), other.len());
            assert!(one.iter().zip(other.iter()).all(|(one, other)| (one - other).abs() < 1e-9));
        }
        let (factors, others) = (at_once.factors_from(0), one_by_one.factors_from(0));
        assert!(factors.iter().zip(&others).all(|(one, other)| (one - other).abs() < 1e-7 * (1.0 + other.abs())));
        assert_eq!(at_once.factors_from(30), factors[30..]);
    }

    #[test]
    fn of_two_equal_columns_the_first_is_kept() {
        let x = DMatrix::from_fn(10, 3, |i, j| if j == 1 { i as f64 } else { 1.0 });
        let y = DVector::from_fn(10, |i, _| 2.0 * i as f64 + 3.0);
        let solution = equations(&x, &y).solve();
        assert_eq!(solution.identified, [true, true, false]);
        assert!((solution.factors[0] - 3.0).abs() < 1e-9 && (solution.factors[1] - 2.0).abs() < 1e-9);
        assert!(solution.residual_energy < 1e-9);
    }

    #[test]
    fn blocks_add_up() {
        let x = DMatrix::from_fn(30, 2, |i, j| ((i + 7 * j) as f64).sin());
        let y = DVector::from_fn(30, |i, _| (i as f64).cos());
        let mut sum = NormalEquations::empty(2);
        for block in 0..3 {
            sum.add(&equations(&x.rows(block * 10, 10).into(), &y.rows(block * 10, 10).into()), 1.0);
        }
        assert!((sum.gram - equations(&x, &y).gram).amax() < 1e-12);
    }
}
