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

/// So many sets are kept.
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
        let columns = search.columns(groups);
        let whole = search.equations_of(groups);
        let eliminate = |block: usize| whole.without(&search.block_equations(block, &columns)).eliminate();
        let by_block = (0..search.library.equations.block_count()).into_par_iter().map(eliminate).collect();
        let new = Arc::new(Eliminated { columns, by_block });
        let mut kept = lock();
        if kept.len() >= MOST_KEPT {
            kept.clear();
        }
        kept.insert(groups.to_vec(), Arc::clone(&new));
        new
    }
}

impl Search<'_> {
    /// The error of each block with these groups, fitted on the other blocks; of a single block, fitted on itself.
    pub(super) fn left_out_errors(&self, groups: &[usize]) -> Vec<f64> {
        let blocks = self.library.equations.block_count();
        if blocks < 2 {
            return vec![self.cost(groups)];
        }
        let (before, last) = groups.split_at(groups.len().saturating_sub(1));
        let set = self.left_out.of(self, before);
        let added: Vec<usize> = last.iter().flat_map(|&group| self.library.groups[group].columns.clone()).collect();
        let error = |block: usize| {
            let mut elimination = set.by_block[block].clone();
            let mut columns = set.columns.clone();
            for &column in &added {
                let products: Vec<f64> =
                    columns.iter().map(|&other| self.product_without(block, other, column)).collect();
                let moment = self.moment_without(block, column);
                elimination.push(&products, self.product_without(block, column, column), moment);
                columns.push(column);
            }
            let factors = DVector::from_vec(elimination.factors_from(0));
            self.block_equations(block, &columns).residual_energy(&factors)
        };
        (0..blocks).into_par_iter().map(error).collect()
    }
}
