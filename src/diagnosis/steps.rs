//! The named effects are added one after the other, and the held-out error of each step is measured.

use std::collections::BTreeMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::evidence;
use super::heard::{BEYOND_DOUBT, Heard};
use super::held_out::{self, Errors};
use super::in_band::InBand;
use super::naming::Named;
use super::presence::{BESIDE_THE_UNKNOWN, Judged, LIKELY};
use super::report::{Ground, MissingEffect};
use super::stated_arm::StatedBody;
use super::withdrawn::Withdrawn;
use crate::effect::{Effect, Family, ParameterSpec, Scope, registry};
use crate::model::design::Design;
use crate::model::{Evaluation, Fitted, Model, ModelError, Parameter, Term, fit};
use crate::progress::Monitor;
use crate::recording::Recording;
use crate::recording::fault::{self, Fault};
use crate::recording::split::Split;

/// How sure a fault is that the readings themselves show.
const SURE_OF_READINGS: f64 = 0.95;

/// What effects are added to, and what they are held against.
pub struct Base<'a> {
    /// The model that was given.
    pub fitted: &'a Fitted,
    /// That model, held against the recording.
    pub evaluation: &'a Evaluation,
    /// The arm as it is stated, if it is.
    pub stated: Option<&'a StatedBody>,
    /// The whole recording.
    pub recording: &'a Recording,
    /// Its parts.
    pub split: &'a Split,
    /// Where held-out data are asked.
    pub in_band: &'a InBand<'a>,
    /// What models are fitted to.
    pub design: &'a Design<'a>,
    /// Tells how far it is, and when to stop.
    pub monitor: &'a Monitor,
}

/// The named effects, measured.
pub struct Steps {
    /// In the order in which they are to be added.
    pub effects: Vec<MissingEffect>,
    /// The model with all of them, held against the recording.
    pub last: Evaluation,
    /// That model.
    pub fitted: Fitted,
    /// Of each effect its groups beside each of their rivals that come close, of each group the closest first.
    pub rivals_of: Vec<Vec<(usize, usize)>>,
    /// What was named and is not any more.
    pub withdrawn: Vec<Withdrawn>,
    /// What the held-out part says of those in doubt.
    pub heard: Vec<Heard>,
}

/// Adds the named effects one after the other and measures the held-out error of each step.
///
/// What lies outside its bounds on a joint when all are fitted does not exist there, and what may as well be zero is not shown: it is
/// left out (but a rotor's inertia, of which the held-out part is asked), and the others are measured anew; so is what is not likely once the held-out part was asked. One that raises the held-out
/// error of all its joints is not what to add first. What may stand in for something unknown has to be likelier than the rest, unless
/// the model with all that is named `is_complete`, held against the recording.
///
/// # Errors
/// [`ModelError`] if a model can't be fitted, or the work was stopped.
pub fn measure(
    named: Vec<Named>,
    judged: &Judged,
    is_complete: impl Fn(&Fitted, &Evaluation) -> Result<bool, ModelError>,
    base: &Base,
) -> Result<Steps, ModelError> {
    let mut withdrawn = Vec::new();
    let (mut named, whole, heard) = asked(named, judged, is_complete, &mut withdrawn, base)?;
    let mut may_reorder = true;
    loop {
        let ladder = climb(&named, &whole, base)?;
        let errors = ladder.errors();
        let rises = |(effect, [before, after]): (&Named, &[Vec<f64>; 2])| {
            effect.joints.iter().all(|&joint| after[joint] > before[joint])
        };
        let first_rises = named.iter().zip(&errors).next().is_some_and(rises);
        if may_reorder && first_rises && !named[0].pins {
            let better = named.iter().zip(&errors).position(|step| !rises(step) && !step.0.pins);
            if let Some(better) = better {
                let first = named.remove(better);
                named.insert(0, first);
                may_reorder = false;
                continue;
            }
        }
        return Ok(ladder.told(&named, withdrawn, heard, base));
    }
}

