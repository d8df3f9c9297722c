//! What an experiment is, as its file says it. Keys that nobody knows and values that can't be are errors with their line.

mod check;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Deserializer, Serialize};
use toml::{Spanned, Table, Value};

use super::ExperimentError;
use crate::model::learned::Features;
use crate::model::{Preset, Term};
use crate::network::Activation;
use crate::recording::catalogue;
use crate::recording::read::ReadOptions;
use crate::simulation::Scenario;
use crate::training::fit::Plan;
use crate::training::optimiser::Optimiser;
use crate::training::schedule::Schedule;
use crate::training::{Options, Precision, Recipe};

/// An experiment.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Experiment {
    /// Its name: that of its file.
    #[serde(skip)]
    pub name: String,
    /// What it is, for lists.
    pub title: String,
    /// What it asks, and what to know before trusting the answer.
    pub description: String,
    /// The paper's table (2, 3 or 4) whose values stand beside ours.
    #[serde(default, deserialize_with = "paper_table")]
    pub paper_table: Option<u8>,
    /// How many seeds; each has training data, test data and first weights of its own.
    #[serde(deserialize_with = "seeds")]
    pub seeds: u64,
    /// What is learned from.
    data: Data,
    /// How all models are trained, where they do not say otherwise.
    #[serde(default)]
    training: Training,
    /// The rows.
    #[serde(rename = "model")]
    pub models: Vec<Model>,
    /// Where the error is measured.
    #[serde(rename = "test", default)]
    tests: Vec<Spanned<Test>>,
    /// Series of test sets, for curves.
    #[serde(rename = "curve", default)]
    curves: Vec<Spanned<CurveOfTests>>,
    /// A small version.
    #[serde(default)]
    quick: Quick,
}

/// What is learned from: a simulation, or recordings.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Data {
    /// A [`Scenario`] without seed.
    simulation: Option<Spanned<Table>>,
    /// Changes of the simulation whose runs are put together: arms with different payloads, say.
    #[serde(default)]
    mixture: Vec<Table>,
    /// Recordings to learn from.
    #[serde(default)]
    recordings: Vec<Runs>,
    /// How recordings are read.
    #[serde(default)]
    read: ReadOptions,
    /// Name of one of the mappings that come with the program, instead of one under `read`.
    mapping: Option<Spanned<String>>,
}

/// Runs of one file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Runs {
    /// Its name in the folder of the data; `a.csv+b.csv` are two files that are read side by side.
    pub file: String,
    /// First and last run, counted from 0; all if not given.
    #[serde(default)]
    pub runs: Option<[usize; 2]>,
    /// Samples that are left out at the beginning of each run.
    #[serde(default)]
    pub skip: usize,
    /// For a log that has to serve both ends: only its training blocks, or only those that are held out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blocks: Option<Blocks>,
}

impl Runs {
    /// Its files in the folder of the data.
    pub fn paths(&self, folder: &Path) -> Vec<PathBuf> {
        self.file.split('+').map(|name| folder.join(name)).collect()
    }
}

/// Which time blocks of a log are taken: [`crate::recording::split::Split::automatic`] cuts them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Blocks {
    /// Four in five.
    Training,
    /// Every fifth.
    HeldOut,
}

/// How models are trained; what is not said is taken from the recipe.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Training {
    recipe: Option<Recipe>,
    epochs: Option<u64>,
    batch: Option<usize>,
    rate: Option<f64>,
    schedule: Option<Schedule>,
    optimiser: Option<Optimiser>,
    decay: Option<f64>,
    smoothness: Option<f64>,
    normalise: Option<bool>,
    features: Option<Features>,
    precision: Option<Precision>,
    hidden: Option<Vec<usize>>,
    activation: Option<Activation>,
}

