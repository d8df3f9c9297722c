//! What a diagnosis says, as data: [`super::words`] says it in words, and writes both to JSON.

use serde::{Deserialize, Serialize};

use crate::effect::{Axis, Effect, Family, Group, Lack};
use crate::model::Parameter;
use crate::model::fit::joint_number;
use crate::recording::Recording;
use crate::recording::hold_out::HoldOut;
use crate::recording::torque::TorqueFact;

/// The answer to "what is missing?".
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Report {
    /// The answer in a word.
    pub verdict: Verdict,
    /// What is missing, in the order in which it should be added.
    pub effects: Vec<MissingEffect>,
    /// How likely each family of effects is there, the likeliest first; what is not worth a thought is left out.
    pub presence: Vec<Presence>,
    /// How complete the answer is, by joint.
    pub completeness: Vec<Completeness>,
    /// Held-out nMSE of each joint with the model as it was.
    pub held_out_nmse: Vec<f64>,
    /// Held-out nMSE of each joint that noise alone would leave; `None` if that can't be told.
    pub noise_floor_nmse: Option<Vec<f64>>,
    /// Joints, counted from 0 (written counted from 1), whose answer is not complete.
    #[serde(with = "joint_numbers")]
    pub unexplained_joints: Vec<usize>,
    /// What to do next, and what to doubt.
    pub notes: Vec<Note>,
    /// What these data can't answer.
    pub not_known: Vec<NotKnown>,
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
    /// Which; its id in files.
    pub effect: &'static Effect,
    /// The joints, counted from 0; written counted from 1.
    #[serde(with = "joint_numbers")]
    pub joints: Vec<usize>,
    /// Probability that something of its family is there, 0 to 1: the least over its joints.
    pub presence: f64,
    /// Probability that it is there in this form, if it is there, 0 to 1: the least over its joints.
    pub form: f64,
    /// Its parameters with all effects of the report in the model.
    pub parameters: Vec<Parameter>,
    /// Held-out nMSE of each joint before it is added (with those before it in the report).
    pub nmse_before: Vec<f64>,
    /// The same after.
    pub nmse_after: Vec<f64>,
    /// Effects that explain nearly as much.
    pub alternatives: Vec<Alternative>,
    /// The motion that would tell it from the closest of them; `None` without alternatives, or if no motion does better than
    /// the one at hand.
    pub telling_motion: Option<TellingMotion>,
    /// Residual without it and what it explains, for plots.
    #[serde(skip)]
    pub evidence: Vec<Evidence>,
}

/// What the held-out part says of a family that was found, or may well be there: how much it is missed there if it is left out and
/// the rest is fitted anew, in the band in which models are fitted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HeldOut {
    /// How likely it was there before the held-out part was asked, 0 to 1.
    pub before: f64,
    /// So many times as large is the squared error of the joints that feel it without it, where it is held out: their geometric mean.
    pub rises: f64,
    /// The same in training.
    pub rises_in_training: f64,
    /// How steady the rise is over pieces of the held-out part: t of its shares of their errors.
    #[serde(default)]
    pub t: f64,
}

/// How likely a family of effects is there.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Presence {
    /// The kind of physics.
    pub group: Group,
    /// The family.
    pub family: Family,
    /// The joint, counted from 0; written counted from 1; none for the whole arm.
    #[serde(with = "joint_number")]
    pub joint: Option<usize>,
    /// Probability that something of the family is there, 0 to 1.
    pub probability: f64,
    /// The form in which it explains most.
    pub effect: &'static Effect,
    /// RMS of its torque over that of the measured torque, on the joint where it is largest.
    pub share: f64,
    /// What the held-out part says of it; none where it was not in doubt or not named before that.
    #[serde(default)]
    pub held_out: Option<HeldOut>,
}

