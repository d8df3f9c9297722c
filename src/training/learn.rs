//! One training run: epochs of steps on all cores, watched, stopped when it makes no sense to go on, the best kept.
//!
//! A batch is dealt into tiles and these into a few groups, each with a gradient of its own; the groups are added in a fixed
//! order. So the weights depend on the seed only, and not on the number of threads.

use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};
use std::time::{Duration, Instant};

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::data::{self, Mark, Samples};
use super::learned::{Checkpoint, LearnedModel};
use super::loss::{SHARE_INPUT, WEIGHT_INPUT, loss_program};
use super::optimiser::{Optimiser, Part};
use super::options::Options;
use super::{TrainError, predict};
use crate::arm::MOST_JOINTS;
use crate::model::learned::Architecture;
use crate::network::team::{self, Team, with_team};
use crate::network::{Arena, Buffer, Element, Layout, Program, TILE, draw_weights};
use crate::progress::{Epoch, Event, Monitor};

/// Groups of tiles that have a gradient of their own: so many threads can share a batch.
const GROUPS: usize = 4;
/// A step whose loss is this many times the first one's has exploded.
const EXPLOSION: f64 = 1e6;
/// How often a watcher hears of progress.
const REPORT_EVERY: Duration = Duration::from_millis(50);

/// What is learned from.
#[derive(Debug, Clone, Copy)]
pub struct TrainingData<'a, E: Element> {
    /// Samples for the gradients.
    pub train: &'a Samples<E>,
    /// Samples that say which epoch is the best; without them it is that of the smallest loss.
    pub validation: Option<&'a Samples<E>>,
    /// Samples whose error is told after every epoch, and decides nothing.
    pub held_out: Option<&'a Samples<E>>,
}

impl<'a, E: Element> TrainingData<'a, E> {
    /// What is measured after every epoch: validation samples, held-out samples.
    fn watched(&self) -> [Option<&'a Samples<E>>; 2] {
        [self.validation, self.held_out]
    }
}

/// Where a run begins.
#[derive(Debug, Clone, Copy, Default)]
pub enum Begin<'a> {
    /// With weights drawn from the seed.
    #[default]
    Fresh,
    /// With the weights of another model, as far as it has the same blocks: after a term was added or removed.
    Warm(&'a LearnedModel),
    /// Where a checkpoint was saved; the result is that of a run that was never interrupted.
    Resume(&'a Checkpoint),
}

/// How a run ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ending {
    /// All epochs are done.
    Finished,
    /// The validation error is as low as asked for.
    GoalReached,
    /// Somebody stopped it, for this reason.
    Stopped(String),
    /// It could not go on, for this reason.
    Failed(String),
}

/// What a run leaves.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The best model: of the smallest validation error, or loss.
    pub model: LearnedModel,
    /// How it ended.
    pub ending: Ending,
    /// All epochs.
    pub history: Vec<Epoch>,
    /// Where it can be resumed.
    pub checkpoint: Checkpoint,
}

/// Called after every epoch; can ask for the checkpoint there, to keep it.
pub type Keep<'a> = dyn FnMut(&dyn Fn() -> Checkpoint) + 'a;

/// Trains a model. Every epoch is told on `monitor`; `keep` can have the checkpoint after it.
///
/// A stop, a loss that is not a number or explodes and a gradient that is exactly zero end the run with the best weights so
/// far and a reason in [`Outcome::ending`].
///
/// # Errors
/// [`TrainError`] if the run can't begin.
pub fn train<E: Element>(
    architecture: &Architecture,
    options: &Options,
    data: TrainingData<E>,
    begin: Begin,
    monitor: &Monitor,
    keep: &mut Keep,
) -> Result<Outcome, TrainError> {
    let engine = Engine::new(architecture, options, data, begin)?;
    let task = |index: usize, thread: usize| engine.task(index, thread);
    let threads = options.threads.unwrap_or_else(team::default_threads);
    let mut run = Run::new(&engine, begin);
    let ending = with_team(threads, GROUPS, &task, |team| run.epochs(team, monitor, keep));
    Ok(run.outcome(ending))
}

/// What the tasks of a round do.
const GRADIENT: u8 = 0;
const UPDATE: u8 = 1;
const EVALUATE: u8 = 2;

