//! Recordings that others made, with a file beside each that says what acts there: the truth comes from other physics than the
//! columns that are searched.
//!
//! A name is judged by [`Verdict`]. An answer is *exact* if every strong effect is named as what it is, and nothing is named on a wrong
//! joint, in the place of something unknown, or falsely; *in family* if another form will do for each. Weak nuisances may be
//! named or not.

use std::path::PathBuf;
use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::kin;
use super::rates::{Reliability, calibration_error, reliability, share};
use super::verdict::{Planted, Truth, Verdict};
use super::{TrialError, answer_of};
use crate::arm::Posture;
use crate::diagnosis::presence::SURE;
use crate::diagnosis::{self, HeldOut, MissingEffect, Presence, Report};
use crate::effect::{Dimension, Effect, ParameterSpec, Scope, registry};
use crate::model::{self, Preset};
use crate::progress::Monitor;
use crate::recording::Recording;
use crate::recording::hold_out::HoldOut;
use crate::recording::read::{ReadOptions, read};
use crate::recording::split::{Split, unusable};

/// A simulation that steps velocity before position reads them half a step apart: a delay below this \[s\] goes with it.
const HALF_STEP: f64 = 6e-4;

/// A recording and what is in it.
#[derive(Debug, Clone)]
pub struct Foreign {
    /// The recording's file.
    pub path: PathBuf,
    /// Where its q = 0 points.
    pub zero: Posture,
    /// What acts there.
    pub truth: Truth,
}

/// A recording that the diagnosis has answered.
#[derive(Debug, Clone, Serialize)]
pub struct Answered {
    /// Name of its file.
    pub name: String,
    /// Its class.
    pub kind: String,
    /// Whether the answer is exact.
    pub exact: bool,
    /// Whether another form would do for each strong effect.
    pub in_family: bool,
    /// Every name with its joint.
    pub names: Vec<Name>,
    /// Every effect that has to be named, and what it was named, if it was.
    pub wanted: Vec<Wanted>,
    /// Every family about which the held-out part was asked and of which it is known whether it is there, named after that or not.
    pub asked: Vec<Asked>,
    /// Whether the diagnosis says that there is more than it names.
    pub flagged: bool,
    /// Where something is outside the catalogue: the share of a joint's torque in which it does what nothing everyday can do, on the joint
    /// where that is largest; `None` where nobody looked.
    pub beside_everyday: Option<f64>,
    /// For each parameter of a right name that is known and has an interval: whether the interval holds it.
    pub intervals: Vec<Interval>,
    /// How long the diagnosis took \[s\].
    pub seconds: f64,
}

/// A name that the diagnosis gave.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Name {
    /// The effect's id.
    pub effect: String,
    /// The joint, from 1; none for the whole arm.
    pub joint: Option<usize>,
    /// How sure the diagnosis is that something of its kind is there.
    pub confidence: f64,
    /// How sure it is of this form of it, if it is there.
    pub form: f64,
    /// What it is.
    pub verdict: Verdict,
}

/// A family about which the held-out part was asked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Asked {
    /// The id of its likeliest form.
    pub effect: String,
    /// The joint, from 1; none for the whole arm.
    pub joint: Option<usize>,
    /// What the held-out part says.
    pub held_out: HeldOut,
    /// Whether it is there, in this form or another.
    pub is_there: bool,
}

/// An effect that has to be named.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Wanted {
    /// The effect's id.
    pub effect: String,
    /// The joint, from 1; none for the whole arm.
    pub joint: Option<usize>,
    /// How it was named: right or as another form; `None` if it was missed.
    pub named: Option<Verdict>,
    /// The presence of the surest name of it, 0 to 1; 0 if it was missed.
    pub confidence: f64,
}

/// A parameter whose true value is known.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Interval {
    /// Of which effect.
    pub effect: String,
    /// The parameter's name.
    pub parameter: String,
    /// Its true value, in SI units.
    pub truth: f64,
    /// The 95 % interval that was given.
    pub interval: [f64; 2],
    /// Whether it holds the truth.
    pub holds: bool,
}

