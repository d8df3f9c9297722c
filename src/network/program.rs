//! A graph made ready to run: a list of instructions over one tile, with a place in memory for each value.
//!
//! Compiling drops what no result needs, folds chains of sums and products into single passes over memory, and lets values that
//! are never alive together share their memory, so that a tile of all intermediate values stays in a core's cache.

use std::collections::HashMap;

use super::buffer::Buffer;
use super::graph::{Graph, Node, Op};
use super::kernel::{Element, Factors, Function, Kernels, PAD, Start, TILE};
use super::layout::{BlockId, Layout};

use super::differentiate::Sink;

/// Most terms that one pass adds up.
const MOST_TERMS: usize = 3;

/// Index of a value, of its place in memory after places are given.
type Place = usize;

/// Some features of a value.
#[derive(Debug, Clone, Copy)]
struct View {
    place: Place,
    first: usize,
    features: usize,
}

impl View {
    fn of<'a, E>(&self, places: &'a [Buffer<E>]) -> &'a [E] {
        &places[self.place][self.first * TILE..(self.first + self.features) * TILE]
    }
}

/// constant + Σ factor · a + Σ factor · a · b
#[derive(Debug, Clone, Default)]
struct Combination {
    constant: f64,
    singles: Vec<(f64, Node)>,
    pairs: Vec<(f64, Node, Node)>,
}

impl Combination {
    fn single(node: Node) -> Self {
        Combination { singles: vec![(1.0, node)], ..Self::default() }
    }
    fn terms(&self) -> usize {
        self.singles.len() + self.pairs.len()
    }
    fn scaled(mut self, factor: f64) -> Self {
        self.constant *= factor;
        self.singles.iter_mut().for_each(|term| term.0 *= factor);
        self.pairs.iter_mut().for_each(|term| term.0 *= factor);
        self
    }
    fn plus(mut self, mut other: Self) -> Self {
        self.constant += other.constant;
        self.singles.append(&mut other.singles);
        self.pairs.append(&mut other.pairs);
        self
    }
}

#[derive(Debug, Clone)]
enum Action<E> {
    Fill {
        value: E,
    },
    Parameter {
        vector: BlockId,
    },
    Product {
        matrix: BlockId,
        back: bool,
        bias: Option<BlockId>,
        x: View,
    },
    Combine {
        constant: E,
        singles: Vec<(E, View)>,
        pairs: Vec<(E, View, View)>,
    },
    Apply {
        function: Function,
        x: View,
    },
    SumFeatures {
        x: View,
    },
    Spread {
        x: View,
    },
    Lower {
        packed: View,
        v: View,
        transposed: bool,
    },
    LowerOuter {
        a: View,
        b: View,
    },
    /// Parts, each from a feature on; zero elsewhere if they leave gaps.
    Stack {
        parts: Vec<(usize, View)>,
        has_gaps: bool,
    },
    Transpose {
        x: View,
        features: usize,
    },
    AddOuter {
        matrix: BlockId,
        left: View,
        right_transposed: View,
    },
    AddColumnSums {
        vector: BlockId,
        x_transposed: View,
    },
    AddRowSums {
        vector: BlockId,
        x: View,
    },
}

#[derive(Debug, Clone)]
struct Instruction<E> {
    action: Action<E>,
    /// The place of the result; none for additions to the gradient.
    to: Option<Place>,
    /// Features of the result; of a transposed tile, its padded width.
    features: usize,
}

impl<E> Action<E> {
    fn each_operand(&mut self, mut visit: impl FnMut(&mut View)) {
        match self {
            Action::Fill { .. } | Action::Parameter { .. } => {}
            Action::Product { x, .. }
            | Action::Apply { x, .. }
            | Action::SumFeatures { x }
            | Action::Spread { x }
            | Action::Transpose { x, .. }
            | Action::AddRowSums { x, .. }
            | Action::AddColumnSums { x_transposed: x, .. } => visit(x),
            Action::Lower { packed: a, v: b, .. }
            | Action::LowerOuter { a, b }
            | Action::AddOuter { left: a, right_transposed: b, .. } => {
                visit(a);
                visit(b);
            }
            Action::Stack { parts, .. } => parts.iter_mut().for_each(|(_, part)| visit(part)),
            Action::Combine { singles, pairs, .. } => {
                singles.iter_mut().for_each(|(_, a)| visit(a));
                for (_, a, b) in pairs {
                    visit(a);
                    visit(b);
                }
            }
        }
    }
}

