//! Runs the cells of an experiment that the store lacks.

use std::path::Path;
use std::str::FromStr;
use std::sync::Arc;
use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::cell::Cell;
use super::file::{Blocks, Effects, Runs, Source, TestSet};
use super::metrics::{Errors, measure};
use super::store::{Claim, Owner, Store};
use super::{Experiment, ExperimentError, cell};
use crate::arm::Arm;
use crate::diagnosis::diagnose;
use crate::effect::place::Place;
use crate::model::learned::LearnedTerm;
use crate::model::{self, Fitted, Model, Preset, Term};
use crate::progress::{Event, Monitor};
use crate::recording::read::read;
use crate::recording::split::Split;
use crate::recording::{Recording, Trajectory};
use crate::simulation::simulate;
use crate::training::{self, Ending};

/// First weights of the members of an ensemble: those of one seed must not be those of another.
const SEEDS_OF_A_MEMBER: u64 = 1_000;

/// Which cells a process takes: every n-th, so that n processes take all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// Counted from 1.
    number: usize,
    of: usize,
}

impl Default for Shard {
    fn default() -> Self {
        Shard { number: 1, of: 1 }
    }
}

impl Shard {
    /// Its share of all cells. They come seed after seed, and each seed is dealt from another shard on: else with as many shards as
    /// models one would get the dearest model at every seed.
    fn cells(self, all: Vec<Cell>) -> Vec<Cell> {
        let is_own = |(number, cell): &(usize, Cell)| (number + cell.seed as usize) % self.of == self.number - 1;
        all.into_iter().enumerate().filter(is_own).map(|(_, cell)| cell).collect()
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').map(|(number, of)| (number.parse(), of.parse()));
        match numbers {
            Some((Ok(number), Ok(of))) if (1..=of).contains(&number) => Ok(Shard { number, of }),
            _ => Err(format!("`{text}` is not a shard: write 2/5 for the second of five (1/5 to 5/5)")),
        }
    }
}

/// How a cell was trained.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrainingRecord {
    /// Terms of the model.
    pub terms: Vec<String>,
    /// Effects that the diagnosis named, if it was asked.
    pub named: Vec<String>,
    /// Its answer in a word.
    pub verdict: Option<String>,
    /// Wall-clock time of all members \[s\].
    pub seconds: f64,
}

/// What stands in the store for a cell.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum State {
    /// All of it.
    Done,
    /// Somebody works on it.
    Running(Owner),
    /// It could not be done, for this reason; a new run tries again.
    Failed(String),
    /// It was done, but a file of it is damaged; a new run does it again.
    Damaged(String),
    /// Nothing, or only a part.
    Open,
}

/// What a run did.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Report {
    /// Cells that were there before.
    pub found: usize,
    /// Cells that it did.
    pub done: usize,
    /// Cells that others are doing.
    pub elsewhere: usize,
    /// Cells that could not be done: model, seed, reason.
    pub failed: Vec<(String, u64, String)>,
    /// Files of finished cells that were damaged, and what is wrong with them; their cells were done again.
    pub damaged: Vec<String>,
}

/// Name of a test set's file.
fn test_file(key: &str) -> String {
    format!("test-{key}.json")
}

fn model_file(member: u64) -> String {
    format!("model-{}", member + 1)
}

const TRAINING: &str = "training.json";
const FAILED: &str = "failed.json";

/// Where a cell stands.
///
/// # Errors
/// [`ExperimentError`] if the store can't be read.
pub fn state(store: &Store, cell: &Cell) -> Result<State, ExperimentError> {
    let Standing { is_done, damaged } = standing(store, cell)?;
    if is_done {
        return Ok(State::Done);
    }
    if let Some(owner) = store.owner(&cell.key)? {
        return Ok(State::Running(owner));
    }
    if let Some((_, problem)) = damaged.into_iter().next() {
        return Ok(State::Damaged(problem));
    }
    Ok(store.json(&cell.key, FAILED)?.map_or(State::Open, State::Failed))
}

/// What the store has of a cell.
struct Standing {
    /// Whether its results are all there, and whole.
    is_done: bool,
    /// Files that are there, but are not what they should be, and what is wrong with them.
    damaged: Vec<(String, String)>,
}

