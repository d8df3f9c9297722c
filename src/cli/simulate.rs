use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::Context;
use clap::builder::RangedU64ValueParser;
use clap::{Args, ValueEnum};
use serde::Serialize;

use super::choice::level;
use super::data::read_arm;
use super::failure::OrUsage;
use super::world::InWorld;
use super::{convert, progress};
use crate::arm::{Arm, MOST_JOINTS};
use crate::effect::place::{Place, PlaceError};
use crate::file;
use crate::recording::seal::HiddenEffect;
use crate::simulation::{Excitation, Level, Making, Scenario, world};

/// Simulate a recording, with hidden effects whose truth is sealed in the file.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope simulate --effect stribeck-friction@2 --strength 0.1 -o arm.npz
  torquescope simulate --embedded -o embedded.npz
  torquescope simulate --mystery --seed 5 -o mystery.npz
  torquescope simulate --mystery=real --seed 5 -o real.npz
  torquescope simulate --joints 3 --motion paper --trajectories 200 --effect viscous-friction=0.5 -o paper.npz
  torquescope simulate --world --class realistic --seed 7 -o world.npz
  torquescope simulate --world --part backlash@2 --part payload --strength 0.05 -o worn.npz
  torquescope simulate --world --motion pick-and-place --trajectories 1 --part 'kind = \"cogging\", joint = 2, torque = 0.5, wave_number = 20' -o cogging.npz")]
pub struct Simulate {
    /// Where to save the recording: NPZ, which keeps the sealed truth; CSV, Parquet or MCAP, or a folder for a CSV of each run.
    #[arg(short, long, value_name = "RECORDING.npz|csv|parquet|mcap|FOLDER")]
    output: PathBuf,
    /// A whole scenario (JSON, or TOML with --world); the options below are then not used, except the seed.
    #[arg(long, value_name = "SCENARIO")]
    scenario: Option<PathBuf>,
    /// The arm that the program begins with where no recording is named, with its hidden effect; the options below
    /// are then not used.
    #[arg(long, conflicts_with_all = ["scenario", "mystery", "effect", "world"])]
    embedded: bool,
    /// Hide what the seed draws, so hard to find; open the seal to learn what it was.
    #[arg(long, value_name = "LEVEL", num_args = 0..=1, require_equals = true, default_missing_value = "medium", value_parser = level())]
    mystery: Option<Level>,
    /// The arm (JSON: links, gravity, posture).
    #[arg(long, value_name = "ARM.json", conflicts_with = "joints")]
    arm: Option<PathBuf>,
    /// An arm of so many uniform rods of 1 m and 1 kg, instead of the embedded three-joint arm.
    #[arg(long, value_parser = RangedU64ValueParser::<usize>::new().range(1..=MOST_JOINTS as u64))]
    joints: Option<usize>,
    /// How the arm is moved.
    #[arg(long, default_value = "multi-sine")]
    motion: Motion,
    /// How many trajectories.
    #[arg(long, default_value_t = 12)]
    trajectories: usize,
    /// How long each lasts [s]; 8 s, or 4 s for the paper's motion (which prints 8 s, but fits 4 s).
    #[arg(long)]
    duration: Option<f64>,
    /// Sampling rate [Hz]; 100 Hz, or 400 samples a trajectory for the paper's motion.
    #[arg(long)]
    rate: Option<f64>,
    /// How many times as fast the same paths are travelled.
    #[arg(long, default_value_t = 1.0)]
    speed: f64,
    /// Largest start and end angle of the paper's motion [rad].
    #[arg(long, default_value_t = 3.0)]
    range: f64,
    /// Hide an effect: its id (see `torquescope effects`), joints, and its parameters if not drawn, such as `coulomb-friction@1,2` or
    /// `stribeck-friction@2=1.5,0.8,0.1`. May be repeated.
    #[arg(long, value_name = "EFFECT[@JOINTS][=VALUES]")]
    effect: Vec<Hiding>,
    /// RMS of the torque of effects and parts without values, as a fraction of the joint's torque.
    #[arg(long, default_value_t = 0.1)]
    strength: f64,
    /// Torque noise, as a fraction of each joint's torque RMS.
    #[arg(long, default_value_t = 0.02)]
    noise: f64,
    /// Steps of the encoders [rad]: positions are rounded, velocity and acceleration derived from them.
    #[arg(long, value_name = "RAD")]
    encoder: Option<f64>,
    /// Seed of all random draws; 1, or that of the scenario.
    #[arg(long)]
    seed: Option<u64>,
    /// Do not state the arm's masses and lengths in the recording.
    #[arg(long)]
    unstated: bool,
    /// Print a summary as JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    in_world: InWorld,
}

/// An effect to hide, with its parameters where they are not drawn.
#[derive(Debug, Clone)]
struct Hiding {
    place: Place,
    parameters: Option<Vec<f64>>,
}

impl FromStr for Hiding {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (place, values) = text.split_once('=').map_or((text, None), |(place, values)| (place, Some(values)));
        let place: Place = place.parse().map_err(|error: PlaceError| error.to_string())?;
        let number = |value: &str| value.trim().parse().map_err(|_| format!("`{value}` in `{text}` is not a number"));
        let parameters =
            values.map(|values| values.split(',').map(number).collect::<Result<Vec<f64>, _>>()).transpose()?;
        if let Some(parameters) = &parameters {
            place.effect.check_parameters(parameters).map_err(|error| error.to_string())?;
        }
        Ok(Hiding { place, parameters })
    }
}

