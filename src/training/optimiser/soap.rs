//! SOAP: Adam in the eigenbasis of Shampoo's preconditioner.
//!
//! For a weight matrix with gradient G the means of G Gᵀ and GᵀG are followed; in the basis of their eigenvectors, Q_Lᵀ G Q_R, the
//! gradient is nearly diagonal, and Adam there acts like a second-order method. The basis is followed by one step of power
//! iteration and Gram–Schmidt now and then, which costs little.
//!
//! Source: Vyas et al., *SOAP: Improving and Stabilizing Shampoo using Adam*, 2024 (arXiv 2409.11321).

use nalgebra::{DMatrix, SymmetricEigen};

use crate::network::kernel::{Factors, PAD, Start};
use crate::network::{Block, Buffer, Element, Kernels};

/// Sides of a matrix longer than this keep their own basis: the eigenbasis would cost more than it brings.
const LONGEST_SIDE: usize = 512;

/// One side of a matrix.
#[derive(Debug)]
struct Side<E> {
    /// Mean of G Gᵀ (or GᵀG), order × order, rows padded.
    covariance: Buffer<E>,
    /// The basis: eigenvectors in its columns.
    vectors: Buffer<E>,
    order: usize,
}

/// The two sides of a matrix.
#[derive(Debug)]
pub(super) struct Basis<E> {
    rows: usize,
    columns: usize,
    left: Option<Side<E>>,
    right: Option<Side<E>>,
}

/// A matrix by rows, which are padded to `stride`.
#[derive(Clone, Copy)]
struct Matrix<'a, E> {
    values: &'a [E],
    rows: usize,
    columns: usize,
}

impl<E: Element> Side<E> {
    fn new(order: usize) -> Option<Self> {
        let zeros = || Buffer::zeros(order * order.next_multiple_of(PAD));
        (2..=LONGEST_SIDE).contains(&order).then(|| Side { covariance: zeros(), vectors: zeros(), order })
    }

    fn vectors(&self) -> Matrix<'_, E> {
        Matrix { values: &self.vectors, rows: self.order, columns: self.order }
    }

    /// The eigenvectors of the covariance, from scratch.
    fn begin(&mut self) {
        let stride = self.order.next_multiple_of(PAD);
        let entry = |i: usize, j: usize| self.covariance[i * stride + j].to_f64();
        let eigen = SymmetricEigen::new(DMatrix::from_fn(self.order, self.order, entry));
        for i in 0..self.order {
            for j in 0..self.order {
                self.vectors[i * stride + j] = E::from_f64(eigen.eigenvectors[(i, j)]);
            }
        }
    }

    /// One step of power iteration: orthonormal columns of covariance · vectors.
    fn follow(&mut self, kernels: &Kernels<E>) {
        let covariance = Matrix { values: &self.covariance, rows: self.order, columns: self.order };
        let mut product = multiply(kernels, covariance, false, self.vectors());
        // A small multiple of the unit matrix keeps vectors of no variance from vanishing; it turns none.
        let stride = self.order.next_multiple_of(PAD);
        let trace: f64 = (0..self.order).map(|i| self.covariance[i * stride + i].to_f64()).sum();
        let little = E::from_f64(1e-6 * trace / self.order as f64);
        (kernels.add_scaled)(little, &self.vectors, &mut product);
        let mut columns = transposed(Matrix { values: &product, rows: self.order, columns: self.order });
        if orthonormalise(&mut columns, self.order) {
            self.vectors = transposed(Matrix { values: &columns, rows: self.order, columns: self.order });
        }
    }
}

impl<E: Element> Basis<E> {
    pub(super) fn new(block: &Block) -> Self {
        let (left, right) = (Side::new(block.rows), Side::new(block.columns));
        Basis { rows: block.rows, columns: block.columns, left, right }
    }

    /// Takes in a gradient and, when it is time, turns the basis and with it the `mean`, which is kept in the basis.
    pub(super) fn observe(
        &mut self,
        kernels: &Kernels<E>,
        gradient: &[E],
        beta: f64,
        step: u64,
        refresh: u64,
        mean: &mut Buffer<E>,
    ) {
        let g = Matrix { values: gradient, rows: self.rows, columns: self.columns };
        let share = if step == 1 { 1.0 } else { 1.0 - beta };
        let take_in = |side: &mut Side<E>, square: &[E]| {
            let before = side.covariance.clone();
            (kernels.add_scaled)(E::from_f64(-share), &before, &mut side.covariance);
            (kernels.add_scaled)(E::from_f64(share), square, &mut side.covariance);
        };
        if let Some(left) = &mut self.left {
            let turned = transposed(g);
            let turned = Matrix { values: &turned, rows: self.columns, columns: self.rows };
            take_in(left, &multiply(kernels, g, false, turned));
        }
        if let Some(right) = &mut self.right {
            take_in(right, &multiply(kernels, g, true, g));
        }
        if step == 1 {
            self.left.iter_mut().chain(&mut self.right).for_each(Side::begin);
        } else if step.is_multiple_of(refresh) {
            let own = self.rotate_back(kernels, mean);
            self.left.iter_mut().chain(&mut self.right).for_each(|side| side.follow(kernels));
            *mean = self.rotate(kernels, &own);
        }
    }

