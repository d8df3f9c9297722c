//! Does a name stay where nothing changes but how the log is looked at? The same log is cut into halves, thinned out, held out in
//! other ways and, by whoever can read it again, filtered in other ways.
//!
//! A name that goes is no proof that it was false: half a log shows less than all of it. One that stays only in one way of looking
//! is none to build on.

use std::ops::Range;

use serde::Serialize;

use super::TrialError;
use super::foreign::{Name, lacking};
use super::planted::{assumed, named};
use super::rates::share;
use super::verdict::{Planted, Verdict};
use crate::diagnosis::presence::SURE;
use crate::model::ModelError;
use crate::progress::Monitor;
use crate::recording::split::{Segment, Split};
use crate::recording::{Recording, Trajectory};

/// A name survives that is given in this share of the variants.
const MOST: f64 = 0.8;
/// From here on a name is probable; below, it is only likelier than not.
const PROBABLE: f64 = 0.7;
/// Every how manieth sample is kept in the variants that are thinned out.
const THINNED: [usize; 2] = [2, 4];
/// No variant is thinned out below this rate \[Hz\]: the motion itself needs it.
const LEAST_RATE: f64 = 50.0;
/// Other choices of what is held out, by how many blocks or trajectories they come later.
const TURNS: [usize; 2] = [1, 3];
/// Cut-offs of the filter for derived channels, in units of the one that was used, for whoever can read the log again.
pub const CUTOFFS: [f64; 2] = [0.7, 1.4];

/// A log looked at in another way.
#[derive(Debug, Clone)]
pub struct Variant {
    /// What is different.
    pub name: String,
    /// What the diagnosis sees.
    pub recording: Recording,
    /// Which part trains and which is held out.
    pub split: Split,
}

/// What stays of the names of a log.
#[derive(Debug, Clone, Serialize)]
pub struct Stability {
    /// Each name of the log as it is.
    pub names: Vec<Stays>,
    /// How many of them survive, by how sure it is that something of their kind is there, from sure to doubtful.
    pub classes: Vec<Class>,
    /// The same by how sure it is that they are there in this form.
    pub forms: Vec<Class>,
    /// What each variant says.
    pub variants: Vec<Said>,
}

/// A name and the share of variants that give it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Stays {
    /// The effect's id.
    pub effect: String,
    /// The joint, from 1; none for the whole arm.
    pub joint: Option<usize>,
    /// How sure the diagnosis is, in the log as it is, that something of its kind is there.
    pub confidence: f64,
    /// How sure it is of this form, if it is there.
    pub form: f64,
    /// Share of the variants that give the same name.
    pub same: f64,
    /// Share of the variants that give it or another form of it.
    pub in_some_form: f64,
}

/// Names of about the same confidence.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Class {
    /// The least confidence.
    pub from: f64,
    /// How many names have it.
    pub names: usize,
    /// Share of them that 80 % of the variants give.
    pub survive: Option<f64>,
    /// Share of them that 80 % of the variants give in some form.
    pub survive_in_some_form: Option<f64>,
}

/// What a variant says.
#[derive(Debug, Clone, Serialize)]
pub struct Said {
    /// What is different.
    pub name: String,
    /// What is named there.
    pub names: Vec<Name>,
    /// Names that are no form of any of the log as it is.
    pub others: usize,
    /// Why it could not be asked, if it could not.
    pub problem: Option<String>,
}

/// The variants of a log that need nothing but itself.
pub fn variants(recording: &Recording, split: &Split) -> Vec<Variant> {
    let mut variants = Vec::new();
    for (half, name) in ["first half", "second half"].into_iter().enumerate() {
        let part = |trajectory: &Trajectory| trajectory.len() * half / 2..trajectory.len() * (half + 1) / 2;
        variants.push(cut(recording, split, name, part));
    }
    let fastest = recording.trajectories.iter().map(Trajectory::time_step).fold(f64::INFINITY, f64::min);
    for every in THINNED.into_iter().filter(|every| fastest * LEAST_RATE * *every as f64 <= 1.0 + 1e-9) {
        variants.push(thinned(recording, split, every));
    }
    for (number, turn) in TURNS.into_iter().enumerate() {
        let other = Split::in_turn(recording, turn);
        if other != *split && !other.held_out.is_empty() && !other.train.is_empty() {
            variants.push(Variant {
                name: format!("another part is held out ({})", number + 1),
                recording: recording.clone(),
                split: other,
            });
        }
    }
    variants
}

