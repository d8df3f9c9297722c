//! What a search stands on: the candidates with their weighted equations, what a set of them costs, and the set found so far.

use std::ops::Range;

use nalgebra::DVector;
use rayon::prelude::*;

use super::gates::WHITE;
use super::left_out::LeftOut;
use crate::diagnosis::candidates::{Group, Library};
use crate::model::ModelError;
use crate::model::least_squares::{Elimination, NormalEquations, Solution};
use crate::model::terms::Found;
use crate::model::whitening::Whitening;

/// Evidence must exceed this many times the price of the Bayesian information criterion (parameters · ln samples): so many
/// candidates are tried that the best of those that are not there passes the price itself now and then.
pub const MARGIN: f64 = 1.5;
/// Two explanations whose evidence differs by less (in the units of ln likelihood, doubled) are as good as each other: odds of
/// 20 to 1 (Kass and Raftery, J. Am. Stat. Assoc. 90 (1995) 773, "strong" from 6 on).
pub const CLOSE: f64 = 6.0;
/// A joint must weigh less than this share of its weight before the set is doubted.
const LIGHTER: f64 = 0.8;

/// Why training can say nothing of an effect at a place, whatever its shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unseen {
    /// The model's own columns take its place.
    Absorbed,
    /// It makes no torque there.
    Idle,
}

/// Weighted normal equations of a library, and the set of effects found so far.
pub struct Search<'a> {
    /// The candidates.
    pub library: Library<'a>,
    /// 1 / error variance of each joint.
    pub weights: Vec<f64>,
    /// What they were at first, when all candidates might explain at once.
    at_first: Vec<f64>,
    /// Indices of the groups found, in the order in which they were found.
    pub active: Vec<usize>,
    /// ln of the number of samples: the price of one parameter.
    pub price: f64,
    /// The groups of which the model's own columns leave nothing to see. They stay out: where what was found delays their columns, they
    /// would come to light only to say the delay in other words.
    pub absorbed: Vec<usize>,
    pub(super) left_out: LeftOut,
    whole: NormalEquations,
    /// The model's own columns on all blocks, which come first in every set.
    own: Elimination,
}

impl<'a> Search<'a> {
    /// Weighs the joints by what is left when all candidates may explain at once, and starts with nothing found.
    pub fn new(library: Library<'a>) -> Self {
        let joints = library.design.joint_count();
        let samples: usize = (0..joints).map(|joint| library.design.sample_count(joint)).sum();
        let empty = NormalEquations::empty(0);
        let mut search = Search {
            weights: (0..joints).map(|joint| 1.0 / library.design.energy(joint).max(f64::MIN_POSITIVE)).collect(),
            at_first: Vec::new(),
            price: (samples.max(2) as f64).ln(),
            active: Vec::new(),
            absorbed: Vec::new(),
            left_out: LeftOut::default(),
            whole: empty,
            own: Elimination::default(),
            library,
        };
        search.weights = (0..joints).map(|joint| search.library.certainty(joint)).collect();
        search.at_first.clone_from(&search.weights);
        search.update();
        search.find_absorbed();
        search
    }

    /// Looks anew for what is absorbed, after shapes were changed from outside.
    pub fn find_absorbed(&mut self) {
        let own = Base::new(self, Vec::new());
        let groups = 0..self.library.groups.len();
        self.absorbed = groups.into_par_iter().filter(|&group| !own.with(self, group).shows).collect();
    }

    /// Why training can say nothing of the effect of a group at its place, if no shape of it shows anything.
    pub fn unseen(&self, group: usize) -> Option<Unseen> {
        let groups = &self.library.groups;
        let same = || (0..groups.len()).filter(|&other| groups[other].same_place_and_effect(&groups[group]));
        if !same().all(|other| self.absorbed.contains(&other)) {
            return None;
        }
        let is_idle =
            |other: usize| groups[other].columns.clone().all(|column| self.whole.gram[(column, column)] == 0.0);
        Some(if same().all(is_idle) { Unseen::Idle } else { Unseen::Absorbed })
    }

