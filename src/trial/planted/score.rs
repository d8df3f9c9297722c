//! How cases fared: what was planted and found, what was named falsely, and what was lost.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{Case, Planting};
use crate::diagnosis::presence::{EVEN, SURE};
use crate::diagnosis::{MissingEffect, Presence, Report};
use crate::effect::{Effect, registry};
use crate::trial::foreign::{Answered, Name};
use crate::trial::rates::{Reliability, calibration_error, reliability, share};
use crate::trial::verdict::{Planted, Truth, Verdict};

/// A case that the diagnosis has answered.
#[derive(Debug, Clone, Serialize)]
pub struct Tried {
    /// Every name and what it is.
    #[serde(flatten)]
    pub answered: Answered,
    /// What became of what was planted.
    pub detections: Vec<Detection>,
    /// Names of nothing that was planted, and of nothing that was named before (of a twin: that is known to be there).
    pub false_names: Vec<Name>,
    /// How many of these are of a family that was likelier there than not before, though not likely enough for a name.
    pub likely_before: usize,
    /// How many of these are what nearly every joint has, so that nobody knows whether it was in the log before; 0 of a twin.
    pub everyday: usize,
    /// What was named before and is not named any more, in no form; nothing of a twin.
    pub lost: Vec<Name>,
    /// The confidence of each name of which it is known whether it is right.
    pub confidences: Vec<(f64, bool)>,
}

/// What became of something that was planted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Detection {
    /// What was planted.
    #[serde(flatten)]
    pub planting: Planting,
    /// Whether it was named before.
    pub before: Before,
    /// How it is named now: right or as another form; `None` if it is not.
    pub named: Option<Verdict>,
    /// How sure the diagnosis is of that.
    pub confidence: Option<f64>,
}

/// Whether something was named before it was planted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Before {
    /// It was not.
    Absent,
    /// Another form of it was, so that its name says nothing of what was planted.
    AsAnotherForm,
    /// It was: then its first parameter has to grow by what was planted.
    There {
        /// By how much it grew, over what was planted; `None` if it is not named any more.
        followed: Option<f64>,
    },
}

/// Cases that belong together.
#[derive(Debug, Clone, Serialize)]
pub struct Group {
    /// How many.
    pub cases: usize,
    /// What was planted, by strength: each up to the given one.
    pub by_strength: Vec<Fared>,
    /// The same by effect.
    pub by_effect: BTreeMap<String, Fared>,
    /// False names a case.
    pub false_names: Option<f64>,
    /// The same of names at 90 % or more.
    pub sure_false_names: Option<f64>,
    /// False names a case of a family that was likelier there than not before anything was planted.
    pub likely_before: Option<f64>,
    /// False names a case of what nearly every joint has, so that nobody knows whether it was in the log before.
    pub everyday: Option<f64>,
    /// Names a case that were there before and are lost.
    pub lost: Option<f64>,
    /// Confidence against the share of right names, where it is known what is right.
    pub reliability: Vec<Reliability>,
    /// Mean distance between the two.
    pub calibration_error: Option<f64>,
    /// Share of the 95 % intervals of right names that hold the truth.
    pub coverage: Option<f64>,
    /// Share of the cases that are said to have more than is named.
    pub flagged: Option<f64>,
    /// How long a diagnosis took, mean \[s\].
    pub seconds_per_case: f64,
}

/// How planted effects fared.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Fared {
    /// The largest strength that is counted here.
    pub strength: f64,
    /// How many were planted that had not been named before, in no form.
    pub planted: usize,
    /// How many of these are named now, as what they are or in another form.
    pub named: usize,
    /// How many of these with a confidence of 90 % or more.
    pub sure: usize,
    /// How many were planted beside what had been named before.
    pub there_before: usize,
    /// Growth of the parameter of what was there before over what was planted, median; `None` if there is none.
    pub followed: Option<f64>,
}

/// How the cases of a log fared.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    /// What is named in the log before anything is planted.
    pub before: Vec<Name>,
    /// Effects planted into the log.
    pub planted: Group,
    /// Twins of the log.
    pub twins: Group,
    /// Every case.
    pub cases: Vec<Tried>,
}

