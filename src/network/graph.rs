//! Expressions over tiles: what a network computes, before anything is computed.
//!
//! A [`Graph`] is a list of nodes, each made of earlier ones. Building simplifies (constants are folded, factors of one vanish)
//! and shares: the same expression is the same node. [`super::differentiate`] adds the nodes of derivatives, so any order of
//! derivative is again a graph; [`super::program`] makes it run.

use std::collections::HashMap;

use super::kernel::{Function, lower_index};
use super::layout::{BlockId, Layout};

/// A node of a graph.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Node(pub(super) usize);

/// A number that can be compared and hashed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Number(u64);

impl Number {
    pub(super) fn new(value: f64) -> Self {
        Number(value.to_bits())
    }
    pub(super) fn value(self) -> f64 {
        f64::from_bits(self.0)
    }
}

/// What a node computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Op {
    /// The input of this number.
    Input(usize),
    /// The same number everywhere.
    Constant(Number),
    /// A vector of parameters, the same for all samples.
    Parameter(BlockId),
    /// W x + bias, where W is the matrix or, if `back`, its transpose.
    Product {
        matrix: BlockId,
        back: bool,
        bias: Option<BlockId>,
        x: Node,
    },
    Add(Node, Node),
    Mul(Node, Node),
    Scale(Number, Node),
    Shift(Number, Node),
    Apply(Function, Node),
    /// Σ over features: one feature remains.
    SumFeatures(Node),
    /// One feature repeated.
    Spread(Node),
    /// L v or Lᵀ v, L a packed lower triangle.
    Lower {
        packed: Node,
        v: Node,
        transposed: bool,
    },
    /// The packed lower triangle of a bᵀ.
    LowerOuter(Node, Node),
    /// Features from `start` on.
    Rows(Node, usize),
    /// Zeros, except for x from `start` on.
    Place(Node, usize),
}

/// An expression over tiles, with the layout of its parameters.
#[derive(Debug, Clone, Default)]
pub struct Graph {
    pub(super) ops: Vec<Op>,
    features: Vec<usize>,
    known: HashMap<(Op, usize), Node>,
    inputs: Vec<Node>,
    /// The parameters that the nodes use.
    pub layout: Layout,
}

impl Graph {
    /// A graph without nodes.
    pub fn new() -> Self {
        Self::default()
    }

    /// How many features a node has.
    pub fn features(&self, node: Node) -> usize {
        self.features[node.0]
    }

    /// The inputs, in the order in which they were made.
    pub fn inputs(&self) -> &[Node] {
        &self.inputs
    }

    pub(super) fn op(&self, node: Node) -> Op {
        self.ops[node.0]
    }

    /// The node of an operation, which is made if it is new.
    pub(super) fn node(&mut self, op: Op, features: usize) -> Node {
        if let Some(node) = self.known.get(&(op, features)) {
            return *node;
        }
        let node = Node(self.ops.len());
        self.ops.push(op);
        self.features.push(features);
        self.known.insert((op, features), node);
        node
    }

    pub(super) fn as_constant(&self, node: Node) -> Option<f64> {
        match self.op(node) {
            Op::Constant(number) => Some(number.value()),
            _ => None,
        }
    }

    /// A new input with this many features.
    pub fn input(&mut self, features: usize) -> Node {
        let node = self.node(Op::Input(self.inputs.len()), features);
        self.inputs.push(node);
        node
    }

    /// The same number in all features of all samples.
    pub fn constant(&mut self, value: f64, features: usize) -> Node {
        self.node(Op::Constant(Number::new(value)), features)
    }

    /// A vector of parameters, the same for all samples.
    pub fn parameter(&mut self, block: BlockId) -> Node {
        let length = self.layout.block(block).columns;
        self.node(Op::Parameter(block), length)
    }

    /// x W + b, with W from the features of x to those of the result.
    ///
    /// # Panics
    /// If W does not fit x.
    pub fn linear(&mut self, matrix: BlockId, bias: Option<BlockId>, x: Node) -> Node {
        let block = self.layout.block(matrix);
        assert_eq!(block.shape().0, self.features(x), "`{}` does not fit its input", block.name);
        let back = !block.turned;
        self.product(matrix, back, bias, x)
    }

    pub(super) fn product(&mut self, matrix: BlockId, back: bool, bias: Option<BlockId>, x: Node) -> Node {
        let block = self.layout.block(matrix);
        let features = if back { block.columns } else { block.rows };
        if bias.is_none() && self.as_constant(x) == Some(0.0) {
            return self.constant(0.0, features);
        }
        self.node(Op::Product { matrix, back, bias, x }, features)
    }

    /// a + b
    pub fn add(&mut self, a: Node, b: Node) -> Node {
        assert_eq!(self.features(a), self.features(b), "sums need equal features");
        match (self.as_constant(a), self.as_constant(b)) {
            (Some(a), _) => return self.shift(a, b),
            (_, Some(b)) => return self.shift(b, a),
            _ => {}
        }
        if a == b {
            return self.scale(2.0, a);
        }
        // Equal terms with different factors are one term.
        let (term_a, term_b) = (self.term(a), self.term(b));
        if term_a.1 == term_b.1 {
            return self.scale(term_a.0 + term_b.0, term_a.1);
        }
        self.node(Op::Add(a.min(b), a.max(b)), self.features(a))
    }

    fn term(&self, node: Node) -> (f64, Node) {
        match self.op(node) {
            Op::Scale(factor, x) => (factor.value(), x),
            _ => (1.0, node),
        }
    }

