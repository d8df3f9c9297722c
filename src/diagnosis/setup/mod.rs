//! Is the log set up right? Before effects are looked for: where q = 0 points, which way joints turn, which column is whose.
//!
//! A wrong set-up looks like missing physics, and no effect mends it. [`check`] asks only where the rigid body, beside what
//! every joint has, fails (or could not exist): then it tries what may be wrong, and tells it if it explains decisively
//! more, on samples that the fit has not seen, than the set-up as stated and than everything else that was tried. Where two
//! explanations can't be told apart, or none is decisive, nothing is told: a false alarm is worse than a miss.
//!
//! `bench` fits a set-up, `hypotheses` lists what may be wrong, `kinematics` what the derivatives say by themselves,
//! `judgement` decides. `play` asks whether a gear has play behind the motor whose angle was read, which explains a part only, and `gain`
//! what a current is worth where the masses are stated.

mod bench;
mod gain;
mod hypotheses;
mod judgement;
mod kinematics;
mod play;

use rayon::prelude::*;

use bench::{Bench, Fit};
pub use gain::gains;
use judgement::{Told, Trial};

use crate::progress::{Monitor, Stopped};
use crate::recording::correction::Correction;
use crate::recording::finding::{Finding, FindingKind, Place, Severity};
use crate::recording::{Recording, joints_text};

/// What is set up wrongly, as a finding that knows how to set it right; none if everything is right or can't be told. `found` is
/// what was found already.
///
/// # Errors
/// [`Stopped`] if the work was stopped.
pub fn check(recording: &Recording, found: &[Finding], monitor: &Monitor) -> Result<Option<Finding>, Stopped> {
    if found.iter().any(|finding| finding.kind == FindingKind::NotPlanar) {
        return Ok(None);
    }
    let Some(bench) = Bench::of(recording) else { return Ok(None) };
    let Some(stated) = bench.stated() else { return Ok(None) };
    monitor.check()?;
    let settling = kinematics::corrections(&bench.pieces, found);
    if !settling.is_empty() {
        let trials = tried(&bench, settling.into_iter().map(|correction| vec![correction]).collect(), monitor)?;
        return Ok(judgement::settled(&stated, trials).map(|told| finding(&stated, &told)));
    }
    if !judgement::is_doubtful(&stated) {
        return Ok(None);
    }
    let trials = single(&bench, monitor)?;
    let best_direction = judgement::best_direction(&stated, &trials);
    let mut answers = judgement::answers(&stated, trials);
    let told = judgement::decided(&stated, answers.clone());
    let is_explained = told.as_ref().is_some_and(|told| !judgement::fails(&told.trial.fit));
    let has_direction = !recording.is_weightless();
    let may_point_elsewhere = has_direction
        && !recording.states_zero()
        && hypotheses::is_planar(&bench.thin)
        && hypotheses::far(&bench.thin).is_empty();
    if is_explained || !may_point_elsewhere {
        return told_or_play(&bench, &stated, told, monitor);
    }
    // Nothing says where the arm points, so that may be wrong beside something else.
    let also = hypotheses::other_directions(&bench).flat_map(|zero| {
        let beside = hypotheses::listed(&bench).into_iter().filter(|other| !matches!(other, Correction::Zero { .. }));
        beside.map(|other| vec![zero.clone(), other]).collect::<Vec<_>>()
    });
    answers.extend(judgement::answers(&best_direction, tried(&bench, also.collect(), monitor)?));
    told_or_play(&bench, &stated, judgement::decided(&stated, answers), monitor)
}

/// What is set up wrongly; if nothing is, the gear that has play.
fn told_or_play(
    bench: &Bench,
    stated: &Fit,
    told: Option<Told>,
    monitor: &Monitor,
) -> Result<Option<Finding>, Stopped> {
    let told = match told {
        None => play::found(bench, stated, monitor)?.map(Told::of),
        told => told,
    };
    Ok(told.map(|told| finding(stated, &told)))
}

/// Everything that may be wrong alone. Where joints reach too far nothing else than that is: no other answer would mend it.
fn single(bench: &Bench, monitor: &Monitor) -> Result<Vec<Trial>, Stopped> {
    let alone = |corrections: Vec<Correction>| corrections.into_iter().map(|correction| vec![correction]).collect();
    let far = hypotheses::far(&bench.thin);
    if !far.is_empty() {
        return tried(bench, alone(hypotheses::gears(bench, &far, monitor)?), monitor);
    }
    let mut corrections = hypotheses::listed(bench);
    if hypotheses::is_planar(&bench.thin) {
        corrections.extend(hypotheses::free_zero(bench, monitor)?);
    }
    let mut late = None;
    if let Some((delay, seconds)) = hypotheses::delay(bench, monitor)? {
        corrections.push(delay);
        late = hypotheses::lag(bench, seconds);
    }
    let mut trials = tried(bench, alone(corrections), monitor)?;
    trials.extend(late.map(|fit| Trial { corrections: Vec::new(), fit }));
    Ok(trials)
}

fn tried(bench: &Bench, set_ups: Vec<Vec<Correction>>, monitor: &Monitor) -> Result<Vec<Trial>, Stopped> {
    let trial = |corrections: Vec<Correction>| {
        monitor.check()?;
        Ok(bench.corrected(&corrections).map(|fit| Trial { corrections, fit }))
    };
    let trials: Result<Vec<Option<Trial>>, Stopped> = set_ups.into_par_iter().map(trial).collect();
    Ok(trials?.into_iter().flatten().collect())
}

fn finding(stated: &Fit, told: &Told) -> Finding {
    let Told { trial, equals, is_contradiction } = told;
    let fault = faults(&trial.corrections);
    let what = if *is_contradiction {
        format!("derivatives contradict each other, and agree if {fault}.")
    } else if !judgement::fails(stated) && !stated.impossible.is_empty() {
        let joints = joints_text(&stated.impossible);
        format!(
            "as the log is set up, {joints} would have a negative inertia or push on when moved; that ends if {fault}."
        )
    } else if !judgement::fails(stated) {
        format!("as the log is set up, the links would weigh less than nothing; they weigh something if {fault}.")
    } else {
        let joint = judgement::most_mended(stated, &trial.fit);
        let [before, after] = [stated, &trial.fit].map(|fit| percent(fit.errors[joint]));
        let joint = joints_text(&[joint]);
        format!(
            "as the log is set up, a rigid body leaves {before} of the torque of {joint} unexplained, and {after} if {fault}."
        )
    };
    let options: Vec<String> =
        trial.corrections.iter().map(|correction| format!("`--set-right {correction}`")).collect();
    let others: Vec<String> = equals.iter().map(|other| faults(&other.corrections)).collect();
    let also = if others.is_empty() {
        String::new()
    } else {
        format!(" (This log can't tell it from: {}; the model comes out the same.)", others.join("; "))
    };
    // A gear that has play is no mistake.
    let is_play = matches!(trial.corrections[..], [Correction::Play { .. }]);
    Finding {
        severity: if is_play { Severity::Warning } else { Severity::Error },
        kind: FindingKind::SetUp,
        what,
        place: Place::default(),
        remedy: format!("Set it right with {}.{also}", options.join(" ")),
        set_right: trial.corrections.clone(),
    }
}

fn faults(corrections: &[Correction]) -> String {
    corrections.iter().map(Correction::fault).collect::<Vec<_>>().join(" and ")
}

/// A share in per cent, with the digits that say something.
fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    let digits = match percent {
        10.0.. => 0,
        0.1.. => 1,
        _ => 3,
    };
    format!("{percent:.digits$} %")
}

#[cfg(test)]
mod tests;
