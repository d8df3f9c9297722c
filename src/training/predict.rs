//! What a learned model says of a motion: torque, each term, and what a Lagrangian has inside.

use nalgebra::{DMatrix, SymmetricEigen};

use super::data::Samples;
use crate::model::learned::Architecture;
use crate::network::{Arena, Element, Graph, Kernels, Layout, Node, Program, TILE};
use crate::signals::Signals;

/// All that a model gives for a motion.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Components {
    /// Total torque \[N m\].
    pub torque: Signals,
    /// Torque of each term \[N m\], in the order of the architecture.
    pub terms: Vec<Signals>,
    /// What the Lagrangian term has inside, if there is one.
    pub lagrangian: Option<LagrangianComponents>,
    /// Parts read off the whole model's torque f without its effect columns, as for models that have no H, c, g of their own.
    pub read_off: ReadOff,
}

/// What a Lagrangian term has inside.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LagrangianComponents {
    /// H(q) = ∂²L/∂q̇² \[kg m²\], one signal for each element, row after row.
    pub mass_matrix: Signals,
    /// H q̈ \[N m\]
    pub inertial: Signals,
    /// Coriolis and centrifugal torque \[N m\].
    pub coriolis: Signals,
    /// Gravity torque \[N m\].
    pub gravity: Signals,
    /// L(q, q̇) \[J\], a single signal.
    pub lagrangian: Signals,
    /// V(q) \[J\], a single signal; only structured Lagrangians have it.
    pub potential: Option<Signals>,
    /// T = L + V \[J\], a single signal; only structured Lagrangians have it.
    pub kinetic: Option<Signals>,
}

impl LagrangianComponents {
    /// Eigenvalues of H \[kg m²\], the smallest first, one signal for each: a physical arm has only positive ones.
    pub fn mass_eigenvalues(&self) -> Signals {
        let joints = self.inertial.joint_count();
        let mut all = Signals::zeros(joints, self.inertial.sample_count());
        for sample in 0..self.inertial.sample_count() {
            let matrix = DMatrix::from_row_iterator(joints, joints, self.mass_matrix.at(sample));
            let mut values = SymmetricEigen::new(matrix).eigenvalues;
            values.as_mut_slice().sort_by(f64::total_cmp);
            (0..joints).for_each(|index| all[index][sample] = values[index]);
        }
        all
    }
}

/// Parts read off a torque f(q, q̇, q̈) alone, as Lutter does.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReadOff {
    /// f(q, 0, q̈) − f(q, 0, 0)
    pub inertial: Signals,
    /// f(q, q̇, 0) − f(q, 0, 0)
    pub coriolis: Signals,
    /// f(q, 0, 0)
    pub gravity: Signals,
}

/// A model ready to be asked for torque only: the fast way.
#[derive(Debug, Clone)]
pub struct TorqueProgram<E: Element> {
    program: Program<E>,
    joints: usize,
    columns: usize,
}

/// A model ready to be asked for all its components.
#[derive(Debug, Clone)]
pub struct ComponentProgram<E: Element> {
    full: TorqueProgram<E>,
    torque: TorqueProgram<E>,
    terms: usize,
    has_lagrangian: bool,
    has_potential: bool,
}

/// The torque of a model.
pub fn torque_program<E: Element>(architecture: &Architecture) -> TorqueProgram<E> {
    let built = architecture.build();
    let (joints, columns) = (architecture.joints, architecture.column_count());
    TorqueProgram { program: Program::compile(built.graph, &[built.torque], &[]), joints, columns }
}

