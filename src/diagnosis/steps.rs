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

/// How sure a fault is that the readings themselves show.
const SURE_OF_READINGS: f64 = 0.95;

/// The named effects, measured.
pub struct Steps {
    /// In the order in which they are to be added.
    pub effects: Vec<MissingEffect>,
    /// The model with all of them, held against the recording.
    pub last: Evaluation,
    /// That model.
    pub fitted: Fitted,
    /// The group of each effect with the largest gain, and its best rival.
    pub rival_of: Vec<Option<(usize, usize)>>,
}

/// Adds the named effects one after the other and measures the held-out error of each step.
///
/// An effect whose parameters lie outside their bounds when all are fitted does not exist: it is left out, and the others are measured
/// anew. One that raises the held-out error of all its joints is not what to add first.
///
/// # Errors
/// [`ModelError`] if a model can't be fitted, or the work was stopped.
pub fn measure(
    mut named: Vec<Named>,
    fitted: &Fitted,
    start: &Evaluation,
    recording: &Recording,
    split: &Split,
    design: &Design,
    monitor: &Monitor,
) -> Result<Steps, ModelError> {
    let mut may_reorder = true;
    loop {
        let ladder = climb(&named, fitted, start, recording, split, design, monitor)?;
        let is_possible = |effect: &Named| {
            let of_effect = ladder.parameters_of(effect);
            of_effect.iter().all(|parameter| parameter.physical)
        };
        let possible: Vec<bool> = named.iter().map(is_possible).collect();
        if possible.contains(&false) {
            let mut possible = possible.iter();
            named.retain(|_| *possible.next().unwrap_or(&true));
            continue;
        }
        let rises = |(effect, (before, after)): (&Named, &(Vec<f64>, Vec<f64>))| {
            effect.joints.iter().all(|&joint| after[joint] > before[joint])
        };
        let first_rises = named.iter().zip(&ladder.errors).next().is_some_and(rises);
        if may_reorder && first_rises && !named[0].pins {
            let better = named.iter().zip(&ladder.errors).position(|step| !rises(step) && !step.0.pins);
            if let Some(better) = better {
                let first = named.remove(better);
                named.insert(0, first);
                may_reorder = false;
                continue;
            }
        }
        return Ok(ladder.told(&named, recording, split));
    }
}

/// The model after all steps, and the held-out errors before and after each.
struct Ladder {
    fitted: Fitted,
    last: Evaluation,
    errors: Vec<(Vec<f64>, Vec<f64>)>,
}

fn climb(
    named: &[Named],
    fitted: &Fitted,
    start: &Evaluation,
    recording: &Recording,
    split: &Split,
    design: &Design,
    monitor: &Monitor,
) -> Result<Ladder, ModelError> {
    let mut model: Model = fitted.model.clone();
    let (mut last_fitted, mut last) = (fitted.clone(), start.clone());
    let mut errors = Vec::new();
    for (number, effect) in named.iter().enumerate() {
        monitor.report(0.8 + 0.2 * number as f32 / named.len() as f32, "adding what was found, step by step")?;
        if effect.pins
            && !model.is_pinned()
            && let Some(arm) = &recording.stated_arm
        {
            model = model.pinned_to(arm);
            last = Evaluation::of(&fit::fit_design(&model, design, monitor)?, recording, split)?;
        }
        let before = last.held_out_nmse();
        model = model.with_effect(effect.effect, &effect.joints)?;
        last_fitted = fit::fit_design(&model, design, monitor)?;
        last = Evaluation::of(&last_fitted, recording, split)?;
        errors.push((before, last.held_out_nmse()));
    }
    Ok(Ladder { fitted: last_fitted, last, errors })
}

impl Ladder {
    fn parameters_of(&self, named: &Named) -> Vec<Parameter> {
        let of_effect =
            |term: usize| matches!(&self.fitted.model.terms[term], Term::Effect(term) if term.effect == named.effect);
        self.fitted.parameters.iter().filter(|parameter| of_effect(parameter.term)).cloned().collect()
    }

    fn told(self, named: &[Named], recording: &Recording, split: &Split) -> Steps {
        let told = |(effect, (nmse_before, nmse_after)): (&Named, &(Vec<f64>, Vec<f64>))| MissingEffect {
            effect: effect.effect,
            joints: effect.joints.clone(),
            presence: effect.presence,
            form: effect.form,
            parameters: self.parameters_of(effect),
            nmse_before: nmse_before.clone(),
            nmse_after: nmse_after.clone(),
            alternatives: effect.alternatives.clone(),
            telling_motion: None,
            evidence: evidence::of_effect(&self.fitted, &self.last, recording, split, effect.effect, &effect.joints),
        };
        let effects = named.iter().zip(&self.errors).map(told).collect();
        let rival_of = named.iter().map(|named| named.rival).collect();
        Steps { effects, last: self.last, fitted: self.fitted, rival_of }
    }
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
            presence: SURE_OF_READINGS,
            form: SURE_OF_READINGS,
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
