//! What a candidate must pass before it is named. Each gate answers with the reason of its refusal.

use rayon::prelude::*;

use super::selection::{MARGIN, Search};
use crate::effect::Effect;

/// Smallest share of the joint's torque (RMS) that is worth naming.
const LEAST_SHARE: f64 = 0.0025;
/// Left-out blocks must confirm at least this share of the gain.
const CONFIRMED: f64 = 0.5;
/// Least t of the paired gains over the blocks.
const LEAST_T: f64 = 2.5;
/// The same for an effect that nearly every joint has.
const LEAST_T_OF_EVERYDAY: f64 = 1.5;
/// Blocks that must each confirm an effect that shows in few blocks only.
const LEAST_CONFIRMING: usize = 3;
/// Share of the gain of such an effect that the blocks against it may lose.
const MOST_AGAINST: f64 = 0.05;
/// The faster third need not confirm if the slower part holds less than this share of the effect's gain.
const LEAST_SLOW_SHARE: f64 = 0.12;

/// Checks the candidate against the set found so far.
///
/// # Errors
/// The reason, in plain words, of the first gate that it fails.
pub fn check(search: &Search, group: usize) -> Result<(), String> {
    let candidate = &search.library.groups[group];
    let before = &search.active;
    let after = search.with(group);
    let gain = search.cost(before) - search.cost(&after);
    let price = search.price_of(group);
    if gain < MARGIN * price {
        return Err("it explains hardly more than chance would".to_owned());
    }
    let share = torque_share(search, &after, group);
    if share < LEAST_SHARE {
        return Err(format!("its torque is only {:.2} % of the measured torque", 100.0 * share));
    }
    if !is_physical(search, &after, group) {
        return Err("its best parameters have the wrong sign".to_owned());
    }
    if let Some(other) = leaves_it(search, &after, group) {
        return Err(format!("it is no more than what the formula of {other} leaves"));
    }
    let confirmed: f64 = block_gains(search, before, &after).iter().sum();
    if confirmed < CONFIRMED * gain {
        return Err("blocks that were left out do not confirm it".to_owned());
    }
    let is_everyday = candidate.effect.facts.everyday;
    let least_t = if is_everyday { LEAST_T_OF_EVERYDAY } else { LEAST_T };
    if !is_confirmed_by(search, before, &after, least_t) {
        return Err("only a few blocks of the recording speak for it".to_owned());
    }
    // Slow motion alone hardly identifies the body of a large arm; what nearly every joint has needs no such proof.
    if is_everyday { Ok(()) } else { extrapolates(search, before, &after, gain) }
}

/// The effect of the set whose formula is only so exact that it leaves the group.
pub fn leaves_it(search: &Search, set: &[usize], group: usize) -> Option<&'static str> {
    let groups = &search.library.groups;
    let solution = search.solve(set);
    let factors = |group: usize| {
        let offset = offset_of(search, set, group)?;
        Some(&solution.factors.as_slice()[offset..offset + groups[group].columns.len()])
    };
    let (effect, own) = (groups[group].effect, factors(group)?);
    let leaves = |&&other: &&usize| {
        let is_beside = other != group && groups[other].joint == groups[group].joint;
        is_beside && factors(other).is_some_and(|others| effect.is_left_by(own, groups[other].effect, others))
    };
    set.iter().find(leaves).map(|&other| groups[other].effect.name)
}

/// Whether the linear parameters of the group lie within their bounds.
pub fn is_physical(search: &Search, groups: &[usize], group: usize) -> bool {
    let solution = search.solve(groups);
    let Some(offset) = offset_of(search, groups, group) else { return false };
    are_physical(search.library.groups[group].effect, &solution.factors.as_slice()[offset..])
}

/// Whether these linear parameters lie within their bounds, but for rounding.
pub fn are_physical(effect: &Effect, factors: &[f64]) -> bool {
    effect.linear().zip(factors).all(|(parameter, &value)| {
        let tolerance = 1e-9 * value.abs();
        value >= parameter.min - tolerance && value <= parameter.max + tolerance
    })
}

/// Where the group's factors start in a solution of these groups.
fn offset_of(search: &Search, groups: &[usize], group: usize) -> Option<usize> {
    let position = groups.iter().position(|&other| other == group)?;
    let before = groups[..position].iter().map(|&other| search.library.groups[other].columns.len());
    Some(search.library.base + before.sum::<usize>())
}

