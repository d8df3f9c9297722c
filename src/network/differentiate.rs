//! Derivatives of graphs, as graphs.
//!
//! [`Graph::tangent`] carries a direction forwards (one pass for one direction, whatever the number of results),
//! [`Graph::pull_back`] carries weights of results backwards (one pass for one sum, whatever the number of variables). Both give
//! nodes, so they can be applied to each other's results: [`Graph::euler_lagrange`] is three lines.

use std::collections::HashMap;

use super::graph::{Graph, Node, Op};
use super::kernel::Function;
use super::layout::BlockId;

/// One contribution to the gradient by parameters, summed over all samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sink {
    /// matrix += left rightᵀ, left along the stored rows, right along the stored columns
    Outer { matrix: BlockId, left: Node, right: Node },
    /// vector += x
    Sum { vector: BlockId, x: Node },
}

impl Graph {
    /// The derivative of `of` along a direction: `along` names variables and the direction in each.
    pub fn tangent(&mut self, of: Node, along: &[(Node, Node)]) -> Node {
        let mut known: HashMap<Node, Option<Node>> = HashMap::new();
        for index in 0..=of.0 {
            let node = Node(index);
            let direction = along.iter().find(|(variable, _)| *variable == node).map(|(_, direction)| *direction);
            let tangent = direction.or_else(|| self.forward(node, &known));
            known.insert(node, tangent);
        }
        let features = self.features(of);
        known[&of].unwrap_or_else(|| self.constant(0.0, features))
    }

    /// The tangent of one node from those of its operands; `None` is zero.
    fn forward(&mut self, node: Node, known: &HashMap<Node, Option<Node>>) -> Option<Node> {
        let of = |x: Node| known[&x];
        let features = self.features(node);
        match self.op(node) {
            Op::Input(_) | Op::Constant(_) | Op::Parameter(_) => None,
            Op::Product { matrix, back, x, .. } => of(x).map(|dx| self.product(matrix, back, None, dx)),
            Op::Add(a, b) => self.both(of(a), of(b)),
            Op::Mul(a, b) => {
                let (left, right) = (of(a).map(|da| self.mul(da, b)), of(b).map(|db| self.mul(a, db)));
                self.both(left, right)
            }
            Op::Scale(factor, x) => of(x).map(|dx| self.scale(factor.value(), dx)),
            Op::Shift(_, x) => of(x),
            Op::Apply(function, x) => {
                let dx = of(x)?;
                let slope = self.slope(function, x, node)?;
                Some(self.mul(slope, dx))
            }
            Op::SumFeatures(x) => of(x).map(|dx| self.sum_features(dx)),
            Op::Spread(x) => of(x).map(|dx| self.spread(dx, features)),
            Op::Lower { packed, v, transposed } => {
                let left = of(packed).map(|dpacked| self.lower(dpacked, v, transposed));
                let right = of(v).map(|dv| self.lower(packed, dv, transposed));
                self.both(left, right)
            }
            Op::LowerOuter(a, b) => {
                let (left, right) = (of(a).map(|da| self.lower_outer(da, b)), of(b).map(|db| self.lower_outer(a, db)));
                self.both(left, right)
            }
            Op::Rows(x, start) => of(x).map(|dx| self.rows(dx, start, features)),
            Op::Place(x, start) => of(x).map(|dx| self.place(dx, start, features)),
        }
    }

    fn both(&mut self, a: Option<Node>, b: Option<Node>) -> Option<Node> {
        match (a, b) {
            (Some(a), Some(b)) => Some(self.add(a, b)),
            (one, other) => one.or(other),
        }
    }

    /// f′(x), where y = f(x); `None` is zero.
    fn slope(&mut self, function: Function, x: Node, y: Node) -> Option<Node> {
        match function {
            Function::Tanh => {
                let square = self.mul(y, y);
                let minus = self.scale(-1.0, square);
                Some(self.shift(1.0, minus))
            }
            Function::Sigmoid => {
                let square = self.mul(y, y);
                Some(self.sub(y, square))
            }
            Function::Softplus => Some(self.apply(Function::Sigmoid, x)),
            Function::Exp => Some(y),
            Function::Sin => Some(self.apply(Function::Cos, x)),
            Function::Cos => {
                let sin = self.apply(Function::Sin, x);
                Some(self.scale(-1.0, sin))
            }
            Function::Sign => None,
        }
    }

    /// Σ weightᵀ ∂of/∂variable for each variable: the gradient of the weighted sum of results.
    pub fn pull_back(&mut self, of: &[(Node, Node)], variables: &[Node]) -> Vec<Node> {
        let mut depends = vec![false; self.ops.len()];
        for index in 0..self.ops.len() {
            let node = Node(index);
            depends[index] = variables.contains(&node) || self.operands(node).any(|operand| depends[operand.0]);
        }
        let (gradients, _) = self.backward(of, &depends);
        let zero = |graph: &mut Graph, variable| graph.constant(0.0, graph.features(variable));
        variables.iter().map(|v| gradients.get(v).copied().unwrap_or_else(|| zero(self, *v))).collect()
    }