/// One row of the table.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// Its name; that of the paper's model whose values stand beside it, if there is one.
    pub name: String,
    /// What is special about it, for the reader of the table.
    #[serde(default)]
    pub note: String,
    /// What it starts from.
    #[serde(default, deserialize_with = "preset")]
    pub preset: Option<Preset>,
    /// Or its terms, each by itself.
    #[serde(default)]
    pub terms: Vec<Term>,
    /// Effects that it has beside these.
    #[serde(default)]
    pub effects: Effects,
    /// How many networks, with other first weights, are trained; their mean is the model.
    #[serde(default = "one", deserialize_with = "members")]
    pub members: u64,
    #[serde(default)]
    training: Training,
}

impl Model {
    /// Whether it has networks, whose first weights depend on the seed.
    pub fn is_trained(&self) -> bool {
        let learned = self.terms.iter().any(|term| matches!(term, Term::Learned(_)));
        learned || matches!(self.preset, Some(Preset::Learned(_)))
    }

    /// What it is called in legends and tables: what it starts from as everywhere else, and what its name says beyond that, such as
    /// `structured DeLaN, named` of `structured-delan-named`.
    pub fn title(&self) -> String {
        let of_preset = |preset: Preset| Some((preset.title(), self.name.strip_prefix(preset.id())?));
        match self.preset.and_then(of_preset) {
            Some((title, "")) => title.to_owned(),
            Some((title, more)) if more.starts_with('-') => format!("{title}, {}", more[1..].replace('-', " ")),
            _ => self.name.clone(),
        }
    }
}

/// Effects of a model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum Effects {
    /// These, such as `coulomb-friction@1,2` (joints counted from 1; all joints without `@`).
    Named(Vec<String>),
    /// Those that the diagnosis names on the training data; none if it names none.
    Diagnosed,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Test {
    name: String,
    /// What differs from the training simulation: its keys, and `more_effects` that come to its effects.
    #[serde(default)]
    simulation: Table,
    /// Its own mixture; that of the training data if not given.
    mixture: Option<Vec<Table>>,
    #[serde(default)]
    recordings: Vec<Runs>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct CurveOfTests {
    name: String,
    /// The key of the simulation that changes, such as `speed_scale` or `motion.range`.
    key: String,
    /// What stands at the horizontal axis.
    axis: String,
    values: Vec<f64>,
    /// What differs from the training simulation beside it.
    #[serde(default)]
    simulation: Table,
    mixture: Option<Vec<Table>>,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Quick {
    seeds: Option<u64>,
    epochs: Option<u64>,
    /// Names of the models that it keeps; all if empty.
    #[serde(default)]
    models: Vec<String>,
    /// Names of the test sets that it keeps; all if empty. Curves are left out.
    #[serde(default)]
    tests: Vec<String>,
}

/// What data are made of, for one seed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum Source {
    /// Runs of these simulations.
    Simulated(Vec<Scenario>),
    /// Runs of these files.
    Recorded(Vec<Runs>, Box<ReadOptions>),
}

/// One test set.
#[derive(Debug, Clone, PartialEq)]
pub struct TestSet {
    /// Its name.
    pub name: String,
    /// The curve that it is a point of, if of one.
    pub point: Option<Point>,
    /// Its data.
    pub source: Source,
}

/// A point of a curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Name of the curve.
    pub curve: String,
    /// Label of the horizontal axis.
    pub axis: String,
    /// Where on it.
    pub x: f64,
}

/// In a change of the simulation: effects beside those of the training simulation.
const MORE_EFFECTS: &str = "more_effects";
/// Most seeds of an experiment.
const MOST_SEEDS: u64 = 1000;
/// The parts of a mixture have seeds of their own, so many apart: more than an experiment may have seeds.
const SEEDS_OF_A_PART: u64 = 10_000;
/// So many parts of training data have their seeds in a row, then as many of test data, and so on: the two never meet.
const PARTS_IN_A_ROW: u64 = 100;

/// What data are for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Use {
    Training,
    Test,
}

/// The random seed of a part of the data (from 0) at a seed of the experiment (from 0).
fn random_seed(purpose: Use, seed: u64, part: u64) -> u64 {
    let row = 2 * (part / PARTS_IN_A_ROW) + u64::from(purpose == Use::Test);
    let first = u64::from(purpose == Use::Training);
    (row * PARTS_IN_A_ROW + part % PARTS_IN_A_ROW) * SEEDS_OF_A_PART + first + seed
}

