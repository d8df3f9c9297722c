//! How steady the answer is: in how many halves of the data a family is found again.
//!
//! Blocks of data are dealt into two halves, again and again, and in each half the families are searched for anew, all in
//! the forms that the whole data gave them. What is found because a few blocks happened to favour it, or because of what was found
//! before it, is found in few halves.
//!
//! Source: Shah and Samworth, Variable selection with error control: another look at stability selection, J. R. Stat. Soc. B 75
//! (2013) 55.

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::diagnosis::search::{MARGIN, Search, gates};
use crate::model::least_squares::NormalEquations;
use crate::model::sweep::Swept;

/// How many times the blocks are dealt.
const DEALS: usize = 12;

/// The share of halves in which each of these families, given by its groups, is found.
pub fn steadiness(search: &Search, families: &[Vec<usize>]) -> Vec<f64> {
    let mut columns: Vec<usize> = search.columns(&[]);
    let own = columns.len();
    let contender = |groups: &Vec<usize>| {
        let first = columns.len();
        columns.extend(groups.iter().flat_map(|&group| search.library.groups[group].columns.clone()));
        let price: f64 = groups.iter().map(|&group| search.price_of(group)).sum();
        Contender { groups: groups.clone(), columns: (first..columns.len()).collect(), price: 0.5 * MARGIN * price }
    };
    let contenders: Vec<Contender> = families.iter().map(contender).collect();
    let blocks: Vec<NormalEquations> = (0..search.library.equations.block_count())
        .into_par_iter()
        .map(|block| search.block_equations(block, &columns))
        .collect();
    let found: Vec<Vec<bool>> = halves(blocks.len())
        .into_par_iter()
        .map(|half| {
            let mut equations = NormalEquations::empty(columns.len());
            half.iter().for_each(|&block| equations.add(&blocks[block], 1.0));
            found_in(search, Swept::new(&equations, own), &contenders)
        })
        .collect();
    let share = |family: usize| {
        let times = found.iter().filter(|found| found[family]).count();
        times as f64 / found.len().max(1) as f64
    };
    (0..families.len()).map(share).collect()
}

/// A family that is searched for.
struct Contender {
    groups: Vec<usize>,
    /// Its columns in the equations of a half.
    columns: Vec<usize>,
    /// What it must gain.
    price: f64,
}

/// Blocks in halves, each with its counterpart; the same ones every time.
fn halves(blocks: usize) -> Vec<Vec<usize>> {
    let mut chance = ChaCha8Rng::seed_from_u64(blocks as u64);
    let mut all: Vec<usize> = (0..blocks).collect();
    let mut deal = || {
        all.shuffle(&mut chance);
        let (one, other) = all.split_at(blocks / 2);
        [one.to_vec(), other.to_vec()]
    };
    (0..DEALS).flat_map(|_| deal()).collect()
}

/// Which families a half shows: the one that gains most joins, until none is worth its price; then those leave that no longer are.
fn found_in(search: &Search, mut swept: Swept, contenders: &[Contender]) -> Vec<bool> {
    let mut is_in = vec![false; contenders.len()];
    let is_physical = |contender: &Contender, factors: &[f64]| {
        let mut rest = factors;
        contender.groups.iter().all(|&group| {
            let group = &search.library.groups[group];
            let (own, others) = rest.split_at(group.columns.len());
            rest = others;
            gates::are_physical(group.effect, own)
        })
    };
    loop {
        let score = |(number, contender): (usize, &Contender)| {
            let (gain, factors) = swept.gain(&contender.columns)?;
            let surplus = gain - contender.price;
            (surplus > 0.0 && is_physical(contender, &factors)).then_some((number, surplus))
        };
        let open = contenders.iter().enumerate().filter(|(number, _)| !is_in[*number]);
        let Some((best, _)) = open.filter_map(score).max_by(|a, b| a.1.total_cmp(&b.1)) else { break };
        contenders[best].columns.iter().for_each(|&column| swept.sweep(column));
        is_in[best] = true;
    }
    loop {
        let margin = |(number, contender): (usize, &Contender)| {
            (number, swept.loss(&contender.columns).unwrap_or(0.0) - contender.price)
        };
        let there = contenders.iter().enumerate().filter(|(number, _)| is_in[*number]);
        match there.map(margin).min_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((weakest, margin)) if margin < 0.0 => {
                contenders[weakest].columns.iter().for_each(|&column| swept.sweep(column));
                is_in[weakest] = false;
            }
            _ => return is_in,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::sightings;
    use crate::effect::Family;
    use crate::model::{self, Preset};
    use crate::progress::Monitor;
    use crate::recording::split::Split;
    use crate::simulation::{Scenario, simulate};

    #[test]
    fn halves_share_nothing_and_leave_nothing_out() {
        for pair in halves(7).chunks(2) {
            let mut all = pair.concat();
            all.sort_unstable();
            assert_eq!(all, (0..7).collect::<Vec<_>>());
        }
        assert_eq!(halves(7), halves(7));
    }

    /// Coulomb friction on joints 1 and 2 is hidden in the sample, and nothing else.
    #[test]
    fn what_is_there_is_found_in_every_half() {
        let recording = simulate(&Scenario::embedded(), &Monitor::new()).unwrap();
        let split = Split::automatic(&recording);
        let body = Preset::RigidBody.model(&recording).unwrap();
        let body = model::fit(&body, &recording, &split, &Monitor::new()).unwrap();
        let (seen, _) = sightings(&body, &recording, &split, &Monitor::new()).unwrap();
        let clue = super::super::CLUES.iter().position(|clue| clue.contains("halves")).unwrap();
        let told: Vec<_> = seen.iter().map(|one| (one.family, one.joint, one.clues[clue])).collect();
        for &(family, joint, steady) in &told {
            let is_there = family == Family::DryFriction && joint.is_some_and(|joint| joint < 2);
            assert!(if is_there { steady == 1.0 } else { steady < 0.5 }, "{told:?}");
        }
    }
}