/// All that threads share.
pub(super) struct Engine<'a, E: Element> {
    architecture: &'a Architecture,
    options: &'a Options,
    data: TrainingData<'a, E>,
    mark: Mark,
    program: Program<E>,
    torque: predict::TorqueProgram<E>,
    /// 1 / variance of the torque of each joint.
    loss_weights: Vec<f64>,
    job: AtomicU8,
    step: RwLock<Step>,
    groups: Vec<RwLock<Group<E>>>,
    /// The weights, with what the optimiser remembers of them.
    parts: Vec<RwLock<Vec<Part<E>>>>,
    /// How often they were changed.
    updates: AtomicU64,
    /// Memory of each thread.
    threads: Vec<Mutex<ThreadMemory<E>>>,
}

/// What this step is about.
#[derive(Default)]
struct Step {
    order: Vec<u32>,
    first: usize,
    number: u64,
    rate: f64,
}

struct Group<E> {
    gradient: Buffer<E>,
    loss: f64,
    /// Σ ‖τ̂ − τ‖² and Σ ‖τ‖² of its validation samples and of its held-out samples.
    errors: [(f64, f64); 2],
}

struct ThreadMemory<E> {
    /// A copy of the weights, and how often these had been changed when it was made: cores then do not share their caches.
    weights: Buffer<E>,
    updates: Option<u64>,
    arena: Arena<E>,
    evaluation: Arena<E>,
    /// For how many samples of a tile the loss weights in the arena are set.
    weighted: usize,
}

// A thread that panicked has already ended the run; what it left is not looked at.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
fn read<T>(lock: &RwLock<T>) -> RwLockReadGuard<'_, T> {
    lock.read().unwrap_or_else(PoisonError::into_inner)
}
fn write<T>(lock: &RwLock<T>) -> RwLockWriteGuard<'_, T> {
    lock.write().unwrap_or_else(PoisonError::into_inner)
}

impl<'a, E: Element> Engine<'a, E> {
    pub(super) fn new(
        architecture: &'a Architecture,
        options: &'a Options,
        data: TrainingData<'a, E>,
        begin: Begin,
    ) -> Result<Self, TrainError> {
        architecture.check()?;
        options.check()?;
        if data.train.len() < options.batch {
            return Err(TrainError::TooFewSamples { samples: data.train.len(), batch: options.batch });
        }
        data.train.check(architecture)?;
        data.watched().into_iter().flatten().try_for_each(|samples| samples.check(architecture))?;
        let mut loss_weights = Vec::new();
        for joint in 0..architecture.joints {
            let (mean, variance) = data.train.mean_and_variance(3, joint);
            if variance <= 1e-12 * mean * mean || variance == 0.0 {
                return Err(TrainError::ConstantTorque { joint: joint + 1, value: mean });
            }
            loss_weights.push(1.0 / variance);
        }
        let mark = Mark::of(data.train, data.watched());
        if let Begin::Resume(checkpoint) = begin {
            checkpoint.check(architecture, options, &mark)?;
        }
        let program = loss_program::<E>(architecture);
        let torque = predict::torque_program(architecture);
        let weights = first_weights(program.layout(), options.seed, begin);
        let mut parts = share_parts(program.layout(), options.optimiser, &weights);
        if let Begin::Resume(checkpoint) = begin {
            for part in parts.iter_mut().flatten() {
                let state = checkpoint.states.get(&part.block().name);
                let state: Vec<E> = state.into_iter().flatten().map(|value| E::from_f64(*value)).collect();
                if !part.restore(&state) {
                    return Err(TrainError::Damaged(format!("the state of `{}` is missing", part.block().name)));
                }
            }
        }
        let size = program.layout().size();
        let group = || Group { gradient: Buffer::zeros(size), loss: 0.0, errors: [(0.0, 0.0); 2] };
        let memory = || ThreadMemory {
            weights: Buffer::zeros(size),
            updates: None,
            arena: program.arena(),
            evaluation: torque.arena(),
            weighted: 0,
        };
        Ok(Engine {
            architecture,
            options,
            data,
            mark,
            loss_weights,
            job: AtomicU8::new(GRADIENT),
            step: RwLock::default(),
            groups: (0..GROUPS).map(|_| RwLock::new(group())).collect(),
            parts: parts.into_iter().map(RwLock::new).collect(),
            updates: AtomicU64::new(0),
            threads: (0..GROUPS).map(|_| Mutex::new(memory())).collect(),
            torque,
            program,
        })
    }

    pub(super) fn task(&self, index: usize, thread: usize) {
        match self.job.load(Ordering::Acquire) {
            GRADIENT => self.gradient(index, thread),
            UPDATE => self.update(index),
            _ => self.evaluate(index, thread),
        }
    }

