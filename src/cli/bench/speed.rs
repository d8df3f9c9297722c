//! How fast training is on this machine, on data of the paper's simulated arm.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use cpu_time::ProcessTime;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::arm::Arm;
use crate::model::learned::{Layers, LearnedPreset};
use crate::network::kernel::{Factors, Start};
use crate::network::team::{Team, with_team};
use crate::network::{Activation, Buffer, Element, TILE, draw_weights};
use crate::progress::Monitor;
use crate::recording::Trajectory;
use crate::selftest::memory;
use crate::simulation::{Excitation, Scenario, simulate};
use crate::training::learn::{Begin, TrainingData, train};
use crate::training::loss::loss_program;
use crate::training::options::{Options, Recipe};
use crate::training::predict::torque_program;
use crate::training::schedule::Schedule;
use crate::training::{Samples, TrainError};

/// What `bench train --json` prints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// One entry for each model.
    pub models: Vec<Speed>,
    /// Fastest that one core, all others idle, multiplies and adds with its widest vectors (f32) \[GFLOP/s\].
    pub peak_gflops: f64,
    /// The same of all threads at once; less than their number would give where cores share what they have \[GFLOP/s\].
    pub peak_of_all_gflops: f64,
    /// Training on the paper's arm to the paper's accuracy.
    pub paper_accuracy: Option<Accuracy>,
    /// Speed of prediction.
    pub inference: Vec<Inference>,
    /// The most memory that this process had at any time \[MiB\]; `None` where the system does not tell.
    pub peak_memory_mib: Option<f64>,
}

/// Speed of the torque of one model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Inference {
    /// Name of the preset.
    pub model: String,
    /// Samples in a call.
    pub chunk: usize,
    /// Widths of the hidden layers.
    pub hidden: Vec<usize>,
    /// Joints of the arm.
    pub joints: usize,
    /// Threads.
    pub threads: usize,
    /// CPU time of all threads a sample, mean over the run \[ns\].
    pub cpu_ns_per_sample: f64,
    /// Samples a second, best round.
    pub samples_per_s: f64,
    /// Matrix products only \[GFLOP/s\].
    pub gflops: f64,
}

/// Speed of training one model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Speed {
    /// Name of the preset.
    pub model: String,
    /// Samples in a step.
    pub batch: usize,
    /// Widths of the hidden layers.
    pub hidden: Vec<usize>,
    /// Joints of the arm.
    pub joints: usize,
    /// Threads.
    pub threads: usize,
    /// CPU time of all threads a step, mean over the run \[ms\].
    pub cpu_ms_per_step: f64,
    /// Time a step, best epoch \[ms\].
    pub wall_ms_per_step: f64,
    /// Samples a second, best epoch.
    pub samples_per_s: f64,
    /// Matrix products only \[GFLOP/s\].
    pub gflops: f64,
}

/// How long training took to an accuracy.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Accuracy {
    /// CPU time of all threads \[s\].
    pub cpu_s: f64,
    /// Time \[s\].
    pub wall_s: f64,
    /// nMSE on trajectories that were not trained on.
    pub nmse: f64,
}

/// nMSE that the paper reports for its structured model on new trajectories.
pub const PAPER_NMSE: f64 = 8.1e-6;

/// Trajectories of the paper's experiment on uniform rods, without noise.
fn paper_trajectories(joints: usize, count: usize, seed: u64) -> Result<Vec<Trajectory>, TrainError> {
    let motion = Excitation::PaperPointToPoint { trajectories: count, duration: 4.0, samples: 400, range: 3.0 };
    let scenario = Scenario { arm: Arm::uniform(joints), motion, ..Scenario::paper(seed) };
    let recording = simulate(&scenario, &Monitor::new()).map_err(|error| TrainError::Model(error.to_string()))?;
    Ok(recording.trajectories)
}

/// CPU time of this process so far, all threads together \[s\]; `None` where the system does not tell.
pub fn cpu_seconds() -> Option<f64> {
    ProcessTime::try_now().ok().map(|time| time.as_duration().as_secs_f64())
}