impl Tried {
    /// Judges a report.
    pub(super) fn new(case: &Case, report: &Report, seconds: f64) -> Tried {
        let Case { truth, before, .. } = case;
        let answered = Answered::new(case.name.clone(), truth, report, seconds);
        let detections = case.plantings.iter().filter_map(|planting| detection(planting, case, report)).collect();
        let is_false = |name: &&Name| !name.verdict.is_good();
        let lost = before.as_ref().map(|before| lost(before, truth, &answered.names)).unwrap_or_default();
        let false_names: Vec<Name> = answered.names.iter().filter(is_false).cloned().collect();
        let is_everyday =
            |name: &&Name| before.is_some() && registry::find(&name.effect).is_ok_and(|effect| effect.facts.everyday);
        let was_likely = |name: &&Name| before.as_ref().is_some_and(|before| likely(before, name));
        Tried {
            detections,
            likely_before: false_names.iter().filter(was_likely).count(),
            everyday: false_names.iter().filter(is_everyday).count(),
            false_names,
            lost,
            confidences: answered.names.iter().filter_map(|name| known(name, truth)).collect(),
            answered,
        }
    }
}

fn detection(planting: &Planting, case: &Case, report: &Report) -> Option<Detection> {
    let effect = registry::find(&planting.effect).ok()?;
    let is_it =
        |planted: &&Planted| !planted.assumed && planted.effect == planting.effect && planted.joint == planting.joint;
    let planted = case.truth.planted.iter().find(is_it)?;
    let judged =
        super::named(report).into_iter().map(|name| (planted.judge(&name.effect, name.joint), name.confidence));
    let found: Vec<(Verdict, f64)> = judged.filter(|(verdict, _)| *verdict >= Verdict::Form).collect();
    Some(Detection {
        planting: planting.clone(),
        before: case.before.as_ref().map_or(Before::Absent, |before| {
            let verdicts = super::named(before).into_iter().map(|name| planted.judge(&name.effect, name.joint));
            match verdicts.max() {
                Some(Verdict::Right) => Before::There { followed: followed(effect, planting, before, report) },
                Some(Verdict::Form) => Before::AsAnotherForm,
                _ => Before::Absent,
            }
        }),
        named: found.iter().map(|(verdict, _)| *verdict).max(),
        confidence: found.iter().map(|(_, confidence)| *confidence).max_by(f64::total_cmp),
    })
}

/// Growth of the first parameter of an effect over what was planted of it.
fn followed(effect: &Effect, planting: &Planting, before: &Report, after: &Report) -> Option<f64> {
    let parameter = effect.parameters.first()?.name;
    let planted = planting.parameters.get(parameter)?;
    let value = |report: &Report| {
        let is_it = |named: &&MissingEffect| named.effect == effect;
        let parameters = report.effects.iter().filter(is_it).flat_map(|named| &named.parameters);
        let joint = planting.joint.map(|joint| joint - 1);
        let mut own = parameters.filter(|other| other.name == parameter && other.joint == joint);
        own.next().map(|parameter| parameter.value)
    };
    Some((value(after)? - value(before)?) / planted)
}

/// What was named before and is not any more.
fn lost(before: &Report, truth: &Truth, names: &[Name]) -> Vec<Name> {
    let is_lost = |old: &Name| {
        let is_it = |planted: &&Planted| planted.assumed && planted.effect == old.effect && planted.joint == old.joint;
        let assumed = truth.planted.iter().find(is_it);
        assumed.is_some_and(|assumed| names.iter().all(|new| assumed.judge(&new.effect, new.joint) < Verdict::Form))
    };
    super::named(before).into_iter().filter(is_lost).collect()
}

/// Whether something of the family of this name was likelier at its place than not.
fn likely(before: &Report, name: &Name) -> bool {
    let Ok(effect) = registry::find(&name.effect) else { return false };
    let place = name.joint.map(|joint| joint - 1);
    let is_it = |one: &&Presence| one.family == effect.family && one.joint == place;
    before.presence.iter().find(is_it).is_some_and(|one| one.probability >= EVEN)
}

