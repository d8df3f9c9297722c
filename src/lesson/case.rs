//! The recordings of a lesson: what is the same for all, and what each student's seed draws.

use rand::seq::{IndexedRandom, SliceRandom};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;

use crate::arm::Arm;
use crate::effect::{Effect, Scope, registry};
use crate::progress::Monitor;
use crate::recording::correction::Correction;
use crate::session::study;
use crate::simulation::{Excitation, Level, Making, Scenario, SimulationError};
use crate::training::fit::Plan;

/// A recording.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct Case {
    /// What it is called in the window.
    name: String,
    /// Added to the student's seed: cases with the same number have the same draws.
    #[serde(default)]
    draw: u64,
    /// A mystery of this level instead of all that follows, save `faults` and `training`.
    mystery: Option<Level>,
    /// The arm; that of the demonstration if not given.
    arm: Option<Arm>,
    /// How it moves; a quiet dozen of sines if not given.
    motion: Option<Excitation>,
    /// How many times as fast.
    #[serde(default = "unchanged")]
    speed: f64,
    /// Torque noise, as a fraction of each joint's torque.
    #[serde(default = "usual_noise")]
    noise: f64,
    /// What is hidden, drawn by the seed.
    #[serde(default)]
    hide: Vec<Hide>,
    /// What is hidden, with its parameters; how much they vary from seed to seed, 0 to 1.
    #[serde(default)]
    effects: Vec<Known>,
    #[serde(default)]
    vary: f64,
    /// Faults of the log, one drawn from each list.
    #[serde(default)]
    faults: Vec<Vec<Correction>>,
    /// How networks are trained with it.
    training: Option<Training>,
}

/// What differs from the usual training: few data need more epochs.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Training {
    /// How often every sample is seen.
    epochs: u64,
    /// Samples in a step.
    batch: usize,
    /// Whether a Cholesky factor keeps a learned mass matrix positive definite.
    #[serde(default = "yes")]
    cholesky: bool,
}

fn yes() -> bool {
    true
}

impl Training {
    fn plan(&self) -> Plan {
        let mut plan = Plan::default();
        (plan.options.epochs, plan.options.batch, plan.cholesky) = (self.epochs, self.batch, self.cholesky);
        plan
    }
}

/// An effect to be drawn.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Hide {
    /// Which it may be.
    among: Vec<String>,
    /// On which joint it may be, counted from 1.
    joints: Vec<usize>,
    /// RMS of its torque over that of the joint's, smallest and largest.
    strength: [f64; 2],
    /// Which card of the deck: cases with the same list and other turns have other effects.
    turn: Option<usize>,
}

/// An effect that is known.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Known {
    effect: String,
    /// Counted from 1.
    joint: Option<usize>,
    parameters: Vec<f64>,
}

fn unchanged() -> f64 {
    1.0
}

fn usual_noise() -> f64 {
    0.01
}

/// Eight runs of six seconds: enough for every effect, and simulated in a moment.
fn usual_motion() -> Excitation {
    Excitation::MultiSine {
        trajectories: 8,
        duration: 6.0,
        rate: 100.0,
        harmonics: 5,
        lowest_frequency: 0.1,
        highest_frequency: 1.0,
        max_position: 2.0,
        max_velocity: 3.5,
    }
}

/// Each use of the seed has its own stream, so that a change of one leaves the others as they were.
#[derive(Clone, Copy)]
enum Draw {
    Deck,
    Effect,
    Fault,
}

impl Case {
    /// What can't be in it.
    pub(super) fn check(&self) -> Result<(), String> {
        for hide in &self.hide {
            if hide.among.is_empty() || hide.joints.contains(&0) || hide.joints.is_empty() {
                return Err("`hide` needs effects in `among`, and `joints` that are counted from 1".to_owned());
            }
            if let Some(unknown) = hide.among.iter().find_map(|id| registry::find(id).err()) {
                return Err(unknown.to_string());
            }
            let [least, most] = hide.strength;
            if !(0.0 < least && least <= most && most <= 1.0) {
                return Err("`strength` is the least and the most share of the torque, from 0 to 1".to_owned());
            }
        }
        let says_itself =
            !self.hide.is_empty() || !self.effects.is_empty() || self.arm.is_some() || self.motion.is_some();
        if self.mystery.is_some() && says_itself {
            return Err("a `mystery` draws arm, motion and what is hidden: leave them out, or leave it out".to_owned());
        }
        if !(0.0..=1.0).contains(&self.vary) {
            return Err("`vary` is a share from 0 to 1".to_owned());
        }
        if let Some(training) = &self.training {
            training.plan().options.check().map_err(|error| error.to_string())?;
        }
        if self.faults.iter().any(Vec::is_empty) {
            return Err("each list of `faults` needs at least one".to_owned());
        }
        Ok(())
    }

