//! The options of `simulate` for a world of rigid bodies.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use clap::{Args, ValueEnum};

use super::failure::OrUsage;
use super::write_file;
use crate::file;
use crate::recording::joints_in;
use crate::simulation::Scenario;
use crate::simulation::world::{self, Kind};

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
    #[arg(long, requires = "world", value_name = "PART[@JOINTS]|TOML", help = about_parts())]
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
    /// Dry and speed friction on every joint, as motors behind gears have it, and perhaps one of them.
    Geared,
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
            Class::Geared => world::Class::Geared,
            Class::Unknown => world::Class::Unknown,
        }
    }
}

impl InWorld {
    /// Whether a world is wanted.
    pub fn is_wanted(&self) -> bool {
        self.world
    }

    /// The world of a file, of a class, or of the `prescribed` scenario, with the parts that were asked for; those without
    /// numbers have this strength.
    pub fn scenario(
        &self,
        file: Option<&Path>,
        seed: Option<u64>,
        strength: f64,
        prescribed: impl FnOnce() -> anyhow::Result<Scenario>,
    ) -> anyhow::Result<world::Scenario> {
        let mut scenario = match (file, self.class) {
            (Some(path), _) => read(path).or_usage()?,
            (None, Some(class)) => world::draw(seed.unwrap_or(1), class.into())?,
            (None, None) => world::Scenario::of(&prescribed()?),
        };
        scenario.seed = seed.unwrap_or(scenario.seed);
        for text in &self.part {
            let put =
                if text.contains('=') { written(&mut scenario, text) } else { named(&mut scenario, text, strength) };
            put.with_context(|| format!("`{text}` is not a part of this world")).or_usage()?;
        }
        scenario.check().or_usage()?;
        if let Some(path) = &self.save_scenario {
            write_file(path, toml::to_string(&scenario)?.as_bytes())?;
        }
        Ok(scenario)
    }
}

/// What `--part` takes.
fn about_parts() -> String {
    let names: Vec<&str> = Kind::ALL.iter().map(|kind| kind.id).collect();
    format!(
        "Put a part into the world, as strong as --strength says: {}; without joints, on all that can have it. Or with all its \
         numbers, as TOML: `kind = \"dry-friction\", joint = 2, torque = 1.5`. May be repeated",
        names.join(", ")
    )
}

/// Puts a part into the world that is written with all its numbers.
fn written(scenario: &mut world::Scenario, text: &str) -> anyhow::Result<()> {
    let parts: BTreeMap<String, world::Part> = toml::from_str(&format!("part = {{ {text} }}"))?;
    scenario.parts.extend(parts.into_values());
    Ok(())
}

/// Puts a part into the world by its name and joints, counted from 1.
fn named(scenario: &mut world::Scenario, text: &str, strength: f64) -> anyhow::Result<()> {
    let (id, list) = text.split_once('@').map_or((text, None), |(id, list)| (id, Some(list)));
    let kind = Kind::find(id.trim()).with_context(|| format!("there is no part `{}`: see --help", id.trim()))?;
    let joints: Vec<usize> = match (list, kind.first_joint) {
        (Some(list), Some(_)) => {
            joints_in(list).map_err(|number| anyhow!("`{number}` is not a joint: they are counted from 1"))?
        }
        (None, Some(first)) => (first..scenario.arm.joint_count()).collect(),
        (None, None) => Vec::new(),
        (Some(_), None) => anyhow::bail!("it is of the whole arm: leave out the joint"),
    };
    Ok(scenario.hide_by_strength(kind, &joints, strength)?)
}

fn read(path: &Path) -> anyhow::Result<world::Scenario> {
    let text = file::read_text(path).with_context(|| format!("can't read {}", path.display()))?;
    toml::from_str(&text).with_context(|| format!("{} is not the scenario of a world", path.display()))
}