    /// The contributions to the gradient, by all parameters, of the sum of `losses` over features and samples.
    pub(super) fn parameter_gradient(&mut self, losses: &[Node]) -> Vec<Sink> {
        let mut depends = vec![false; self.ops.len()];
        for index in 0..self.ops.len() {
            let node = Node(index);
            let is_own = matches!(self.op(node), Op::Parameter(_) | Op::Product { .. });
            depends[index] = is_own || self.operands(node).any(|operand| depends[operand.0]);
        }
        let ones: Vec<_> = losses.iter().map(|loss| (*loss, self.constant(1.0, self.features(*loss)))).collect();
        self.backward(&ones, &depends).1
    }

    /// Carries weights back through all nodes that `depends` marks.
    fn backward(&mut self, of: &[(Node, Node)], depends: &[bool]) -> (HashMap<Node, Node>, Vec<Sink>) {
        let mut gradients: HashMap<Node, Node> = HashMap::new();
        let mut sinks = Vec::new();
        for (node, weight) in of {
            self.collect(&mut gradients, depends, *node, *weight);
        }
        let last = of.iter().map(|(node, _)| node.0).max().unwrap_or(0);
        for node in (0..=last).rev().map(Node) {
            let Some(g) = gradients.get(&node).copied() else { continue };
            match self.op(node) {
                Op::Input(_) | Op::Constant(_) => {}
                Op::Parameter(vector) => sinks.push(Sink::Sum { vector, x: g }),
                Op::Product { matrix, back, bias, x } => {
                    let (left, right) = if back { (x, g) } else { (g, x) };
                    sinks.push(Sink::Outer { matrix, left, right });
                    sinks.extend(bias.map(|vector| Sink::Sum { vector, x: g }));
                    if depends[x.0] {
                        let through = self.product(matrix, !back, None, g);
                        self.collect(&mut gradients, depends, x, through);
                    }
                }
                Op::Add(a, b) => {
                    self.collect(&mut gradients, depends, a, g);
                    self.collect(&mut gradients, depends, b, g);
                }
                Op::Mul(a, b) => {
                    for (one, other) in [(a, b), (b, a)] {
                        if depends[one.0] {
                            let through = self.mul(g, other);
                            self.collect(&mut gradients, depends, one, through);
                        }
                    }
                }
                Op::Scale(factor, x) => {
                    let through = self.scale(factor.value(), g);
                    self.collect(&mut gradients, depends, x, through);
                }
                Op::Shift(_, x) => self.collect(&mut gradients, depends, x, g),
                Op::Apply(function, x) => {
                    if depends[x.0]
                        && let Some(slope) = self.slope(function, x, node)
                    {
                        let through = self.mul(slope, g);
                        self.collect(&mut gradients, depends, x, through);
                    }
                }
                Op::SumFeatures(x) => {
                    let through = self.spread(g, self.features(x));
                    self.collect(&mut gradients, depends, x, through);
                }
                Op::Spread(x) => {
                    let through = self.sum_features(g);
                    self.collect(&mut gradients, depends, x, through);
                }
                Op::Lower { packed, v, transposed } => {
                    if depends[packed.0] {
                        let through = if transposed { self.lower_outer(v, g) } else { self.lower_outer(g, v) };
                        self.collect(&mut gradients, depends, packed, through);
                    }
                    if depends[v.0] {
                        let through = self.lower(packed, g, !transposed);
                        self.collect(&mut gradients, depends, v, through);
                    }
                }
                Op::LowerOuter(a, b) => {
                    if depends[a.0] {
                        let through = self.lower(g, b, false);
                        self.collect(&mut gradients, depends, a, through);
                    }
                    if depends[b.0] {
                        let through = self.lower(g, a, true);
                        self.collect(&mut gradients, depends, b, through);
                    }
                }
                Op::Rows(x, start) => {
                    let through = self.place(g, start, self.features(x));
                    self.collect(&mut gradients, depends, x, through);
                }
                Op::Place(x, start) => {
                    let through = self.rows(g, start, self.features(x));
                    self.collect(&mut gradients, depends, x, through);
                }
            }
        }
        (gradients, sinks)
    }

    fn collect(&mut self, gradients: &mut HashMap<Node, Node>, depends: &[bool], node: Node, weight: Node) {
        if !depends[node.0] || self.as_constant(weight) == Some(0.0) {
            return;
        }
        let sum = match gradients.get(&node) {
            Some(before) => self.add(*before, weight),
            None => weight,
        };
        gradients.insert(node, sum);
    }

    /// The generalised forces of a Lagrangian L(q, q̇), one feature:
    ///
    /// ```text
    /// τ = d/dt ∂L/∂q̇ − ∂L/∂q
    /// ```
    pub fn euler_lagrange(&mut self, lagrangian: Node, q: Node, qd: Node, qdd: Node) -> Node {
        let one = self.constant(1.0, 1);
        let slopes = self.pull_back(&[(lagrangian, one)], &[q, qd]);
        let momentum_rate = self.tangent(slopes[1], &[(q, qd), (qd, qdd)]);
        self.sub(momentum_rate, slopes[0])
    }
}