/// Leaves out what all fitted together don't show, and, one after the other, what is not likely once the held-out part was asked. What stays,
/// each with the presence that it has then, the model with it, and what the held-out part says of what stays and of what left.
fn asked(
    named: Vec<Named>,
    judged: &Judged,
    is_complete: impl Fn(&Fitted, &Evaluation) -> Result<bool, ModelError>,
    withdrawn: &mut Vec<Withdrawn>,
    base: &Base,
) -> Result<(Vec<Named>, Fitted, Vec<Heard>), ModelError> {
    // A rotor's inertia and the links' share what is sure of their sum: what training does not tell apart held-out data may.
    let is_asked = |effect: &Effect, joint: usize| {
        let presence = judged.presence(effect.family, Some(joint));
        let is_shared = effect.facts.everyday && effect.facts.absorbed_by_body;
        is_shared && presence < BEYOND_DOUBT && !base.split.held_out.is_empty()
    };
    let (mut named, mut whole) = only_shown(named, is_asked, withdrawn, base)?;
    let mut gone: Vec<Heard> = Vec::new();
    loop {
        let errors = |named: &[Named]| {
            let evaluation = measured(with_all(named, base)?, &whole, base, &base.monitor.quiet())?.evaluation;
            Ok(Errors::of(&evaluation, base.in_band))
        };
        let heard = held_out::ask(&named, |family, joint| judged.presence(family, joint), errors)?;
        let unlikely = held_out::unlikely(&named, &heard, |_| LIKELY)
            .map(|(number, one)| (number, one, Ground::NotSupported(one.held_out)));
        let leaves = match unlikely {
            None => may_stand_in(&named, &heard, || {
                is_complete(&whole, &Evaluation::of(&whole, base.recording, base.split)?)
            })?,
            unlikely => unlikely,
        };
        let Some((number, one, ground)) = leaves else {
            for effect in named.iter_mut().filter(|effect| !effect.pins) {
                let presence = |joint| presence(judged, &heard, effect.effect.family, joint);
                effect.presence = effect.places().into_iter().map(presence).fold(1.0, f64::min);
            }
            gone.retain(|gone| Heard::find(&heard, gone.family, gone.joint).is_none());
            gone.extend(heard);
            return Ok((named, whole, gone));
        };
        let effect = named[number].effect;
        withdrawn.push(Withdrawn { effect, joint: one.joint, ground });
        take_off(&mut named, number, one.joint.unwrap_or_default());
        gone.push(one);
        (named, whole) = only_shown(named, is_asked, withdrawn, base)?;
    }
}

/// The least likely of what may stand in for something unknown, if such is left, and the number of its name.
fn may_stand_in(
    named: &[Named],
    heard: &[Heard],
    is_complete: impl FnOnce() -> Result<bool, ModelError>,
) -> Result<Option<(usize, Heard, Ground)>, ModelError> {
    let on = |effect: &Effect| if effect.facts.everyday { LIKELY } else { BESIDE_THE_UNKNOWN };
    let Some((number, one)) = held_out::unlikely(named, heard, on) else { return Ok(None) };
    Ok((!is_complete()?).then_some((number, one, Ground::MayStandIn { presence: one.presence })))
}

/// The model with all these effects.
fn with_all(named: &[Named], base: &Base) -> Result<Model, ModelError> {
    let is_pinned = named.iter().any(|effect| effect.pins);
    let given = &base.fitted.model;
    let body = base.stated.filter(|_| is_pinned).map_or_else(|| given.clone(), |stated| stated.held(given));
    named.iter().try_fold(body, |model, effect| model.with_effect(effect.effect, &effect.joints))
}

/// How likely a family is there at a place, with what was `heard` of it.
fn presence(judged: &Judged, heard: &[Heard], family: Family, joint: Option<usize>) -> f64 {
    Heard::find(heard, family, joint).map_or_else(|| judged.presence(family, joint), |one| one.presence)
}

