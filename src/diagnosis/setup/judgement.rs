//! Which set-up is told, if any.

use super::bench::Fit;
use crate::recording::correction::{Correction, Part};

/// A joint of whose torque's variance a rigid body leaves more than this is doubted.
const FAILS: f64 = 0.005;
/// By so much must a doubted joint's error be divided.
const DECISIVE: f64 = 4.0;
/// More than this must not be left of any joint that it concerns: who has made two mistakes is not told that one of them is all.
const EXPLAINED: f64 = 0.15;
/// The same for gear ratios.
const EXPLAINED_BY_SEARCH: f64 = 0.1;
/// No joint's error may be multiplied by more than this; one that is neither multiplied nor divided by more is not concerned, and may
/// lack an effect (of the wrist of a TX40, whose axes are coupled, a rigid body leaves 16 and 40 % however it is set up).
const WORSE: f64 = 1.5;
/// Errors are not told apart below this: there other things decide.
const FLOOR: f64 = 1e-3;
/// Two set-ups whose gains (sums of logarithms) differ by less explain equally much; the simpler one is told.
const TIE: f64 = 0.4;
/// The same model in other words differs by less.
const SAME: f64 = 0.02;
/// Two that ask to believe as much but for this are equally simple.
const AS_SIMPLE: f64 = 0.05;
/// What a link asks to believe whose weight lies behind its joint.
const BACKWARDS: f64 = 0.3;
/// Fewest folds in which less is left.
const FOLDS_FOR: usize = 4;

/// A set-up that was tried; without corrections it is an effect that could be taken for a mistake, and is never told.
#[derive(Debug, Clone)]
pub(super) struct Trial {
    pub corrections: Vec<Correction>,
    pub fit: Fit,
}

/// What is told.
pub(super) struct Told {
    pub trial: Trial,
    /// The same model in other words, no less simple.
    pub equals: Vec<Trial>,
    /// Whether it is the derivatives that say it.
    pub is_contradiction: bool,
}

impl Told {
    /// What was decided otherwise.
    pub(super) fn of(trial: Trial) -> Told {
        Told { trial, equals: Vec::new(), is_contradiction: false }
    }
}

/// Whether a rigid body fails on a joint.
pub(super) fn fails(stated: &Fit) -> bool {
    stated.errors.iter().any(|error| *error > FAILS)
}

/// Whether it fails, or can't exist.
pub(super) fn is_doubtful(stated: &Fit) -> bool {
    fails(stated) || !stated.impossible.is_empty() || stated.is_turned_over()
}

/// The joint whose error falls by the largest factor among the doubted ones.
pub(super) fn most_mended(stated: &Fit, fit: &Fit) -> usize {
    let mended =
        |joint: usize| (stated.errors[joint].max(FAILS) / FAILS) * fall(stated.errors[joint], fit.errors[joint]);
    (0..stated.errors.len()).max_by(|one, other| mended(*one).total_cmp(&mended(*other))).unwrap_or_default()
}

fn fall(before: f64, after: f64) -> f64 {
    (before + FLOOR) / (after + FLOOR)
}

/// Sum over the joints of the logarithm by which their errors are divided.
fn gain(stated: &Fit, fit: &Fit) -> f64 {
    stated.errors.iter().zip(&fit.errors).map(|(before, after)| fall(*before, *after).ln()).sum()
}

fn is_possible(fit: &Fit) -> bool {
    fit.impossible.is_empty() && !fit.is_turned_over()
}

/// Whether it explains what the stated set-up does not.
fn is_decisive(stated: &Fit, fit: &Fit) -> bool {
    let pairs = || stated.errors.iter().zip(&fit.errors);
    let mends = pairs().any(|(&before, &after)| before > FAILS && fall(before, after) > DECISIVE);
    let explains = explains(stated, fit, EXPLAINED);
    let spoils = pairs().any(|(&before, &after)| after > FAILS && after > WORSE * before);
    let folds = stated.folds.iter().zip(&fit.folds).filter(|(before, after)| after < before).count();
    mends && explains && !spoils && folds >= FOLDS_FOR
}

