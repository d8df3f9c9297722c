//! Which physical effect is missing: from a model and measurements, name it with evidence, and never cry wolf.
//!
//! [`candidates`] lays every effect beside the model, [`selection`] searches the set that explains the torque for the least
//! price, [`gates`] say what evidence a name needs, [`stated_arm`] finds what the base parameters absorb, [`naming`] says how
//! sure it is and what else it could be, [`telling`] which motion would tell, [`remainder`] whether more is left than noise.
//! The answer is a [`Report`]; [`evidence`] holds its plots. [`sufficiency`] asks, once the truth is known, whether the data
//! could show it.
//!
//! A diagnosis sees measurements only. It never opens a seal; a test keeps it so.

mod advice;
mod candidates;
pub mod evidence;
mod flexible;
mod gates;
mod naming;
mod ranking;
mod remainder;
mod report;
mod selection;
mod stated_arm;
mod sufficiency;
mod telling;

use advice::advice;
use candidates::Library;
use naming::{Named, name_effects};
use ranking::{error_drops, rank};
use selection::Search;
use stated_arm::Comparison;

pub use report::{Candidate, Evidence, MissingEffect, Report, TellingMotion, Verdict};
pub use sufficiency::{Suspect, sufficiency};

use crate::effect::{Effect, ParameterSpec, registry};
use crate::model::design::Design;
use crate::model::learned::LearnedTerm;
use crate::model::{EffectTerm, Evaluation, Fitted, Model, ModelError, Parameter, RigidBody, Term, fit};
use crate::progress::Monitor;
use crate::recording::Recording;
use crate::recording::fault::{self, Fault};
use crate::recording::split::Split;

/// Below this confidence the verdict is "ambiguous".
const SURE: f64 = 0.8;
/// The confidence of a fault that the readings themselves show.
const HIGHEST_OF_READINGS: f64 = 0.95;
/// The highest on joints whose residual is still more than noise: what was named may stand in for what is really there.
const HIGHEST_BESIDE_UNKNOWN: f64 = 0.45;

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

/// [`diagnose`] with other candidates than the whole catalogue: with effects of one's own, or without the right one, to measure
/// what happens then.
///
/// ```
/// use torquescope::diagnosis::diagnose_among;
/// use torquescope::{effect::registry, model, prelude::*};
///
/// let monitor = Monitor::new();
/// let recording = simulate(&Scenario::embedded(), &monitor)?; // Coulomb friction is hidden in it
/// let split = Split::automatic(&recording);
/// let body = model::fit(&Preset::RigidBody.model(&recording)?, &recording, &split, &monitor)?;
/// let springs = [registry::find("joint-spring")?, registry::find("hardening-spring")?];
/// let report = diagnose_among(&springs, &body, &recording, &split, &monitor)?;
/// assert_ne!(report.verdict, Verdict::NothingMissing);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_among(
    effects: &[&'static Effect],
    fitted: &Fitted,
    recording: &Recording,
    split: &Split,
    monitor: &Monitor,
) -> Result<Report, ModelError> {
    let held_out_nmse = Evaluation::of(fitted, recording, split)?.held_out_nmse();
    monitor.report(0.05, "filtering the torque")?;
    let design = Design::new(recording, split)?;
    let counterpart;
    let fitted = if fitted.model.is_learned() {
        counterpart = fit::fit_design(&linear_counterpart(&fitted.model, recording.joint_count()), &design, monitor)?;
        &counterpart
    } else {
        fitted
    };
    let before = Evaluation::of(fitted, recording, split)?;
    monitor.report(0.1, "computing candidate effects")?;
    let (library, mut impossible) = Library::new(fitted, design.clone(), effects, monitor)?;
    let mut search = Search::new(library);
    let absorbed: Vec<usize> =
        (0..search.library.groups.len()).filter(|&group| search.is_absorbed(group, &[])).collect();
    let drops = error_drops(&search, monitor)?;
    let refused = search.run(monitor)?;
    let comparison = stated_arm::compare(&search, &fitted.model, recording.stated_arm.as_ref(), &absorbed);
    let named = name_effects(&search, &comparison, recording);
    monitor.report(0.8, "adding what was found, step by step")?;
    let (mut effects, last, last_fitted) = measure_steps(&named, fitted, &before, recording, split, &design, monitor)?;
    for (effect, named) in effects.iter_mut().zip(&named) {
        monitor.check()?;
        let motion = |(group, rival)| telling::best_motion(&search, &last_fitted, group, rival);
        effect.telling_motion = named.rival.and_then(motion);
    }
    let unexplained = remainder::joints_with_structure(&search, recording, split, &last)?;
    for effect in &mut effects {
        if effect.joints.iter().any(|joint| unexplained.contains(joint)) {
            effect.confidence = effect.confidence.min(HIGHEST_BESIDE_UNKNOWN);
        }
    }
    effects.extend(fault::find(recording).iter().filter_map(|fault| in_readings(fault, recording, &last)));
    let verdict = verdict(&effects, &unexplained, &comparison);
    if comparison == Comparison::NotPossible && !last_fitted.model.is_pinned() {
        let names = absorbed.iter().map(|&group| search.library.groups[group].label());
        impossible.extend(names.map(|name| format!("{name} can't be told from the base parameters: state the arm")));
    }
    let advice = advice(verdict, &effects, &unexplained, &comparison, &impossible);
    let ranking = rank(&search, &drops, &refused, &comparison, &absorbed);
    monitor.report(1.0, "diagnosed")?;
    Ok(Report {
        verdict,
        effects,
        held_out_nmse,
        noise_floor_nmse: last.noise_floor_nmse,
        unexplained_joints: unexplained,
        advice,
        ranking,
    })
}

