//! A report in words: said here once, for the window, the command line and the texts of the JSON.

use serde::Serialize;
use serde::ser::{SerializeStruct, Serializer};

use super::conclusion::{CARRIES_OVER, NOISIER};
use super::presence::{LIKELY, SURE};
use super::proposal::percent;
use super::report::{
    Alternative, Candidate, Completeness, Exciting, Ground, HeldOut, MissingEffect, NotKnown, Note, Presence, Refusal,
    Report, TellingMotion, Verdict,
};
use crate::effect::NotApplicable;
use crate::model::Preset;
use crate::recording::joints_text;
use crate::recording::torque::TorqueFact;

/// Above so many times the evidence the number says nothing more: it grows with the noise's smallness.
const MOST_TIMES: f64 = 1000.0;
/// So many effects that explain nearly as much are told by name; a report as JSON has all.
const MOST_ALTERNATIVES: usize = 4;

impl Report {
    /// The answer in a sentence.
    pub fn headline(&self) -> &'static str {
        let is_all = self.unexplained_joints.is_empty();
        match self.verdict {
            Verdict::Missing if is_all => "Something is missing, and these effects explain it:",
            Verdict::Missing => {
                "Something is missing; these effects explain a part of it, but more is left than noise:"
            }
            Verdict::Ambiguous if is_all => "Something is missing; these effects explain it, others nearly as well:",
            Verdict::Ambiguous => {
                "Something is missing; these effects explain a part of it, others nearly as well, and more is left than noise:"
            }
            Verdict::NothingMissing if self.is_of_a_part() => {
                "Nothing is missing in the torque as it was logged, which is not all that the joints felt."
            }
            Verdict::NothingMissing => "Nothing is missing.",
            Verdict::UnknownEffect => "Something is missing that is not in the catalogue.",
        }
    }

    /// Whether something is stated that keeps a part of what the joints felt from the torque.
    pub fn is_of_a_part(&self) -> bool {
        let is_partial = |fact: TorqueFact| fact.hides().is_some() && fact != TorqueFact::Commanded;
        self.not_known.iter().any(|it| matches!(it, NotKnown::NotInTorque { fact } if is_partial(*fact)))
    }

    /// What to do next and what can't be known, in sentences.
    pub fn advice(&self) -> String {
        let notes = self.notes.iter().map(Note::sentence);
        // Of what is not known for the same reason one sentence tells.
        let mut unknown: Vec<(Vec<String>, String)> = Vec::new();
        for (what, why) in self.not_known.iter().map(NotKnown::what_and_why) {
            match unknown.iter_mut().find(|(_, other)| !why.is_empty() && *other == why) {
                Some((all, _)) => all.push(what),
                None => unknown.push((vec![what], why)),
            }
        }
        let unknown = unknown.iter().map(|(what, why)| format!("Not known: {}{why}.", what.join(", ")));
        notes.chain(unknown).collect::<Vec<_>>().join(" ")
    }
}

impl Alternative {
    /// Its name, where it is if not in the same place, and on which joints it explains as much if not on all.
    fn text(&self) -> String {
        let name = self.effect.placed(self.elsewhere);
        if self.joints.is_empty() { name } else { format!("{name} ({})", joints_text(&self.joints)) }
    }

    /// The first few of many, and how many more there are.
    pub fn texts(others: &[Alternative]) -> Vec<String> {
        // One more takes no more room than to say so.
        let told = if others.len() <= MOST_ALTERNATIVES + 1 { others.len() } else { MOST_ALTERNATIVES };
        let more = (told < others.len()).then(|| format!("{} others", others.len() - told));
        others[..told].iter().map(Alternative::text).chain(more).collect()
    }
}

impl NotKnown {
    /// What is not known and what would tell, without its full stop.
    pub fn text(&self) -> String {
        let (what, why) = self.what_and_why();
        what + &why
    }