/// A graph ready to run.
#[derive(Debug, Clone)]
pub struct Program<E: Element> {
    instructions: Vec<Instruction<E>>,
    layout: Layout,
    inputs: Vec<Place>,
    outputs: Vec<View>,
    /// Features of each place, rows of a transposed tile included.
    sizes: Vec<usize>,
}

/// The memory in which a program runs one tile; one for each thread.
#[derive(Debug)]
pub struct Arena<E> {
    places: Vec<Buffer<E>>,
}

impl<E: Element> Program<E> {
    /// Compiles what `outputs` need and, where `losses` are given, the gradient of their sum by all parameters.
    ///
    /// A loss is a node whose values, summed over features and samples, are to be minimised.
    pub fn compile(mut graph: Graph, outputs: &[Node], losses: &[Node]) -> Self {
        let sinks = if losses.is_empty() { Vec::new() } else { graph.parameter_gradient(losses) };
        let plan = Plan::new(&graph, outputs, &sinks);
        let (mut instructions, values) = plan.instructions::<E>(&graph, &sinks);
        let input_sizes: Vec<usize> = graph.inputs().iter().map(|input| graph.features(*input)).collect();
        let mut outputs: Vec<View> = outputs.iter().map(|node| values[node]).collect();
        let (places, sizes) = share_memory(&mut instructions, &input_sizes, &outputs);
        outputs.iter_mut().for_each(|view| view.place = places[&view.place]);
        Program {
            instructions,
            inputs: (0..input_sizes.len()).map(|value| places[&value]).collect(),
            outputs,
            layout: graph.layout,
            sizes,
        }
    }

    /// The layout of the parameters.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Memory for one thread.
    pub fn arena(&self) -> Arena<E> {
        Arena { places: self.sizes.iter().map(|features| Buffer::zeros(features * TILE)).collect() }
    }

    /// How many bytes an arena takes.
    pub fn arena_bytes(&self) -> usize {
        self.sizes.iter().sum::<usize>() * TILE * size_of::<E>()
    }

