//! The sweep operator: columns of a least-squares problem come in and go out again, each at the price of one pass over the matrix.
//!
//! Source: Goodnight, A tutorial on the SWEEP operator, Am. Stat. 33 (1979) 149.

use nalgebra::{DMatrix, DVector};

use super::least_squares::NormalEquations;

/// Least share of a column's squared length that must be left beside the others. What comes and goes adds rounding at each pass, so
/// this is more than what one elimination from top to bottom asks for.
const INDEPENDENT: f64 = 1e-8;

/// Equations of which some columns are swept: these are fitted, and of all others what they share with them is taken out.
pub struct Swept {
    /// Of columns of length 1. Among swept ones −(XᵀX)⁻¹, among others what is left of XᵀX.
    matrix: DMatrix<f64>,
    /// Factors of swept columns; of others their product with what is left of y.
    moment: DVector<f64>,
    scale: Vec<f64>,
    is_in: Vec<bool>,
}

impl Swept {
    /// Sweeps the first `own` columns, but those that can't be told from the ones before them.
    pub fn new(equations: &NormalEquations, own: usize) -> Self {
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
    pub fn sweep(&mut self, column: usize) {
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
    pub fn gain(&self, columns: &[usize]) -> Option<(f64, Vec<f64>)> {
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
    pub fn loss(&self, columns: &[usize]) -> Option<f64> {
        let inverse = -self.matrix.select_rows(columns).select_columns(columns);
        let factors = self.moment.select_rows(columns);
        Some(factors.dot(&inverse.cholesky()?.solve(&factors)))
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;

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
}
