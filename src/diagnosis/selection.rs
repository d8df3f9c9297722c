//! The search for the set of missing effects.
//!
//! Forward: of all candidates the one with the best evidence is tried; it must pass every gate of [`super::gates`]. Then
//! effects that others made superfluous leave again, and each one is swapped for a rival if that explains more for its price.
//! The model's own parameters (the base parameters above all) are estimated anew with every candidate: a biased rigid body
//! hides effects and fakes others.

use nalgebra::DVector;

use super::candidates::{Group, Library};
use super::gates;
use crate::model::ModelError;
use crate::model::least_squares::{NormalEquations, Solution};
use crate::progress::Monitor;

/// Evidence must exceed this many times the price (parameters · ln samples).
pub const MARGIN: f64 = 1.5;
/// Most effects that one diagnosis names, over all joints.
const MOST_EFFECTS: usize = 24;
/// Golden-section steps when a shape is refined.
const REFINEMENTS: usize = 12;

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
        let joints = library.design.recording.joint_count();
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
        search.update();
        search.weights = crate::model::fit::residual_weights(
            search.library.design,
            &search.library.equations,
            &search.whole.solve().factors,
        );
        search.update();
        search
    }

    /// Recomputes the weighted sums after the columns or the weights changed.
    fn update(&mut self) {
        let equations = &self.library.equations;
        self.blocks =
            (0..equations.block_count()).map(|block| equations.total(&self.weights, |other| other == block)).collect();
        self.whole = sum(&self.blocks, |_| true);
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
        let parameters: usize = groups.iter().map(|&group| self.library.groups[group].parameter_count()).sum();
        self.cost(groups) + parameters as f64 * self.price
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

    /// The set with this group more, and without those that it includes.
    pub fn with(&self, group: usize) -> Vec<usize> {
        let candidate = &self.library.groups[group];
        let stays = |other: &usize| !candidate.includes(&self.library.groups[*other]);
        let mut groups: Vec<usize> = self.active.iter().copied().filter(stays).collect();
        groups.push(group);
        groups
    }

    /// Runs the search to its end. Candidates that had evidence but failed a gate come back with the reason.
    ///
    /// # Errors
    /// [`ModelError`] if it was stopped or a column can't be computed.
    pub fn run(&mut self, monitor: &Monitor) -> Result<Vec<(usize, String)>, ModelError> {
        let mut refused: Vec<(usize, String)> = Vec::new();
        for step in 0..MOST_EFFECTS {
            monitor.report(0.45 + 0.02 * step as f32, "searching for missing effects")?;
            let Some(group) = self.next_best(&mut refused)? else { break };
            self.active = self.with(group);
            self.prune();
            self.swap();
        }
        self.prune();
        refused.retain(|(group, _)| !self.active.contains(group));
        Ok(refused)
    }

    /// The candidate with the best evidence that passes all gates.
    fn next_best(&mut self, refused: &mut Vec<(usize, String)>) -> Result<Option<usize>, ModelError> {
        loop {
            let now = self.priced_cost(&self.active);
            let mut best: Option<(usize, f64)> = None;
            for group in 0..self.library.groups.len() {
                let candidate = &self.library.groups[group];
                let is_refused =
                    refused.iter().any(|(other, _)| self.library.groups[*other].same_place_and_effect(candidate));
                if is_refused || !self.is_open(group) {
                    continue;
                }
                let score = now - self.priced_cost(&self.with(group));
                if score > best.map_or(0.0, |(_, best)| best) && !self.is_absorbed(group, &self.active) {
                    best = Some((group, score));
                }
            }
            let Some((group, _)) = best else { return Ok(None) };
            self.refine(group)?;
            match gates::check(self, group) {
                Ok(()) => return Ok(Some(group)),
                Err(reason) => refused.push((group, reason)),
            }
        }
    }

    /// Sets the shape of a group to its best value, by golden section between the neighbours of its start value.
    fn refine(&mut self, group: usize) -> Result<(), ModelError> {
        let start = self.library.groups[group].shape.clone();
        let ranges: Vec<(f64, f64)> = self.library.groups[group]
            .spec
            .shapes()
            .zip(&start)
            .map(|((parameter, grid), value)| {
                let below = grid.iter().copied().rfind(|other| other < value).unwrap_or(parameter.min.max(value / 4.0));
                let above = grid.iter().copied().find(|other| other > value).unwrap_or(parameter.max.min(value * 4.0));
                (below.ln(), above.ln())
            })
            .collect();
        for (number, (mut low, mut high)) in ranges.into_iter().enumerate() {
            for _ in 0..REFINEMENTS {
                let third = (high - low) / 3.0;
                let [left, right] = [low + third, high - third];
                if self.cost_with_shape(group, number, left.exp())?
                    < self.cost_with_shape(group, number, right.exp())?
                {
                    high = right;
                } else {
                    low = left;
                }
            }
            self.cost_with_shape(group, number, (0.5 * (low + high)).exp())?;
        }
        Ok(())
    }

    fn cost_with_shape(&mut self, group: usize, number: usize, value: f64) -> Result<f64, ModelError> {
        let mut shape = self.library.groups[group].shape.clone();
        shape[number] = value;
        self.library.reshape(group, shape)?;
        self.update();
        Ok(self.cost(&self.with(group)))
    }

    /// Takes out what is no longer worth its price, the weakest first.
    fn prune(&mut self) {
        loop {
            let now = self.cost(&self.active);
            let margin = |&group: &usize| {
                let without: Vec<usize> = self.active.iter().copied().filter(|&other| other != group).collect();
                let price = self.library.groups[group].parameter_count() as f64 * self.price;
                (group, self.cost(&without) - now - MARGIN * price)
            };
            let weakest = self.active.iter().map(margin).min_by(|a, b| a.1.total_cmp(&b.1));
            match weakest {
                Some((group, margin)) if margin < 0.0 => self.active.retain(|&other| other != group),
                _ => return,
            }
        }
    }

    /// Swaps effects for rivals at the same place while that pays.
    fn swap(&mut self) {
        let mut rounds = self.active.len();
        while rounds > 0 {
            rounds -= 1;
            let now = self.priced_cost(&self.active);
            let mut best: Option<(Vec<usize>, f64)> = None;
            for &old in &self.active {
                for (rival, _) in self.rivals(old) {
                    let cost = self.priced_cost(&rival);
                    if cost < best.as_ref().map_or(now, |(_, cost)| *cost) {
                        best = Some((rival, cost));
                    }
                }
            }
            let Some((better, _)) = best else { return };
            self.active = better;
        }
    }

    /// The sets in which another effect at the same place stands for `group`, each with that effect.
    pub fn rivals(&self, group: usize) -> Vec<(Vec<usize>, usize)> {
        let place = self.library.groups[group].joint;
        let others: Vec<usize> = self.active.iter().copied().filter(|&other| other != group).collect();
        let is_free = |candidate: &usize| {
            let candidate_group = &self.library.groups[*candidate];
            candidate_group.joint == place
                && !candidate_group.same_place_and_effect(&self.library.groups[group])
                && !others.iter().any(|&other| {
                    let other = &self.library.groups[other];
                    other.same_place_and_effect(candidate_group)
                        || other.includes(candidate_group)
                        || candidate_group.includes(other)
                })
        };
        let candidates = (0..self.library.groups.len()).filter(is_free);
        candidates
            .map(|candidate| {
                let mut groups = others.clone();
                groups.push(candidate);
                (groups, candidate)
            })
            .filter(|(groups, candidate)| gates::is_physical(self, groups, *candidate))
            .collect()
    }
}

/// Sum of the equations of the blocks for which `included` holds.
fn sum(blocks: &[NormalEquations], included: impl Fn(usize) -> bool) -> NormalEquations {
    let mut sum = NormalEquations::empty(blocks.first().map_or(0, |block| block.moment.len()));
    for (_, block) in blocks.iter().enumerate().filter(|(index, _)| included(*index)) {
        sum.add(block, 1.0);
    }
    sum
}
