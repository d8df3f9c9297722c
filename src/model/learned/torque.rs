//! The torque of each learned term, as a graph: the formulas of the paper, one function each.

use super::{Architecture, Features, Layers, LearnedTerm, Positive, Scales};
use crate::network::kernel::PAD;
use crate::network::{Function, Graph, Node, dense};

/// A model's graph before anything is asked of it.
#[derive(Debug, Clone)]
pub struct Built {
    /// All nodes.
    pub graph: Graph,
    /// The motion, parts of the state.
    pub motion: Motion,
    /// Measured torque, a part of the state; the model's torque does not depend on it.
    pub measured: Node,
    /// Torque of each term, n features, in the order of the architecture.
    pub terms: Vec<Node>,
    /// Their sum.
    pub torque: Node,
    /// What the Lagrangian term has inside, if there is one.
    pub lagrangian: Option<LagrangianNodes>,
    /// (λ, what the network gives) of a term that the loss penalises: its torque before it is scaled, so that a penalty means the
    /// same in every unit.
    pub penalised: Option<(f64, Node)>,
}

/// Nodes of the motion, n features each.
#[derive(Debug, Clone, Copy)]
pub struct Motion {
    /// Position \[rad\].
    pub q: Node,
    /// Velocity \[rad/s\].
    pub qd: Node,
    /// Acceleration \[rad/s²\].
    pub qdd: Node,
}

/// What a Lagrangian term has inside.
#[derive(Debug, Clone, Copy)]
pub struct LagrangianNodes {
    /// L(q, q̇) \[J\], one feature.
    pub lagrangian: Node,
    /// V(q) \[J\], one feature; only structured Lagrangians have it.
    pub potential: Option<Node>,
    /// Its torque.
    pub torque: Node,
}

impl Architecture {
    /// Features of the state, which is input 0 of every graph: q, q̇, q̈, τ and the effect columns, n features each, then padding to
    /// whole vectors.
    pub fn state_features(&self) -> usize {
        ((4 + self.column_count()) * self.joints).next_multiple_of(PAD)
    }

    /// The graph of the torque. Its only input is the state, see [`Architecture::state_features`].
    ///
    /// The architecture is to be checked before ([`Architecture::check`]).
    pub fn build(&self) -> Built {
        let n = self.joints;
        let mut graph = Graph::new();
        let state = graph.input(self.state_features());
        let mut part = |index: usize| graph.rows(state, index * n, n);
        let motion = Motion { q: part(0), qd: part(1), qdd: part(2) };
        let measured = part(3);
        let weights = &self.scales.joints;
        let features = features(&mut graph, self.features, motion.q, weights);
        let (mut terms, mut lagrangian, mut penalised) = (Vec::new(), None, None);
        for term in &self.terms {
            let torque = match term {
                LearnedTerm::StructuredLagrangian { layers, positive } => {
                    let seen = [inertia_features(&mut graph, self.features, motion.q, features, weights), features];
                    let nodes = structured(&mut graph, seen, motion, layers, *positive, &self.scales);
                    lagrangian = Some(nodes);
                    nodes.torque
                }
                LearnedTerm::BlackBoxLagrangian { layers } => {
                    let qd = graph.scale(1.0 / self.scales.velocity, motion.qd);
                    let input = graph.stack(&[features, qd]);
                    let output = dense(&mut graph, "lagrangian", input, &layers.hidden, 1, layers.activation);
                    let value = graph.scale(self.scales.torque, output);
                    let torque = graph.euler_lagrange(value, motion.q, motion.qd, motion.qdd);
                    lagrangian = Some(LagrangianNodes { lagrangian: value, potential: None, torque });
                    torque
                }
                LearnedTerm::FeedForward { layers, penalty } => {
                    let name =
                        if self.terms.iter().any(LearnedTerm::is_lagrangian) { "epsilon" } else { "inverse_model" };
                    let qd = graph.scale(1.0 / self.scales.velocity, motion.qd);
                    let qdd = graph.scale(1.0 / self.scales.acceleration, motion.qdd);
                    let input = graph.stack(&[features, qd, qdd]);
                    let output = dense(&mut graph, name, input, &layers.hidden, n, layers.activation);
                    if *penalty > 0.0 {
                        penalised = Some((*penalty, output));
                    }
                    graph.scale(self.scales.torque, output)
                }
                LearnedTerm::Friction => {
                    let torque = friction(&mut graph, motion.qd);
                    graph.scale(self.scales.torque, torque)
                }
                LearnedTerm::Columns { names } => {
                    let torque = columns(&mut graph, state, names.len(), n);
                    graph.scale(self.scales.torque, torque)
                }
            };
            terms.push(torque);
        }
        let nothing = graph.constant(0.0, n);
        let torque = terms.iter().fold(nothing, |sum, term| graph.add(sum, *term));
        Built { graph, motion, measured, terms, torque, lagrangian, penalised }
    }
}

