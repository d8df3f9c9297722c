//! Our own file: an NPZ that numpy opens, with two entries more.
//!
//! `time` (N), `trajectory` (N, i64: index of the trajectory of each sample), `q`, `qd`, `qdd`, `tau` (N, n), then
//! `torquescope.json` (the [`Manifest`]) and, where there is one, `truth.sealed` (the scrambled bytes of the seal).

use serde::{Deserialize, Serialize};

use super::encoders::Side;
use super::torque::TorqueFacts;
use super::{Joint, Provenance};
use crate::arm::chain::Chain;
use crate::arm::{Arm, Posture};

/// Version of the layout that is written, and the newest that is understood.
pub const VERSION: u32 = 1;
/// Name of the entry with the manifest.
pub const MANIFEST: &str = "torquescope.json";
/// Name of the entry with the sealed truth.
pub const TRUTH: &str = "truth.sealed";
/// Names of the arrays with one column a joint.
pub const CHANNELS: [&str; 4] = ["q", "qd", "qdd", "tau"];
/// Name of the array of time stamps \[s\].
pub const TIME: &str = "time";
/// Name of the array that tells which trajectory a sample belongs to.
pub const TRAJECTORY: &str = "trajectory";

/// What the arrays can't say.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Version of the layout.
    pub format: u32,
    /// Name of the recording.
    pub name: String,
    /// Its joints.
    pub joints: Vec<Joint>,
    /// Names of its trajectories, in the order of their numbers.
    pub trajectories: Vec<String>,
    /// Where the derivatives came from.
    pub provenance: Provenance,
    /// Where q = 0 points.
    pub posture: Option<Posture>,
    /// The arm as its maker states it.
    pub stated_arm: Option<Arm>,
    /// Where its axes are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chain: Option<Chain>,
    /// What its torque is, as it is stated.
    #[serde(default, skip_serializing_if = "TorqueFacts::is_empty")]
    pub torque: TorqueFacts,
    /// On which side of the gears its encoders are, where it is stated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub encoders: Option<Side>,
}

/// Only the version, which is read first: the rest may differ in other versions.
#[derive(Deserialize)]
pub struct Version {
    /// Version of the layout.
    pub format: u32,
}