/// Leaves out, one after the other, what all fitted together don't show: what one of them takes over another no longer says. What most of
/// the other joints have stays as long as it is possible: two kinds of friction may share what is sure of their sum; so does what the held-out
/// part `is_asked` about, which is to show it then. What stays, and the model with it; what leaves is `withdrawn`.
fn only_shown(
    mut named: Vec<Named>,
    is_asked: impl Fn(&Effect, usize) -> bool,
    withdrawn: &mut Vec<Withdrawn>,
    base: &Base,
) -> Result<(Vec<Named>, Fitted), ModelError> {
    let design = base.design;
    loop {
        let whole = fit::fit_design(&with_all(&named, base)?, design, base.monitor)?;
        let quantile = fit::interval_quantile(design.blocks().len());
        let places = named.iter().enumerate().flat_map(|(number, effect)| {
            let parameters = parameters_of(&whole, effect.effect);
            let shown = |&joint: &usize| {
                let shown = shown(effect.effect, &parameters, joint, design) / quantile;
                let stays = shown > 0.0 && (effect.usual.contains(&joint) || is_asked(effect.effect, joint));
                (if stays { f64::INFINITY } else { shown }, number, joint)
            };
            effect.joints.iter().map(shown).collect::<Vec<_>>()
        });
        let Some((shown, number, joint)) = places.min_by(|a, b| a.0.total_cmp(&b.0)) else { return Ok((named, whole)) };
        if shown > 1.0 {
            return Ok((named, whole));
        }
        let effect = named[number].effect;
        let not_shown = |joint| Withdrawn { effect, joint, ground: Ground::NotShown };
        withdrawn.extend(effect.places([joint]).into_iter().map(not_shown));
        take_off(&mut named, number, joint);
    }
}

/// Takes one of the named effects off a joint. The common form of its family that it contains stays there: it is judged by itself.
fn take_off(named: &mut Vec<Named>, number: usize, joint: usize) {
    let own = &mut named[number];
    let is_of_arm = own.effect.scope == Scope::Arm;
    own.joints.retain(|&other| other != joint && !is_of_arm);
    let is_usual = own.usual.contains(&joint);
    own.usual.retain(|&other| other != joint);
    let (family, gain, presence) = (own.effect.family, own.gain, own.presence);
    let form = own.forms.remove(&Some(joint));
    let mut contained = own.effect.facts.includes.iter().filter_map(|id| registry::find(id).ok());
    let common = contained.find(|effect| effect.is_common() && effect.family == family);
    named.retain(|effect| !effect.joints.is_empty());
    let Some(effect) = common else { return };
    let place = named.iter().position(|named| named.effect == effect).unwrap_or_else(|| {
        let (joints, usual, alternatives, rivals) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let forms = BTreeMap::new();
        named.push(Named { effect, joints, usual, gain, presence, forms, alternatives, rivals, pins: false });
        named.len() - 1
    });
    let common = &mut named[place];
    common.joints.push(joint);
    common.joints.sort_unstable();
    common.usual.extend(is_usual.then_some(joint));
    common.presence = common.presence.min(presence);
    common.forms.extend(form.map(|form| (Some(joint), form)));
}

/// How far what was fitted for an effect on a joint is from nothing, in standard errors; 0 if it is impossible or a
/// wave that does not repeat along the way.
fn shown(effect: &Effect, parameters: &[Parameter], joint: usize, design: &Design) -> f64 {
    let here = || parameters.iter().filter(|parameter| parameter.joint.is_none_or(|own| own == joint));
    let value = |name: &str| here().find(|parameter| parameter.name == name).map(|parameter| parameter.value);
    let shape: Vec<f64> = effect.shapes().filter_map(|(shape, _)| value(shape.name)).collect();
    if here().any(|parameter| !parameter.physical) || !effect.repeats_along(design.way(Some(joint)), &shape) {
        return 0.0;
    }
    let is_linear = |parameter: &&Parameter| effect.linear().any(|linear| linear.name == parameter.name);
    let distance = |parameter: &Parameter| match parameter.std_error {
        _ if !parameter.identified => 0.0,
        Some(error) => parameter.value.abs() / error,
        None => f64::INFINITY,
    };
    here().filter(is_linear).map(distance).fold(0.0, f64::max)
}

/// What was fitted for an effect.
fn parameters_of(fitted: &Fitted, effect: &Effect) -> Vec<Parameter> {
    let is_it = |term: usize| matches!(&fitted.model.terms[term], Term::Effect(term) if term.effect == effect);
    fitted.parameters.iter().filter(|parameter| is_it(parameter.term)).cloned().collect()
}