/// How a class of recordings fared.
#[derive(Debug, Clone, Serialize)]
pub struct Class {
    /// Its name; `known` is all without anything outside the catalogue, `all` is all.
    pub kind: String,
    /// How many recordings it has.
    pub recordings: usize,
    /// Share of exact answers.
    pub exact: Option<f64>,
    /// Share of answers that are exact but for the forms.
    pub in_family: Option<f64>,
    /// Strong effects that were named as what they are.
    pub right: usize,
    /// Strong effects that were named as another form.
    pub form: usize,
    /// Strong effects that were not named.
    pub missed: usize,
    /// Names that are false or on a wrong joint, for each recording.
    pub false_names: f64,
    /// Names in the place of something unknown, for each recording.
    pub stand_ins: f64,
    /// Share that is said to have more than is named.
    pub flagged: Option<f64>,
}

/// How all fared.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    /// Each class, then `known` and `all`.
    pub classes: Vec<Class>,
    /// How many names were given.
    pub names: usize,
    /// Names at 90 % or more.
    pub sure_names: usize,
    /// Share of these that is right.
    pub sure_right: Option<f64>,
    /// Share of these that is right, another form, or beside.
    pub sure_good: Option<f64>,
    /// How many effects have to be named.
    pub wanted: usize,
    /// Share of these that is named at 90 % or more, as what it is or in another form.
    pub wanted_sure: Option<f64>,
    /// How many recordings hold something outside the catalogue that shows: on some joint at least [`SHOWS`] of the torque is what nothing
    /// everyday does, or nobody looked.
    pub showing: usize,
    /// Share of these that is said to have more than is named.
    pub showing_flagged: Option<f64>,
    /// How many intervals can be checked.
    pub intervals: usize,
    /// Share of these that holds the truth.
    pub coverage: Option<f64>,
    /// Confidence against the share of names that are right, another form, or beside.
    pub reliability: Vec<Reliability>,
    /// Mean distance between the two.
    pub calibration_error: Option<f64>,
    /// How sure the form is of what is there, against the share of the forms that are right.
    pub forms: Vec<Reliability>,
    /// How long a diagnosis took, mean.
    pub seconds_per_recording: f64,
    /// How long the slowest took.
    pub seconds_of_slowest: f64,
    /// Every recording.
    pub recordings: Vec<Answered>,
}

impl Foreign {
    /// A recording with the text of the file that tells what is in it.
    ///
    /// # Errors
    /// [`TrialError::Truth`] if the text does not.
    pub fn new(path: PathBuf, truth: &str) -> Result<Foreign, TrialError> {
        let wrong = |problem| TrialError::Truth { file: path.with_extension("json").display().to_string(), problem };
        let standing: Standing = serde_json::from_str(truth).map_err(wrong)?;
        let mut truth: Truth = serde_json::from_str(truth).map_err(wrong)?;
        for (planted, Sided { side }) in truth.planted.iter_mut().zip(standing.sides) {
            if let (Some(lag), Some(COMMAND_READ)) = (planted.parameters.get_mut("lag"), side.as_deref()) {
                *lag = -*lag;
            }
            kin::tell_the_side(planted, side.as_deref() == Some(MOTOR));
            kin::tell_the_younger(planted);
        }
        Ok(Foreign { zero: standing.zero.posture(), truth, path })
    }

    /// Reads the recording, asks what a rigid body lacks there, and judges the answer.
    ///
    /// # Errors
    /// [`TrialError`] if it can't be read, fitted or diagnosed.
    pub fn run(&self, monitor: &Monitor) -> Result<Answered, TrialError> {
        let (report, seconds) = self.diagnose(monitor)?;
        let name = self.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Answered::new(name, &self.truth, &report, seconds))
    }

    fn diagnose(&self, monitor: &Monitor) -> Result<(Report, f64), TrialError> {
        let options = ReadOptions { zero: Some(self.zero), ..ReadOptions::default() };
        let recording = read(std::slice::from_ref(&self.path), &options, monitor)?.recording;
        lacking_as_advised(&recording, monitor)
    }
}