/// The fastest that so many threads together multiply and add \[GFLOP/s\]: products whose factors never leave the registers and
/// the first cache.
pub fn peak_gflops(threads: usize) -> f64 {
    const DEPTH: usize = 20_000;
    const ROUNDS: usize = 200;
    let (a, b) = (vec![1e-3_f32; 6], vec![1e-3_f32; TILE]);
    let task = |_: usize, _: usize| {
        let start = Start::Zero;
        let f = Factors { rows: 6, columns: TILE, depth: DEPTH, a: &a, a_row: 1, a_depth: 0, b: &b, b_row: 0, start };
        (f32::kernels().product)(&f, &mut [0.0; 6 * TILE], TILE);
    };
    let best = with_team(threads, threads, &task, |team| best_round(team, ROUNDS));
    (threads * 2 * 6 * TILE * DEPTH) as f64 / best * 1e-9
}

/// The shortest of some rounds \[s\].
fn best_round(team: &mut Team, rounds: usize) -> f64 {
    let round = |_| {
        let start = Instant::now();
        team.run();
        start.elapsed().as_secs_f64()
    };
    (0..rounds).map(round).fold(f64::INFINITY, f64::min)
}

/// Measures the speed of training one model with AdamW.
///
/// # Errors
/// [`TrainError`] as training.
pub fn speed(
    preset: LearnedPreset,
    joints: usize,
    layers: &Layers,
    batch: usize,
    threads: usize,
) -> Result<Speed, TrainError> {
    let samples = Samples::<f32>::new(joints, &paper_trajectories(joints, 200, 1)?, &[])?;
    let architecture = preset.architecture(joints, layers);
    let steps_an_epoch = samples.len() / batch;
    let epochs = (3000 / steps_an_epoch).clamp(5, 40) as u64;
    let options = Options { batch, epochs, threads: Some(threads), ..Options::paper() };
    let data = TrainingData { train: &samples, validation: None, held_out: None };
    let (start, cpu) = (Instant::now(), cpu_seconds());
    let outcome = train(&architecture, &options, data, Begin::Fresh, &Monitor::new(), &mut |_| {})?;
    let steps = epochs as f64 * steps_an_epoch as f64;
    let cpu_s = match (cpu, cpu_seconds()) {
        (Some(before), Some(after)) => after - before,
        _ => start.elapsed().as_secs_f64() * threads as f64,
    };
    let samples_per_s = outcome.history.iter().map(|epoch| epoch.samples_per_s).fold(0.0, f64::max);
    let program = loss_program::<f32>(&architecture);
    let operations = program.product_operations() as f64 / TILE as f64;
    Ok(Speed {
        model: preset.id().into(),
        batch,
        hidden: layers.hidden.clone(),
        joints,
        threads,
        cpu_ms_per_step: cpu_s / steps * 1e3,
        wall_ms_per_step: batch as f64 / samples_per_s * 1e3,
        samples_per_s,
        gflops: samples_per_s * operations * 1e-9,
    })
}

/// Measures the speed of the torque of one model, each thread with chunks of 2,000 samples of its own.
///
/// # Errors
/// [`TrainError`] if the data can't be simulated.
pub fn inference(
    preset: LearnedPreset,
    joints: usize,
    layers: &Layers,
    threads: usize,
) -> Result<Inference, TrainError> {
    const CHUNK: usize = 2_000;
    const CHUNKS_A_ROUND: usize = 8;
    const ROUNDS: usize = 100;
    let samples = Samples::<f32>::new(joints, &paper_trajectories(joints, 5, 1)?, &[])?;
    let motion = [0, 1, 2].map(|channel| samples.channel(channel));
    let program = torque_program::<f32>(&preset.architecture(joints, layers));
    let weights = Buffer::from_slice(&draw_weights::<f32>(program.layout(), &mut ChaCha8Rng::seed_from_u64(1)));
    let memory: Vec<_> = (0..threads).map(|_| Mutex::new((program.arena(), vec![0.0_f32; CHUNK * joints]))).collect();
    let task = |index: usize, _: usize| {
        let mut memory = memory[index].lock().unwrap_or_else(PoisonError::into_inner);
        let (arena, torque) = &mut *memory;
        let inputs = [0, 1, 2].map(|channel: usize| &motion[channel][..CHUNK * joints]);
        for _ in 0..CHUNKS_A_ROUND {
            program.run(f32::kernels(), &weights, arena, inputs, &[], torque);
        }
    };
    let (start, cpu) = (Instant::now(), cpu_seconds());
    let best = with_team(threads, threads, &task, |team| best_round(team, ROUNDS));
    let cpu_s = match (cpu, cpu_seconds()) {
        (Some(before), Some(after)) => after - before,
        _ => start.elapsed().as_secs_f64() * threads as f64,
    };
    let a_round = (threads * CHUNKS_A_ROUND * CHUNK) as f64;
    Ok(Inference {
        model: preset.id().into(),
        chunk: CHUNK,
        hidden: layers.hidden.clone(),
        joints,
        threads,
        cpu_ns_per_sample: cpu_s / (a_round * ROUNDS as f64) * 1e9,
        samples_per_s: a_round / best,
        gflops: a_round / best * program.product_operations() as f64 / TILE as f64 * 1e-9,
    })
}