/// One step of the ladder.
struct Rung {
    /// The model before it, where this step holds the body to the stated arm.
    pinned: Option<Model>,
    /// The model after it.
    with: Model,
}

fn rungs(named: &[Named], base: &Base) -> Result<Vec<Rung>, ModelError> {
    let mut model = base.fitted.model.clone();
    let rung = |effect: &Named| {
        let stated = base.stated.filter(|_| effect.pins && !model.is_pinned());
        let pinned = stated.map(|stated| stated.held(&model));
        model = pinned.as_ref().unwrap_or(&model).with_effect(effect.effect, &effect.joints)?;
        Ok(Rung { pinned, with: model.clone() })
    };
    named.iter().map(rung).collect()
}

/// The models before and after each step, and after all.
struct Ladder {
    steps: Vec<[Arc<Measured>; 2]>,
    last: Arc<Measured>,
}

/// A model that was fitted, held against the recording.
#[derive(Clone)]
struct Measured {
    fitted: Fitted,
    evaluation: Evaluation,
}

/// Of a model that is fitted here, unless it is the `whole` one, which is fitted already.
fn measured(model: Model, whole: &Fitted, base: &Base, monitor: &Monitor) -> Result<Measured, ModelError> {
    let fitted = if model == whole.model { whole.clone() } else { fit::fit_design(&model, base.design, monitor)? };
    let evaluation = Evaluation::of(&fitted, base.recording, base.split)?;
    Ok(Measured { fitted, evaluation })
}

fn climb(named: &[Named], whole: &Fitted, base: &Base) -> Result<Ladder, ModelError> {
    base.monitor.report(0.85, "adding what was found, step by step")?;
    // Models of neighbouring steps are fitted side by side: none needs what another one found.
    let quiet = base.monitor.quiet();
    let measured = |model: Model| measured(model, whole, base, &quiet).map(Arc::new);
    let rungs: Vec<Rung> = rungs(named, base)?;
    let climbed = |rung: Rung| Ok((rung.pinned.map(measured).transpose()?, measured(rung.with)?));
    let measured: Vec<_> = rungs.into_par_iter().map(climbed).collect::<Result<_, ModelError>>()?;
    let mut last = Arc::new(Measured { fitted: base.fitted.clone(), evaluation: base.evaluation.clone() });
    let step = |(pinned, with): (Option<Arc<Measured>>, Arc<Measured>)| {
        let before = pinned.unwrap_or_else(|| last.clone());
        last = with.clone();
        [before, with]
    };
    let steps = measured.into_iter().map(step).collect();
    Ok(Ladder { steps, last })
}

impl Ladder {
    /// The held-out errors before and after each step.
    fn errors(&self) -> Vec<[Vec<f64>; 2]> {
        self.steps.iter().map(|step| step.each_ref().map(|one| one.evaluation.held_out_nmse())).collect()
    }

