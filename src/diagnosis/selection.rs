//! The search for the set of missing effects.
//!
//! Forward: of all candidates the one with the best evidence is tried; it must pass every gate of [`super::gates`]. Then
//! effects that others made superfluous leave again, and each one is swapped for a rival if that explains more for its price.
//! The model's own parameters (the base parameters above all) are estimated anew with every candidate: a biased rigid body
//! hides effects and fakes others.

use std::ops::Range;

use nalgebra::DVector;
use rayon::prelude::*;

use super::candidates::{Group, Library};
use super::gates;
use crate::model::ModelError;
use crate::model::equations::PreparedColumn;
use crate::model::least_squares::{Elimination, NormalEquations, Solution};
use crate::model::line_search::{FINE, minimum};
use crate::model::terms::Found;
use crate::progress::{Event, Monitor};

/// Evidence must exceed this many times the price (parameters · ln samples).
pub const MARGIN: f64 = 1.5;
/// Two explanations whose evidence differs by less (in the units of ln likelihood, doubled) are as good as each other.
pub const CLOSE: f64 = 6.0;
/// Most effects that one diagnosis names, over all joints.
const MOST_EFFECTS: usize = 24;
/// Most rounds of the search, each with a better rigid body.
const LOAD_ROUNDS: usize = 3;
/// Steps of a search for a shape that is to be compared with others, not yet kept.
const COARSE: usize = 6;
/// Rounds over the shape parameters of an effect that has several.
const SHAPE_ROUNDS: usize = 2;
/// A joint must weigh less than this share of its weight before the set is doubted.
const LIGHTER: f64 = 0.8;
/// How many refused effects are tried in pairs, and how many pairs of them.
const PAIRED: usize = 8;
/// How many effects have their shape refined before the best is taken.
const SHORT_LIST: usize = 4;

/// Weighted normal equations of a library, by block, and the set of effects found so far.
pub struct Search<'a> {
    /// The candidates.
    pub library: Library<'a>,
    /// 1 / error variance of each joint.
    pub weights: Vec<f64>,
    /// Indices of the groups found, in the order in which they were found.
    pub active: Vec<usize>,
    /// ln of the number of samples: the price of one parameter.
    pub price: f64,
    blocks: Vec<NormalEquations>,
    whole: NormalEquations,
}

impl<'a> Search<'a> {
    /// Weighs the joints by what is left when all candidates may explain at once, and starts with nothing found.
    pub fn new(library: Library<'a>) -> Self {
        let joints = library.design.joint_count();
        let samples: usize = (0..joints).map(|joint| library.design.sample_count(joint)).sum();
        let empty = NormalEquations::empty(0);
        let mut search = Search {
            weights: (0..joints).map(|joint| 1.0 / library.design.energy(joint).max(f64::MIN_POSITIVE)).collect(),
            price: (samples.max(2) as f64).ln(),
            active: Vec::new(),
            blocks: Vec::new(),
            whole: empty,
            library,
        };
        search.weights = (0..joints).map(|joint| search.library.certainty(joint)).collect();
        search.update();
        search
    }

    /// Recomputes the weighted sums after the weights changed.
    fn update(&mut self) {
        let equations = &self.library.equations;
        self.blocks =
            (0..equations.block_count()).map(|block| equations.total(&self.weights, |other| other == block)).collect();
        self.whole = sum(&self.blocks, |_| true);
    }

    /// Recomputes the rows and columns of the weighted sums that belong to replaced columns.
    fn update_columns(&mut self, changed: Range<usize>) {
        let all: Vec<usize> = (0..self.whole.moment.len()).collect();
        for number in changed {
            let (mut products, mut moment) = (DVector::zeros(all.len()), 0.0);
            for (index, block) in self.blocks.iter_mut().enumerate() {
                let (of_block, moment_of_block) = self.library.equations.column(index, number, &all, &self.weights);
                replace(block, number, &of_block, moment_of_block);
                products += of_block;
                moment += moment_of_block;
            }
            replace(&mut self.whole, number, &products, moment);
        }
    }

