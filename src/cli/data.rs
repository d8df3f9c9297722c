//! Arguments that name data and a model, shared by the commands.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, ValueEnum};

use super::progress;
use crate::arm::{Arm, Posture};
use crate::model::{Fitted, Preset};
use crate::recording::mapping::MappingSpec;
use crate::recording::read::ReadOptions;
use crate::session::{Command, Session};
use crate::simulation::Scenario;
use crate::training::fit::Plan;
use crate::training::{self, Recipe};

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
    /// Which column is which channel, such as `q=pos_filt*,qd=vel_filt*,tau=tau_meas*,time=time` (`*` is the joint).
    #[arg(long, value_name = "MAP")]
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
    /// Recordings (CSV or NPZ); several files are trajectories of one arm.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    reading: Reading,
}

/// Files that need not be given: without, the embedded recording is taken.
#[derive(Args, Debug, Clone)]
pub struct OptionalData {
    /// Recordings (CSV or NPZ); several files are trajectories of one arm. Without any: an embedded arm with a hidden effect.
    files: Vec<PathBuf>,
    #[command(flatten)]
    reading: Reading,
}

/// How networks are trained; not used by models without networks.
#[derive(Args, Debug, Clone)]
pub struct Training {
    /// Settings to start from: `ours` converges quickest, `paper` is table 1 of the paper.
    #[arg(long, default_value = "ours", value_parser = parse_recipe)]
    recipe: Recipe,
    /// How often every sample is seen.
    #[arg(long)]
    epochs: Option<u64>,
    /// Samples in a step.
    #[arg(long)]
    batch: Option<usize>,
    /// Highest learning rate.
    #[arg(long)]
    learning_rate: Option<f64>,
    /// Seed of first weights and of the order of samples.
    #[arg(long, default_value_t = 0)]
    training_seed: u64,
    /// Threads; the result does not depend on them.
    #[arg(long)]
    threads: Option<usize>,
}

impl Training {
    /// The plan that these options make.
    pub fn plan(&self) -> Plan {
        let mut plan = Plan::of(self.recipe);
        let options = &mut plan.options;
        options.epochs = self.epochs.unwrap_or(options.epochs);
        options.batch = self.batch.unwrap_or(options.batch);
        options.rate = self.learning_rate.unwrap_or(options.rate);
        options.threads = self.threads;
        options.seed = self.training_seed;
        plan
    }
}

fn parse_recipe(text: &str) -> Result<Recipe, String> {
    match text {
        "ours" => Ok(Recipe::Ours),
        "paper" => Ok(Recipe::Paper),
        other => Err(format!("there is no recipe `{other}`: choose ours or paper")),
    }
}

/// Files and the model to use on them.
#[derive(Args, Debug, Clone)]
pub struct Data {
    #[command(flatten)]
    files: Files,
    /// The model: a preset (rigid-body, stated-arm, ff-nn, black-box-delan, structured-delan, delan-friction, delan-ffnn), or
    /// a file saved by `train`.
    #[arg(long, default_value = "rigid-body")]
    model: String,
    #[command(flatten)]
    training: Training,
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
        let path = Path::new(&self.model);
        (path.extension().is_some() || path.exists()).then(|| path.to_owned())
    }

    /// A session with the recording and the model, identified from the training part, with all effects that were asked for.
    pub fn session_with_model(&self) -> anyhow::Result<Session> {
        let mut session = match self.model_file() {
            Some(path) => {
                let command = Command::UseModel { model: read_model(&path)?.model, title: self.model.clone() };
                progress::run(command, &self.session()?)?
            }
            None => self.session_with_preset()?,
        };
        let joints = session.recording.as_ref().map_or(0, |recording| recording.joint_count());
        for text in &self.add {
            let (effect, joints) = parse_place(text, joints)?;
            session = progress::run(Command::AddEffect { effect, joints }, &session)?;
        }
        Ok(session)
    }

    fn session_with_preset(&self) -> anyhow::Result<Session> {
        let preset = Preset::ALL.into_iter().find(|preset| preset.id() == self.model).with_context(|| {
            let known: Vec<&str> = Preset::ALL.iter().map(|preset| preset.id()).collect();
            format!("there is no model `{}`; known: {}, or a file saved by `train`", self.model, known.join(", "))
        })?;
        let session = Session { plan: self.training.plan(), ..self.session()? };
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
