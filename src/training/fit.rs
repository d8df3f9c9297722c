//! Training in the terms of the session: a model and a recording in, a model with its parameters out.
//!
//! Effects beside a network keep the shape parameters that a rigid body with the same effects finds; their linear
//! parameters are trained together with the weights.

use std::any::Any;
use std::io::{Cursor, Write};
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use zip::write::SimpleFileOptions;
use zip::{DateTime, ZipArchive, ZipWriter};

use super::data::Columns;
use super::effects::{self, AddedEffect};
use super::learn::{Begin, Ending, Outcome, TrainingData, train};
use super::learned::{Checkpoint, LearnedModel, same_settings};
use super::options::{Options, Precision, Recipe, scale_to};
use super::restart::{self, OtherStart};
use super::{Samples, TrainError};
use crate::file::Unpacking;
use crate::model::file::load_own_effects;
use crate::model::fit::TrainedTerms;
use crate::model::learned::{Architecture, Features, Layers, LearnedTerm, Positive, Scales};
use crate::model::terms::Setting;
use crate::model::{self, Fitted, Model, ModelError, Parameter, RigidBody, Term};
use crate::network::Element;
use crate::progress::{Epoch, Event, Monitor};
use crate::recording::split::{Segment, Split, VALIDATION_SHARE};
use crate::recording::{JointKind, Recording, Trajectory};
use crate::signals::Signals;

/// How a model of the session is trained.
///
/// ```
/// use torquescope::{prelude::*, training::Recipe};
///
/// let mut plan = Plan::of(Recipe::Thorough);
/// (plan.options.epochs, plan.layers.hidden) = (100, vec![32, 32]);
/// plan.options.check()?;
/// # Ok::<(), torquescope::training::TrainError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Where the settings come from.
    pub recipe: Recipe,
    /// Hidden layers of all networks of a preset; a model that is given keeps its own.
    pub layers: Layers,
    /// How positions enter the networks; those of sliding joints enter as they are. `None`: as suits the arm, so the directions of
    /// links into a Lagrangian of a planar arm, cos q and sin q into every other network.
    pub features: Option<Features>,
    /// Whether quantities are scaled to the data (ours) or taken as they are (the paper's).
    pub normalise: bool,
    /// What is calculated with.
    pub precision: Precision,
    /// Optimiser, schedule, budget.
    pub options: Options,
    /// Velocities and accelerations enter networks divided by so many times their typical size. A larger number keeps a network
    /// nearer to the polynomial that a torque is in them, so that it bends less where it was not trained.
    #[serde(default = "typical")]
    pub smoothness: f64,
    /// Whether a Cholesky factor keeps the mass matrix of a preset positive definite, as it always is in nature.
    #[serde(default = "yes")]
    pub cholesky: bool,
}

fn yes() -> bool {
    true
}

fn typical() -> f64 {
    1.0
}

impl Default for Plan {
    fn default() -> Self {
        Plan::of(Recipe::Ours)
    }
}

impl Plan {
    /// The plan of a recipe.
    pub fn of(recipe: Recipe) -> Self {
        Plan {
            recipe,
            layers: recipe.layers(),
            features: recipe.features(),
            normalise: recipe.normalises(),
            precision: Precision::F32,
            options: recipe.options(),
            smoothness: typical(),
            cholesky: yes(),
        }
    }

    /// A model with the networks that this plan wants for presets.
    pub fn shaped(&self, model: &Model) -> Model {
        model.with_layers(&self.layers).with_positive(self.cholesky.then_some(Positive::PAPER))
    }

    /// This plan without what does not change the course of a run.
    fn course(&self) -> Self {
        Plan { options: self.options.course(), ..self.clone() }
    }
}

/// A model after training.
#[derive(Debug, Clone)]
pub struct Trained {
    /// The model with its best weights.
    pub fitted: Fitted,
    /// How the run ended.
    pub ending: Ending,
    /// Its epochs.
    pub history: Vec<Epoch>,
    /// Where it can be resumed.
    pub run: SavedRun,
}

