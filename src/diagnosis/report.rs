//! What a diagnosis says.

use serde::{Deserialize, Serialize};

use crate::effect::Axis;
use crate::model::Parameter;
use crate::model::fit::joint_number;

/// The answer to "what is missing?".
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// The answer in a word.
    pub verdict: Verdict,
    /// What is missing, in the order in which it should be added.
    pub effects: Vec<MissingEffect>,
    /// Held-out nMSE of each joint with the model as it was.
    pub held_out_nmse: Vec<f64>,
    /// Held-out nMSE of each joint that noise alone would leave; `None` if that can't be told.
    pub noise_floor_nmse: Option<Vec<f64>>,
    /// Joints, counted from 0 (written counted from 1), whose held-out residual is more than noise even with all effects of
    /// the report in the model.
    #[serde(with = "joint_numbers")]
    pub unexplained_joints: Vec<usize>,
    /// What to do next, in plain words.
    pub advice: String,
    /// All candidates, best first, with what speaks for or against each.
    pub ranking: Vec<Candidate>,
}

/// The answer in a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Effects of the catalogue are missing.
    Missing,
    /// Nothing is missing that these data could show.
    NothingMissing,
    /// Something is missing that no effect of the catalogue explains.
    UnknownEffect,
    /// Something is missing, but two effects explain it equally well with these data.
    Ambiguous,
}

/// One missing effect, on one joint or several.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MissingEffect {
    /// Its id in the registry.
    pub effect: String,
    /// The joints, counted from 0; written counted from 1.
    #[serde(with = "joint_numbers")]
    pub joints: Vec<usize>,
    /// Probability that it is this effect, 0 to 1.
    pub confidence: f64,
    /// Its parameters with all effects of the report in the model.
    pub parameters: Vec<Parameter>,
    /// Held-out nMSE of each joint before it is added (with those before it in the report).
    pub nmse_before: Vec<f64>,
    /// The same after.
    pub nmse_after: Vec<f64>,
    /// Effects that explain nearly as much.
    pub alternatives: Vec<String>,
    /// The motion that would tell it from the closest of them; `None` without alternatives, or if no motion does better than
    /// the one at hand.
    pub telling_motion: Option<TellingMotion>,
    /// Residual without it and what it explains, for plots; left out where a report is written for people.
    #[serde(skip)]
    pub evidence: Vec<Evidence>,
}

/// A motion that would tell an effect from a rival.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TellingMotion {
    /// What to record, in plain words.
    pub motion: String,
    /// Id of the rival.
    pub against: String,
    /// So many times the evidence, sample for sample, of the motion at hand.
    pub gain: f64,
}

impl TellingMotion {
    /// Above so many times the evidence the number says nothing more: it grows with the noise's smallness.
    const MOST_TIMES: f64 = 1000.0;

    /// The gain in words.
    pub fn times(&self) -> String {
        if self.gain > Self::MOST_TIMES {
            return format!("more than {} times", Self::MOST_TIMES);
        }
        format!("{:.*} times", usize::from(self.gain < 10.0), self.gain)
    }
}

/// The residual of one joint over the state where the effect shows best.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// The joint, counted from 0.
    pub joint: usize,
    /// The state on the horizontal axis.
    pub axis: Axis,
    /// Held-out residual without the effect: (state, torque \[N m\]).
    pub residual: Vec<[f64; 2]>,
    /// Torque of the effect at the same states.
    pub explained: Vec<[f64; 2]>,
}

/// One candidate and what speaks for or against it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Its id in the registry.
    pub effect: String,
    /// The joint, counted from 0; written counted from 1; none for an effect of the whole arm.
    #[serde(with = "joint_number")]
    pub joint: Option<usize>,
    /// Cross-validated drop of the squared residual of its joint when it alone is added to the model, 0 to 1; negative if
    /// it makes things worse.
    pub error_drop: f64,
    /// Whether it is part of the answer.
    pub accepted: bool,
    /// Why, or why not.
    pub reason: String,
}

/// Joints are counted from 0 inside and from 1 in files.
mod joint_numbers {
    use serde::{Deserialize, Deserializer, Serializer};

    pub fn serialize<S: Serializer>(joints: &[usize], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(joints.iter().map(|joint| joint + 1))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<usize>, D::Error> {
        let joint =
            |number: usize| number.checked_sub(1).ok_or_else(|| serde::de::Error::custom("there is no joint 0"));
        Vec::<usize>::deserialize(deserializer)?.into_iter().map(joint).collect()
    }
}
