//! Forward selection: the candidate, or the pair of candidates, that the evidence asks for next.

use rayon::prelude::*;

use super::gates;
use super::shape::COARSE;
use super::state::{Base, Search};
use crate::diagnosis::report::Refusal;
use crate::model::ModelError;

/// How many refused effects are tried in pairs, and how many pairs of them.
const PAIRED: usize = 8;
/// How many effects have their shape refined before the best is taken.
const SHORT_LIST: usize = 4;

impl Search<'_> {
    /// The candidate with the best evidence that passes all gates.
    pub(super) fn next_best(&mut self, refused: &mut Vec<(usize, Refusal)>) -> Result<Option<usize>, ModelError> {
        let base = Base::new(self, self.active.clone());
        let now = gates::Now::of(self);
        let mut scores: Vec<Option<f64>> =
            (0..self.library.groups.len()).into_par_iter().map(|group| self.score(&base, group)).collect();
        let mut refined: Vec<usize> = Vec::new();
        loop {
            let is_refused = |group: usize| {
                let groups = &self.library.groups;
                refused.iter().any(|(other, _)| groups[*other].same_place_and_effect(&groups[group]))
            };
            let open = scores.iter().enumerate().filter_map(|(group, score)| Some((group, (*score)?)));
            let open: Vec<(usize, f64)> = open.filter(|(group, _)| !is_refused(*group)).collect();
            let before = refined.len();
            let Some(group) = self.best_when_refined(open, &mut refined)? else { return Ok(None) };
            for &reshaped in &refined[before..] {
                scores[reshaped] = self.score(&base, reshaped);
            }
            match gates::check(self, &now, group) {
                Ok(()) => return Ok(Some(group)),
                Err(reason) => refused.push((group, reason)),
            }
        }
    }

    /// The evidence for one more group, its price taken off; `None` if there is none.
    fn score(&self, base: &Base, group: usize) -> Option<f64> {
        if !self.is_open(group) {
            return None;
        }
        let with = self.with(group);
        let beside = base.with(self, group);
        let score = if with.len() <= self.active.len() {
            base.cost + self.price_of_all(&self.active) - self.priced_cost(&with)
        } else {
            base.cost - beside.cost - self.price_of(group)
        };
        (score > 0.0 && beside.shows).then_some(score)
    }

    /// Two refused candidates that pass all gates beside each other: where two strong effects are missing, each may hide the
    /// other's part in too many blocks to be confirmed alone. Empty if there are none.
    pub(super) fn best_pair(&mut self, refused: &[(usize, Refusal)]) -> Vec<usize> {
        let before = self.active.clone();
        let now = self.priced_cost(&before);
        let is_new = |group: &usize| self.with(*group).len() == before.len() + 1;
        let candidates: Vec<usize> = refused.iter().map(|(group, _)| *group).filter(is_new).take(PAIRED).collect();
        let with = |added: &[usize]| before.iter().chain(added).copied().collect::<Vec<usize>>();
        let groups = &self.library.groups;
        let are_two = |&[first, second]: &[usize; 2]| {
            let (first, second) = (&groups[first], &groups[second]);
            !first.includes(second) && !second.includes(first) && !first.excludes(second)
        };
        let mut pairs: Vec<([usize; 2], f64)> = candidates
            .iter()
            .enumerate()
            .flat_map(|(number, &first)| candidates[number + 1..].iter().map(move |&second| [first, second]))
            .filter(are_two)
            .map(|both| (both, self.priced_cost(&with(&both))))
            .filter(|(_, cost)| *cost < now)
            .collect();
        pairs.sort_by(|a, b| a.1.total_cmp(&b.1));
        let passes = |search: &mut Search, [first, second]: [usize; 2]| {
            let pass = [[first, second], [second, first]].into_iter().all(|[there, added]| {
                search.active = with(&[there]);
                gates::check(search, &gates::Now::of(search), added).is_ok()
            });
            search.active.clone_from(&before);
            pass && gates::is_confirmed(search, &before, &with(&[first, second]))
        };
        let best = pairs.into_iter().take(PAIRED).map(|(both, _)| both).find(|&both| passes(self, both));
        best.map_or(Vec::new(), Vec::from)
    }

    /// The best of the most promising effects, each with its shape refined: at its start value a shape may do badly. Those that are
    /// `refined` beside this set already stay as they are; the others join them.
    fn best_when_refined(
        &mut self,
        mut scored: Vec<(usize, f64)>,
        refined: &mut Vec<usize>,
    ) -> Result<Option<usize>, ModelError> {
        scored.sort_by(|a, b| b.1.total_cmp(&a.1));
        let is_everyday = |&group: &usize| self.library.groups[group].effect.facts.everyday;
        let everyday: Vec<usize> = scored.iter().map(|(group, _)| *group).filter(is_everyday).collect();
        let mut short_list: Vec<usize> = Vec::new();
        for (group, _) in scored {
            let groups = &self.library.groups;
            if !short_list.iter().any(|&other| groups[other].same_place_and_effect(&groups[group])) {
                short_list.push(group);
            }
            if short_list.len() == SHORT_LIST {
                break;
            }
        }
        let new: Vec<usize> = short_list.iter().copied().filter(|group| !refined.contains(group)).collect();
        let shapes =
            new.par_iter().map(|&group| self.best_shape(group, COARSE)).collect::<Result<Vec<_>, ModelError>>()?;
        for (&group, shape) in new.iter().zip(shapes) {
            shape.map_or(Ok(()), |shape| self.reshape(group, shape))?;
        }
        refined.extend(new);
        let cost = |group: &usize| self.priced_cost(&self.with(*group));
        let Some(best) = short_list.iter().copied().min_by(|a, b| cost(a).total_cmp(&cost(b))) else { return Ok(None) };
        let groups = &self.library.groups;
        let is_as_good = |simple: &usize| {
            groups[*simple].parameter_count() < groups[best].parameter_count()
                && groups[*simple].meets(&groups[best])
                && !gates::is_confirmed(self, &self.with(*simple), &self.with(best))
        };
        let simple = short_list.iter().chain(&everyday).copied().filter(is_as_good);
        Ok(simple.min_by(|a, b| cost(a).total_cmp(&cost(b))).or(Some(best)))
    }
}