/// A training run of a session's model that can be resumed.
#[derive(Debug, Clone, PartialEq)]
pub struct SavedRun {
    /// What is trained.
    pub model: Model,
    /// How.
    pub plan: Plan,
    /// How far it is.
    pub checkpoint: Checkpoint,
    /// Whether it began with the weights of another model, so that there is no other start.
    pub is_warm: bool,
    /// Starts that were tried beside this one, since it or they got stuck.
    pub other_starts: Vec<OtherStart>,
}

impl SavedRun {
    /// The plan as it was asked for, with its own seed and not that of a start which was tried in its place.
    pub fn asked(&self) -> Plan {
        let mut plan = self.plan.clone();
        plan.options.seed = self.other_starts.iter().map(|start| start.seed).fold(plan.options.seed, u64::min);
        plan
    }
}

/// Called after every epoch; can ask for the run as it stands there, to keep it.
pub type KeepRun<'a> = dyn FnMut(&dyn Fn() -> SavedRun) + 'a;

/// Trained networks and what they need beside the motion.
#[derive(Debug)]
struct TrainedNetworks {
    model: LearnedModel,
    effects: Vec<AddedEffect>,
    setting: Setting,
    /// How many terms of the architecture are networks or trained friction.
    terms: usize,
}

impl TrainedTerms for TrainedNetworks {
    fn torques(&self, trajectory: &Trajectory) -> Result<Vec<Signals>, ModelError> {
        let failed = |error: TrainError| ModelError::Network(error.to_string());
        let columns = effects::columns(&self.effects, &self.setting, trajectory)?;
        let components = self.model.components(trajectory, &columns).map_err(failed)?;
        Ok(components.terms.into_iter().take(self.terms).collect())
    }

    fn as_any(&self) -> &dyn Any {
        self
    }
}

/// The networks of a fitted model, for components and files; `None` if it has none.
pub fn networks(fitted: &Fitted) -> Option<&LearnedModel> {
    trained(fitted).map(|networks| &networks.model)
}

fn trained(fitted: &Fitted) -> Option<&TrainedNetworks> {
    fitted.networks()?.as_any().downcast_ref()
}

/// Columns of the effects of a fitted model along a trajectory, as its networks expect them.
///
/// # Errors
/// [`TrainError`] if an effect can't be computed.
pub fn effect_columns(fitted: &Fitted, trajectory: &Trajectory) -> Result<Columns, TrainError> {
    match trained(fitted) {
        Some(networks) => effects::columns(&networks.effects, &networks.setting, trajectory).map_err(failed),
        None => Ok(Columns::new()),
    }
}

/// Trains all terms of a model jointly. With `before`, weights of blocks that both models have are kept (warm start).
///
/// A stop, a loss that explodes or is not a number end the run with the best weights so far; [`Trained::ending`] says so.
///
/// # Errors
/// [`TrainError`] if the run can't begin, or was stopped before its first epoch.
pub fn fit(
    model: &Model,
    recording: &Recording,
    split: &Split,
    plan: &Plan,
    before: Option<&Fitted>,
    monitor: &Monitor,
    keep: &mut KeepRun,
) -> Result<Trained, TrainError> {
    let begin = before.and_then(networks).map_or(Begin::Fresh, Begin::Warm);
    let course = Course { model, plan, is_warm: matches!(begin, Begin::Warm(_)), other_starts: &[] };
    let trained = course.run(recording, split, begin, monitor, keep)?;
    unstuck(trained, recording, split, monitor, keep)
}

/// Goes on with a run on the recording where it began; the result is that of a run that was never interrupted.
///
/// # Errors
/// [`TrainError::OtherCheckpoint`] if recording or split are others than those of the run; else as [`fit`].
pub fn resume(
    run: &SavedRun,
    recording: &Recording,
    split: &Split,
    monitor: &Monitor,
    keep: &mut KeepRun,
) -> Result<Trained, TrainError> {
    let SavedRun { model, plan, checkpoint, is_warm, other_starts } = run;
    let course = Course { model, plan, is_warm: *is_warm, other_starts };
    let trained = course.run(recording, split, Begin::Resume(checkpoint), monitor, keep)?;
    unstuck(trained, recording, split, monitor, keep)
}

