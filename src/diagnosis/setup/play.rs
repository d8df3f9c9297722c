//! Whether a gear has play behind the motor whose angle was read.
//!
//! No other mistake of a set-up explains only a part of what is left, so this one is judged for itself: it is told if every part of the
//! log is predicted better with it, no joint worse, and its own by more than with a gear that twists.

use rayon::prelude::*;

use super::bench::{Bench, Fit};
use super::hypotheses::{golden, is_planar};
use super::judgement::{Trial, fails};
use crate::progress::{Monitor, Stopped};
use crate::recording::correction::{Correction, Play};

/// The error of its joint must fall to this share (variance). DFKI's pendulum, whose joint 1 has play, comes to 0.77 (five runs) and 0.64
/// (the first four); of the 81 joints of the forty recordings of another engine that were asked one comes to 0.74, with a gap of 46°, and
/// the next to 0.94 (`torquescope inspect`, 2026-11-29).
const FALLS_TO: f64 = 0.9;
/// A gear with more play than this is broken, or none \[rad\].
const WIDEST: f64 = 0.035;
/// No other joint's error may rise by more than this.
const WORSE: f64 = 1.05;
/// Looked for is friction before the gear of these shares of the joint's torque (RMS), and these times of crossing \[s\].
const FRICTIONS: [f64; 5] = [0.0, 0.15, 0.3, 0.45, 0.6];
const CROSSING_TIMES: [f64; 3] = [0.02, 0.035, 0.06];
/// Whether it is worth a search these shapes say, on a part of the log of so many samples: with one of them the error has to fall to this.
const FIRST_FRICTIONS: [f64; 2] = [0.0, 0.3];
const FIRST_CROSSING_TIMES: [f64; 1] = [0.035];
const MOST_AT_FIRST: usize = 9_000;
const WORTH_A_SEARCH: f64 = 0.97;
/// The error is a parabola of the gap, which is drawn through this \[rad\], its opposite and none.
const UNIT: f64 = 0.003;
/// The best gap lies within so many times the lowest point of that.
const REACH: f64 = 3.0;

/// The joint whose gear has play, with the play that explains most; `None` if none has, or it is not an arm in a plane.
pub(super) fn found(bench: &Bench, stated: &Fit, monitor: &Monitor) -> Result<Option<Trial>, Stopped> {
    if !fails(stated) || !is_planar(&bench.thin) {
        return Ok(None);
    }
    let Some(part) = bench.short(MOST_AT_FIRST) else { return Ok(None) };
    let Some(of_part) = part.stated() else { return Ok(None) };
    let mut trials: Vec<(f64, Trial)> = Vec::new();
    for joint in 0..bench.thin.joint_count() {
        let first = At { bench: &part, joint, stated: of_part.errors[joint] };
        let is_worth_it = |found: Option<(Play, f64)>| found.is_some_and(|(_, share)| share < WORTH_A_SEARCH);
        if !is_worth_it(first.lowest(&FIRST_FRICTIONS, &FIRST_CROSSING_TIMES, monitor)?) {
            continue;
        }
        let at = At { bench, joint, stated: stated.errors[joint] };
        trials.extend(at.trial(stated, monitor)?.map(|trial| (at.share(&trial.fit), trial)));
    }
    Ok(trials.into_iter().min_by(|one, other| one.0.total_cmp(&other.0)).map(|(_, trial)| trial))
}

/// A joint on a bench, and its error as the log is set up.
struct At<'a> {
    bench: &'a Bench,
    joint: usize,
    stated: f64,
}