    /// What is not known, and what is said of it.
    fn what_and_why(&self) -> (String, String) {
        match *self {
            NotKnown::NotComputed { effect, lack } => {
                (NotApplicable { effect: effect.name, lack }.to_string(), String::new())
            }
            NotKnown::AbsorbedByBody { effect, joint } => {
                (effect.placed(joint), " can't be told from the base parameters: state the arm".to_owned())
            }
            NotKnown::Idle { effect, joint } => (
                effect.placed(joint),
                " can't be judged: where models learn there is no torque of the kind; record another motion, or hold another part out"
                    .to_owned(),
            ),
            NotKnown::NotInTorque { fact } => {
                (fact.hides().unwrap_or_else(|| fact.about()).to_owned(), String::new())
            }
        }
    }
}

impl Note {
    /// It as a sentence.
    pub fn sentence(&self) -> String {
        match self {
            Note::AddFirst { effect, joints } => format!("Add {} on {} first.", effect.name, joints_text(joints)),
            Note::HardlyTold { effect, from, telling } => {
                let others = Alternative::texts(from).join(" or ");
                let open = format!("These data hardly tell {} from {others}", effect.name);
                match telling {
                    Some(telling) => format!(
                        "{open}; record {}, which gives {} the evidence against {}.",
                        telling.motion.text(),
                        telling.times(),
                        telling.against.name
                    ),
                    None => format!("{open}, and no other motion would do it better."),
                }
            }
            Note::NeedsLinkEncoder { effect } => {
                format!("The formula of {} takes the angle to be measured on the link, not on the motor.", effect.name)
            }
            Note::NeedsMotorEncoder { effect } => {
                format!("The formula of {} takes the angle to be measured on the motor, not on the link.", effect.name)
            }
            Note::MoreThanNoise { joints } => format!(
                "The residual of {} is still more than noise: no effect of the catalogue explains the rest.",
                joints_text(joints)
            ),
            Note::RaisesError { effect, joints } => format!(
                "With {} the held-out error of {} rises: what it explains in training does not carry over.",
                effect.name,
                joints_text(joints)
            ),
            Note::MayStandIn => {
                "What was named may only stand in for something that is not in the catalogue: look at the \
                                 residual views before you add it."
                    .to_owned()
            }
            Note::NoneExplains { joints } => format!(
                "The residual of {} is not noise, but no effect of the catalogue explains it: look at it in the residual \
                 views.",
                joints_text(joints)
            ),
            Note::FailsOnHeldOut { joints } => format!(
                "On held-out data the error of {} is far larger than in training: something acts there only (a contact, a load, a \
                 collision), or its motion goes where the training data don't. Hold another fifth out (`--held-out-fifth`, or Data), so that models learn from it, or look there in the residual \
                 views.",
                joints_text(joints)
            ),
            Note::Burst { joints, trajectory, seconds: [from, to], times, not_in_training } => format!(
                "From {from:.2} to {to:.2} s of trajectory \u{201c}{trajectory}\u{201d} the error of {} is {times:.0} times that of most of the log: something acts \
                 there only (a contact, a collision, a load, a faulty reading), or it moves there as nowhere else. Look there in the residual views{}.",
                joints_text(joints),
                if *not_in_training {
                    "; no model learns from that stretch: to have it explained, hold another part out"
                } else {
                    ""
                }
            ),
            Note::NoiseOfMotion { joints } => format!(
                "What is left of {} looks like noise, but is more than {NOISIER} times that of the torque: it is most likely that of the motion \
                 (derivatives, a coarse encoder, channels read at different moments). A lower cut-off or a better velocity \
                 helps there, no further effect does.",
                joints_text(joints)
            ),
            Note::NotFollowed { above_hz } => format!(
                "Above {above_hz:.1} Hz a rigid body asks for more torque along the motion that was measured than there is, on most joints: \
                 gears that rattle or give way, encoders and derivatives do that. Models are fitted to what is slower."
            ),
            Note::Excerpt { share } => format!(
                "The training part is long: {} of it was searched, from the start of each run; held-out errors are those of the whole \
                 held-out part.",
                percent(*share)
            ),
            Note::NothingShown => "Nothing is missing that these data could show.".to_owned(),
            Note::NotConfirmable { blocks } => format!(
                "Nothing confirms what was named: the recording makes {blocks} {}, too few to leave one out. Record more.",
                if *blocks == 1 { "block" } else { "blocks" }
            ),
            Note::StatedArmDiffers => format!(
                "The identified base parameters differ from the stated arm, and no single effect explains how: check the \
                 stated masses and lengths, or keep the preset `{}`.",
                Preset::RigidBody.id()
            ),
        }
    }
}

