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
        NormalEquations {
            gram: DMatrix::from_fn(columns.len(), columns.len(), |i, j| self.gram[(columns[i], columns[j])]),
            moment: DVector::from_fn(columns.len(), |i, _| self.moment[columns[i]]),
            energy: self.energy,
        }
    }

    /// ‖y − Xβ‖² for given factors; never negative.
    pub fn residual_energy(&self, factors: &DVector<f64>) -> f64 {
        (self.energy - 2.0 * factors.dot(&self.moment) + factors.dot(&(&self.gram * factors))).max(0.0)
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
        let elimination = self.eliminate();
        Solution {
            factors: DVector::from_vec(elimination.factors_from(0)),
            residual_energy: elimination.residual_energy(),
            identified: elimination.identified,
        }
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
    pub fn eliminate(&self) -> Elimination {
        let mut elimination = Elimination { energy: self.energy, ..Elimination::default() };
        (0..self.moment.len()).for_each(|column| elimination.push_column(self, column));
        elimination
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
        let mut factors = vec![0.0; self.rows.len()];
        for i in (first..self.rows.len()).rev().filter(|&i| self.identified[i]) {
            let rest: f64 = (i + 1..self.rows.len()).map(|k| self.rows[k][i] * factors[k]).sum();
            factors[i] = (self.half[i] - rest) / self.rows[i][i];
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
    fn solves_what_nalgebra_solves() {
        let x = DMatrix::from_fn(40, 4, |i, j| ((i * (j + 2)) as f64 * 0.37).sin() * 10f64.powi(j as i32 * 2));
        let y = DVector::from_fn(40, |i, _| (i as f64 * 0.1).cos());
        let expected = x.clone().svd(true, true).solve(&y, 1e-14).unwrap();
        let solution = equations(&x, &y).solve();
        assert!((&solution.factors - &expected).component_div(&expected).amax() < 1e-9);
        assert!((solution.residual_energy - (&y - &x * &expected).norm_squared()).abs() < 1e-9);
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
