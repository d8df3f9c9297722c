//! Recordings: what was measured on an arm, and where it came from.
//!
//! bytes → [`read`] (sniff, table) → [`mapping`] (which column is which channel) → [`Recording`] + [`check`] findings
//! → [`split`] by trajectory or time block. [`differentiate`] derives what was not measured, [`mod@write`] writes.
//!
//! SI units everywhere: rad (m for prismatic joints), s, N m (N).

pub mod check;
pub mod differentiate;
pub mod mapping;
pub mod read;
pub mod seal;
pub mod split;
pub mod write;

use serde::{Deserialize, Serialize};

use crate::arm::{Arm, Posture};
use seal::Seal;

/// One value per sample for each joint: `signal[joint][sample]`.
pub type PerJoint = Vec<Vec<f64>>;

/// Trajectories measured on one arm, with the provenance of every channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Short name for titles, such as the file name without its ending.
    pub name: String,
    /// The joints, base first.
    pub joints: Vec<Joint>,
    /// The runs. Never empty; all have as many joints as [`Recording::joints`].
    pub trajectories: Vec<Trajectory>,
    /// Where velocity and acceleration came from.
    pub provenance: Provenance,
    /// Where q = 0 points and which way q grows; `None` where the file does not say.
    pub posture: Option<Posture>,
    /// The arm as its maker states it (masses, lengths), where the file says: known to everybody, not the truth.
    pub stated_arm: Option<Arm>,
    /// The hidden truth of a simulated recording, closed until the user opens it.
    pub seal: Option<Seal>,
}

/// One run without interruption of its clock. All channels have `time.len()` samples for each joint.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trajectory {
    /// Name for tables and legends.
    pub name: String,
    /// Time stamps \[s\], strictly increasing.
    pub time: Vec<f64>,
    /// Joint position \[rad or m\].
    pub q: PerJoint,
    /// Joint velocity \[rad/s or m/s\].
    pub qd: PerJoint,
    /// Joint acceleration \[rad/s² or m/s²\].
    pub qdd: PerJoint,
    /// Joint torque \[N m or N\].
    pub tau: PerJoint,
}

/// One joint of the arm.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Joint {
    /// Name for axes and tables; `joint 1` where the file gives none.
    pub name: String,
    /// What it does, which decides its units.
    pub kind: JointKind,
}

/// How a joint moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum JointKind {
    /// Turns; rad and N m.
    #[default]
    Revolute,
    /// Slides; m and N.
    Prismatic,
}

/// Where the derivatives of position came from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Provenance {
    /// Of q̇.
    pub velocity: Origin,
    /// Of q̈.
    pub acceleration: Origin,
}

/// Where a channel came from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Origin {
    /// It stands in the file.
    Measured,
    /// We computed it; the text says how (filter, cut-off frequency, difference).
    Derived(String),
}

impl Recording {
    /// How many joints the arm has.
    pub fn joint_count(&self) -> usize {
        self.joints.len()
    }

    /// How many samples all trajectories have together.
    pub fn sample_count(&self) -> usize {
        self.trajectories.iter().map(Trajectory::len).sum()
    }
}

impl Trajectory {
    /// How many samples it has.
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Whether it has no sample at all.
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// How many joints it has.
    pub fn joint_count(&self) -> usize {
        self.q.len()
    }

    /// Median time step \[s\]; 0 with fewer than two samples.
    pub fn time_step(&self) -> f64 {
        let mut steps: Vec<f64> = self.time.windows(2).map(|pair| pair[1] - pair[0]).collect();
        if steps.is_empty() {
            return 0.0;
        }
        let middle = steps.len() / 2;
        *steps.select_nth_unstable_by(middle, f64::total_cmp).1
    }

    /// The samples of `range` as a trajectory of their own.
    pub fn slice(&self, range: std::ops::Range<usize>) -> Trajectory {
        let cut = |signal: &PerJoint| signal.iter().map(|joint| joint[range.clone()].to_vec()).collect();
        Trajectory {
            name: self.name.clone(),
            time: self.time[range.clone()].to_vec(),
            q: cut(&self.q),
            qd: cut(&self.qd),
            qdd: cut(&self.qdd),
            tau: cut(&self.tau),
        }
    }
}

impl Joint {
    /// A revolute joint named by its number, counted from 1.
    pub fn numbered(number: usize) -> Self {
        Joint { name: format!("joint {number}"), kind: JointKind::Revolute }
    }
}
