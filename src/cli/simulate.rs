use std::path::PathBuf;

use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use serde::Serialize;

use super::data::{parse_place, read_arm};
use super::{progress, write_file};
use crate::arm::Arm;
use crate::recording::seal::HiddenEffect;
use crate::recording::write;
use crate::simulation::{self, Excitation, Scenario};

/// Simulate a recording, with hidden effects whose truth is sealed in the file.
#[derive(Args)]
pub struct Simulate {
    /// Where to save the recording (NPZ).
    #[arg(short, long, value_name = "RECORDING.npz")]
    output: PathBuf,
    /// A whole scenario (JSON); the options below are then not used, except the seed.
    #[arg(long, value_name = "SCENARIO.json")]
    scenario: Option<PathBuf>,
    /// Hide one effect that is drawn by the seed, on the embedded arm; open the seal to learn which.
    #[arg(long)]
    mystery: bool,
    /// The arm (JSON: links, gravity, posture).
    #[arg(long, value_name = "ARM.json", conflicts_with = "joints")]
    arm: Option<PathBuf>,
    /// An arm of so many uniform rods of 1 m and 1 kg, instead of the embedded three-joint arm.
    #[arg(long)]
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
    /// Hide an effect: id, joints, and its parameters if not drawn, such as `coulomb-friction@1,2` or
    /// `stribeck-friction@2=1.5,0.8,0.1`. May be repeated.
    #[arg(long, value_name = "EFFECT[@JOINTS][=VALUES]")]
    effect: Vec<String>,
    /// RMS of the torque of effects without values, as a fraction of the joint's torque.
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
}

/// Motions to choose from.
#[derive(Clone, Copy, ValueEnum)]
enum Motion {
    /// Sums of sines about random places.
    MultiSine,
    /// The paper's point-to-point motion.
    Paper,
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
        let scenario = self.build_scenario()?;
        let recording = progress::watch("simulate", move |monitor| simulation::simulate(&scenario, monitor))?;
        write_file(&self.output, &write::to_npz_bytes(&recording)?)?;
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
            println!(
                "saved {}: {} joints, {} trajectories, {} samples; the truth is sealed in it",
                answer.file, answer.joints, answer.trajectories, answer.samples
            );
        }
        Ok(())
    }

    fn build_scenario(&self) -> anyhow::Result<Scenario> {
        if let Some(path) = &self.scenario {
            let text = std::fs::read_to_string(path).with_context(|| format!("can't read {}", path.display()))?;
            let mut scenario: Scenario =
                serde_json::from_str(&text).with_context(|| format!("{} is not a scenario", path.display()))?;
            scenario.seed = self.seed.unwrap_or(scenario.seed);
            return Ok(scenario);
        }
        let seed = self.seed.unwrap_or(1);
        if self.mystery {
            return Ok(Scenario::mystery(seed)?);
        }
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
        for text in &self.effect {
            let hidden = self.hidden_effects(text, &scenario)?;
            scenario.effects.extend(hidden);
        }
        Ok(scenario)
    }

    fn excitation(&self, embedded: &Excitation) -> Excitation {
        match (self.motion, embedded.clone()) {
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

    fn hidden_effects(&self, text: &str, scenario: &Scenario) -> anyhow::Result<Vec<HiddenEffect>> {
        let (place, values) = match text.split_once('=') {
            Some((place, values)) => (place, Some(values)),
            None => (text, None),
        };
        let (effect, joints) = parse_place(place, scenario.arm.joint_count())?;
        let Some(values) = values else { return Ok(scenario.hide_by_strength(&effect, &joints, self.strength)?) };
        let parse =
            |value: &str| value.trim().parse::<f64>().with_context(|| format!("`{value}` in `{text}` is not a number"));
        let parameters = values.split(',').map(parse).collect::<anyhow::Result<Vec<f64>>>()?;
        let spec = crate::effect::registry::find(&effect)?;
        if spec.parameters.len() != parameters.len() {
            let names: Vec<&str> = spec.parameters.iter().map(|parameter| parameter.name).collect();
            bail!(
                "{effect} has {} parameters ({}), `{text}` gives {}",
                names.len(),
                names.join(", "),
                parameters.len()
            );
        }
        let places = spec.places(joints);
        let hidden = |joint| HiddenEffect { effect: effect.clone(), joint, parameters: parameters.clone() };
        Ok(places.into_iter().map(hidden).collect())
    }
}
