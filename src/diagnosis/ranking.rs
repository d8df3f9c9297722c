//! All candidates side by side: what each would gain alone, and why it is part of the answer or not.

use std::collections::BTreeMap;

use nalgebra::DVector;
use rayon::prelude::*;

use super::candidates::Group;
use super::heard::Heard;
use super::report::{Candidate, Ground, HeldOut, NotKnown, Refusal};
use super::search::{FEWEST_BLOCKS, Search, Unseen};
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
    let firsts = search.library.firsts();
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

/// Of what training can say nothing; what a body absorbs only if it is not known (`body_unknown`).
pub fn unseen(search: &Search, body_unknown: bool) -> Vec<NotKnown> {
    let groups = &search.library.groups;
    let of_first = |index: usize| {
        let Group { effect, joint, .. } = groups[index];
        match search.unseen(index)? {
            Unseen::Absorbed => body_unknown.then_some(NotKnown::AbsorbedByBody { effect, joint }),
            Unseen::Idle => Some(NotKnown::Idle { effect, joint }),
        }
    };
    search.library.firsts().into_iter().filter_map(of_first).collect()
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
    for index in search.library.firsts() {
        let group = &groups[index];
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
        } else if let Some(unseen) = search.unseen(index) {
            match unseen {
                Unseen::Absorbed => Ground::AbsorbedByBody,
                Unseen::Idle => Ground::Idle,
            }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::search::testing::searched;
    use crate::recording::split::Split;
    use crate::simulation::{Excitation, Scenario, simulate};

    /// Joint 2 is held: nothing is known of its friction. Of a rotor of joint 1 nothing is known as long as the body isn't. An end stop of
    /// joint 1, which goes further where it is held out, is judged where training can touch it.
    #[test]
    fn of_what_training_can_say_nothing() {
        let motion = Excitation::PaperPointToPoint { trajectories: 12, duration: 4.0, samples: 100, range: 2.0 };
        let mut recording = simulate(&Scenario { motion, ..Scenario::embedded() }, &Monitor::new()).unwrap();
        for run in &mut recording.trajectories {
            let run = run.channels_mut();
            [run.q, run.qd, run.qdd].into_iter().for_each(|mut signal| signal[1].fill(0.0));
        }
        for held_out in Split::automatic(&recording).held_out {
            let run = recording.trajectories[held_out.trajectory].channels_mut();
            [run.q, run.qd, run.qdd].into_iter().for_each(|mut signal| signal[0].iter_mut().for_each(|it| *it *= 2.0));
        }
        let search = searched(&recording, &["viscous-friction", "rotor-inertia", "upper-stop"]);
        let told = |body_unknown| -> Vec<(&str, Option<usize>, bool)> {
            let all = unseen(&search, body_unknown).into_iter().filter_map(|it| match it {
                NotKnown::AbsorbedByBody { effect, joint } => Some((effect.id, joint, false)),
                NotKnown::Idle { effect, joint } => Some((effect.id, joint, true)),
                _ => None,
            });
            all.collect()
        };
        let groups = &search.library.groups;
        let stops = |set: &[usize]| {
            let is_it = |&&group: &&usize| (groups[group].effect.id, groups[group].joint) == ("upper-stop", Some(0));
            set.iter().filter(is_it).count()
        };
        let all_stops = stops(&(0..groups.len()).collect::<Vec<usize>>());
        assert!(0 < stops(&search.absorbed) && stops(&search.absorbed) < all_stops, "some are out of reach");
        let all = told(true);
        assert!(all.contains(&("viscous-friction", Some(1), true)) && all.contains(&("rotor-inertia", Some(0), false)));
        assert!(all.iter().all(|(effect, joint, _)| (*effect, *joint) != ("upper-stop", Some(0))), "{all:?}");
        assert!(told(false).iter().all(|(.., idle)| *idle));
    }
}
