//! Arguments that name data and a model, shared by the commands.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use anyhow::{Context, anyhow};
use clap::builder::RangedU64ValueParser;
use clap::{Args, ValueEnum};

use super::choice::{Choice, one_of};
use super::failure::OrUsage;
use super::progress;
use super::saved::{Of, Saved};
use super::table::number;
use crate::arm::robot::{self, SerialArm};
use crate::arm::{Arm, Posture};
use crate::effect::place::Place;
use crate::export::files::check_output;
use crate::file;
use crate::model::learned::{Features, Layers, MOST_NEURONS};
use crate::model::{Fitted, Model, Preset};
use crate::network::Activation;
use crate::progress::Monitor;
use crate::recording::correction::Correction;
use crate::recording::encoders::Side;
use crate::recording::hold_out::HoldOut;
use crate::recording::mapping::{MappingError, MappingSpec};
use crate::recording::read::{READABLE, ReadOptions, endings, parts};
use crate::recording::torque::{TorqueFact, TorqueFacts};
use crate::recording::{Recording, catalogue};
use crate::session::{self, Command, Document, Session, default_name, runs};
use crate::simulation::Scenario;
use crate::training::fit::Plan;
use crate::training::optimiser::Optimiser;
use crate::training::schedule::Schedule;
use crate::training::{Precision, Recipe};

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
    /// Which fifth is held out where none is named, of the trajectories or, with fewer than four, of time blocks: 1 to 5. Another
    /// than the first is for a log in which something acts in the held-out part alone.
    #[arg(long, value_name = "NUMBER", conflicts_with = "held_out", value_parser = RangedU64ValueParser::<usize>::new().range(1..=5))]
    held_out_fifth: Option<usize>,
    /// Which column is which channel, such as `q=pos_filt*,qd=vel_filt*,tau=tau_meas*,time=time` (`*` is the joint); or a
    /// mapping file, which can state factors, matrices and axes too; or one that comes with the program: emps, kuka-kr300,
    /// panda, sarcos, tx40, ur10.
    #[arg(long, value_name = "MAP|FILE.toml|NAME", value_parser = parse_mapping)]
    map: Option<MappingSpec>,
    /// Where the arm points at q = 0, if the file does not say it.
    #[arg(long)]
    zero: Option<Zero>,
    /// The arm's stated masses and lengths (JSON: links, gravity, posture); or the URDF or MJCF (.xml) of a serial arm, whose axes
    /// are taken; its masses are identified, and what it states of them stands beside (or is the model, `--model stated-arm`).
    #[arg(long, value_name = "ARM.json|URDF|MJCF")]
    arm: Option<PathBuf>,
    /// Of a URDF or MJCF with more joints than those of one arm (a hand, a second arm): these move, all others are fixed.
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', requires = "arm")]
    arm_joints: Vec<String>,
    /// What the torque is, as nothing in the numbers tells it, such as `commanded,without-friction`.
    #[arg(long, value_name = "FACT,…", value_delimiter = ',', value_parser = one_of(facts()))]
    torque: Vec<TorqueFact>,
    /// On which side of the gears the encoders are, as nothing in the numbers tells it for certain.
    #[arg(long, value_name = "SIDE", value_parser = one_of(sides()))]
    encoders: Option<Side>,
    /// Sampling rate [Hz] of files without a time column.
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
    /// Cut-off of the filter for velocity and acceleration that are derived [Hz].
    #[arg(long, value_name = "HZ")]
    low_pass: Option<f64>,
    /// Smooths them by a Gaussian of this width instead [samples]: 1 as for published models of dynamics.
    #[arg(long, value_name = "SAMPLES", conflicts_with = "low_pass")]
    gaussian: Option<f64>,
    /// Set right how the log is set up, as `inspect` proposes it: `zero=down`, `sign-torque@2`, `order-torque=2,1`,
    /// `angles=absolute`, `factor-velocity@1=0.1`, `delay-torque=0.02`, `play@1=0.3,0.12,0.04`. May be repeated.
    #[arg(long, value_name = "CORRECTION")]
    set_right: Vec<Correction>,
    #[command(flatten)]
    own: OwnEffects,
}

/// Effects of one's own.
#[derive(Args, Debug, Clone, Default)]
pub struct OwnEffects {
    /// An effect of your own: a file with its formula (MANUAL.md tells how). It is sought by a diagnosis beside those of the
    /// catalogue, and --add knows its id. May be repeated.
    #[arg(long, value_name = "EFFECT.toml")]
    effect_file: Vec<PathBuf>,
}

