//! Arguments that name data and a model, shared by the commands.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use serde::de::DeserializeOwned;

use super::progress;
use crate::arm::{Arm, Posture};
use crate::effect::registry;
use crate::model::learned::{Features, Layers};
use crate::model::{Fitted, Model, Preset, Term};
use crate::network::Activation;
use crate::recording::mapping::{MappingError, MappingSpec};
use crate::recording::read::ReadOptions;
use crate::session::{Command, Session, runs};
use crate::simulation::Scenario;
use crate::training::fit::Plan;
use crate::training::optimiser::Optimiser;
use crate::training::schedule::Schedule;
use crate::training::{self, Precision, Recipe};

/// Where the arm points at q = 0.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Zero {
    /// Along −z: the arm hangs.
    Down,
    /// Along +x.
    Right,
    /// Along +z.
    Up,
}

/// How files are read; what is not given is guessed or taken from the file.
#[derive(Args, Debug, Clone)]
pub struct Reading {
    /// What to hold out, files or names of trajectories: the error is measured there, nothing is learned from it.
    #[arg(long, value_name = "FILE|NAME", num_args = 1..)]
    held_out: Vec<PathBuf>,
    /// Which column is which channel, such as `q=pos_filt*,qd=vel_filt*,tau=tau_meas*,time=time` (`*` is the joint); or a
    /// mapping file, which can state factors, matrices and axes too, such as `assets/mappings/emps.toml`.
    #[arg(long, value_name = "MAP|FILE.toml", value_parser = parse_mapping)]
    map: Option<MappingSpec>,
    /// Where the arm points at q = 0, if the file does not say it.
    #[arg(long)]
    zero: Option<Zero>,
    /// The arm's stated masses and lengths (JSON: links, gravity, posture).
    #[arg(long, value_name = "ARM.json")]
    arm: Option<PathBuf>,
    /// Sampling rate [Hz] of files without a time column.
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
    /// Cut-off of the filter for velocity and acceleration that are derived [Hz].
    #[arg(long, value_name = "HZ")]
    low_pass: Option<f64>,
}

/// Files to read, and how.
#[derive(Args, Debug, Clone)]
pub struct Files {
    /// Recordings (CSV, NPZ, MATLAB .mat, ROS 2 .db3); several files are trajectories of one arm, and `FILE+FILE` are files
    /// with channels of the same samples.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    reading: Reading,
}

/// Files that need not be given: without, the embedded recording is taken.
#[derive(Args, Debug, Clone)]
pub struct OptionalData {
    /// Recordings (CSV, NPZ, .mat, .db3); several files are trajectories of one arm. Without any: an embedded arm with a hidden effect.
    files: Vec<PathBuf>,
    #[command(flatten)]
    reading: Reading,
}

/// How networks are trained; not used by models without networks.
#[derive(Args, Debug, Clone)]
#[command(next_help_heading = "Training of networks")]
pub struct Training {
    /// Settings to start from: `ours` (the default) converges quickest, `thorough` is ours for five times as long, `paper` is
    /// table 1 of the paper.
    #[arg(long, value_parser = named::<Recipe>)]
    recipe: Option<Recipe>,
    /// How often every sample is seen.
    #[arg(long)]
    epochs: Option<u64>,
    /// Samples in a step.
    #[arg(long)]
    batch: Option<usize>,
    /// Highest learning rate.
    #[arg(long)]
    learning_rate: Option<f64>,
    /// Course of the learning rate: constant, cosine (with warm-up) or one-cycle.
    #[arg(long, value_parser = parse_schedule)]
    schedule: Option<Schedule>,
    /// How weights follow from gradients: adamw or soap.
    #[arg(long, value_parser = parse_optimiser)]
    optimiser: Option<Optimiser>,
    /// Weight decay, per unit of learning rate.
    #[arg(long)]
    weight_decay: Option<f64>,
    /// Widths of the hidden layers, such as `64,64`.
    #[arg(long, value_name = "WIDTHS", value_delimiter = ',')]
    hidden: Option<Vec<usize>>,
    /// Their activation: tanh, sigmoid, softplus or silu.
    #[arg(long, value_parser = named::<Activation>)]
    activation: Option<Activation>,
    /// How positions enter the networks: cos-sin, link-angles or raw.
    #[arg(long, value_parser = named::<Features>)]
    features: Option<Features>,
    /// Divides velocities and accelerations that enter networks; with more than 1 these bend less where they were not trained.
    #[arg(long)]
    smoothness: Option<f64>,
    /// Whether quantities are scaled to the data: true, or false as in the paper.
    #[arg(long, value_name = "BOOL")]
    normalise: Option<bool>,
    /// What is calculated with: f32 or f64.
    #[arg(long, value_parser = named::<Precision>)]
    precision: Option<Precision>,
    /// Ends as soon as the held-out nMSE is this low.
    #[arg(long, value_name = "NMSE")]
    goal: Option<f64>,
    /// Seed of first weights and of the order of samples.
    #[arg(long)]
    training_seed: Option<u64>,
    /// Threads; the result does not depend on them.
    #[arg(long)]
    threads: Option<usize>,
}

