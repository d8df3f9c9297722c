//! How often answers to blind draws are right.
//!
//! Rates are about draws whose evidence suffices ([`Trial::suffices`]), where they do not say otherwise.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use super::Answer;
use super::blind::{Trial, names_of};
use crate::effect::registry;
use crate::recording::seal::HiddenEffect;

/// The rates, as shares of the draws that they are about; `None` without such draws.
#[derive(Debug, Clone, Serialize)]
pub struct Rates {
    /// How many draws there were.
    pub draws: usize,
    /// Draws of known effects, or of none, answered exactly.
    pub exact: Option<f64>,
    /// The same of all draws, also where the evidence does not suffice.
    pub exact_of_all: Option<f64>,
    /// Share of the draws with hidden effects where the evidence suffices.
    pub sufficient: Option<f64>,
    /// Exact of the draws without a hidden effect.
    pub silent: Option<f64>,
    /// Exact of those with one.
    pub one: Option<f64>,
    /// Of those with two.
    pub two: Option<f64>,
    /// Of those with three.
    pub three: Option<f64>,
    /// The first named effect is a hidden one, on a joint of its own.
    pub first_right: Option<f64>,
    /// Of the draws whose effect is not among the candidates.
    pub unknown_flagged: Option<f64>,
    /// Of the same: everything that was named has a confidence below one half.
    pub unknown_doubted: Option<f64>,
    /// Of the exact answers: flagged although nothing is unknown.
    pub false_flags: Option<f64>,
    /// True parameters inside their 95 % intervals, of the exact answers.
    pub coverage: Option<f64>,
    /// Median, of the exact answers.
    pub error_over_noise_floor: Option<f64>,
    /// Mean distance between presence and share of names, at each of their places, that are there in some form, over ten classes of presence.
    pub calibration_error: Option<f64>,
    /// How long a diagnosis took, mean.
    pub seconds_per_recording: f64,
    /// How long the slowest took.
    pub seconds_of_slowest: f64,
    /// How long a recording was, mean.
    pub samples_per_recording: f64,
    /// Every effect of the catalogue.
    pub by_effect: BTreeMap<&'static str, EffectRates>,
    /// Classes of presence with the share of names that were there in some form, where effects were unknown too.
    pub reliability: Vec<Reliability>,
    /// How often each hidden effect (outer) was named what (inner) on one of its joints.
    pub confusion: BTreeMap<String, BTreeMap<String, usize>>,
}

/// How an effect fared.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct EffectRates {
    /// How often it was hidden while it was a candidate.
    pub hidden: usize,
    /// How often it was then named on exactly its joints.
    pub named: usize,
    /// How often it was named where it was not, while all hidden effects were candidates.
    pub named_falsely: usize,
}

/// Names that were given about the same confidence.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reliability {
    /// Mean confidence.
    pub confidence: f64,
    /// Share that was right.
    pub right: f64,
    /// How many they are.
    pub names: usize,
}

impl Rates {
    /// The rates of these trials.
    pub fn of(trials: &[Trial]) -> Rates {
        let clear: Vec<&Trial> = trials.iter().filter(|trial| trial.suffices()).collect();
        let (unknown, known): (Vec<&Trial>, Vec<&Trial>) = clear.iter().partition(|trial| trial.unknown);
        let exact: Vec<&Trial> = known.iter().copied().filter(|trial| trial.is_exact()).collect();
        let exact_of = |hidden: usize| share(known.iter().filter(|trial| trial.hidden == hidden).map(|t| t.is_exact()));
        let all_known = trials.iter().filter(|trial| !trial.unknown);
        let hiding = trials.iter().filter(|trial| trial.hidden > 0);
        let confidences: Vec<(f64, bool)> = trials.iter().flat_map(Trial::confidences).collect();
        let reliability = reliability(&confidences);
        let mut ratios: Vec<f64> = exact.iter().filter_map(|trial| error_over_floor(trial)).collect();
        ratios.sort_by(f64::total_cmp);
        let count = trials.len().max(1) as f64;
        Rates {
            draws: trials.len(),
            exact: share(known.iter().map(|trial| trial.is_exact())),
            exact_of_all: share(all_known.map(Trial::is_exact)),
            sufficient: share(hiding.map(Trial::suffices)),
            silent: exact_of(0),
            one: exact_of(1),
            two: exact_of(2),
            three: exact_of(3),
            first_right: share(known.iter().filter(|trial| trial.hidden > 0).map(|trial| first_is_right(trial))),
            unknown_flagged: share(unknown.iter().map(|trial| trial.is_flagged())),
            unknown_doubted: share(unknown.iter().map(|trial| is_doubted(trial))),
            false_flags: share(exact.iter().map(|trial| trial.is_flagged())),
            coverage: share(exact.iter().flat_map(|trial| intervals_that_hold(trial))),
            error_over_noise_floor: ratios.get(ratios.len() / 2).copied(),
            calibration_error: calibration_error(&reliability),
            seconds_per_recording: trials.iter().map(|trial| trial.seconds).sum::<f64>() / count,
            seconds_of_slowest: trials.iter().map(|trial| trial.seconds).fold(0.0, f64::max),
            samples_per_recording: trials.iter().map(|trial| trial.samples as f64).sum::<f64>() / count,
            by_effect: by_effect(&known),
            reliability,
            confusion: confusion(&clear),
        }
    }
}

