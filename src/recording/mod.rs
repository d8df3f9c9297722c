//! Recordings: what was measured on an arm, and where it came from.
//!
//! bytes → [`read`] (sniff, table) → [`mapping`] (which column is which channel) → [`Recording`] + [`check`] findings
//! → [`split`] by trajectory or time block. [`differentiate`] derives what was not measured, [`mod@write`] writes.
//! [`gallery`] holds recordings that come with the program.
//!
//! SI units everywhere: rad (m for prismatic joints), s, N m (N).

pub mod catalogue;
pub mod check;
pub mod correction;
pub mod differentiate;
pub mod drive;
pub mod encoders;
mod error;
pub mod fault;
pub mod finding;
pub mod gallery;
mod glitch;
pub mod hold_out;
mod layout;
mod limits;
pub mod mapping;
pub mod noise_filter;
pub mod npy;
pub mod read;
pub mod seal;
mod segment;
pub mod spectrum;
pub mod split;
pub mod table;
pub mod torque;
mod trajectory;
pub mod transform;
pub mod write;

use serde::{Deserialize, Serialize};

use crate::arm::chain::Chain;
use crate::arm::{Arm, Posture};
use encoders::Side;
use seal::Seal;
use torque::{TorqueFact, TorqueFacts};

pub use error::RecordingError;
pub(crate) use trajectory::Pick;
pub use trajectory::{Channels, ChannelsMut, Trajectory};

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
    /// Where the axes of an arm are that is not planar, where it is known; the masses are not.
    pub chain: Option<Chain>,
    /// What the torque is, as it is stated.
    pub torque: TorqueFacts,
    /// On which side of the gears the encoders are, where it is stated.
    pub encoders: Option<Side>,
    /// The hidden truth of a simulated recording, closed until the user opens it.
    pub seal: Option<Seal>,
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

impl JointKind {
    /// Units of position, velocity, acceleration and torque.
    pub fn units(self) -> [&'static str; 4] {
        match self {
            JointKind::Revolute => ["rad", "rad/s", "rad/s²", "N m"],
            JointKind::Prismatic => ["m", "m/s", "m/s²", "N"],
        }
    }

    /// What moves it, in a word.
    pub fn effort(self) -> &'static str {
        match self {
            JointKind::Revolute => "torque",
            JointKind::Prismatic => "force",
        }
    }
}

/// Where the derivatives of position came from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Of q̇.
    pub velocity: Origin,
    /// Of q̈.
    pub acceleration: Origin,
    /// Lowest cut-off \[Hz\] of the filter that what was derived has passed; `None` where nothing was, and in files that do not
    /// say it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low_pass_hz: Option<f64>,
}

impl Provenance {
    /// All channels stand in the file.
    pub const MEASURED: Provenance =
        Provenance { velocity: Origin::Measured, acceleration: Origin::Measured, low_pass_hz: None };

    /// Whether nothing but the position was measured of the motion.
    pub fn is_derived(&self) -> bool {
        self.velocity != Origin::Measured && self.acceleration != Origin::Measured
    }
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

impl std::fmt::Display for Origin {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Origin::Measured => f.write_str("measured"),
            Origin::Derived(how) => write!(f, "derived: {how}"),
        }
    }
}

impl Recording {
    /// Units of position, velocity, acceleration and torque; where joints of both kinds are mixed, both, as `N m or N`.
    pub fn units(&self) -> [String; 4] {
        let mut kinds: Vec<JointKind> = Vec::new();
        for joint in &self.joints {
            if !kinds.contains(&joint.kind) {
                kinds.push(joint.kind);
            }
        }
        [0, 1, 2, 3].map(|channel| kinds.iter().map(|kind| kind.units()[channel]).collect::<Vec<_>>().join(" or "))
    }

