//! Steps of training and torque of prediction, the work that `torquescope bench train` reports.

use divan::Bencher;
use divan::counter::ItemsCount;
use torquescope::model::learned::{Layers, LearnedPreset};
use torquescope::network::{Activation, Buffer, Element, TILE, draw_weights};
use torquescope::progress::Monitor;
use torquescope::recording::Trajectory;
use torquescope::simulation::{Excitation, Scenario, simulate};
use torquescope::training::learn::{Begin, TrainingData, train};
use torquescope::training::loss::loss_program;
use torquescope::training::predict::torque_program;
use torquescope::training::{Options, Samples};

fn main() {
    divan::main();
}

/// Trajectories of the paper's simulated arm.
fn paper_trajectories(trajectories: usize) -> Vec<Trajectory> {
    let motion = Excitation::PaperPointToPoint { trajectories, duration: 4.0, samples: 400, range: 3.0 };
    simulate(&Scenario { motion, ..Scenario::paper(1) }, &Monitor::new()).expect("a good scenario").trajectories
}

fn layers() -> Layers {
    Layers { hidden: vec![64, 64], activation: Activation::Tanh }
}

const PRESETS: [&str; 5] = ["ff-nn", "black-box-delan", "structured-delan", "delan-friction", "delan-ffnn"];

/// Loss and gradient of one tile on one thread: the inner loop of training.
#[divan::bench(args = PRESETS)]
fn tile(bencher: Bencher, preset: &str) {
    let preset = LearnedPreset::parse(preset).expect("a preset");
    let program = loss_program::<f32>(&preset.architecture(3, &layers()));
    let mut random: rand_chacha::ChaCha8Rng = rand::SeedableRng::seed_from_u64(1);
    let weights = Buffer::from_slice(&draw_weights::<f32>(program.layout(), &mut random));
    let (mut arena, mut gradient) = (program.arena(), Buffer::<f32>::zeros(weights.len()));
    bencher
        .counter(ItemsCount::new(TILE))
        .bench_local(|| program.run(f32::kernels(), &weights, &mut arena, &mut gradient));
}

/// One epoch of 100 steps of 512 samples, as users run it: shuffled, gathered, on two threads.
#[divan::bench(args = PRESETS, sample_count = 10)]
fn hundred_steps(bencher: Bencher, preset: &str) {
    let preset = LearnedPreset::parse(preset).expect("a preset");
    let samples = Samples::<f32>::new(3, &paper_trajectories(128), &[]).expect("good samples");
    let architecture = preset.architecture(3, &layers());
    let options = Options { epochs: 1, threads: Some(2), ..Options::paper() };
    bencher.counter(ItemsCount::new(samples.len())).bench_local(|| {
        let data = TrainingData { train: &samples, validation: None, held_out: None };
        train(&architecture, &options, data, Begin::Fresh, &Monitor::new(), &mut |_| {})
    });
}

/// Torque of the structured model for 2,000 samples on one thread.
#[divan::bench]
fn torque_of_2000_samples(bencher: Bencher) {
    let program = torque_program::<f32>(&LearnedPreset::StructuredDelan.architecture(3, &layers()));
    let mut random: rand_chacha::ChaCha8Rng = rand::SeedableRng::seed_from_u64(1);
    let weights = Buffer::from_slice(&draw_weights::<f32>(program.layout(), &mut random));
    let motion = vec![0.3_f32; 3 * 2000];
    let (mut arena, mut torque) = (program.arena(), vec![0.0; motion.len()]);
    bencher.counter(ItemsCount::new(2000_usize)).bench_local(|| {
        program.run(f32::kernels(), &weights, &mut arena, [&motion, &motion, &motion], &[], &mut torque);
    });
}
