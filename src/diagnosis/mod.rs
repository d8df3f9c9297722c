//! Which physical effect is missing: from a model and measurements, name it with evidence, and never cry wolf.
//!
//! [`candidates`] lays every effect beside the model, [`selection`] searches the set that explains the torque for the least
//! price, [`gates`] say what evidence a name needs, [`stated_arm`] finds what the base parameters absorb, [`remainder`] asks
//! whether more is left than noise. The answer is a [`Report`]; [`evidence`] holds its plots.
//!
//! A diagnosis sees measurements only. It never opens a seal; a test keeps it so.

mod candidates;
pub mod evidence;
mod gates;
mod remainder;
mod report;
mod selection;
mod stated_arm;

use std::collections::BTreeMap;

use candidates::{Group, Library};
use selection::Search;
use stated_arm::Comparison;
use statrs::distribution::{ContinuousCDF, StudentsT};

pub use report::{Candidate, Evidence, MissingEffect, Report, Verdict};

use crate::effect::{Effect, Scope, registry};
use crate::model::design::Design;
use crate::model::{Evaluation, Fitted, Model, ModelError, Preset, Term, fit};
use crate::progress::Monitor;
use crate::recording::split::Split;
use crate::recording::{Recording, joints_text};

/// A rival counts as an alternative if its evidence is this close (in the units of ln likelihood, doubled).
const CLOSE: f64 = 6.0;
/// A rival counts as an alternative too if it explains all but this share of what the effect explains.
const NEARLY_AS_MUCH: f64 = 0.05;
/// Below this confidence the verdict is "ambiguous".
const SURE: f64 = 0.8;
/// No finding is given a higher confidence: data alone never make certain.
const HIGHEST_CONFIDENCE: f64 = 0.99;
/// The same on joints whose residual is still more than noise: what is left may be what was named in truth. Not calibrated yet.
const HIGHEST_BESIDE_UNKNOWN: f64 = 0.8;

/// One effect with all joints where it was found.
struct Named {
    effect: &'static str,
    joints: Vec<usize>,
    gain: f64,
    confidence: f64,
    alternatives: Vec<String>,
    pins: bool,
}

/// Looks for what `fitted` lacks on the training part, and measures on the held-out part what adding it gains.
///
/// # Errors
/// [`ModelError`] if the model does not fit the recording, or the work was stopped.
pub fn diagnose(
    fitted: &Fitted,
    recording: &Recording,
    split: &Split,
    monitor: &Monitor,
) -> Result<Report, ModelError> {
    diagnose_among(&registry::sought(), fitted, recording, split, monitor)
}