    fn told(self, named: &[Named], withdrawn: Vec<Withdrawn>, heard: Vec<Heard>, base: &Base) -> Steps {
        let Base { recording, split, .. } = *base;
        let Measured { fitted, evaluation } = &*self.last;
        let told = |(effect, [nmse_before, nmse_after]): (&Named, [Vec<f64>; 2])| MissingEffect {
            effect: effect.effect,
            joints: effect.joints.clone(),
            presence: effect.presence,
            form: effect.form(),
            parameters: parameters_of(fitted, effect.effect),
            nmse_before,
            nmse_after,
            alternatives: effect.alternatives_told(),
            telling_motion: None,
            evidence: evidence::of_effect(fitted, evaluation, recording, split, effect.effect, &effect.joints),
        };
        let effects = named.iter().zip(self.errors()).map(told).collect();
        let rivals_of = named.iter().map(|named| named.rivals.clone()).collect();
        drop(self.steps);
        let Measured { fitted, evaluation: last } = Arc::unwrap_or_clone(self.last);
        Steps { effects, last, fitted, rivals_of, withdrawn, heard }
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
            stated: None,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::report::HeldOut;

    fn told(named: &[Named]) -> Vec<(&str, &[usize])> {
        named.iter().map(|named| (named.effect.id, named.joints.as_slice())).collect()
    }

    /// Coulomb friction is hidden in the arm; an offset that is not there may as well be zero.
    #[test]
    fn what_all_fitted_together_do_not_show_leaves_and_is_remembered() {
        use crate::model::Preset;
        use crate::simulation::{Scenario, simulate};
        let recording = simulate(&Scenario::embedded(), &Monitor::new()).unwrap();
        let split = Split::automatic(&recording);
        let body = Preset::RigidBody.model(&recording).unwrap();
        let body = fit::fit(&body, &recording, &split, &Monitor::new()).unwrap();
        let design = Design::new(&recording, &split).unwrap();
        let named =
            ["coulomb-friction", "torque-offset"].map(|id| Named { usual: vec![], ..Named::example(id, &[1], 0.9) });
        let mut withdrawn = Vec::new();
        let base = Base {
            fitted: &body,
            evaluation: &Evaluation::of(&body, &recording, &split).unwrap(),
            stated: None,
            recording: &recording,
            split: &split,
            in_band: &InBand::of(&recording, &split, &design),
            design: &design,
            monitor: &Monitor::new(),
        };
        let (stays, _) = only_shown(named.to_vec(), |_, joint| joint == 1, &mut withdrawn, &base).unwrap();
        assert_eq!((stays.len(), withdrawn.len()), (2, 0), "the held-out part is asked");
        let (stays, whole) = only_shown(named.into(), |_, _| false, &mut withdrawn, &base).unwrap();
        assert_eq!(told(&stays), [("coulomb-friction", [1].as_slice())]);
        let effect = registry::find("torque-offset").unwrap();
        assert_eq!(withdrawn, [Withdrawn { effect, joint: Some(1), ground: Ground::NotShown }]);
        assert_eq!(whole.model.terms.len(), body.model.terms.len() + 1);
    }

    /// A wave has to be likelier than an offset, which nearly every joint has, unless nothing unknown is left.
    #[test]
    fn what_may_stand_in_for_something_unknown_leaves() {
        let named = ["cogging", "torque-offset"].map(|id| Named { usual: Vec::new(), ..Named::example(id, &[0], 0.9) });
        let held_out = HeldOut { before: 0.6, rises: 1.2, rises_in_training: 1.2, t: 0.8 };
        let heard = |family, presence| Heard { family, joint: Some(0), held_out, presence };
        let leaves = |wave: f64, is_complete: bool| {
            let heard = [heard(Family::Ripple, wave), heard(Family::Offset, 0.7)];
            let leaves = may_stand_in(&named, &heard, || Ok(is_complete)).unwrap();
            leaves.map(|(number, one, ground)| (number, one.family, ground))
        };
        assert_eq!(leaves(0.73, false), Some((0, Family::Ripple, Ground::MayStandIn { presence: 0.73 })));
        assert_eq!([leaves(0.73, true), leaves(0.85, false)], [None, None]);
    }

    /// A Stribeck curve whose peak is impossible on joint 2 leaves the Coulomb friction that it contains; that leaves nothing.
    #[test]
    fn what_is_taken_off_leaves_the_common_form_that_it_contains() {
        let mut all =
            vec![Named::example("stribeck-friction", &[0, 1], 0.9), Named::example("coulomb-friction", &[2], 0.99)];
        take_off(&mut all, 0, 1);
        assert_eq!(told(&all), [("stribeck-friction", [0].as_slice()), ("coulomb-friction", &[1, 2])]);
        assert_eq!((all[1].presence, all[1].usual.len()), (0.9, 2));
        take_off(&mut all, 0, 0);
        take_off(&mut all, 0, 1);
        assert_eq!(told(&all), [("coulomb-friction", [0, 2].as_slice())]);
        let mut alone =
            vec![Named::example("stribeck-friction", &[1], 0.9), Named::example("base-tilt", &[0, 1, 2], 0.9)];
        take_off(&mut alone, 0, 1);
        assert_eq!(told(&alone), [("base-tilt", [0, 1, 2].as_slice()), ("coulomb-friction", &[1])]);
        take_off(&mut alone, 0, 2);
        assert_eq!(told(&alone), [("coulomb-friction", [1].as_slice())], "it acts on the whole arm or not at all");
    }
}
