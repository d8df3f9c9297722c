//! The remainder of one joint as rows, beside series that are prepared as it is: quickly, since very many are tried.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use crate::effect::Column;
use crate::model::ModelError;
use crate::model::design::Design;
use crate::model::equations::{Block, PreparedColumn};
use crate::recording::Trajectory;
use crate::signals::Signals;

/// Most numbers in the matrix of all candidates.
const MOST_VALUES: usize = 8_000_000;
/// Rows that are kept however many candidates there are.
const FEWEST_ROWS: usize = 1500;
/// Share of the largest eigenvalue below which a direction of the model counts as none.
const INDEPENDENT: f64 = 1e-9;

/// How series of a whole recording become rows.
pub struct Thinning<'a> {
    design: &'a Design<'a>,
    /// Of the prepared samples of the blocks, every how manieth is a row.
    stride: usize,
}

impl<'a> Thinning<'a> {
    /// For so many series.
    pub fn new(design: &'a Design<'a>, series: usize) -> Self {
        let rows: usize = design.blocks().iter().map(|block| block.samples.len()).sum();
        let most = (MOST_VALUES / series.max(1)).max(FEWEST_ROWS);
        Thinning { design, stride: rows.div_ceil(most).max(1) }
    }

    /// The trajectories on which series are to be computed.
    pub fn runs(&self) -> impl Iterator<Item = &Trajectory> {
        self.design.recording().trajectories.iter()
    }

    /// The rows of a series that was computed on [`Thinning::runs`], filtered as the torque is.
    pub fn rows_of(&self, series: &[Vec<f64>]) -> Vec<f64> {
        let preparations = self.design.preparations().iter();
        let prepared: Vec<Vec<f64>> =
            preparations.zip(series).map(|(preparation, series)| preparation.apply(series)).collect();
        self.gather(|trajectory| &prepared[trajectory])
    }

    /// The rows of the remainder of a joint, and the model's own columns there.
    ///
    /// # Errors
    /// [`ModelError`] if the samples that count can't be told.
    pub fn of_joint(
        &self,
        columns: &[PreparedColumn],
        remainder: &[Signals],
        joint: usize,
    ) -> Result<Rows, ModelError> {
        // Blanked samples of a column of ones are 0, all others are 1.
        let ones = self.design.prepare(|run, _| Ok(vec![ones(run, joint)]))?;
        let rows_of = |column: &PreparedColumn| self.gather_blocks(|block| column.cut(block, joint));
        let counts: Vec<bool> = rows_of(&ones[0]).iter().map(|value| *value != 0.0).collect();
        let own: Vec<DVector<f64>> = columns.iter().chain(&ones).map(rows_of).map(DVector::from_vec).collect();
        let target = DVector::from_vec(self.gather(|trajectory| &remainder[trajectory][joint]));
        let mut blocks = Vec::new();
        let mut start = 0;
        for block in self.design.blocks() {
            let end = start + block.samples.len().div_ceil(self.stride);
            blocks.push(start..end);
            start = end;
        }
        let known = orthonormal(&own, target.len());
        let mut rows = Rows { blocks, counts, known, target: target.clone() };
        rows.target = rows.beside_model(DMatrix::from_columns(&[target])).column(0).into_owned();
        Ok(rows)
    }

    fn gather<'b>(&self, series: impl Fn(usize) -> &'b [f64]) -> Vec<f64> {
        self.gather_blocks(|block| series(block.trajectory).get(block.samples.clone()).unwrap_or_default())
    }

    /// The rows of what `cut` gives of each block; a column is 0 where it gives nothing.
    fn gather_blocks<'b>(&self, cut: impl Fn(&Block) -> &'b [f64]) -> Vec<f64> {
        let rows = |block: &Block| {
            let values = cut(block);
            let samples = (0..block.samples.len()).step_by(self.stride);
            samples.map(|sample| values.get(sample).copied().unwrap_or(0.0)).collect::<Vec<f64>>()
        };
        self.design.blocks().iter().flat_map(rows).collect()
    }
}

