//! Linear least squares by normal equations, which add up over blocks of data.
//!
//! A block's equations are computed once; any selection of blocks (all, all but one, the slow ones) is then a sum of small
//! matrices, so cross-validation and the jackknife cost next to nothing.

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
        let count = self.moment.len();
        let scale: Vec<f64> = (0..count).map(|i| self.gram[(i, i)].max(0.0).sqrt()).collect();
        let mut lower = DMatrix::<f64>::zeros(count, count);
        let mut identified = vec![false; count];
        for i in 0..count {
            if scale[i] == 0.0 {
                continue;
            }
            for j in (0..i).filter(|&j| identified[j]) {
                let rest: f64 = (0..j).map(|k| lower[(i, k)] * lower[(j, k)]).sum();
                lower[(i, j)] = (self.gram[(i, j)] / (scale[i] * scale[j]) - rest) / lower[(j, j)];
            }
            let pivot = 1.0 - (0..i).map(|k| lower[(i, k)].powi(2)).sum::<f64>();
            if pivot > INDEPENDENT {
                lower[(i, i)] = pivot.sqrt();
                identified[i] = true;
            } else {
                lower.row_mut(i).fill(0.0);
            }
        }
        let kept: Vec<usize> = (0..count).filter(|&i| identified[i]).collect();
        let mut half = DVector::<f64>::zeros(count);
        for &i in &kept {
            let rest: f64 = kept.iter().take_while(|&&k| k < i).map(|&k| lower[(i, k)] * half[k]).sum();
            half[i] = (self.moment[i] / scale[i] - rest) / lower[(i, i)];
        }
        let mut factors = DVector::<f64>::zeros(count);
        for &i in kept.iter().rev() {
            let rest: f64 = kept.iter().filter(|&&k| k > i).map(|&k| lower[(k, i)] * factors[k]).sum();
            factors[i] = (half[i] - rest) / lower[(i, i)];
        }
        for &i in &kept {
            factors[i] /= scale[i];
        }
        let residual_energy = (self.energy - half.norm_squared()).max(0.0);
        Solution { factors, identified, residual_energy }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn equations(x: &DMatrix<f64>, y: &DVector<f64>) -> NormalEquations {
        NormalEquations { gram: x.transpose() * x, moment: x.transpose() * y, energy: y.norm_squared() }
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