    /// The tile of an input, to be filled before a run: element `[feature · TILE + sample]`.
    pub fn input<'a>(&self, arena: &'a mut Arena<E>, input: usize) -> &'a mut [E] {
        &mut arena.places[self.inputs[input]]
    }

    /// The tile of an output after a run.
    pub fn output<'a>(&self, arena: &'a Arena<E>, output: usize) -> &'a [E] {
        self.outputs[output].of(&arena.places)
    }

    /// Floating-point operations of the matrix products in one tile (a multiplication and an addition count as two).
    pub fn product_operations(&self) -> usize {
        let matrix = |instruction: &Instruction<E>| match instruction.action {
            Action::Product { matrix, .. } | Action::AddOuter { matrix, .. } => Some(matrix),
            _ => None,
        };
        let blocks = self.instructions.iter().filter_map(matrix).map(|id| self.layout.block(id));
        blocks.map(|block| 2 * block.rows * block.columns * TILE).sum()
    }

    /// How many instructions there are.
    pub fn instruction_count(&self) -> usize {
        self.instructions.len()
    }

    /// Runs one tile; the gradient of its losses is added to `gradient`, which has the size of the weights (or 0 without losses).
    ///
    /// # Panics
    /// If weights or gradient do not have the size of the layout.
    pub fn run(&self, kernels: &Kernels<E>, weights: &[E], arena: &mut Arena<E>, gradient: &mut [E]) {
        assert_eq!(weights.len(), self.layout.size(), "weights fit the layout");
        for instruction in &self.instructions {
            self.execute(instruction, kernels, weights, arena, gradient);
        }
    }

    #[inline]
    fn execute(
        &self,
        instruction: &Instruction<E>,
        kernels: &Kernels<E>,
        weights: &[E],
        arena: &mut Arena<E>,
        gradient: &mut [E],
    ) {
        // The result is taken out of the arena while the rest is read. Where it takes the place of an operand, the kernel is
        // told so.
        let mut taken = instruction.to.map(|place| std::mem::take(&mut arena.places[place]));
        let nothing: &mut [E] = &mut [];
        let y: &mut [E] = match &mut taken {
            Some(buffer) => buffer,
            None => nothing,
        };
        let places = &arena.places;
        let vector = |id: BlockId| {
            let block = self.layout.block(id);
            &weights[block.offset..block.offset + block.columns]
        };
        match &instruction.action {
            Action::Fill { value } => y.fill(*value),
            Action::Parameter { vector: id } => (kernels.fill)(vector(*id), y),
            Action::Product { matrix, back, bias, x } => {
                let block = self.layout.block(*matrix);
                let (rows, depth) = if *back { (block.columns, block.rows) } else { (block.rows, block.columns) };
                let (a_row, a_depth) = if *back { (1, block.stride()) } else { (block.stride(), 1) };
                let start = bias.map_or(Start::Zero, |id| Start::Column(vector(id)));
                let (a, b) = (&weights[block.range()], x.of(places));
                let factors = Factors { rows, columns: TILE, depth, a, a_row, a_depth, b, b_row: TILE, start };
                (kernels.product)(&factors, y, TILE);
            }
            Action::Combine { constant, singles, pairs } => {
                let operand = |view: &View| (Some(view.place) != instruction.to).then(|| view.of(places));
                let mut ones = [(E::ZERO, None); MOST_TERMS];
                let mut twos = [(E::ZERO, None, None); MOST_TERMS];
                for (one, (factor, a)) in ones.iter_mut().zip(singles) {
                    *one = (*factor, operand(a));
                }
                for (two, (factor, a, b)) in twos.iter_mut().zip(pairs) {
                    *two = (*factor, operand(a), operand(b));
                }
                (kernels.combine)(*constant, &ones[..singles.len()], &twos[..pairs.len()], y);
            }
            Action::Apply { function, x } => {
                let operand = (Some(x.place) != instruction.to).then(|| x.of(places));
                (kernels.apply)(*function, operand, y);
            }
            Action::SumFeatures { x } => (kernels.sum_features)(x.of(places), y),
            Action::Spread { x } => y.chunks_exact_mut(TILE).for_each(|row| (kernels.copy)(x.of(places), row)),
            Action::Lower { packed, v, transposed } => {
                (kernels.lower_product)(packed.of(places), v.of(places), *transposed, y);
            }
            Action::LowerOuter { a, b } => (kernels.lower_outer)(a.of(places), b.of(places), y),
            Action::Stack { parts, has_gaps } => {
                if *has_gaps {
                    y.fill(E::ZERO);
                }
                for (start, part) in parts {
                    (kernels.copy)(part.of(places), &mut y[start * TILE..][..part.features * TILE]);
                }
            }
            Action::Transpose { x, features } => (kernels.transpose)(x.of(places), *features, y),
            Action::AddOuter { matrix, left, right_transposed } => {
                let block = self.layout.block(*matrix);
                let factors = Factors {
                    rows: block.rows,
                    columns: block.stride(),
                    depth: TILE,
                    a: left.of(places),
                    a_row: TILE,
                    a_depth: 1,
                    b: right_transposed.of(places),
                    b_row: block.stride(),
                    start: Start::Result,
                };
                (kernels.product)(&factors, &mut gradient[block.range()], block.stride());
            }
            Action::AddColumnSums { vector, x_transposed } => {
                (kernels.add_column_sums)(x_transposed.of(places), &mut gradient[self.layout.block(*vector).range()]);
            }
            Action::AddRowSums { vector, x } => {
                let block = self.layout.block(*vector);
                (kernels.add_row_sums)(x.of(places), &mut gradient[block.offset..block.offset + block.columns]);
            }
        }
        if let (Some(place), Some(buffer)) = (instruction.to, taken) {
            arena.places[place] = buffer;
        }
    }
}