impl OwnEffects {
    /// An empty session that knows them.
    pub fn session(&self) -> anyhow::Result<Session> {
        let load = |session: Session, path: &PathBuf| {
            Command::LoadEffect { path: path.clone() }.run(&session, &Monitor::new()).or_usage()
        };
        self.effect_file.iter().try_fold(Session::default(), load)
    }
}

impl Reading {
    /// Whether nothing was given that says how files are read.
    fn is_empty(&self) -> bool {
        let Reading {
            held_out,
            held_out_fifth,
            map,
            zero,
            arm,
            arm_joints: _,
            torque,
            encoders,
            rate,
            low_pass,
            gaussian,
            set_right,
            own: _,
        } = self;
        let is_numberless = rate.is_none() && low_pass.is_none() && gaussian.is_none() && torque.is_empty();
        let is_shapeless = zero.is_none() && arm.is_none() && encoders.is_none() && set_right.is_empty();
        let holds_out_none = held_out.is_empty() && held_out_fifth.is_none();
        holds_out_none && map.is_none() && is_numberless && is_shapeless
    }
}

/// The help about files to read; `more` is what else may be given.
fn recordings_help(more: &str) -> String {
    format!(
        "Recordings ({READABLE}, or a folder of NPY arrays); several files are trajectories of one arm, and `FILE+FILE` are files \
         with channels of the same samples; `gallery/NAME` is one that comes with the program{more}"
    )
}

/// Files to read, and how.
#[derive(Args, Debug, Clone)]
pub struct Files {
    #[arg(required = true, help = recordings_help(""))]
    files: Vec<PathBuf>,
    #[command(flatten)]
    reading: Reading,
}

/// Files that need not be given: without, the embedded recording is taken.
#[derive(Args, Debug, Clone)]
pub struct OptionalData {
    #[arg(help = recordings_help("; or a saved session (.torquescope). Without any: an embedded arm with a hidden effect"))]
    files: Vec<PathBuf>,
    #[command(flatten)]
    reading: Reading,
}

/// A recording beside the model of a file.
#[derive(Args, Debug, Clone)]
pub struct OptionalLog {
    /// Recordings of the arm: the states of the test are taken from them, and shares of the torque are measured there.
    #[arg(long, value_name = "FILE", num_args = 1..)]
    log: Vec<PathBuf>,
    #[command(flatten)]
    reading: Reading,
}

impl OptionalLog {
    /// All files that are read for it.
    pub fn inputs(&self) -> Vec<PathBuf> {
        inputs(&self.log, &self.reading)
    }

    /// The recording that was named, or else that which was saved with the model; it must have the joints of the model.
    pub fn recording_for(&self, saved: &Saved) -> anyhow::Result<Option<Arc<Recording>>> {
        let Saved { fitted, recording } = saved;
        if self.log.is_empty() {
            return Ok(recording.clone());
        }
        let session = progress::run(open_command(&self.log, &self.reading)?, &self.reading.own.session()?)?;
        let recording = session.recording.context("no recording was read")?;
        let joints = fitted.setting().kinds.len();
        if recording.joint_count() != joints {
            let found = recording.joint_count();
            return Err(anyhow!("the model has {joints} joints, the log {found}: name a log of its arm")).or_usage();
        }
        Ok(Some(recording))
    }
}

/// The heading under which help shows them.
pub const TRAINING: &str = "Training of networks";