/// The confidence of a name and whether it is right; `None` if nobody knows.
fn known(name: &Name, truth: &Truth) -> Option<(f64, bool)> {
    let is_good = |planted: &&Planted| planted.judge(&name.effect, name.joint).is_good();
    let (assumed, sure): (Vec<&Planted>, Vec<&Planted>) =
        truth.planted.iter().filter(is_good).partition(|planted| planted.assumed);
    let is_right = !sure.is_empty();
    (assumed.is_empty() && is_right == name.verdict.is_good()).then_some((name.confidence, is_right))
}

impl Summary {
    /// How these cases of a log fared in which all of `before` was named.
    pub fn of(before: Vec<Name>, strengths: &[f64], cases: Vec<Tried>) -> Summary {
        let (twins, planted): (Vec<&Tried>, Vec<&Tried>) =
            cases.iter().partition(|tried| tried.answered.kind == super::TWIN);
        Summary { before, planted: Group::of(&planted, strengths), twins: Group::of(&twins, strengths), cases }
    }
}

impl Group {
    fn of(cases: &[&Tried], strengths: &[f64]) -> Group {
        let detections: Vec<&Detection> = cases.iter().flat_map(|tried| &tried.detections).collect();
        let mut ends = strengths.to_vec();
        ends.sort_by(f64::total_cmp);
        ends.dedup();
        let of_end = |(number, end): (usize, &f64)| {
            let above = if number == 0 { 0.0 } else { ends[number - 1] };
            let own =
                |detection: &&&Detection| detection.planting.strength > above && detection.planting.strength <= *end;
            Fared { strength: *end, ..Fared::of(&detections.iter().filter(own).copied().collect::<Vec<_>>()) }
        };
        let mut effects: BTreeMap<String, Vec<&Detection>> = BTreeMap::new();
        for detection in &detections {
            effects.entry(detection.planting.effect.clone()).or_default().push(detection);
        }
        let a_case = |names: &dyn Fn(&Tried) -> usize| {
            let all: usize = cases.iter().map(|tried| names(tried)).sum();
            (!cases.is_empty()).then(|| all as f64 / cases.len() as f64)
        };
        let confidences: Vec<(f64, bool)> = cases.iter().flat_map(|tried| &tried.confidences).copied().collect();
        let reliability = reliability(&confidences);
        let intervals = cases.iter().flat_map(|tried| &tried.answered.intervals);
        Group {
            cases: cases.len(),
            by_strength: ends.iter().enumerate().map(of_end).collect(),
            by_effect: effects.into_iter().map(|(effect, own)| (effect, Fared::of(&own))).collect(),
            false_names: a_case(&|tried| tried.false_names.len()),
            sure_false_names: a_case(&|tried| tried.false_names.iter().filter(|name| name.confidence >= SURE).count()),
            likely_before: a_case(&|tried| tried.likely_before),
            everyday: a_case(&|tried| tried.everyday),
            lost: a_case(&|tried| tried.lost.len()),
            calibration_error: calibration_error(&reliability),
            reliability,
            coverage: share(intervals.map(|interval| interval.holds)),
            flagged: share(cases.iter().map(|tried| tried.answered.flagged)),
            seconds_per_case: cases.iter().map(|tried| tried.answered.seconds).sum::<f64>() / cases.len().max(1) as f64,
        }
    }
}

impl Fared {
    fn of(detections: &[&Detection]) -> Fared {
        let (new, others): (Vec<&Detection>, Vec<&Detection>) =
            detections.iter().partition(|detection| detection.before == Before::Absent);
        let followed = |detection: &&Detection| match detection.before {
            Before::There { followed } => followed,
            Before::Absent | Before::AsAnotherForm => None,
        };
        let mut changes: Vec<f64> = others.iter().filter_map(followed).collect();
        changes.sort_by(f64::total_cmp);
        let is_sure = |detection: &&&Detection| detection.confidence.is_some_and(|confidence| confidence >= SURE);
        Fared {
            strength: detections.iter().map(|detection| detection.planting.strength).fold(0.0, f64::max),
            planted: new.len(),
            named: new.iter().filter(|detection| detection.named.is_some()).count(),
            sure: new.iter().filter(is_sure).count(),
            there_before: others.len(),
            followed: changes.get(changes.len() / 2).copied(),
        }
    }
}