impl Experiment {
    /// Reads an experiment.
    ///
    /// # Errors
    /// [`ExperimentError::File`] says on which line what is wrong, and what is possible there.
    pub fn parse(name: &str, text: &str) -> Result<Experiment, ExperimentError> {
        let failed =
            |problem: String| ExperimentError::File { file: name.to_owned(), problem: problem.trim().to_owned() };
        let mut experiment: Experiment = toml::from_str(text).map_err(|error| failed(error.to_string()))?;
        name.clone_into(&mut experiment.name);
        experiment.use_mapping(text).map_err(failed)?;
        experiment.check(text).map_err(failed)?;
        Ok(experiment)
    }

    /// Puts the mapping that is named in place.
    fn use_mapping(&mut self, text: &str) -> Result<(), String> {
        let Some(name) = &self.data.mapping else { return Ok(()) };
        let place = check::line_at(text, name.span().start);
        if self.data.read.mapping.is_some() {
            return Err(place + "`mapping` and `read.mapping` both say how columns are mapped: keep one");
        }
        let spec = catalogue::mapping(name.get_ref()).map_err(|problem| place + &problem.to_string())?;
        self.data.read.mapping = Some(spec);
        Ok(())
    }

    /// What the model of this name is called in legends and tables, and its place among all.
    pub fn called(&self, model: &str) -> (String, usize) {
        let place = self.models.iter().position(|own| own.name == model);
        place.map_or_else(|| (model.to_owned(), 0), |place| (self.models[place].title(), place))
    }

    /// Its small version.
    #[must_use]
    pub fn quick(&self) -> Experiment {
        let mut quick = self.clone();
        quick.seeds = self.quick.seeds.unwrap_or(self.seeds);
        if !self.quick.models.is_empty() {
            quick.models.retain(|model| self.quick.models.contains(&model.name));
        }
        if !self.quick.tests.is_empty() {
            quick.tests.retain(|test| self.quick.tests.contains(&test.get_ref().name));
            quick.curves.clear();
        }
        for model in &mut quick.models {
            model.training.epochs = self.quick.epochs.or(model.training.epochs);
        }
        quick
    }

    /// Only these models.
    ///
    /// # Errors
    /// [`ExperimentError::File`] if one of the names is that of no model.
    pub fn only(mut self, names: &[String]) -> Result<Experiment, ExperimentError> {
        if let Some(name) = names.iter().find(|name| self.models.iter().all(|model| model.name != **name)) {
            let known: Vec<&str> = self.models.iter().map(|model| model.name.as_str()).collect();
            let problem = format!("there is no model `{name}`; it has {}", known.join(", "));
            return Err(ExperimentError::File { file: self.name, problem });
        }
        if !names.is_empty() {
            self.models.retain(|model| names.contains(&model.name));
        }
        Ok(self)
    }

    /// Whether it needs recordings that do not come with the program.
    pub fn needs_data(&self) -> bool {
        !self.data.recordings.is_empty()
    }

    /// What a seed's models learn from.
    ///
    /// # Errors
    /// [`ExperimentError::File`] if the simulation is none, which [`Experiment::parse`] has ruled out.
    pub fn training_source(&self, seed: u64) -> Result<Source, ExperimentError> {
        let source = self.training_source_of(seed);
        source.map_err(|problem| ExperimentError::File { file: self.name.clone(), problem })
    }

    fn training_source_of(&self, seed: u64) -> Result<Source, String> {
        self.source(&Table::new(), None, &self.data.recordings, (Use::Training, seed))
    }

    /// Where a seed's models are measured.
    ///
    /// # Errors
    /// As [`Experiment::training_source`].
    pub fn test_sets(&self, seed: u64) -> Result<Vec<TestSet>, ExperimentError> {
        let failed = |problem| ExperimentError::File { file: self.name.clone(), problem };
        self.test_sets_of(seed).into_iter().map(|set| set.map_err(failed)).collect()
    }