/// The training itself or, where it got stuck, the best of a few starts; of each the watcher is told.
fn unstuck(
    mut best: Trained,
    recording: &Recording,
    split: &Split,
    monitor: &Monitor,
    keep: &mut KeepRun,
) -> Result<Trained, TrainError> {
    let mut newest = best.clone();
    while let Some(seed) = restart::next_start(&newest, recording, split, monitor)? {
        let left = OtherStart { seed: newest.run.plan.options.seed, unexplained: restart::unexplained(&newest) };
        monitor.tell(Event::Warning(format!(
            "the training got stuck: {:.1} % of the variance is left in what it learned from, far more than a rigid body \
             leaves. It begins anew from another start (seed {seed} instead of {})",
            100.0 * left.unexplained,
            left.seed
        )));
        let run = &newest.run;
        let mut plan = run.plan.clone();
        plan.options.seed = seed;
        let other_starts = [&run.other_starts[..], &[left]].concat();
        let course = Course { model: &run.model, plan: &plan, is_warm: false, other_starts: &other_starts };
        newest = match course.run(recording, split, Begin::Fresh, monitor, keep) {
            // Stopped before its first epoch: what was there before is what is kept.
            Err(TrainError::Stopped(_)) => break,
            next => next?,
        };
        let unexplained = restart::unexplained(&newest);
        if unexplained < restart::unexplained(&best) {
            best = newest.clone();
        } else {
            best.run.other_starts.push(OtherStart { seed, unexplained });
        }
    }
    Ok(best)
}

/// What is trained how, from one start.
struct Course<'a> {
    model: &'a Model,
    plan: &'a Plan,
    is_warm: bool,
    other_starts: &'a [OtherStart],
}

impl Course<'_> {
    fn run(
        &self,
        recording: &Recording,
        split: &Split,
        begin: Begin,
        monitor: &Monitor,
        keep: &mut KeepRun,
    ) -> Result<Trained, TrainError> {
        match self.plan.precision {
            Precision::F32 => fit_from::<f32>(self, recording, split, begin, monitor, keep),
            Precision::F64 => fit_from::<f64>(self, recording, split, begin, monitor, keep),
        }
    }
}

fn fit_from<E: Element>(
    course: &Course,
    recording: &Recording,
    split: &Split,
    begin: Begin,
    monitor: &Monitor,
    keep: &mut KeepRun,
) -> Result<Trained, TrainError> {
    let Course { model, plan, is_warm, other_starts } = *course;
    let (effects, setting) = added_effects(model, recording, split, monitor)?;
    let samples = |segments: &[Segment]| -> Result<Samples<E>, TrainError> {
        let (mut cuts, mut columns) = (Vec::new(), Vec::new());
        for segment in segments {
            // Effects are computed along the whole trajectory, since they may have an inner state, and cut afterwards.
            let trajectory = &recording.trajectories[segment.trajectory];
            let whole = effects::columns(&effects, &setting, trajectory).map_err(failed)?;
            let cut = |column: &Signals| column.cut(segment.samples.clone());
            columns.push(whole.iter().map(cut).collect::<Columns>());
            cuts.push(trajectory.slice(segment.samples.clone()));
        }
        Samples::new(recording.joint_count(), &cuts, &columns)
    };
    let [learned, validation] = parts(recording, split);
    let watched = |segments: &[Segment]| if segments.is_empty() { Ok(None) } else { samples(segments).map(Some) };
    let (train_samples, validation, held_out) = (samples(&learned)?, watched(&validation)?, watched(&split.held_out)?);
    let architecture = architecture(model, &effects, &setting, plan, &train_samples)?;
    let data = TrainingData { train: &train_samples, validation: validation.as_ref(), held_out: held_out.as_ref() };
    let run = |checkpoint: Checkpoint| SavedRun {
        model: model.clone(),
        plan: plan.clone(),
        checkpoint,
        is_warm,
        other_starts: other_starts.to_vec(),
    };
    let Outcome { model: learned, ending, history, checkpoint } =
        train(&architecture, &plan.options, data, begin, monitor, &mut |checkpoint| keep(&|| run(checkpoint())))?;
    if history.is_empty()
        && let Ending::Stopped(reason) = &ending
    {
        return Err(crate::progress::Stopped { reason: reason.clone() }.into());
    }
    Ok(Trained { fitted: fitted(model, learned, effects, setting)?, ending, history, run: run(checkpoint) })
}