impl MissingEffect {
    /// How sure it is, in words: `there 99 %, in this form 62 %`.
    pub fn sureness(&self) -> String {
        format!("there {:.0} %, in this form {:.0} %", 100.0 * self.presence, 100.0 * self.form)
    }
}

impl Presence {
    /// Title of a column of [`Presence::missed`].
    pub const MISSED: &str = "squared held-out error without it";

    /// How much it is missed where it is held out; empty where that was not asked.
    pub fn missed(&self) -> String {
        self.held_out.map_or_else(String::new, |held_out| format!("× {:.2}", held_out.rises))
    }

    /// What is there and where: `dry friction, joint 2`.
    pub fn place(&self) -> String {
        let place = self.joint.map_or("arm".to_owned(), |joint| format!("joint {}", joint + 1));
        format!("{}, {place}", self.group.name())
    }

    /// How likely it is, in a word.
    pub fn likelihood(&self) -> &'static str {
        match self.probability {
            sure if sure >= SURE => "is there",
            likely if likely >= LIKELY => "is probably there",
            _ => "may be there",
        }
    }
}

impl HeldOut {
    /// How much it is missed, in words, without a full stop.
    pub fn text(&self) -> String {
        format!(
            "without it the squared error there is × {:.2}, t = {:.1} (in training × {:.2}); its presence was {:.0} % before",
            self.rises,
            self.t,
            self.rises_in_training,
            100.0 * self.before
        )
    }
}

impl Completeness {
    /// How much of what was missing is explained, and how much is left, without its full stop.
    pub fn text(&self) -> String {
        let explained = format!("{:.1} % of the squared residual is explained", 100.0 * self.explained);
        let noise = self.noise.map(|noise| format!(" ({:.2} % would be noise of the readings)", 100.0 * noise));
        let noise = noise.unwrap_or_default();
        let all = self.left.map(|left| format!("{:.2} % of what was measured is left{noise}, ", 100.0 * left));
        let beside_noise = match &all {
            Some(_) => format!("{:.2} % beside noise or in doubt", 100.0 * self.remainder),
            None => format!("{:.2} % of what was measured is left beside noise or in doubt", 100.0 * self.remainder),
        };
        let answer = if self.complete { "complete" } else { "not complete" };
        let held_out = self.held_out.filter(|times| *times > CARRIES_OVER);
        let held_out =
            held_out.map(|times| format!("; on held-out data the error is {times:.0} times that of training"));
        let all = all.unwrap_or_default();
        format!("joint {}: {answer}; {explained}, {all}{beside_noise}{}", self.joint + 1, held_out.unwrap_or_default())
    }
}

impl Candidate {
    /// By how much the squared error of its joint is divided when it alone is added. Not in per cent, as a probability is.
    pub fn divides(&self) -> String {
        match 1.0 / (1.0 - self.error_drop) {
            factor if !factor.is_finite() || factor < 0.0 => "÷ ∞".to_owned(),
            factor if factor < 1.005 => "no fall".to_owned(),
            factor if factor < 10.0 => format!("÷ {factor:.2}"),
            factor => format!("÷ {factor:.0}"),
        }
    }

    /// Why it is part of the answer, or why not.
    pub fn reason(&self) -> String {
        match self.ground {
            Ground::Confirmed => "left-out blocks confirm it".to_owned(),
            Ground::NotConfirmable { blocks } => format!("it fits, but {blocks} blocks are too few to confirm it"),
            Ground::TellsFromStatedArm => "it explains how the identified arm differs from the stated one".to_owned(),
            Ground::AbsorbedByBody => "the base parameters take its place".to_owned(),
            Ground::Idle => "it makes no torque where models learn".to_owned(),
            Ground::Contained => "it is part of an effect that was found".to_owned(),
            Ground::Doubtful { presence } => {
                format!(
                    "evidence of this kind is right in {:.0} % of the cases where the truth is known",
                    100.0 * presence
                )
            }
            Ground::Supported(held_out) if held_out.rises < 1.0 => {
                format!("training speaks more for it than held-out data do against it: {}", held_out.text())
            }
            Ground::Supported(held_out) => format!("held-out data speak for it: {}", held_out.text()),
            Ground::NotSupported(held_out) => format!("held-out data do not speak for it: {}", held_out.text()),
            Ground::MayStandIn { presence } => format!(
                "it is there with {:.0} %, and may stand in for something unknown that is left",
                100.0 * presence
            ),
            Ground::NotShown => "fitted with all that is named it may as well be zero, or is impossible".to_owned(),
            Ground::Superfluous => "beside what was found it explains hardly more than chance would".to_owned(),
            Ground::Refused(refusal) => refusal.text(),
        }
    }
}