/// What the file beside a recording says of the arm's posture, and of where each effect acts.
#[derive(Deserialize)]
struct Standing {
    zero: Zero,
    #[serde(rename = "truth")]
    sides: Vec<Sided>,
}

/// On which side of the drive an effect acts.
#[derive(Deserialize)]
struct Sided {
    #[serde(default)]
    side: Option<String>,
}

/// The log holds what the drive was asked for, and it lags: the log is early against the torque, so that its lag is negative.
const COMMAND_READ: &str = "command read";

/// The encoders are on the motors.
const MOTOR: &str = "motor";

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Zero {
    Down,
    Right,
    Up,
}

impl Zero {
    fn posture(self) -> Posture {
        match self {
            Zero::Down => Posture::DOWN,
            Zero::Right => Posture::RIGHT,
            Zero::Up => Posture::UP,
        }
    }
}

/// What a rigid body lacks in a recording, and how long it took to say that \[s\].
pub(super) fn lacking(recording: &Recording, split: &Split, monitor: &Monitor) -> Result<(Report, f64), TrialError> {
    let body = model::fit(&Preset::RigidBody.model(recording)?, recording, split, &monitor.part(0.0..0.1))?;
    let begin = Instant::now();
    let report = diagnosis::diagnose(&body, recording, split, &monitor.part(0.1..1.0))?;
    Ok((report, begin.elapsed().as_secs_f64()))
}

/// The same of whoever follows its advice: while it says that the model fails on what is held out, the next part is held out instead.
pub(super) fn lacking_as_advised(recording: &Recording, monitor: &Monitor) -> Result<(Report, f64), TrialError> {
    let (unusable, mut held_out, mut seconds) = (unusable(recording), HoldOut::default(), 0.0);
    loop {
        let split = Split::as_asked(recording, &held_out, &unusable)?;
        let (report, more) = lacking(recording, &split, monitor)?;
        seconds += more;
        match report.hold_out_next(&held_out, recording) {
            Some(next) => held_out = next,
            None => return Ok((report, seconds)),
        }
    }
}

impl Answered {
    /// Judges a report.
    pub(super) fn new(name: String, truth: &Truth, report: &Report, seconds: f64) -> Answered {
        let names: Vec<Name> = report.effects.iter().flat_map(|named| judged_names(named, report, truth)).collect();
        let wanted: Vec<Wanted> = truth
            .wanted()
            .map(|planted| {
                let judged = names.iter().map(|name| (planted.judge(&name.effect, name.joint), name.confidence));
                let of_it = judged.filter(|(verdict, _)| *verdict >= Verdict::Form);
                let (named, confidence) = of_it.fold((None, 0.0f64), |(best, surest), (verdict, confidence)| {
                    (best.max(Some(verdict)), surest.max(confidence))
                });
                Wanted { effect: planted.effect.clone(), joint: planted.joint, named, confidence }
            })
            .collect();
        let is_clean = names.iter().all(|name| name.verdict.is_good());
        Answered {
            name,
            kind: truth.kind.clone(),
            exact: is_clean && wanted.iter().all(|wanted| wanted.named == Some(Verdict::Right)),
            in_family: is_clean && wanted.iter().all(|wanted| wanted.named.is_some()),
            names,
            wanted,
            asked: report.presence.iter().filter_map(|one| asked(one, truth)).collect(),
            flagged: !report.unexplained_joints.is_empty() || report.verdict == diagnosis::Verdict::UnknownEffect,
            beside_everyday: truth.planted.iter().filter_map(|planted| planted.beside_everyday).reduce(f64::max),
            intervals: report.effects.iter().flat_map(|named| intervals_of(named, truth)).collect(),
            seconds,
        }
    }
}

