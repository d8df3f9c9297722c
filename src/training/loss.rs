//! The loss: squared torque error, weighted by the inverse variance of the torque (equation 11 of the paper), and a penalty on
//! a feed-forward term beside a Lagrangian (equation 15).
//!
//! ```text
//! loss = mean over samples of Σⱼ wⱼ (τ̂ⱼ − τⱼ)² + λ Σⱼ (εⱼ / scale)²
//! ```
//!
//! The scale of torque is 1 in the paper, whose ε² then has a unit beside squared errors that have none: of what only ε can explain
//! it learns the share 1 / (1 + λ / wⱼ), so a tenth on a joint of 10 N m and all on one of 0.3 N m. Scaled to the data
//! ([`super::options::scale_to`]), that share is the same for every arm.

use crate::model::learned::Architecture;
use crate::network::{Element, Program};

/// Input 0 is the state ([`Architecture::state_features`]); this one holds the weight of each squared error: wⱼ / batch size, or 0
/// for samples that only fill up a tile; n features. See [`Program::input`].
pub const WEIGHT_INPUT: usize = 1;
/// 1 / batch size, or 0 for samples that only fill up a tile; n features.
pub const SHARE_INPUT: usize = 2;

/// The program of loss and gradient. Its only output is the loss of each sample and joint, n features; its gradient is that of
/// the sum of these over a batch.
pub fn loss_program<E: Element>(architecture: &Architecture) -> Program<E> {
    let built = architecture.build();
    let mut graph = built.graph;
    let n = architecture.joints;
    let (weight, share) = (graph.input(n), graph.input(n));
    let error = graph.sub(built.torque, built.measured);
    let square = graph.mul(error, error);
    let mut loss = graph.mul(weight, square);
    if let Some((lambda, epsilon)) = built.penalised {
        let square = graph.mul(epsilon, epsilon);
        let penalty = graph.mul(share, square);
        let penalty = graph.scale(lambda, penalty);
        loss = graph.add(loss, penalty);
    }
    Program::compile(graph, &[loss], &[loss])
}