/// Looks at the results of a cell themselves: that a file is there says nothing of what a full disk has left in it.
fn standing(store: &Store, cell: &Cell) -> Result<Standing, ExperimentError> {
    let tests = cell.tests.iter().map(|(_, key)| test_file(key));
    let is_there = |file: &String| store.json::<Errors>(&cell.key, file).map(|errors| errors.is_some());
    let mut seen: Vec<_> = tests.map(|file| (is_there(&file), file)).collect();
    // Cells of before had no such record.
    seen.push((training_record(store, cell).map(|_| true), TRAINING.to_owned()));
    let models = (0..cell.inputs.members).map(|number| (member(cell, store, number).map(|_| true), model_file(number)));
    seen.extend(models);
    let mut standing = Standing { is_done: true, damaged: Vec::new() };
    for (is_whole, file) in seen {
        match is_whole {
            Err(error @ ExperimentError::Damaged { .. }) => standing.damaged.push((file, error.to_string())),
            is_whole => standing.is_done &= is_whole?,
        }
    }
    standing.is_done &= standing.damaged.is_empty();
    Ok(standing)
}

/// Errors of a cell on each of its test sets; `None` for those that are not there yet.
///
/// # Errors
/// [`ExperimentError`] if the store can't be read.
pub fn errors(store: &Store, cell: &Cell) -> Result<Vec<Option<Errors>>, ExperimentError> {
    cell.tests.iter().map(|(_, key)| store.json(&cell.key, &test_file(key))).collect()
}

/// How a cell was trained, if it was.
///
/// # Errors
/// [`ExperimentError`] if the store can't be read.
pub fn training_record(store: &Store, cell: &Cell) -> Result<Option<TrainingRecord>, ExperimentError> {
    store.json(&cell.key, TRAINING)
}

/// Runs the cells of a shard that the store lacks and that nobody else works on. Every cell that is done is told.
///
/// # Errors
/// [`ExperimentError`] if it can't begin, or was stopped; cells that can't be done are in the report.
pub fn run(
    experiment: &Experiment,
    store: &Store,
    data: Option<&Path>,
    shard: Shard,
    monitor: &Monitor,
) -> Result<Report, ExperimentError> {
    let cells: Vec<Cell> = shard.cells(cell::plan(experiment, data)?);
    let (mut report, begin) = (Report::default(), Instant::now());
    for (index, cell) in cells.iter().enumerate() {
        if standing(store, cell)?.is_done {
            report.found += 1;
            continue;
        }
        let title = format!("cell {} of {}: {}, seed {}", index + 1, cells.len(), cell.model.name, cell.seed + 1);
        monitor.report(index as f32 / cells.len() as f32, &title)?;
        let Some(claim) = store.claim(&cell.key)? else {
            report.elsewhere += 1;
            continue;
        };
        // It may have been finished between the two looks.
        let Standing { is_done, damaged } = standing(store, cell)?;
        if is_done {
            report.found += 1;
            continue;
        }
        for (file, problem) in damaged {
            store.remove(&cell.key, &file)?;
            report.damaged.push(problem);
        }
        let part =
            part(monitor, Arc::new(claim), [index, report.found + report.elsewhere, cells.len()], begin, title.clone());
        match run_cell(cell, store, data, &part, &mut report.damaged) {
            Ok(()) => {
                store.remove(&cell.key, FAILED)?;
                report.done += 1;
                monitor.tell(Event::Done(title));
            }
            Err(error) if error.is_stop() => return Err(error),
            Err(error @ ExperimentError::Store { .. }) => return Err(error),
            Err(error) => {
                store.write_json(&cell.key, FAILED, &error.to_string())?;
                report.failed.push((cell.model.name.clone(), cell.seed, error.to_string()));
            }
        }
    }
    Ok(report)
}

/// The line of one cell: its reports keep the claim alive and are passed on, with the time that is left.
fn part(
    monitor: &Monitor,
    claim: Arc<Claim>,
    [index, skipped, count]: [usize; 3],
    begin: Instant,
    title: String,
) -> Monitor {
    let whole = monitor.clone();
    monitor.of_part(move |event| {
        claim.beat();
        // Epochs and findings of a cell concern nobody.
        let Event::Progress(progress) = event else { return Ok(()) };
        let done = (index - skipped) as f64 + f64::from(progress.fraction);
        let left = begin.elapsed().as_secs_f64() / done.max(0.02)
            * (count - skipped) as f64
            * (1.0 - done / (count - skipped) as f64);
        let share = (index as f32 + progress.fraction) / count as f32;
        whole.report(share, &format!("{title}, {}, about {} left", progress.activity, duration_text(left)))
    })
}