/// RMS of the group's torque as a share of the RMS of the measured torque, on the joint where it is largest.
fn torque_share(search: &Search, groups: &[usize], group: usize) -> f64 {
    (0..search.weights.len()).map(|joint| share_on(search, groups, group, joint)).fold(0.0, f64::max)
}

/// RMS of the group's torque as a share of the RMS of the measured torque of one joint.
pub fn share_on(search: &Search, groups: &[usize], group: usize, joint: usize) -> f64 {
    let Some(offset) = offset_of(search, groups, group) else { return 0.0 };
    let solution = search.solve(groups);
    let columns: Vec<usize> = search.library.groups[group].columns.clone().collect();
    let factors = nalgebra::DVector::from_fn(columns.len(), |index, _| solution.factors[offset + index]);
    let equations = &search.library.equations;
    let energy: f64 = (0..equations.block_count())
        .map(|block| {
            let gram = &equations.select(block, joint, &columns).gram;
            factors.dot(&(gram * &factors))
        })
        .sum();
    (energy / search.library.design.energy(joint).max(f64::MIN_POSITIVE)).max(0.0).sqrt()
}

/// Whether blocks that were left out prefer the set `after` to `before`, and not few of them only.
pub fn is_confirmed(search: &Search, before: &[usize], after: &[usize]) -> bool {
    is_confirmed_by(search, before, after, LEAST_T)
}

/// The same for this t of the paired gains.
fn is_confirmed_by(search: &Search, before: &[usize], after: &[usize], least_t: f64) -> bool {
    let (gains, shares): (Vec<f64>, Vec<f64>) = left_out_errors(search, before)
        .into_iter()
        .zip(left_out_errors(search, after))
        // The share of the error, too: where another effect is still missing, a few blocks' gains drown all others.
        .map(|(before, after)| (before - after, (before - after) / (before + after).max(f64::MIN_POSITIVE)))
        .unzip();
    gains.len() < 3 || paired_t(&gains) >= least_t || paired_t(&shares) >= least_t || is_unopposed(&gains, search.price)
}

/// How much each block gains from the step from `before` to `after`, fitted on the other blocks.
pub fn block_gains(search: &Search, before: &[usize], after: &[usize]) -> Vec<f64> {
    let errors = left_out_errors(search, before).into_iter().zip(left_out_errors(search, after));
    errors.map(|(before, after)| before - after).collect()
}

/// The error of each block with these groups, fitted on the other blocks; of a single block, fitted on itself.
fn left_out_errors(search: &Search, groups: &[usize]) -> Vec<f64> {
    match search.library.equations.block_count() {
        0 | 1 => vec![search.cost(groups)],
        blocks => (0..blocks).into_par_iter().map(|block| search.error_when(groups, block).1).collect(),
    }
}

/// Mean over its standard error.
pub fn paired_t(gains: &[f64]) -> f64 {
    let count = gains.len() as f64;
    let mean = gains.iter().sum::<f64>() / count;
    let variance = gains.iter().map(|gain| (gain - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
    mean / (variance / count).sqrt().max(f64::MIN_POSITIVE)
}

/// Some effects show in few blocks only (an end stop, where it was reached). They count if several blocks confirm them by
/// themselves and hardly any speaks against.
fn is_unopposed(gains: &[f64], price: f64) -> bool {
    let confirming = gains.iter().filter(|&&gain| gain > price).count();
    let for_it: f64 = gains.iter().map(|gain| gain.max(0.0)).sum();
    let against: f64 = gains.iter().map(|gain| (-gain).max(0.0)).sum();
    confirming >= LEAST_CONFIRMING && against < MOST_AGAINST * for_it
}

/// A real effect, fitted on slow motion, helps on fast motion too.
fn extrapolates(search: &Search, before: &[usize], after: &[usize], gain: f64) -> Result<(), String> {
    let speeds = search.library.design.block_speeds();
    let mut order: Vec<usize> = (0..speeds.len()).collect();
    order.sort_by(|&a, &b| speeds[a].total_cmp(&speeds[b]));
    let (slow, fast) = order.split_at(order.len() * 2 / 3);
    if slow.len() < 2 || fast.is_empty() {
        return Ok(());
    }
    let slow_gain = search.transfer_error(before, slow, slow) - search.transfer_error(after, slow, slow);
    if slow_gain < LEAST_SLOW_SHARE * gain {
        return Ok(());
    }
    if search.transfer_error(after, slow, fast) < search.transfer_error(before, slow, fast) {
        Ok(())
    } else {
        Err("fitted on the slower two thirds of the blocks it does not help on the fastest third".to_owned())
    }
}