    /// What moves its joints, in a word: torque, unless all of them slide.
    pub fn effort(&self) -> &'static str {
        let slides = self.joints.iter().all(|joint| joint.kind == JointKind::Prismatic);
        if slides { JointKind::Prismatic.effort() } else { JointKind::Revolute.effort() }
    }

    /// How many joints the arm has.
    pub fn joint_count(&self) -> usize {
        self.joints.len()
    }

    /// The least and the greatest position of a joint; of a joint that is not there the least lies above.
    pub fn way(&self, joint: usize) -> [f64; 2] {
        Trajectory::way(&self.trajectories, joint)
    }

    /// All of every run.
    pub fn runs(&self) -> impl Iterator<Item = split::Segment> {
        let runs = self.trajectories.iter().enumerate();
        runs.map(|(trajectory, run)| split::Segment { trajectory, samples: 0..run.len() })
    }

    /// The highest speed of a joint \[rad/s or m/s\], above zero.
    pub fn top_speed(&self, joint: usize) -> f64 {
        let speeds = self.trajectories.iter().flat_map(|trajectory| &trajectory.qd[joint]);
        speeds.fold(f64::MIN_POSITIVE, |top, qd| top.max(qd.abs()))
    }

    /// Measured runs of joints that turn, with nothing said about the arm.
    #[cfg(test)]
    pub(crate) fn of_runs(trajectories: Vec<Trajectory>) -> Recording {
        let joints = trajectories.first().map_or(0, Trajectory::joint_count);
        Recording {
            name: "test".into(),
            joints: (1..=joints).map(Joint::numbered).collect(),
            trajectories,
            provenance: Provenance::MEASURED,
            posture: None,
            stated_arm: None,
            chain: None,
            torque: TorqueFacts::default(),
            encoders: None,
            seal: None,
        }
    }

    /// How many samples all trajectories have together.
    pub fn sample_count(&self) -> usize {
        self.trajectories.iter().map(Trajectory::len).sum()
    }

    /// Where q = 0 points and which way q grows: as the file says, else as its stated arm has it, else the default.
    pub fn assumed_posture(&self) -> Posture {
        self.posture.or(self.stated_arm.as_ref().map(|arm| arm.posture)).unwrap_or_default()
    }

    /// Whether it is known where the arm points at q = 0: the file says so, or its stated arm or its stated axes do.
    pub fn states_zero(&self) -> bool {
        self.posture.is_some() || self.stated_arm.is_some() || self.chain.is_some()
    }

    /// Whether gravity was taken out of its torque.
    pub fn is_weightless(&self) -> bool {
        self.torque.has(TorqueFact::WithoutGravity)
    }

    /// The stated arm as the torque shows it: without weight where gravity was taken out.
    pub fn arm_in_torque(&self) -> Option<Arm> {
        let arm = self.stated_arm.clone()?;
        Some(if self.is_weightless() { Arm { gravity: 0.0, ..arm } } else { arm })
    }

    /// Whether it is stated what the links weigh.
    pub fn states_arm(&self) -> bool {
        self.spatial().map_or(self.stated_arm.is_some(), Chain::states_links)
    }

    /// The axes of an arm that is not planar. Those of the planar arm that is stated say only what its file states of each joint.
    pub fn spatial(&self) -> Option<&Chain> {
        self.chain.as_ref().filter(|chain| self.stated_arm.is_none() || chain.planar().is_err())
    }

    /// Takes an arm whose axes are stated for the planar one that it is, if it is one: see [`Chain::planar`].
    fn settle_plane(&mut self) {
        if self.stated_arm.is_none() && self.joints.iter().all(|joint| joint.kind == JointKind::Revolute) {
            self.stated_arm = self.chain.as_ref().and_then(|chain| chain.planar().ok());
        }
    }

    /// The stated axes as the torque shows them: without weight where gravity was taken out.
    pub fn chain_in_torque(&self) -> Option<Chain> {
        let chain = self.spatial()?.clone();
        Some(if self.is_weightless() { Chain { gravity: [0.0; 3], ..chain } } else { chain })
    }

    /// The same arm in other runs. What was sealed is of the runs that it was sealed with, so it is left out.
    pub fn with_trajectories(&self, trajectories: Vec<Trajectory>) -> Recording {
        Recording {
            name: self.name.clone(),
            joints: self.joints.clone(),
            trajectories,
            provenance: self.provenance.clone(),
            posture: self.posture,
            stated_arm: self.stated_arm.clone(),
            chain: self.chain.clone(),
            torque: self.torque.clone(),
            encoders: self.encoders,
            seal: None,
        }
    }

    /// Checks what the fields promise: a joint and a trajectory at least, all channels of one shape, finite values, a
    /// clock that increases, a stated arm that can exist.
    ///
    /// # Errors
    /// [`RecordingError`] names the first promise that is broken, and where.
    pub fn verify(&self) -> Result<(), RecordingError> {
        if self.joints.is_empty() {
            return Err(RecordingError::NoJoint);
        }
        if self.trajectories.is_empty() {
            return Err(RecordingError::NoTrajectory);
        }
        if let Some(posture) = self.posture.filter(|posture| !posture.zero_angle.is_finite()) {
            return Err(RecordingError::Posture(posture.zero_angle));
        }
        if let Some(arm) = &self.stated_arm {
            arm.check()?;
        }
        if let Some(chain) = &self.chain {
            chain.check_for(self.joint_count())?;
        }
        self.trajectories.iter().try_for_each(|trajectory| trajectory.verify(self.joint_count()))
    }
}