/// What a training learns from, and what chooses its best epoch. Where nothing is held out, all of it is learned from: what is
/// reported then is measured elsewhere.
pub fn parts(recording: &Recording, split: &Split) -> [Vec<Segment>; 2] {
    if split.held_out.is_empty() { [split.train.clone(), Vec::new()] } else { split.with_validation(recording) }
}

/// About how many samples a training learns from: [`parts`] without looking at the recording.
pub fn about_learned(split: &Split) -> usize {
    let samples: usize = split.train.iter().map(|segment| segment.samples.len()).sum();
    if split.held_out.is_empty() { samples } else { samples - samples / VALIDATION_SHARE }
}

fn failed(error: ModelError) -> TrainError {
    match error {
        ModelError::Stopped(stopped) => stopped.into(),
        other => TrainError::Model(other.to_string()),
    }
}

/// The effects of a model with the shapes that a rigid body with the same effects finds, and the setting with that body, from
/// which comes the load of effects that depend on it.
fn added_effects(
    model: &Model,
    recording: &Recording,
    split: &Split,
    monitor: &Monitor,
) -> Result<(Vec<AddedEffect>, Setting), TrainError> {
    let effects: Vec<Term> = model.effects().cloned().map(Term::Effect).collect();
    if effects.is_empty() {
        return Ok((Vec::new(), Setting::of(recording).map_err(failed)?));
    }
    let terms = [Term::RigidBody(RigidBody::Identified)].into_iter().chain(effects).collect();
    let solved = model::fit(&Model { terms }, recording, split, monitor).map_err(failed)?;
    let shapes = solved.shapes().iter().skip(1);
    let added =
        |(term, shape): (&model::EffectTerm, &Vec<f64>)| AddedEffect { term: term.clone(), shape: shape.clone() };
    Ok((model.effects().zip(shapes).map(added).collect(), solved.setting().clone()))
}

fn architecture<E: Element>(
    model: &Model,
    effects: &[AddedEffect],
    setting: &Setting,
    plan: &Plan,
    samples: &Samples<E>,
) -> Result<Architecture, TrainError> {
    let mut terms: Vec<LearnedTerm> = Vec::new();
    for term in &model.terms {
        match term {
            Term::Learned(term) => terms.push(term.clone()),
            Term::Effect(_) => {}
            Term::RigidBody(_) | Term::Resistance(_) => {
                return Err(TrainError::Model(
                    "a rigid body and a network can't be trained together: start from one of them".to_owned(),
                ));
            }
        }
    }
    if !effects.is_empty() {
        terms.push(LearnedTerm::Columns { names: effects::names(effects) });
    }
    let features = match plan.features {
        _ if setting.kinds.contains(&JointKind::Prismatic) => Features::Raw,
        Some(features) => features,
        None if setting.chain.is_none() && terms.iter().any(LearnedTerm::is_lagrangian) => Features::LinkAngles,
        None => Features::CosSin,
    };
    let mut architecture = Architecture { joints: setting.kinds.len(), features, terms, scales: Scales::default() };
    if plan.normalise {
        scale_to(&mut architecture, samples);
    }
    architecture.scales.velocity *= plan.smoothness;
    architecture.scales.acceleration *= plan.smoothness;
    Ok(architecture)
}