/// How complete the answer is on one joint.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Completeness {
    /// The joint, counted from 0; written counted from 1.
    #[serde(with = "alone")]
    pub joint: usize,
    /// Share of the squared residual of the model as it was that the named effects explain, 0 to 1.
    pub explained: f64,
    /// RMS of all that is left, noise too, over that of the measured torque, behind the filter of the diagnosis; `None` in reports of an
    /// older program.
    #[serde(default)]
    pub left: Option<f64>,
    /// RMS of what noise of the readings makes of what is left, over that of the measured torque; `None` where they don't tell their noise,
    /// and in reports of an older program.
    #[serde(default)]
    pub noise: Option<f64>,
    /// RMS of what is left beyond noise (where that is not told: and does not look white), or rests on doubtful names, over that of the measured
    /// torque.
    pub remainder: f64,
    /// RMS error on held-out data over that in training, with all that was named; `None` where nothing is held out, and in reports of
    /// an older program.
    #[serde(default)]
    pub held_out: Option<f64>,
    /// Whether the remainder is no more than where the truth is known to be complete and has no law, held-out data don't contradict it, and no
    /// stretch stands out.
    pub complete: bool,
}

/// An effect that explains nearly as much as a named one.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Alternative {
    /// Which; its id in files.
    pub effect: &'static Effect,
    /// Its joint, counted from 0 (written counted from 1), where it is not that of the named one.
    #[serde(with = "joint_number")]
    pub elsewhere: Option<usize>,
    /// On which joints of the named one it does (counted from 0, written counted from 1), if not on all.
    #[serde(default, with = "joint_numbers")]
    pub joints: Vec<usize>,
}

/// A motion that would tell an effect from a rival.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct TellingMotion {
    /// What to record.
    #[serde(rename = "exciting")]
    pub motion: Exciting,
    /// The rival.
    pub against: &'static Effect,
    /// So many times the evidence, sample for sample, of the motion at hand.
    pub gain: f64,
}

/// A motion that could be recorded next.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Exciting {
    /// The same paths, faster or slower.
    Speed {
        /// So many times as fast.
        factor: f64,
    },
    /// The same motion over another range.
    Range {
        /// So many times as far from its middle.
        factor: f64,
    },
    /// Small swings about the middle.
    TinyReversals,
    /// One joint moves as before, the others stand still.
    Alone {
        /// Counted from 0; written counted from 1.
        #[serde(with = "alone")]
        joint: usize,
    },
    /// Back and forth at constant velocity.
    Sweeps,
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
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Candidate {
    /// Which; its id in files.
    pub effect: &'static Effect,
    /// The joint, counted from 0; written counted from 1; none for an effect of the whole arm.
    #[serde(with = "joint_number")]
    pub joint: Option<usize>,
    /// Cross-validated drop of the squared residual of its joint when it alone is added to the model, 0 to 1; negative if
    /// it makes things worse.
    pub error_drop: f64,
    /// Why it is part of the answer, or why not.
    pub ground: Ground,
}

impl MissingEffect {
    /// Where it acts: each joint, from 0, or `None` for the whole arm.
    pub fn places(&self) -> Vec<Option<usize>> {
        self.effect.places(self.joints.iter().copied())
    }
}

impl Report {
    /// Whether the held-out part was asked about anything.
    pub fn asks_held_out(&self) -> bool {
        self.presence.iter().any(|one| one.held_out.is_some())
    }

    /// Whether the model with all that was named fits in training, but not where it was held out: another part is to be held out.
    pub fn fails_on_held_out(&self) -> bool {
        self.notes.iter().any(|note| matches!(note, Note::FailsOnHeldOut { .. }))
    }

    /// What it advises to hold out instead of this: the part whose turn comes next where the model [fails](Report::fails_on_held_out) on it,
    /// until each was held out once.
    pub fn hold_out_next(&self, now: &HoldOut, recording: &Recording) -> Option<HoldOut> {
        if self.fails_on_held_out() { now.next(recording) } else { None }
    }

    /// How likely an effect that was named at a place (a joint, from 0, or the whole arm) is there.
    pub fn presence_of(&self, named: &MissingEffect, place: Option<usize>) -> f64 {
        let is_it = |one: &&Presence| one.family == named.effect.family && one.joint == place;
        self.presence.iter().find(is_it).map_or(named.presence, |one| one.probability)
    }
}

