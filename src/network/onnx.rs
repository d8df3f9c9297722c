//! A graph as an ONNX model: its derivatives are nodes like others, so whatever runs sums, products and elementary functions computes
//! a Lagrangian's torque.
//!
//! The few messages of ONNX's protocol buffers that this takes are written by hand (<https://onnx.ai/onnx/intro/concepts.html>,
//! `onnx.proto3`; operator set 17). All tensors are f64 and samples × features; a triangle is spread and gathered by constant
//! matrices of zeros and ones.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::graph::{Graph, Node, Op};
use super::kernel::{Function, lower_index};
use super::layout::BlockId;

/// Values of each block by its name, inputs × outputs.
type Weights = BTreeMap<String, Vec<f64>>;

const IR_VERSION: u64 = 8;
const OPERATOR_SET: u64 = 17;
/// Element types, `TensorProto.DataType`.
const INT64: u64 = 7;
const DOUBLE: u64 = 11;

/// The model that gives `output` under a name. `inputs` are names and features of what stands, one after the other, at the beginning
/// of the graph's input 0; nothing behind them may be needed. `about` are pairs of metadata.
pub fn model(
    graph: &Graph,
    weights: &Weights,
    inputs: &[(&str, usize)],
    output: (&str, Node),
    about: &[(&str, &str)],
) -> Vec<u8> {
    let mut writer = Writer { graph, weights, nodes: Vec::new(), tensors: Vec::new(), known: HashMap::new() };
    let names: Vec<String> = inputs.iter().map(|(name, _)| (*name).to_owned()).collect();
    writer.push("Concat", &names, &name(graph.inputs()[0]), &[("axis", 1)]);
    for node in needed(graph, output.1) {
        writer.write(node);
    }
    writer.push("Identity", &[name(output.1)], output.0, &[]);

    let mut body = Message::default();
    writer.nodes.iter().for_each(|node| body.message(1, node));
    body.bytes(2, b"torque");
    writer.tensors.iter().for_each(|tensor| body.message(5, tensor));
    inputs.iter().for_each(|(name, features)| body.message(11, &value_info(name, *features)));
    body.message(12, &value_info(output.0, graph.features(output.1)));
    let mut whole = Message::default();
    whole.number(1, IR_VERSION);
    whole.bytes(2, b"Torquescope");
    whole.bytes(3, env!("CARGO_PKG_VERSION").as_bytes());
    whole.message(7, &body);
    let mut operators = Message::default();
    operators.number(2, OPERATOR_SET);
    whole.message(8, &operators);
    for (key, value) in about {
        let mut entry = Message::default();
        entry.bytes(1, key.as_bytes());
        entry.bytes(2, value.as_bytes());
        whole.message(14, &entry);
    }
    whole.0
}

/// A message of protocol buffers: fields, each behind its number.
#[derive(Debug, Clone, Default)]
struct Message(Vec<u8>);

impl Message {
    fn number(&mut self, field: u64, value: u64) {
        self.varint(field << 3);
        self.varint(value);
    }

    fn bytes(&mut self, field: u64, bytes: &[u8]) {
        self.varint(field << 3 | 2);
        self.varint(bytes.len() as u64);
        self.0.extend(bytes);
    }

    fn message(&mut self, field: u64, message: &Message) {
        self.bytes(field, &message.0);
    }

    /// Seven bits a byte, the last ones first.
    fn varint(&mut self, mut value: u64) {
        while value >= 1 << 7 {
            self.0.push((value | 1 << 7) as u8);
            value >>= 7;
        }
        self.0.push(value as u8);
    }
}

/// Name, type and shape of an input or output: any number of samples.
fn value_info(name: &str, features: usize) -> Message {
    let mut dimensions = [Message::default(), Message::default()];
    dimensions[0].bytes(2, b"samples");
    dimensions[1].number(1, features as u64);
    let mut shape = Message::default();
    dimensions.iter().for_each(|dimension| shape.message(1, dimension));
    let (mut tensor, mut kind, mut info) = (Message::default(), Message::default(), Message::default());
    tensor.number(1, DOUBLE);
    tensor.message(2, &shape);
    kind.message(1, &tensor);
    info.bytes(1, name.as_bytes());
    info.message(2, &kind);
    info
}