    /// Recomputes the weighted sums after the weights changed.
    fn update(&mut self) {
        self.left_out.forget();
        self.whole = self.library.equations.total(&self.weights, |_| true);
        self.own = self.whole_of(&self.columns(&[])).eliminate();
    }

    /// Recomputes the rows and columns of the weighted sums that belong to replaced columns of candidates.
    fn update_columns(&mut self, changed: Range<usize>) {
        self.left_out.forget_those_with(&changed);
        let (equations, all) = (&self.library.equations, (0..self.whole.moment.len()).collect::<Vec<usize>>());
        for number in changed {
            let (mut products, mut moment) = (DVector::zeros(all.len()), 0.0);
            for block in 0..equations.block_count() {
                let (of_block, moment_of_block) = equations.column(block, number, &all, &self.weights);
                products += of_block;
                moment += moment_of_block;
            }
            self.whole.gram.set_column(number, &products);
            self.whole.gram.set_row(number, &products.transpose());
            self.whole.moment[number] = moment;
        }
    }

    /// Columns of the model and of these groups.
    pub fn columns(&self, groups: &[usize]) -> Vec<usize> {
        let own = 0..self.library.base;
        own.chain(groups.iter().flat_map(|&group| self.library.groups[group].columns.clone())).collect()
    }

    /// Normal equations of the model and these groups on all blocks.
    pub fn equations_of(&self, groups: &[usize]) -> NormalEquations {
        self.whole_of(&self.columns(groups))
    }

    /// Normal equations of these columns on all blocks.
    pub fn whole_of(&self, columns: &[usize]) -> NormalEquations {
        self.whole.select(columns)
    }

    /// Least squares with these groups on all blocks.
    pub fn solve(&self, groups: &[usize]) -> Solution {
        self.eliminated(groups).solution()
    }

    /// The columns of the model and of these groups on all blocks, eliminated.
    fn eliminated(&self, groups: &[usize]) -> Elimination {
        let mut elimination = self.own.clone();
        self.push(&mut elimination, &mut self.columns(&[]), groups);
        elimination
    }

    /// Eliminates the columns of these groups on all blocks behind those that are eliminated already.
    fn push(&self, elimination: &mut Elimination, columns: &mut Vec<usize>, groups: &[usize]) {
        for column in groups.iter().flat_map(|&group| self.library.groups[group].columns.clone()) {
            let products: Vec<f64> = columns.iter().map(|&other| self.whole.gram[(other, column)]).collect();
            elimination.push(&products, self.whole.gram[(column, column)], self.whole.moment[column]);
            columns.push(column);
        }
    }

    /// Factors of all columns of the library with these groups on all blocks; 0 for those that are not in.
    pub fn factors(&self, groups: &[usize]) -> DVector<f64> {
        let mut factors = DVector::zeros(self.library.columns.len());
        for (column, &factor) in self.columns(groups).into_iter().zip(&self.solve(groups).factors) {
            factors[column] = factor;
        }
        factors
    }

    /// Weighted normal equations of one block in these columns.
    pub fn block_equations(&self, block: usize, columns: &[usize]) -> NormalEquations {
        self.library.equations.of_block(block, columns, &self.weights)
    }

    /// The products of a column with these on one block, weighted, and its moment.
    pub(super) fn block_products(&self, block: usize, column: usize, others: &[usize]) -> (DVector<f64>, f64) {
        self.library.equations.column(block, column, others, &self.weights)
    }

    /// The share that is structure, not noise, of what these factors of all columns leave of a joint; 0 if nothing is left.
    pub fn structure(&self, joint: usize, factors: &DVector<f64>) -> f64 {
        self.library.design.structure(joint, self.correlation(joint, factors))
    }

