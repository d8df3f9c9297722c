//! The error of each block with a set of effects that was fitted on the other blocks.
//!
//! Candidates are tried one after the other beside the same set. So the set without its last group is eliminated once for each block
//! that is left out, and kept while the equations stand; each candidate then costs the square of the number of columns, not the cube.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::DVector;
use rayon::prelude::*;

use super::state::Search;
use crate::model::least_squares::{Elimination, NormalEquations};

/// So many sets are kept; that of the model alone always is.
const MOST_KEPT: usize = 64;

/// Sets that were eliminated with each block left out.
#[derive(Default)]
pub(super) struct LeftOut {
    kept: Mutex<BTreeMap<Vec<usize>, Arc<Eliminated>>>,
}

/// A set of groups, eliminated once for each block without it.
struct Eliminated {
    /// Its columns in the library.
    columns: Vec<usize>,
    by_block: Vec<BesideBlock>,
}

/// The columns of a set beside one block.
struct BesideBlock {
    /// On all other blocks, eliminated.
    others: Elimination,
    /// Their equations on the block itself.
    own: NormalEquations,
}

/// The columns of a set and others behind them, beside one block.
struct Behind {
    /// On all other blocks, eliminated.
    others: Elimination,
    /// Of each column behind the set, on the block itself: its products with all before it and with itself, and its moment.
    own: Vec<(DVector<f64>, f64)>,
}

impl LeftOut {
    /// Forgets all sets: other equations are to hold.
    pub fn forget(&mut self) {
        self.kept.get_mut().unwrap_or_else(PoisonError::into_inner).clear();
    }

    /// Forgets the sets that have one of these columns, which are replaced.
    pub fn forget_those_with(&mut self, replaced: &Range<usize>) {
        let kept = self.kept.get_mut().unwrap_or_else(PoisonError::into_inner);
        kept.retain(|_, set| !set.columns.iter().any(|column| replaced.contains(column)));
    }

    fn of(&self, search: &Search, groups: &[usize]) -> Arc<Eliminated> {
        let lock = || self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = lock().get(groups) {
            return Arc::clone(known);
        }
        let blocks = 0..search.library.equations.block_count();
        let columns = search.columns(groups);
        let by_block = if groups.is_empty() {
            let whole = search.equations_of(groups);
            let eliminate = |block: usize| {
                let own = search.block_equations(block, &columns);
                BesideBlock { others: whole.without(&own).eliminate(), own }
            };
            blocks.into_par_iter().map(eliminate).collect()
        } else {
            let before = self.of(search, &[]);
            let eliminate = |block: usize| BesideBlock {
                others: search.behind(&before, block, groups).others,
                own: search.block_equations(block, &columns),
            };
            blocks.into_par_iter().map(eliminate).collect()
        };
        let new = Arc::new(Eliminated { columns, by_block });
        let mut kept = lock();
        if kept.len() >= MOST_KEPT {
            kept.retain(|groups, _| groups.is_empty());
        }
        kept.insert(groups.to_vec(), Arc::clone(&new));
        new
    }
}

impl Search<'_> {
    /// The error of each block with these groups, fitted on the other blocks; of a single block, fitted on itself.
    pub(super) fn left_out_errors(&self, groups: &[usize]) -> Vec<f64> {
        if self.library.equations.block_count() < 2 {
            return vec![self.cost(groups)];
        }
        self.left_out_fits(groups).into_iter().map(|(_, error)| error).collect()
    }

    /// Of each block: the factors of the model and these groups, fitted on the other blocks, and its error with them.
    pub fn left_out_fits(&self, groups: &[usize]) -> Vec<(DVector<f64>, f64)> {
        let (before, last) = groups.split_at(groups.len().saturating_sub(1));
        let set = self.left_out.of(self, before);
        let fit = |block: usize| {
            let behind = self.behind(&set, block, last);
            let factors = DVector::from_vec(behind.others.factors_from(0));
            let error = set.by_block[block].own.residual_energy_with(&behind.own, &factors);
            (factors, error)
        };
        (0..self.library.equations.block_count()).into_par_iter().map(fit).collect()
    }

    /// The columns of these groups behind a set, with this block left out.
    fn behind(&self, set: &Eliminated, block: usize, groups: &[usize]) -> Behind {
        let (mut others, mut columns) = (set.by_block[block].others.clone(), set.columns.clone());
        let mut own = Vec::new();
        for column in groups.iter().flat_map(|&group| self.library.groups[group].columns.clone()) {
            columns.push(column);
            let (whole, here) = (self.whole_products(column, &columns), self.block_products(block, column, &columns));
            let products = whole.0 - &here.0;
            let before = columns.len() - 1;
            others.push(&products.as_slice()[..before], products[before], whole.1 - here.1);
            own.push(here);
        }
        Behind { others, own }
    }
}