impl Refusal {
    fn text(self) -> String {
        match self {
            Refusal::Chance { .. } => "it explains hardly more than chance would".to_owned(),
            Refusal::Small { share } => format!("it is only {:.2} % of what was measured", 100.0 * share),
            Refusal::OnAllJoints => {
                "all other joints have it, and on all at once the base parameters take its place".to_owned()
            }
            Refusal::Unphysical => "its best parameters have the wrong sign".to_owned(),
            Refusal::NoWave => "its best wave does not repeat along the way of the joint".to_owned(),
            Refusal::LeftBy { effect } => format!("it is no more than what the formula of {} leaves", effect.name),
            Refusal::NotConfirmed { .. } => "blocks that were left out do not confirm it".to_owned(),
            Refusal::FewBlocks { .. } => "only a few blocks of the recording speak for it".to_owned(),
            Refusal::NotOnFastMotion => {
                "fitted on the slower two thirds of the blocks it does not help on the fastest third".to_owned()
            }
        }
    }
}

impl TellingMotion {
    /// The gain in words.
    pub fn times(&self) -> String {
        if self.gain > MOST_TIMES {
            return format!("more than {MOST_TIMES} times");
        }
        format!("{:.*} times", usize::from(self.gain < 10.0), self.gain)
    }
}

impl Exciting {
    fn text(self) -> String {
        match self {
            Exciting::Speed { factor } if factor < 1.0 => format!("the same motion at {factor} times the speed"),
            Exciting::Speed { factor } => format!("the same motion {factor} times as fast"),
            Exciting::Range { factor } => format!("the same motion over {factor} times the range"),
            Exciting::TinyReversals => "tiny reversals (a few hundredths of the range)".to_owned(),
            Exciting::Alone { joint } => format!("joint {} alone, the others held still", joint + 1),
            Exciting::Sweeps => "sweeps at constant velocity, slow and fast".to_owned(),
        }
    }
}

/// The data, with what they say in words beside them.
impl Serialize for Report {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let unexplained: Vec<usize> = self.unexplained_joints.iter().map(|joint| joint + 1).collect();
        let mut fields = serializer.serialize_struct("Report", 11)?;
        fields.serialize_field("verdict", &self.verdict)?;
        fields.serialize_field("effects", &self.effects)?;
        fields.serialize_field("presence", &self.presence)?;
        fields.serialize_field("completeness", &self.completeness)?;
        fields.serialize_field("held_out_nmse", &self.held_out_nmse)?;
        fields.serialize_field("noise_floor_nmse", &self.noise_floor_nmse)?;
        fields.serialize_field("unexplained_joints", &unexplained)?;
        fields.serialize_field("advice", &self.advice())?;
        fields.serialize_field("notes", &self.notes)?;
        fields.serialize_field("not_known", &self.not_known)?;
        fields.serialize_field("ranking", &self.ranking)?;
        fields.end()
    }
}

impl Serialize for Candidate {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("Candidate", 6)?;
        fields.serialize_field("effect", self.effect)?;
        fields.serialize_field("joint", &self.joint.map(|joint| joint + 1))?;
        fields.serialize_field("error_drop", &self.error_drop)?;
        fields.serialize_field("accepted", &self.accepted())?;
        fields.serialize_field("reason", &self.reason())?;
        fields.serialize_field("ground", &self.ground)?;
        fields.end()
    }
}

impl Serialize for TellingMotion {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("TellingMotion", 4)?;
        fields.serialize_field("motion", &self.motion.text())?;
        fields.serialize_field("exciting", &self.motion)?;
        fields.serialize_field("against", self.against)?;
        fields.serialize_field("gain", &self.gain)?;
        fields.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::Verdict;
    use crate::effect::registry;