    /// ρ₁ of what these factors of all columns leave of a joint; 0 if nothing is left.
    pub fn correlation(&self, joint: usize, factors: &DVector<f64>) -> f64 {
        let Library { equations, columns, torque, .. } = &self.library;
        equations.correlations(columns, factors, torque, joint, 1).first().copied().unwrap_or(0.0)
    }

    /// What whitens the joints of which the set leaves more than noise.
    pub fn whitening(&self) -> Whitening {
        let factors = self.factors(&self.active);
        let of_joint = |joint: usize| {
            let correlation = self.correlation(joint, &factors);
            if self.library.design.structure(joint, correlation) < WHITE { 0.0 } else { correlation }
        };
        Whitening::new((0..self.weights.len()).map(of_joint).collect())
    }

    /// Takes over the set of another search among the same candidates, with its shapes.
    ///
    /// # Errors
    /// [`ModelError`] if a column can't be computed.
    pub fn adopt(&mut self, other: &Search) -> Result<(), ModelError> {
        for &group in &other.active {
            let shape = &other.library.groups[group].shape;
            if self.library.groups[group].shape != *shape {
                self.reshape(group, shape.clone())?;
            }
        }
        self.active.clone_from(&other.active);
        self.reload()?;
        self.weigh_anew();
        Ok(())
    }