    fn test_sets_of(&self, seed: u64) -> Vec<Result<TestSet, String>> {
        // All test sets of a seed have one random seed: a faster set travels the same paths.
        let seed = (Use::Test, seed);
        let test = |test: &Spanned<Test>| {
            let test = test.get_ref();
            let source = self.source(&test.simulation, test.mixture.as_deref(), &test.recordings, seed)?;
            Ok(TestSet { name: test.name.clone(), point: None, source })
        };
        let points = self.curves.iter().flat_map(|curve| {
            let curve = curve.get_ref();
            curve.values.iter().map(move |&x| {
                let mut change = curve.simulation.clone();
                set(&mut change, &curve.key, x)
                    .ok_or_else(|| format!("curve `{}`: its key `{}` leads nowhere", curve.name, curve.key))?;
                let source = self.source(&change, curve.mixture.as_deref(), &[], seed)?;
                let point = Point { curve: curve.name.clone(), axis: curve.axis.clone(), x };
                Ok(TestSet { name: format!("{} {x}", curve.name), point: Some(point), source })
            })
        });
        self.tests.iter().map(test).chain(points).collect()
    }

    /// The data with a change: of the simulation, or other recordings.
    fn source(
        &self,
        change: &Table,
        mixture: Option<&[Table]>,
        recordings: &[Runs],
        (purpose, seed): (Use, u64),
    ) -> Result<Source, String> {
        let Some(simulation) = &self.data.simulation else {
            return Ok(Source::Recorded(recordings.to_vec(), Box::new(self.data.read.clone())));
        };
        let unmixed = [Table::new()];
        let mixture = mixture.unwrap_or(if self.data.mixture.is_empty() { &unmixed } else { &self.data.mixture });
        let scenario = |(part, mixed): (usize, &Table)| {
            let mut table = simulation.get_ref().clone();
            merge(&mut table, change);
            merge(&mut table, mixed);
            add_effects(&mut table);
            let seed = random_seed(purpose, seed, part as u64);
            table.insert("seed".to_owned(), Value::Integer(i64::try_from(seed).map_err(|error| error.to_string())?));
            Scenario::deserialize(Value::Table(table)).map_err(|error| error.to_string().trim().to_owned())
        };
        Ok(Source::Simulated(mixture.iter().enumerate().map(scenario).collect::<Result<_, String>>()?))
    }

    /// How a model is trained; member and seed give its first weights.
    pub fn plan_of(&self, model: &Model, seed: u64) -> Plan {
        let of = |training: &Training| training.clone();
        let (own, common) = (of(&model.training), of(&self.training));
        let mut plan = Plan::of(self.recipe_of(model));
        let options = &mut plan.options;
        *options = Options {
            epochs: own.epochs.or(common.epochs).unwrap_or(options.epochs),
            batch: own.batch.or(common.batch).unwrap_or(options.batch),
            rate: own.rate.or(common.rate).unwrap_or(options.rate),
            schedule: own.schedule.or(common.schedule).unwrap_or(options.schedule),
            optimiser: own.optimiser.or(common.optimiser).unwrap_or(options.optimiser),
            decay: own.decay.or(common.decay).unwrap_or(options.decay),
            seed,
            ..options.clone()
        };
        plan.normalise = own.normalise.or(common.normalise).unwrap_or(plan.normalise);
        plan.features = own.features.or(common.features).or(plan.features);
        plan.precision = own.precision.or(common.precision).unwrap_or(plan.precision);
        plan.smoothness = own.smoothness.or(common.smoothness).unwrap_or(plan.smoothness);
        plan
    }