/// Puts weights and effects together as a model of the session.
fn fitted(
    model: &Model,
    learned: LearnedModel,
    effects: Vec<AddedEffect>,
    setting: Setting,
) -> Result<Fitted, TrainError> {
    let factors = learned.effect_factors();
    let names = model.factors(&setting).map_err(failed)?;
    let of_effect = |(factor, &value): (&model::terms::Factor, &f64)| Parameter {
        name: factor.name.clone(),
        symbol: factor.symbol.clone(),
        term: factor.term,
        joint: factor.joint,
        value,
        std_error: None,
        interval: None,
        unit: factor.unit.to_owned(),
        identified: true,
        physical: (factor.bounds[0]..=factor.bounds[1]).contains(&value),
        stated: None,
    };
    let kinds = setting.kinds.clone();
    let friction = model.terms.iter().position(|term| matches!(term, Term::Learned(LearnedTerm::Friction)));
    let mut parameters: Vec<Parameter> = names.iter().zip(&factors).map(of_effect).collect();
    for coefficient in friction.iter().flat_map(|_| learned.friction_coefficients()) {
        parameters.push(Parameter {
            name: coefficient.name.to_owned(),
            symbol: coefficient.symbol.to_owned(),
            term: friction.unwrap_or(0),
            joint: Some(coefficient.joint),
            value: coefficient.value,
            std_error: None,
            interval: None,
            unit: coefficient.dimension.unit(kinds[coefficient.joint]).to_owned(),
            identified: true,
            physical: coefficient.value >= 0.0,
            stated: None,
        });
    }
    parameters.sort_by_key(|parameter| parameter.term);
    let mut own_shapes = effects.iter().map(|effect| effect.shape.clone());
    let shapes = model
        .terms
        .iter()
        .map(|term| if matches!(term, Term::Effect(_)) { own_shapes.next().unwrap_or_default() } else { Vec::new() })
        .collect();
    let terms = model.terms.iter().filter(|term| matches!(term, Term::Learned(_))).count();
    let networks = Arc::new(TrainedNetworks { model: learned, effects, setting: setting.clone(), terms });
    Ok(Fitted::trained(model.clone(), parameters, factors, shapes, setting, networks))
}

/// Names of the entries of files: of a model, of a run.
const FITTED: &str = "model.json";
const NETWORKS: &str = "networks.npz";
const RUN: &str = "run.json";
const CHECKPOINT: &str = "checkpoint.npz";

fn damaged(error: impl std::fmt::Display) -> TrainError {
    TrainError::Damaged(error.to_string())
}

fn pack(entries: [(&str, Vec<u8>); 2]) -> Result<Vec<u8>, TrainError> {
    // No time stamps, so that equal contents are equal files.
    let options = SimpleFileOptions::default().last_modified_time(DateTime::default());
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in entries {
        archive.start_file(name, options).map_err(damaged)?;
        archive.write_all(&bytes).map_err(damaged)?;
    }
    Ok(archive.finish().map_err(damaged)?.into_inner())
}

/// Whether an archive has this entry.
fn holds(bytes: &[u8], name: &str) -> bool {
    ZipArchive::new(Cursor::new(bytes)).is_ok_and(|archive| archive.index_for_name(name).is_some())
}

fn unpack(bytes: &[u8], names: [&str; 2]) -> Result<[Vec<u8>; 2], TrainError> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(damaged)?;
    let mut unpacking = Unpacking::of(bytes.len());
    let mut entry = |name: &str| -> Result<Vec<u8>, TrainError> {
        let part = archive.by_name(name).map_err(|error| damaged(format!("`{name}`: {error}")))?;
        unpacking.part(part).map_err(|error| damaged(format!("`{name}`: {error}")))
    };
    Ok([entry(names[0])?, entry(names[1])?])
}

/// What is trained and how; the rest of a run's file is its checkpoint.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RunFile {
    /// The files of effects of one's own that are in it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    own_effects: Vec<String>,
    model: Model,
    plan: Plan,
    #[serde(default)]
    is_warm: bool,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    other_starts: Vec<OtherStart>,
}

impl SavedRun {
    /// The same run with other settings, as far as they do not change its course: threads, goal and, at a constant rate, the
    /// number of epochs.
    ///
    /// # Errors
    /// [`TrainError::OtherCheckpoint`] names the first setting that would change it.
    pub fn with_plan(self, plan: Plan) -> Result<Self, TrainError> {
        let (own, other) = (self.plan.course(), plan.course());
        same_settings(&own.options, &other.options)?;
        same_settings(&own, &other)?;
        Ok(SavedRun { plan, ..self })
    }