/// A part of each trajectory.
fn cut(recording: &Recording, split: &Split, name: &str, part: impl Fn(&Trajectory) -> Range<usize>) -> Variant {
    let parts: Vec<Range<usize>> = recording.trajectories.iter().map(part).collect();
    let within = |segment: &Segment| {
        let part = &parts[segment.trajectory];
        let start = segment.samples.start.max(part.start);
        let end = segment.samples.end.min(part.end);
        (start < end).then(|| Segment { samples: start - part.start..end - part.start, ..*segment })
    };
    let runs = recording.trajectories.iter().zip(&parts);
    Variant {
        name: name.to_owned(),
        recording: recording.with_trajectories(runs.map(|(run, part)| run.slice(part.clone())).collect()),
        split: split.changed(within),
    }
}

/// Every so manieth sample.
fn thinned(recording: &Recording, split: &Split, every: usize) -> Variant {
    Variant {
        name: format!("every {} sample", if every == 2 { "second".to_owned() } else { format!("{every}th") }),
        recording: recording.with_trajectories(recording.trajectories.iter().map(|run| run.thinned(every)).collect()),
        split: split.changed(|segment| Some(segment.thinned(every)).filter(|segment| !segment.samples.is_empty())),
    }
}

/// Diagnoses a log as it is, and its variants.
///
/// # Errors
/// [`TrialError`] if the log as it is can't be diagnosed, or somebody stopped it. A variant that can't be says why.
pub fn stability(
    recording: &Recording,
    split: &Split,
    variants: &[Variant],
    monitor: &Monitor,
) -> Result<Stability, TrialError> {
    let part = |number: usize| {
        let share = |number: usize| number as f32 / (variants.len() + 1) as f32;
        monitor.part(share(number)..share(number + 1))
    };
    let names = named(&lacking(recording, split, &part(0))?.0);
    let assumed = assumed(&names, recording.joint_count());
    let mut said = Vec::new();
    for (number, variant) in variants.iter().enumerate() {
        said.push(ask(variant, &assumed, &part(number + 1))?);
    }
    let asked: Vec<&Said> = said.iter().filter(|said| said.problem.is_none()).collect();
    let share_with = |assumed: &Planted, least: Verdict| {
        let gives = |said: &&Said| said.names.iter().any(|name| assumed.judge(&name.effect, name.joint) >= least);
        share(asked.iter().map(gives)).unwrap_or(f64::NAN)
    };
    let stays = |(name, assumed): (Name, &Planted)| Stays {
        effect: name.effect,
        joint: name.joint,
        confidence: name.confidence,
        form: name.form,
        same: share_with(assumed, Verdict::Right),
        in_some_form: share_with(assumed, Verdict::Form),
    };
    let names: Vec<Stays> = names.into_iter().zip(&assumed).map(stays).collect();
    let classes = classes_by(&names, |name| name.confidence);
    Ok(Stability { classes, forms: classes_by(&names, |name| name.confidence * name.form), names, variants: said })
}

/// What a variant says beside the names of the log as it is.
fn ask(variant: &Variant, assumed: &[Planted], monitor: &Monitor) -> Result<Said, TrialError> {
    monitor.report(0.0, &variant.name)?;
    let (names, problem) = match lacking(&variant.recording, &variant.split, monitor) {
        Ok((report, _)) => (named(&report), None),
        Err(TrialError::Stopped(stopped) | TrialError::Model(ModelError::Stopped(stopped))) => {
            return Err(stopped.into());
        }
        Err(error) => (Vec::new(), Some(error.to_string())),
    };
    let is_other = |name: &&Name| assumed.iter().all(|assumed| assumed.judge(&name.effect, name.joint) < Verdict::Form);
    let others = names.iter().filter(is_other).count();
    Ok(Said { name: variant.name.clone(), names, others, problem })
}