/// How networks are trained; not used by models without networks. Whatever stands behind these in a command's struct comes
/// under their heading, so they stand last.
#[derive(Args, Debug, Clone)]
#[command(next_help_heading = TRAINING)]
pub struct Training {
    /// Settings to start from; without it: ours.
    #[arg(long, value_parser = one_of(RECIPES))]
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
    /// Course of the learning rate.
    #[arg(long, value_parser = one_of(SCHEDULES))]
    schedule: Option<Schedule>,
    /// How weights follow from gradients.
    #[arg(long, value_parser = one_of(OPTIMISERS))]
    optimiser: Option<Optimiser>,
    /// Weight decay, per unit of learning rate.
    #[arg(long)]
    weight_decay: Option<f64>,
    /// Widths of the hidden layers, such as `64,64`.
    #[arg(long, value_name = "WIDTHS", value_delimiter = ',', value_parser = RangedU64ValueParser::<usize>::new().range(WIDTHS))]
    hidden: Option<Vec<usize>>,
    /// Their activation.
    #[arg(long, value_parser = one_of(ACTIVATIONS))]
    activation: Option<Activation>,
    /// How positions enter the networks; if it is not said, as suits the arm: the directions of links into a Lagrangian of a planar
    /// arm, cos q and sin q into every other network.
    #[arg(long, value_parser = one_of(FEATURES))]
    features: Option<Features>,
    /// Divides velocities and accelerations that enter networks; with more than 1 these bend less where they were not trained.
    #[arg(long)]
    smoothness: Option<f64>,
    /// Whether a Cholesky factor keeps a learned mass matrix positive definite; false shows what becomes of one that nothing keeps so.
    #[arg(long, value_name = "BOOL")]
    cholesky: Option<bool>,
    /// Whether quantities are scaled to the data: true, or false as in the paper.
    #[arg(long, value_name = "BOOL")]
    normalise: Option<bool>,
    /// What is calculated with.
    #[arg(long, value_parser = one_of(PRECISIONS))]
    precision: Option<Precision>,
    /// Ends as soon as the nMSE of the validation part is this low.
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
    pub fn plan(&self) -> anyhow::Result<Plan> {
        let plan = self.changing(Plan::of(self.recipe.unwrap_or_default()));
        plan.options.check().or_usage()?;
        Ok(plan)
    }

    /// This plan with the options that were given.
    pub fn changing(&self, plan: Plan) -> Plan {
        let mut plan = match self.recipe {
            Some(recipe) if recipe != plan.recipe => Plan::of(recipe),
            _ => plan,
        };
        plan.layers = self.layers(&plan.layers);
        plan.features = self.features.or(plan.features);
        plan.normalise = self.normalise.unwrap_or(plan.normalise);
        plan.precision = self.precision.unwrap_or(plan.precision);
        plan.smoothness = self.smoothness.unwrap_or(plan.smoothness);
        plan.cholesky = self.cholesky.unwrap_or(plan.cholesky);
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
        match model.layers() {
            Some(layers) if self.hidden.is_some() || self.activation.is_some() => {
                model.with_layers(&self.layers(layers))
            }
            _ => model.clone(),
        }
    }
}

/// Neurons that a layer may have.
const WIDTHS: RangeInclusive<u64> = 1..=MOST_NEURONS as u64;

const RECIPES: [Choice<Recipe>; 3] = [
    ("ours", "converges quickest", Recipe::Ours),
    ("thorough", "ours for five times as long", Recipe::Thorough),
    ("paper", "table 1 of the paper: Adam at a constant rate for 2,500 epochs", Recipe::Paper),
];

const SCHEDULES: [Choice<Schedule>; 3] = [
    ("constant", "the same all the time", Schedule::Constant),
    ("cosine", "a warm-up, then half a cosine down", Schedule::COSINE),
    ("one-cycle", "up and down once", Schedule::ONE_CYCLE),
];

const OPTIMISERS: [Choice<Optimiser>; 2] = [
    ("adamw", "Adam with decoupled weight decay", Optimiser::ADAM_W),
    ("soap", "Adam in the eigenbasis of Shampoo's preconditioner", Optimiser::SOAP),
];

const ACTIVATIONS: [Choice<Activation>; 4] = [
    ("tanh", "tanh x", Activation::Tanh),
    ("sigmoid", "1 / (1 + exp(-x))", Activation::Sigmoid),
    ("softplus", "ln(1 + exp(x))", Activation::Softplus),
    ("silu", "x / (1 + exp(-x))", Activation::Silu),
];

const FEATURES: [Choice<Features>; 3] = [
    ("cos-sin", "cos q and sin q of each joint", Features::CosSin),
    ("link-angles", "cos and sin of every sum of neighbouring joint angles", Features::LinkAngles),
    ("raw", "q itself", Features::Raw),
];

const PRECISIONS: [Choice<Precision>; 2] =
    [("f32", "single precision", Precision::F32), ("f64", "double precision", Precision::F64)];

fn sides() -> [Choice<Side>; 2] {
    Side::ALL.map(|side| (side.name(), side.about(), side))
}

fn facts() -> [Choice<TorqueFact>; 6] {
    TorqueFact::ALL.map(|fact| (fact.name(), fact.about(), fact))
}