    /// Columns of the model and of these groups.
    pub fn columns(&self, groups: &[usize]) -> Vec<usize> {
        let own = 0..self.library.base;
        own.chain(groups.iter().flat_map(|&group| self.library.groups[group].columns.clone())).collect()
    }

    /// Normal equations of the model and these groups on all blocks.
    pub fn equations_of(&self, groups: &[usize]) -> NormalEquations {
        self.whole.select(&self.columns(groups))
    }

    /// Least squares with these groups on all blocks.
    pub fn solve(&self, groups: &[usize]) -> Solution {
        self.equations_of(groups).solve()
    }

    /// Weighted squared error that is left with these groups.
    pub fn cost(&self, groups: &[usize]) -> f64 {
        self.solve(groups).residual_energy
    }

    /// [`Search::cost`] plus the price of the parameters.
    pub fn priced_cost(&self, groups: &[usize]) -> f64 {
        self.cost(groups) + self.price_of_all(groups)
    }

    /// The price of the parameters of these groups.
    pub fn price_of_all(&self, groups: &[usize]) -> f64 {
        groups.iter().map(|&group| self.price_of(group)).sum()
    }

    /// Error of each block with these groups, fitted on the blocks for which `trains(block, left_out)` holds, by left-out
    /// block.
    pub fn error_when(&self, groups: &[usize], left_out: usize) -> (DVector<f64>, f64) {
        let columns = self.columns(groups);
        let mut rest = self.whole.select(&columns);
        let block = self.blocks[left_out].select(&columns);
        rest.add(&block, -1.0);
        let factors = rest.solve().factors;
        let error = block.residual_energy(&factors);
        (factors, error)
    }

    /// Error on the blocks of `test` with these groups, fitted on the blocks of `train`.
    pub fn transfer_error(&self, groups: &[usize], train: &[usize], test: &[usize]) -> f64 {
        let columns = self.columns(groups);
        let factors = sum(&self.blocks, |block| train.contains(&block)).select(&columns).solve().factors;
        sum(&self.blocks, |block| test.contains(&block)).select(&columns).residual_energy(&factors)
    }

    /// Whether the model's own columns leave nothing of this group to see, beside `others`.
    pub fn is_absorbed(&self, group: usize, others: &[usize]) -> bool {
        let mut groups = others.to_vec();
        groups.push(group);
        let count = self.library.groups[group].columns.len();
        self.solve(&groups).identified.iter().rev().take(count).all(|identified| !identified)
    }

    /// Whether a group may enter: nothing that covers it is in the set.
    fn is_open(&self, group: usize) -> bool {
        let candidate = &self.library.groups[group];
        !self.active.iter().any(|&other| {
            let other: &Group = &self.library.groups[other];
            other.same_place_and_effect(candidate) || other.includes(candidate)
        })
    }

    /// The set with this group more, and without those that it includes or that are other forms of it.
    pub fn with(&self, group: usize) -> Vec<usize> {
        let candidate = &self.library.groups[group];
        let stays = |other: &usize| {
            let other = &self.library.groups[*other];
            !candidate.includes(other) && !candidate.is_another_form_of(other)
        };
        let mut groups: Vec<usize> = self.active.iter().copied().filter(stays).collect();
        groups.push(group);
        groups
    }

