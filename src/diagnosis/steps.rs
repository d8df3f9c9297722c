//! The named effects are added one after the other, and the held-out error of each step is measured.

use super::evidence;
use super::naming::Named;
use super::report::MissingEffect;
use crate::effect::{ParameterSpec, registry};
use crate::model::design::Design;
use crate::model::{Evaluation, Fitted, Model, ModelError, Parameter, Term, fit};
use crate::progress::Monitor;
use crate::recording::Recording;
use crate::recording::fault::{self, Fault};
use crate::recording::split::Split;

/// The confidence of a fault that the readings themselves show.
const HIGHEST_OF_READINGS: f64 = 0.95;

/// Adds the named effects one after the other and measures the held-out error of each step.
pub fn measure(
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
            effect: effect.effect,
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

/// Faults of the torque readings, which were left out of all that was learned and measured: there is nothing to add for them.
pub fn faults_of_readings(recording: &Recording, last: &Evaluation) -> Vec<MissingEffect> {
    let named = |fault: &Fault| {
        let effect = registry::of_fault(fault.kind)?;
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
            effect,
            joints: vec![fault.joint],
            confidence: HIGHEST_OF_READINGS,
            parameters: effect.parameters.iter().zip(fault.parameters(recording)).map(parameter).collect(),
            nmse_before: last.held_out_nmse(),
            nmse_after: last.held_out_nmse(),
            alternatives: Vec::new(),
            telling_motion: None,
            evidence: Vec::new(),
        })
    };
    fault::find(recording).iter().filter_map(named).collect()
}
