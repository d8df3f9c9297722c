//! Which names say the same of a motion: the table by which a judge tells another form of what is there from a false name.

use std::collections::BTreeMap;

use super::verdict::Planted;
use crate::effect::{Effect, Family, Scope, registry};
use crate::recording::encoders::Side;

/// Share of the torque from which on an effect has to be named.
pub const TO_BE_NAMED: f64 = 0.03;

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
        let effect = registry::find(self.effect).ok();
        let [equal, also] = effect.map(|effect| self.kin(effect)).unwrap_or_default();
        Planted {
            effect: self.effect.to_owned(),
            joint: self.joint,
            strong: share >= TO_BE_NAMED,
            equal,
            also,
            unknown: effect.is_none(),
            absorbed: false,
            assumed: false,
            beside_everyday: None,
            parameters,
        }
    }

    /// Whether the base parameters of a planar arm take it up by its nature. The rotor of the first joint turns with the first
    /// link.
    pub fn is_absorbed(&self) -> bool {
        let is_of_arm_or_first = |effect: &Effect| effect.scope == Scope::Arm || self.joint == Some(1);
        registry::find(self.effect).is_ok_and(|effect| effect.facts.absorbed_by_body && is_of_arm_or_first(effect))
    }

    /// What else says the same of the motion, and what goes with it.
    fn kin(&self, effect: &'static Effect) -> [Names; 2] {
        let mut equal: Names = forms(effect).flat_map(|form| self.at(form)).collect();
        equal.extend(effect.facts.also_said_as.iter().flat_map(|id| self.named(id)));
        // A body that is identified has no scale of its own: too much on one joint is too little on the other.
        if let (Family::Gain, 2, Some(joint)) = (effect.family, self.joints, self.joint) {
            equal.push((effect.id.to_owned(), Some(3 - joint)));
        }
        [equal, effect.facts.goes_with.iter().flat_map(|id| self.named(id)).collect()]
    }

    fn named(&self, id: &str) -> Names {
        registry::find(id).map(|effect| self.at(effect)).unwrap_or_default()
    }

    /// Another effect where this one acts: on each joint, if this one acts on the whole arm and the other on a joint.
    fn at(&self, effect: &Effect) -> Names {
        let places = match (effect.scope, self.joint) {
            (Scope::Arm, _) => vec![None],
            (_, Some(joint)) => vec![Some(joint)],
            (_, None) => (1..=self.joints).map(Some).collect(),
        };
        places.into_iter().map(|joint| (effect.id.to_owned(), joint)).collect()
    }
}

/// The other forms in which a model can have what this effect is: those of its family. In a motion that does not dwell on what
/// tells them apart each says the same as the others. What is soft or loose is one, from whichever side it is seen.
fn forms(of: &'static Effect) -> impl Iterator<Item = &'static Effect> {
    let is_form = move |other: &&Effect| {
        *other != of && other.family == of.family && other.facts.encoder.is_some() == of.facts.encoder.is_some()
    };
    registry::addable().filter(is_form)
}

/// Takes account of the side of the encoder, which a truth states beside the name of what is soft or loose: the catalogue has a
/// name for each side. Of all else it changes nothing.
pub fn tell_the_side(planted: &mut Planted, on_motor: bool) {
    let Ok(mut effect) = registry::find(&planted.effect) else { return };
    let Some(side) = effect.facts.encoder else { return };
    if on_motor
        && side == Side::Link
        && let Some(from_motor) = effect.facts.other_side.and_then(|id| registry::find(id).ok())
    {
        effect = from_motor;
        effect.id.clone_into(&mut planted.effect);
        // They are those of the other side.
        planted.parameters.clear();
    }
    planted.equal.extend(forms(effect).map(|form| (form.id.to_owned(), planted.joint)));
}

/// Takes account of effects that the catalogue may not have had when a truth was written: they will do wherever the one will do
/// that stood for them.
pub fn tell_the_younger(planted: &mut Planted) {
    for (effect, elder) in registry::ALL.iter().filter_map(|effect| Some((effect, effect.facts.formerly?))) {
        let is_named = |id: &str| planted.effect == id || planted.equal.iter().any(|(name, _)| name == id);
        if is_named(elder) && !is_named(effect.id) {
            planted.equal.push((effect.id.to_owned(), planted.joint));
        }
    }
}

/// Values of parameters by the catalogue's names; none of what is not in it.
pub fn parameters(effect: &str, values: &[f64]) -> BTreeMap<String, f64> {
    let names = registry::find(effect).into_iter().flat_map(|effect| effect.parameters);
    names.map(|parameter| parameter.name.to_owned()).zip(values.iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::super::verdict::Verdict::{Beside, Form, Right};
    use super::*;

    /// What the judge holds to be the same, told by its forms and by what effects say of themselves.
    #[test]
    fn effects_of_a_family_are_forms_of_each_other() {
        let planted = |effect| Place { effect, joint: Some(1), joints: 3 }.planted(0.1, BTreeMap::new());
        let dry = planted("asymmetric-friction");
        assert_eq!(dry.equal.len(), 11, "{dry:?}");
        assert_eq!((dry.judge("stribeck-friction", Some(1)), dry.judge("torque-offset", Some(1))), (Form, Beside));
        let lag = planted("actuator-lag");
        assert_eq!((lag.judge("derivative-delay", None), lag.equal.len()), (Form, 1));
        let spring = planted("upper-stop");
        assert_eq!((spring.judge("joint-spring", Some(1)), spring.judge("torque-offset", Some(1))), (Form, Beside));
        assert_eq!(planted("torque-offset").judge("joint-spring", Some(1)), Form);
        // It hides small torques, and is nothing soft.
        assert_eq!(planted("dead-zone").equal, Vec::new());
        assert_eq!(planted("backlash").judge("rotor-inertia", Some(1)), Beside);
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
        let mut told = planted(true);
        tell_the_side(&mut told, true);
        assert_eq!(told.effect, "motor-side-backlash", "a truth may use the name of the side itself");
        assert_eq!((verdicts(false), verdicts(true)), ([Right, Form], [Form, Right]));
        let friction = Place { effect: "coulomb-friction", joint: Some(1), joints: 3 }.planted(0.1, BTreeMap::new());
        let mut same = friction.clone();
        tell_the_side(&mut same, true);
        assert_eq!(same, friction);
    }

    #[test]
    fn an_effect_that_is_younger_than_a_truth_will_do_where_its_elder_does() {
        let written = |effect, equal: &[&str]| {
            let mut planted = Place { effect, joint: Some(2), joints: 3 }.planted(0.1, BTreeMap::new());
            planted.equal = equal.iter().map(|&id| (id.to_owned(), Some(2))).collect();
            tell_the_younger(&mut planted);
            planted
        };
        for planted in [written("friction-warm-up", &[]), written("coulomb-friction", &["friction-warm-up"])] {
            assert_eq!(planted.judge("frictional-heating", Some(2)), Form);
            let mut again = planted.clone();
            tell_the_younger(&mut again);
            assert_eq!(again, planted);
        }
        assert_eq!(written("joint-spring", &["torque-offset"]).equal.len(), 1);
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
