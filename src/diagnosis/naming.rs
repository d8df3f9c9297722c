//! Names for what was found, each with the probability that it is right and the effects that explain nearly as much.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

use super::presence::Judged;
use super::report::Alternative;
use super::search::{CLOSE, Rival, Search, odds_of_form};
use super::stated_arm::{self, Comparison, StatedBody};
use crate::effect::{Effect, Family};

/// A rival counts as an alternative too if it explains all but this share of what the effect explains.
const NEARLY_AS_MUCH: f64 = 0.05;
/// Data alone never make certain, not even beside a stated arm.
const SUREST: f64 = 0.98;

/// One effect with all joints where it was found.
#[derive(Clone)]
pub struct Named {
    /// Which.
    pub effect: &'static Effect,
    /// Counted from 0.
    pub joints: Vec<usize>,
    /// Those of them where it is what most of the other joints have, too.
    pub usual: Vec<usize>,
    /// Drop of the weighted squared error.
    pub gain: f64,
    /// Probability that something of its family is there.
    pub presence: f64,
    /// Probability that it is there in this form, if it is there, by place.
    pub forms: BTreeMap<Option<usize>, f64>,
    /// Effects that explain nearly as much: at which of its places, which, and on which joint if that is another one.
    pub alternatives: Vec<(Option<usize>, &'static Effect, Option<usize>)>,
    /// Each of its groups beside each of its rivals that come close, of each group the closest first.
    pub rivals: Vec<(usize, usize)>,
    /// Whether it needs the rigid body held at the stated arm.
    pub pins: bool,
}

impl Named {
    /// Its places: each joint, or the whole arm.
    pub fn places(&self) -> Vec<Option<usize>> {
        self.effect.places(self.joints.iter().copied())
    }

    /// Probability that it is there in this form, if it is there: the least over its places.
    pub fn form(&self) -> f64 {
        self.places().iter().filter_map(|place| self.forms.get(place)).copied().fold(1.0, f64::min)
    }