/// All components of a model.
pub fn component_program<E: Element>(architecture: &Architecture) -> ComponentProgram<E> {
    let built = architecture.build();
    let n = architecture.joints;
    let mut graph = built.graph;
    let mut outputs = vec![built.torque];
    outputs.extend(&built.terms);
    let mut torques = vec![built.torque];
    if let Some(nodes) = built.lagrangian {
        let one = graph.constant(1.0, 1);
        let momentum = graph.pull_back(&[(nodes.lagrangian, one)], &[built.motion.qd])[0];
        outputs.push(nodes.torque);
        outputs.push(graph.tangent(momentum, &[(built.motion.qd, built.motion.qdd)]));
        outputs.push(nodes.lagrangian);
        outputs.extend(nodes.potential);
        for j in 0..n {
            let unit = unit_vector(&mut graph, j, n);
            outputs.push(graph.tangent(momentum, &[(built.motion.qd, unit)]));
        }
        torques.push(nodes.torque);
    }
    let program = |outputs: &[Node]| TorqueProgram {
        program: Program::compile(graph.clone(), outputs, &[]),
        joints: n,
        columns: architecture.column_count(),
    };
    ComponentProgram {
        full: program(&outputs),
        torque: program(&torques),
        terms: built.terms.len(),
        has_lagrangian: built.lagrangian.is_some(),
        has_potential: built.lagrangian.is_some_and(|nodes| nodes.potential.is_some()),
    }
}

fn unit_vector(graph: &mut Graph, index: usize, n: usize) -> Node {
    let one = graph.constant(1.0, 1);
    graph.place(one, index, n)
}

impl<E: Element> TorqueProgram<E> {
    /// The layout of its weights.
    pub fn layout(&self) -> &Layout {
        self.program.layout()
    }

    /// Memory for one thread.
    pub fn arena(&self) -> Arena<E> {
        self.program.arena()
    }

    /// Floating-point operations of the matrix products in one tile.
    pub fn product_operations(&self) -> usize {
        self.program.product_operations()
    }

    /// Torque for q, q̇, q̈ (n values a sample, sample after sample), written in the same order. `columns` are the effect columns of
    /// each sample, column after column with n values each; empty for none.
    pub fn run(
        &self,
        kernels: &Kernels<E>,
        weights: &[E],
        arena: &mut Arena<E>,
        motion: [&[E]; 3],
        columns: &[E],
        torque: &mut [E],
    ) {
        let n = self.joints;
        for first in (0..torque.len() / n).step_by(TILE) {
            self.run_tile(kernels, weights, arena, motion, columns, first);
            scatter(self.program.output(arena, 0), n, &mut torque[first * n..]);
        }
    }

    /// Σ ‖τ̂ − τ‖² and Σ ‖τ‖² over a range of samples.
    pub(super) fn squared_errors(
        &self,
        weights: &[E],
        arena: &mut Arena<E>,
        samples: &Samples<E>,
        range: std::ops::Range<usize>,
    ) -> (f64, f64) {
        let (mut error, mut size) = (0.0, 0.0);
        let mut measured = vec![E::ZERO; self.joints * TILE];
        let picks: Vec<u32> = range.map(|sample| sample as u32).collect();
        for picks in picks.chunks(TILE) {
            samples.deal(E::kernels(), picks, self.program.input(arena, 0));
            let first = 3 * self.joints * TILE;
            measured.copy_from_slice(&self.program.input(arena, 0)[first..first + self.joints * TILE]);
            self.program.run(E::kernels(), weights, arena, &mut []);
            let rows = self.program.output(arena, 0).chunks_exact(TILE).zip(measured.chunks_exact(TILE));
            for (ours, theirs) in rows.flat_map(|(ours, theirs)| ours.iter().zip(theirs).take(picks.len())) {
                error += (ours.to_f64() - theirs.to_f64()).powi(2);
                size += theirs.to_f64().powi(2);
            }
        }
        (error, size)
    }

    fn run_tile(
        &self,
        kernels: &Kernels<E>,
        weights: &[E],
        arena: &mut Arena<E>,
        motion: [&[E]; 3],
        columns: &[E],
        first: usize,
    ) {
        let (n, state) = (self.joints, self.program.input(arena, 0));
        for (part, values) in motion.into_iter().enumerate() {
            gather(values, first, &mut state[part * n * TILE..(part + 1) * n * TILE]);
        }
        gather(columns, first, &mut state[4 * n * TILE..(4 + self.columns) * n * TILE]);
        self.program.run(kernels, weights, arena, &mut []);
    }