    /// The student's seed, of which cases have one each.
    fn seed(&self, student: u64) -> u64 {
        student.wrapping_mul(1000).wrapping_add(self.draw)
    }

    fn random(&self, seed: u64, draw: Draw) -> ChaCha8Rng {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed(seed));
        random.set_stream(draw as u64 + 0x1e55);
        random
    }

    /// How the recording of a student is made.
    pub(super) fn making(&self, seed: u64) -> Result<Making, SimulationError> {
        let making = match self.mystery {
            Some(level) => Making::mystery(level, self.seed(seed))?,
            None => Making::Formulas(Box::new(self.scenario(seed)?)),
        };
        Ok(making.named(format!("{} {seed}", self.name)))
    }

    fn scenario(&self, seed: u64) -> Result<Scenario, SimulationError> {
        let bare = Scenario {
            arm: self.arm.clone().unwrap_or_else(|| Scenario::embedded().arm),
            motion: self.motion.clone().unwrap_or_else(usual_motion),
            speed_scale: self.speed,
            torque_noise: self.noise,
            seed: self.seed(seed),
            effects: Vec::new(),
            ..Scenario::embedded()
        };
        let mut random = self.random(seed, Draw::Effect);
        let mut effects = Vec::new();
        for hide in &self.hide {
            let effect = hide.effect(seed, &mut random)?;
            // The later joint of a pair names it.
            let first = usize::from(effect.scope == Scope::Pair);
            let joints: Vec<usize> =
                hide.joints.iter().map(|joint| joint - 1).filter(|joint| *joint >= first).collect();
            let joint = joints.choose(&mut random).copied().unwrap_or(first);
            let strength = random.random_range(hide.strength[0]..=hide.strength[1]);
            effects.extend(bare.hide_by_strength(effect.id, &[joint], strength)?);
        }
        let mut scenario = Scenario { effects, ..bare };
        for known in &self.effects {
            let mut vary = |value: &f64| value * (1.0 + self.vary * random.random_range(-1.0..=1.0));
            let parameters = known.parameters.iter().map(&mut vary).collect();
            let joint = known.joint.map(|joint| joint.saturating_sub(1));
            scenario.hide(&known.effect, joint, parameters);
        }
        scenario.check()?;
        Ok(scenario)
    }

    /// What is set wrong in the recording of a student.
    pub(super) fn faults(&self, seed: u64) -> Vec<Correction> {
        let mut random = self.random(seed, Draw::Fault);
        self.faults.iter().filter_map(|list| list.choose(&mut random).cloned()).collect()
    }

    /// All of it, for the session.
    pub(super) fn set_up(&self, name: &str, seed: u64) -> Result<study::Case, SimulationError> {
        let plan = self.training.as_ref().map(Training::plan);
        Ok(study::Case { name: name.to_owned(), making: self.making(seed)?, faults: self.faults(seed), plan })
    }
}

impl Hide {
    fn effect(&self, seed: u64, random: &mut ChaCha8Rng) -> Result<&'static Effect, SimulationError> {
        let mut deck = self.among.clone();
        let card = match self.turn {
            Some(turn) => {
                let mut dealer = ChaCha8Rng::seed_from_u64(seed);
                dealer.set_stream(Draw::Deck as u64 + 0x1e55);
                deck.shuffle(&mut dealer);
                deck.get(turn % deck.len().max(1)).cloned()
            }
            None => deck.choose(random).cloned(),
        };
        Ok(registry::find(&card.unwrap_or_default())?)
    }
}

impl Case {
    /// By what its recording is known again.
    pub(super) fn fingerprint(&self, seed: u64) -> Result<String, SimulationError> {
        Ok(study::fingerprint(&self.making(seed)?.simulate(&Monitor::new())?))
    }
}