/// Which nodes get a value of their own, and how combinations are folded.
struct Plan {
    is_needed: Vec<bool>,
    combinations: HashMap<Node, Combination>,
    /// Sums of parts that do not overlap: (first feature, part).
    stacks: HashMap<Node, Vec<(usize, Node)>>,
}

impl Plan {
    fn new(graph: &Graph, outputs: &[Node], sinks: &[Sink]) -> Self {
        let roots: Vec<Node> = outputs.iter().copied().chain(sinks.iter().flat_map(operands)).collect();
        let uses = count_uses(graph, &roots);
        let mut plan =
            Plan { is_needed: vec![false; graph.ops.len()], combinations: HashMap::new(), stacks: HashMap::new() };
        for root in &roots {
            plan.is_needed[root.0] = true;
        }
        for node in (0..graph.ops.len()).rev().map(Node).filter(|node| uses[node.0] > 0) {
            if !plan.is_needed[node.0] {
                continue;
            }
            let mut parts = Vec::new();
            if plan.collect_parts(graph, &uses, node, true, &mut parts) {
                parts.iter().for_each(|(_, part)| plan.is_needed[part.0] = true);
                plan.stacks.insert(node, parts);
            } else if matches!(graph.op(node), Op::Add(..) | Op::Mul(..) | Op::Scale(..) | Op::Shift(..)) {
                let combination = plan.combination(graph, &uses, node);
                for (_, a) in &combination.singles {
                    plan.is_needed[a.0] = true;
                }
                for (_, a, b) in &combination.pairs {
                    plan.is_needed[a.0] = true;
                    plan.is_needed[b.0] = true;
                }
                plan.combinations.insert(node, combination);
            } else {
                graph.operands(node).for_each(|operand| plan.is_needed[operand.0] = true);
            }
        }
        plan
    }

    /// The parts of which a node is stacked; `false` if it is anything else.
    fn collect_parts(
        &self,
        graph: &Graph,
        uses: &[usize],
        node: Node,
        is_root: bool,
        parts: &mut Vec<(usize, Node)>,
    ) -> bool {
        match graph.op(node) {
            Op::Place(x, start) => {
                let is_apart = |(first, part): &(usize, Node)| {
                    start >= first + graph.features(*part) || *first >= start + graph.features(x)
                };
                let fits = parts.iter().all(is_apart);
                parts.push((start, x));
                fits
            }
            Op::Add(a, b) if is_root || (uses[node.0] == 1 && !self.is_needed[node.0]) => {
                self.collect_parts(graph, uses, a, false, parts) && self.collect_parts(graph, uses, b, false, parts)
            }
            _ => false,
        }
    }

    fn combination(&self, graph: &Graph, uses: &[usize], node: Node) -> Combination {
        match graph.op(node) {
            Op::Mul(a, b) => Combination { pairs: vec![(1.0, a, b)], ..Combination::default() },
            Op::Scale(factor, x) => self.folded(graph, uses, x).scaled(factor.value()),
            Op::Shift(offset, x) => {
                let mut combination = self.folded(graph, uses, x);
                combination.constant += offset.value();
                combination
            }
            Op::Add(a, b) => {
                let (left, right) = (self.folded(graph, uses, a), self.folded(graph, uses, b));
                if left.terms() + right.terms() <= MOST_TERMS {
                    left.plus(right)
                } else if left.terms() < MOST_TERMS {
                    left.plus(Combination::single(b))
                } else if right.terms() < MOST_TERMS {
                    Combination::single(a).plus(right)
                } else {
                    Combination::single(a).plus(Combination::single(b))
                }
            }
            _ => Combination::single(node),
        }
    }

