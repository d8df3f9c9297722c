//! What the user should know about a recording.
//!
//! A finding never changes the data. What the import had to do (cut at gaps, convert units) is a finding too, so that
//! nothing happens in silence.

use std::fmt;
use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::correction::Correction;

/// One thing that the user should know about a recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// How much it matters.
    pub severity: Severity,
    /// What sort of thing it is.
    pub kind: FindingKind,
    /// What was found, a sentence.
    pub what: String,
    /// Where.
    pub place: Place,
    /// What to do about it, a sentence; empty where nothing has to be done.
    pub remedy: String,
    /// What sets it right, one after the other; empty where nothing is known to.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set_right: Vec<Correction>,
}

/// How much a finding matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Severity {
    /// Good to know.
    Info,
    /// Results may be wrong.
    Warning,
    /// Results will be wrong.
    Error,
}

impl Severity {
    /// As people are told.
    pub fn word(self) -> &'static str {
        match self {
            Severity::Info => "note",
            Severity::Warning => "warning",
            Severity::Error => "error",
        }
    }
}

/// The sorts of findings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FindingKind {
    /// Samples with NaN or infinite values were left out.
    NonFinite,
    /// Samples that repeat the ones before them were left out.
    Repeated,
    /// The clock jumps; the trajectory was cut there.
    TimeGap,
    /// Time steps differ much from each other.
    UnevenTime,
    /// The time stamps are hardly in seconds.
    TimeUnit,
    /// A channel never changes.
    Constant,
    /// q̇ is not dq/dt.
    VelocityMismatch,
    /// q̈ is not dq̇/dt.
    AccelerationMismatch,
    /// The filter of a derived q̇ or q̈ takes the motion away.
    Flattened,
    /// Angles that look like degrees.
    Degrees,
    /// Torque readings that repeat while the joint moves.
    Stuck,
    /// Torque readings that end at a limit.
    Saturated,
    /// Single samples far from all others.
    FarOut,
    /// A signal and its derivative that no motion has together.
    Contradiction,
    /// An angle that jumps by a whole turn.
    WholeTurn,
    /// Values that no robot has.
    BeyondBelief,
    /// A derivative that was measured more seldom than it was written.
    Held,
    /// Too little data to learn from.
    FewSamples,
    /// Values were converted to SI units.
    Converted,
    /// A channel holds commanded values, not measured ones.
    Commanded,
    /// The torque is that of a motor's current, in amperes.
    Amperes,
    /// What a current is worth as a torque, by the masses that are stated.
    Gains,
    /// The torque is that of the motors, and nothing says the ratio of the gears.
    MotorSide,
    /// The torque follows from a command by the law of the drive.
    Drive,
    /// A mapping that comes with the program names these columns.
    ReadyMapping,
    /// Other columns could have been taken.
    Alternatives,
    /// Parts of the file were not read.
    PassedOver,
    /// The clocks of a log: which one is taken, and how far others are from it.
    Clocks,
    /// A text ends within a line.
    BrokenOff,
    /// Samples beside the cuts between time blocks are in no part.
    Guard,
    /// The log contradicts how it is set up: its zero, a sign, the order of columns, a factor, a delay.
    SetUp,
    /// Something was set right, as asked.
    SetRight,
    /// A joint goes further, faster or stronger than its robot's file says that it can.
    BeyondLimit,
    /// The arm is hardly the planar one that it is taken for.
    NotPlanar,
}

/// Where something was found; what is `None` does not apply or means everywhere.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Place {
    /// Name of the file.
    pub file: Option<String>,
    /// Index into [`Recording::trajectories`](super::Recording::trajectories).
    pub trajectory: Option<usize>,
    /// Index into [`Recording::joints`](super::Recording::joints).
    pub joint: Option<usize>,
    /// Samples of the trajectory.
    pub samples: Option<Range<usize>>,
}

impl Place {
    /// Everywhere in a file.
    pub fn file(name: &str) -> Self {
        Place { file: Some(name.to_owned()), ..Place::default() }
    }

    /// A joint, in all trajectories.
    pub fn joint(joint: usize) -> Self {
        Place { joint: Some(joint), ..Place::default() }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(file) = &self.place.file {
            write!(f, "{file}: ")?;
        }
        f.write_str(&self.what)?;
        if self.remedy.is_empty() { Ok(()) } else { write!(f, " {}", self.remedy) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_finding_is_said_with_its_place_and_remedy() {
        let mut finding = Finding {
            severity: Severity::Warning,
            kind: FindingKind::Constant,
            what: "τ never changes.".into(),
            place: Place::default(),
            remedy: String::new(),
            set_right: Vec::new(),
        };
        assert_eq!(finding.to_string(), "τ never changes.");
        finding.remedy = "Check it.".into();
        finding.place = Place::file("log.csv");
        assert_eq!(finding.to_string(), "log.csv: τ never changes. Check it.");
        let words = [Severity::Info, Severity::Warning, Severity::Error].map(Severity::word);
        assert_eq!(words, ["note", "warning", "error"]);
    }
}