impl Training {
    /// The plan that these options make.
    pub fn plan(&self) -> Plan {
        self.changing(Plan::of(self.recipe.unwrap_or_default()))
    }

    /// This plan with the options that were given.
    pub fn changing(&self, plan: Plan) -> Plan {
        let mut plan = match self.recipe {
            Some(recipe) if recipe != plan.recipe => Plan::of(recipe),
            _ => plan,
        };
        plan.layers = self.layers(&plan.layers);
        plan.features = self.features.unwrap_or(plan.features);
        plan.normalise = self.normalise.unwrap_or(plan.normalise);
        plan.precision = self.precision.unwrap_or(plan.precision);
        plan.smoothness = self.smoothness.unwrap_or(plan.smoothness);
        let options = &mut plan.options;
        options.epochs = self.epochs.unwrap_or(options.epochs);
        options.batch = self.batch.unwrap_or(options.batch);
        options.rate = self.learning_rate.unwrap_or(options.rate);
        options.schedule = self.schedule.unwrap_or(options.schedule);
        options.optimiser = self.optimiser.unwrap_or(options.optimiser);
        options.decay = self.weight_decay.unwrap_or(options.decay);
        options.seed = self.training_seed.unwrap_or(options.seed);
        options.goal = self.goal.or(options.goal);
        options.threads = self.threads.or(options.threads);
        plan
    }

    fn layers(&self, before: &Layers) -> Layers {
        let hidden = self.hidden.clone().unwrap_or_else(|| before.hidden.clone());
        Layers { hidden, activation: self.activation.unwrap_or(before.activation) }
    }

    /// A model of a file with the layers that were asked for; its own where none were.
    fn model(&self, model: &Model) -> Model {
        if self.hidden.is_none() && self.activation.is_none() {
            return model.clone();
        }
        model.with_layers(&self.layers(&Layers::default()))
    }
}

/// A setting by its name in files.
fn named<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    serde_json::from_value(text.into()).map_err(|error| error.to_string())
}

fn parse_schedule(text: &str) -> Result<Schedule, String> {
    let known = [("constant", Schedule::Constant), ("cosine", Schedule::COSINE), ("one-cycle", Schedule::ONE_CYCLE)];
    chosen(text, &known)
}

fn parse_optimiser(text: &str) -> Result<Optimiser, String> {
    chosen(text, &[("adamw", Optimiser::ADAM_W), ("soap", Optimiser::SOAP)])
}

fn chosen<T: Copy>(text: &str, known: &[(&str, T)]) -> Result<T, String> {
    let found = known.iter().find(|(name, _)| *name == text).map(|(_, value)| *value);
    let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
    found.ok_or_else(|| format!("choose {}", names.join(", ")))
}

/// A mapping as text, or from a file.
fn parse_mapping(text: &str) -> Result<MappingSpec, String> {
    if !text.ends_with(".toml") {
        return text.parse().map_err(|error: MappingError| error.to_string());
    }
    let content = std::fs::read_to_string(text).map_err(|error| format!("can't read {text}: {error}"))?;
    MappingSpec::from_toml(&content).map_err(|error| error.to_string())
}