    /// The combination that stands for x inside another one: x itself where others need its value too.
    fn folded(&self, graph: &Graph, uses: &[usize], x: Node) -> Combination {
        let is_own = self.is_needed[x.0];
        match graph.op(x) {
            Op::Scale(factor, inner) if !is_own => self.folded(graph, uses, inner).scaled(factor.value()),
            Op::Add(..) | Op::Mul(..) | Op::Shift(..) if !is_own && uses[x.0] == 1 => self.combination(graph, uses, x),
            _ => Combination::single(x),
        }
    }

    /// Instructions in order of the nodes, each sink as soon as it can be; results are numbered by value.
    fn instructions<E: Element>(self, graph: &Graph, sinks: &[Sink]) -> (Vec<Instruction<E>>, HashMap<Node, View>) {
        let mut list = Vec::new();
        let whole = |place: Place, node: Node| View { place, first: 0, features: graph.features(node) };
        let inputs = graph.inputs().iter().enumerate();
        let mut values: HashMap<Node, View> = inputs.map(|(i, node)| (*node, whole(i, *node))).collect();
        let mut transposed: HashMap<Node, View> = HashMap::new();
        let mut count = values.len();
        let mut new_value = || {
            count += 1;
            count - 1
        };
        for node in (0..graph.ops.len()).map(Node) {
            if let Op::Rows(x, start) = graph.op(node)
                && self.is_needed[node.0]
            {
                // No work: these features are read where they stand.
                let View { place, first, .. } = values[&x];
                values.insert(node, View { place, first: first + start, features: graph.features(node) });
            } else if self.is_needed[node.0] && !matches!(graph.op(node), Op::Input(_)) {
                let action = self.action(graph, node, &values);
                let to = new_value();
                list.push(Instruction { action, to: Some(to), features: graph.features(node) });
                values.insert(node, whole(to, node));
            }
            for sink in sinks.iter().filter(|sink| operands(sink).max() == Some(node)) {
                let mut turn = |x: Node, list: &mut Vec<Instruction<E>>| {
                    *transposed.entry(x).or_insert_with(|| {
                        let to = new_value();
                        let features = graph.features(x);
                        let action = Action::Transpose { x: values[&x], features };
                        let features = features.next_multiple_of(PAD);
                        list.push(Instruction { action, to: Some(to), features });
                        View { place: to, first: 0, features }
                    })
                };
                let action = match *sink {
                    Sink::Outer { matrix, left, right } => {
                        let right_transposed = turn(right, &mut list);
                        Action::AddOuter { matrix, left: values[&left], right_transposed }
                    }
                    Sink::Sum { vector, x } if graph.features(x) < PAD => Action::AddRowSums { vector, x: values[&x] },
                    Sink::Sum { vector, x } => {
                        let x_transposed = turn(x, &mut list);
                        Action::AddColumnSums { vector, x_transposed }
                    }
                };
                list.push(Instruction { action, to: None, features: 0 });
            }
        }
        (list, values)
    }

    fn action<E: Element>(&self, graph: &Graph, node: Node, values: &HashMap<Node, View>) -> Action<E> {
        if let Some(parts) = self.stacks.get(&node) {
            let covered: usize = parts.iter().map(|(_, part)| graph.features(*part)).sum();
            let has_gaps = covered < graph.features(node);
            return Action::Stack {
                parts: parts.iter().map(|(start, part)| (*start, values[part])).collect(),
                has_gaps,
            };
        }
        if let Some(combination) = self.combinations.get(&node) {
            let number = E::from_f64;
            return Action::Combine {
                constant: number(combination.constant),
                singles: combination.singles.iter().map(|(f, a)| (number(*f), values[a])).collect(),
                pairs: combination.pairs.iter().map(|(f, a, b)| (number(*f), values[a], values[b])).collect(),
            };
        }
        match graph.op(node) {
            Op::Constant(number) => Action::Fill { value: E::from_f64(number.value()) },
            Op::Parameter(vector) => Action::Parameter { vector },
            Op::Product { matrix, back, bias, x } => Action::Product { matrix, back, bias, x: values[&x] },
            Op::Apply(function, x) => Action::Apply { function, x: values[&x] },
            Op::SumFeatures(x) => Action::SumFeatures { x: values[&x] },
            Op::Spread(x) => Action::Spread { x: values[&x] },
            Op::Lower { packed, v, transposed } => Action::Lower { packed: values[&packed], v: values[&v], transposed },
            Op::LowerOuter(a, b) => Action::LowerOuter { a: values[&a], b: values[&b] },
            Op::Input(_) | Op::Rows(..) | Op::Place(..) | Op::Add(..) | Op::Mul(..) | Op::Scale(..) | Op::Shift(..) => {
                unreachable!("inputs are given, rows are views, and the rest are stacks or combinations")
            }
        }
    }
}