/// Whether it leaves less than this of every joint that it concerns, and of most of the others: what is wrong with half of the joints is
/// wrong with the set-up.
fn explains(stated: &Fit, fit: &Fit, most: f64) -> bool {
    let left = stated.errors.iter().copied().zip(fit.errors.iter().copied()).filter(|(_, after)| *after >= most);
    let is_concerned = |(before, after): &(f64, f64)| !(before / WORSE..=before * WORSE).contains(after);
    let (concerned, others): (Vec<_>, Vec<_>) = left.partition(is_concerned);
    concerned.is_empty() && 2 * others.len() < fit.errors.len()
}

fn is_searched(correction: &Correction) -> bool {
    matches!(correction, Correction::Factor { part: Part::Motion, .. })
}

/// How much a set-up asks to believe; of equals the least is told.
fn cost(trial: &Trial) -> f64 {
    let of = |correction: &Correction| match correction {
        Correction::Zero { angle } if is_quarter(*angle) => 1.0,
        Correction::Zero { .. } => 2.0,
        Correction::Angles(_) => 1.0,
        Correction::Sign { joints, part } => {
            // A torque has the other sign more often than a motion, and that more often than both.
            let rarer = match part {
                Part::Torque => 0.0,
                Part::Motion => 0.01,
                _ => 0.02,
            };
            1.0 + 0.1 * joints.len() as f64 + rarer
        }
        Correction::Offset { joints, .. } => 1.1 + 0.1 * joints.len() as f64,
        Correction::Order { order, .. } => {
            let moved = order.iter().enumerate().filter(|(place, from)| place != *from).count();
            1.0 + 0.1 * moved as f64
        }
        Correction::Factor { joints, .. } => 1.3 + 0.1 * joints.len() as f64,
        Correction::Delay { .. } => 1.5,
        Correction::Play { .. } => 2.0,
    };
    let backwards = if trial.fit.links[0] > 0 { trial.fit.links[1] } else { 0 };
    trial.corrections.iter().map(of).sum::<f64>() + BACKWARDS * backwards as f64
}

fn is_quarter(angle: f64) -> bool {
    let quarters = angle / std::f64::consts::FRAC_PI_2;
    (quarters - quarters.round()).abs() < 1e-9
}

/// Those that can exist and explain what a set-up does not.
pub(super) fn answers(stated: &Fit, trials: Vec<Trial>) -> Vec<Trial> {
    let as_good = |fit: &Fit| !is_possible(stated) && gain(stated, fit) > -SAME;
    let is_answer = |trial: &Trial| {
        // A search over many numbers always finds something.
        let is_sound = !trial.corrections.iter().any(is_searched) || explains(stated, &trial.fit, EXPLAINED_BY_SEARCH);
        is_sound && (is_decisive(stated, &trial.fit) || as_good(&trial.fit))
    };
    trials.into_iter().filter(|trial| is_possible(&trial.fit) && is_answer(trial)).collect()
}

/// The best that another direction of the first link alone does, or the set-up as it is stated: what two mistakes have to beat, the one
/// of which is the direction.
pub(super) fn best_direction(stated: &Fit, trials: &[Trial]) -> Fit {
    let is_direction = |trial: &&Trial| matches!(trial.corrections[..], [Correction::Zero { .. }]);
    let directions = trials.iter().filter(is_direction).filter(|trial| is_possible(&trial.fit)).map(|trial| &trial.fit);
    let best = directions.max_by(|one, other| gain(stated, one).total_cmp(&gain(stated, other)));
    best.filter(|best| gain(stated, best) > 0.0).unwrap_or(stated).clone()
}

/// Of the answers the one that is decisively better than everything else.
pub(super) fn decided(stated: &Fit, answers: Vec<Trial>) -> Option<Told> {
    simplest(stated, answers, false)
}

/// What ends a contradiction of the derivatives and makes nothing worse.
pub(super) fn settled(stated: &Fit, trials: Vec<Trial>) -> Option<Told> {
    let is_harmless = |fit: &Fit| gain(stated, fit) > -TIE && fit.impossible.len() <= stated.impossible.len();
    simplest(stated, trials.into_iter().filter(|trial| is_harmless(&trial.fit)).collect(), true)
}