/// What the networks see of the positions, of each joint as much as it weighs.
fn features(graph: &mut Graph, features: Features, q: Node, weights: &[f64]) -> Node {
    let (angles, weights) = match features {
        Features::Raw => return weighed(graph, q, weights),
        Features::CosSin => (q, weights.to_vec()),
        // A direction against another link's is that of its last joint.
        Features::LinkAngles => {
            let weights = (0..weights.len()).flat_map(|first| weights[first..].to_vec()).collect();
            (neighbour_sums(graph, q), weights)
        }
    };
    let functions = [Function::Cos, Function::Sin].map(|function| {
        let seen = graph.apply(function, angles);
        weighed(graph, seen, &weights)
    });
    graph.stack(&functions)
}

/// Each feature by its weight; without weights as it is.
fn weighed(graph: &mut Graph, x: Node, weights: &[f64]) -> Node {
    if weights.iter().all(|weight| *weight == 1.0) {
        return x;
    }
    let weights: Vec<Node> = weights.iter().map(|weight| graph.constant(*weight, 1)).collect();
    let weights = graph.stack(&weights);
    graph.mul(weights, x)
}

/// What the network of H sees. The inertia of an arm is the same wherever its first joint stands, which the directions of links
/// against each other say; a single joint keeps its angle.
fn inertia_features(graph: &mut Graph, kind: Features, q: Node, all: Node, weights: &[f64]) -> Node {
    let n = graph.features(q);
    if kind != Features::LinkAngles || n == 1 {
        return all;
    }
    let rest = graph.rows(q, 1, n - 1);
    features(graph, kind, rest, weights.get(1..).unwrap_or_default())
}

/// q_i + … + q_j for all i ≤ j.
fn neighbour_sums(graph: &mut Graph, q: Node) -> Node {
    let n = graph.features(q);
    let mut sums = Vec::new();
    for first in 0..n {
        let mut sum = graph.rows(q, first, 1);
        sums.push(sum);
        for next in first + 1..n {
            let angle = graph.rows(q, next, 1);
            sum = graph.add(sum, angle);
            sums.push(sum);
        }
    }
    graph.stack(&sums)
}

/// L = ½ q̇ᵀ H q̇ − V, equation (5) of the paper. `seen` is what the networks of H and V see.
fn structured(
    graph: &mut Graph,
    seen: [Node; 2],
    motion: Motion,
    layers: &Layers,
    positive: Option<Positive>,
    scales: &Scales,
) -> LagrangianNodes {
    let n = graph.features(motion.qd);
    let size = n * (n + 1) / 2;
    let roots: Vec<f64> = scales.joints.iter().map(|weight| weight.sqrt()).collect();
    let weighed_qd = weighed(graph, motion.qd, &roots);
    let o = dense(graph, "mass_matrix", seen[0], &layers.hidden, size, layers.activation);
    let scale = scales.inertia.unwrap_or(scales.torque);
    let kinetic = match positive {
        Some(positive) => positive_energy(graph, o, [weighed_qd, motion.qd], positive, scale),
        None => {
            // ½ q̇ᵀ (C + Cᵀ) q̇
            let product = graph.lower(o, weighed_qd, true);
            let product = graph.mul(weighed_qd, product);
            let sum = graph.sum_features(product);
            graph.scale(scale, sum)
        }
    };
    let v = dense(graph, "potential_energy", seen[1], &layers.hidden, 1, layers.activation);
    let potential = graph.scale(scales.torque, v);
    let lagrangian = graph.sub(kinetic, potential);
    let torque = graph.euler_lagrange(lagrangian, motion.q, motion.qd, motion.qdd);
    LagrangianNodes { lagrangian, potential: Some(potential), torque }
}