    /// Hidden layers and activation of a model's networks where the experiment states them; a preset has those of its recipe else,
    /// and terms that are written out their own.
    pub fn layers_of<'a>(&'a self, model: &'a Model) -> (Option<&'a Vec<usize>>, Option<Activation>) {
        let hidden = model.training.hidden.as_ref().or(self.training.hidden.as_ref());
        let usual = || model.preset.map(|_| self.recipe_of(model).layers().activation);
        (hidden, model.training.activation.or(self.training.activation).or_else(usual))
    }

    fn recipe_of(&self, model: &Model) -> Recipe {
        model.training.recipe.or(self.training.recipe).unwrap_or_default()
    }
}

/// Puts the values of `change` over those of `table`; tables are merged, everything else is replaced.
fn merge(table: &mut Table, change: &Table) {
    for (key, value) in change {
        match (table.get_mut(key), value) {
            (Some(Value::Table(old)), Value::Table(new)) => merge(old, new),
            _ => {
                table.insert(key.clone(), value.clone());
            }
        }
    }
}

/// Moves what stands under `more_effects` behind the `effects`.
fn add_effects(scenario: &mut Table) {
    let Some(Value::Array(more)) = scenario.remove(MORE_EFFECTS) else { return };
    if let Value::Array(effects) = scenario.entry("effects").or_insert_with(|| Value::Array(Vec::new())) {
        effects.extend(more);
    }
}

/// Sets a key such as `motion.range` or `more_effects.0.parameters.0`; `None` if an entry of a list is not there.
fn set(table: &mut Table, key: &str, value: f64) -> Option<()> {
    match key.split_once('.') {
        None => {
            table.insert(key.to_owned(), Value::Float(value));
            Some(())
        }
        Some((first, rest)) => match table.entry(first).or_insert_with(|| Value::Table(Table::new())) {
            Value::Table(inner) => set(inner, rest, value),
            Value::Array(entries) => set_entry(entries, rest, value),
            _ => None,
        },
    }
}

fn set_entry(entries: &mut [Value], key: &str, value: f64) -> Option<()> {
    let (index, rest) = key.split_once('.').map_or((key, None), |(index, rest)| (index, Some(rest)));
    match (entries.get_mut(index.parse::<usize>().ok()?)?, rest) {
        (entry, None) => *entry = Value::Float(value),
        (Value::Table(inner), Some(rest)) => set(inner, rest, value)?,
        (Value::Array(inner), Some(rest)) => set_entry(inner, rest, value)?,
        _ => return None,
    }
    Some(())
}

fn one() -> u64 {
    1
}

fn within<'de, D: Deserializer<'de>>(deserializer: D, what: &str, most: u64) -> Result<u64, D::Error> {
    let count = i64::deserialize(deserializer)?;
    let fits = u64::try_from(count).ok().filter(|count| (1..=most).contains(count));
    fits.ok_or_else(|| serde::de::Error::custom(format!("{count} {what}: choose between 1 and {most}")))
}

fn seeds<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u64, D::Error> {
    within(deserializer, "seeds", MOST_SEEDS)
}

fn members<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u64, D::Error> {
    within(deserializer, "members", 100)
}

fn paper_table<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<u8>, D::Error> {
    let table = u8::deserialize(deserializer)?;
    if (2..=4).contains(&table) {
        return Ok(Some(table));
    }
    Err(serde::de::Error::custom(format!("the paper has results in the tables 2, 3 and 4, not {table}")))
}

fn preset<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Preset>, D::Error> {
    let id = String::deserialize(deserializer)?;
    let known = || Preset::ALL.map(Preset::id).join(", ");
    let found = Preset::ALL.into_iter().find(|preset| preset.id() == id);
    found.map(Some).ok_or_else(|| serde::de::Error::custom(format!("there is no model `{id}`; known: {}", known())))
}

impl Default for Effects {
    fn default() -> Self {
        Effects::Named(Vec::new())
    }
}