/// The share of hits; `None` of nothing.
pub(super) fn share(hits: impl IntoIterator<Item = bool>) -> Option<f64> {
    let (mut all, mut count) = (0, 0);
    for hit in hits {
        all += 1;
        count += usize::from(hit);
    }
    (all > 0).then(|| f64::from(count as u32) / f64::from(all))
}

fn first_is_right(trial: &Trial) -> bool {
    trial.report.effects.first().is_some_and(|first| !super::answer_of(first).is_disjoint(&trial.expected()))
}

fn is_doubted(trial: &Trial) -> bool {
    trial.report.effects.iter().all(|named| named.presence < 0.5)
}

fn error_over_floor(trial: &Trial) -> Option<f64> {
    let (last, floor) = (trial.report.effects.last()?, trial.report.noise_floor_nmse.as_ref()?);
    Some(last.nmse_after.iter().sum::<f64>() / floor.iter().sum::<f64>())
}

/// For each true parameter that was estimated with an interval, whether it lies inside.
fn intervals_that_hold(trial: &Trial) -> Vec<bool> {
    let of_effect = |hidden: &HiddenEffect| -> Vec<bool> {
        let Ok(effect) = registry::find(&hidden.effect) else { return Vec::new() };
        let truths = effect.parameters.iter().zip(&hidden.parameters);
        let holds = |(spec, &value): (&crate::effect::ParameterSpec, &f64)| -> Vec<bool> {
            let named = trial.report.effects.iter().filter(|named| named.effect.id == hidden.effect);
            let estimates = named.flat_map(|named| &named.parameters);
            let found = estimates.filter(|estimate| estimate.name == spec.name && estimate.joint == hidden.joint);
            let intervals = found.filter_map(|estimate| estimate.interval);
            intervals.map(|[low, high]| (low..=high).contains(&value)).collect()
        };
        truths.flat_map(holds).collect()
    };
    trial.truth.iter().flat_map(of_effect).collect()
}

fn by_effect(trials: &[&Trial]) -> BTreeMap<&'static str, EffectRates> {
    let mut rates: BTreeMap<&'static str, EffectRates> = BTreeMap::new();
    for id in registry::ALL.iter().map(|effect| effect.id) {
        let own = rates.entry(id).or_default();
        for trial in trials {
            let (expected, given) = (trial.expected(), trial.given());
            let hidden = trial.truth.iter().filter(|hidden| hidden.effect == id);
            let wanted: Answer = hidden.flat_map(names_of).collect();
            // Of the names that it goes by, those that another hidden effect does not ask for.
            let ids: BTreeSet<&String> = wanted.iter().map(|(id, _)| id).collect();
            let is_own = |name: &&(String, Option<usize>)| {
                ids.contains(&name.0) && (wanted.contains(*name) || !expected.contains(*name))
            };
            own.hidden += usize::from(!wanted.is_empty());
            own.named += usize::from(!wanted.is_empty() && given.iter().filter(is_own).eq(&wanted));
            own.named_falsely += usize::from(given.iter().any(|name| name.0 == id && !expected.contains(name)));
        }
    }
    rates
}

/// What each hidden effect was named on its joints. Beside other hidden effects of the joint only the right name counts for this
/// one, if it is there.
fn confusion(trials: &[&Trial]) -> BTreeMap<String, BTreeMap<String, usize>> {
    let mut confusion: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    for trial in trials {
        let (expected, given) = (trial.expected(), trial.given());
        for hidden in &trial.truth {
            let row = confusion.entry(hidden.effect.clone()).or_default();
            let mut names: Vec<&str> = vec![&hidden.effect];
            if !names_of(hidden).is_subset(&given) {
                let here = given.iter().filter(|name| name.1 == hidden.joint && !expected.contains(*name));
                names = here.map(|name| name.0.as_str()).collect();
            }
            if names.is_empty() {
                names.push("nothing");
            }
            names.into_iter().for_each(|name| *row.entry(name.to_owned()).or_default() += 1);
        }
    }
    confusion
}

/// The names in ten classes of confidence.
pub(super) fn reliability(confidences: &[(f64, bool)]) -> Vec<Reliability> {
    let class_of = |confidence: f64| ((confidence * 10.0) as usize).min(9);
    let of_class = |class: usize| {
        let names: Vec<&(f64, bool)> =
            confidences.iter().filter(|(confidence, _)| class_of(*confidence) == class).collect();
        let count = names.len() as f64;
        (!names.is_empty()).then(|| Reliability {
            confidence: names.iter().map(|(confidence, _)| confidence).sum::<f64>() / count,
            right: names.iter().filter(|(_, right)| *right).count() as f64 / count,
            names: names.len(),
        })
    };
    (0..10).filter_map(of_class).collect()
}

/// Mean distance between confidence and share of right names.
pub(super) fn calibration_error(classes: &[Reliability]) -> Option<f64> {
    let names: usize = classes.iter().map(|class| class.names).sum();
    let distance: f64 = classes.iter().map(|class| class.names as f64 * (class.confidence - class.right).abs()).sum();
    (names > 0).then(|| distance / names as f64)
}