    fn run(&self, team: &mut Team, job: u8) {
        self.job.store(job, Ordering::Release);
        team.run();
    }

    /// The memory of a thread, its weights brought up to date.
    fn memory(&self, thread: usize) -> MutexGuard<'_, ThreadMemory<E>> {
        let mut memory = lock(&self.threads[thread]);
        let updates = Some(self.updates.load(Ordering::Acquire));
        if memory.updates != updates {
            self.copy_weights(&mut memory.weights);
            memory.updates = updates;
        }
        memory
    }

    fn copy_weights(&self, to: &mut [E]) {
        for share in &self.parts {
            for part in read(share).iter() {
                to[part.block().range()].copy_from_slice(&part.weights);
            }
        }
    }

    /// The gradient of one group of tiles of the batch.
    fn gradient(&self, index: usize, thread: usize) {
        let (step, kernels) = (read(&self.step), E::kernels());
        let (mut memory, mut group) = (self.memory(thread), write(&self.groups[index]));
        let group = &mut *group;
        group.gradient.fill(E::ZERO);
        group.loss = 0.0;
        let batch = &step.order[step.first..step.first + self.options.batch];
        let tiles = batch.len().div_ceil(TILE);
        for tile in tiles * index / GROUPS..tiles * (index + 1) / GROUPS {
            let picks = &batch[tile * TILE..batch.len().min((tile + 1) * TILE)];
            let ThreadMemory { weights, arena, weighted, .. } = &mut *memory;
            self.data.train.deal(kernels, picks, self.program.input(arena, 0));
            if *weighted != picks.len() {
                self.weigh(picks.len(), arena);
                *weighted = picks.len();
            }
            self.program.run(kernels, weights, arena, &mut group.gradient);
            // Within a tile in the training precision, over tiles in double.
            let mut sums = [E::ZERO; MOST_JOINTS];
            (kernels.add_row_sums)(self.program.output(arena, 0), &mut sums);
            group.loss += sums.into_iter().map(Element::to_f64).sum::<f64>();
        }
    }

    /// Sets the weights of the loss for a tile of which `valid` samples count.
    fn weigh(&self, valid: usize, arena: &mut Arena<E>) {
        let share = 1.0 / self.options.batch as f64;
        for (input, is_weight) in [(WEIGHT_INPUT, true), (SHARE_INPUT, false)] {
            for (joint, row) in self.program.input(arena, input).chunks_exact_mut(TILE).enumerate() {
                let value = if is_weight { share * self.loss_weights[joint] } else { share };
                row[..valid].fill(E::from_f64(value));
                row[valid..].fill(E::ZERO);
            }
        }
    }

    /// New weights of some blocks.
    fn update(&self, index: usize) {
        let (step, kernels) = (read(&self.step), E::kernels());
        let groups: Vec<_> = self.groups.iter().map(read).collect();
        for part in write(&self.parts[index]).iter_mut() {
            let range = part.block().range();
            part.gradient.copy_from_slice(&groups[0].gradient[range.clone()]);
            for group in &groups[1..] {
                (kernels.add_scaled)(E::from_f64(1.0), &group.gradient[range.clone()], &mut part.gradient);
            }
            part.step(self.options.optimiser, kernels, step.number, step.rate, self.options.decay);
        }
    }

    /// The errors of one share of the samples that are watched.
    fn evaluate(&self, index: usize, thread: usize) {
        let mut memory = self.memory(thread);
        let ThreadMemory { weights, evaluation, .. } = &mut *memory;
        let mut errors = |samples: &Samples<E>| {
            let tiles = samples.len().div_ceil(TILE);
            let range = tiles * index / GROUPS * TILE..(tiles * (index + 1) / GROUPS * TILE).min(samples.len());
            self.torque.squared_errors(weights, evaluation, samples, range)
        };
        let errors = self.data.watched().map(|samples| samples.map_or((0.0, 0.0), &mut errors));
        write(&self.groups[index]).errors = errors;
    }
}

/// Cuts the blocks into as many shares of about equal cost as there are groups.
fn share_parts<E: Element>(layout: &Layout, optimiser: Optimiser, weights: &[E]) -> Vec<Vec<Part<E>>> {
    let mut parts: Vec<Part<E>> = layout.blocks().iter().map(|block| Part::new(optimiser, block, weights)).collect();
    parts.sort_by_key(|part| std::cmp::Reverse(part.cost()));
    let mut shares: Vec<(usize, Vec<Part<E>>)> = (0..GROUPS).map(|_| (0, Vec::new())).collect();
    for part in parts {
        if let Some(least) = shares.iter_mut().min_by_key(|share| share.0) {
            least.0 += part.cost();
            least.1.push(part);
        }
    }
    shares.into_iter().map(|share| share.1).collect()
}