impl Candidate {
    /// Whether it is part of the answer.
    pub fn accepted(&self) -> bool {
        use Ground::{Confirmed, NotConfirmable, Supported, TellsFromStatedArm};
        matches!(self.ground, Confirmed | NotConfirmable { .. } | Supported(_) | TellsFromStatedArm)
    }
}

/// Why a candidate is part of the answer, or why not.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Ground {
    /// It is: left-out blocks confirm it.
    Confirmed,
    /// It is, but there are too few blocks to leave any out.
    NotConfirmable {
        /// How many there are.
        blocks: usize,
    },
    /// It is: the search had not found it, or it was in doubt, but it is likely with what the held-out part says.
    Supported(HeldOut),
    /// It is: it explains how the identified arm differs from the stated one.
    TellsFromStatedArm,
    /// The base parameters take its place.
    AbsorbedByBody,
    /// It makes no torque where models learn.
    Idle,
    /// It is part of an effect that was found.
    Contained,
    /// Beside what was found it explains hardly more than chance would.
    Superfluous,
    /// It was found, but where the truth is known such evidence is not right often enough to name it. Sessions that were saved before 28
    /// November 2026 may have `contradicted` in its place, of what was right in a quarter of the cases.
    #[serde(alias = "contradicted")]
    Doubtful {
        /// Probability that its family is there.
        #[serde(default = "contradicted")]
        presence: f64,
    },
    /// It was found, or may well be there, but with what the held-out part says it is not likely enough to name it.
    NotSupported(HeldOut),
    /// It is likely, but not likely enough beside something unknown for which it may stand in.
    MayStandIn {
        /// Probability that its family is there, with what the held-out part says.
        presence: f64,
    },
    /// It was found, but fitted with all that is named it may as well be zero, or is impossible.
    NotShown,
    /// It had evidence, but failed a gate.
    Refused(Refusal),
}

/// The presence of what was `contradicted`.
fn contradicted() -> f64 {
    0.25
}

/// The gate that a candidate failed, and what was measured there.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "gate")]
pub enum Refusal {
    /// It explains hardly more than chance would.
    Chance {
        /// Drop of the weighted squared error.
        gain: f64,
        /// What its parameters cost.
        needed: f64,
    },
    /// Its torque is hardly worth naming.
    Small {
        /// RMS of its torque over that of the measured torque of its joint.
        share: f64,
    },
    /// All other joints have it, and of all at once the body absorbs it.
    OnAllJoints,
    /// Its best parameters lie outside their bounds.
    Unphysical,
    /// Its best wave does not repeat along the way of the joint: what fits it may be anything that bows.
    NoWave,
    /// It is no more than what the formula of another effect leaves.
    LeftBy {
        /// That effect.
        effect: &'static Effect,
    },
    /// Blocks that were left out do not confirm its gain.
    NotConfirmed {
        /// The share of the gain that they confirm.
        confirmed: f64,
    },
    /// Only a few blocks speak for it.
    FewBlocks {
        /// t of the paired gains of the blocks.
        t: f64,
        /// What it must reach.
        needed: f64,
    },
    /// Fitted on the slower blocks, it does not help on the fastest third.
    NotOnFastMotion,
}

