//! Is a name right? Judged by what is in a recording, where one effect has several names that would do.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// What is in a recording, as the file beside it says.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Truth {
    /// The class that it is counted in, such as `single` or `unknown`.
    pub kind: String,
    /// Whether the velocity was recorded.
    pub with_speed: bool,
    /// What acts there.
    #[serde(rename = "truth")]
    pub planted: Vec<Planted>,
}

/// One effect that acts in a recording. Joints are counted from 1; `None` is the whole arm.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Planted {
    /// Its id in the catalogue, or the name of something that is not in it.
    pub effect: String,
    /// Where it acts.
    pub joint: Option<usize>,
    /// Whether it has to be named; a weak nuisance may be.
    pub strong: bool,
    /// What else says the same of the motion: other forms of it.
    pub equal: Vec<(String, Option<usize>)>,
    /// What may be named beside it, since it goes with it.
    pub also: Vec<(String, Option<usize>)>,
    /// Whether it is outside the catalogue.
    pub unknown: bool,
    /// Whether a rigid body takes it up, so that nobody has to name it.
    pub absorbed: bool,
    /// Whether nobody knows that it is there: it was named in a log of a real arm before anything was planted there, so it may be
    /// named again, and its name counts neither way.
    #[serde(default)]
    pub assumed: bool,
    /// Of something outside the catalogue: the share of its joint's torque (RMS) in which it does what a rigid body and what nearly every
    /// joint has can't do along that motion, if somebody looked.
    #[serde(default)]
    pub beside_everyday: Option<f64>,
    /// Its parameters by the catalogue's names, as far as they have them.
    pub parameters: BTreeMap<String, f64>,
}

/// What a name is, from bad to good.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Nothing of the kind is there.
    False,
    /// Named on a joint where something outside the catalogue acts.
    StandIn,
    /// It is there, or a form of it, but not on this joint.
    WrongJoint,
    /// It goes with what is there.
    Beside,
    /// Another form of what is there.
    Form,
    /// It is there.
    Right,
}

impl Verdict {
    /// All, from good to bad.
    pub const ALL: [Verdict; 6] =
        [Verdict::Right, Verdict::Form, Verdict::Beside, Verdict::WrongJoint, Verdict::StandIn, Verdict::False];

    /// Whether whoever believes the name is not misled.
    pub fn is_good(self) -> bool {
        self >= Verdict::Beside
    }
}

impl Truth {
    /// What has to be named.
    pub fn wanted(&self) -> impl Iterator<Item = &Planted> {
        let is_wanted =
            |planted: &&Planted| planted.strong && !planted.absorbed && !planted.unknown && !planted.assumed;
        self.planted.iter().filter(is_wanted)
    }

    /// What an effect is that was named on a joint (from 1; `None` for the whole arm): the best that it is for any that acts there.
    pub fn judge(&self, effect: &str, joint: Option<usize>) -> Verdict {
        let verdicts = self.planted.iter().map(|planted| planted.judge(effect, joint));
        verdicts.max().unwrap_or(Verdict::False)
    }
}

impl Planted {
    /// Whether this name says that it is there: as what it is or as another form of it.
    pub fn judge(&self, effect: &str, joint: Option<usize>) -> Verdict {
        let is_it = |(other, place): (&str, Option<usize>)| other == effect && place == joint;
        let is_there = |names: &[(String, Option<usize>)]| names.iter().any(|(other, place)| is_it((other, *place)));
        let is_form = |(other, _): &(String, Option<usize>)| other == effect;
        if self.unknown {
            let is_here = joint.is_none() || joint == self.joint;
            return if is_here { Verdict::StandIn } else { Verdict::False };
        }
        if is_it((&self.effect, self.joint)) {
            Verdict::Right
        } else if is_there(&self.equal) {
            Verdict::Form
        } else if is_there(&self.also) {
            Verdict::Beside
        } else if self.effect == effect || self.equal.iter().any(is_form) {
            Verdict::WrongJoint
        } else {
            Verdict::False
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRUTH: &str = r#"{
        "kind": "several", "zero": "up", "with_speed": true, "rate": 500,
        "truth": [
            {"effect": "coulomb-friction", "joint": 1, "share": 0.1, "strong": true, "family": "dry", "unknown": false,
             "absorbed": false, "equal": [["coulomb-friction", 1], ["dahl-hysteresis", 1]], "also": [], "parameters": {}},
            {"effect": "joint-spring", "joint": 2, "share": 0.005, "strong": false, "family": "spring", "unknown": false,
             "absorbed": false, "equal": [["hardening-spring", 2]], "also": [["torque-offset", 2]], "parameters": {}},
            {"effect": "tip-payload", "joint": null, "share": 0.1, "strong": true, "family": "payload", "unknown": false,
             "absorbed": true, "equal": [], "also": [], "parameters": {"payload_mass": 0.4}},
            {"effect": "cable", "joint": 3, "share": 0.1, "strong": true, "family": "unknown", "unknown": true,
             "absorbed": false, "equal": [], "also": [], "parameters": {}}
        ]
    }"#;

    #[test]
    fn names_are_judged_by_what_is_there() {
        let truth: Truth = serde_json::from_str(TRUTH).unwrap();
        for (effect, joint, verdict) in [
            ("coulomb-friction", Some(1), Verdict::Right),
            ("dahl-hysteresis", Some(1), Verdict::Form),
            ("dahl-hysteresis", Some(2), Verdict::WrongJoint),
            ("hardening-spring", Some(1), Verdict::WrongJoint),
            ("torque-offset", Some(2), Verdict::Beside),
            ("torque-offset", Some(1), Verdict::False),
            ("torque-gain", Some(3), Verdict::StandIn),
            ("dahl-hysteresis", Some(3), Verdict::WrongJoint),
            ("torque-gain", Some(1), Verdict::False),
            ("base-tilt", None, Verdict::StandIn),
            ("tip-payload", None, Verdict::Right),
        ] {
            assert_eq!(truth.judge(effect, joint), verdict, "{effect} on {joint:?}");
        }
        // Neither what is weak, nor what the body takes up, nor what nobody can name has to be named.
        assert_eq!(truth.wanted().map(|planted| planted.effect.as_str()).collect::<Vec<_>>(), ["coulomb-friction"]);
        let empty = Truth { planted: Vec::new(), ..truth };
        assert_eq!(empty.judge("coulomb-friction", Some(1)), Verdict::False);
    }
}