    /// Q_Lᵀ G Q_R
    pub(super) fn rotate(&self, kernels: &Kernels<E>, g: &[E]) -> Buffer<E> {
        let mut result = Buffer::from_slice(g);
        if let Some(left) = &self.left {
            result = multiply(kernels, left.vectors(), true, self.matrix(&result));
        }
        if let Some(right) = &self.right {
            result = multiply(kernels, self.matrix(&result), false, right.vectors());
        }
        result
    }

    /// Q_L G Q_Rᵀ
    pub(super) fn rotate_back(&self, kernels: &Kernels<E>, g: &[E]) -> Buffer<E> {
        let mut result = Buffer::from_slice(g);
        if let Some(left) = &self.left {
            result = multiply(kernels, left.vectors(), false, self.matrix(&result));
        }
        if let Some(right) = &self.right {
            let turned = transposed(right.vectors());
            let turned = Matrix { values: &turned, rows: right.order, columns: right.order };
            result = multiply(kernels, self.matrix(&result), false, turned);
        }
        result
    }

    fn matrix<'a>(&self, values: &'a [E]) -> Matrix<'a, E> {
        Matrix { values, rows: self.rows, columns: self.columns }
    }

    pub(super) fn buffers(&self) -> impl Iterator<Item = &Buffer<E>> {
        self.left.iter().chain(&self.right).flat_map(|side| [&side.covariance, &side.vectors])
    }

    pub(super) fn buffers_mut(&mut self) -> impl Iterator<Item = &mut Buffer<E>> {
        self.left.iter_mut().chain(&mut self.right).flat_map(|side| [&mut side.covariance, &mut side.vectors])
    }
}

/// A B or, if `turn`, Aᵀ B.
fn multiply<E: Element>(kernels: &Kernels<E>, a: Matrix<E>, turn: bool, b: Matrix<E>) -> Buffer<E> {
    let (a_stride, stride) = (a.columns.next_multiple_of(PAD), b.columns.next_multiple_of(PAD));
    let (rows, depth) = if turn { (a.columns, a.rows) } else { (a.rows, a.columns) };
    let (a_row, a_depth) = if turn { (1, a_stride) } else { (a_stride, 1) };
    let mut product = Buffer::zeros(rows * stride);
    let (a, b) = (a.values, b.values);
    let factors = Factors { rows, columns: stride, depth, a, a_row, a_depth, b, b_row: stride, start: Start::Zero };
    (kernels.product)(&factors, &mut product, stride);
    product
}

fn transposed<E: Element>(a: Matrix<E>) -> Buffer<E> {
    let (a_stride, stride) = (a.columns.next_multiple_of(PAD), a.rows.next_multiple_of(PAD));
    let mut turned = Buffer::zeros(a.columns * stride);
    // By blocks of 8 columns, so that each line of the result is filled while it is near.
    for first in (0..a.columns).step_by(8) {
        for i in 0..a.rows {
            for j in first..(first + 8).min(a.columns) {
                turned[j * stride + i] = a.values[i * a_stride + j];
            }
        }
    }
    turned
}

/// Makes the rows orthonormal by Gram and Schmidt's method, each row twice for accuracy; `false` if they are not independent
/// or not numbers.
fn orthonormalise<E: Element>(rows: &mut [E], order: usize) -> bool {
    let stride = order.next_multiple_of(PAD);
    for i in 0..order {
        let (before, rest) = rows.split_at_mut(i * stride);
        let row = &mut rest[..stride];
        let length = dot(row, row).to_f64().sqrt();
        if !(length > 0.0 && length.is_finite()) {
            return false;
        }
        scale(row, 1.0 / length);
        for _ in 0..2 {
            for other in before.chunks_exact(stride) {
                let overlap = dot(row, other);
                for (element, component) in row.iter_mut().zip(other) {
                    *element = *element - overlap * *component;
                }
            }
            let length = dot(row, row).to_f64().sqrt();
            if length < 1e-6 {
                return false;
            }
            scale(row, 1.0 / length);
        }
    }
    true
}

fn scale<E: Element>(row: &mut [E], factor: f64) {
    for element in row {
        *element = *element * E::from_f64(factor);
    }
}

/// Σ a b with 16 sums side by side, which the compiler turns into vectors.
fn dot<E: Element>(a: &[E], b: &[E]) -> E {
    let mut sums = [E::ZERO; PAD];
    for (a, b) in a.chunks_exact(PAD).zip(b.chunks_exact(PAD)) {
        for lane in 0..PAD {
            sums[lane] = sums[lane] + a[lane] * b[lane];
        }
    }
    sums.into_iter().fold(E::ZERO, |sum, lane| sum + lane)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_basis_is_orthonormal_and_turns_there_and_back() {
        let block = Block { name: "w".into(), rows: 5, columns: 20, turned: false, offset: 0 };
        let mut basis = Basis::<f64>::new(&block);
        let kernels = f64::kernels();
        let mut g = Buffer::zeros(block.size());
        let mut mean = Buffer::zeros(block.size());
        for step in 1..=6 {
            for i in 0..5 {
                for j in 0..20 {
                    g[i * 32 + j] = ((i * 20 + j) as f64 * step as f64 * 0.37).sin();
                }
            }
            basis.observe(kernels, &g, 0.9, step, 2, &mut mean);
            let there = basis.rotate(kernels, &g);
            let back = basis.rotate_back(kernels, &there);
            assert!(back.iter().zip(g.iter()).all(|(a, b)| (a - b).abs() < 1e-10), "step {step}");
        }
    }
}
