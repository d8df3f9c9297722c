//! Where the recording of a session comes from: enough to read it again in another way, or to make it anew.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::recording::correction::Correction;
use crate::recording::hold_out::HoldOut;
use crate::recording::read::ReadOptions;
use crate::simulation::{Level, Scenario, world};

/// Where a recording comes from.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// What it is made of.
    pub origin: Origin,
    /// How it was read, and what was set right in it since.
    pub options: ReadOptions,
    /// What is held out of it.
    pub held_out: HoldOut,
}

/// What a recording is made of.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Origin {
    /// One or more files; each is a trajectory, or holds several.
    Files(Vec<PathBuf>),
    /// Formulas along a motion that is prescribed.
    Simulated(Box<Scenario>),
    /// Rigid bodies.
    World(Box<world::Scenario>),
    /// What a seed draws.
    Mystery {
        /// How hard it is.
        level: Level,
        /// By which all of it is drawn.
        seed: u64,
    },
}

impl Source {
    /// Its files; `None` if it was not read from any.
    pub fn files(&self) -> Option<&[PathBuf]> {
        match &self.origin {
            Origin::Files(paths) => Some(paths),
            _ => None,
        }
    }

    /// The same with these files beside its own; `None` if it has none of its own.
    pub(super) fn beside(&self, more: &[PathBuf], held_out: HoldOut) -> Option<Self> {
        let origin = Origin::Files([self.files()?, more].concat());
        Some(Source { origin, options: self.options.clone(), held_out })
    }

    /// The same, set right.
    pub(super) fn set_right(&self, corrections: &[Correction], held_out: HoldOut) -> Self {
        let mut options = self.options.clone();
        options.set_right.extend_from_slice(corrections);
        Source { origin: self.origin.clone(), options, held_out }
    }

    /// Whether it spells out what the seal of its recording hides.
    pub(super) fn tells_the_truth(&self) -> bool {
        matches!(self.origin, Origin::Simulated(_) | Origin::World(_))
    }
}