    /// What can't be confirmed is said: in the data, in the advice, and beside each candidate.
    #[test]
    fn too_few_blocks_are_told() {
        let effect = registry::find("coulomb-friction").unwrap();
        let ground = Ground::NotConfirmable { blocks: 2 };
        let report = Report {
            verdict: Verdict::Missing,
            effects: Vec::new(),
            presence: Vec::new(),
            completeness: Vec::new(),
            held_out_nmse: vec![0.1],
            noise_floor_nmse: None,
            unexplained_joints: vec![0],
            notes: vec![Note::NotConfirmable { blocks: 2 }],
            not_known: vec![NotKnown::AbsorbedByBody { effect, joint: Some(1) }],
            ranking: vec![Candidate { effect, joint: Some(0), error_drop: 0.5, ground }],
        };
        let json = serde_json::to_value(&report).unwrap();
        assert_eq!(json["notes"][0], serde_json::json!({ "kind": "not-confirmable", "blocks": 2 }));
        assert_eq!(json["ranking"][0]["ground"]["blocks"], 2);
        assert_eq!((&json["ranking"][0]["accepted"], &json["ranking"][0]["joint"]), (&true.into(), &1.into()));
        assert_eq!((&json["unexplained_joints"][0], &json["not_known"][0]["joint"]), (&1.into(), &2.into()));
        assert!(json["advice"].as_str().unwrap().contains("2 blocks, too few to leave one out"), "{}", json["advice"]);
        assert!(json["advice"].as_str().unwrap().ends_with("state the arm."), "{}", json["advice"]);
        assert!(report.ranking[0].reason().contains("too few to confirm it"));
        let read: Report = serde_json::from_value(json).unwrap();
        assert_eq!(read, report, "what is written is read again");
    }

    /// A candidate that is refused has no per cent beside the probability of one that is named.
    #[test]
    fn what_an_effect_alone_does_is_not_said_as_a_probability_is() {
        let divides = |error_drop| {
            let effect = registry::find("coulomb-friction").unwrap();
            Candidate { effect, joint: None, error_drop, ground: Ground::Superfluous }.divides()
        };
        assert_eq!([0.99, 0.5, 0.001, -0.3].map(divides), ["÷ 100", "÷ 2.00", "no fall", "no fall"]);
        assert_eq!(divides(1.0), "÷ ∞");
    }

    #[test]
    fn a_refusal_is_a_number_and_a_text() {
        let effect = registry::find("joint-elasticity").unwrap();
        let lag = registry::find("actuator-lag").unwrap();
        let candidate = |refusal| Candidate { effect, joint: None, error_drop: 0.1, ground: Ground::Refused(refusal) };
        let small = candidate(Refusal::Small { share: 0.0012 });
        assert!(!small.accepted() && small.reason() == "it is only 0.12 % of what was measured");
        assert_eq!(serde_json::to_value(small).unwrap()["ground"]["share"], 0.0012);
        let left = candidate(Refusal::LeftBy { effect: lag });
        assert_eq!(left.reason(), "it is no more than what the formula of actuator lag leaves");
        assert_eq!(serde_json::to_value(left).unwrap()["ground"]["effect"], "actuator-lag");
    }

    fn report(verdict: Verdict, unexplained_joints: Vec<usize>, not_known: Vec<NotKnown>) -> Report {
        Report {
            verdict,
            effects: Vec::new(),
            presence: Vec::new(),
            completeness: Vec::new(),
            held_out_nmse: vec![0.1],
            noise_floor_nmse: None,
            unexplained_joints,
            notes: vec![Note::NothingShown],
            not_known,
            ranking: Vec::new(),
        }
    }

    #[test]
    fn what_is_not_known_for_one_reason_is_one_sentence() {
        let [friction, rotor] = ["coulomb-friction", "rotor-inertia"].map(|id| registry::find(id).unwrap());
        let absorbed = |effect, joint| NotKnown::AbsorbedByBody { effect, joint: Some(joint) };
        let idle = NotKnown::Idle { effect: friction, joint: Some(1) };
        let advice = report(Verdict::Missing, Vec::new(), vec![absorbed(rotor, 0), idle, absorbed(rotor, 2)]).advice();
        assert_eq!(advice.matches("Not known: ").count(), 2, "{advice}");
        assert!(
            advice.contains("Not known: rotor inertia on joint 1, rotor inertia on joint 3 can't be told"),
            "{advice}"
        );
        assert!(advice.contains("Coulomb friction on joint 2 can't be judged"), "{advice}");
    }