/// [`diagnose`] with other candidates than the whole catalogue, to measure what happens if the right one is not among them.
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_among(
    effects: &[&'static dyn Effect],
    fitted: &Fitted,
    recording: &Recording,
    split: &Split,
    monitor: &Monitor,
) -> Result<Report, ModelError> {
    if let Some(term) = fitted.model.terms.iter().find(|term| matches!(term, Term::Learned(_))) {
        return Err(ModelError::Undiagnosable(term.label()));
    }
    let before = Evaluation::of(fitted, recording, split)?;
    monitor.report(0.1, "computing candidate effects")?;
    let design = Design::new(recording, split)?;
    let (library, mut impossible) = Library::new(fitted, &design, effects, monitor)?;
    let mut search = Search::new(library);
    let absorbed: Vec<usize> =
        (0..search.library.groups.len()).filter(|&group| search.is_absorbed(group, &[])).collect();
    let drops = error_drops(&search, monitor)?;
    let refused = search.run(monitor)?;
    let comparison = stated_arm::compare(&search, &fitted.model, recording.stated_arm.as_ref(), &absorbed);
    let named = name_effects(&search, &comparison, recording);
    monitor.report(0.8, "adding what was found, step by step")?;
    let (mut effects, last, last_fitted) = measure_steps(&named, fitted, &before, recording, split, &design, monitor)?;
    let unexplained = remainder::joints_with_structure(recording, split, &last);
    for effect in &mut effects {
        let beside_unknown = effect.joints.iter().any(|joint| unexplained.contains(joint));
        let highest = if beside_unknown { HIGHEST_BESIDE_UNKNOWN } else { HIGHEST_CONFIDENCE };
        effect.confidence = effect.confidence.min(highest);
    }
    let verdict = if effects.iter().any(|effect| effect.confidence < SURE && !effect.alternatives.is_empty()) {
        Verdict::Ambiguous
    } else if !effects.is_empty() {
        Verdict::Missing
    } else if !unexplained.is_empty() {
        Verdict::UnknownEffect
    } else {
        Verdict::NothingMissing
    };
    if comparison == Comparison::NotPossible && !last_fitted.model.is_pinned() {
        let names = absorbed.iter().map(|&group| label(&search.library.groups[group]));
        impossible.extend(names.map(|name| format!("{name} can't be told from the base parameters: state the arm")));
    }
    let advice = advice(verdict, &effects, &unexplained, &comparison, &impossible);
    let ranking = rank(&search, &drops, &refused, &comparison, &absorbed);
    monitor.report(1.0, "diagnosed")?;
    Ok(Report {
        verdict,
        effects,
        held_out_nmse: before.held_out_nmse(),
        noise_floor_nmse: last.noise_floor_nmse,
        unexplained_joints: unexplained,
        advice,
        ranking,
    })
}

/// The groups that were found, the same effect on several joints once, the largest gain first; those that need the stated
/// arm last.
fn name_effects(search: &Search, comparison: &Comparison, recording: &Recording) -> Vec<Named> {
    let joints = recording.joint_count();
    let mut by_effect: BTreeMap<&'static str, Named> = BTreeMap::new();
    let mut add = |group: usize, gain: f64, confidence: f64, alternatives: Vec<String>, pins: bool| {
        let group = &search.library.groups[group];
        let named = by_effect.entry(group.spec.id).or_insert(Named {
            effect: group.spec.id,
            joints: Vec::new(),
            gain: 0.0,
            confidence: 1.0,
            alternatives: Vec::new(),
            pins: false,
        });
        named.pins |= pins;
        match group.joint {
            Some(joint) => named.joints.push(joint),
            None => named.joints.extend(0..joints),
        }
        named.gain += gain;
        named.confidence = named.confidence.min(confidence);
        named.alternatives.extend(alternatives);
    };
    for &group in &search.active {
        let (gain, confidence, alternatives) = judge(search, group);
        add(group, gain, confidence, alternatives, false);
    }
    if let (Comparison::Explained(found), Some(arm)) = (comparison, &recording.stated_arm) {
        for &group in found {
            let mut confidence = 1.0;
            let mut alternatives = Vec::new();
            for rival in (0..search.library.groups.len()).filter(|rival| !found.contains(rival)) {
                let groups = &search.library.groups;
                if !search.is_absorbed(rival, &[]) || groups[rival].same_place_and_effect(&groups[group]) {
                    continue;
                }
                let worse = stated_arm::rival_cost(search, arm, found, group, rival);
                confidence = f64::min(confidence, odds(worse));
                if worse < CLOSE {
                    alternatives.push(label(&groups[rival]));
                }
            }
            add(group, 0.0, confidence, alternatives, true);
        }
    }
    let mut named: Vec<Named> = by_effect.into_values().collect();
    for effect in &mut named {
        effect.joints.sort_unstable();
        effect.alternatives.sort();
        effect.alternatives.dedup();
    }
    named.sort_by(|a, b| a.pins.cmp(&b.pins).then(b.gain.total_cmp(&a.gain)));
    named
}

/// Gain of one effect of the set, the probability that it and not a rival is there, and the rivals that come close.
fn judge(search: &Search, group: usize) -> (f64, f64, Vec<String>) {
    let groups = &search.library.groups;
    let without: Vec<usize> = search.active.iter().copied().filter(|&other| other != group).collect();
    let gain = search.cost(&without) - search.cost(&search.active);
    let price = groups[group].parameter_count() as f64 * search.price;
    let mut confidence = f64::min(odds(gain - price), certainty(search, &without));
    let mut alternatives = Vec::new();
    for (set, rival) in search.rivals(group) {
        let worse = search.cost(&set) - search.cost(&search.active);
        let priced = search.priced_cost(&set) - search.priced_cost(&search.active);
        // A rival that contains the effect explains as much by itself; it is one only if its surplus is worth its price.
        let contains = groups[rival].includes(&groups[group]);
        if !contains {
            confidence = confidence.min(odds(priced));
        }
        let is_simpler = groups[rival].parameter_count() <= groups[group].parameter_count();
        if priced < CLOSE || (!contains && is_simpler && worse < NEARLY_AS_MUCH * gain) {
            alternatives.push(groups[rival].spec.id.to_owned());
        }
    }
    (gain, confidence, alternatives)
}

/// Probability that the better of two explanations is right, from the difference of their evidence.
fn odds(difference: f64) -> f64 {
    1.0 / (1.0 + (-0.5 * difference).exp())
}

/// Probability, by the paired gains of left-out blocks, that the whole set is better than `without`.
fn certainty(search: &Search, without: &[usize]) -> f64 {
    let gains = gates::block_gains(search, without, &search.active);
    let freedom = (gains.len() - 1) as f64;
    if freedom < 2.0 {
        return 0.5;
    }
    StudentsT::new(0.0, 1.0, freedom).map_or(0.5, |t| t.cdf(gates::paired_t(&gains)))
}

/// Adds the named effects one after the other and measures the held-out error of each step.
fn measure_steps(
    named: &[Named],
    fitted: &Fitted,
    start: &Evaluation,
    recording: &Recording,
    split: &Split,
    design: &Design,
    monitor: &Monitor,
) -> Result<(Vec<MissingEffect>, Evaluation, Fitted), ModelError> {
    let mut model: Model = fitted.model.clone();
    let (mut last_fitted, mut last) = (fitted.clone(), start.clone());
    let mut errors = Vec::new();
    for (number, effect) in named.iter().enumerate() {
        monitor.report(0.8 + 0.2 * number as f32 / named.len() as f32, "adding what was found, step by step")?;
        if effect.pins && !model.is_pinned() {
            let Some(arm) = &recording.stated_arm else { continue };
            model = model.pinned_to(arm);
            last = Evaluation::of(&fit::fit_design(&model, design, monitor)?, recording, split)?;
        }
        let before = last.held_out_nmse();
        model = model.with_effect(effect.effect, &effect.joints)?;
        last_fitted = fit::fit_design(&model, design, monitor)?;
        last = Evaluation::of(&last_fitted, recording, split)?;
        errors.push((before, last.held_out_nmse()));
    }
    let mut effects = Vec::new();
    for (effect, (nmse_before, nmse_after)) in named.iter().zip(errors) {
        let of_effect =
            |term: usize| matches!(&last_fitted.model.terms[term], Term::Effect(term) if term.effect == effect.effect);
        let parameters = last_fitted.parameters.iter().filter(|parameter| of_effect(parameter.term)).cloned().collect();
        let evidence = evidence::of_effect(&last_fitted, &last, recording, split, effect.effect, &effect.joints);
        effects.push(MissingEffect {
            effect: effect.effect.to_owned(),
            joints: effect.joints.clone(),
            confidence: effect.confidence,
            parameters,
            nmse_before,
            nmse_after,
            alternatives: effect.alternatives.clone(),
            evidence,
        });
    }
    Ok((effects, last, last_fitted))
}

/// Cross-validated drop of the squared residual by each candidate alone, by group. Of the shapes of an effect at a place
/// only the one that fits best is measured; the others get what it gets.
fn error_drops(search: &Search, monitor: &Monitor) -> Result<Vec<f64>, ModelError> {
    let groups = &search.library.groups;
    let blocks = search.library.equations.block_count();
    let error = |set: &[usize], joint: Option<usize>| -> f64 {
        let columns = search.columns(set);
        let of_block = |block: usize| {
            let (factors, weighted) = search.error_when(set, block);
            let on_joint = |joint| search.library.equations.select(block, joint, &columns).residual_energy(&factors);
            joint.map_or(weighted, on_joint)
        };
        (0..blocks).map(of_block).sum()
    };
    let mut alone: BTreeMap<Option<usize>, f64> = BTreeMap::new();
    let mut drops: Vec<f64> = Vec::with_capacity(groups.len());
    for (group, candidate) in groups.iter().enumerate() {
        monitor.check()?;
        if let Some(first) = groups[..group].iter().position(|other| other.same_place_and_effect(candidate)) {
            drops.push(drops[first]);
            continue;
        }
        let same = (group..groups.len()).filter(|&other| groups[other].same_place_and_effect(candidate));
        let costs = same.map(|other| (other, search.cost(&[other])));
        let best = costs.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(group, |(best, _)| best);
        let alone = *alone.entry(candidate.joint).or_insert_with(|| error(&[], candidate.joint));
        drops.push(if alone > 0.0 { 1.0 - error(&[best], candidate.joint) / alone } else { 0.0 });
    }
    Ok(drops)
}

/// All candidates, one line for each effect and joint: first those that are part of the answer, then by their error drop.
fn rank(
    search: &Search,
    drops: &[f64],
    refused: &[(usize, String)],
    comparison: &Comparison,
    absorbed: &[usize],
) -> Vec<Candidate> {
    let groups = &search.library.groups;
    let explained: &[usize] = if let Comparison::Explained(found) = comparison { found } else { &[] };
    let mut ranking: Vec<Candidate> = Vec::new();
    for (index, group) in groups.iter().enumerate() {
        let is_first = groups[..index].iter().all(|other| !other.same_place_and_effect(group));
        if !is_first {
            continue;
        }
        let same = |other: &usize| groups[*other].same_place_and_effect(group);
        let accepted = search.active.iter().any(same) || explained.iter().any(same);
        let reason = if search.active.iter().any(same) {
            "left-out blocks confirm it".to_owned()
        } else if explained.iter().any(same) {
            "it explains how the identified arm differs from the stated one".to_owned()
        } else if absorbed.iter().any(same) {
            "the base parameters take its place".to_owned()
        } else if let Some((_, reason)) = refused.iter().find(|(other, _)| same(other)) {
            reason.clone()
        } else if search.active.iter().any(|&other| groups[other].includes(group)) {
            "it is part of an effect that was found".to_owned()
        } else {
            "beside what was found it explains hardly more than chance would".to_owned()
        };
        let error_drop = (index..groups.len()).filter(same).map(|other| drops[other]).fold(f64::NEG_INFINITY, f64::max);
        ranking.push(Candidate { effect: group.spec.id.to_owned(), joint: group.joint, error_drop, accepted, reason });
    }
    ranking.sort_by(|a, b| b.accepted.cmp(&a.accepted).then(b.error_drop.total_cmp(&a.error_drop)));
    ranking
}

fn label(group: &Group) -> String {
    match (group.spec.scope, group.joint) {
        (Scope::Joint, Some(joint)) => format!("{} on joint {}", group.spec.name, joint + 1),
        (Scope::Pair, Some(joint)) => format!("{} of joints {} and {}", group.spec.name, joint, joint + 1),
        _ => group.spec.name.to_owned(),
    }
}

/// What to do next, in plain words.
fn advice(
    verdict: Verdict,
    effects: &[MissingEffect],
    unexplained: &[usize],
    comparison: &Comparison,
    impossible: &[String],
) -> String {
    let mut sentences = Vec::new();
    match (verdict, effects.first()) {
        (Verdict::Missing | Verdict::Ambiguous, Some(first)) => {
            let name = registry::find(&first.effect).map_or(first.effect.as_str(), |effect| effect.spec().name);
            sentences.push(format!("Add {name} on {} first.", joints_text(&first.joints)));
            if verdict == Verdict::Ambiguous {
                sentences
                    .push("These data can't tell it from its alternatives: record slower and faster motion.".into());
            }
            if !unexplained.is_empty() {
                let joints = joints_text(unexplained);
                sentences.push(format!(
                    "The residual of {joints} is still more than noise: no effect of the catalogue explains the rest."
                ));
            }
        }
        (Verdict::UnknownEffect, _) => sentences.push(format!(
            "The residual of {} is not noise, but no effect of the catalogue explains it: look at it in the residual \
             views.",
            joints_text(unexplained)
        )),
        _ => sentences.push("Nothing is missing that these data could show.".to_owned()),
    }
    if *comparison == Comparison::Differs {
        sentences.push(format!(
            "The identified base parameters differ from the stated arm, and no single effect explains how: check the stated \
             masses and lengths, or keep the preset `{}`.",
            Preset::RigidBody.id()
        ));
    }
    let mut impossible: Vec<&String> = impossible.iter().collect();
    impossible.dedup();
    sentences.extend(impossible.into_iter().map(|reason| format!("Not known: {reason}.")));
    sentences.join(" ")
}