fn operands(sink: &Sink) -> impl Iterator<Item = Node> {
    let (first, second) = match *sink {
        Sink::Outer { left, right, .. } => (left, Some(right)),
        Sink::Sum { x, .. } => (x, None),
    };
    std::iter::once(first).chain(second)
}

/// How many live nodes read each node; roots count as read.
fn count_uses(graph: &Graph, roots: &[Node]) -> Vec<usize> {
    let mut uses = vec![0; graph.ops.len()];
    for root in roots {
        uses[root.0] += 1;
    }
    for node in (0..graph.ops.len()).rev().map(Node) {
        if uses[node.0] > 0 {
            graph.operands(node).for_each(|operand| uses[operand.0] += 1);
        }
    }
    uses
}

/// Gives each value a place, reusing the places of values that are no longer read, the most recent (and so nearest to the
/// core) first. `inputs` (their features) and outputs keep theirs. Returns the place of each value and the features of each place.
fn share_memory<E>(
    instructions: &mut [Instruction<E>],
    inputs: &[usize],
    outputs: &[View],
) -> (HashMap<Place, Place>, Vec<usize>) {
    let mut sizes = inputs.to_vec();
    let inputs = inputs.len();
    let is_output = |value: Place| outputs.iter().any(|view| view.place == value);
    let mut value_sizes: HashMap<Place, usize> = sizes.iter().copied().enumerate().collect();
    let mut last_read: HashMap<Place, usize> = HashMap::new();
    for (index, instruction) in instructions.iter_mut().enumerate() {
        instruction.action.each_operand(|view| _ = last_read.insert(view.place, index));
    }
    let mut places: HashMap<Place, Place> = (0..inputs).map(|input| (input, input)).collect();
    let mut free: HashMap<usize, Vec<Place>> = HashMap::new();
    for (index, instruction) in instructions.iter_mut().enumerate() {
        let mut ended = Vec::new();
        instruction.action.each_operand(|view| {
            if last_read.get(&view.place) == Some(&index) && view.place >= inputs && !is_output(view.place) {
                ended.push(view.place);
            }
        });
        ended.sort_unstable();
        ended.dedup();
        if let Some(value) = instruction.to {
            let size = instruction.features;
            value_sizes.insert(value, size);
            // Best is the place of an operand that ends here: it is in the cache already.
            let is_elementwise = matches!(instruction.action, Action::Combine { .. } | Action::Apply { .. });
            let inherited = ended.iter().position(|operand| is_elementwise && value_sizes[operand] == size);
            let place = match inherited {
                Some(index) => places[&ended.swap_remove(index)],
                None => free.get_mut(&size).and_then(Vec::pop).unwrap_or_else(|| {
                    sizes.push(size);
                    sizes.len() - 1
                }),
            };
            places.insert(value, place);
            instruction.to = Some(place);
            if !last_read.contains_key(&value) && !is_output(value) {
                free.entry(size).or_default().push(place);
            }
        }
        for value in ended {
            free.entry(value_sizes[&value]).or_default().push(places[&value]);
        }
        instruction.action.each_operand(|view| view.place = places[&view.place]);
    }
    (places, sizes)
}