/// A mapping as text, from a file, or by the name under which it comes with the program.
fn parse_mapping(text: &str) -> Result<MappingSpec, String> {
    if text.contains('=') {
        return text.parse().map_err(|error: MappingError| error.to_string());
    }
    if !text.ends_with(".toml") {
        let known = catalogue::mapping(text);
        return known.map_err(|unknown| format!("{unknown}; or give a file .toml, or columns such as q=pos*,tau=tau*"));
    }
    let content = file::read_text(Path::new(text)).map_err(|error| format!("can't read {text}: {error}"))?;
    MappingSpec::from_toml(&content).map_err(|error| error.to_string())
}

/// What a model starts from.
#[derive(Debug, Clone)]
enum Start {
    Preset(Preset),
    File(PathBuf),
}

impl Default for Start {
    fn default() -> Self {
        Start::Preset(Preset::default())
    }
}

impl FromStr for Start {
    type Err = String;

    /// Presets have no ending.
    fn from_str(text: &str) -> Result<Self, String> {
        let path = Path::new(text);
        if path.is_file() {
            return Ok(Start::File(path.to_owned()));
        }
        let preset = Preset::ALL.into_iter().find(|preset| preset.id() == text);
        preset.map(Start::Preset).ok_or_else(|| {
            let known: Vec<&str> = Preset::ALL.iter().map(|preset| preset.id()).collect();
            format!(
                "there is no model and no file `{text}`; known models: {}, or a file saved by `train`, or a saved session",
                known.join(", ")
            )
        })
    }
}

/// Files and the model to use on them.
#[derive(Args, Debug, Clone)]
pub struct Data {
    #[command(flatten)]
    files: Files,
    /// The model: a preset (rigid-body, stated-arm, ff-nn, black-box-delan, structured-delan, delan-friction, delan-ffnn), or
    /// a file saved by `train`, or a saved session (.torquescope), whose current model it is. Without it: rigid-body; where a saved
    /// session stands in place of recordings, its current model.
    #[arg(long, value_name = "PRESET|FILE")]
    model: Option<Start>,
    #[command(flatten)]
    of: Of,
    /// Add an effect to the model: its id (see `torquescope effects`), and its joints if not all, such as
    /// `coulomb-friction@1,2`. May be repeated.
    #[arg(long, value_name = "EFFECT[@JOINTS]")]
    add: Vec<String>,
    #[command(flatten)]
    pub training: Training,
}

/// All files that are read for a recording; files that are read side by side are `FILE+FILE`.
fn inputs(files: &[PathBuf], reading: &Reading) -> Vec<PathBuf> {
    let all = files.iter().chain(&reading.held_out).chain(&reading.arm);
    all.flat_map(|path| parts(path)).collect()
}

/// Whether it is a saved session that stands in place of recordings.
fn is_saved_session(files: &[PathBuf]) -> bool {
    matches!(files, [one] if session::file::is_session(one))
}

impl Files {
    /// Refuses to write a result over what it is made of.
    pub fn check_output(&self, output: &Path) -> anyhow::Result<()> {
        check_output(output, &inputs(&self.files, &self.reading)).or_usage()
    }

    /// A session with the recording, fitted with the default preset where one fits.
    pub fn session(&self) -> anyhow::Result<Session> {
        progress::run(open_command(&self.files, &self.reading)?, &self.reading.own.session()?)
    }

    /// A session with the recording only: nothing is identified from it.
    pub fn opened(&self) -> anyhow::Result<Session> {
        progress::open(open_command(&self.files, &self.reading)?, &self.reading.own.session()?)
    }
}

impl OptionalData {
    /// Refuses to write a result over what it is made of.
    pub fn check_output(&self, output: &Path) -> anyhow::Result<()> {
        check_output(output, &inputs(&self.files, &self.reading)).or_usage()
    }

    /// The files that were named.
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// What opens the files or a saved session, or simulates the embedded recording.
    pub fn command(&self) -> anyhow::Result<Command> {
        match self.files.as_slice() {
            [] => Ok(Command::Simulate(Box::new(Scenario::embedded()))),
            files => open_command(files, &self.reading),
        }
    }

    /// A session with the files, or with the embedded recording; of a saved one also where one looked.
    pub fn document_or_embedded(&self) -> anyhow::Result<Document> {
        match self.command()? {
            Command::Restore { path } => self.restored(&path),
            command => Ok(progress::run(command, &self.start()?)?.into()),
        }
    }

