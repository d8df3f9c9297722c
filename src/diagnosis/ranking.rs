//! All candidates side by side: what each would gain alone, and why it is part of the answer or not.

use std::collections::BTreeMap;

use nalgebra::DVector;
use rayon::prelude::*;

use super::candidates::Group;
use super::heard::Heard;
use super::report::{Candidate, Ground, HeldOut, Refusal};
use super::search::{FEWEST_BLOCKS, Search};
use super::stated_arm::Comparison;
use super::withdrawn::Withdrawn;
use crate::model::ModelError;
use crate::progress::Monitor;

/// Cross-validated drop of the squared residual by each candidate alone, by group. Of the shapes of an effect at a place
/// only the one that fits best is measured; the others get what it gets.
pub fn error_drops(search: &Search, monitor: &Monitor) -> Result<Vec<f64>, ModelError> {
    let groups = &search.library.groups;
    let errors = |set: &[usize], joints: &[Option<usize>]| -> Vec<f64> {
        let columns = search.columns(set);
        let fits = search.left_out_fits(set);
        let on_joint = |block: usize, joint: usize, factors: &DVector<f64>| {
            search.library.equations.select(block, joint, &columns).residual_energy(factors)
        };
        let error = |joint: &Option<usize>| {
            let of_block = |(block, (factors, weighted)): (usize, &(DVector<f64>, f64))| {
                joint.map_or(*weighted, |joint| on_joint(block, joint, factors))
            };
            fits.iter().enumerate().map(of_block).sum()
        };
        joints.iter().map(error).collect()
    };
    let places: Vec<Option<usize>> = (0..search.weights.len()).map(Some).chain([None]).collect();
    let alone: BTreeMap<Option<usize>, f64> = places.iter().copied().zip(errors(&[], &places)).collect();
    let is_first = |&group: &usize| groups[..group].iter().all(|other| !other.same_place_and_effect(&groups[group]));
    let firsts: Vec<usize> = (0..groups.len()).filter(is_first).collect();
    let drop_of = |&first: &usize| {
        monitor.check()?;
        let same = (first..groups.len()).filter(|&other| groups[other].same_place_and_effect(&groups[first]));
        let costs = same.map(|other| (other, search.cost(&[other])));
        let best = costs.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(first, |(best, _)| best);
        let alone = alone.get(&groups[first].joint).copied().unwrap_or(0.0);
        Ok(if alone > 0.0 { 1.0 - errors(&[best], &[groups[first].joint])[0] / alone } else { 0.0 })
    };
    let drops = firsts.par_iter().map(drop_of).collect::<Result<Vec<f64>, ModelError>>()?;
    let of_group = |group: &Group| {
        let first = firsts.iter().position(|&first| groups[first].same_place_and_effect(group));
        first.map_or(0.0, |first| drops[first])
    };
    Ok(groups.iter().map(of_group).collect())
}

/// Groups beside what was found, each with what was `heard` of its family.
pub fn supported(search: &Search, beside: &[usize], heard: &[Heard]) -> Vec<(usize, HeldOut)> {
    let of_group = |&group: &usize| {
        let Group { effect, joint, .. } = &search.library.groups[group];
        Heard::find(heard, effect.family, *joint).map(|one| (group, one.held_out))
    };
    beside.iter().filter_map(of_group).collect()
}

/// All candidates, one line for each effect and joint: first those that are part of the answer, then by their error drop.
pub fn rank(
    search: &Search,
    drops: &[f64],
    refused: &[(usize, Refusal)],
    doubtful: &[(usize, f64)],
    supported: &[(usize, HeldOut)],
    withdrawn: &[Withdrawn],
    comparison: &Comparison,
) -> Vec<Candidate> {
    let groups = &search.library.groups;
    let blocks = search.library.equations.block_count();
    let explained: &[usize] = if let Comparison::Explained(found) = comparison { found } else { &[] };
    let mut ranking: Vec<Candidate> = Vec::new();
    for (index, group) in groups.iter().enumerate() {
        let is_first = groups[..index].iter().all(|other| !other.same_place_and_effect(group));
        if !is_first {
            continue;
        }
        let same = |other: &usize| groups[*other].same_place_and_effect(group);
        let is_withdrawn = |one: &&Withdrawn| one.effect == group.effect && one.joint == group.joint;
        let ground = if let Some(withdrawn) = withdrawn.iter().find(is_withdrawn) {
            withdrawn.ground
        } else if let Some((_, held_out)) = supported.iter().find(|(other, _)| same(other)) {
            Ground::Supported(*held_out)
        } else if search.active.iter().any(same) {
            if blocks < FEWEST_BLOCKS { Ground::NotConfirmable { blocks } } else { Ground::Confirmed }
        } else if explained.iter().any(same) {
            Ground::TellsFromStatedArm
        } else if search.absorbed.iter().any(same) {
            Ground::AbsorbedByBody
        } else if let Some((_, presence)) = doubtful.iter().find(|(other, _)| same(other)) {
            Ground::Doubtful { presence: *presence }
        } else if let Some((_, refusal)) = refused.iter().find(|(other, _)| same(other)) {
            Ground::Refused(*refusal)
        } else if search.active.iter().any(|&other| groups[other].includes(group)) {
            Ground::Contained
        } else {
            Ground::Superfluous
        };
        let error_drop = (index..groups.len()).filter(same).map(|other| drops[other]).fold(f64::NEG_INFINITY, f64::max);
        ranking.push(Candidate { effect: group.effect, joint: group.joint, error_drop, ground });
    }
    ranking.sort_by(|a, b| b.accepted().cmp(&a.accepted()).then(b.error_drop.total_cmp(&a.error_drop)));
    ranking
}