    /// Runs the search to its end. Candidates that had evidence but failed a gate come back with the reason.
    ///
    /// The effects that were found correct the rigid body, and with it the candidates that depend on its torque; so the search
    /// goes on until they change nothing.
    ///
    /// # Errors
    /// [`ModelError`] if it was stopped or a column can't be computed.
    pub fn run(&mut self, monitor: &Monitor) -> Result<Vec<(usize, String)>, ModelError> {
        let mut refused: Vec<(usize, String)> = Vec::new();
        for round in 0..LOAD_ROUNDS {
            let before = self.active.clone();
            refused.clear();
            for step in 0..MOST_EFFECTS {
                monitor.report(0.45 + 0.1 * round as f32 + 0.004 * step as f32, "searching for missing effects")?;
                let found = self.next_best(&mut refused)?.map_or_else(|| self.best_pair(&refused), |group| vec![group]);
                if found.is_empty() {
                    break;
                }
                for &group in &found {
                    self.active = self.with(group);
                }
                if found.iter().any(|&group| self.library.groups[group].effect.facts.depends_on_load) {
                    // Each time the error of the load shrinks by the strength of the effect.
                    for _ in 0..LOAD_ROUNDS {
                        self.reload()?;
                    }
                }
                self.settle()?;
                self.follow()?;
                let names = self.active.iter().map(|&group| self.library.groups[group].label());
                monitor.tell(Event::Found(names.collect()));
            }
            if self.active == before {
                break;
            }
            self.refine_other_forms()?;
            self.reload()?;
            self.settle()?;
        }
        for _ in 0..LOAD_ROUNDS {
            if !self.weigh_by_remainder() {
                break;
            }
            self.settle()?;
        }
        if self.simplify() {
            self.refine_found()?;
        }
        refused.retain(|(group, _)| !self.active.contains(group));
        Ok(refused)
    }

    /// Weighs the joints by what the effects found leave of them; whether one weighs clearly less than before.
    ///
    /// Beside something that no candidate explains, a small gain proves little: a form of friction that drifts or warms up
    /// copies a bit of it. What is left then counts as noise, and its neighbouring samples as one.
    fn weigh_by_remainder(&mut self) -> bool {
        let solution = self.solve(&self.active);
        let mut factors = DVector::zeros(self.library.columns.len());
        for (column, &factor) in self.columns(&self.active).into_iter().zip(&solution.factors) {
            factors[column] = factor;
        }
        let weights: Vec<f64> = (0..self.weights.len())
            .map(|joint| self.weights[joint].min(self.library.certainty_beside(joint, &factors, solution.rank())))
            .collect();
        let falls = weights.iter().zip(&self.weights).any(|(new, old)| *new < LIGHTER * old);
        if falls {
            self.weights = weights;
            self.update();
        }
        falls
    }

    /// Gives a candidate another shape.
    ///
    /// # Errors
    /// [`ModelError`] if the effect can't be computed with it.
    pub fn reshape(&mut self, group: usize, shape: Vec<f64>) -> Result<(), ModelError> {
        self.library.reshape(group, shape)?;
        self.update_columns(self.library.groups[group].columns.clone());
        Ok(())
    }

    /// Takes the load from the rigid body as it is identified beside the effects found; whether any column changed.
    ///
    /// # Errors
    /// [`ModelError`] if a column can't be computed.
    pub fn reload(&mut self) -> Result<bool, ModelError> {
        let (factors, found) = self.found();
        for (&group, found) in self.active.iter().zip(&found) {
            let group = &mut self.library.groups[group];
            if group.effect.changes_others() {
                group.shape.clone_from(&found.linear);
            }
        }
        let changed = self.library.reload(&factors, found)?;
        if changed {
            self.update();
        }
        Ok(changed)
    }

    /// The factors of the model's own columns, and what was found beside them.
    fn found(&self) -> (Vec<f64>, Vec<Found>) {
        let factors = self.solve(&self.active).factors;
        let (own, mut others) = factors.as_slice().split_at(self.library.base);
        let found = |&group: &usize| {
            let group = &self.library.groups[group];
            let linear = others.split_off(..group.columns.len()).unwrap_or_default().to_vec();
            Found { term: group.term(), linear, shape: group.shape.clone() }
        };
        let found = self.active.iter().map(found).collect();
        (own.to_vec(), found)
    }

    /// Lets the effects of the set pass through those that change what others do, be they found or candidates.
    fn follow(&mut self) -> Result<(), ModelError> {
        let (factors, found) = self.found();
        if !self.library.is_altered_by(&found) {
            self.reload()?;
        } else if self.library.pass(&factors, found)? {
            self.update();
        }
        Ok(())
    }

