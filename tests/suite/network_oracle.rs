//! Torque, components, loss, gradients and five optimiser steps against reference values that JAX computed in double precision.

use std::collections::HashMap;
use std::io::Read;
use std::path::{Path, PathBuf};

use torquescope::model::learned::{Architecture, Features, Layers, LearnedTerm, Positive, Scales};
use torquescope::network::{Activation, AdamStep, Element, Kernels, Layout, Program, TILE};
use torquescope::recording::npy::{self, NpyError};
use torquescope::signals::Signals;
use torquescope::training::loss::{SHARE_INPUT, WEIGHT_INPUT, loss_program};
use torquescope::training::predict::{Components, component_program};

use crate::outside;

const TOLERANCE: f64 = 1e-9;

type Arrays = HashMap<String, (Vec<usize>, Vec<f64>)>;

fn oracle_files() -> Vec<PathBuf> {
    let in_folder = |folder: PathBuf| folder.join("networks").read_dir().unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> = outside::references().into_iter().flat_map(in_folder).collect();
    files.retain(|path| path.extension().is_some_and(|ending| ending == "npz"));
    files.sort();
    assert!(files.len() >= 5, "the reference vectors were not found");
    files
}

/// All numeric arrays of a file as f64.
fn read(path: &Path) -> Arrays {
    let mut archive = zip::ZipArchive::new(std::fs::File::open(path).unwrap()).unwrap();
    let mut arrays = Arrays::new();
    for index in 0..archive.len() {
        let mut file = archive.by_index(index).unwrap();
        let name = file.name().unwrap().strip_suffix(".npy").unwrap().to_owned();
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).unwrap();
        match npy::decode(&bytes, 1 << 20) {
            Ok(array) => drop(arrays.insert(name, (array.shape().to_vec(), array.into_iter().collect()))),
            Err(NpyError::NotNumbers(_)) => {}
            Err(error) => panic!("{}: {name}: {error}", path.display()),
        }
    }
    arrays
}

/// The reference values come sample after sample.
fn by_sample(signals: &Signals) -> Vec<f64> {
    (0..signals.sample_count()).flat_map(|sample| signals.at(sample)).collect()
}

struct Case {
    name: String,
    arrays: Arrays,
    architecture: Architecture,
    n: usize,
    samples: usize,
}

impl Case {
    fn new(path: &Path) -> Self {
        let arrays = read(path);
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let number = |key: &str| arrays[key].1[0];
        let activation = match () {
            () if name.contains("sigmoid") => Activation::Sigmoid,
            () if name.contains("softplus") => Activation::Softplus,
            () => Activation::Tanh,
        };
        let hidden = arrays["cfg_hidden"].1.iter().map(|width| *width as usize).collect();
        let layers = Layers { hidden, activation };
        let positive =
            Positive { shift: number("cfg_shift"), floor: number("cfg_eps_L"), inertia: number("cfg_eps_H") };
        let structured = LearnedTerm::StructuredLagrangian { layers: layers.clone(), positive: Some(positive) };
        let feed_forward = |penalty| LearnedTerm::FeedForward { layers: layers.clone(), penalty };
        let terms = match name.split('_').next().unwrap() {
            "structured" => vec![structured],
            "blackbox" => vec![LearnedTerm::BlackBoxLagrangian { layers: layers.clone() }],
            "ffn" => vec![feed_forward(0.0)],
            "friction" => vec![structured, LearnedTerm::Friction],
            "ffnn" => vec![structured, feed_forward(number("cfg_lam"))],
            other => panic!("unknown model {other}"),
        };
        let features = if number("cfg_feat") == 1.0 { Features::CosSin } else { Features::Raw };
        let n = number("cfg_n") as usize;
        let architecture = Architecture { joints: n, features, terms, scales: Scales::default() };
        architecture.check().unwrap();
        let samples = arrays["q"].0[0];
        Case { name, arrays, architecture, n, samples }
    }

    fn values(&self, key: &str) -> &[f64] {
        &self.arrays[key].1
    }

    fn weights<E: Element>(&self, layout: &Layout, prefix: &str) -> Vec<E> {
        let mut flat = vec![E::ZERO; layout.size()];
        for block in layout.blocks() {
            layout.write(block, self.values(&format!("{prefix}/{}", block.name)), &mut flat);
        }
        flat
    }

    /// All states in one tile; what is left of it repeats the last sample.
    fn fill<E: Element>(&self, tile: &mut [E], value: impl Fn(usize, usize) -> f64) {
        for (feature, row) in tile.chunks_exact_mut(TILE).enumerate() {
            for (sample, element) in row.iter_mut().enumerate() {
                *element = E::from_f64(value(sample.min(self.samples - 1), feature));
            }
        }
    }

    fn agree(&self, what: &str, ours: &[f64], theirs: &[f64], tolerance: f64) {
        assert_eq!(ours.len(), theirs.len(), "{}: {what} has another size", self.name);
        let scale = theirs.iter().fold(1e-300_f64, |most, value| most.max(value.abs()));
        for (index, (a, b)) in ours.iter().zip(theirs).enumerate() {
            let error = (a - b).abs() / scale;
            assert!(error <= tolerance, "{}: {what}[{index}] is {a}, not {b} (error {error:.1e})", self.name);
        }
    }