    /// Two saved sessions, if it is these that were named, each with its path.
    pub fn two_sessions(&self) -> anyhow::Result<Option<[(&Path, Document); 2]>> {
        let is_session = |path: &&PathBuf| session::file::is_session(path);
        let sessions: Vec<&PathBuf> = self.files.iter().filter(is_session).collect();
        match sessions.as_slice() {
            [] | [_] if self.files.len() == sessions.len() || sessions.is_empty() => Ok(None),
            [one, two] if self.files.len() == 2 && self.reading.is_empty() => {
                Ok(Some([(one, self.restored(one)?), (two, self.restored(two)?)]))
            }
            _ => Err(anyhow!(
                "saved sessions are read alone, or two beside each other, without logs and without --map, --zero and the like"
            ))
            .or_usage(),
        }
    }

    fn restored(&self, path: &Path) -> anyhow::Result<Document> {
        let (path, start) = (path.to_owned(), self.start()?);
        let opened = progress::watch("open the session", move |monitor| session::file::open(&path, monitor))?;
        Ok(opened.document.knowing(&start.own_effects))
    }

    /// What the command is given: an empty session that knows the effects of one's own.
    pub fn start(&self) -> anyhow::Result<Session> {
        self.reading.own.session()
    }
}

impl Data {
    /// Refuses to write a result over what it is made of.
    pub fn check_output(&self, output: &Path) -> anyhow::Result<()> {
        let Files { files, reading } = &self.files;
        let model = self.model_file().map(Path::to_owned);
        let inputs: Vec<PathBuf> = inputs(files, reading).into_iter().chain(model).collect();
        check_output(output, &inputs).or_usage()
    }

    /// A session with the recording only.
    pub fn session(&self) -> anyhow::Result<Session> {
        self.files.session()
    }

    fn model_file(&self) -> Option<&Path> {
        match self.model.as_ref()? {
            Start::File(path) => Some(path),
            Start::Preset(_) => None,
        }
    }

    /// The saved model, if one was named.
    pub fn saved_model(&self) -> anyhow::Result<Option<Fitted>> {
        self.model_file().map(|path| Ok(self.of.read(path)?.fitted)).transpose()
    }

    /// Whether the model is one of the saved session that stands in place of recordings.
    fn is_of_session(&self) -> bool {
        self.model.is_none() && is_saved_session(&self.files.files)
    }

    /// What is opened; of a saved session with the model that is meant as its current one.
    fn opened(&self) -> anyhow::Result<Session> {
        match (self.is_of_session(), self.model_file()) {
            (true, _) => self.of.taken_up(&self.session()?),
            (false, Some(_)) => self.session(),
            (false, None) => self.of.refuse_without_session().and_then(|()| self.session()),
        }
    }

    /// A session with the recording and the model, identified from the training part, with all effects that were asked for.
    ///
    /// A training that ended early is a warning on standard error: the best weights so far are the model.
    pub fn session_with_model(&self) -> anyhow::Result<Session> {
        let session = self.session_keeping(None)?;
        for step in &session.ladder {
            if let Some(reason) = step.early_end() {
                progress::remark(format_args!("warning: training ended early: {reason}"));
            }
        }
        Ok(session)
    }

    /// The effects to add. They are looked for when those of one's own are known, so that the order of options does not matter.
    fn places(&self) -> anyhow::Result<Vec<Place>> {
        self.files.reading.own.session()?;
        let place = |text: &String| text.parse::<Place>().with_context(|| format!("--add {text}"));
        self.add.iter().map(place).collect::<anyhow::Result<_>>().or_usage()
    }

    /// Whether the model that is asked for has networks.
    pub fn asks_for_networks(&self) -> anyhow::Result<bool> {
        Ok(match &self.model {
            Some(Start::File(path)) => self.of.read(path)?.fitted.model.is_learned(),
            Some(Start::Preset(preset)) => matches!(preset, Preset::Learned(_)),
            None => false,
        })
    }

