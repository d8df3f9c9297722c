//! Swaps: a rival that explains more for its price takes an effect's place, and an everyday effect that of an odd one.

use rayon::prelude::*;

use super::gates;
use super::state::{Base, CLOSE, Search};

/// An effect that stands for another one of the set that was found.
pub struct Rival {
    /// The set with it.
    pub set: Vec<usize>,
    /// Which it is.
    pub group: usize,
    /// Weighted squared error that is left with that set.
    pub cost: f64,
}

impl Search<'_> {
    /// Swaps effects for rivals while that pays.
    pub(super) fn swap(&mut self) {
        for _ in 0..self.active.len() {
            let now = self.priced_cost(&self.active);
            let mut best: Option<(Vec<usize>, f64)> = None;
            for &old in &self.active {
                let rest = self.price_of_all(&self.active) - self.price_of(old);
                for rival in self.rivals(old) {
                    let cost = rival.cost + rest + self.price_of(rival.group);
                    let is_simpler = self.price_of(rival.group) <= self.price_of(old);
                    if cost < best.as_ref().map_or(now, |(_, cost)| *cost)
                        && (is_simpler || gates::is_confirmed(self, &self.active, &rival.set))
                    {
                        best = Some((rival.set, cost));
                    }
                }
            }
            let Some((better, _)) = best else { return };
            self.active = better;
        }
    }

    /// Puts everyday effects, or none, in the place of an odd one that has hardly more evidence, or that left-out blocks don't
    /// confirm against them; whether any changed.
    pub(super) fn simplify(&mut self) -> bool {
        let is_odd = |group: &usize| !self.library.groups[*group].effect.facts.everyday;
        let before = self.active.clone();
        for odd in before.iter().copied().filter(is_odd).collect::<Vec<_>>() {
            let now = self.priced_cost(&self.active);
            let is_as_good = |set: &Vec<usize>| {
                let evidence = self.priced_cost(set) - now;
                evidence < CLOSE || !gates::is_confirmed_as_found(self, set, &self.active, odd, evidence)
            };
            let best = self.simpler_than(odd, &self.rivals(odd)).into_iter().filter(is_as_good);
            let best = best.min_by(|a, b| self.priced_cost(a).total_cmp(&self.priced_cost(b)));
            if let Some(set) = best {
                self.active = set;
            }
        }
        self.active != before
    }

    /// The sets in which one everyday effect of the same joint, two or none stand for `odd`, with no more parameters than it has. Those
    /// with impossible parameters are left out.
    pub fn simpler_than(&self, odd: usize, rivals: &[Rival]) -> Vec<Vec<usize>> {
        let groups = &self.library.groups;
        let others: Vec<usize> = self.active.iter().copied().filter(|&other| other != odd).collect();
        let is_everyday =
            |rival: &usize| groups[*rival].effect.facts.everyday && groups[*rival].joint == groups[odd].joint;
        let everyday: Vec<usize> = rivals.iter().map(|rival| rival.group).filter(is_everyday).collect();
        let alone = everyday.iter().map(|&first| vec![first]);
        let pairs = everyday.iter().flat_map(|&first| {
            let is_other = move |second: &&usize| groups[**second].effect.id > groups[first].effect.id;
            everyday.iter().filter(is_other).map(move |&second| vec![first, second])
        });
        let size = |set: &[usize]| set.iter().map(|&group| groups[group].parameter_count()).sum::<usize>();
        let simple = alone.chain(pairs).chain([Vec::new()]).filter(|set| size(set) <= groups[odd].parameter_count());
        let sets = simple.map(|set| others.iter().copied().chain(set).collect::<Vec<usize>>());
        sets.filter(|set| gates::are_new_ones_physical(self, set)).collect()
    }

    /// The sets in which another effect that meets `group` on a joint, or the same effect on another joint, stands for it.
    pub fn rivals(&self, group: usize) -> Vec<Rival> {
        let groups = &self.library.groups;
        let others: Vec<usize> = self.active.iter().copied().filter(|&other| other != group).collect();
        let base = Base::new(self, others);
        let rival = |candidate: usize| {
            let candidate_group = &groups[candidate];
            let meets = candidate_group.meets(&groups[group]) || candidate_group.effect == groups[group].effect;
            let excludes = |&other: &usize| {
                let other = &groups[other];
                other.same_place_and_effect(candidate_group)
                    || other.includes(candidate_group)
                    || candidate_group.includes(other)
                    || candidate_group.excludes(other)
            };
            let is_absorbed = self.absorbed.contains(&candidate);
            if !meets
                || is_absorbed
                || self.is_on_all_joints(&base.groups, candidate)
                || !candidate_group.repeats()
                || candidate_group.same_place_and_effect(&groups[group])
                || base.groups.iter().any(excludes)
            {
                return None;
            }
            let beside = base.with(self, candidate);
            let set = base.groups.iter().copied().chain([candidate]).collect();
            gates::are_physical(candidate_group.effect, &beside.factors).then_some(Rival {
                set,
                group: candidate,
                cost: beside.cost,
            })
        };
        (0..groups.len()).into_par_iter().filter_map(rival).collect()
    }
}
