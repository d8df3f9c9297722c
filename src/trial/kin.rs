//! Which names say the same of a motion: the table by which a judge tells another form of what is there from a false name.

use std::collections::BTreeMap;

use super::verdict::Planted;
use crate::effect::registry;

/// Share of the torque from which on an effect has to be named.
pub const TO_BE_NAMED: f64 = 0.03;

/// Friction that stays when the speed falls. In a motion that does not dwell on what tells them apart each is a form of the others.
const DRY: [&str; 11] = [
    "coulomb-friction",
    "asymmetric-friction",
    "stribeck-friction",
    "dahl-hysteresis",
    "maxwell-slip",
    "bouc-wen-hysteresis",
    "lugre-friction",
    "friction-drift",
    "friction-warm-up",
    "load-friction",
    "position-friction",
];

/// Friction that grows with the speed.
const SPEED: [&str; 3] = ["viscous-friction", "quadratic-drag", "concave-friction"];

/// What pulls a joint back by where it is.
const SPRINGS: [&str; 4] = ["joint-spring", "hardening-spring", "upper-stop", "lower-stop"];

/// What is soft or loose between motor and link, seen from either side.
const ELASTIC: [&str; 4] = ["joint-elasticity", "backlash", "motor-side-elasticity", "motor-side-backlash"];

/// Names with their places; joints from 1.
pub type Names = Vec<(String, Option<usize>)>;

/// Where an effect acts.
#[derive(Debug, Clone, Copy)]
pub struct Place<'a> {
    /// Its id in the catalogue, or the name of something that is not in it.
    pub effect: &'a str,
    /// The joint, from 1; none for the whole arm.
    pub joint: Option<usize>,
    /// How many joints the arm has.
    pub joints: usize,
}

impl Place<'_> {
    /// What a judge has to know of an effect that acts here and makes this share of the torque. No rigid body takes it up.
    pub fn planted(&self, share: f64, parameters: BTreeMap<String, f64>) -> Planted {
        let [equal, also] = self.kin();
        Planted {
            effect: self.effect.to_owned(),
            joint: self.joint,
            strong: share >= TO_BE_NAMED,
            equal,
            also,
            unknown: registry::find(self.effect).is_err(),
            absorbed: false,
            assumed: false,
            parameters,
        }
    }

    /// Whether the base parameters of a planar arm take it up by its nature. The rotor of the first joint turns with the first
    /// link.
    pub fn is_absorbed(&self) -> bool {
        self.effect == "tip-payload" || (self.effect == "rotor-inertia" && self.joint == Some(1))
    }

    /// What else says the same of the motion, and what goes with it.
    fn kin(&self) -> [Names; 2] {
        let Place { effect, joint, joints } = *self;
        let here = |names: &[&str]| -> Names { names.iter().map(|name| ((*name).to_owned(), joint)).collect() };
        let of_arm = |name: &str| vec![(name.to_owned(), None)];
        match effect {
            _ if DRY.contains(&effect) => {
                // Different in the two directions is the same friction with an offset.
                let also = if effect == "asymmetric-friction" { here(&["torque-offset"]) } else { Vec::new() };
                [here(&DRY), also]
            }
            _ if SPEED.contains(&effect) => [here(&SPEED), Vec::new()],
            _ if SPRINGS.contains(&effect) => [here(&SPRINGS), here(&["torque-offset"])],
            "torque-offset" => [here(&["offset-drift", "joint-spring"]), Vec::new()],
            "offset-drift" => [here(&["torque-offset"]), Vec::new()],
            // A body that is identified has no scale of its own: too much on one joint is too little on the other.
            "torque-gain" if joints == 2 => [vec![(effect.to_owned(), joint.map(|joint| 3 - joint))], Vec::new()],
            _ if ELASTIC.contains(&effect) => [here(&ELASTIC), here(&["rotor-inertia"])],
            "actuator-lag" => [of_arm("derivative-delay"), Vec::new()],
            "base-tilt" => {
                let leaning = (1..=joints).map(|joint| ("com-offset".to_owned(), Some(joint)));
                [leaning.collect(), Vec::new()]
            }
            "com-offset" => [of_arm("base-tilt"), Vec::new()],
            _ => [Vec::new(), Vec::new()],
        }
    }
}

/// Takes account of the side of the encoder, which a truth states beside the name of what is soft or loose: the catalogue has a
/// name for each side. Of all else it changes nothing.
pub fn tell_the_side(planted: &mut Planted, on_motor: bool) {
    if !ELASTIC.contains(&planted.effect.as_str()) {
        return;
    }
    let from_motor = match planted.effect.as_str() {
        "joint-elasticity" => Some("motor-side-elasticity"),
        "backlash" => Some("motor-side-backlash"),
        _ => None,
    };
    if let Some(from_motor) = from_motor.filter(|_| on_motor) {
        from_motor.clone_into(&mut planted.effect);
        // They are those of the other side.
        planted.parameters.clear();
    }
    planted.equal.extend(ELASTIC.map(|name| (name.to_owned(), planted.joint)));
}

/// Values of parameters by the catalogue's names; none of what is not in it.
pub fn parameters(effect: &str, values: &[f64]) -> BTreeMap<String, f64> {
    let names = registry::find(effect).into_iter().flat_map(|effect| effect.parameters);
    names.map(|parameter| parameter.name.to_owned()).zip(values.iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kin_is_in_the_catalogue() {
        for effect in registry::ALL {
            let place = Place { effect: effect.id, joint: Some(1), joints: 3 };
            for (name, _) in place.kin().concat() {
                assert!(registry::find(&name).is_ok(), "{}: {name}", effect.id);
            }
        }
    }

    #[test]
    fn what_is_loose_has_a_name_for_each_side() {
        let planted = |on_motor| {
            let mut planted = Place { effect: "backlash", joint: Some(2), joints: 3 }.planted(0.1, BTreeMap::new());
            planted.equal.clear();
            tell_the_side(&mut planted, on_motor);
            planted
        };
        let verdicts =
            |on_motor: bool| ["backlash", "motor-side-backlash"].map(|name| planted(on_motor).judge(name, Some(2)));
        use crate::trial::verdict::Verdict::{Form, Right};
        let mut told = planted(true);
        tell_the_side(&mut told, true);
        assert_eq!(told.effect, "motor-side-backlash", "a truth may use the name of the side itself");
        assert_eq!((verdicts(false), verdicts(true)), ([Right, Form], [Form, Right]));
        let friction = Place { effect: "coulomb-friction", joint: Some(1), joints: 3 }.planted(0.1, BTreeMap::new());
        let mut same = friction.clone();
        tell_the_side(&mut same, true);
        assert_eq!(same, friction);
    }

    /// Friction of one joint is no form of that of another, and what is not in the catalogue has no kin.
    #[test]
    fn forms_are_of_one_joint() {
        let of = |effect, joint| Place { effect, joint, joints: 3 }.planted(0.1, BTreeMap::new());
        assert!(of("coulomb-friction", Some(2)).equal.iter().all(|(_, joint)| *joint == Some(2)));
        let tilt: Names = (1..=3).map(|joint| ("com-offset".to_owned(), Some(joint))).collect();
        assert_eq!(of("base-tilt", None).equal, tilt);
        let gain = |joints| Place { effect: "torque-gain", joint: Some(1), joints }.planted(0.1, BTreeMap::new()).equal;
        assert_eq!((gain(2), gain(3)), (vec![("torque-gain".to_owned(), Some(2))], Vec::new()));
        let cable = of("cable", Some(1));
        assert!(cable.unknown && cable.equal.is_empty() && cable.also.is_empty());
    }
}