    fn load<E: Element>(&self, program: &Program<E>, arena: &mut torquescope::network::Arena<E>) {
        for (part, key) in ["q", "qd", "qdd", "tau_target"].into_iter().enumerate() {
            let (values, size) = (self.values(key), self.n * TILE);
            let tile = &mut program.input(arena, 0)[part * size..(part + 1) * size];
            self.fill(tile, |sample, joint| values[sample * self.n + joint]);
        }
        let (share, weight) = (1.0 / self.samples as f64, self.values("loss_weight"));
        for (input, with_weight) in [(WEIGHT_INPUT, true), (SHARE_INPUT, false)] {
            for (joint, row) in program.input(arena, input).chunks_exact_mut(TILE).enumerate() {
                for (sample, element) in row.iter_mut().enumerate() {
                    let value = if sample < self.samples { share } else { 0.0 };
                    *element = E::from_f64(if with_weight { value * weight[joint] } else { value });
                }
            }
        }
    }

    fn check_training<E: Element>(&self, kernels: &Kernels<E>, tolerance: f64) {
        let program = loss_program::<E>(&self.architecture);
        let layout = program.layout().clone();
        let mut weights = self.weights::<E>(&layout, "param");
        let mut arena = program.arena();
        let (mut mean, mut square) = (vec![E::ZERO; layout.size()], vec![E::ZERO; layout.size()]);
        for step in 1..=5 {
            let mut gradient = vec![E::ZERO; layout.size()];
            self.load(&program, &mut arena);
            program.run(kernels, &weights, &mut arena, &mut gradient);
            let loss: f64 = program.output(&arena, 0).iter().map(|value| value.to_f64()).sum();
            self.agree("loss", &[loss], &self.values("adamw5_losses")[step - 1..step], tolerance);
            if step == 1 {
                for block in layout.blocks() {
                    let key = format!("grad/{}", block.name);
                    self.agree(&key, &layout.read(block, &gradient), self.values(&key), tolerance);
                }
            }
            let number = E::from_f64;
            let adam = AdamStep {
                rate: number(1e-3),
                beta_1: number(0.9),
                beta_2: number(0.999),
                unbias_1: number(1.0 / (1.0 - 0.9_f64.powi(step as i32))),
                unbias_2: number(1.0 / (1.0 - 0.999_f64.powi(step as i32))),
                epsilon: number(1e-8),
                decay: number(1e-2),
            };
            (kernels.adam)(&adam, &mut weights, &gradient, &mut mean, &mut square);
        }
        for block in layout.blocks() {
            let key = format!("adamw5/{}", block.name);
            self.agree(&key, &layout.read(block, &weights), self.values(&key), tolerance);
        }
    }

    fn check_components<E: Element>(&self, kernels: &Kernels<E>, tolerance: f64) {
        let program = component_program::<E>(&self.architecture);
        let weights = self.weights::<E>(program.layout(), "param");
        let motion = |key: &str| self.values(key).iter().map(|value| E::from_f64(*value)).collect::<Vec<E>>();
        let (q, qd, qdd) = (motion("q"), motion("qd"), motion("qdd"));
        let components: Components = program.run(kernels, &weights, &q, &qd, &qdd, &[]);
        self.agree("tau", &by_sample(&components.torque), self.values("tau"), tolerance);
        if let Some(lagrangian) = &components.lagrangian {
            self.agree("H", &by_sample(&lagrangian.mass_matrix), self.values("H"), tolerance);
            self.agree("c", &by_sample(&lagrangian.coriolis), self.values("c"), tolerance);
            self.agree("g", &by_sample(&lagrangian.gravity), self.values("g"), tolerance);
            if self.arrays.contains_key("V") {
                self.agree("V", &by_sample(lagrangian.potential.as_ref().unwrap()), self.values("V"), tolerance);
                self.agree("T", &by_sample(lagrangian.kinetic.as_ref().unwrap()), self.values("T"), tolerance);
                self.agree("Hqdd", &by_sample(&lagrangian.inertial), self.values("Hqdd"), tolerance);
            } else {
                self.agree("L", &by_sample(&lagrangian.lagrangian), self.values("lagrangian"), tolerance);
            }
        }
        self.agree("comp_m", &by_sample(&components.read_off.inertial), self.values("comp_m"), tolerance);
        self.agree("comp_c", &by_sample(&components.read_off.coriolis), self.values("comp_c"), tolerance);
        self.agree("comp_g", &by_sample(&components.read_off.gravity), self.values("comp_g"), tolerance);
        for (key, kind) in [("tau_fric", "friction"), ("eps", "feed-forward")] {
            if self.arrays.contains_key(key) {
                let index = self.architecture.terms.iter().position(|term| term.kind() == kind).unwrap();
                self.agree(key, &by_sample(&components.terms[index]), self.values(key), tolerance);
            }
        }
    }
}

#[test]
fn all_models_agree_with_the_reference() {
    for path in oracle_files() {
        let case = Case::new(&path);
        for kernels in f64::all_kernels() {
            case.check_training::<f64>(kernels, TOLERANCE);
            case.check_components::<f64>(kernels, TOLERANCE);
        }
        for kernels in f32::all_kernels() {
            case.check_components::<f32>(kernels, 3e-5);
        }
        println!("{} agrees", case.name);
    }
}