    /// Settles the set after a change: superfluous effects leave, rivals that explain more take over, shapes are refined
    /// beside the others.
    fn settle(&mut self) -> Result<(), ModelError> {
        self.prune();
        self.swap();
        self.refine_found()
    }

    /// Refines the shapes of what was found, each beside the others, and takes out what then is superfluous.
    fn refine_found(&mut self) -> Result<(), ModelError> {
        for group in self.active.clone() {
            if let Some(shape) = self.best_shape(group, FINE)? {
                self.reshape(group, shape)?;
            }
        }
        self.prune();
        Ok(())
    }

    /// Puts everyday effects, or none, in the place of an odd one that has hardly more evidence, or that left-out blocks don't
    /// confirm against them; whether any changed.
    fn simplify(&mut self) -> bool {
        let groups = &self.library.groups;
        let before = self.active.clone();
        for odd in before.iter().copied().filter(|&group| !groups[group].effect.facts.everyday) {
            let others: Vec<usize> = self.active.iter().copied().filter(|&other| other != odd).collect();
            let everyday: Vec<usize> = self
                .rivals(odd)
                .into_iter()
                .map(|rival| rival.group)
                .filter(|&rival| groups[rival].effect.facts.everyday && groups[rival].joint == groups[odd].joint)
                .collect();
            let alone = everyday.iter().map(|&first| vec![first]);
            let pairs = everyday.iter().flat_map(|&first| {
                let is_other = move |second: &&usize| groups[**second].effect.id > groups[first].effect.id;
                everyday.iter().filter(is_other).map(move |&second| vec![first, second])
            });
            let size = |set: &[usize]| set.iter().map(|&group| groups[group].parameter_count()).sum::<usize>();
            let simple =
                alone.chain(pairs).chain([Vec::new()]).filter(|set| size(set) <= groups[odd].parameter_count());
            let sets = simple.map(|set| others.iter().copied().chain(set).collect::<Vec<usize>>());
            let now = self.priced_cost(&self.active);
            let is_as_good = |set: &Vec<usize>| {
                set[others.len()..].iter().all(|&group| gates::is_physical(self, set, group))
                    && (self.priced_cost(set) < now + CLOSE || !gates::is_confirmed(self, set, &self.active))
            };
            let best = sets.filter(is_as_good).min_by(|a, b| self.priced_cost(a).total_cmp(&self.priced_cost(b)));
            if let Some(set) = best {
                self.active = set;
            }
        }
        self.active != before
    }

    /// Gives the other forms of what was found their best shapes, so that a swap compares each at its best.
    pub fn refine_other_forms(&mut self) -> Result<(), ModelError> {
        let groups = &self.library.groups;
        let mut best: Vec<(usize, f64)> = Vec::new();
        for form in 0..groups.len() {
            let is_found = self.active.iter().any(|&found| groups[found].same_place_and_effect(&groups[form]));
            if is_found || !self.active.iter().any(|&found| groups[form].is_another_form_of(&groups[found])) {
                continue;
            }
            let cost = self.cost(&self.with(form));
            match best.iter_mut().find(|(other, _)| groups[*other].same_place_and_effect(&groups[form])) {
                Some(known) if cost < known.1 => *known = (form, cost),
                Some(_) => {}
                None => best.push((form, cost)),
            }
        }
        let shapes =
            best.par_iter().map(|&(form, _)| self.best_shape(form, FINE)).collect::<Result<Vec<_>, ModelError>>()?;
        for ((form, _), shape) in best.into_iter().zip(shapes) {
            shape.map_or(Ok(()), |shape| self.reshape(form, shape))?;
        }
        Ok(())
    }