impl Joint {
    /// A revolute joint named by its number, counted from 1.
    pub fn numbered(number: usize) -> Self {
        Joint { name: format!("joint {number}"), kind: JointKind::Revolute }
    }
}

/// Joints as people list them, `1,3`, counted from 1 there and from 0 here.
///
/// # Errors
/// The first that is no joint.
pub fn joints_in(text: &str) -> Result<Vec<usize>, &str> {
    let joint = |number: &str| number.parse::<usize>().ok()?.checked_sub(1);
    text.split(',').map(str::trim).map(|number| joint(number).ok_or(number)).collect()
}

/// Joints for people: `joint 2`, `joints 1, 3`; counted from 1.
pub fn joints_text(joints: &[usize]) -> String {
    let numbers: Vec<String> = joints.iter().map(|joint| (joint + 1).to_string()).collect();
    format!("joint{} {}", if joints.len() == 1 { "" } else { "s" }, numbers.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signals::Signals;

    fn recording(kinds: &[JointKind]) -> Recording {
        let signal = || Signals::zeros(kinds.len(), 3);
        let channels = Channels { time: vec![0.0, 1.0, 2.0], q: signal(), qd: signal(), qdd: signal(), tau: signal() };
        let mut recording = Recording::of_runs(vec![Trajectory::new("run", channels).unwrap()]);
        recording.joints.iter_mut().zip(kinds).for_each(|(joint, kind)| joint.kind = *kind);
        recording
    }

    /// Units and words are those of the joints; where some turn and others slide, both.
    #[test]
    fn units_are_those_of_what_turns_and_slides() {
        use JointKind::{Prismatic, Revolute};
        let of = |kinds: &[JointKind]| (recording(kinds).units().join(", "), recording(kinds).effort());
        assert_eq!(of(&[Revolute, Revolute]), ("rad, rad/s, rad/s², N m".to_owned(), "torque"));
        assert_eq!(of(&[Prismatic, Prismatic]), ("m, m/s, m/s², N".to_owned(), "force"));
        let mixed = "rad or m, rad/s or m/s, rad/s² or m/s², N m or N".to_owned();
        assert_eq!(of(&[Revolute, Prismatic]), (mixed, "torque"));
    }

    #[test]
    fn gravity_that_was_taken_out_is_not_in_the_arm() {
        let mut recording = recording(&[JointKind::Revolute]);
        recording.stated_arm = Some(Arm::uniform(1));
        assert_eq!(recording.arm_in_torque(), Some(Arm::uniform(1)));
        recording.torque.state(TorqueFact::WithoutGravity);
        assert!(recording.is_weightless() && recording.arm_in_torque().is_some_and(|arm| arm.gravity == 0.0));
    }

    #[test]
    fn joints_are_listed_from_one() {
        assert_eq!(joints_in("1, 3"), Ok(vec![0, 2]));
        assert_eq!((joints_in("1,0"), joints_in("x")), (Err("0"), Err("x")));
        assert_eq!([joints_text(&[1]), joints_text(&[0, 2])], ["joint 2", "joints 1, 3"]);
    }
}
