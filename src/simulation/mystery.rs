//! Mysteries: recordings in which something is hidden, drawn by a seed at a level of difficulty.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use rand::RngExt;
use rand::seq::{SliceRandom, index};
use serde::{Deserialize, Serialize};

use super::{Draw, Scenario, SimulationError, random, simulate, world};
use crate::effect::{Effect, registry};
use crate::progress::Monitor;
use crate::recording::Recording;
use crate::recording::seal::HiddenEffect;

/// How hard it is to find what is hidden.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Level {
    /// One everyday effect, strong, on one joint, and little noise.
    Easy,
    /// One effect of the registry.
    #[default]
    Medium,
    /// Two weak effects of different families, noise, and positions alone from coarse encoders; the arm is not stated.
    Hard,
    /// One strong effect among several weak ones in a world of rigid bodies, whose torque no formula of ours makes.
    Real,
}

impl Level {
    /// All of them, the easiest first.
    pub const ALL: [Level; 4] = [Level::Easy, Level::Medium, Level::Hard, Level::Real];

    /// Its name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Level::Easy => "easy",
            Level::Medium => "medium",
            Level::Hard => "hard",
            Level::Real => "real",
        }
    }

    /// What it hides, in a few words.
    pub fn about(self) -> &'static str {
        match self {
            Level::Easy => "one strong everyday effect on one joint, 1 % noise",
            Level::Medium => "one effect of the catalogue, 2 % noise",
            Level::Hard => "two weak effects, 4 % noise, positions only, an arm that is not stated",
            Level::Real => "rigid bodies with motors: one strong effect among several weak ones",
        }
    }
}

/// What a recording is simulated from.
#[derive(Debug, Clone, PartialEq)]
pub enum Making {
    /// Formulas along a motion that is prescribed.
    Formulas(Box<Scenario>),
    /// Rigid bodies; its first part is what is to be found, the others are weak.
    World(Box<world::Scenario>),
}

impl Making {
    /// The mystery of a level and a seed.
    ///
    /// # Errors
    /// [`SimulationError`] if nothing can be drawn, which no seed tried so far brought about.
    pub fn mystery(level: Level, seed: u64) -> Result<Making, SimulationError> {
        let name = match level {
            Level::Medium => format!("mystery {seed}"),
            _ => format!("mystery {seed} ({})", level.name()),
        };
        Ok(match Rules::of(level) {
            Some(rules) => Making::Formulas(Box::new(Scenario { name, ..rules.draw(seed)? })),
            None => Making::World(Box::new(world::Scenario { name, ..world::mystery(seed)? })),
        })
    }

    /// The same under another name.
    #[must_use]
    pub fn named(mut self, name: String) -> Making {
        match &mut self {
            Making::Formulas(scenario) => scenario.name = name,
            Making::World(world) => world.name = name,
        }
        self
    }

    /// Name of the recording.
    pub fn name(&self) -> &str {
        match self {
            Making::Formulas(scenario) => &scenario.name,
            Making::World(world) => &world.name,
        }
    }

    /// What is there to be found.
    pub fn hidden(&self) -> Vec<HiddenEffect> {
        match self {
            Making::Formulas(scenario) => scenario.effects.clone(),
            Making::World(world) => world.hidden().into_iter().take(1).collect(),
        }
    }

    /// The recording.
    ///
    /// # Errors
    /// [`SimulationError`] says what can't be, or that somebody stopped it.
    pub fn simulate(&self, monitor: &Monitor) -> Result<Recording, SimulationError> {
        match self {
            Making::Formulas(scenario) => simulate(scenario, monitor),
            Making::World(world) => world::simulate(world, monitor),
        }
    }
}

impl Scenario {
    /// [`Scenario::embedded`] with another motion and something else hidden: one effect of the registry, on one or two
    /// joints or the whole arm, of 3 to 20 % of the torque. All of it is drawn by the seed.
    ///
    /// # Errors
    /// [`SimulationError`] if no effect of the registry can be drawn, which no known registry brings about.
    pub fn mystery(seed: u64) -> Result<Scenario, SimulationError> {
        let scenario = Rules::MEDIUM.draw(seed)?;
        Ok(Scenario { name: format!("mystery {seed}"), ..scenario })
    }
}

/// What a level hides in the arm of the demonstration, and how well it can be seen.
struct Rules {
    /// Which effects may be hidden.
    may_hide: fn(&Effect) -> bool,
    /// How many of them.
    effects: usize,
    /// On how many joints each.
    joints: RangeInclusive<usize>,
    /// RMS of each over that of the torque of the joints that feel it.
    strength: RangeInclusive<f64>,
    torque_noise: f64,
    encoder_resolution: Option<f64>,
    stated: bool,
}