/// The model in which a network's Lagrangian is a rigid body and its friction that of the catalogue.
///
/// A network hides an effect that it lacks in the weights of those it has; what it bends can't be linearised away. The rigid
/// body that it stands for is known, so that is what the effects are laid beside.
fn linear_counterpart(model: &Model, joints: usize) -> Model {
    let mut terms = vec![Term::RigidBody(RigidBody::Identified)];
    for term in &model.terms {
        match term {
            Term::Learned(LearnedTerm::Friction) => {
                let mut friction: Vec<_> = registry::addable().filter(|effect| effect.facts.learned_friction).collect();
                friction.sort_by_key(|effect| effect.id);
                let placed = |effect| (0..joints).map(move |joint| EffectTerm { effect, joint: Some(joint) });
                terms.extend(friction.into_iter().flat_map(placed).map(Term::Effect));
            }
            Term::Effect(_) => terms.push(term.clone()),
            Term::Learned(_) | Term::RigidBody(_) => {}
        }
    }
    Model { terms }
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
            effect: effect.effect.id.to_owned(),
            joints: effect.joints.clone(),
            confidence: effect.confidence,
            parameters,
            nmse_before,
            nmse_after,
            alternatives: effect.alternatives.clone(),
            telling_motion: None,
            evidence,
        });
    }
    Ok((effects, last, last_fitted))
}

/// A fault of the torque readings, which were left out of all that was learned and measured: there is nothing to add for it.
fn in_readings(fault: &Fault, recording: &Recording, last: &Evaluation) -> Option<MissingEffect> {
    let spec = registry::of_fault(fault.kind)?;
    let parameter = |(parameter, value): (&ParameterSpec, f64)| Parameter {
        name: parameter.name.to_owned(),
        symbol: parameter.symbol.to_owned(),
        term: 0,
        joint: Some(fault.joint),
        value,
        std_error: None,
        interval: None,
        unit: parameter.dimension.unit(recording.joints[fault.joint].kind).to_owned(),
        identified: true,
        physical: true,
    };
    Some(MissingEffect {
        effect: spec.id.to_owned(),
        joints: vec![fault.joint],
        confidence: HIGHEST_OF_READINGS,
        parameters: spec.parameters.iter().zip(fault.parameters(recording)).map(parameter).collect(),
        nmse_before: last.held_out_nmse(),
        nmse_after: last.held_out_nmse(),
        alternatives: Vec::new(),
        telling_motion: None,
        evidence: Vec::new(),
    })
}

/// The answer in a word.
fn verdict(effects: &[MissingEffect], unexplained: &[usize], comparison: &Comparison) -> Verdict {
    let doubted =
        |effect: &MissingEffect| effect.confidence <= HIGHEST_BESIDE_UNKNOWN && effect.alternatives.is_empty();
    if effects.is_empty() {
        let is_known = unexplained.is_empty() && *comparison != Comparison::Differs;
        return if is_known { Verdict::NothingMissing } else { Verdict::UnknownEffect };
    }
    if effects.iter().all(doubted) {
        return Verdict::UnknownEffect;
    }
    if effects.iter().any(|effect| effect.confidence < SURE && !effect.alternatives.is_empty()) {
        return Verdict::Ambiguous;
    }
    Verdict::Missing
}