fn first_weights<E: Element>(layout: &Layout, seed: u64, begin: Begin) -> Buffer<E> {
    let mut weights = Buffer::from_slice(&draw_weights::<E>(layout, &mut ChaCha8Rng::seed_from_u64(seed)));
    match begin {
        Begin::Fresh => {}
        Begin::Warm(model) => model.copy_common(layout, &mut weights),
        Begin::Resume(checkpoint) => {
            for block in layout.blocks() {
                let values = checkpoint.weights.get(&block.name).map_or(&[][..], Vec::as_slice);
                layout.write(block, values, &mut weights);
            }
        }
    }
    weights
}

/// The course of a run, as its leader sees it.
struct Run<'e, 'a, E: Element> {
    engine: &'e Engine<'a, E>,
    epoch: u64,
    step: u64,
    first_loss: Option<f64>,
    /// Mean loss of the steps of this epoch so far, as a share of the whole epoch.
    epoch_loss: f64,
    best_error: f64,
    best: Buffer<E>,
    history: Vec<Epoch>,
    began: Instant,
    epoch_began: Instant,
    last_report: Instant,
    /// Seconds that earlier parts of the run took.
    before_s: f64,
}

impl<'e, 'a, E: Element> Run<'e, 'a, E> {
    fn new(engine: &'e Engine<'a, E>, begin: Begin) -> Self {
        let mut best = Buffer::zeros(engine.program.layout().size());
        engine.copy_weights(&mut best);
        let now = Instant::now();
        let mut run = Run {
            engine,
            epoch: 0,
            step: 0,
            first_loss: None,
            epoch_loss: 0.0,
            best_error: f64::INFINITY,
            best,
            history: Vec::new(),
            began: now,
            epoch_began: now,
            last_report: now,
            before_s: 0.0,
        };
        if let Begin::Resume(checkpoint) = begin {
            (run.epoch, run.step, run.epoch_loss) = (checkpoint.epoch, checkpoint.step, checkpoint.epoch_loss);
            (run.first_loss, run.best_error) = (checkpoint.first_loss, checkpoint.best_error.unwrap_or(f64::INFINITY));
            run.history.clone_from(&checkpoint.history);
            run.before_s = run.history.last().map_or(0.0, |epoch| epoch.elapsed_s);
            checkpoint.model.copy_common(engine.program.layout(), &mut run.best);
        }
        run
    }

    fn epochs(&mut self, team: &mut Team, monitor: &Monitor, keep: &mut Keep) -> Ending {
        let engine = self.engine;
        let (epochs, batch, samples) = (engine.options.epochs, engine.options.batch, engine.data.train.len());
        let batches = samples / batch;
        while self.epoch < epochs {
            self.epoch_began = Instant::now();
            write(&engine.step).order = data::order(samples, engine.options.seed, self.epoch);
            // A resumed run goes on in the middle of its epoch.
            let first = (self.step - self.epoch * batches as u64) as usize;
            for index in first..batches {
                match self.one_step(team, index * batch, epochs * batches as u64) {
                    Ok(loss) => self.epoch_loss += loss / batches as f64,
                    Err(reason) => return Ending::Failed(reason),
                }
                let asked = Instant::now();
                let answer = self.report(monitor, (index + 1) as f64 / batches as f64);
                // A pause is no time of training.
                let waited = asked.elapsed();
                self.began += waited;
                self.epoch_began += waited;
                if let Err(stopped) = answer {
                    return Ending::Stopped(stopped.reason);
                }
            }
            self.epoch += 1;
            let samples_per_s = ((batches - first) * batch) as f64 / self.epoch_began.elapsed().as_secs_f64();
            let epoch = self.close_epoch(team, samples_per_s);
            monitor.tell(Event::Epoch(epoch));
            keep(&|| self.checkpoint());
            if epoch.validation.is_some_and(|error| engine.options.goal.is_some_and(|goal| error <= goal)) {
                return Ending::GoalReached;
            }
        }
        Ending::Finished
    }