/// What a node needs, in the order in which it is computed; without the input.
fn needed(graph: &Graph, output: Node) -> Vec<Node> {
    let mut all = HashSet::from([output]);
    // Whoever uses a node comes after it.
    for index in (0..=output.0).rev() {
        if all.contains(&Node(index)) {
            all.extend(graph.operands(Node(index)));
        }
    }
    let mut sorted: Vec<Node> = all.into_iter().filter(|node| !matches!(graph.op(*node), Op::Input(_))).collect();
    sorted.sort();
    sorted
}

fn name(node: Node) -> String {
    format!("v{}", node.0)
}

struct Writer<'a> {
    graph: &'a Graph,
    weights: &'a Weights,
    nodes: Vec<Message>,
    tensors: Vec<Message>,
    /// The names of tensors.
    known: HashMap<Key, String>,
}

/// By which a tensor is found that was written before: its given name, or its type, shape and content.
type Key = (Option<String>, u64, Vec<usize>, Vec<u8>);

impl Writer<'_> {
    fn write(&mut self, node: Node) {
        let (to, features) = (name(node), self.graph.features(node));
        match self.graph.op(node) {
            // The inputs are put together before.
            Op::Input(_) => {}
            Op::Constant(number) => {
                let values = self.constant(&[1, features], vec![number.value(); features]);
                self.push("Identity", &[values], &to, &[]);
            }
            Op::Parameter(block) => {
                let values = self.block(block);
                self.push("Identity", &[values], &to, &[]);
            }
            Op::Product { matrix, back, bias, x } => {
                // The matrix is written inputs × outputs, however it is stored.
                let is_turned = self.graph.layout.block(matrix).turned == back;
                let mut from = vec![name(x), self.block(matrix)];
                from.extend(bias.map(|bias| self.block(bias)));
                self.push("Gemm", &from, &to, &[("transB", u64::from(is_turned))]);
            }
            Op::Add(a, b) => self.push("Add", &[name(a), name(b)], &to, &[]),
            Op::Mul(a, b) => self.push("Mul", &[name(a), name(b)], &to, &[]),
            Op::Scale(factor, x) => {
                let factor = self.constant(&[], vec![factor.value()]);
                self.push("Mul", &[name(x), factor], &to, &[]);
            }
            Op::Shift(offset, x) => {
                let offset = self.constant(&[], vec![offset.value()]);
                self.push("Add", &[name(x), offset], &to, &[]);
            }
            Op::Apply(Function::Softplus, x) => self.softplus(name(x), &to),
            Op::Apply(function, x) => self.push(operator(function), &[name(x)], &to, &[]),
            Op::SumFeatures(x) => {
                let axes = self.places(&[1]);
                self.push("ReduceSum", &[name(x), axes], &to, &[]);
            }
            Op::Spread(x) => {
                let ones = self.constant(&[1, features], vec![1.0; features]);
                self.push("MatMul", &[name(x), ones], &to, &[]);
            }
            Op::Lower { packed, v, transposed } => {
                let spread = self.spreading(features, |i, j| if transposed { i } else { j });
                let gather = self.gathering(features, |i, j| if transposed { j } else { i });
                let [spread_v, products] = ["spread", "products"].map(|part| format!("{to}_{part}"));
                self.push("MatMul", &[name(v), spread], &spread_v, &[]);
                self.push("Mul", &[name(packed), spread_v], &products, &[]);
                self.push("MatMul", &[products, gather], &to, &[]);
            }
            Op::LowerOuter(a, b) => {
                let n = self.graph.features(a);
                let rows = self.spreading(n, |i, _| i);
                let columns = self.spreading(n, |_, j| j);
                let [a_spread, b_spread] = ["rows", "columns"].map(|part| format!("{to}_{part}"));
                self.push("MatMul", &[name(a), rows], &a_spread, &[]);
                self.push("MatMul", &[name(b), columns], &b_spread, &[]);
                self.push("Mul", &[a_spread, b_spread], &to, &[]);
            }
            Op::Rows(x, start) => {
                let [start, end, axes] = [start, start + features, 1].map(|place| self.places(&[place]));
                self.push("Slice", &[name(x), start, end, axes], &to, &[]);
            }
            Op::Place(x, start) => {
                let behind = features - start - self.graph.features(x);
                let pads = self.places(&[0, start, 0, behind]);
                self.push("Pad", &[name(x), pads], &to, &[]);
            }
        }
    }

    /// max(x, 0) + ln(1 + e^−|x|): ONNX has a softplus, but widespread runtimes have it for f32 only.
    fn softplus(&mut self, x: String, to: &str) {
        let one = self.constant(&[], vec![1.0]);
        let mut before = x.clone();
        for operator in ["Abs", "Neg", "Exp"] {
            let part = format!("{to}_{operator}");
            self.push(operator, &[before], &part, &[]);
            before = part;
        }
        let [more, logarithm, positive] = ["more", "logarithm", "positive"].map(|part| format!("{to}_{part}"));
        self.push("Add", &[before, one], &more, &[]);
        self.push("Log", &[more], &logarithm, &[]);
        self.push("Relu", &[x], &positive, &[]);
        self.push("Add", &[positive, logarithm], to, &[]);
    }

    /// A node with whole numbers as attributes.
    fn push(&mut self, operator: &str, from: &[String], to: &str, attributes: &[(&str, u64)]) {
        const INT: u64 = 2;
        let mut node = Message::default();
        from.iter().for_each(|from| node.bytes(1, from.as_bytes()));
        node.bytes(2, to.as_bytes());
        node.bytes(4, operator.as_bytes());
        for (name, value) in attributes {
            let mut attribute = Message::default();
            attribute.bytes(1, name.as_bytes());
            attribute.number(3, *value);
            attribute.number(20, INT);
            node.message(5, &attribute);
        }
        self.nodes.push(node);
    }

    /// The weights of a block, which keep their name.
    fn block(&mut self, id: BlockId) -> String {
        let block = self.graph.layout.block(id);
        let (inputs, outputs) = block.shape();
        let values = self.weights.get(&block.name).into_iter().flatten().flat_map(|value| value.to_le_bytes());
        self.tensor(Some(&block.name), DOUBLE, &[inputs, outputs], values.collect())
    }

    fn constant(&mut self, shape: &[usize], values: Vec<f64>) -> String {
        self.tensor(None, DOUBLE, shape, values.into_iter().flat_map(f64::to_le_bytes).collect())
    }

    fn places(&mut self, places: &[usize]) -> String {
        let bytes = places.iter().flat_map(|place| (*place as i64).to_le_bytes());
        self.tensor(None, INT64, &[places.len()], bytes.collect())
    }

    /// Order n × triangle: takes to entry (i, j) of a packed triangle the element of a vector that `from` says.
    fn spreading(&mut self, n: usize, from: impl Fn(usize, usize) -> usize) -> String {
        let size = n * (n + 1) / 2;
        let mut values = vec![0.0; n * size];
        entries(n).for_each(|(i, j)| values[from(i, j) * size + lower_index(n, i, j)] = 1.0);
        self.constant(&[n, size], values)
    }

    /// Triangle × order n: adds entry (i, j) to the element of a vector that `to` says.
    fn gathering(&mut self, n: usize, to: impl Fn(usize, usize) -> usize) -> String {
        let size = n * (n + 1) / 2;
        let mut values = vec![0.0; n * size];
        entries(n).for_each(|(i, j)| values[lower_index(n, i, j) * n + to(i, j)] = 1.0);
        self.constant(&[size, n], values)
    }

    /// A tensor, once; without a name it gets one by its number.
    fn tensor(&mut self, given: Option<&str>, kind: u64, shape: &[usize], bytes: Vec<u8>) -> String {
        let number = self.tensors.len();
        let name = given.map_or_else(|| format!("constant_{number}"), str::to_owned);
        // Constants that are equal are one; weights that happen to be equal keep names of their own.
        let content = if given.is_some() { Vec::new() } else { bytes.clone() };
        let key = (given.map(str::to_owned), kind, shape.to_vec(), content);
        if let Some(known) = self.known.get(&key) {
            return known.clone();
        }
        let mut tensor = Message::default();
        shape.iter().for_each(|size| tensor.number(1, *size as u64));
        tensor.number(2, kind);
        tensor.bytes(8, name.as_bytes());
        tensor.bytes(9, &bytes);
        self.tensors.push(tensor);
        self.known.insert(key, name.clone());
        name
    }
}

/// Rows and columns of a lower triangle.
fn entries(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(|i| (0..=i).map(move |j| (i, j)))
}

/// The operator of a function.
fn operator(function: Function) -> &'static str {
    match function {
        Function::Tanh => "Tanh",
        Function::Sigmoid => "Sigmoid",
        Function::Softplus => "Softplus",
        Function::Exp => "Exp",
        Function::Sin => "Sin",
        Function::Cos => "Cos",
        Function::Sign => "Sign",
    }
}