/// What the held-out part said of a family, and whether it is there, if it was asked and if that is known: of a real log, in which something
/// is assumed, nobody knows that it lacks what nearly every joint has: friction, a torque that is not zero at rest, the inertia of a motor.
fn asked(one: &Presence, truth: &Truth) -> Option<Asked> {
    let (effect, joint) = (one.effect.id.to_owned(), one.joint.map(|joint| joint + 1));
    let is_assumed = |planted: &Planted| planted.assumed && planted.judge(&effect, joint).is_good();
    if truth.planted.iter().any(is_assumed) {
        return None;
    }
    let is_there = truth.judge(&effect, joint).is_good();
    let is_everyday = |other: &&Effect| other.family == one.family && other.facts.everyday;
    if !is_there && registry::sought().iter().any(is_everyday) && truth.planted.iter().any(|planted| planted.assumed) {
        return None;
    }
    one.held_out.map(|held_out| Asked { effect, joint, held_out, is_there })
}

/// The names of an effect at each of its places.
pub(super) fn judged_names(named: &MissingEffect, report: &Report, truth: &Truth) -> Vec<Name> {
    let is_half_step = truth.with_speed && is_short_delay(named);
    let judged = |(effect, place): (String, Option<usize>)| {
        let joint = place.map(|joint| joint + 1);
        let verdict = truth.judge(&effect, joint);
        let verdict = if is_half_step { verdict.max(Verdict::Beside) } else { verdict };
        Name { effect, joint, confidence: report.presence_of(named, place), form: named.form, verdict }
    };
    answer_of(named).into_iter().map(judged).collect()
}

/// Whether it is a delay of the whole arm's readings that is shorter than half a step of a simulation.
fn is_short_delay(named: &MissingEffect) -> bool {
    let is_time = |parameter: &ParameterSpec| parameter.dimension == Dimension::Time;
    let is_delay = named.effect.scope == Scope::Arm && named.effect.parameters.iter().all(is_time);
    is_delay && named.parameters.iter().all(|parameter| parameter.value.abs() < HALF_STEP)
}

/// The intervals of a name where it is right.
fn intervals_of(named: &MissingEffect, truth: &Truth) -> Vec<Interval> {
    let mut intervals = Vec::new();
    for parameter in &named.parameters {
        let joint = parameter.joint.map(|joint| joint + 1);
        let planted = truth.planted.iter().find(|planted| planted.judge(named.effect.id, joint) == Verdict::Right);
        let value = planted.and_then(|planted| planted.parameters.get(&parameter.name));
        if let (Some(&value), Some(interval @ [low, high])) = (value, parameter.interval) {
            let (effect, parameter) = (named.effect.id.to_owned(), parameter.name.clone());
            intervals.push(Interval {
                effect,
                parameter,
                truth: value,
                interval,
                holds: (low..=high).contains(&value),
            });
        }
    }
    intervals
}