/// Trains the structured model on the paper's arm with our recipe until its error on new trajectories is the paper's.
///
/// # Errors
/// [`TrainError`] as training.
pub fn paper_accuracy(threads: usize, seed: u64) -> Result<Accuracy, TrainError> {
    let samples = Samples::<f32>::new(3, &paper_trajectories(3, 200, 2 * seed + 1)?, &[])?;
    let new = Samples::<f32>::new(3, &paper_trajectories(3, 10, 2 * seed + 2)?, &[])?;
    let architecture = Recipe::Ours.architecture(LearnedPreset::StructuredDelan, 3, &samples);
    // So short a run bears twice the rate, with a longer warm-up.
    let schedule = Schedule::Cosine { warm_up: 0.2 };
    let (threads_asked, goal) = (Some(threads), Some(PAPER_NMSE));
    let options = Options { epochs: 8, rate: 2e-2, schedule, seed, threads: threads_asked, goal, ..Options::ours() };
    let data = TrainingData { train: &samples, validation: Some(&new), held_out: None };
    let (start, cpu) = (Instant::now(), cpu_seconds());
    let outcome = train(&architecture, &options, data, Begin::Fresh, &Monitor::new(), &mut |_| {})?;
    let wall_s = start.elapsed().as_secs_f64();
    let cpu_s = cpu.zip(cpu_seconds()).map_or(wall_s * threads as f64, |(before, after)| after - before);
    let nmse = outcome.history.last().and_then(|epoch| epoch.validation).unwrap_or(f64::NAN);
    Ok(Accuracy { cpu_s, wall_s, nmse })
}

/// Measures everything: the five presets as in the paper (batch 512, 2 × 64 tanh, 3 joints), a wider structured model, one of
/// seven joints, and the time to the paper's accuracy.
///
/// # Errors
/// [`TrainError`] as training, also when `monitor` was told to stop.
pub fn report(threads: usize, monitor: &Monitor) -> Result<Report, TrainError> {
    let small = Layers { hidden: vec![64, 64], activation: Activation::Tanh };
    let wide = Layers { hidden: vec![128, 128], activation: Activation::Sigmoid };
    let mut cases: Vec<(LearnedPreset, usize, &Layers, usize)> =
        LearnedPreset::ALL.into_iter().map(|preset| (preset, 3, &small, 512)).collect();
    cases.push((LearnedPreset::StructuredDelan, 3, &wide, 1024));
    cases.push((LearnedPreset::StructuredDelan, 7, &small, 512));
    let mut models = Vec::new();
    for (index, (preset, joints, layers, batch)) in cases.iter().enumerate() {
        let activity = format!("{}, {joints} joints, batch {batch}", preset.title());
        monitor.report(index as f32 / (cases.len() + 1) as f32, &activity)?;
        models.push(speed(*preset, *joints, layers, *batch, threads)?);
    }
    monitor.report(cases.len() as f32 / (cases.len() + 1) as f32, "training to the paper's accuracy")?;
    let paper_accuracy = Some(paper_accuracy(threads, 0)?);
    let inference = vec![inference(LearnedPreset::StructuredDelan, 3, &small, threads)?];
    let peak_memory_mib = memory::most().map(|bytes| bytes as f64 / f64::from(1 << 20));
    let (peak_gflops, peak_of_all_gflops) = (peak_gflops(1), peak_gflops(threads));
    Ok(Report { models, peak_gflops, peak_of_all_gflops, paper_accuracy, inference, peak_memory_mib })
}