/// A column of ones on a joint.
fn ones(run: &Trajectory, joint: usize) -> Column {
    Column::on_joint(joint, std::iter::repeat_n(1.0, run.len()))
}

/// The remainder of one joint beside the model and a constant.
pub struct Rows {
    /// Rows that are kept together in validation.
    pub blocks: Vec<Range<usize>>,
    /// What is left \[N m\].
    pub target: DVector<f64>,
    /// Whether a row counts.
    counts: Vec<bool>,
    /// An orthonormal basis of what the model and a constant can explain.
    known: DMatrix<f64>,
}

impl Rows {
    /// Takes out of series what the model and a constant could explain of them, and the rows that do not count.
    pub fn beside_model(&self, mut series: DMatrix<f64>) -> DMatrix<f64> {
        for (row, _) in self.counts.iter().enumerate().filter(|(_, counts)| !**counts) {
            series.row_mut(row).fill(0.0);
        }
        let shared = self.known.tr_mul(&series);
        series.gemm(-1.0, &self.known, &shared, 1.0);
        series
    }
}

/// An orthonormal basis of the span of these columns.
fn orthonormal(columns: &[DVector<f64>], rows: usize) -> DMatrix<f64> {
    let scaled = columns.iter().filter_map(|column| column.try_normalize(0.0));
    let scaled: Vec<DVector<f64>> = scaled.filter(|column| column.iter().all(|value| value.is_finite())).collect();
    if scaled.is_empty() {
        return DMatrix::zeros(rows, 0);
    }
    let matrix = DMatrix::from_columns(&scaled);
    let eigen = matrix.tr_mul(&matrix).symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    let directions: Vec<DVector<f64>> = eigen
        .eigenvalues
        .iter()
        .enumerate()
        .filter(|(_, value)| **value > INDEPENDENT * largest)
        .map(|(place, value)| &matrix * eigen.eigenvectors.column(place) / value.sqrt())
        .collect();
    DMatrix::from_columns(&directions)
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Rows {
        /// Rows that all count, with no model beside them.
        pub fn of_blocks(blocks: Vec<Range<usize>>, target: DVector<f64>) -> Rows {
            let (counts, known) = (vec![true; target.len()], DMatrix::zeros(target.len(), 0));
            Rows { blocks, target, counts, known }
        }
    }

    #[test]
    fn a_basis_spans_what_its_columns_span_and_no_more() {
        let column = |values: [f64; 4]| DVector::from_column_slice(&values);
        let [one, two] = [column([1.0, 1.0, 0.0, 0.0]), column([0.0, 2.0, 0.0, 5.0])];
        let zero = DVector::zeros(4);
        let basis = orthonormal(&[one.clone(), two.clone(), &one + &two, zero.clone(), one.map(|_| f64::NAN)], 4);
        assert_eq!(basis.ncols(), 2, "a sum, nothing and what is no number add no direction");
        assert!((basis.tr_mul(&basis) - DMatrix::identity(2, 2)).norm() < 1e-12);
        for column in [one, two] {
            assert!((&basis * basis.tr_mul(&column) - &column).norm() < 1e-12);
        }
        assert_eq!(orthonormal(&[zero], 4).shape(), (4, 0));
    }

    #[test]
    fn rows_that_do_not_count_are_nothing_beside_a_model() {
        let mut rows = Rows::of_blocks(vec![0..2, 2..4], DVector::zeros(4));
        rows.counts[3] = false;
        rows.known = orthonormal(&[DVector::from_column_slice(&[1.0, 1.0, 1.0, 0.0])], 4);
        let left = rows.beside_model(DMatrix::from_column_slice(4, 1, &[1.0, 2.0, 3.0, 50.0]));
        assert!((left - DMatrix::from_column_slice(4, 1, &[-1.0, 0.0, 1.0, 0.0])).norm() < 1e-12);
    }
}
