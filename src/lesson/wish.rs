//! What a step can ask of the session: a closed set, which looks at what the session is, and not at how it came about.

use serde::{Deserialize, Deserializer};

use crate::effect::place::Place;
use crate::model::{EffectTerm, Parameter, Preset, Term};
use crate::recording::seal::HiddenEffect;
use crate::session::{Session, Source, Step};
use crate::simulation::extrapolation::Stretch;

/// Something that the session is to fulfil.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Wish {
    /// The current model was diagnosed.
    Diagnosed,
    /// The seal was opened.
    SealOpen,
    /// There is a model of this kind.
    Made(Preset),
    /// The current model has everything that is hidden, on the joints where it is hidden.
    HasHidden,
    /// The current model has these effects.
    Has(#[serde(deserialize_with = "places")] Vec<Place>),
    /// The held-out error of each joint is at most so many times what noise alone would leave.
    ErrorWithin(f64),
    /// The mean held-out error is at most so many times that of the first model of the ladder.
    ErrorFell(f64),
    /// The true value of everything hidden lies in the interval of the current model, widened so many times.
    TruthInside(f64),
    /// The intervals of all effects of the current model are at most so wide to either side, as a part of the value.
    IntervalsBelow(f64),
    /// The growth of errors was computed, for at least two models or one that was not there before.
    Extrapolated(Stretch),
    /// The recording is one that was opened, and not one that was simulated.
    OwnRecording,
}

fn places<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<Place>, D::Error> {
    let texts = Vec::<String>::deserialize(from)?;
    texts.iter().map(|text| text.parse().map_err(serde::de::Error::custom)).collect()
}

impl Wish {
    /// Whether the session fulfils it; else what lacks. `hidden` is what is to be found in its recording, where that is known.
    pub(super) fn check(&self, session: &Session, hidden: &[HiddenEffect]) -> Result<(), String> {
        let lacks = |text: &str| Err(text.to_owned());
        let Some(recording) = session.recording.as_deref() else { return lacks("there is no recording yet") };
        if let Wish::OwnRecording = self {
            return match session.source.as_deref().and_then(Source::files) {
                Some(_) => Ok(()),
                None => lacks("open a recording of your own"),
            };
        }
        let Some(step) = session.current() else { return lacks("there is no model yet") };
        match self {
            Wish::OwnRecording => Ok(()),
            Wish::Diagnosed if session.report.is_some() => Ok(()),
            Wish::Diagnosed => lacks("the current model was not diagnosed yet"),
            Wish::SealOpen if session.truth.is_some() => Ok(()),
            Wish::SealOpen => lacks("the seal is shut"),
            Wish::Made(preset) => match session.models.iter().any(|kept| kept.preset == *preset) {
                true => Ok(()),
                false => Err(format!("there is no {} yet", preset.title())),
            },
            Wish::HasHidden => {
                let is_there = |effect: &str, joint| term_of(step, effect, joint).is_some();
                match hidden.iter().all(|hidden| is_there(&hidden.effect, hidden.joint)) {
                    true => Ok(()),
                    false => lacks("the model lacks what is hidden, or has it elsewhere"),
                }
            }
            Wish::Has(places) => {
                let joints = recording.joint_count();
                let has = |place: &Place| {
                    let wanted = place.joints.clone().unwrap_or_else(|| (0..joints).collect());
                    let is_there = |joint| term_of(step, place.effect.id, joint).is_some();
                    place.effect.places(wanted).into_iter().all(is_there)
                };
                match places.iter().find(|place| !has(place)) {
                    None => Ok(()),
                    Some(place) => Err(format!("the model lacks {}", place.effect.name)),
                }
            }
            Wish::ErrorWithin(factor) => error_within(step, *factor),
            Wish::ErrorFell(factor) => error_fell(session, step, *factor),
            Wish::TruthInside(factor) => truth_inside(step, hidden, *factor),
            Wish::IntervalsBelow(share) => intervals_below(step, *share),
            Wish::Extrapolated(stretch) => match &session.sweep {
                Some(sweep) if sweep.stretch == *stretch => Ok(()),
                _ => Err(format!("it was not extrapolated in {} yet", stretch.name())),
            },
        }
    }
}

/// The place of an effect among the terms of a model.
fn term_of(step: &Step, effect: &str, joint: Option<usize>) -> Option<usize> {
    let is_it = |term: &EffectTerm| term.effect.id == effect && term.joint == joint;
    step.fitted.model.terms.iter().position(|term| matches!(term, Term::Effect(own) if is_it(own)))
}

fn error_within(step: &Step, factor: f64) -> Result<(), String> {
    let Some(floor) = &step.evaluation.noise_floor_nmse else {
        return Err("there are too few samples to tell what noise leaves".to_owned());
    };
    let errors = step.evaluation.held_out_nmse();
    for (joint, (error, floor)) in errors.iter().zip(floor).enumerate() {
        if *error > factor * floor {
            let times = error / floor;
            return Err(format!("the held-out error of joint {} is {times:.1} times what noise leaves", joint + 1));
        }
    }
    Ok(())
}

pub(super) fn mean_error(step: &Step) -> f64 {
    let errors = step.evaluation.held_out_nmse();
    errors.iter().sum::<f64>() / errors.len().max(1) as f64
}

fn error_fell(session: &Session, step: &Step, factor: f64) -> Result<(), String> {
    let first = session.ladder.first().map_or(f64::NAN, |first| mean_error(first));
    let share = mean_error(step) / first;
    if share <= factor {
        return Ok(());
    }
    Err(format!("the held-out error is {:.0} % of what it was; {:.0} % are wanted", 100.0 * share, 100.0 * factor))
}

fn truth_inside(step: &Step, all: &[HiddenEffect], factor: f64) -> Result<(), String> {
    for hidden in all {
        let Some(term) = term_of(step, &hidden.effect, hidden.joint) else {
            return Err("the model lacks what is hidden, or has it elsewhere".to_owned());
        };
        let own: Vec<&Parameter> = step.fitted.parameters.iter().filter(|parameter| parameter.term == term).collect();
        for (parameter, truth) in own.iter().zip(&hidden.parameters) {
            let Some([low, high]) = parameter.interval else {
                return Err(format!("{} has no interval", parameter.name));
            };
            let (middle, half) = (0.5 * (low + high), 0.5 * factor * (high - low));
            if (truth - middle).abs() > half {
                return Err(format!("the true {} lies outside its interval", parameter.name));
            }
        }
    }
    Ok(())
}

fn intervals_below(step: &Step, share: f64) -> Result<(), String> {
    let of_effects = |parameter: &&Parameter| matches!(step.fitted.model.terms[parameter.term], Term::Effect(_));
    for parameter in step.fitted.parameters.iter().filter(of_effects) {
        let Some([low, high]) = parameter.interval else { return Err(format!("{} has no interval", parameter.name)) };
        let half = 0.5 * (high - low) / parameter.value.abs();
        if half.is_nan() || half > share {
            let (half, share) = (100.0 * half, 100.0 * share);
            return Err(format!("the interval of {} is ±{half:.0} %; ±{share:.0} % are wanted", parameter.name));
        }
    }
    Ok(())
}
