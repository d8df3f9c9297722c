//! Names for what was found, each with the probability that it is right and the effects that explain nearly as much.

use std::collections::BTreeMap;

use super::presence::Judged;
use super::report::Alternative;
use super::search::{CLOSE, Rival, Search, odds_of_form};
use super::stated_arm::{self, Comparison, StatedBody};
use crate::effect::Effect;

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
    /// Probability that it is there in this form, if it is there.
    pub form: f64,
    /// Effects that explain nearly as much.
    pub alternatives: Vec<Alternative>,
    /// The group with the largest gain, and its best rival.
    pub rival: Option<(usize, usize)>,
    /// Whether it needs the rigid body held at the stated arm.
    pub pins: bool,
}

impl Named {
    /// Its places: each joint, or the whole arm.
    pub fn places(&self) -> Vec<Option<usize>> {
        self.effect.places(self.joints.iter().copied())
    }
}

/// What is said of one group.
struct Judgement {
    gain: f64,
    presence: f64,
    form: f64,
    alternatives: Vec<Alternative>,
    /// The rival that comes closest.
    rival: Option<usize>,
}

/// The groups that were found, the same effect on several joints once, the largest gain first; those that need the stated
/// arm last.
pub fn name_effects(
    search: &Search,
    comparison: &Comparison,
    stated: Option<&StatedBody>,
    judged: &Judged,
) -> Vec<Named> {
    let mut by_effect: BTreeMap<&'static str, Named> = BTreeMap::new();
    let mut add = |group: usize, judgement: Judgement, pins: bool| {
        let place = &search.library.groups[group];
        let named = by_effect.entry(place.effect.id).or_insert(Named {
            effect: place.effect,
            joints: Vec::new(),
            usual: Vec::new(),
            gain: 0.0,
            presence: 1.0,
            form: 1.0,
            alternatives: Vec::new(),
            rival: None,
            pins: false,
        });
        named.pins |= pins;
        match place.joint {
            Some(joint) => named.joints.push(joint),
            None => named.joints.extend(0..search.library.design.joint_count()),
        }
        named.usual.extend(place.joint.filter(|_| search.is_usual(group)));
        named.gain += judgement.gain;
        named.presence = named.presence.min(judgement.presence);
        named.form = named.form.min(judgement.form);
        if !judgement.alternatives.is_empty() {
            named.rival = named.rival.or(judgement.rival.map(|rival| (group, rival)));
        }
        named.alternatives.extend(judgement.alternatives);
    };
    for &group in &search.active {
        add(group, judge(search, judged, group), false);
    }
    if let (Comparison::Explained(found), Some(stated)) = (comparison, stated) {
        for &group in found {
            add(group, judge_absorbed(search, stated, found, group), true);
        }
    }
    let mut named: Vec<Named> = by_effect.into_values().collect();
    for effect in &mut named {
        effect.joints.sort_unstable();
        effect.alternatives.sort_by_key(|other| (other.effect.id, other.elsewhere));
        effect.alternatives.dedup();
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
    let mut closest: Option<(f64, usize)> = None;
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
            alternatives.push(Alternative {
                effect: groups[rival].effect,
                elsewhere: groups[rival].joint.filter(|_| elsewhere),
            });
            if closest.is_none_or(|(least, _)| priced < least) {
                closest = Some((priced, rival));
            }
        }
    }
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
        rival: closest.map(|(_, rival)| rival),
    }
}

/// The same for an effect that the base parameters absorb and the stated arm brings to light.
fn judge_absorbed(search: &Search, stated: &StatedBody, found: &[usize], group: usize) -> Judgement {
    let groups = &search.library.groups;
    let mut judgement = Judgement { gain: 0.0, presence: SUREST, form: SUREST, alternatives: Vec::new(), rival: None };
    for rival in search.absorbed.iter().copied().filter(|rival| !found.contains(rival)) {
        if groups[rival].same_place_and_effect(&groups[group]) {
            continue;
        }
        let worse = stated_arm::rival_cost(search, stated, found, group, rival);
        judgement.presence = judgement.presence.min(odds(worse));
        if worse < CLOSE {
            judgement.alternatives.push(Alternative { effect: groups[rival].effect, elsewhere: groups[rival].joint });
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
        let (alternatives, rival) = (Vec::new(), None);
        Named { effect, joints, usual, gain: 1.0, presence, form: 0.6, alternatives, rival, pins: false }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Evidence is twice a logarithm of likelihoods.
    #[test]
    fn evidence_becomes_a_probability() {
        assert_eq!(odds(0.0), 0.5);
        assert!((odds(2.0 * 3f64.ln()) - 0.75).abs() < 1e-12 && (odds(-2.0 * 3f64.ln()) - 0.25).abs() < 1e-12);
    }
}