    /// All outputs for all samples, with as many signals as each has values.
    fn run_all(
        &self,
        kernels: &Kernels<E>,
        weights: &[E],
        motion: [&[E]; 3],
        columns: &[E],
        sizes: &[usize],
    ) -> Vec<Signals> {
        let samples = motion[0].len() / self.joints;
        let mut arena = self.program.arena();
        let mut results: Vec<Vec<E>> = sizes.iter().map(|size| vec![E::ZERO; size * samples]).collect();
        for first in (0..samples).step_by(TILE) {
            self.run_tile(kernels, weights, &mut arena, motion, columns, first);
            for (output, (size, result)) in sizes.iter().zip(&mut results).enumerate() {
                scatter(self.program.output(&arena, output), *size, &mut result[first * size..]);
            }
        }
        let by_signal = |(size, result): (&usize, &Vec<E>)| {
            Signals::from_fn(*size, samples, |signal, sample| result[sample * size + signal].to_f64())
        };
        sizes.iter().zip(&results).map(by_signal).collect()
    }
}

/// Fills a tile with the samples from `first` on; behind the last one the tile is zero.
fn gather<E: Element>(values: &[E], first: usize, tile: &mut [E]) {
    let features = tile.len() / TILE;
    let values = &values[(first * features).min(values.len())..];
    for (feature, row) in tile.chunks_exact_mut(TILE).enumerate() {
        let samples = values.chunks_exact(features);
        row[samples.len().min(TILE)..].fill(E::ZERO);
        for (element, sample) in row.iter_mut().zip(samples) {
            *element = sample[feature];
        }
    }
}

/// Writes the samples of a tile one after the other, as many as there is room for.
fn scatter<E: Element>(tile: &[E], features: usize, to: &mut [E]) {
    for (feature, row) in tile.chunks_exact(TILE).enumerate() {
        for (element, sample) in row.iter().zip(to.chunks_exact_mut(features)) {
            sample[feature] = *element;
        }
    }
}

impl<E: Element> ComponentProgram<E> {
    /// The layout of its weights.
    pub fn layout(&self) -> &Layout {
        self.full.layout()
    }

    /// All components for q, q̇, q̈ and the effect columns, given as for [`TorqueProgram::run`].
    pub fn run(&self, kernels: &Kernels<E>, weights: &[E], q: &[E], qd: &[E], qdd: &[E], columns: &[E]) -> Components {
        let n = self.full.joints;
        let mut sizes = vec![n; 1 + self.terms];
        if self.has_lagrangian {
            sizes.extend([n, n, 1]);
            sizes.extend(self.has_potential.then_some(1));
            sizes.extend(vec![n; n]);
        }
        let mut results = self.full.run_all(kernels, weights, [q, qd, qdd], columns, &sizes).into_iter();
        let mut next = || results.next().unwrap_or_default();
        let torque = next();
        let terms = (0..self.terms).map(|_| next()).collect();

        let (still, nothing) = (vec![E::ZERO; q.len()], vec![E::ZERO; columns.len()]);
        let part = |qd: &[E], qdd: &[E]| {
            self.torque.run_all(
                kernels,
                weights,
                [q, qd, qdd],
                &nothing,
                &vec![n; 1 + usize::from(self.has_lagrangian)],
            )
        };
        let at_rest = part(&still, &still);
        let read_off = ReadOff {
            inertial: minus(&part(&still, qdd)[0], &at_rest[0]),
            coriolis: minus(&part(qd, &still)[0], &at_rest[0]),
            gravity: at_rest[0].clone(),
        };
        let lagrangian = self.has_lagrangian.then(|| {
            let (total, inertial, lagrangian) = (next(), next(), next());
            let potential = self.has_potential.then(&mut next);
            let kinetic = potential.as_ref().map(|potential| minus(&lagrangian, &potential.map(|v| -v)));
            let gravity = at_rest[1].clone();
            let coriolis = minus(&minus(&total, &inertial), &gravity);
            let rows: Vec<Signals> = (0..n).map(|_| next()).collect();
            let mass_matrix = Signals::from_fn(n * n, inertial.sample_count(), |element, sample| {
                rows[element / n][element % n][sample]
            });
            LagrangianComponents { mass_matrix, inertial, coriolis, gravity, lagrangian, potential, kinetic }
        });
        Components { torque, terms, lagrangian, read_off }
    }
}

fn minus(a: &Signals, b: &Signals) -> Signals {
    let mut difference = a.clone();
    difference.add(b, -1.0);
    difference
}