/// Files and the model to use on them.
#[derive(Args, Debug, Clone)]
pub struct Data {
    #[command(flatten)]
    files: Files,
    /// The model: a preset (rigid-body, stated-arm, ff-nn, black-box-delan, structured-delan, delan-friction, delan-ffnn), or
    /// a file saved by `train`. Without it: rigid-body.
    #[arg(long)]
    model: Option<String>,
    #[command(flatten)]
    pub training: Training,
    /// Add an effect to the model: its id, and its joints if not all, such as `coulomb-friction@1,2`. May be repeated.
    #[arg(long, value_name = "EFFECT[@JOINTS]")]
    add: Vec<String>,
}

impl Files {
    /// A session with the recording, fitted with the default preset where one fits.
    pub fn session(&self) -> anyhow::Result<Session> {
        progress::run(open_command(&self.files, &self.reading)?, &Session::default())
    }
}

impl OptionalData {
    /// What opens the files, or simulates the embedded recording.
    pub fn command(&self) -> anyhow::Result<Command> {
        if self.files.is_empty() {
            return Ok(Command::Simulate(Box::new(Scenario::embedded())));
        }
        open_command(&self.files, &self.reading)
    }

    /// A session with the files, or with the embedded recording.
    pub fn session_or_embedded(&self) -> anyhow::Result<Session> {
        progress::run(self.command()?, &Session::default())
    }
}

impl Data {
    /// A session with the recording only.
    pub fn session(&self) -> anyhow::Result<Session> {
        self.files.session()
    }

    /// The saved model, if one was named: presets have no ending.
    pub fn model_file(&self) -> Option<PathBuf> {
        let path = Path::new(self.model.as_deref()?);
        (path.extension().is_some() || path.exists()).then(|| path.to_owned())
    }

    /// A session with the recording and the model, identified from the training part, with all effects that were asked for.
    ///
    /// A training that ended early is a warning on standard error: the best weights so far are the model.
    pub fn session_with_model(&self) -> anyhow::Result<Session> {
        let session = self.session_keeping(None)?;
        for step in &session.ladder {
            if let Some(reason) = step.early_end() {
                eprintln!("warning: training ended early: {reason}");
            }
        }
        Ok(session)
    }

    /// The same without the warning; training saves itself in the given file while it runs.
    pub fn session_keeping(&self, checkpoint_file: Option<PathBuf>) -> anyhow::Result<Session> {
        let opened = Session { plan: self.training.plan(), checkpoint_file, ..self.session()? };
        let mut session = match self.model_file() {
            Some(path) => {
                let title = path.display().to_string();
                let model = self.training.model(&read_model(&path)?.model);
                progress::run(Command::UseModel { model, title }, &opened)?
            }
            None => self.with_preset(opened)?,
        };
        let joints = session.recording.as_ref().map_or(0, |recording| recording.joint_count());
        for text in &self.add {
            let (effect, joints) = parse_place(text, joints)?;
            session = progress::run(Command::AddEffect { effect, joints }, &session)?;
        }
        Ok(session)
    }

    /// A session that goes on with the training in this file. The model and the settings that were given must be its own.
    pub fn session_resuming(&self, run: &Path, checkpoint_file: Option<PathBuf>) -> anyhow::Result<Session> {
        let session = Session { checkpoint_file, ..self.session()? };
        let saved = runs::load(run)?;
        if self.model.is_some() || !self.add.is_empty() {
            let asked = self.asked_model(&session, &saved.plan)?;
            if asked != saved.model {
                let labels = |model: &Model| model.terms.iter().map(Term::label).collect::<Vec<_>>().join(" + ");
                bail!(
                    "{} is the checkpoint of another model: it has {}, asked for is {}. Leave out --model and --add, or train anew",
                    run.display(),
                    labels(&saved.model),
                    labels(&asked)
                );
            }
        }
        let plan = self.training.changing(saved.plan.clone());
        let saved = saved.with_plan(plan).with_context(|| run.display().to_string())?;
        progress::run(Command::Resume(Arc::new(saved)), &session)
    }