/// Sure, probable and hardly likely names, as this says.
fn classes_by(names: &[Stays], sureness: impl Fn(&Stays) -> f64) -> Vec<Class> {
    let ends = [SURE, PROBABLE, 0.0];
    let of_class = |number: usize| {
        let below = if number == 0 { f64::INFINITY } else { ends[number - 1] };
        let own: Vec<&Stays> = names.iter().filter(|name| (ends[number]..below).contains(&sureness(name))).collect();
        Class {
            from: ends[number],
            names: own.len(),
            survive: share(own.iter().map(|name| name.same >= MOST)),
            survive_in_some_form: share(own.iter().map(|name| name.in_some_form >= MOST)),
        }
    };
    (0..ends.len()).map(of_class).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::planted::tests::with_friction;

    /// A log with clear friction.
    fn log() -> (Recording, Split) {
        with_friction(3, 10.0, 100.0, 0.1)
    }

    #[test]
    fn variants_are_the_same_log_in_other_pieces() {
        let (recording, split) = log();
        let variants = variants(&recording, &split);
        let names: Vec<&str> = variants.iter().map(|variant| variant.name.as_str()).collect();
        // At 100 Hz every fourth sample would be too slow.
        let held_out = ["another part is held out (1)", "another part is held out (2)"];
        assert_eq!(names, [&["first half", "second half", "every second sample"], &held_out[..]].concat());
        let size = |segments: &[Segment]| segments.iter().map(|segment| segment.samples.len()).sum::<usize>();
        let [first, second, thinned, other, _] = &variants[..] else { panic!("{names:?}") };
        for part in [|split: &Split| split.train.clone(), |split: &Split| split.held_out.clone()] {
            assert_eq!(size(&part(&first.split)) + size(&part(&second.split)), size(&part(&split)));
        }
        for (run, whole) in recording.trajectories.iter().enumerate() {
            let [first, second, thinned] = [first, second, thinned].map(|variant| &variant.recording.trajectories[run]);
            assert_eq!([first.time.clone(), second.time.clone()].concat(), whole.time);
            assert_eq!([&first.tau[1], &second.tau[1]].concat(), whole.tau[1]);
            assert_eq!((thinned.len(), thinned.tau[0][7]), (whole.len().div_ceil(2), whole.tau[0][14]));
        }
        for variant in &variants {
            variant.recording.verify().unwrap();
            for segment in variant.split.train.iter().chain(&variant.split.held_out) {
                assert!(segment.samples.end <= variant.recording.trajectories[segment.trajectory].len());
            }
        }
        assert_ne!(other.split, split);
    }

    #[test]
    fn clear_friction_stays_and_a_variant_that_can_not_be_asked_says_why() {
        let (recording, split) = log();
        let mut some = variants(&recording, &split);
        some.truncate(3);
        some.remove(1);
        some.push(cut(&recording, &split, "the first samples", |_| 0..6));
        let result = stability(&recording, &split, &some, &Monitor::new()).unwrap();
        let friction = &result.names[0];
        assert_eq!((friction.effect.as_str(), friction.joint), ("coulomb-friction", Some(2)), "{result:?}");
        assert_eq!((friction.same, friction.in_some_form), (1.0, 1.0), "{result:?}");
        let problems: Vec<bool> = result.variants.iter().map(|said| said.problem.is_some()).collect();
        assert_eq!(problems, [false, false, true]);
    }

    #[test]
    fn names_are_counted_by_confidence() {
        let stays = |confidence, same, in_some_form| Stays {
            effect: String::new(),
            joint: None,
            confidence,
            form: if confidence > 0.92 { 0.99 } else { 0.8 },
            same,
            in_some_form,
        };
        let names = [stays(0.95, 1.0, 1.0), stays(0.9, 0.7, 0.8), stays(0.45, 0.5, 0.5)];
        let told = |classes: Vec<Class>| -> Vec<_> {
            classes.iter().map(|class| (class.names, class.survive, class.survive_in_some_form)).collect()
        };
        let by_presence = told(classes_by(&names, |name| name.confidence));
        assert_eq!(by_presence, [(2, Some(0.5), Some(1.0)), (0, None, None), (1, Some(0.0), Some(0.0))]);
        let by_form = told(classes_by(&names, |name| name.confidence * name.form));
        assert_eq!(by_form, [(1, Some(1.0), Some(1.0)), (1, Some(0.0), Some(1.0)), (1, Some(0.0), Some(0.0))]);
    }
}