/// What to do next, or to doubt.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Note {
    /// Add this effect first.
    AddFirst {
        /// Which.
        effect: &'static Effect,
        /// Counted from 0; written counted from 1.
        #[serde(with = "joint_numbers")]
        joints: Vec<usize>,
    },
    /// These data hardly tell an effect from others.
    HardlyTold {
        /// Which.
        effect: &'static Effect,
        /// The others.
        from: Vec<Alternative>,
        /// What would tell; `None` if no motion would do it better than the one at hand.
        telling: Option<TellingMotion>,
    },
    /// The formula of a named effect takes the encoder to be on the link.
    NeedsLinkEncoder {
        /// Which effect.
        effect: &'static Effect,
    },
    /// The formula of a named effect takes the encoder to be on the motor.
    NeedsMotorEncoder {
        /// Which effect.
        effect: &'static Effect,
    },
    /// With all that was named, more is left than noise.
    MoreThanNoise {
        /// On these joints, counted from 0; written counted from 1.
        #[serde(with = "joint_numbers")]
        joints: Vec<usize>,
    },
    /// With a named effect added, the held-out error of its joints rises.
    RaisesError {
        /// Which effect.
        effect: &'static Effect,
        /// Counted from 0; written counted from 1.
        #[serde(with = "joint_numbers")]
        joints: Vec<usize>,
    },
    /// What was named may only stand in for something else.
    MayStandIn,
    /// Nothing can be named, but more is left than noise.
    NoneExplains {
        /// On these joints, counted from 0; written counted from 1.
        #[serde(with = "joint_numbers")]
        joints: Vec<usize>,
    },
    /// The model with all that was named fits in training, but not where it was held out.
    FailsOnHeldOut {
        /// On these joints, counted from 0; written counted from 1.
        #[serde(with = "joint_numbers")]
        joints: Vec<usize>,
    },
    /// In one stretch the model with all that was named errs many times as much as elsewhere.
    Burst {
        /// On these joints, counted from 0; written counted from 1.
        #[serde(with = "joint_numbers")]
        joints: Vec<usize>,
        /// In this trajectory, by name.
        trajectory: String,
        /// From then to then \[s\].
        seconds: [f64; 2],
        /// So many times as much (RMS) on the joint where it is most.
        times: f64,
        /// Whether models learn from none of it. Sessions that were saved before 29 November 2026 don't say it.
        #[serde(default)]
        not_in_training: bool,
    },
    /// What is left is noise, but far more than that of the torque: it comes from the motion, most likely.
    NoiseOfMotion {
        /// On these joints, counted from 0; written counted from 1.
        #[serde(with = "joint_numbers")]
        joints: Vec<usize>,
    },
    /// The torque does not follow the motion that was measured where that is faster: models are fitted to what is slower.
    NotFollowed {
        /// Than this \[Hz\].
        above_hz: f64,
    },
    /// The search looked at a part of the training data.
    Excerpt {
        /// How much of them.
        share: f64,
    },
    /// Nothing is missing that these data could show.
    NothingShown,
    /// There are too few blocks to leave any out, so nothing that was named is confirmed by data that it has not seen.
    NotConfirmable {
        /// How many there are.
        blocks: usize,
    },
    /// The identified base parameters differ from the stated arm, and no single effect explains how.
    StatedArmDiffers,
}

/// What these data can't show or rule out.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum NotKnown {
    /// It can't be computed.
    NotComputed {
        /// Which.
        effect: &'static Effect,
        /// What is lacking.
        lack: Lack,
    },
    /// The base parameters would take its place.
    AbsorbedByBody {
        /// Which.
        effect: &'static Effect,
        /// The joint, counted from 0; written counted from 1; none for an effect of the whole arm.
        #[serde(with = "joint_number")]
        joint: Option<usize>,
    },
    /// It makes no torque where models learn.
    Idle {
        /// Which.
        effect: &'static Effect,
        /// The joint, counted from 0; written counted from 1; none for an effect of the whole arm.
        #[serde(with = "joint_number")]
        joint: Option<usize>,
    },
    /// It is not in the torque, as it is stated.
    NotInTorque {
        /// What is stated.
        fact: TorqueFact,
    },
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