    #[test]
    fn the_headline_says_whether_more_is_left() {
        let headline = |verdict, joints: &[usize]| report(verdict, joints.to_vec(), Vec::new()).headline();
        for verdict in [Verdict::Missing, Verdict::Ambiguous] {
            assert!(!headline(verdict, &[]).contains("more"), "{verdict:?}");
            assert!(headline(verdict, &[1]).contains("more") && headline(verdict, &[1]).contains("than noise"));
            let others = headline(verdict, &[]).contains("others nearly as well");
            assert_eq!(others, verdict == Verdict::Ambiguous);
        }
        assert!(headline(Verdict::UnknownEffect, &[0]).contains("not in the catalogue"));
        assert_eq!(headline(Verdict::NothingMissing, &[]), "Nothing is missing.");
    }

    /// A torque from which friction was taken says nothing of friction; a command is whole.
    #[test]
    fn nothing_is_missing_only_in_the_torque_as_it_was_logged() {
        let of = |fact| report(Verdict::NothingMissing, Vec::new(), vec![NotKnown::NotInTorque { fact }]);
        for fact in TorqueFact::ALL {
            let hides_a_part =
                [TorqueFact::Link, TorqueFact::WithoutGravity, TorqueFact::WithoutFriction].contains(&fact);
            assert_eq!(of(fact).is_of_a_part(), hides_a_part, "{fact:?}");
            assert_eq!(of(fact).headline().contains("not all that the joints felt"), hides_a_part);
            let hidden = fact.hides().unwrap_or_else(|| fact.about());
            assert_eq!(
                of(fact).advice(),
                format!("Nothing is missing that these data could show. Not known: {hidden}.")
            );
        }
    }

    #[test]
    fn of_many_alternatives_the_first_are_named_and_the_rest_counted() {
        let effect = |id| registry::find(id).unwrap();
        let of = |elsewhere, joints: &[usize]| Alternative {
            effect: effect("viscous-friction"),
            elsewhere,
            joints: joints.to_vec(),
        };
        let all =
            [of(None, &[]), of(None, &[2, 4]), of(Some(0), &[]), of(Some(0), &[3]), of(None, &[1]), of(None, &[5])];
        let name = effect("viscous-friction").name;
        let elsewhere = effect("viscous-friction").placed(Some(0));
        let named = [
            name.to_owned(),
            format!("{name} (joints 3, 5)"),
            elsewhere.clone(),
            format!("{elsewhere} (joint 4)"),
            format!("{name} (joint 2)"),
        ];
        assert_eq!(Alternative::texts(&all[..5]), named);
        let mut told = named[..4].to_vec();
        told.push("2 others".to_owned());
        assert_eq!(Alternative::texts(&all), told);
        assert!(Alternative::texts(&[]).is_empty());
    }

    #[test]
    fn a_motion_that_tells_is_said_with_its_gain() {
        let effect = |id| registry::find(id).unwrap();
        let gains = [1.5, 12.34, MOST_TIMES + 1.0];
        let telling = |gain, motion| TellingMotion { motion, against: effect("viscous-friction"), gain };
        let times = gains.map(|gain| telling(gain, Exciting::Sweeps).times());
        assert_eq!(times, ["1.5 times", "12 times", "more than 1000 times"]);
        let note = |telling| {
            let effect_there = effect("viscous-friction");
            let from = vec![Alternative { effect: effect_there, elsewhere: Some(1), joints: Vec::new() }];
            Note::HardlyTold { effect: effect("coulomb-friction"), from, telling }.sentence()
        };
        let place = effect("viscous-friction").placed(Some(1));
        let open = format!("These data hardly tell Coulomb friction from {place}");
        assert_eq!(note(None), format!("{open}, and no other motion would do it better."));
        let said = |motion| note(Some(telling(1.5, motion)));
        let ways = [
            (Exciting::Speed { factor: 2.5 }, "the same motion 2.5 times as fast"),
            (Exciting::Speed { factor: 0.25 }, "the same motion at 0.25 times the speed"),
            (Exciting::Range { factor: 1.5 }, "the same motion over 1.5 times the range"),
            (Exciting::Alone { joint: 1 }, "joint 2 alone, the others held still"),
        ];
        for (motion, words) in ways {
            let rest = format!("; record {words}, which gives 1.5 times the evidence against viscous friction.");
            assert_eq!(said(motion), format!("{open}{rest}"));
        }
    }