impl Rules {
    const EASY: Rules = Rules {
        may_hide: |effect| effect.facts.everyday && !effect.facts.absorbed_by_body,
        effects: 1,
        joints: 1..=1,
        strength: 0.12..=0.25,
        torque_noise: 0.01,
        encoder_resolution: None,
        stated: true,
    };
    const MEDIUM: Rules =
        Rules { may_hide: |_| true, joints: 1..=2, strength: 0.03..=0.2, torque_noise: 0.02, ..Rules::EASY };
    const HARD: Rules = Rules {
        may_hide: |effect| effect.fault().is_none() && !effect.facts.absorbed_by_body,
        effects: 2,
        strength: 0.04..=0.09,
        torque_noise: 0.04,
        encoder_resolution: Some(TAU / 16_384.0),
        stated: false,
        ..Rules::EASY
    };

    /// Those of a level; `None` for the one that no formulas make.
    fn of(level: Level) -> Option<Rules> {
        match level {
            Level::Easy => Some(Rules::EASY),
            Level::Medium => Some(Rules::MEDIUM),
            Level::Hard => Some(Rules::HARD),
            Level::Real => None,
        }
    }

    fn draw(&self, seed: u64) -> Result<Scenario, SimulationError> {
        let mut scenario = Scenario {
            seed,
            effects: Vec::new(),
            torque_noise: self.torque_noise,
            encoder_resolution: self.encoder_resolution,
            stated: self.stated,
            ..Scenario::embedded()
        };
        let mut random = random(seed, Draw::Mystery);
        let mut deck: Vec<&'static Effect> = registry::ALL.to_vec();
        deck.sort_by_key(|effect| effect.id);
        deck.shuffle(&mut random);
        deck.retain(|effect| (self.may_hide)(effect));
        let mut deck = deck.into_iter();
        let mut families = Vec::new();
        for _ in 0..self.effects {
            let strength = random.random_range(self.strength.clone());
            let count = random.random_range(self.joints.clone());
            let mut joints = index::sample(&mut random, scenario.arm.joint_count(), count).into_vec();
            joints.sort_unstable();
            let mut failure = SimulationError::EmptyRegistry;
            let hidden = deck.by_ref().filter(|effect| !families.contains(&effect.family)).find_map(|effect| {
                let hidden = scenario.hide_by_strength(effect.id, &joints, strength);
                hidden.map_err(|error| failure = error).ok().map(|hidden| (effect.family, hidden))
            });
            let (family, hidden) = hidden.ok_or(failure)?;
            families.push(family);
            scenario.effects.extend(hidden);
        }
        Ok(scenario)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scenario(level: Level, seed: u64) -> Scenario {
        match Making::mystery(level, seed).unwrap() {
            Making::Formulas(scenario) => *scenario,
            Making::World(_) => panic!("it is a world"),
        }
    }

    #[test]
    fn levels_hide_what_they_say() {
        for seed in 0..25 {
            let easy = scenario(Level::Easy, seed);
            let everyday = registry::find(&easy.effects[0].effect).unwrap().facts.everyday;
            assert!(everyday && easy.effects.len() == 1 && easy.stated, "seed {seed}");
            let hard = scenario(Level::Hard, seed);
            let families: Vec<_> =
                hard.effects.iter().map(|hidden| registry::find(&hidden.effect).unwrap().family).collect();
            assert!(families.len() == 2 && families[0] != families[1] && !hard.stated, "seed {seed}: {hard:?}");
            assert_eq!(scenario(Level::Medium, seed), Scenario::mystery(seed).unwrap());
        }
    }

    /// What is to be found is by far the strongest of what was really there.
    #[test]
    fn a_real_mystery_has_one_strong_effect_among_weak_ones() {
        let Making::World(mut world) = Making::mystery(Level::Real, 3).unwrap() else { panic!("it is no world") };
        assert!(world.parts.len() >= 5);
        (world.step, world.name) = (5e-4, "quick".to_owned());
        let making = Making::World(world);
        let causes = making.simulate(&Monitor::new()).unwrap().seal.unwrap().open().unwrap().causes;
        let share = |effect: &str| causes.iter().find(|cause| cause.effect == effect).map_or(0.0, |cause| cause.share);
        let found = making.hidden().remove(0).effect;
        assert!(share(&found) > 0.03, "{causes:?}");
        assert!(causes.iter().filter(|cause| cause.effect != found).all(|cause| cause.share < 0.03), "{causes:?}");
    }
}
