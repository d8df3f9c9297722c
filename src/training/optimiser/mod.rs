//! Optimisers: how weights follow from gradients.
//!
//! The flat vector of weights is cut into [`Part`]s, one a block, that several threads can work on at once.

mod soap;

use serde::{Deserialize, Serialize};

use crate::network::{AdamStep, Block, Buffer, Element, Kernels};
use soap::Basis;

/// Which optimiser, with its settings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Optimiser {
    /// Adam with decoupled weight decay (Loshchilov and Hutter 2019).
    AdamW {
        /// Decay of the mean of the gradient.
        beta_1: f64,
        /// Decay of the mean of its square.
        beta_2: f64,
    },
    /// Adam in the eigenbasis of Shampoo's preconditioner (Vyas et al. 2024), which sees how the weights of a matrix act together.
    Soap {
        /// Decay of the mean of the gradient.
        beta_1: f64,
        /// Decay of the mean squares and of the preconditioner.
        beta_2: f64,
        /// Steps between two updates of the eigenbasis.
        refresh: u64,
    },
}

impl Optimiser {
    /// The usual settings of Adam.
    pub const ADAM_W: Optimiser = Optimiser::AdamW { beta_1: 0.9, beta_2: 0.999 };
    /// Settings of SOAP that do well on arms.
    pub const SOAP: Optimiser = Optimiser::Soap { beta_1: 0.95, beta_2: 0.95, refresh: 30 };
}

/// Added to the root of the mean square.
const EPSILON: f64 = 1e-8;

/// The state of one block of weights.
#[derive(Debug)]
pub struct Part<E: Element> {
    block: Block,
    /// The gradient of this step, to be filled in before it.
    pub gradient: Buffer<E>,
    /// The weights, to be read after a step.
    pub weights: Buffer<E>,
    mean: Buffer<E>,
    square: Buffer<E>,
    basis: Option<Basis<E>>,
}

impl<E: Element> Part<E> {
    /// The state before the first step.
    pub fn new(optimiser: Optimiser, block: &Block, weights: &[E]) -> Self {
        let zeros = || Buffer::zeros(block.size());
        let basis = match optimiser {
            Optimiser::Soap { .. } if block.rows > 1 || block.name.ends_with("/w") => Some(Basis::new(block)),
            _ => None,
        };
        let weights = Buffer::from_slice(&weights[block.range()]);
        Part { block: block.clone(), gradient: zeros(), weights, mean: zeros(), square: zeros(), basis }
    }

    /// The block that it belongs to.
    pub fn block(&self) -> &Block {
        &self.block
    }

    /// About how many operations a step takes, to share the work.
    pub fn cost(&self) -> usize {
        let size = self.block.size();
        if self.basis.is_some() { size * (self.block.rows + self.block.columns) } else { 4 * size }
    }

    /// One step (counted from 1) with this learning rate.
    pub fn step(&mut self, optimiser: Optimiser, kernels: &Kernels<E>, step: u64, rate: f64, decay: f64) {
        let (beta_1, beta_2) = match optimiser {
            Optimiser::AdamW { beta_1, beta_2 } | Optimiser::Soap { beta_1, beta_2, .. } => (beta_1, beta_2),
        };
        let number = E::from_f64;
        let unbias = |beta: f64| number(1.0 / (1.0 - beta.powf(step as f64)));
        let adam = AdamStep {
            rate: number(rate),
            beta_1: number(beta_1),
            beta_2: number(beta_2),
            unbias_1: unbias(beta_1),
            unbias_2: unbias(beta_2),
            epsilon: number(EPSILON),
            decay: number(decay),
        };
        match (&mut self.basis, optimiser) {
            (Some(basis), Optimiser::Soap { refresh, .. }) => {
                basis.observe(kernels, &self.gradient, beta_2, step, refresh, &mut self.mean);
                let rotated = basis.rotate(kernels, &self.gradient);
                let mut update = Buffer::zeros(rotated.len());
                let pure = AdamStep { rate: number(-1.0), decay: E::ZERO, ..adam };
                (kernels.adam)(&pure, &mut update, &rotated, &mut self.mean, &mut self.square);
                let update = basis.rotate_back(kernels, &update);
                let shrink = number(1.0 - rate * decay) - number(1.0);
                let before = self.weights.clone();
                (kernels.add_scaled)(shrink, &before, &mut self.weights);
                (kernels.add_scaled)(number(-rate), &update, &mut self.weights);
            }
            _ => (kernels.adam)(&adam, &mut self.weights, &self.gradient, &mut self.mean, &mut self.square),
        }
    }

    /// All memory beside the weights, to be saved.
    pub fn state(&self) -> Vec<E> {
        let mut state = [&self.mean[..], &self.square[..]].concat();
        if let Some(basis) = &self.basis {
            basis.buffers().for_each(|buffer| state.extend_from_slice(buffer));
        }
        state
    }

    /// Takes back what [`Part::state`] gave; `false` if it has another length.
    pub fn restore(&mut self, state: &[E]) -> bool {
        let mut buffers = vec![&mut self.mean, &mut self.square];
        if let Some(basis) = &mut self.basis {
            buffers.extend(basis.buffers_mut());
        }
        if buffers.iter().map(|buffer| buffer.len()).sum::<usize>() != state.len() {
            return false;
        }
        let mut rest = state;
        for buffer in buffers {
            let (own, after) = rest.split_at(buffer.len());
            buffer.copy_from_slice(own);
            rest = after;
        }
        true
    }
}
