//! A cell is a model of an experiment at one seed: what it needs, and the key by which its results are found again.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;
use sha2::{Digest, Sha256};

use super::file::{Effects, Model, Runs, Source, TestSet};
use super::{Experiment, ExperimentError, store};
use crate::model::{Preset, Term};
use crate::network::Activation;
use crate::training::fit::Plan;

/// To be raised when the same inputs give other results: a new optimiser step, another metric.
const VERSION: u32 = 1;
/// The same for the answers of the diagnosis, so that models without it need no new training.
const DIAGNOSIS_VERSION: u32 = 5;
/// The same for how networks are trained, so that what is solved for stays as it is.
const TRAINING_VERSION: u32 = 3;
/// The same for what hidden effects do to the torque of a simulation.
const EFFECTS_VERSION: u32 = 2;
/// Letters of a key: enough that no two of them ever meet.
const KEY_LENGTH: usize = 20;

/// One model at one seed.
#[derive(Debug, Clone)]
pub struct Cell {
    /// The model.
    pub model: Model,
    /// The seed, from 0.
    pub seed: u64,
    /// Name of its folder: the hash of all that decides what is learned.
    pub key: String,
    /// The same for each test set, in the order of the experiment.
    pub tests: Vec<(TestSet, String)>,
    pub(super) inputs: Inputs,
}

/// All that decides what is learned.
#[derive(Debug, Clone, Serialize)]
pub struct Inputs {
    version: u32,
    pub(super) source: Source,
    /// Hashes of the recordings by their names; what else decides about simulated ones.
    contents: BTreeMap<String, String>,
    pub(super) preset: Option<Preset>,
    pub(super) terms: Vec<Term>,
    pub(super) effects: Effects,
    #[serde(skip_serializing_if = "Option::is_none")]
    diagnosis: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    training: Option<u32>,
    pub(super) hidden: Option<Vec<usize>>,
    pub(super) activation: Option<Activation>,
    /// What is solved for has none, so that all its seeds on the same recordings are one cell.
    pub(super) plan: Option<Plan>,
    pub(super) members: u64,
}

/// The cells of an experiment, seed after seed, so that every model has a first result early. `data` is where recordings are.
///
/// # Errors
/// [`ExperimentError`] if recordings are needed and missing.
pub fn plan(experiment: &Experiment, data: Option<&Path>) -> Result<Vec<Cell>, ExperimentError> {
    let mut known = BTreeMap::new();
    let mut cells = Vec::new();
    for seed in 0..experiment.seeds {
        let source = experiment.training_source(seed)?;
        let contents = contents(&source, data, &mut known)?;
        let mut tests = Vec::new();
        for set in experiment.test_sets(seed)? {
            let contents = self::contents(&set.source, data, &mut known)?;
            let key = key(&(VERSION, &set.source, contents));
            tests.push((set, key));
        }
        for model in &experiment.models {
            let (hidden, activation) = experiment.layers_of(model);
            let inputs = Inputs {
                version: VERSION,
                source: source.clone(),
                contents: contents.clone(),
                preset: model.preset,
                terms: model.terms.clone(),
                effects: model.effects.clone(),
                diagnosis: (model.effects == Effects::Diagnosed).then_some(DIAGNOSIS_VERSION),
                training: model.is_trained().then_some(TRAINING_VERSION),
                hidden: hidden.cloned(),
                activation,
                plan: model.is_trained().then(|| experiment.plan_of(model, seed)),
                members: model.members,
            };
            cells.push(Cell { model: model.clone(), seed, key: key(&inputs), tests: tests.clone(), inputs });
        }
    }
    Ok(cells)
}

/// The cells of a model, each once: what is solved for on recordings is the same cell at every seed, and has no spread.
pub fn of_model<'a>(cells: &'a [Cell], model: &str) -> Vec<&'a Cell> {
    let mut own: Vec<&Cell> = cells.iter().filter(|cell| cell.model.name == model).collect();
    own.dedup_by(|one, other| one.key == other.key);
    own
}

/// Hashes of the files of a source, each of which is read once, or the version of what is simulated.
fn contents(
    source: &Source,
    data: Option<&Path>,
    known: &mut BTreeMap<String, String>,
) -> Result<BTreeMap<String, String>, ExperimentError> {
    let mut contents = BTreeMap::new();
    let runs = match source {
        Source::Recorded(runs, _) => runs,
        Source::Simulated(scenarios) => {
            if scenarios.iter().any(|scenario| !scenario.effects.is_empty()) {
                contents.insert("version of the effects".to_owned(), EFFECTS_VERSION.to_string());
            }
            return Ok(contents);
        }
    };
    for own @ Runs { file, .. } in runs {
        if !known.contains_key(file) {
            let Some(folder) = data else {
                let files = runs.iter().map(|runs| runs.file.as_str()).collect::<Vec<_>>().join(", ");
                return Err(ExperimentError::NoData { files });
            };
            let paths = own.paths(folder);
            let bytes = paths.iter().map(|path| store::read(path)).collect::<Result<Vec<_>, _>>()?;
            known.insert(file.clone(), hash(&bytes.concat()));
        }
        contents.insert(file.clone(), known[file].clone());
    }
    Ok(contents)
}

fn key(value: &impl Serialize) -> String {
    hash(&serde_json::to_vec(value).expect("numbers and texts always have a JSON form"))
}

fn hash(bytes: &[u8]) -> String {
    let digest = Sha256::digest(bytes);
    let letters: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
    letters[..KEY_LENGTH].to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_solved_for_on_recordings_is_one_cell_at_all_seeds() {
        let text = r#"
title = "two logs"
description = "one to learn from, one to test on"
seeds = 5
[data]
recordings = [{ file = "a.csv" }]
[[model]]
name = "solved"
preset = "rigid-body"
[[model]]
name = "trained"
preset = "ff-nn"
[[test]]
name = "other"
recordings = [{ file = "b.csv" }]
"#;
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.csv", "b.csv"] {
            std::fs::write(folder.path().join(name), name).unwrap();
        }
        let cells = plan(&Experiment::parse("two", text).unwrap(), Some(folder.path())).unwrap();
        assert_eq!(cells.len(), 10);
        assert_eq!((of_model(&cells, "solved").len(), of_model(&cells, "trained").len()), (1, 5));
    }
}