impl<'de> Deserialize<'de> for Effects {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged, expecting = "either \"diagnosed\" or a list such as [\"coulomb-friction@1,2\"]")]
        enum Written {
            Word(Diagnosed),
            List(Vec<String>),
        }
        #[derive(Deserialize)]
        #[serde(rename_all = "kebab-case")]
        enum Diagnosed {
            Diagnosed,
        }
        Ok(match Written::deserialize(deserializer)? {
            Written::Word(Diagnosed::Diagnosed) => Effects::Diagnosed,
            Written::List(names) => Effects::Named(names),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str = r#"
title = "small"
description = "two models"
seeds = 2

[data.simulation]
name = "arm"
arm = { links = [{ mass = 1.0, length = 1.0, com = 0.5, inertia = 0.1 }] }
motion = { kind = "paper-point-to-point", trajectories = 3, duration = 4.0, samples = 50, range = 3.0 }

[[model]]
name = "rigid-body"
preset = "rigid-body"

[[model]]
name = "answer"
preset = "rigid-body"
effects = ["coulomb-friction@1"]

[[test]]
name = "iid"

[[test]]
name = "far"
simulation = { motion = { range = 10.0 } }

[[curve]]
name = "speed"
key = "speed_scale"
axis = "times as fast"
values = [1.0, 2.0]
simulation = { motion = { trajectories = 5 } }
"#;

    fn problem(from: &str, to: &str) -> String {
        assert!(SMALL.contains(from), "{from}");
        Experiment::parse("small", &SMALL.replacen(from, to, 1)).unwrap_err().to_string()
    }

    #[test]
    fn test_sets_are_the_training_simulation_with_their_changes() {
        let experiment = Experiment::parse("small", SMALL).unwrap();
        let sets = experiment.test_sets(0).unwrap();
        let names: Vec<&str> = sets.iter().map(|set| set.name.as_str()).collect();
        assert_eq!(names, ["iid", "far", "speed 1", "speed 2"]);
        let scenario = |index: usize| match &sets[index].source {
            Source::Simulated(scenarios) => scenarios[0].clone(),
            other => panic!("{other:?}"),
        };
        let Source::Simulated(training) = experiment.training_source(0).unwrap() else { panic!("not simulated") };
        assert_eq!(scenario(0), Scenario { seed: 1_000_000, ..training[0].clone() });
        assert_eq!(scenario(3).speed_scale, 2.0);
        assert_eq!(scenario(3).motion.trajectory_count(), 5);
        assert_ne!(scenario(1).motion, scenario(0).motion);
        assert_eq!(sets[3].point.as_ref().map(|point| point.x), Some(2.0));
    }

    #[test]
    fn mistakes_are_told_with_their_line_and_how_to_mend_them() {
        let told = [
            (("seeds = 2", "sheds = 2"), vec!["line 4", "unknown field `sheds`", "`seeds`"]),
            (("seeds = 2", "seeds = 0"), vec!["line 4", "choose between 1 and 1000"]),
            (("range = 10.0", "rage = 10.0"), vec!["line 23", "unknown field `rage`", "`range`"]),
            (("range = 10.0", "range = -1.0"), vec!["line 23", "range is -1"]),
            (("mass = 1.0", "mass = \"one\""), vec!["line 6", "invalid type: string \"one\"", "arm.links.mass"]),
            (
                ("preset = \"rigid-body\"\n\n[[model]]", "preset = \"body\"\n\n[[model]]"),
                vec!["line 13", "no model `body`; known: rigid-body"],
            ),
            (
                ("[\"coulomb-friction@1\"]", "[\"friction@1\"]"),
                vec!["line 18", "no effect `friction`; known effects: viscous"],
            ),
            (("[\"coulomb-friction@1\"]", "[\"coulomb-friction@0\"]"), vec!["line 18", "joints are counted from 1"]),
            (
                (
                    "speed_scale\"",
                    "speed_scale\"\nmixture = [{ effects = [{ effect = \"viscous-friction\", joint = 0, parameters = [1.0] }] }]",
                ),
                vec!["line 27", "write `effect = \"viscous-friction@1\"` instead"],
            ),
            (("[\"coulomb-friction@1\"]", "\"all\""), vec!["line 18", "either \"diagnosed\" or a list"]),
            (("name = \"far\"", "name = \"iid\""), vec!["line 23", "two test sets are named `iid`"]),
            (("values = [1.0, 2.0]", "values = []"), vec!["curve `speed` has no values"]),
            (("key = \"speed_scale\"", "key = \"motion.range.1\""), vec!["line 27", "invalid type: map", "motion"]),
            (("key = \"speed_scale\"", "key = \"sped\""), vec!["unknown field `sped`", "`speed_scale`"]),
        ];
        for ((from, to), parts) in told {
            let message = problem(from, to);
            for part in parts {
                assert!(message.contains(part), "{from} -> {to}: {message}");
            }
        }
    }

    /// A name stands in other places before its model, and a mistake in the second of two models is not in the first.
    #[test]
    fn mistakes_are_told_where_they_are_made() {
        let named = |from: &str, to: &str| problem(from, to).lines().next().unwrap().to_owned();
        let twice = named("name = \"answer\"", "name = \"rigid-body\"");
        assert!(twice.starts_with("small: line 16: two models are named `rigid-body`"), "{twice}");
        let effect =
            named("effects = [\"coulomb-friction@1\"]", "effects = [\n  \"coulomb-friction@1\",\n  \"answer@1\",\n]");
        assert!(effect.starts_with("small: line 20: model `answer`: there is no effect `answer`"), "{effect}");
        let neither = named("preset = \"rigid-body\"\neffects = ", "effects = ");
        assert!(neither.starts_with("small: line 15: model `answer` needs either"), "{neither}");
        let rate = named("preset = \"rigid-body\"\neffects", "preset = \"ff-nn\"\ntraining = { rate = -1.0 }\neffects");
        assert!(rate.starts_with("small: line 18: model `answer`: the learning rate is -1"), "{rate}");
        let text = format!("{SMALL}\n[quick]\n# [quick] keeps what it names\nmodels = [\"answer\", \"question\"]\n");
        let quick = Experiment::parse("small", &text).unwrap_err().to_string();
        assert!(quick.starts_with("small: line 36: `quick` keeps the model `question`"), "{quick}");
    }

    #[test]
    fn training_and_test_data_never_have_the_same_random_seed() {
        let seeds = |purpose| {
            let of_part = move |part| [0, 1, MOST_SEEDS - 1].map(|seed| random_seed(purpose, seed, part));
            (0..1000).flat_map(of_part).collect::<std::collections::BTreeSet<u64>>()
        };
        let (training, test) = (seeds(Use::Training), seeds(Use::Test));
        assert_eq!((training.len(), test.len()), (3000, 3000), "nor do two parts");
        assert!(training.is_disjoint(&test));
        // A mixture of many parts, as a file has it.
        let text = SMALL.replacen("[[model]]", &("[[data.mixture]]\n".repeat(150) + "[[model]]"), 1);
        let experiment = Experiment::parse("small", &text).unwrap();
        let of = |source: Source| match source {
            Source::Simulated(scenarios) => scenarios.into_iter().map(|scenario| scenario.seed).collect::<Vec<_>>(),
            other => panic!("{other:?}"),
        };
        let test = of(experiment.test_sets(0).unwrap().remove(0).source);
        let training: Vec<u64> = (0..3).flat_map(|seed| of(experiment.training_source(seed).unwrap())).collect();
        assert_eq!((training.len(), test.len()), (450, 150));
        assert!(training.iter().all(|seed| !test.contains(seed)));
    }

    #[test]
    fn the_quick_version_keeps_what_it_names() {
        let text = format!("{SMALL}\n[quick]\nseeds = 1\nmodels = [\"answer\"]\ntests = [\"iid\"]\n");
        let quick = Experiment::parse("small", &text).unwrap().quick();
        assert_eq!((quick.seeds, quick.models.len(), quick.test_sets(0).unwrap().len()), (1, 1, 1));
        let wrong = text.replace("models = [\"answer\"]", "models = [\"question\"]");
        let message = Experiment::parse("small", &wrong).unwrap_err().to_string();
        assert!(
            message.contains("`quick` keeps the model `question`, which is not among rigid-body, answer"),
            "{message}"
        );
    }
}