    /// What explains nearly as much at any of its places, each once; what does at most of them comes first.
    pub fn alternatives_told(&self) -> Vec<Alternative> {
        let places = self.places();
        let mut told: BTreeMap<_, (&'static Effect, BTreeSet<Option<usize>>)> = BTreeMap::new();
        for &(place, effect, elsewhere) in self.alternatives.iter().filter(|(place, ..)| places.contains(place)) {
            told.entry((effect.id, elsewhere)).or_insert_with(|| (effect, BTreeSet::new())).1.insert(place);
        }
        let mut told: Vec<_> = told.into_iter().collect();
        told.sort_by_key(|(_, (_, on))| Reverse(on.len()));
        let alternative = |((_, elsewhere), (effect, on)): (_, (_, BTreeSet<Option<usize>>))| {
            let joints = if on.len() == places.len() { Vec::new() } else { on.into_iter().flatten().collect() };
            Alternative { effect, elsewhere, joints }
        };
        told.into_iter().map(alternative).collect()
    }
}

/// What is said of one group.
struct Judgement {
    gain: f64,
    presence: f64,
    form: f64,
    /// Which explain nearly as much, each with its joint if that is another one.
    alternatives: Vec<(&'static Effect, Option<usize>)>,
    /// The groups behind them, the closest first.
    rivals: Vec<usize>,
}

/// What may well be there though nothing of it was found, or stayed, and is worth asking the held-out part about: of each family at each place
/// the group that explains most beside what was found.
pub fn in_question_beside(search: &Search, judged: &Judged) -> Vec<usize> {
    let groups = &search.library.groups;
    let of_place = |(family, joint): (Family, Option<usize>)| {
        let is_it = |group: &usize| groups[*group].effect.family == family && groups[*group].joint == joint;
        let goes_with = |group: &usize| {
            !search.active.iter().any(|&other| groups[*group].excludes(&groups[other]))
                && !search.is_on_all_joints(&search.active, *group)
        };
        if search.active.iter().any(is_it) {
            return None;
        }
        let all =
            (0..groups.len()).filter(|group| is_it(group) && !search.absorbed.contains(group) && goes_with(group));
        // What the other joints have it has in their form, if at all: an odd one explains more, be it there or not.
        let mut usual = all.clone().filter(|&group| groups[group].effect.is_common() && search.is_usual(group));
        usual.next().or_else(|| search.best_beside(&search.active, all))
    };
    judged.in_question().filter_map(of_place).collect()
}

/// The groups that were found, and each of those that are likely `beside` them, the same effect on several joints once, the largest gain
/// first; those that need the stated arm last.
pub fn name_effects(
    search: &mut Search,
    beside: &[usize],
    comparison: &Comparison,
    stated: Option<&StatedBody>,
    judged: &Judged,
) -> Vec<Named> {
    let of_group = |search: &Search, group: usize| (group, judge(search, judged, group), false);
    let mut judgements: Vec<(usize, Judgement, bool)> =
        search.active.iter().map(|&group| of_group(search, group)).collect();
    for &group in beside {
        search.active.push(group);
        judgements.push(of_group(search, group));
        search.active.pop();
    }
    if let (Comparison::Explained(found), Some(stated)) = (comparison, stated) {
        judgements.extend(found.iter().map(|&group| (group, judge_absorbed(search, stated, found, group), true)));
    }
    let mut by_effect: BTreeMap<&'static str, Named> = BTreeMap::new();
    for (group, judgement, pins) in judgements {
        let place = &search.library.groups[group];
        let named = by_effect.entry(place.effect.id).or_insert(Named {
            effect: place.effect,
            joints: Vec::new(),
            usual: Vec::new(),
            gain: 0.0,
            presence: 1.0,
            forms: BTreeMap::new(),
            alternatives: Vec::new(),
            rivals: Vec::new(),
            pins: false,
        });
        named.pins |= pins;
        match place.joint {
            Some(joint) => named.joints.push(joint),
            None => named.joints.extend(0..search.library.design.joint_count()),
        }
        // What was not found is not named because the other joints have it.
        named.usual.extend(place.joint.filter(|_| search.is_usual(group) && !beside.contains(&group)));
        named.gain += judgement.gain;
        named.presence = named.presence.min(judgement.presence);
        named.forms.insert(place.joint, judgement.form);
        named.rivals.extend(judgement.rivals.into_iter().map(|rival| (group, rival)));
        let alternatives = judgement.alternatives.into_iter();
        named.alternatives.extend(alternatives.map(|(effect, elsewhere)| (place.joint, effect, elsewhere)));
    }
    let mut named: Vec<Named> = by_effect.into_values().collect();
    for effect in &mut named {
        effect.joints.sort_unstable();
    }
    named.sort_by(|a, b| a.pins.cmp(&b.pins).then(b.gain.total_cmp(&a.gain)));
    named
}

/// Gain of one effect of the set, the probability of its presence and its form, and the rivals that come close.
fn judge(search: &Search, judged: &Judged, group: usize) -> Judgement {
    let groups = &search.library.groups;
    let without: Vec<usize> = search.active.iter().copied().filter(|&other| other != group).collect();
    let found = search.cost(&search.active);
    let gain = search.cost(&without) - found;
    let price = search.price_of(group);
    let mut alternatives = Vec::new();
    let mut rivals: Vec<(f64, usize)> = Vec::new();
    // Of each other form the best shape.
    let mut forms: BTreeMap<&'static str, (&'static Effect, f64)> = BTreeMap::new();
    for Rival { group: rival, cost, .. } in search.rivals(group) {
        let worse = cost - found;
        let priced = worse + search.price_of(rival) - price;
        let is_form = groups[rival].effect.family == groups[group].effect.family
            && groups[rival].joint == groups[group].joint
            && groups[rival].effect != groups[group].effect;
        if is_form {
            let (_, least) = forms.entry(groups[rival].effect.id).or_insert((groups[rival].effect, f64::INFINITY));
            *least = least.min(priced);
        }
        // A rival that contains the effect explains as much by itself; it is one only if its surplus is worth its price.
        let contains = groups[rival].includes(&groups[group]);
        let is_simpler = groups[rival].parameter_count() <= groups[group].parameter_count();
        if priced < CLOSE || (!contains && is_simpler && worse < NEARLY_AS_MUCH * gain) {
            let elsewhere = groups[rival].effect == groups[group].effect;
            alternatives.push((groups[rival].effect, groups[rival].joint.filter(|_| elsewhere)));
            rivals.push((priced, rival));
        }
    }
    rivals.sort_by(|a, b| a.0.total_cmp(&b.0));
    let certainty = judged.certainty(groups[group].joint);
    // A form with more evidence was refused by left-out blocks: then it is one or the other.
    let odds = |(form, priced): &(&Effect, f64)| odds_of_form(form) * (-0.5 * certainty * priced.max(0.0)).exp();
    let others: f64 = forms.values().map(odds).sum();
    Judgement {
        gain,
        presence: judged.presence_of(search, group),
        // What no formula of the catalogue says has odds, too.
        form: 1.0 / (1.0 / groups[group].effect.family.form_is_right() + others),
        alternatives,
        rivals: rivals.into_iter().map(|(_, rival)| rival).collect(),
    }
}

/// The same for an effect that the base parameters absorb and the stated arm brings to light.
fn judge_absorbed(search: &Search, stated: &StatedBody, found: &[usize], group: usize) -> Judgement {
    let groups = &search.library.groups;
    let mut judgement =
        Judgement { gain: 0.0, presence: SUREST, form: SUREST, alternatives: Vec::new(), rivals: Vec::new() };
    for rival in search.absorbed.iter().copied().filter(|rival| !found.contains(rival)) {
        if groups[rival].same_place_and_effect(&groups[group]) {
            continue;
        }
        let worse = stated_arm::rival_cost(search, stated, found, group, rival);
        judgement.presence = judgement.presence.min(odds(worse));
        if worse < CLOSE {
            judgement.alternatives.push((groups[rival].effect, groups[rival].joint));
        }
    }
    judgement
}

/// Probability that the better of two explanations is right, from the difference of their evidence.
fn odds(difference: f64) -> f64 {
    1.0 / (1.0 + (-0.5 * difference).exp())
}

#[cfg(test)]
impl Named {
    /// An effect that most of the other joints have, too.
    pub(super) fn example(id: &str, joints: &[usize], presence: f64) -> Named {
        let effect = crate::effect::registry::find(id).unwrap();
        let (joints, usual) = (joints.to_vec(), joints.to_vec());
        let (alternatives, rivals) = (Vec::new(), Vec::new());
        let forms = effect.places(joints.iter().copied()).into_iter().map(|place| (place, 0.6)).collect();
        Named { effect, joints, usual, gain: 1.0, presence, forms, alternatives, rivals, pins: false }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::presence::calibration::Calibration;
    use crate::diagnosis::search::testing::{found, group, searched};
    use crate::effect::registry;
    use crate::progress::Monitor;
    use crate::simulation::{Scenario, simulate};

    /// Friction that the search has not found is named beside what it has if it may well be there, and may be asked about.
    #[test]
    fn what_is_in_question_beside_what_was_found_is_named_with_its_presence() {
        let recording = simulate(&Scenario::embedded(), &Monitor::new()).unwrap();
        let mut search = searched(&recording, &["coulomb-friction", "dahl-hysteresis", "joint-spring"]);
        let (effect, joint) = found(&search)[0];
        assert_eq!(effect, "coulomb-friction");
        let group = search.active.remove(0);
        let family = search.library.groups[group].effect.family;
        let judged = |presence: f64| {
            let judged = Judged::of(&search, Calibration::learned()).unwrap();
            let rest = judged.in_question().collect::<Vec<_>>();
            rest.into_iter()
                .fold(judged, |judged, (family, joint)| judged.believing(family, joint, 0.99))
                .believing(family, joint, presence)
        };
        assert_eq!(
            [0.39, 0.4, 0.99].map(|presence| in_question_beside(&search, &judged(presence))),
            [vec![], vec![group], vec![]]
        );
        let judged = judged(0.6);
        let named = name_effects(&mut search, &[group], &Comparison::NotPossible, None, &judged);
        let friction = named.iter().find(|one| one.effect.id == "coulomb-friction" && one.places().contains(&joint));
        assert_eq!(friction.unwrap().presence, 0.6);
        assert!(friction.unwrap().usual.iter().all(|&usual| Some(usual) != joint), "it was not found");
        search.active.push(group);
        assert!(in_question_beside(&search, &judged).is_empty(), "it is found");
    }

    /// Joints 1 and 2 have Coulomb friction, joint 3 has another form of it.
    #[test]
    fn what_the_other_joints_have_is_asked_about_in_their_form() {
        let mut scenario = Scenario::embedded();
        scenario.effects.extend(scenario.hide_by_strength("dahl-hysteresis", &[2], 0.05).unwrap());
        let recording = simulate(&scenario, &Monitor::new()).unwrap();
        let mut search = searched(&recording, &["coulomb-friction", "dahl-hysteresis"]);
        search.active.retain(|&group| search.library.groups[group].joint != Some(2));
        let common = group(&search, "coulomb-friction", 2);
        let groups = &search.library.groups;
        let all = (0..groups.len()).filter(|&group| groups[group].joint == Some(2));
        let best = search.best_beside(&search.active, all).unwrap();
        assert_eq!(groups[best].effect.id, "dahl-hysteresis", "it explains more");
        let judged = Judged::of(&search, Calibration::learned()).unwrap();
        let judged = judged.believing(groups[common].effect.family, Some(2), 0.6);
        assert_eq!(in_question_beside(&search, &judged), [common]);
        search.active.clear();
        let best = search.best_beside(&[], [best, common].into_iter());
        assert!(in_question_beside(&search, &judged).contains(&best.unwrap()), "nothing is usual then");
    }

    /// Of joints that left the name nothing is told; an effect of the whole arm has no joints.
    #[test]
    fn what_explains_nearly_as_much_is_told_once_with_its_joints() {
        let find = |id| registry::find(id).unwrap();
        let (lag, tilt, wave) = (find("actuator-lag"), find("base-tilt"), find("cogging"));
        let of = |effect, joints: &[usize]| Alternative { effect, elsewhere: None, joints: joints.to_vec() };
        let on = |joint, effect| (Some(joint), effect, None);
        let alternatives = vec![on(2, lag), on(1, tilt), on(2, wave), on(2, tilt), on(0, wave)];
        let named = Named { alternatives, ..Named::example("coulomb-friction", &[1, 2], 0.9) };
        assert_eq!(named.alternatives_told(), [of(tilt, &[]), of(lag, &[2]), of(wave, &[2])]);
        let mut named = Named { joints: vec![1], ..named };
        assert_eq!(named.alternatives_told(), [of(tilt, &[])]);
        named.forms.insert(Some(2), 0.3);
        assert_eq!(named.form(), 0.6, "joint 3 has left the name");
        named.joints.push(2);
        assert_eq!(named.form(), 0.3);
        let alternatives = vec![(None, wave, None), (None, lag, None)];
        let arm = Named { alternatives, ..Named::example("base-tilt", &[0, 1, 2], 0.9) };
        assert_eq!(arm.alternatives_told(), [of(lag, &[]), of(wave, &[])]);
    }

    /// Evidence is twice a logarithm of likelihoods.
    #[test]
    fn evidence_becomes_a_probability() {
        assert_eq!(odds(0.0), 0.5);
        assert!((odds(2.0 * 3f64.ln()) - 0.75).abs() < 1e-12 && (odds(-2.0 * 3f64.ln()) - 0.25).abs() < 1e-12);
    }
}
