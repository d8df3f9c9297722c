//! The loss: squared torque error, weighted by the inverse variance of the torque (equation 11 of the paper), and a penalty on
//! a feed-forward term beside a Lagrangian (equation 15).
//!
//! ```text
//! loss = mean over samples of Σⱼ wⱼ (τ̂ⱼ − τⱼ)² + λ Σⱼ εⱼ²
//! ```

use crate::model::learned::Architecture;
use crate::network::{Element, Program};

/// Where a training program reads its data. Each input is a tile, see [`Program::input`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Inputs {
    /// Columns of effects, column after column, n features each; `None` without effects.
    pub columns: Option<usize>,
    /// Measured torque, n features.
    pub torque: usize,
    /// Weight of each squared error: wⱼ / batch size; 0 for samples that only fill up a tile. n features.
    pub weight: usize,
    /// 1 / batch size, or 0 for samples that only fill up a tile. n features.
    pub share: usize,
}

/// Position, velocity and acceleration are these inputs.
pub const MOTION_INPUTS: [usize; 3] = [0, 1, 2];

/// The program of loss and gradient. Its only output is the loss of each sample and joint, n features; its gradient is that of
/// the sum of these over a batch.
pub fn loss_program<E: Element>(architecture: &Architecture) -> (Program<E>, Inputs) {
    let built = architecture.build();
    let mut graph = built.graph;
    let n = architecture.joints;
    let columns = (architecture.column_count() > 0).then_some(MOTION_INPUTS.len());
    let first = graph.inputs().len();
    let (torque, weight, share) = (graph.input(n), graph.input(n), graph.input(n));
    let error = graph.sub(built.torque, torque);
    let square = graph.mul(error, error);
    let mut loss = graph.mul(weight, square);
    if let Some((lambda, epsilon)) = built.penalised {
        let square = graph.mul(epsilon, epsilon);
        let penalty = graph.mul(share, square);
        let penalty = graph.scale(lambda, penalty);
        loss = graph.add(loss, penalty);
    }
    let inputs = Inputs { columns, torque: first, weight: first + 1, share: first + 2 };
    (Program::compile(graph, &[loss], &[loss]), inputs)
}