    /// The same without the warning; training saves itself in the given file while it runs.
    pub fn session_keeping(&self, checkpoint_file: Option<PathBuf>) -> anyhow::Result<Session> {
        let plan = self.training.plan()?;
        let places = self.places()?;
        let start = match self.model.clone().unwrap_or_default() {
            Start::File(path) => Command::UseModel { model: self.training.model(&self.of.read(&path)?.fitted.model) },
            Start::Preset(preset) => Command::ChoosePreset(preset),
        };
        let opened = Session { plan, checkpoint_file, ..self.opened()? };
        if let Some(model) = self.networks_with_effects(&start, &opened)? {
            return progress::run(Command::UseModel { model }, &opened);
        }
        // Of a recording the preset was fitted as it was opened; a saved session has gone on from its own.
        let is_there = |preset| match is_saved_session(&self.files.files) {
            true => self.is_of_session() && opened.current().is_some(),
            false => opened.current().is_some() && opened.preset == preset,
        };
        let mut session = match start {
            Command::ChoosePreset(preset) if is_there(preset) => opened,
            start => progress::run(start, &opened)?,
        };
        let joints = session.recording.as_ref().map_or(0, |recording| recording.joint_count());
        for place in places {
            let add =
                Command::AddEffect { effect: place.effect.id.to_owned(), joints: place.joints(joints).or_usage()? };
            session = progress::run(add, &session)?;
        }
        Ok(session)
    }

    /// The whole model, if it has networks and effects beside them: these are trained together, once. So the checkpoint of the
    /// training has all that was asked for, and what is resumed from it too.
    fn networks_with_effects(&self, start: &Command, session: &Session) -> anyhow::Result<Option<Model>> {
        let recording = session.recording.as_deref().context("no recording was read")?;
        let model = match start {
            Command::UseModel { model } => model.clone(),
            Command::ChoosePreset(preset) => match preset {
                Preset::Learned(_) => session.plan.shaped(&preset.model(recording)?),
                Preset::RigidBody | Preset::StatedArm => return Ok(None),
            },
            _ => return Ok(None),
        };
        let is_both = model.is_learned() && !self.add.is_empty();
        is_both.then(|| self.with_effects(model, recording.joint_count())).transpose()
    }

    /// A model with all effects that were asked for.
    fn with_effects(&self, mut model: Model, joints: usize) -> anyhow::Result<Model> {
        for place in self.places()? {
            model = model.with_effect(place.effect, &place.joints(joints).or_usage()?)?;
        }
        Ok(model)
    }

    /// A session that goes on with the training in this file. The model and the settings that were given must be its own.
    pub fn session_resuming(&self, run: &Path, checkpoint_file: Option<PathBuf>) -> anyhow::Result<Session> {
        let saved = runs::load(run).or_usage()?;
        let session = Session { checkpoint_file, ..self.session()? };
        if self.model.is_some() || !self.add.is_empty() {
            let asked = self.asked_model(&session, &saved.plan)?;
            if asked != saved.model {
                let (saved, asked) = (default_name(&saved.model), default_name(&asked));
                return Err(anyhow!(
                    "{} is the checkpoint of another model: it has {saved}, asked for is {asked}. Leave out --model and --add, or \
                     train anew",
                    run.display()
                ))
                .or_usage();
            }
        }
        let plan = self.training.changing(saved.plan.clone());
        let saved = saved.with_plan(plan).with_context(|| run.display().to_string()).or_usage()?;
        progress::run(Command::Resume(Arc::new(saved)), &session)
    }

    /// The model that the options name, before anything is estimated.
    fn asked_model(&self, session: &Session, plan: &Plan) -> anyhow::Result<Model> {
        let recording = session.recording.as_deref().context("no recording was read")?;
        let model = match self.model.clone().unwrap_or_default() {
            Start::File(path) => self.of.read(&path)?.fitted.model,
            Start::Preset(preset) => plan.shaped(&preset.model(recording)?),
        };
        self.with_effects(model, recording.joint_count())
    }
}

/// Reads an arm file.
pub fn read_arm(path: &Path) -> anyhow::Result<Arm> {
    let read = || {
        let text = file::read_text(path).with_context(|| format!("can't read the arm file {}", path.display()))?;
        let arm: Arm = serde_json::from_str(&text).with_context(|| {
            format!("{} is not an arm file (JSON with `links`, each with mass, length, com, inertia)", path.display())
        })?;
        arm.check().with_context(|| format!("{}", path.display()))?;
        anyhow::Ok(arm)
    };
    read().or_usage()
}

