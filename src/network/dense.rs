//! Dense layers: the networks from which models are made.

use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

use super::graph::{Graph, Node};
use super::kernel::{Element, Function};
use super::layout::Layout;

/// The function of a hidden layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Activation {
    /// tanh x
    Tanh,
    /// 1 / (1 + e⁻ˣ)
    Sigmoid,
    /// ln(1 + eˣ)
    Softplus,
    /// x / (1 + e⁻ˣ)
    Silu,
}

impl Activation {
    fn apply(self, graph: &mut Graph, x: Node) -> Node {
        match self {
            Activation::Tanh => graph.apply(Function::Tanh, x),
            Activation::Sigmoid => graph.apply(Function::Sigmoid, x),
            Activation::Softplus => graph.apply(Function::Softplus, x),
            Activation::Silu => {
                let sigmoid = graph.apply(Function::Sigmoid, x);
                graph.mul(x, sigmoid)
            }
        }
    }
}

/// Adds a network to a graph: hidden layers with an activation, then a linear layer to `outputs` features.
///
/// The blocks are named `<name>/linear_<k>/w` and `…/b`.
pub fn dense(
    graph: &mut Graph,
    name: &str,
    input: Node,
    hidden: &[usize],
    outputs: usize,
    activation: Activation,
) -> Node {
    let mut x = input;
    for (layer, width) in hidden.iter().chain([&outputs]).enumerate() {
        let matrix = graph.layout.matrix(&format!("{name}/linear_{layer}/w"), graph.features(x), *width);
        let bias = graph.layout.vector(&format!("{name}/linear_{layer}/b"), *width);
        x = graph.linear(matrix, Some(bias), x);
        if layer < hidden.len() {
            x = activation.apply(graph, x);
        }
    }
    x
}

/// First weights: matrices with variance 1 / inputs (so that a signal keeps its size from layer to layer), cut off at two
/// standard deviations; vectors zero.
pub fn draw_weights<E: Element>(layout: &Layout, random: &mut impl Rng) -> Vec<E> {
    let mut flat = vec![E::ZERO; layout.size()];
    for block in layout.blocks().iter().filter(|block| block.name.ends_with("/w")) {
        let (inputs, outputs) = block.shape();
        let deviation = 1.0 / (inputs as f64).sqrt();
        let values: Vec<f64> = (0..inputs * outputs).map(|_| deviation * cut_normal(random)).collect();
        layout.write(block, &values, &mut flat);
    }
    flat
}

/// A draw from the normal distribution, cut off at ±2, by Box and Muller's formula.
fn cut_normal(random: &mut impl Rng) -> f64 {
    loop {
        let (u, v): (f64, f64) = (random.random(), random.random());
        let normal = (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos();
        if normal.abs() < 2.0 {
            return normal;
        }
    }
}
