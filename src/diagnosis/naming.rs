//! Names for what was found, each with the probability that it is right and the effects that explain nearly as much.

use std::collections::BTreeMap;

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::report::Alternative;
use super::search::{BlockGains, CLOSE, Rival, Search};
use super::stated_arm::{self, Comparison};
use crate::arm::Arm;
use crate::effect::{Effect, Scope};
use crate::recording::Recording;

/// A rival counts as an alternative too if it explains all but this share of what the effect explains.
const NEARLY_AS_MUCH: f64 = 0.05;
/// No finding is given a higher confidence: data alone never make certain.
const HIGHEST_CONFIDENCE: f64 = 0.99;
/// The same for effects in odd company.
const HIGHEST_IN_ODD_COMPANY: f64 = 0.45;
/// The same for an effect with another form that explains nearly as much.
const HIGHEST_BESIDE_OTHER_FORM: f64 = 0.6;

/// One effect with all joints where it was found.
pub struct Named {
    /// Which.
    pub effect: &'static Effect,
    /// Counted from 0.
    pub joints: Vec<usize>,
    /// Drop of the weighted squared error.
    pub gain: f64,
    /// Probability that it is this effect.
    pub confidence: f64,
    /// Effects that explain nearly as much.
    pub alternatives: Vec<Alternative>,
    /// The group with the largest gain, and its best rival.
    pub rival: Option<(usize, usize)>,
    /// Whether it needs the rigid body held at the stated arm.
    pub pins: bool,
}

/// What is said of one group.
struct Judgement {
    gain: f64,
    confidence: f64,
    alternatives: Vec<Alternative>,
    /// The rival that comes closest.
    rival: Option<usize>,
}

/// The groups that were found, the same effect on several joints once, the largest gain first; those that need the stated
/// arm last.
pub fn name_effects(search: &Search, comparison: &Comparison, recording: &Recording) -> Vec<Named> {
    let mut by_effect: BTreeMap<&'static str, Named> = BTreeMap::new();
    let mut add = |group: usize, judgement: Judgement, pins: bool| {
        let place = &search.library.groups[group];
        let named = by_effect.entry(place.effect.id).or_insert(Named {
            effect: place.effect,
            joints: Vec::new(),
            gain: 0.0,
            confidence: 1.0,
            alternatives: Vec::new(),
            rival: None,
            pins: false,
        });
        named.pins |= pins;
        match place.joint {
            Some(joint) => named.joints.push(joint),
            None => named.joints.extend(0..recording.joint_count()),
        }
        named.gain += judgement.gain;
        named.confidence = named.confidence.min(judgement.confidence);
        if !judgement.alternatives.is_empty() {
            named.rival = named.rival.or(judgement.rival.map(|rival| (group, rival)));
        }
        named.alternatives.extend(judgement.alternatives);
    };
    for &group in &search.active {
        let mut judgement = judge(search, group);
        if is_in_odd_company(search, group) {
            judgement.confidence = judgement.confidence.min(HIGHEST_IN_ODD_COMPANY);
        }
        add(group, judgement, false);
    }
    if let (Comparison::Explained(found), Some(arm)) = (comparison, &recording.stated_arm) {
        for &group in found {
            add(group, judge_absorbed(search, arm, found, group), true);
        }
    }
    let mut named: Vec<Named> = by_effect.into_values().collect();
    for effect in &mut named {
        effect.confidence = effect.confidence.min(HIGHEST_CONFIDENCE);
        effect.joints.sort_unstable();
        effect.alternatives.sort_by_key(|other| (other.effect.id, other.elsewhere));
        effect.alternatives.dedup();
    }
    named.sort_by(|a, b| a.pins.cmp(&b.pins).then(b.gain.total_cmp(&a.gain)));
    named
}