/// The same for a single joint.
pub(super) mod alone {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(joint: &usize, serializer: S) -> Result<S::Ok, S::Error> {
        (joint + 1).serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<usize, D::Error> {
        let number = usize::deserialize(deserializer)?;
        number.checked_sub(1).ok_or_else(|| serde::de::Error::custom("there is no joint 0"))
    }
}

#[cfg(test)]
impl MissingEffect {
    /// An effect that is surely there on joint 1 and halves its error: what tests begin from.
    pub(super) fn example(id: &str) -> MissingEffect {
        MissingEffect {
            effect: crate::effect::registry::find(id).unwrap(),
            joints: vec![0],
            presence: 0.95,
            form: 0.9,
            parameters: Vec::new(),
            nmse_before: vec![0.2],
            nmse_after: vec![0.1],
            alternatives: Vec::new(),
            telling_motion: None,
            evidence: Vec::new(),
        }
    }
}

#[cfg(test)]
impl Completeness {
    /// Of joint 1, on which half is explained and nothing is left.
    pub(super) fn example() -> Completeness {
        Completeness {
            joint: 0,
            explained: 0.5,
            left: None,
            noise: None,
            remainder: 0.0,
            held_out: None,
            complete: true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::registry;

    fn named(joints: Vec<usize>) -> MissingEffect {
        MissingEffect { joints, presence: 0.6, form: 0.62, ..MissingEffect::example("coulomb-friction") }
    }

    /// The presence of an effect is the least over its joints; each joint has its own.
    #[test]
    fn presence_is_told_by_place() {
        let effect = named(vec![0, 1]);
        assert_eq!(effect.sureness(), "there 60 %, in this form 62 %");
        let family = effect.effect.family;
        let presence = |family: Family, joint, probability| {
            let (group, effect) = (family.group(), effect.effect);
            Presence { group, family, joint, probability, effect, share: 0.1, held_out: None }
        };
        let other = registry::find("joint-spring").unwrap().family;
        assert_ne!(other, family);
        let report = Report {
            verdict: Verdict::Missing,
            effects: Vec::new(),
            presence: vec![
                presence(other, Some(1), 0.3),
                presence(family, Some(0), 0.9),
                presence(family, Some(1), 0.8),
            ],
            completeness: Vec::new(),
            held_out_nmse: Vec::new(),
            noise_floor_nmse: None,
            unexplained_joints: Vec::new(),
            notes: Vec::new(),
            not_known: Vec::new(),
            ranking: Vec::new(),
        };
        let of = |place| report.presence_of(&effect, place);
        assert_eq!([of(Some(0)), of(Some(1)), of(Some(2)), of(None)], [0.9, 0.8, 0.6, 0.6]);
    }

    #[test]
    fn a_contradicted_candidate_of_an_older_session_is_doubtful() {
        let ground = |text: &str| serde_json::from_str::<Ground>(text).unwrap();
        let older = ground(r#"{"kind": "contradicted", "rises": 1.2, "falls": 1.1}"#);
        assert_eq!(older, Ground::Doubtful { presence: 0.25 });
        let held_out = HeldOut { before: 0.7, rises: 0.9, rises_in_training: 1.1, t: -0.5 };
        let [doubtful, may_stand_in] = [Ground::Doubtful { presence: 0.4 }, Ground::MayStandIn { presence: 0.7 }];
        for one in [doubtful, may_stand_in, Ground::NotSupported(held_out), Ground::Supported(held_out)] {
            assert_eq!(ground(&serde_json::to_string(&one).unwrap()), one);
        }
    }

    /// A report in a file says nothing of a joint 0, wherever it stands.
    #[test]
    fn joints_are_counted_from_one_in_files() {
        let complete = Completeness { joint: 1, remainder: 0.1, complete: false, ..Completeness::example() };
        let written = serde_json::to_string(&complete).unwrap();
        assert!(written.contains("\"joint\":2"), "{written}");
        assert_eq!(serde_json::from_str::<Completeness>(&written).unwrap(), complete);
        let zero = serde_json::from_str::<Completeness>(&written.replace("\"joint\":2", "\"joint\":0"));
        assert!(zero.unwrap_err().to_string().contains("there is no joint 0"));
        let written = serde_json::to_string(&named(vec![0, 2])).unwrap();
        assert!(written.contains("\"joints\":[1,3]"), "{written}");
        assert_eq!(serde_json::from_str::<MissingEffect>(&written).unwrap().joints, [0, 2]);
        let zero = serde_json::from_str::<MissingEffect>(&written.replace("[1,3]", "[1,0]"));
        assert!(zero.unwrap_err().to_string().contains("there is no joint 0"));
    }
}