/// A mapping with the axes of a robot's file.
fn with_axes_of(mapping: MappingSpec, path: &Path, joints: &[String]) -> anyhow::Result<MappingSpec> {
    let text = file::read_text(path).with_context(|| format!("can't read {}", path.display())).or_usage()?;
    let arm = SerialArm::moving_only(&text, joints).with_context(|| path.display().to_string()).or_usage()?;
    let names: Vec<&str> = arm.joints.iter().map(|joint| joint.name.as_str()).collect();
    progress::remark(format_args!("the axes of {}: {}", path.display(), names.join(", ")));
    let unweighed: Vec<&str> = arm.unweighed().collect();
    if arm.mass() > 0.0 {
        let but = if unweighed.is_empty() { "" } else { "; it says nothing of " };
        progress::remark(format_args!(
            "it states that {} kg move (--model stated-arm){but}{}",
            number(arm.mass()),
            unweighed.join(", ")
        ));
    }
    arm.plane_told().iter().for_each(progress::remark);
    mapping.with_axes_of(&arm).with_context(|| path.display().to_string()).or_usage()
}

/// Trajectories are named without the ending of their file.
fn is_named_like_a_log(path: &Path) -> bool {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    ending.is_some_and(|ending| endings().any(|known| known == ending))
}

fn open_command(files: &[PathBuf], reading: &Reading) -> anyhow::Result<Command> {
    if is_saved_session(files) && !reading.is_empty() {
        return Err(anyhow!("a saved session says itself how it was read: leave out --map, --zero and the like"))
            .or_usage();
    }
    let zero = reading.zero.map(|zero| match zero {
        Zero::Down => Posture::DOWN,
        Zero::Right => Posture::RIGHT,
        Zero::Up => Posture::UP,
    });
    let is_robot = |path: &&Path| robot::is_named_like_one(path);
    let (robot, arm) = (reading.arm.as_deref().filter(is_robot), reading.arm.as_deref().filter(|path| !is_robot(path)));
    let arm = arm.map(read_arm).transpose()?;
    let mapping = match robot {
        Some(path) => Some(with_axes_of(reading.map.clone().unwrap_or_default(), path, &reading.arm_joints)?),
        None => reading.map.clone(),
    };
    let torque = TorqueFacts::new(reading.torque.iter().copied()).context("--torque").or_usage()?;
    let options = ReadOptions {
        mapping,
        zero,
        arm,
        torque: (!torque.is_empty()).then_some(torque),
        encoders: reading.encoders,
        rate_hz: reading.rate,
        low_pass_hz: reading.low_pass,
        gaussian_samples: reading.gaussian,
        set_right: reading.set_right.clone(),
        ..ReadOptions::default()
    };
    options.check().or_usage()?;
    let mut paths = files.to_vec();
    let mut held_out = Vec::new();
    for path in &reading.held_out {
        // A trajectory is named like its file, or as `inspect` shows it.
        if path.exists() {
            held_out.push(path.file_stem().unwrap_or_default().to_string_lossy().into_owned());
            if !paths.contains(path) {
                paths.push(path.clone());
            }
        } else if is_named_like_a_log(path) {
            return Err(anyhow!("--held-out: there is no file {}", path.display())).or_usage();
        } else {
            held_out.push(path.to_string_lossy().into_owned());
        }
    }
    let held_out = reading.held_out_fifth.map_or_else(|| HoldOut::named(held_out), |number| HoldOut::Fifth(number - 1));
    Ok(Command::open(paths, options, held_out))
}

#[cfg(test)]
mod tests {
    use serde::Serialize;

    use super::*;

    /// A setting has one name, on the command line and in files.
    #[test]
    fn choices_are_named_as_in_files() {
        fn check<T: Serialize>(choices: &[Choice<T>]) {
            for (name, _, value) in choices {
                assert_eq!(serde_json::to_value(value).unwrap(), *name);
            }
        }
        check(&RECIPES);
        check(&ACTIVATIONS);
        check(&FEATURES);
        check(&PRECISIONS);
    }

    #[test]
    fn help_tells_every_mapping_and_every_preset() {
        let command = Data::augment_args(clap::Command::new("data"));
        let help = |id: &str| {
            let argument = command.get_arguments().find(|argument| argument.get_id() == id).unwrap();
            argument.get_help().unwrap().to_string()
        };
        for (name, _) in catalogue::ALL {
            assert!(help("map").contains(name), "{name}");
        }
        for preset in Preset::ALL {
            assert!(help("model").contains(preset.id()), "{}", preset.id());
        }
    }
}