    /// a − b
    pub fn sub(&mut self, a: Node, b: Node) -> Node {
        let minus_b = self.scale(-1.0, b);
        self.add(a, minus_b)
    }

    /// a · b, element by element
    pub fn mul(&mut self, a: Node, b: Node) -> Node {
        assert_eq!(self.features(a), self.features(b), "products need equal features");
        if let Some(factor) = self.as_constant(a) {
            return self.scale(factor, b);
        }
        if let Some(factor) = self.as_constant(b) {
            return self.scale(factor, a);
        }
        let ((factor_a, a), (factor_b, b)) = (self.term(a), self.term(b));
        let product = self.node(Op::Mul(a.min(b), a.max(b)), self.features(a));
        self.scale(factor_a * factor_b, product)
    }

    /// factor · x
    pub fn scale(&mut self, factor: f64, x: Node) -> Node {
        let features = self.features(x);
        if factor == 1.0 {
            return x;
        }
        match self.op(x) {
            _ if factor == 0.0 => self.constant(0.0, features),
            Op::Constant(number) => self.constant(factor * number.value(), features),
            Op::Scale(inner, x) => self.scale(factor * inner.value(), x),
            _ => self.node(Op::Scale(Number::new(factor), x), features),
        }
    }

    /// x + offset
    pub fn shift(&mut self, offset: f64, x: Node) -> Node {
        let features = self.features(x);
        if offset == 0.0 {
            return x;
        }
        match self.op(x) {
            Op::Constant(number) => self.constant(offset + number.value(), features),
            Op::Shift(inner, x) => self.shift(offset + inner.value(), x),
            _ => self.node(Op::Shift(Number::new(offset), x), features),
        }
    }

    /// f(x), element by element
    pub fn apply(&mut self, function: Function, x: Node) -> Node {
        self.node(Op::Apply(function, x), self.features(x))
    }

    /// Σ over the features of x
    pub fn sum_features(&mut self, x: Node) -> Node {
        if let Some(value) = self.as_constant(x) {
            return self.constant(value * self.features(x) as f64, 1);
        }
        if self.features(x) == 1 {
            return x;
        }
        self.node(Op::SumFeatures(x), 1)
    }

    /// The single feature of x, repeated.
    pub fn spread(&mut self, x: Node, features: usize) -> Node {
        if let Some(value) = self.as_constant(x) {
            return self.constant(value, features);
        }
        if features == 1 {
            return x;
        }
        self.node(Op::Spread(x), features)
    }

    /// L v or, if `transposed`, Lᵀ v, for a lower triangle packed as [`lower_index`] says.
    pub fn lower(&mut self, packed: Node, v: Node, transposed: bool) -> Node {
        let n = self.features(v);
        assert_eq!(self.features(packed), n * (n + 1) / 2, "a triangle of order {n}");
        if self.as_constant(packed) == Some(0.0) || self.as_constant(v) == Some(0.0) {
            return self.constant(0.0, n);
        }
        self.node(Op::Lower { packed, v, transposed }, n)
    }

    /// The lower triangle of a bᵀ, packed as [`lower_index`] says.
    pub fn lower_outer(&mut self, a: Node, b: Node) -> Node {
        let n = self.features(a);
        debug_assert_eq!(lower_index(n, 0, 0), 0);
        if self.as_constant(a) == Some(0.0) || self.as_constant(b) == Some(0.0) {
            return self.constant(0.0, n * (n + 1) / 2);
        }
        self.node(Op::LowerOuter(a, b), n * (n + 1) / 2)
    }

    /// The features `start .. start + features` of x.
    pub fn rows(&mut self, x: Node, start: usize, features: usize) -> Node {
        assert!(start + features <= self.features(x), "these features exist");
        if features == self.features(x) {
            return x;
        }
        if let Some(value) = self.as_constant(x) {
            return self.constant(value, features);
        }
        self.node(Op::Rows(x, start), features)
    }

    /// x at `start` within `features` features, zero elsewhere.
    pub fn place(&mut self, x: Node, start: usize, features: usize) -> Node {
        assert!(start + self.features(x) <= features, "x fits");
        if features == self.features(x) {
            return x;
        }
        if self.as_constant(x) == Some(0.0) {
            return self.constant(0.0, features);
        }
        self.node(Op::Place(x, start), features)
    }

    /// The features of all parts, one after the other.
    pub fn stack(&mut self, parts: &[Node]) -> Node {
        let features = parts.iter().map(|part| self.features(*part)).sum();
        let mut start = 0;
        let mut stack = self.constant(0.0, features);
        for part in parts {
            let placed = self.place(*part, start, features);
            stack = self.add(stack, placed);
            start += self.features(*part);
        }
        stack
    }

    /// The nodes that an operation reads.
    pub(super) fn operands(&self, node: Node) -> impl Iterator<Item = Node> {
        let (first, second) = match self.op(node) {
            Op::Input(_) | Op::Constant(_) | Op::Parameter(_) => (None, None),
            Op::Product { x, .. }
            | Op::Scale(_, x)
            | Op::Shift(_, x)
            | Op::Apply(_, x)
            | Op::SumFeatures(x)
            | Op::Spread(x)
            | Op::Rows(x, _)
            | Op::Place(x, _) => (Some(x), None),
            Op::Add(a, b) | Op::Mul(a, b) | Op::LowerOuter(a, b) => (Some(a), Some(b)),
            Op::Lower { packed, v, .. } => (Some(packed), Some(v)),
        };
        first.into_iter().chain(second)
    }
}