    /// The model that the options name, before anything is estimated.
    fn asked_model(&self, session: &Session, plan: &Plan) -> anyhow::Result<Model> {
        let recording = session.recording.as_deref().context("no recording was read")?;
        let mut model = match self.model_file() {
            Some(path) => read_model(&path)?.model,
            None => self.preset()?.model(recording)?.with_layers(&plan.layers),
        };
        for text in &self.add {
            let (effect, joints) = parse_place(text, recording.joint_count())?;
            model = model.with_effect(registry::find(&effect)?, &joints)?;
        }
        Ok(model)
    }

    fn preset(&self) -> anyhow::Result<Preset> {
        let name = self.model.as_deref().unwrap_or(Preset::default().id());
        Preset::ALL.into_iter().find(|preset| preset.id() == name).with_context(|| {
            let known: Vec<&str> = Preset::ALL.iter().map(|preset| preset.id()).collect();
            format!("there is no model `{name}`; known: {}, or a file saved by `train`", known.join(", "))
        })
    }

    fn with_preset(&self, session: Session) -> anyhow::Result<Session> {
        let preset = self.preset()?;
        if session.current().is_some() && session.preset == preset {
            return Ok(session);
        }
        progress::run(Command::ChoosePreset(preset), &session)
    }
}

/// Reads a model that `train` saved.
pub fn read_model(path: &Path) -> anyhow::Result<Fitted> {
    let bytes = std::fs::read(path).with_context(|| format!("can't read {}", path.display()))?;
    training::fit::from_bytes(&bytes).with_context(|| format!("{}", path.display()))
}

/// `coulomb-friction@1,3` → the effect and its joints counted from 0; all joints if none are named.
pub fn parse_place(text: &str, joints: usize) -> anyhow::Result<(String, Vec<usize>)> {
    let Some((effect, list)) = text.split_once('@') else { return Ok((text.to_owned(), (0..joints).collect())) };
    let parse = |number: &str| -> anyhow::Result<usize> {
        let joint: usize =
            number.trim().parse().with_context(|| format!("`{number}` in `{text}` is not a joint number"))?;
        joint.checked_sub(1).with_context(|| format!("joints are counted from 1, `{text}` names joint 0"))
    };
    Ok((effect.to_owned(), list.split(',').map(parse).collect::<anyhow::Result<_>>()?))
}

/// Reads an arm file.
pub fn read_arm(path: &Path) -> anyhow::Result<Arm> {
    let text = std::fs::read_to_string(path).with_context(|| format!("can't read the arm file {}", path.display()))?;
    let arm: Arm = serde_json::from_str(&text).with_context(|| {
        format!("{} is not an arm file (JSON with `links`, each with mass, length, com, inertia)", path.display())
    })?;
    arm.check().with_context(|| format!("{}", path.display()))?;
    Ok(arm)
}

fn open_command(files: &[PathBuf], reading: &Reading) -> anyhow::Result<Command> {
    let zero = reading.zero.map(|zero| match zero {
        Zero::Down => Posture::DOWN,
        Zero::Right => Posture::RIGHT,
        Zero::Up => Posture::UP,
    });
    let arm = reading.arm.as_deref().map(read_arm).transpose()?;
    let options = ReadOptions {
        mapping: reading.map.clone(),
        zero,
        arm,
        rate_hz: reading.rate,
        low_pass_hz: reading.low_pass,
        ..ReadOptions::default()
    };
    let mut paths = files.to_vec();
    let mut held_out = Vec::new();
    for path in &reading.held_out {
        // A trajectory is named like its file, or as `inspect` shows it.
        if path.exists() {
            held_out.push(path.file_stem().unwrap_or_default().to_string_lossy().into_owned());
            if !paths.contains(path) {
                paths.push(path.clone());
            }
        } else {
            held_out.push(path.to_string_lossy().into_owned());
        }
    }
    Ok(Command::Open { paths, options, held_out })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_counted_from_one() {
        assert_eq!(parse_place("coulomb-friction@1,3", 3).unwrap(), ("coulomb-friction".into(), vec![0, 2]));
        assert_eq!(parse_place("tip-payload", 2).unwrap(), ("tip-payload".into(), vec![0, 1]));
        assert!(parse_place("viscous-friction@0", 2).is_err());
        assert!(parse_place("viscous-friction@x", 2).unwrap_err().to_string().contains("not a joint"));
    }
}