    /// Of these groups the one that leaves the least beside the set `others`, its price counted; a physical one if there is any.
    pub fn best_beside(&self, others: &[usize], groups: impl Iterator<Item = usize>) -> Option<usize> {
        let base = Base::new(self, others.to_vec());
        let judged = groups.filter_map(|group| {
            let beside = base.with(self, group);
            let effect = self.library.groups[group].effect;
            let wrong = !super::gates::are_physical(effect, &beside.factors);
            beside.shows.then_some((wrong, beside.cost + self.price_of(group), group))
        });
        judged.min_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))).map(|(_, _, group)| group)
    }

    /// Weighted squared error that is left with these groups.
    pub fn cost(&self, groups: &[usize]) -> f64 {
        self.eliminated(groups).residual_energy()
    }

    /// [`Search::cost`] plus the price of the parameters.
    pub fn priced_cost(&self, groups: &[usize]) -> f64 {
        self.cost(groups) + self.price_of_all(groups)
    }

    /// The price of the parameters of these groups.
    pub fn price_of_all(&self, groups: &[usize]) -> f64 {
        groups.iter().map(|&group| self.price_of(group)).sum()
    }

    /// The products of a column with these on all blocks, and its moment.
    pub(super) fn whole_products(&self, column: usize, others: &[usize]) -> (DVector<f64>, f64) {
        let own = self.whole.gram.column(column);
        (DVector::from_fn(others.len(), |i, _| own[others[i]]), self.whole.moment[column])
    }

    /// Error on each of these lists of blocks with these groups, fitted on the blocks of `train`.
    pub fn transfer_errors<const N: usize>(&self, groups: &[usize], train: &[usize], tests: [&[usize]; N]) -> [f64; N] {
        let columns = self.columns(groups);
        let of = |blocks: &[usize]| {
            let mut sum = NormalEquations::empty(columns.len());
            blocks.iter().for_each(|&block| sum.add(&self.block_equations(block, &columns), 1.0));
            sum
        };
        let factors = of(train).solve().factors;
        tests.map(|test| of(test).residual_energy(&factors))
    }

    /// Whether a group may enter: neither the model nor anything in the set covers it.
    pub(super) fn is_open(&self, group: usize) -> bool {
        let candidate = &self.library.groups[group];
        !self.absorbed.contains(&group)
            && !self.active.iter().any(|&other| {
                let other: &Group = &self.library.groups[other];
                other.same_place_and_effect(candidate) || other.includes(candidate)
            })
    }

    /// Whether the body absorbs a group beside this set, since all other joints have the same and only what one has more than another shows.
    pub fn is_on_all_joints(&self, set: &[usize], group: usize) -> bool {
        let groups = &self.library.groups;
        let (effect, own) = (groups[group].effect, groups[group].joint);
        let has = |joint: usize| {
            set.iter().any(|&other| groups[other].effect == effect && groups[other].joint == Some(joint))
        };
        let is_on_all = || (0..self.weights.len()).all(|joint| own == Some(joint) || has(joint));
        effect.facts.is_relative && self.library.is_body_free() && is_on_all()
    }

    /// The set with this group more, and without those that it includes or excludes.
    pub fn with(&self, group: usize) -> Vec<usize> {
        let candidate = &self.library.groups[group];
        let stays = |other: &usize| {
            let other = &self.library.groups[*other];
            !candidate.includes(other) && !candidate.excludes(other)
        };
        let mut groups: Vec<usize> = self.active.iter().copied().filter(stays).collect();
        groups.push(group);
        groups
    }

    /// Weighs the joints by what the effects found leave of them; whether one weighs clearly less than before.
    ///
    /// Beside something that no candidate explains, a small gain proves little: a form of friction that drifts or warms up
    /// copies a bit of it. What is left then counts as noise, and its neighbouring samples as one.
    pub(super) fn weigh_by_remainder(&mut self) -> bool {
        let weights = self.at_most(&self.weights);
        let falls = weights.iter().zip(&self.weights).any(|(new, old)| *new < LIGHTER * old);
        if falls {
            self.weights = weights;
            self.update();
        }
        falls
    }

    /// Weighs the joints by what the set leaves of them, whatever the sets left that were found on the way to it: what is judged by these
    /// weights is not to depend on the way.
    pub fn weigh_anew(&mut self) {
        let weights = self.at_most(&self.at_first);
        if weights != self.weights {
            self.weights = weights;
            self.update();
        }
    }

    /// These weights, or what the set leaves of a joint says if that is less.
    fn at_most(&self, weights: &[f64]) -> Vec<f64> {
        let rank = self.solve(&self.active).rank();
        let factors = self.factors(&self.active);
        let beside = |(joint, weight): (usize, &f64)| weight.min(self.library.certainty_beside(joint, &factors, rank));
        weights.iter().enumerate().map(beside).collect()
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
    pub(super) fn follow(&mut self) -> Result<(), ModelError> {
        let (factors, found) = self.found();
        if !self.library.is_altered_by(&found) {
            self.reload()?;
        } else if self.library.pass(&factors, found)? {
            self.update();
        }
        Ok(())
    }

    /// The price of a group's parameters.
    pub fn price_of(&self, group: usize) -> f64 {
        self.library.groups[group].parameter_count() as f64 * self.price
    }
}

/// The model's columns and those of some groups, eliminated once, so that one more group after the other can be tried.
pub(super) struct Base {
    /// The groups.
    pub groups: Vec<usize>,
    columns: Vec<usize>,
    /// Weighted squared error that they leave.
    pub cost: f64,
    elimination: Elimination,
}

/// What a group does beside a base.
pub(super) struct Beside {
    /// Weighted squared error that is left.
    pub cost: f64,
    /// Its factors.
    pub factors: Vec<f64>,
    /// Whether the data show any of its factors.
    pub shows: bool,
}

impl Base {
    /// The model and these groups.
    pub fn new(search: &Search, groups: Vec<usize>) -> Self {
        let columns = search.columns(&groups);
        let elimination = search.eliminated(&groups);
        Base { groups, columns, cost: elimination.residual_energy(), elimination }
    }

    /// One more group.
    pub fn with(&self, search: &Search, group: usize) -> Beside {
        let mut elimination = self.elimination.clone();
        search.push(&mut elimination, &mut self.columns.clone(), &[group]);
        let first = self.columns.len();
        Beside {
            cost: elimination.residual_energy(),
            factors: elimination.factors_from(first),
            shows: elimination.identified()[first..].iter().any(|&shows| shows),
        }
    }
}