/// Gain of one effect of the set, the probability that it and not a rival is there, and the rivals that come close.
fn judge(search: &Search, group: usize) -> Judgement {
    let groups = &search.library.groups;
    let without: Vec<usize> = search.active.iter().copied().filter(|&other| other != group).collect();
    let gain = search.cost(&without) - search.cost(&search.active);
    let price = search.price_of(group);
    let mut confidence = f64::min(odds(gain - price), certainty(search, &without));
    let mut alternatives = Vec::new();
    let mut closest: Option<(f64, usize)> = None;
    let found = search.cost(&search.active);
    for Rival { group: rival, cost, .. } in search.rivals(group) {
        let worse = cost - found;
        let priced = worse + search.price_of(rival) - price;
        // A rival that contains the effect explains as much by itself; it is one only if its surplus is worth its price.
        let contains = groups[rival].includes(&groups[group]);
        if !contains {
            // A rival that scores better was refused for want of confirmation: then it is one or the other.
            confidence = confidence.min(odds(priced.max(0.0)));
        }
        let is_simpler = groups[rival].parameter_count() <= groups[group].parameter_count();
        if priced < CLOSE || (!contains && is_simpler && worse < NEARLY_AS_MUCH * gain) {
            let elsewhere = groups[rival].effect == groups[group].effect;
            alternatives.push(Alternative {
                effect: groups[rival].effect,
                elsewhere: groups[rival].joint.filter(|_| elsewhere),
            });
            if groups[rival].is_another_form_of(&groups[group]) {
                confidence = confidence.min(HIGHEST_BESIDE_OTHER_FORM);
            }
            if closest.is_none_or(|(least, _)| priced < least) {
                closest = Some((priced, rival));
            }
        }
    }
    Judgement { gain, confidence, alternatives, rival: closest.map(|(_, rival)| rival) }
}

/// The same for an effect that the base parameters absorb and the stated arm brings to light.
fn judge_absorbed(search: &Search, arm: &Arm, found: &[usize], group: usize) -> Judgement {
    let groups = &search.library.groups;
    let mut judgement = Judgement { gain: 0.0, confidence: 1.0, alternatives: Vec::new(), rival: None };
    for rival in (0..groups.len()).filter(|rival| !found.contains(rival)) {
        if !search.is_absorbed(rival, &[]) || groups[rival].same_place_and_effect(&groups[group]) {
            continue;
        }
        let worse = stated_arm::rival_cost(search, arm, found, group, rival);
        judgement.confidence = judgement.confidence.min(odds(worse));
        if worse < CLOSE {
            judgement.alternatives.push(Alternative { effect: groups[rival].effect, elsewhere: groups[rival].joint });
        }
    }
    judgement
}

/// Whether two effects of a joint show over the same state, neither of them an everyday one, and this is one of them or the
/// joint's offset. Two such together can copy nearly any function of that state, and its mean is an offset; so they may stand
/// in for one effect that is not in the catalogue.
fn is_in_odd_company(search: &Search, group: usize) -> bool {
    let groups = &search.library.groups;
    let is_odd = |group: usize| groups[group].effect.scope == Scope::Joint && !groups[group].effect.facts.everyday;
    let is_pair = |first: usize, second: usize| {
        first != second
            && is_odd(first)
            && is_odd(second)
            && groups[first].joint == groups[second].joint
            && groups[first].effect.axis == groups[second].effect.axis
    };
    let belongs = |first: &usize| {
        *first == group || (groups[group].effect.facts.is_offset && groups[group].joint == groups[*first].joint)
    };
    let mut belonging = search.active.iter().copied().filter(belongs);
    belonging.any(|first| search.active.iter().any(|&second| is_pair(first, second)))
}

/// Probability that the better of two explanations is right, from the difference of their evidence.
fn odds(difference: f64) -> f64 {
    1.0 / (1.0 + (-0.5 * difference).exp())
}

/// Probability, by the paired gains of left-out blocks, that the whole set is better than `without`.
fn certainty(search: &Search, without: &[usize]) -> f64 {
    let gains = BlockGains::of(search, without, &search.active);
    let freedom = gains.count().saturating_sub(1) as f64;
    if freedom < 2.0 {
        return 0.5;
    }
    StudentsT::new(0.0, 1.0, freedom).map_or(0.5, |t| t.cdf(gains.paired_t()))
}