    /// One step on the batch from `first` on. Returns its loss.
    fn one_step(&mut self, team: &mut Team, first: usize, steps: u64) -> Result<f64, String> {
        let engine = self.engine;
        let options = engine.options;
        {
            let mut step = write(&engine.step);
            step.first = first;
            step.number = self.step + 1;
            step.rate = options.rate * options.schedule.factor(self.step, steps);
        }
        engine.run(team, GRADIENT);
        let loss: f64 = engine.groups.iter().map(|group| read(group).loss).sum();
        let limit = EXPLOSION * *self.first_loss.get_or_insert(loss);
        let at = format!("in epoch {}", self.epoch + 1);
        if !loss.is_finite() {
            return Err(format!("the loss is not a number {at}: choose a smaller learning rate"));
        }
        if loss > limit {
            return Err(format!("the loss explodes {at}: choose a smaller learning rate"));
        }
        if first == 0 && engine.groups.iter().all(|group| read(group).gradient.iter().all(|slope| *slope == E::ZERO)) {
            return Err(format!(
                "the gradient is exactly zero {at}: the model can't learn from these data as it stands"
            ));
        }
        engine.run(team, UPDATE);
        engine.updates.fetch_add(1, Ordering::Release);
        self.step += 1;
        Ok(loss)
    }

    fn report(&mut self, monitor: &Monitor, share: f64) -> Result<(), crate::progress::Stopped> {
        if self.last_report.elapsed() < REPORT_EVERY {
            return monitor.check();
        }
        self.last_report = Instant::now();
        let epochs = self.engine.options.epochs;
        let mut activity = format!("epoch {} of {epochs}", self.epoch + 1);
        if let Some(error) = self.history.last().and_then(|epoch| epoch.validation) {
            activity += &format!(", validation nMSE {error:.1e}");
        }
        monitor.report(((self.epoch as f64 + share) / epochs as f64) as f32, &activity)
    }

    /// Measures, keeps the best, and remembers the epoch.
    fn close_epoch(&mut self, team: &mut Team, samples_per_s: f64) -> Epoch {
        let engine = self.engine;
        let loss = std::mem::take(&mut self.epoch_loss);
        let [validation, held_out] = self.watched_errors(team);
        let elapsed_s = self.before_s + self.began.elapsed().as_secs_f64();
        let left = (engine.options.epochs - self.epoch) as f64;
        let epoch = Epoch {
            epoch: self.epoch,
            epochs: engine.options.epochs,
            loss,
            validation,
            held_out,
            rate: read(&engine.step).rate,
            samples_per_s,
            elapsed_s,
            remaining_s: elapsed_s / self.epoch as f64 * left,
        };
        if epoch.deciding_error() < self.best_error {
            self.best_error = epoch.deciding_error();
            engine.copy_weights(&mut self.best);
        }
        self.history.push(epoch);
        epoch
    }

    /// nMSE of the validation samples and of the held-out samples, as far as there are any.
    fn watched_errors(&self, team: &mut Team) -> [Option<f64>; 2] {
        let engine = self.engine;
        let watched = engine.data.watched();
        if watched.iter().any(Option::is_some) {
            engine.run(team, EVALUATE);
        }
        [0, 1].map(|which| {
            let add = |sum: (f64, f64), group: &RwLock<Group<E>>| {
                let errors = read(group).errors[which];
                (sum.0 + errors.0, sum.1 + errors.1)
            };
            let (error, size) = engine.groups.iter().fold((0.0, 0.0), add);
            watched[which].map(|_| error / size.max(f64::MIN_POSITIVE))
        })
    }

    fn outcome(self, ending: Ending) -> Outcome {
        let checkpoint = self.checkpoint();
        Outcome { model: checkpoint.model.clone(), ending, history: self.history, checkpoint }
    }

    fn checkpoint(&self) -> Checkpoint {
        let engine = self.engine;
        let layout = engine.program.layout();
        let states = engine.parts.iter().flat_map(|share| {
            let share = read(share);
            let state = |part: &Part<E>| {
                let values = part.state().into_iter().map(Element::to_f64).collect();
                (part.block().name.clone(), values)
            };
            share.iter().map(state).collect::<Vec<_>>()
        });
        let mut weights = Buffer::zeros(layout.size());
        engine.copy_weights(&mut weights);
        Checkpoint {
            options: engine.options.clone(),
            data: engine.mark.clone(),
            weights: LearnedModel::new(engine.architecture.clone(), layout, &weights).weights,
            model: LearnedModel::new(engine.architecture.clone(), layout, &self.best),
            states: states.collect(),
            epoch: self.epoch,
            step: self.step,
            first_loss: self.first_loss,
            epoch_loss: self.epoch_loss,
            best_error: self.best_error.is_finite().then_some(self.best_error),
            history: self.history.clone(),
        }
    }
}
