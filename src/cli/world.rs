//! The options of `simulate` for a world of rigid bodies.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, ValueEnum};

use super::failure::OrUsage;
use super::write_file;
use crate::simulation::{Scenario, world};

/// What is simulated by rigid bodies instead of formulas.
#[derive(Args)]
#[command(next_help_heading = "World of rigid bodies")]
pub struct InWorld {
    /// Let a servo move an arm of rigid bodies along the motion, instead of computing the torque of the prescribed motion.
    #[arg(long, conflicts_with_all = ["effect", "mystery"])]
    world: bool,
    /// Draw the whole world by the seed, with so much hidden in it; arm, motion and sensors too.
    #[arg(long, requires = "world", conflicts_with_all = ["scenario", "arm", "joints"])]
    class: Option<Class>,
    /// Put a part into the world, as TOML, such as `kind = "dry-friction", joint = 2, torque = 1.5`. May be repeated.
    #[arg(long, requires = "world", value_name = "TOML")]
    part: Vec<String>,
    /// Save the world's scenario here too, to change it and simulate it again.
    #[arg(long, requires = "world", value_name = "SCENARIO.toml")]
    save_scenario: Option<PathBuf>,
}

/// How much is hidden in a world that is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Class {
    /// Nothing.
    None,
    /// One effect of the catalogue.
    Single,
    /// Two or three of them.
    Several,
    /// One or two of them, and several weak ones.
    Realistic,
    /// Something that the catalogue does not have.
    Unknown,
}

impl From<Class> for world::Class {
    fn from(class: Class) -> Self {
        match class {
            Class::None => world::Class::None,
            Class::Single => world::Class::Single,
            Class::Several => world::Class::Several,
            Class::Realistic => world::Class::Realistic,
            Class::Unknown => world::Class::Unknown,
        }
    }
}

impl InWorld {
    /// Whether a world is wanted.
    pub fn is_wanted(&self) -> bool {
        self.world
    }

    /// The world of a file, of a class, or of the `prescribed` scenario, with the parts that were asked for.
    pub fn scenario(
        &self,
        file: Option<&Path>,
        seed: Option<u64>,
        prescribed: impl FnOnce() -> anyhow::Result<Scenario>,
    ) -> anyhow::Result<world::Scenario> {
        let mut scenario = match (file, self.class) {
            (Some(path), _) => read(path).or_usage()?,
            (None, Some(class)) => world::draw(seed.unwrap_or(1), class.into())?,
            (None, None) => world::Scenario::of(&prescribed()?),
        };
        for text in &self.part {
            let parts: BTreeMap<String, world::Part> = toml::from_str(&format!("part = {{ {text} }}"))
                .with_context(|| format!("`{text}` is not a part of a world"))
                .or_usage()?;
            scenario.parts.extend(parts.into_values());
        }
        scenario.seed = seed.unwrap_or(scenario.seed);
        scenario.check().or_usage()?;
        if let Some(path) = &self.save_scenario {
            write_file(path, toml::to_string(&scenario)?.as_bytes())?;
        }
        Ok(scenario)
    }
}

fn read(path: &Path) -> anyhow::Result<world::Scenario> {
    let text = std::fs::read_to_string(path).with_context(|| format!("can't read {}", path.display()))?;
    toml::from_str(&text).with_context(|| format!("{} is not the scenario of a world", path.display()))
}
