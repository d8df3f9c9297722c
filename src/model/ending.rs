//! Other columns at the end of the same equations: a search for a shape tries dozens of them beside what stays.

use super::equations::{Equations, PreparedColumn};
use super::least_squares::{Elimination, NormalEquations};
use crate::signals::Signals;

/// Columns that stay, all that they share taken out once, with room for others behind them.
pub struct Ending<'a> {
    equations: &'a Equations,
    kept: Vec<&'a PreparedColumn>,
    torque: &'a [Signals],
    weights: &'a [f64],
    /// Over all blocks: of the columns that stay, then of those behind them.
    sum: NormalEquations,
    /// The columns that stay.
    beside: Elimination,
}

impl<'a> Ending<'a> {
    /// Behind the columns `kept`, which come first in `sum`: the weighted equations over all blocks, of `kept` and what was tried last.
    pub fn new(
        equations: &'a Equations,
        kept: Vec<&'a PreparedColumn>,
        sum: NormalEquations,
        torque: &'a [Signals],
        weights: &'a [f64],
    ) -> Self {
        let stays: Vec<usize> = (0..kept.len()).collect();
        let beside = sum.select(&stays).eliminate();
        Ending { equations, kept, torque, weights, sum, beside }
    }

    /// The weighted squared error with these columns behind those that stay, as many as `sum` has.
    pub fn residual_energy(&mut self, own: &[PreparedColumn]) -> f64 {
        self.equations.complete(&mut self.sum, &self.kept, own, self.torque, self.weights);
        let mut elimination = self.beside.clone();
        (self.kept.len()..self.sum.moment.len()).for_each(|column| elimination.push_column(&self.sum, column));
        elimination.residual_energy()
    }
}