    /// The candidate with the best evidence that passes all gates.
    fn next_best(&mut self, refused: &mut Vec<(usize, String)>) -> Result<Option<usize>, ModelError> {
        loop {
            let base = Base::new(self, self.active.clone());
            let (before, now) = (base.elimination.residual_energy(), self.priced_cost(&self.active));
            let score = |group: usize| {
                let candidate = &self.library.groups[group];
                let is_refused =
                    refused.iter().any(|(other, _)| self.library.groups[*other].same_place_and_effect(candidate));
                if is_refused || !self.is_open(group) {
                    return None;
                }
                let beside = base.with(self, group);
                let with = self.with(group);
                let replaces = with.len() <= self.active.len();
                let score =
                    if replaces { now - self.priced_cost(&with) } else { before - beside.cost - self.price_of(group) };
                (score > 0.0 && beside.shows).then_some((group, score))
            };
            let scored: Vec<(usize, f64)> = (0..self.library.groups.len()).into_par_iter().filter_map(score).collect();
            let Some(group) = self.best_when_refined(scored)? else { return Ok(None) };
            match gates::check(self, group) {
                Ok(()) => return Ok(Some(group)),
                Err(reason) => refused.push((group, reason)),
            }
        }
    }

    /// Two refused candidates that pass all gates beside each other: where two strong effects are missing, each may hide the
    /// other's part in too many blocks to be confirmed alone. Empty if there are none.
    fn best_pair(&mut self, refused: &[(usize, String)]) -> Vec<usize> {
        let before = self.active.clone();
        let now = self.priced_cost(&before);
        let is_new = |group: &usize| self.with(*group).len() == before.len() + 1;
        let candidates: Vec<usize> = refused.iter().map(|(group, _)| *group).filter(is_new).take(PAIRED).collect();
        let with = |added: &[usize]| before.iter().chain(added).copied().collect::<Vec<usize>>();
        let groups = &self.library.groups;
        let are_two = |&[first, second]: &[usize; 2]| {
            let (first, second) = (&groups[first], &groups[second]);
            !first.includes(second) && !second.includes(first) && !first.is_another_form_of(second)
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
                gates::check(search, added).is_ok()
            });
            search.active.clone_from(&before);
            pass && gates::is_confirmed(search, &before, &with(&[first, second]))
        };
        let best = pairs.into_iter().take(PAIRED).map(|(both, _)| both).find(|&both| passes(self, both));
        best.map_or(Vec::new(), Vec::from)
    }

    /// The best of the most promising effects, each with its shape refined: at its start value a shape may do badly.
    fn best_when_refined(&mut self, mut scored: Vec<(usize, f64)>) -> Result<Option<usize>, ModelError> {
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
        let refined = short_list
            .par_iter()
            .map(|&group| self.best_shape(group, COARSE))
            .collect::<Result<Vec<_>, ModelError>>()?;
        for (&group, shape) in short_list.iter().zip(refined) {
            shape.map_or(Ok(()), |shape| self.reshape(group, shape))?;
        }
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

    /// The best shape of a group beside the active ones, between the neighbours of its start value; `None`
    /// if there is none or it has it.
    fn best_shape(&self, group: usize, steps: usize) -> Result<Option<Vec<f64>>, ModelError> {
        if self.library.groups[group].effect.shapes().next().is_none() {
            return Ok(None);
        }
        let candidate = self.library.groups[group].clone();
        // The group's own columns come last, so that a trial changes only the end of the equations.
        let mut groups = self.with(group);
        groups.retain(|&other| other != group);
        let others = self.columns(&groups);
        groups.push(group);
        let mut equations = self.equations_of(&groups);
        let kept: Vec<&PreparedColumn> = others.iter().map(|&column| &self.library.columns[column]).collect();
        let Library { design, torque, equations: of_library, .. } = &self.library;
        let mut cost = |shape: &[f64]| -> Result<f64, ModelError> {
            let prepared = design.effect_columns(&candidate.term(), shape)?;
            of_library.complete(&mut equations, &kept, &prepared, torque, &self.weights);
            Ok(equations.solve().residual_energy)
        };
        let mut shape = candidate.shape.clone();
        let start = cost(&shape)?;
        let mut least = start;
        // Several shape parameters influence each other.
        let rounds = if steps == COARSE { 1 } else { candidate.shape.len().min(SHAPE_ROUNDS) };
        for (number, (parameter, grid)) in (0..rounds).flat_map(|_| candidate.effect.shapes().enumerate()) {
            let value = shape[number];
            let below = grid.iter().copied().rfind(|&other| other < 0.999 * value);
            let above = grid.iter().copied().find(|&other| other > 1.001 * value);
            let below = below.unwrap_or(value / 4.0).max(candidate.least_shape[number]);
            let above = above.unwrap_or(parameter.max.min(value * 4.0));
            let mut trial = shape.clone();
            let (best, found) = minimum(below.ln(), above.ln(), steps, |place| {
                trial[number] = place.exp();
                cost(&trial)
            })?;
            if found < least {
                (shape[number], least) = (best.exp(), found);
            }
        }
        Ok((least < start).then_some(shape))
    }

    /// Takes out what is no longer worth its price, or what another effect's formula leaves, the weakest first.
    fn prune(&mut self) {
        loop {
            let now = self.cost(&self.active);
            let margin = |&group: &usize| {
                if gates::leaves_it(self, &self.active, group).is_some() {
                    return (group, f64::NEG_INFINITY);
                }
                let without: Vec<usize> = self.active.iter().copied().filter(|&other| other != group).collect();
                (group, self.cost(&without) - now - MARGIN * self.price_of(group))
            };
            let weakest = self.active.iter().map(margin).min_by(|a, b| a.1.total_cmp(&b.1));
            match weakest {
                Some((group, margin)) if margin < 0.0 => self.active.retain(|&other| other != group),
                _ => return,
            }
        }
    }

    /// Swaps effects for rivals while that pays.
    fn swap(&mut self) {
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
                    || candidate_group.is_another_form_of(other)
            };
            if !meets || candidate_group.same_place_and_effect(&groups[group]) || base.groups.iter().any(excludes) {
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

    /// The price of a group's parameters.
    pub fn price_of(&self, group: usize) -> f64 {
        self.library.groups[group].parameter_count() as f64 * self.price
    }
}

/// An effect that stands for another one of the set that was found.
pub struct Rival {
    /// The set with it.
    pub set: Vec<usize>,
    /// Which it is.
    pub group: usize,
    /// Weighted squared error that is left with that set.
    pub cost: f64,
}

/// The model's columns and those of some groups, eliminated once, so that one more group after the other can be tried.
struct Base {
    groups: Vec<usize>,
    columns: Vec<usize>,
    elimination: Elimination,
}

/// What a group does beside a base.
struct Beside {
    cost: f64,
    factors: Vec<f64>,
    /// Whether the data show any of its factors.
    shows: bool,
}

impl Base {
    fn new(search: &Search, groups: Vec<usize>) -> Self {
        let columns = search.columns(&groups);
        let elimination = search.whole.select(&columns).eliminate();
        Base { groups, columns, elimination }
    }

    fn with(&self, search: &Search, group: usize) -> Beside {
        let mut elimination = self.elimination.clone();
        let mut columns = self.columns.clone();
        for column in search.library.groups[group].columns.clone() {
            let products: Vec<f64> = columns.iter().map(|&other| search.whole.gram[(other, column)]).collect();
            elimination.push(&products, search.whole.gram[(column, column)], search.whole.moment[column]);
            columns.push(column);
        }
        let first = self.columns.len();
        Beside {
            cost: elimination.residual_energy(),
            factors: elimination.factors_from(first),
            shows: elimination.identified()[first..].iter().any(|&shows| shows),
        }
    }
}

/// Puts other products of one column into the equations.
fn replace(equations: &mut NormalEquations, number: usize, products: &DVector<f64>, moment: f64) {
    equations.gram.set_column(number, products);
    equations.gram.set_row(number, &products.transpose());
    equations.moment[number] = moment;
}

/// Sum of the equations of the blocks for which `included` holds.
fn sum(blocks: &[NormalEquations], included: impl Fn(usize) -> bool) -> NormalEquations {
    let mut sum = NormalEquations::empty(blocks.first().map_or(0, |block| block.moment.len()));
    for (_, block) in blocks.iter().enumerate().filter(|(index, _)| included(*index)) {
        sum.add(block, 1.0);
    }
    sum
}