impl Summary {
    /// How these fared. Recordings with something outside the catalogue are of the class `unknown`.
    pub fn of(recordings: Vec<Answered>) -> Summary {
        let mut kinds: Vec<&str> = Vec::new();
        for answered in &recordings {
            if !kinds.contains(&answered.kind.as_str()) {
                kinds.push(&answered.kind);
            }
        }
        let of_kind = |kind: &str| recordings.iter().filter(|answered| answered.kind == kind).collect::<Vec<_>>();
        let mut classes: Vec<Class> = kinds.iter().map(|kind| Class::of(kind, &of_kind(kind))).collect();
        let known: Vec<&Answered> = recordings.iter().filter(|answered| answered.kind != UNKNOWN).collect();
        classes.push(Class::of("known", &known));
        classes.push(Class::of("all", &recordings.iter().collect::<Vec<_>>()));
        let names: Vec<&Name> = recordings.iter().flat_map(|answered| &answered.names).collect();
        let sure: Vec<Verdict> = names.iter().filter(|name| name.confidence >= SURE).map(|name| name.verdict).collect();
        let wanted: Vec<bool> =
            recordings.iter().flat_map(|answered| &answered.wanted).map(|wanted| wanted.confidence >= SURE).collect();
        let shows = |answered: &&Answered| {
            answered.kind == UNKNOWN && answered.beside_everyday.is_none_or(|share| share >= SHOWS)
        };
        let showing: Vec<bool> = recordings.iter().filter(shows).map(|answered| answered.flagged).collect();
        let intervals: Vec<bool> =
            recordings.iter().flat_map(|answered| &answered.intervals).map(|interval| interval.holds).collect();
        let confidences: Vec<(f64, bool)> =
            names.iter().map(|name| (name.confidence, name.verdict.is_good())).collect();
        let is_there = |name: &&&Name| name.verdict >= Verdict::Form;
        let forms: Vec<(f64, bool)> =
            names.iter().filter(is_there).map(|name| (name.form, name.verdict == Verdict::Right)).collect();
        let forms = reliability(&forms);
        let reliability = reliability(&confidences);
        Summary {
            classes,
            forms,
            names: names.len(),
            sure_names: sure.len(),
            sure_right: share(sure.iter().map(|verdict| *verdict == Verdict::Right)),
            sure_good: share(sure.iter().map(|verdict| verdict.is_good())),
            wanted: wanted.len(),
            wanted_sure: share(wanted),
            showing: showing.len(),
            showing_flagged: share(showing),
            intervals: intervals.len(),
            coverage: share(intervals),
            calibration_error: calibration_error(&reliability),
            reliability,
            seconds_per_recording: recordings.iter().map(|answered| answered.seconds).sum::<f64>()
                / recordings.len().max(1) as f64,
            seconds_of_slowest: recordings.iter().map(|answered| answered.seconds).fold(0.0, f64::max),
            recordings,
        }
    }
}

/// Something outside the catalogue shows from this share of a joint's torque (RMS) on, in which nothing everyday does the same: what an
/// answer may leave of it without being called incomplete.
pub const SHOWS: f64 = 0.01;

/// The class of recordings with something outside the catalogue.
const UNKNOWN: &str = "unknown";