impl At<'_> {
    /// The play that explains most, if it is to be told.
    fn trial(&self, stated: &Fit, monitor: &Monitor) -> Result<Option<Trial>, Stopped> {
        let Some((play, _)) = self.lowest(&FRICTIONS, &CROSSING_TIMES, monitor)? else { return Ok(None) };
        let share = |gap: f64| {
            monitor.check()?;
            let fit = self.with(&Play { gap, ..play });
            Ok::<f64, Stopped>(fit.map_or(f64::INFINITY, |fit| self.share(&fit)))
        };
        let play = rounded(Play { gap: golden([0.0, REACH * play.gap], share)?, ..play });
        let Some(fit) = self.with(&play) else { return Ok(None) };
        let is_better = fit.folds.iter().zip(&stated.folds).all(|(with, without)| with < without);
        let spoils = fit.errors.iter().zip(&stated.errors).any(|(with, without)| *with > WORSE * without);
        let is_told = self.share(&fit) < FALLS_TO && play.gap < WIDEST && is_better && !spoils;
        if !is_told || self.twists(&play, self.share(&fit)) {
            return Ok(None);
        }
        Ok(Some(Trial { corrections: vec![Correction::Play { joint: self.joint, play }], fit }))
    }

    /// Of these shapes the one with which the error can fall most, with its gap and the share to which it falls.
    fn lowest(
        &self,
        frictions: &[f64],
        crossing_times: &[f64],
        monitor: &Monitor,
    ) -> Result<Option<(Play, f64)>, Stopped> {
        let size = self.torque();
        let shapes: Vec<Play> = frictions
            .iter()
            .flat_map(|share| {
                let of = move |&crossing_time: &f64| Play { gap: UNIT, friction: share * size, crossing_time };
                crossing_times.iter().map(of)
            })
            .collect();
        let of_shape = |play: Play| {
            monitor.check()?;
            let share = |gap: f64| self.with(&Play { gap, ..play }).map(|fit| self.share(&fit));
            let found = parabola(share(UNIT), share(-UNIT)).filter(|[times, _]| *times > 0.0);
            Ok::<_, Stopped>(found.map(|[times, share]| (Play { gap: times * UNIT, ..play }, share)))
        };
        let found = shapes.into_par_iter().map(of_shape).collect::<Result<Vec<_>, Stopped>>()?;
        Ok(found.into_iter().flatten().min_by(|one, other| one.1.total_cmp(&other.1)))
    }

    /// Whether a gear that twists explains as much.
    fn twists(&self, play: &Play, share: f64) -> bool {
        let size = UNIT / self.torque();
        let with = |compliance: f64| {
            let fit = self.bench.changed(|run| play.take_twist_out(run, self.joint, compliance));
            fit.map(|fit| self.share(&fit))
        };
        parabola(with(size), with(-size)).is_some_and(|[times, lowest]| times > 0.0 && lowest < share)
    }

    /// RMS of the joint's torque.
    fn torque(&self) -> f64 {
        let torque = || self.bench.thin.trajectories.iter().flat_map(|run| &run.tau[self.joint]);
        (torque().map(|tau| tau.powi(2)).sum::<f64>() / torque().count().max(1) as f64).sqrt()
    }

    fn with(&self, play: &Play) -> Option<Fit> {
        self.bench.changed(|run| play.take_out(run, self.joint))
    }

    /// What is left of the joint, as a share of what is left as the log is set up.
    fn share(&self, fit: &Fit) -> f64 {
        fit.errors[self.joint] / self.stated
    }
}

/// Where a parabola is lowest that is 1 at 0, and how low, from its values at 1 and −1.
fn parabola(more: Option<f64>, less: Option<f64>) -> Option<[f64; 2]> {
    let (slope, bend) = ((more? - less?) / 2.0, (more? + less?) / 2.0 - 1.0);
    (bend > 0.0).then(|| [-slope / (2.0 * bend), 1.0 - slope.powi(2) / (4.0 * bend)])
}

/// With as many digits as it is known to.
fn rounded(play: Play) -> Play {
    let short = |value: f64| format!("{value:.2e}").parse().unwrap_or(value);
    Play {
        gap: short(play.gap.to_degrees()).to_radians(),
        friction: short(play.friction),
        crossing_time: play.crossing_time,
    }
}