/// `40 s`, `12 min` or `2.5 h`.
pub fn duration_text(seconds: f64) -> String {
    match seconds {
        s if s < 90.0 => format!("{s:.0} s"),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

fn run_cell(
    cell: &Cell,
    store: &Store,
    data: Option<&Path>,
    monitor: &Monitor,
    damaged: &mut Vec<String>,
) -> Result<(), ExperimentError> {
    store.write_json(&cell.key, "inputs.json", &cell.inputs)?;
    let members = match trained_members(cell, store) {
        Ok(Some(members)) => members,
        Ok(None) => train_members(cell, store, data, monitor)?,
        Err(error @ ExperimentError::Damaged { .. }) => {
            damaged.push(error.to_string());
            train_members(cell, store, data, monitor)?
        }
        Err(error) => return Err(error),
    };
    for (set, key) in &cell.tests {
        if !store.has(&cell.key, &test_file(key)) {
            let recording = load(&set.source, data, monitor)?;
            let errors = measure(&members, &recording, exact_arm(set), monitor)?;
            if !errors.is_finite() {
                return Err(ExperimentError::NotFinite(set.name.clone()));
            }
            store.write_json(&cell.key, &test_file(key), &errors)?;
        }
    }
    Ok(())
}

/// The models of a cell, if they were trained.
pub(super) fn trained_members(cell: &Cell, store: &Store) -> Result<Option<Vec<Fitted>>, ExperimentError> {
    if !store.has(&cell.key, TRAINING) {
        return Ok(None);
    }
    (0..cell.inputs.members).map(|number| member(cell, store, number)).collect()
}

/// A model of a cell, if it is there.
fn member(cell: &Cell, store: &Store, number: u64) -> Result<Option<Fitted>, ExperimentError> {
    let file = model_file(number);
    let Some(bytes) = store.bytes(&cell.key, &file)? else { return Ok(None) };
    training::fit::from_bytes(&bytes).map(Some).map_err(|problem| store.damaged(&cell.key, &file, &problem))
}

fn train_members(
    cell: &Cell,
    store: &Store,
    data: Option<&Path>,
    monitor: &Monitor,
) -> Result<Vec<Fitted>, ExperimentError> {
    let begin = Instant::now();
    let recording = load(&cell.inputs.source, data, monitor)?;
    let split = Split { train: recording.runs().collect(), ..Split::default() };
    let (model, named, verdict) = model_of(cell, &recording, &split, monitor)?;
    let mut members = Vec::new();
    for number in 0..cell.inputs.members {
        let fitted = if let Some(plan) = &cell.inputs.plan {
            let mut plan = plan.clone();
            plan.options.seed += SEEDS_OF_A_MEMBER * number;
            let count = cell.inputs.members as f32;
            let part = monitor.part(number as f32 / count..(number + 1) as f32 / count);
            let trained = training::fit::fit(&model, &recording, &split, &plan, None, &part, &mut |_| {})?;
            match trained.ending {
                Ending::Finished | Ending::GoalReached => trained.fitted,
                Ending::Stopped(reason) => return Err(crate::progress::Stopped { reason }.into()),
                Ending::Failed(reason) => return Err(ExperimentError::TrainingFailed(reason)),
            }
        } else {
            model::fit(&model, &recording, &split, monitor)?
        };
        store.write(&cell.key, &model_file(number), &training::fit::to_bytes(&fitted)?)?;
        members.push(fitted);
    }
    let terms = model.terms.iter().map(Term::label).collect();
    let record = TrainingRecord { terms, named, verdict, seconds: begin.elapsed().as_secs_f64() };
    store.write_json(&cell.key, TRAINING, &record)?;
    Ok(members)
}

/// The model of a cell with all its effects; what the diagnosis named, and its verdict, if it was asked.
fn model_of(
    cell: &Cell,
    recording: &Recording,
    split: &Split,
    monitor: &Monitor,
) -> Result<(Model, Vec<String>, Option<String>), ExperimentError> {
    let mut model = match cell.inputs.preset {
        Some(preset) => preset.model(recording)?,
        None => Model { terms: cell.inputs.terms.clone() },
    };
    for term in &mut model.terms {
        if let Term::Learned(
            LearnedTerm::StructuredLagrangian { layers, .. }
            | LearnedTerm::BlackBoxLagrangian { layers }
            | LearnedTerm::FeedForward { layers, .. },
        ) = term
        {
            layers.hidden = cell.inputs.hidden.as_ref().unwrap_or(&layers.hidden).clone();
            layers.activation = cell.inputs.activation.unwrap_or(layers.activation);
        }
    }
    let joints = recording.joint_count();
    match &cell.inputs.effects {
        Effects::Named(names) => {
            for name in names {
                let place: Place = name.parse()?;
                model = model.with_effect(place.effect, &place.joints(joints)?)?;
            }
            Ok((model, Vec::new(), None))
        }
        Effects::Diagnosed => {
            // The diagnosis needs held-out runs of its own, taken from the training data.
            let split = if split.held_out.is_empty() { Split::automatic(recording) } else { split.clone() };
            let body = model::fit(&Preset::RigidBody.model(recording)?, recording, &split, monitor)?;
            let report = diagnose(&body, recording, &split, monitor)?;
            let mut named = Vec::new();
            for effect in &report.effects {
                model = model.with_effect(effect.effect, &effect.joints)?;
                let joints: Vec<String> = effect.joints.iter().map(|joint| (joint + 1).to_string()).collect();
                named.push(format!("{}@{}", effect.effect.id, joints.join(",")));
            }
            Ok((model, named, Some(format!("{:?}", report.verdict))))
        }
    }
}

/// The arm whose parts of the torque are known at the very states that were measured.
pub(super) fn exact_arm(set: &TestSet) -> Option<&Arm> {
    let Source::Simulated(scenarios) = &set.source else { return None };
    let first = scenarios.first()?;
    let is_exact = scenarios.iter().all(|other| other.arm == first.arm && other.encoder_resolution.is_none());
    is_exact.then_some(&first.arm)
}

/// Simulates or reads data, and puts them together as one recording.
pub(super) fn load(source: &Source, data: Option<&Path>, monitor: &Monitor) -> Result<Recording, ExperimentError> {
    let parts: Vec<Recording> = match source {
        Source::Simulated(scenarios) => {
            scenarios.iter().map(|scenario| simulate(scenario, monitor)).collect::<Result<_, _>>()?
        }
        Source::Recorded(all, options) => {
            let folder = data.unwrap_or(Path::new("."));
            let part = |own: &Runs| -> Result<Recording, ExperimentError> {
                let Runs { file, runs, skip, blocks } = own;
                let paths: Vec<String> =
                    own.paths(folder).iter().map(|path| path.to_string_lossy().into_owned()).collect();
                let mut recording = read(&[paths.join("+").into()], options, monitor)?.recording;
                let count = recording.trajectories.len();
                let [first, last] = runs.unwrap_or([0, count - 1]);
                if first > last || last >= count {
                    return Err(ExperimentError::NoSuchRuns { file: file.clone(), runs: count, first, last });
                }
                recording.trajectories = recording.trajectories[first..=last]
                    .iter()
                    .filter(|run| run.len() > *skip)
                    .map(|run| run.slice(*skip..run.len()))
                    .collect();
                if let Some(blocks) = blocks {
                    recording.trajectories = self::blocks(&recording, *blocks);
                }
                Ok(recording)
            };
            all.iter().map(part).collect::<Result<_, _>>()?
        }
    };
    let count = parts.len();
    let mut parts = parts.into_iter();
    let Some(mut whole) = parts.next() else { return Err(ExperimentError::NoData { files: String::new() }) };
    for part in parts {
        whole.trajectories.extend(part.trajectories);
    }
    if count > 1 {
        for (number, run) in whole.trajectories.iter_mut().enumerate() {
            run.name = format!("run {}", number + 1);
        }
    }
    Ok(whole)
}

/// The time blocks of a log that train, or those that are held out, each as a run of its own.
fn blocks(recording: &Recording, which: Blocks) -> Vec<Trajectory> {
    let split = Split::automatic(recording);
    let segments = match which {
        Blocks::Training => split.train,
        Blocks::HeldOut => split.held_out,
    };
    segments.into_iter().map(|part| recording.trajectories[part.trajectory].slice(part.samples)).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn shards_are_counted_from_one() {
        assert_eq!("2/5".parse(), Ok(Shard { number: 2, of: 5 }));
        for wrong in ["0/5", "6/5", "2", "a/b", "1/0", ""] {
            assert!(wrong.parse::<Shard>().unwrap_err().contains("write 2/5"), "{wrong}");
        }
    }

    /// With as many shards as models, each has a cell of every seed, and of other models.
    #[test]
    fn shards_share_the_dear_models() {
        let experiment = crate::experiment::catalogue::find("table-2").unwrap();
        let all = cell::plan(&experiment, None).unwrap();
        let of = experiment.models.len();
        let mut count = 0;
        for number in 1..=of {
            let cells = Shard { number, of }.cells(all.clone());
            let models: BTreeSet<&str> = cells.iter().map(|cell| cell.model.name.as_str()).collect();
            assert_eq!(models.len() as u64, experiment.seeds);
            count += cells.len();
        }
        assert_eq!(count, all.len());
    }

    #[test]
    fn durations_are_told_in_their_unit() {
        assert_eq!([12.4, 300.0, 9000.0].map(duration_text), ["12 s", "5 min", "2.5 h"]);
    }
}
