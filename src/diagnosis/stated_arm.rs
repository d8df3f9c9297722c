//! Effects that the base parameters absorb, found by holding the identified parameters against the stated ones.
//!
//! A payload that never changes moves the base parameters and leaves no residual. Where the recording states its arm, the
//! difference can be seen: with the rigid body held at the stated parameters the error is larger than with free ones, and
//! an absorbed effect is named if it alone explains that difference.

use super::candidates::Library;
use super::search::{MARGIN, Search};
use crate::arm::Arm;
use crate::model::least_squares::NormalEquations;
use crate::model::{Model, RigidBody, Term};

/// Smallest share of the torque (RMS) by which the two must differ: less is what filters and encoders make.
const LEAST_SHARE: f64 = 0.005;
/// Share of the difference that may remain unexplained.
const REMAINDER: f64 = 0.05;

/// What the comparison with the stated arm says.
#[derive(Debug, Clone, PartialEq)]
pub enum Comparison {
    /// There is no stated arm, or the model does not identify a rigid body.
    NotPossible,
    /// Identified and stated parameters agree within their errors.
    Agrees,
    /// These groups explain the difference.
    Explained(Vec<usize>),
    /// No absorbed effect explains the difference.
    Differs,
}

/// Compares identified and stated base parameters, beside the effects found so far.
pub fn compare(search: &Search, model: &Model, arm: Option<&Arm>, absorbed: &[usize]) -> Comparison {
    let identifies = model.terms.first() == Some(&Term::RigidBody(RigidBody::Identified));
    let Some(arm) = arm.filter(|_| identifies) else { return Comparison::NotPossible };
    let stated = arm.lumped_parameters();
    if stated.len() > search.library.base {
        return Comparison::NotPossible;
    }
    let free = search.cost(&search.active);
    let pinned = |extra: &[usize]| pinned_cost(search, &stated, extra);
    let difference = pinned(&[]) - free;
    let mut found: Vec<usize> = Vec::new();
    let mut cost = pinned(&[]);
    let share = (difference.max(0.0) / search.equations_of(&[]).energy.max(f64::MIN_POSITIVE)).sqrt();
    if difference < MARGIN * search.price || share < LEAST_SHARE {
        return Comparison::Agrees;
    }
    while found.len() < absorbed.len() {
        let open = absorbed.iter().copied().filter(|group| !found.contains(group));
        let with = |group: usize| {
            let mut groups = found.clone();
            groups.push(group);
            groups
        };
        let best = open
            .filter(|&group| is_physical(search, &stated, &with(group)))
            .map(|group| (group, pinned(&with(group))))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((group, better)) = best else { break };
        let price = search.library.groups[group].parameter_count() as f64 * search.price;
        // The same for each further one: what is less is as well an error of the body that was found.
        if cost - better < MARGIN * price || (!found.is_empty() && cost - better < REMAINDER * difference) {
            break;
        }
        found.push(group);
        cost = better;
    }
    let remainder = cost - free;
    let price = stated.len() as f64 * search.price;
    if remainder > REMAINDER * difference && remainder > MARGIN * price {
        return Comparison::Differs;
    }
    if found.is_empty() { Comparison::Agrees } else { Comparison::Explained(found) }
}

/// How much worse it gets if `rival` stands for `group` beside the stated arm.
pub fn rival_cost(search: &Search, arm: &Arm, found: &[usize], group: usize, rival: usize) -> f64 {
    let stated = arm.lumped_parameters();
    let swapped: Vec<usize> = found.iter().map(|&other| if other == group { rival } else { other }).collect();
    pinned_cost(search, &stated, &swapped) - pinned_cost(search, &stated, found)
}

/// Weighted squared error with the rigid body held at the stated parameters, beside the effects found and `extra`.
fn pinned_cost(search: &Search, stated: &[f64], extra: &[usize]) -> f64 {
    pinned_equations(search, stated, extra).solve().residual_energy
}

fn is_physical(search: &Search, stated: &[f64], extra: &[usize]) -> bool {
    let solution = pinned_equations(search, stated, extra).solve();
    let Library { groups, .. } = &search.library;
    let mut factors = solution.factors.iter().rev();
    extra.iter().rev().all(|&group| {
        let parameters: Vec<_> = groups[group].effect.linear().collect();
        parameters
            .iter()
            .rev()
            .zip(factors.by_ref())
            .all(|(parameter, &value)| (parameter.min..=parameter.max).contains(&value))
    })
}

/// The equations of everything but the rigid body, whose torque is taken as known: y − Yβ stands for y.
fn pinned_equations(search: &Search, stated: &[f64], extra: &[usize]) -> NormalEquations {
    let mut groups = search.active.clone();
    groups.extend(extra);
    let all = search.equations_of(&groups);
    let body = stated.len();
    let beta = nalgebra::DVector::from_row_slice(stated);
    let rest: Vec<usize> = (body..all.moment.len()).collect();
    let mut pinned = all.select(&rest);
    let known = all.gram.view((0, 0), (body, body)) * &beta;
    pinned.energy += beta.dot(&known) - 2.0 * beta.dot(&all.moment.rows(0, body));
    pinned.moment -= all.gram.view((body, 0), (rest.len(), body)) * &beta;
    pinned
}