    #[test]
    fn how_sure_and_how_complete_an_answer_is_stands_in_numbers() {
        let effect = registry::find("coulomb-friction").unwrap();
        let presence = |probability, joint| Presence {
            group: effect.family.group(),
            family: effect.family,
            joint,
            probability,
            effect,
            share: 0.1,
            held_out: None,
        };
        let words = [SURE, LIKELY, LIKELY - 0.01].map(|probability| presence(probability, None).likelihood());
        assert_eq!(words, ["is there", "is probably there", "may be there"]);
        let group = effect.family.group().name();
        let places = [presence(1.0, Some(1)).place(), presence(1.0, None).place()];
        assert_eq!(places, [format!("{group}, joint 2"), format!("{group}, arm")]);
        let complete = Completeness { explained: 0.98, left: Some(0.03), remainder: 0.01, ..Completeness::example() };
        let told = "joint 1: complete; 98.0 % of the squared residual is explained, 3.00 % of what was measured is left, 1.00 % beside \
                    noise or in doubt";
        assert_eq!(complete.text(), told);
        let noisy = Completeness { noise: Some(0.024), ..complete }.text();
        assert!(
            noisy.contains("3.00 % of what was measured is left (2.40 % would be noise of the readings), 1.00 %"),
            "{noisy}"
        );
        let fails = Completeness { held_out: Some(12.3), ..complete };
        assert_eq!(fails.text(), format!("{told}; on held-out data the error is 12 times that of training"));
        let older = Completeness { left: None, complete: false, ..complete }.text();
        assert!(
            older.starts_with("joint 1: not complete;")
                && older.ends_with("1.00 % of what was measured is left beside noise or in doubt")
        );
    }

    #[test]
    fn a_stretch_that_stands_out_is_told_with_its_time() {
        let note = |not_in_training| {
            let (joints, trajectory) = (vec![0, 2], "b".to_owned());
            Note::Burst { joints, trajectory, seconds: [1.0, 1.504], times: 7.4, not_in_training }.sentence()
        };
        let told = "From 1.00 to 1.50 s of trajectory \u{201c}b\u{201d} the error of joints 1, 3 is 7 times that of most of the log";
        assert!(note(false).starts_with(told) && note(false).ends_with("residual views."), "{}", note(false));
        assert!(note(true).ends_with("hold another part out."), "{}", note(true));
    }

    #[test]
    fn how_much_is_missed_where_it_is_held_out_stands_in_numbers() {
        let held_out = HeldOut { before: 0.674, rises: 0.976, rises_in_training: 1.148, t: -0.3 };
        let told =
            "without it the squared error there is × 0.98, t = -0.3 (in training × 1.15); its presence was 67 % before";
        assert_eq!(held_out.text(), told);
        let effect = registry::find("cogging").unwrap();
        let candidate = |ground| Candidate { effect, joint: Some(0), error_drop: 0.1, ground };
        let [no, yes] = [Ground::NotSupported(held_out), Ground::Supported(held_out)].map(candidate);
        assert_eq!(no.reason(), format!("held-out data do not speak for it: {told}"));
        assert_eq!(yes.reason(), format!("training speaks more for it than held-out data do against it: {told}"));
        assert!(yes.accepted() && !no.accepted());
        let may_stand_in = candidate(Ground::MayStandIn { presence: 0.734 });
        assert_eq!(may_stand_in.reason(), "it is there with 73 %, and may stand in for something unknown that is left");
        assert!(!may_stand_in.accepted());
        let missed = candidate(Ground::Supported(HeldOut { rises: 1.5, ..held_out }));
        assert!(
            missed.reason().starts_with("held-out data speak for it: without it the squared error there is × 1.50")
        );
    }
}
