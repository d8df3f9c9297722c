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
use crate::model::least_squares::Elimination;

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
    by_block: Vec<Elimination>,
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
            let eliminate = |block: usize| whole.without(&search.block_equations(block, &columns)).eliminate();
            blocks.into_par_iter().map(eliminate).collect()
        } else {
            let own = self.of(search, &[]);
            let eliminate = |block: usize| search.behind(&own, block, groups).0;
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
            let (elimination, columns) = self.behind(&set, block, last);
            let factors = DVector::from_vec(elimination.factors_from(0));
            let error = self.block_error(block, &columns, &factors);
            (factors, error)
        };
        (0..self.library.equations.block_count()).into_par_iter().map(fit).collect()
    }

    /// With this block left out: the columns of these groups, eliminated behind a set; and all columns then.
    fn behind(&self, set: &Eliminated, block: usize, groups: &[usize]) -> (Elimination, Vec<usize>) {
        let (mut elimination, mut columns) = (set.by_block[block].clone(), set.columns.clone());
        for column in groups.iter().flat_map(|&group| self.library.groups[group].columns.clone()) {
            let products: Vec<f64> = columns.iter().map(|&other| self.product_without(block, other, column)).collect();
            let moment = self.moment_without(block, column);
            elimination.push(&products, self.product_without(block, column, column), moment);
            columns.push(column);
        }
        (elimination, columns)
    }
}