/// ½ scale ‖Cᵀv‖² + ½ ε ‖q̇‖², where v is q̇ by the weight of each joint, and `o` holds the diagonal of C before it is made positive,
/// then the rest of it.
fn positive_energy(graph: &mut Graph, o: Node, [weighed, qd]: [Node; 2], positive: Positive, scale: f64) -> Node {
    let (n, size) = (graph.features(qd), graph.features(o));
    let diagonal = graph.rows(o, 0, n);
    let shifted = graph.shift(positive.shift, diagonal);
    let soft = graph.apply(Function::Softplus, shifted);
    let diagonal = graph.shift(positive.floor, soft);
    let triangle = if size > n {
        let rest = graph.rows(o, n, size - n);
        graph.stack(&[diagonal, rest])
    } else {
        diagonal
    };
    let half_momentum = graph.lower(triangle, weighed, true);
    let square = graph.mul(half_momentum, half_momentum);
    let sum = graph.sum_features(square);
    let kinetic = graph.scale(0.5 * scale, sum);
    if positive.inertia == 0.0 {
        return kinetic;
    }
    let square = graph.mul(qd, qd);
    let sum = graph.sum_features(square);
    let floor = graph.scale(0.5 * positive.inertia, sum);
    graph.add(kinetic, floor)
}

/// (τ_C + τ_S exp(−q̇² / v)) sign q̇ + d q̇ for each joint, equation (12) of the paper with the sign of a motor's torque; v = e^(log v)
/// stays positive.
fn friction(graph: &mut Graph, qd: Node) -> Node {
    let n = graph.features(qd);
    let parameter = |graph: &mut Graph, name: &str| {
        let block = graph.layout.vector(&format!("friction/{name}"), n);
        graph.parameter(block)
    };
    let coulomb = parameter(graph, "tau_cv");
    let stribeck = parameter(graph, "tau_cs");
    let log_v = parameter(graph, "log_v");
    let damping = parameter(graph, "d");
    let minus_log_v = graph.scale(-1.0, log_v);
    let inverse_v = graph.apply(Function::Exp, minus_log_v);
    let square = graph.mul(qd, qd);
    let exponent = graph.mul(square, inverse_v);
    let exponent = graph.scale(-1.0, exponent);
    let bell = graph.apply(Function::Exp, exponent);
    let falling = graph.mul(stribeck, bell);
    let level = graph.add(coulomb, falling);
    let sign = graph.apply(Function::Sign, qd);
    let dry = graph.mul(level, sign);
    let wet = graph.mul(damping, qd);
    graph.add(dry, wet)
}

/// Σ factor · column; the columns are the last part of the state.
fn columns(graph: &mut Graph, state: Node, count: usize, n: usize) -> Node {
    let block = graph.layout.vector("effects/factors", count);
    let factors = graph.parameter(block);
    let mut torque = graph.constant(0.0, n);
    for k in 0..count {
        let column = graph.rows(state, (4 + k) * n, n);
        let factor = graph.rows(factors, k, 1);
        let factor = graph.spread(factor, n);
        let part = graph.mul(factor, column);
        torque = graph.add(torque, part);
    }
    torque
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::model::learned::LearnedPreset;

    fn built(preset: LearnedPreset) -> Built {
        preset.architecture(2, &Layers { hidden: vec![4], ..Layers::default() }).build()
    }

    /// What a network is called says whether it stands alone or beside a Lagrangian; only what has a price is priced.
    #[test]
    fn a_network_beside_a_lagrangian_is_its_remainder() {
        let names = |built: &Built| -> String {
            let blocks = built.graph.layout.blocks();
            blocks.iter().map(|block| block.name.as_str()).collect::<Vec<_>>().join(" ")
        };
        let alone = built(LearnedPreset::FfNn);
        assert!(names(&alone).contains("inverse_model") && alone.penalised.is_none() && alone.lagrangian.is_none());
        let beside = built(LearnedPreset::DelanFfnn);
        assert!(names(&beside).contains("epsilon") && !names(&beside).contains("inverse_model"));
        assert_eq!(beside.penalised.map(|(price, _)| price), Some(0.1));
        assert!(beside.lagrangian.is_some_and(|nodes| nodes.potential.is_some()));
        let black_box = built(LearnedPreset::BlackBoxDelan);
        assert!(black_box.lagrangian.is_some_and(|nodes| nodes.potential.is_none()));
    }

    /// Of three joints: H and V of a planar arm see six sums of neighbouring angles, H those three without the first joint.
    #[test]
    fn networks_see_as_many_features_as_there_are_directions() {
        let seen = |features: Features, joints: usize| {
            let mut graph = Graph::new();
            let q = graph.input(joints);
            let all = super::features(&mut graph, features, q, &[]);
            let of_inertia = inertia_features(&mut graph, features, q, all, &[]);
            [graph.features(all), graph.features(of_inertia)]
        };
        assert_eq!(seen(Features::Raw, 3), [3, 3]);
        assert_eq!(seen(Features::CosSin, 3), [6, 6]);
        assert_eq!(seen(Features::LinkAngles, 3), [12, 6]);
        assert_eq!(seen(Features::LinkAngles, 1), [2, 2], "a single joint keeps its angle");
    }
}