/// The simplest of those that explain as much as the best; `None` if that is an effect, or another that is as simple is another
/// model.
fn simplest(stated: &Fit, trials: Vec<Trial>, is_contradiction: bool) -> Option<Told> {
    let gain = |trial: &Trial| gain(stated, &trial.fit);
    let best = trials.iter().map(gain).fold(f64::NEG_INFINITY, f64::max);
    let mut near: Vec<Trial> = trials.into_iter().filter(|trial| gain(trial) > best - TIE).collect();
    near.sort_by(|one, other| {
        let cost = cost(one).total_cmp(&cost(other));
        cost.then(gain(other).total_cmp(&gain(one)))
    });
    let mut near = near.into_iter();
    let trial = near.next()?;
    let least = cost(&trial) + AS_SIMPLE;
    let as_simple: Vec<Trial> = near.take_while(|other| cost(other) <= least).collect();
    let (equals, others): (Vec<Trial>, Vec<Trial>) =
        as_simple.into_iter().partition(|other| (gain(other) - gain(&trial)).abs() < SAME);
    let is_told = others.is_empty() && !trial.corrections.is_empty();
    is_told.then_some(Told { trial, equals, is_contradiction })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fit(errors: &[f64], folds: &[f64]) -> Fit {
        Fit { errors: errors.to_vec(), folds: folds.to_vec(), impossible: Vec::new(), links: [1, 0] }
    }

    #[test]
    fn a_set_up_decides_where_it_mends_what_fails_and_spoils_nothing() {
        let [well, badly] = [0.5 * EXPLAINED, 2.0 * DECISIVE * EXPLAINED];
        let (stated, before, after) = (fit(&[badly, well], &[1.0; 5]), [1.0; 5], [0.1; 5]);
        assert!(is_decisive(&stated, &fit(&[well, well], &after)));
        assert!(!is_decisive(&fit(&[well, well], &before), &fit(&[well, well], &after)), "it mends nothing");
        assert!(!is_decisive(&stated, &fit(&[well, 1.1 * EXPLAINED], &after)), "a joint is not explained");
        let [lacking, still] = [[badly, well, 0.4], [well, well, 0.38]].map(|errors| fit(&errors, &after));
        assert!(
            is_decisive(&Fit { folds: vec![1.0; 5], ..lacking.clone() }, &still),
            "the last joint lacks something else"
        );
        let [lacking, still] = [[badly, 0.3, 0.4], [well, 0.3, 0.38]].map(|errors| fit(&errors, &after));
        assert!(!is_decisive(&Fit { folds: vec![1.0; 5], ..lacking }, &still), "most joints do");
        assert!(!is_decisive(&stated, &fit(&[well, 0.9 * EXPLAINED], &after)), "a joint is spoiled");
        assert!(!is_decisive(&stated, &fit(&[well, well], &before)), "no fold is better");
    }

    #[test]
    fn what_is_searched_for_has_to_explain_all() {
        let [least, more] = [0.9, 1.1].map(|times| times * EXPLAINED_BY_SEARCH);
        let before = fit(&[0.9, 0.9], &[]);
        let explains = |errors: [f64; 2]| explains(&before, &fit(&errors, &[]), EXPLAINED_BY_SEARCH);
        assert!(explains([least, least]) && !explains([least, more]));
        let [stated, better] = [fit(&[0.4, 0.2], &[]), fit(&[0.04, 0.2], &[])];
        let expected = ((0.4 + FLOOR) / (0.04 + FLOOR)).ln();
        assert!((gain(&stated, &better) - expected).abs() < 1e-12 && gain(&stated, &stated) == 0.0);
        let upside_down = Fit { links: [0, 2], ..stated.clone() };
        assert!(is_possible(&stated) && !is_possible(&upside_down));
        assert!(!is_possible(&Fit { impossible: vec![1], ..stated }));
    }
}