impl Class {
    fn of(kind: &str, recordings: &[&Answered]) -> Class {
        let wanted = |named: Option<Verdict>| {
            recordings.iter().flat_map(|answered| &answered.wanted).filter(|wanted| wanted.named == named).count()
        };
        let per_recording = |verdicts: &[Verdict]| {
            let names = recordings.iter().flat_map(|answered| &answered.names);
            names.filter(|name| verdicts.contains(&name.verdict)).count() as f64 / recordings.len().max(1) as f64
        };
        Class {
            kind: kind.to_owned(),
            recordings: recordings.len(),
            exact: share(recordings.iter().map(|answered| answered.exact)),
            in_family: share(recordings.iter().map(|answered| answered.in_family)),
            right: wanted(Some(Verdict::Right)),
            form: wanted(Some(Verdict::Form)),
            missed: wanted(None),
            false_names: per_recording(&[Verdict::False, Verdict::WrongJoint]),
            stand_ins: per_recording(&[Verdict::StandIn]),
            flagged: share(recordings.iter().map(|answered| answered.flagged)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::write::to_npz_bytes;
    use crate::simulation::{Excitation, Scenario, simulate};

    /// A recording of our own with Coulomb friction on joint 2, and a file that says so.
    #[test]
    fn a_recording_is_read_diagnosed_and_judged() {
        let mut scenario = Scenario { seed: 11, effects: Vec::new(), ..Scenario::embedded() };
        if let Excitation::MultiSine { trajectories, duration, .. } = &mut scenario.motion {
            (*trajectories, *duration) = (10, 6.0);
        }
        scenario.effects = scenario.hide_by_strength("coulomb-friction", &[1], 0.08).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("000.npz");
        let recording = simulate(&scenario, &Monitor::new()).unwrap();
        std::fs::write(&path, to_npz_bytes(&recording).unwrap()).unwrap();
        let truth = |joint: usize, torque: f64| {
            format!(
                r#"{{"kind": "single", "zero": "up", "with_speed": true, "truth": [{{"effect": "coulomb-friction",
                "joint": {joint}, "strong": true, "equal": [["dahl-hysteresis", {joint}]], "also": [], "unknown": false,
                "absorbed": false, "parameters": {{"coulomb_torque": {torque}}}}}]}}"#
            )
        };
        let torque = scenario.effects[0].parameters[0];
        let foreign = |truth: &str| Foreign::new(path.clone(), truth).unwrap();
        let right = foreign(&truth(2, torque)).run(&Monitor::new()).unwrap();
        assert!(right.exact && right.in_family && !right.flagged, "{right:?}");
        assert_eq!((right.names.len(), right.names[0].verdict, right.names[0].joint), (1, Verdict::Right, Some(2)));
        assert_eq!(right.intervals.iter().map(|interval| interval.holds).collect::<Vec<_>>(), [true]);
        // The same answer, held against other truths.
        let (report, seconds) = foreign(&truth(2, torque)).diagnose(&Monitor::new()).unwrap();
        let answer = |truth: &str| Answered::new("000".to_owned(), &foreign(truth).truth, &report, seconds);
        let another = answer(&truth(2, 2.0 * torque));
        assert_eq!(another.intervals.iter().map(|interval| interval.holds).collect::<Vec<_>>(), [false]);
        let elsewhere = answer(&truth(1, torque));
        assert!(!elsewhere.exact && !elsewhere.in_family && elsewhere.wanted[0].named.is_none());
        assert_eq!(elsewhere.names[0].verdict, Verdict::WrongJoint);
        assert!(elsewhere.intervals.is_empty());
        // Asked about, friction of joint 2 is there; on a joint without it is not, unless it is a real log, where nobody knows.
        let held_out = diagnosis::HeldOut { before: 0.8, rises: 1.2, rises_in_training: 1.1, t: 1.0 };
        let mut presence = *report.presence.iter().find(|one| one.effect.id == "coulomb-friction").unwrap();
        presence.held_out = Some(held_out);
        let mut of_log = foreign(&truth(2, torque)).truth;
        of_log.planted.extend(crate::trial::planted::assumed(&right.names, 4));
        let known = |joint: usize, truth: &Truth| {
            asked(&Presence { joint: Some(joint), ..presence }, truth).map(|asked| asked.is_there)
        };
        assert_eq!([1, 0].map(|joint| known(joint, &foreign(&truth(2, torque)).truth)), [Some(true), Some(false)]);
        assert_eq!([1, 0].map(|joint| known(joint, &of_log)), [None, None]);
        let told = Foreign::new(path.clone(), "{}").unwrap_err().to_string();
        assert!(told.contains("000.json does not say what is hidden") && told.contains("missing field"), "{told}");
    }

    /// Of a drive that lags behind a logged command the catalogue says that the log is early.
    #[test]
    fn a_lag_behind_a_logged_command_is_negative() {
        let lag = |side: &str| {
            let truth = format!(
                r#"{{"kind": "single", "zero": "up", "with_speed": true, "truth": [{{"effect": "actuator-lag", "joint": 2,
                "side": "{side}", "strong": true, "equal": [], "also": [], "unknown": false, "absorbed": false,
                "parameters": {{"lag": 0.02}}}}]}}"#
            );
            Foreign::new(PathBuf::from("000.npz"), &truth).unwrap().truth.planted[0].parameters["lag"]
        };
        assert_eq!((lag("command read"), lag("torque filtered")), (-0.02, 0.02));
    }

    fn answered(kind: &str, names: &[(f64, Verdict)], wanted: &[Option<Verdict>]) -> Answered {
        let name = |&(confidence, verdict): &(f64, Verdict)| Name {
            effect: String::new(),
            joint: None,
            confidence,
            form: 1.0,
            verdict,
        };
        let wanted_as = |&named: &Option<Verdict>| {
            let of_it = names.iter().filter(|(_, verdict)| Some(*verdict) == named);
            let confidence = of_it.map(|(confidence, _)| *confidence).fold(0.0, f64::max);
            Wanted { effect: String::new(), joint: None, named, confidence }
        };
        let is_clean = names.iter().all(|(_, verdict)| verdict.is_good());
        Answered {
            name: String::new(),
            kind: kind.to_owned(),
            exact: is_clean && wanted.iter().all(|named| *named == Some(Verdict::Right)),
            in_family: is_clean && wanted.iter().all(Option::is_some),
            names: names.iter().map(name).collect(),
            wanted: wanted.iter().map(wanted_as).collect(),
            asked: Vec::new(),
            flagged: kind == "unknown",
            beside_everyday: None,
            intervals: Vec::new(),
            seconds: 1.0,
        }
    }

    #[test]
    fn what_is_unknown_counts_as_showing_where_the_everyday_does_not_do_the_same() {
        let unknown = |beside_everyday: Option<f64>, flagged: bool| Answered {
            beside_everyday,
            flagged,
            ..answered("unknown", &[], &[])
        };
        let summary = Summary::of(vec![
            unknown(Some(0.5 * SHOWS), false),
            unknown(Some(2.0 * SHOWS), true),
            unknown(Some(3.0 * SHOWS), false),
            unknown(None, true),
            unknown(None, true),
            answered("single", &[], &[]),
        ]);
        assert_eq!((summary.showing, summary.showing_flagged), (4, Some(0.75)));
    }

    #[test]
    fn classes_are_counted_by_recording_and_by_name() {
        let summary = Summary::of(vec![
            answered("none", &[], &[]),
            answered("none", &[(0.45, Verdict::False)], &[]),
            answered("single", &[(0.95, Verdict::Form), (0.99, Verdict::Beside)], &[Some(Verdict::Form)]),
            answered("single", &[(0.99, Verdict::Right)], &[Some(Verdict::Right), None]),
            answered("single", &[(0.89, Verdict::Right)], &[Some(Verdict::Right)]),
            answered("unknown", &[(0.9, Verdict::StandIn), (0.3, Verdict::StandIn)], &[]),
        ]);
        let kinds: Vec<&str> = summary.classes.iter().map(|class| class.kind.as_str()).collect();
        assert_eq!(kinds, ["none", "single", "unknown", "known", "all"]);
        let [none, single, unknown, known, all] = &summary.classes[..] else { panic!("{kinds:?}") };
        assert_eq!((none.exact, none.in_family, none.false_names), (Some(0.5), Some(0.5), 0.5));
        assert_eq!((single.exact, single.in_family), (Some(1.0 / 3.0), Some(2.0 / 3.0)));
        assert_eq!((single.right, single.form, single.missed), (2, 1, 1));
        assert_eq!((unknown.stand_ins, unknown.flagged, unknown.exact), (2.0, Some(1.0), Some(0.0)));
        assert_eq!((known.recordings, known.in_family, known.flagged), (5, Some(0.6), Some(0.0)));
        assert_eq!((all.recordings, all.false_names), (6, 1.0 / 6.0));
        assert_eq!((summary.names, summary.sure_names), (7, 4));
        assert_eq!((summary.wanted, summary.wanted_sure), (4, Some(0.5)), "one is missed, one at 89 %");
        assert_eq!((summary.sure_right, summary.sure_good), (Some(0.25), Some(0.75)));
        assert_eq!((summary.intervals, summary.coverage), (0, None));
    }
}