    /// Whether another run trains the same model in the same way, from whichever seed.
    pub fn differs_by_seed_only(&self, other: &SavedRun) -> bool {
        let mut plan = other.plan.clone();
        plan.options.seed = self.plan.options.seed;
        self.model == other.model && self.plan == plan
    }

    /// In a sentence, which other starts were tried and what they left; `None` if the first one was good.
    pub fn starts_text(&self) -> Option<String> {
        let seeds: Vec<String> = self.other_starts.iter().map(OtherStart::to_string).collect();
        (!seeds.is_empty()).then(|| {
            format!(
                "Kept is the start from seed {}; others got stuck, and left more of the variance in what they learned \
                 from: {}.",
                self.plan.options.seed,
                seeds.join(", ")
            )
        })
    }

    /// The run as a file.
    ///
    /// # Errors
    /// As [`to_bytes`].
    pub fn to_bytes(&self) -> Result<Vec<u8>, TrainError> {
        let file = RunFile {
            own_effects: self.model.own_effects(),
            model: self.model.clone(),
            plan: self.plan.clone(),
            is_warm: self.is_warm,
            other_starts: self.other_starts.clone(),
        };
        pack([(RUN, serde_json::to_vec(&file).map_err(damaged)?), (CHECKPOINT, self.checkpoint.to_bytes()?)])
    }

    /// A run from the bytes of a file.
    ///
    /// # Errors
    /// [`TrainError::Damaged`] says what is wrong.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, TrainError> {
        if holds(bytes, FITTED) {
            return Err(TrainError::OtherFile { is: "a trained model", needed: "the checkpoint of a training" });
        }
        let [file, checkpoint] = unpack(bytes, [RUN, CHECKPOINT])?;
        load_own_effects(&serde_json::from_slice(&file).map_err(damaged)?).map_err(damaged)?;
        let RunFile { model, plan, is_warm, other_starts, .. } = serde_json::from_slice(&file).map_err(damaged)?;
        Ok(SavedRun { model, plan, checkpoint: Checkpoint::from_bytes(&checkpoint)?, is_warm, other_starts })
    }
}

/// A fitted model as a file: JSON if it has no networks, else an archive of that JSON and of the weights.
///
/// # Errors
/// [`TrainError::Damaged`] if the archive can't be written, which memory never refuses.
pub fn to_bytes(fitted: &Fitted) -> Result<Vec<u8>, TrainError> {
    let Some(networks) = networks(fitted) else { return Ok(fitted.to_json().into_bytes()) };
    pack([(FITTED, fitted.to_json().into_bytes()), (NETWORKS, networks.to_bytes()?)])
}

/// A fitted model from the bytes of a file.
///
/// # Errors
/// [`TrainError::Damaged`] says what is wrong.
pub fn from_bytes(bytes: &[u8]) -> Result<Fitted, TrainError> {
    if !bytes.starts_with(b"PK") {
        let text = std::str::from_utf8(bytes).map_err(|_| TrainError::Damaged("it is not text".to_owned()))?;
        return Fitted::from_json(text).map_err(damaged);
    }
    if holds(bytes, RUN) {
        return Err(TrainError::OtherFile { is: "the checkpoint of a training", needed: "a trained model" });
    }
    let [text, networks] = unpack(bytes, [FITTED, NETWORKS])?;
    let plain = Fitted::from_json(&String::from_utf8(text).map_err(damaged)?).map_err(damaged)?;
    let learned = LearnedModel::from_bytes(&networks)?;
    let shapes = plain.model.terms.iter().zip(plain.shapes()).filter(|(term, _)| matches!(term, Term::Effect(_)));
    let effects: Vec<AddedEffect> = plain
        .model
        .effects()
        .zip(shapes)
        .map(|(term, (_, shape))| AddedEffect { term: term.clone(), shape: shape.clone() })
        .collect();
    if learned.architecture.joints != plain.setting().kinds.len()
        || learned.effect_factors().len() != plain.factor_count()
    {
        return Err(TrainError::Damaged("its networks are of another model".to_owned()));
    }
    let setting = plain.setting().clone();
    fitted(&plain.model, learned, effects, setting)
}