/// Motions to choose from.
#[derive(Clone, Copy, ValueEnum)]
enum Motion {
    /// Sums of sines about random places.
    MultiSine,
    /// The paper's point-to-point motion.
    Paper,
    /// From place to place, with a pause at each.
    Stops,
    /// Between four places in turn.
    PickAndPlace,
}

#[derive(Serialize)]
struct Answer {
    file: String,
    joints: usize,
    trajectories: usize,
    samples: usize,
    sealed: bool,
}

impl Simulate {
    /// Simulates and saves.
    pub fn run(&self) -> anyhow::Result<()> {
        let recording = if self.in_world.is_wanted() {
            let scenario =
                self.in_world.scenario(self.scenario.as_deref(), self.seed, self.strength, || self.build_scenario())?;
            progress::watch("simulate", move |monitor| world::simulate(&scenario, monitor))?
        } else {
            let making = self.making()?;
            progress::watch("simulate", move |monitor| making.simulate(monitor))?
        };
        convert::save(&recording, &self.output)?;
        let answer = Answer {
            file: self.output.display().to_string(),
            joints: recording.joint_count(),
            trajectories: recording.trajectories.len(),
            samples: recording.sample_count(),
            sealed: recording.seal.is_some(),
        };
        if self.json {
            println!("{}", serde_json::to_string_pretty(&answer)?);
        } else {
            convert::tell(&recording, &self.output);
        }
        Ok(())
    }

    fn making(&self) -> anyhow::Result<Making> {
        match (&self.scenario, self.mystery) {
            (None, Some(level)) => Ok(Making::mystery(level, self.seed.unwrap_or(1))?),
            _ => Ok(Making::Formulas(Box::new(self.build_scenario()?))),
        }
    }

    fn build_scenario(&self) -> anyhow::Result<Scenario> {
        if self.embedded {
            return Ok(Scenario::embedded());
        }
        if let Some(path) = &self.scenario {
            let mut scenario = read_scenario(path).or_usage()?;
            scenario.seed = self.seed.unwrap_or(scenario.seed);
            return Ok(scenario);
        }
        let seed = self.seed.unwrap_or(1);
        let embedded = Scenario::embedded();
        let arm = match (&self.arm, self.joints) {
            (Some(path), _) => read_arm(path)?,
            (None, Some(joints)) => Arm::uniform(joints),
            (None, None) => embedded.arm.clone(),
        };
        let name = self.output.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut scenario = Scenario {
            name,
            arm,
            motion: self.excitation(&embedded.motion),
            speed_scale: self.speed,
            effects: Vec::new(),
            torque_noise: self.noise,
            encoder_resolution: self.encoder,
            seed,
            stated: !self.unstated,
        };
        scenario.check()?;
        for hiding in &self.effect {
            let hidden = self.hidden_effects(hiding, &scenario)?;
            scenario.effects.extend(hidden);
        }
        Ok(scenario)
    }

    fn excitation(&self, embedded: &Excitation) -> Excitation {
        let stops = |places| Excitation::Stops {
            trajectories: self.trajectories,
            duration: self.duration.unwrap_or(8.0),
            rate: self.rate.unwrap_or(100.0),
            places,
            pause: 0.3,
            max_position: 1.5,
            max_velocity: 3.0,
        };
        match (self.motion, embedded.clone()) {
            (Motion::Stops, _) => stops(1000),
            (Motion::PickAndPlace, _) => stops(4),
            (Motion::Paper, _) => {
                let duration = self.duration.unwrap_or(4.0);
                let samples = self.rate.map_or(400, |rate| (rate * duration).round() as usize);
                Excitation::PaperPointToPoint { trajectories: self.trajectories, duration, samples, range: self.range }
            }
            (Motion::MultiSine, mut motion) => {
                if let Excitation::MultiSine { trajectories, duration, rate, .. } = &mut motion {
                    *trajectories = self.trajectories;
                    *duration = self.duration.unwrap_or(*duration);
                    *rate = self.rate.unwrap_or(*rate);
                }
                motion
            }
        }
    }

    fn hidden_effects(&self, hiding: &Hiding, scenario: &Scenario) -> anyhow::Result<Vec<HiddenEffect>> {
        let Place { effect, .. } = hiding.place;
        let joints = hiding.place.joints(scenario.arm.joint_count()).or_usage()?;
        let Some(parameters) = &hiding.parameters else {
            return Ok(scenario.hide_by_strength(effect.id, &joints, self.strength)?);
        };
        let places = effect.places(joints);
        let hidden = |joint| HiddenEffect { effect: effect.id.to_owned(), joint, parameters: parameters.clone() };
        Ok(places.into_iter().map(hidden).collect())
    }
}

fn read_scenario(path: &Path) -> anyhow::Result<Scenario> {
    let text = file::read_text(path).with_context(|| format!("can't read {}", path.display()))?;
    serde_json::from_str(&text).with_context(|| format!("{} is not a scenario", path.display()))
}
