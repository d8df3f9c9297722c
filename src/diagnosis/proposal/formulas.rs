//! Formulas for the remainder of one joint: the promising ones by thinned rows, then those among them exactly as a fit has them.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::candidates::{Candidate, Library, values};
use super::rows::{Rows, Thinning};
use super::selection::select;
use super::{Left, Proposal};
use crate::effect::{Column, Effect, Motion, NotApplicable, Scope, registry};
use crate::model::design::Design;
use crate::model::equations::{Equations, PreparedColumn};
use crate::model::fit::{interval_quantile, jackknife_error};
use crate::model::least_squares::{NormalEquations, Solution, dot};
use crate::model::{EffectTerm, ModelError};

/// Most formulas for a joint.
const MOST_FORMULAS: usize = 4;
/// How many steps tell what is promising, and how many of the best of each are.
const SCOUTING: usize = 5;
const PROMISING: usize = 10;
/// Pairs of halves of the blocks that are asked to choose.
const HALVES: usize = 12;
/// Share of the halves that must choose a formula.
const STABLE: f64 = 0.6;
/// Formulas whose columns correlate more than this, beside the model, are the same choice.
const SAME_CHOICE: f64 = 0.95;
/// From this on data hardly tell them.
const LOOKS_ALIKE: f64 = 0.985;
/// Share of the remainder that the first formula must explain on left-out blocks, and every further one.
const LEAST_FIRST: f64 = 0.05;
const LEAST_MORE: f64 = 0.02;
/// Blocks are put together into this many at most, so that leaving each out costs little.
const MOST_PARTS: usize = 32;
/// A part where a formula has to guess beyond its data counts no worse than so many times the error without it.
const WORST: f64 = 1.5;
/// A catalogue's column whose angle to a formula is this small is the same.
const SAME: f64 = 1e-9;
/// A constant is told if it is so large beside the formula's torque (RMS).
const LEAST_OFFSET: f64 = 0.1;
/// Share of a column's square that keeps the elimination of the model's columns regular.
const REGULAR: f64 = 1e-10;

/// Formulas for the remainder of a joint, given as rows, too.
pub(super) fn of_joint(
    left: &Left,
    library: &Library,
    thinning: &Thinning,
    rows: &Rows,
    joint: usize,
) -> Result<Vec<Proposal>, ModelError> {
    let promising = promising(library, left.design, thinning, rows)?;
    Exact::new(left, library, &promising, joint)?.proposals()
}

/// The prepared columns of these formulas on a joint.
pub(super) fn columns(design: &Design, texts: &[&str], joint: usize) -> Result<Vec<PreparedColumn>, ModelError> {
    design.prepare(|run, load| {
        let motion = Motion { load, ..design.setting().motion(run) };
        let column = |text: &&str| {
            let values = values(text, &motion).map_err(|lack| NotApplicable { effect: "a proposal", lack })?;
            Ok(Column { parts: vec![(joint, values)] })
        };
        texts.iter().map(column).collect()
    })
}

/// The candidates (by place in the library) that thinned rows find worth a look.
fn promising(library: &Library, design: &Design, thinning: &Thinning, rows: &Rows) -> Result<Vec<usize>, ModelError> {
    let setting = design.setting();
    let mut atoms: Vec<Vec<Vec<f64>>> = Vec::new();
    for run in thinning.runs() {
        let load = setting.load(run);
        let motion = Motion { load: load.as_ref(), ..setting.motion(run) };
        let of_run: Result<_, _> = library.atoms.iter().map(|atom| atom.values(&motion)).collect();
        atoms.push(of_run.map_err(|lack| NotApplicable { effect: "a proposal", lack })?);
    }
    let rows_of = |candidate: &Candidate| {
        let series: Vec<Vec<f64>> = atoms.iter().map(|atoms| candidate.values(atoms)).collect();
        thinning.rows_of(&series)
    };
    let columns: Vec<Vec<f64>> = library.candidates.par_iter().map(rows_of).collect();
    let raw = DMatrix::from_iterator(rows.target.len(), columns.len(), columns.into_iter().flatten());
    let whole: Vec<f64> = raw.column_iter().map(|column| column.norm_squared()).collect();
    let columns = rows.beside_model(raw);
    // What the model could take of a formula is no news.
    let size = |(column, whole): (nalgebra::DVectorView<f64>, &f64)| match column.norm_squared() {
        left if left > 1e-4 * whole => left,
        _ => 0.0,
    };
    let sizes: Vec<f64> = columns.column_iter().zip(&whole).map(size).collect();
    let moments = columns.tr_mul(&rows.target);
    let costs: Vec<usize> = library.candidates.iter().map(|candidate| candidate.cost).collect();
    let picks = select(&sizes, moments.as_slice(), &costs, SCOUTING, |candidate| {
        columns.tr_mul(&columns.column(candidate)).iter().copied().collect()
    });
    let mut promising: Vec<usize> = Vec::new();
    for pick in picks {
        let mut ranking: Vec<usize> = (0..pick.gains.len()).collect();
        ranking.sort_by(|&one, &other| pick.gains[other].total_cmp(&pick.gains[one]));
        promising.push(pick.candidate);
        promising.extend(ranking.into_iter().take(PROMISING).filter(|&candidate| pick.gains[candidate] > 0.0));
    }
    promising.sort_unstable();
    promising.dedup();
    Ok(promising)
}

/// Some formulas beside the model and a constant, as columns of the design.
struct Exact<'a> {
    left: &'a Left<'a>,
    joint: usize,
    candidates: Vec<&'a Candidate>,
    /// Columns of the model, the constant, the candidates.
    columns: Vec<PreparedColumn>,
    /// How many there are before the candidates.
    base: usize,
    equations: Equations,
    /// Blocks that are left out together, and their weighted equations.
    parts: Vec<(Range<usize>, NormalEquations)>,
    whole: NormalEquations,
}

/// Equations of the candidates, with what the model and the constant share with them taken out.
struct Beside {
    gram: DMatrix<f64>,
    moment: DVector<f64>,
}

impl<'a> Exact<'a> {
    fn new(left: &'a Left<'a>, library: &'a Library, promising: &[usize], joint: usize) -> Result<Self, ModelError> {
        let design = left.design;
        let candidates: Vec<&Candidate> = promising.iter().map(|&place| &library.candidates[place]).collect();
        let mut columns = left.columns.clone();
        let texts: Vec<&str> =
            std::iter::once("1").chain(candidates.iter().map(|candidate| candidate.text.as_str())).collect();
        columns.extend(self::columns(design, &texts, joint)?);
        let equations = design.equations(&columns, &left.whole);
        let count = equations.block_count();
        let parts = count.min(MOST_PARTS);
        let parts: Vec<(Range<usize>, NormalEquations)> = (0..parts)
            .map(|part| {
                let blocks = part * count / parts..(part + 1) * count / parts;
                let sum = equations.total(&left.weights, |block| blocks.contains(&block));
                (blocks, sum)
            })
            .collect();
        let mut whole = NormalEquations::empty(columns.len());
        parts.iter().for_each(|(_, part)| whole.add(part, 1.0));
        Ok(Exact { left, joint, candidates, base: left.columns.len() + 1, columns, equations, parts, whole })
    }

    /// The formulas that are stable and that left-out blocks confirm, each beside those before it.
    fn proposals(&self) -> Result<Vec<Proposal>, ModelError> {
        let costs: Vec<usize> = self.candidates.iter().map(|candidate| candidate.cost).collect();
        let all = self.beside(&self.whole);
        let path: Vec<usize> = all.select(&costs).into_iter().map(|pick| pick.candidate).collect();
        let halves = self.choices_of_halves(&costs);
        let is_same = |one: usize, other: usize, least: f64| one == other || all.correlation(one, other).abs() > least;
        let mut proposals: Vec<Proposal> = Vec::new();
        let mut chosen: Vec<usize> = Vec::new();
        let alone = self.left_out_energies(&chosen);
        let nothing: f64 = alone.iter().sum();
        let mut before = nothing;
        for candidate in path {
            let choosing = |half: &&Vec<usize>| half.iter().any(|&other| is_same(candidate, other, SAME_CHOICE));
            let stability = halves.iter().filter(choosing).count() as f64 / halves.len().max(1) as f64;
            chosen.push(candidate);
            let energies = self.left_out_energies(&chosen);
            let after: f64 = energies.iter().zip(&alone).map(|(left, alone)| left.min(WORST * alone)).sum();
            let share = (before - after) / nothing.max(f64::MIN_POSITIVE);
            let least = if proposals.is_empty() { LEAST_FIRST } else { LEAST_MORE };
            if share < least || (stability < STABLE && !halves.is_empty()) {
                break;
            }
            before = after;
            let mut look_alikes: Vec<usize> = (0..self.candidates.len())
                .filter(|&other| other != candidate && is_same(candidate, other, LOOKS_ALIKE))
                .collect();
            look_alikes.sort_by(|&one, &other| {
                all.correlation(candidate, other).abs().total_cmp(&all.correlation(candidate, one).abs())
            });
            let look_alikes =
                look_alikes.into_iter().take(3).map(|other| self.candidates[other].text.clone()).collect();
            proposals.push(self.proposal(&chosen, share, stability, look_alikes)?);
        }
        Ok(proposals)
    }

    /// The last of the `chosen` formulas, with its numbers.
    fn proposal(
        &self,
        chosen: &[usize],
        share: f64,
        stability: f64,
        look_alikes: Vec<String>,
    ) -> Result<Proposal, ModelError> {
        let last = chosen.len() - 1;
        let candidate = self.candidates[chosen[last]];
        let places = self.places(chosen);
        let value_of = |solution: &Solution| solution.factors[self.base + last];
        let offset_of = |solution: &Solution| solution.factors[self.base - 1];
        let all = self.whole.select(&places).solve();
        let gained = |equations: &NormalEquations, size: f64| {
            let without = equations.select(&places[..places.len() - 1]).solve().residual_energy;
            (without - equations.select(&places).solve().residual_energy) / size.max(f64::MIN_POSITIVE)
        };
        // What each part has of the remainder of this joint, beside the model alone.
        let model = self.whole.select(&self.places(&[])).solve().factors;
        let weight = self.left.weights[self.joint];
        let sizes: Vec<f64> = self.parts.iter().map(|(blocks, _)| weight * self.energy(blocks, &[], &model)).collect();
        let size: f64 = sizes.iter().sum();
        let (mut values, mut offsets, mut shares) = (Vec::new(), Vec::new(), Vec::new());
        for ((_, part), own) in self.parts.iter().zip(&sizes) {
            let rest = self.whole.without(part);
            let solution = rest.select(&places).solve();
            values.push(value_of(&solution));
            offsets.push(offset_of(&solution));
            shares.push(gained(&rest, size - own));
        }
        let (value, offset) = (value_of(&all), offset_of(&all));
        let around = |middle: f64, values: &[f64]| half_width(values).map(|half| [middle - half, middle + half]);
        let share_interval = around(share, &shares).map(|[low, high]| [low.max(0.0), high.min(1.0)]);
        let column = &self.columns[self.base + chosen[last]];
        let samples = self.left.design.sample_count(self.joint).max(1) as f64;
        let rms = value.abs() * (self.product(column, column) / samples).sqrt();
        let shows = around(offset, &offsets).is_some_and(|[low, high]| low > 0.0 || high < 0.0);
        Ok(Proposal {
            joint: self.joint,
            formula: candidate.text.clone(),
            value,
            interval: around(value, &values),
            unit: candidate.unit(self.left.design.setting().kinds[self.joint]),
            share,
            share_interval,
            stability,
            look_alikes,
            offset: Some(offset).filter(|offset| shows && offset.abs() > LEAST_OFFSET * rms),
            known: self.known(column)?,
        })
    }

    /// The effect of the catalogue whose only column is this one.
    fn known(&self, column: &PreparedColumn) -> Result<Option<&'static Effect>, ModelError> {
        let own = self.product(column, column);
        let is_plain = |effect: &&'static Effect| {
            effect.scope == Scope::Joint && effect.parameters.len() == 1 && !effect.changes_others()
        };
        for effect in registry::addable().filter(is_plain) {
            let term = EffectTerm { effect, joint: Some(self.joint) };
            // What these data do not allow is not what was found in them.
            let Ok(columns) = self.left.design.effect_columns(&term, &[]) else { continue };
            let [other] = &columns[..] else { continue };
            let shared = self.product(column, other);
            if shared * shared >= (1.0 - SAME) * own * self.product(other, other) && shared > 0.0 {
                return Ok(Some(effect));
            }
        }
        Ok(None)
    }

    /// Σ of the products of two columns on this joint.
    fn product(&self, one: &PreparedColumn, other: &PreparedColumn) -> f64 {
        let blocks = self.left.design.blocks().iter();
        blocks.map(|block| dot(one.cut(block, self.joint), other.cut(block, self.joint))).sum()
    }

    /// Places of the columns of the model, the constant and these formulas.
    fn places(&self, chosen: &[usize]) -> Vec<usize> {
        (0..self.base).chain(chosen.iter().map(|candidate| self.base + candidate)).collect()
    }

    /// What these factors of the model, the constant and the formulas leave of some blocks on this joint \[(N m)²\].
    fn energy(&self, blocks: &Range<usize>, chosen: &[usize], factors: &DVector<f64>) -> f64 {
        let mut all = DVector::zeros(self.columns.len());
        self.places(chosen).into_iter().zip(factors).for_each(|(place, factor)| all[place] = *factor);
        blocks.clone().map(|block| self.equations.residual_energy(block, self.joint, &all)).sum()
    }

    /// What is left of this joint on each part, with all factors found on the others.
    fn left_out_energies(&self, chosen: &[usize]) -> Vec<f64> {
        let places = self.places(chosen);
        let left_out = |(blocks, part): &(Range<usize>, NormalEquations)| {
            self.energy(blocks, chosen, &self.whole.without(part).select(&places).solve().factors)
        };
        self.parts.iter().map(left_out).collect()
    }

    fn beside(&self, equations: &NormalEquations) -> Beside {
        let (base, count) = (self.base, self.columns.len() - self.base);
        let scale = DVector::from_fn(base, |i, _| equations.gram[(i, i)].max(f64::MIN_POSITIVE).sqrt().recip());
        let known = DMatrix::from_fn(base, base, |i, j| {
            equations.gram[(i, j)] * scale[i] * scale[j] + if i == j { REGULAR } else { 0.0 }
        });
        let shared = DMatrix::from_fn(base, count, |i, j| equations.gram[(i, base + j)] * scale[i]);
        let moment = DVector::from_fn(base, |i, _| equations.moment[i] * scale[i]);
        let mut gram = equations.gram.view((base, base), (count, count)).into_owned();
        let mut rest = equations.moment.rows(base, count).into_owned();
        if let Some(known) = known.cholesky() {
            gram -= shared.tr_mul(&known.solve(&shared));
            rest -= shared.tr_mul(&known.solve(&moment));
        }
        Beside { gram, moment: rest }
    }

    /// What halves of the data choose; nothing if there are too few blocks to halve.
    fn choices_of_halves(&self, costs: &[usize]) -> Vec<Vec<usize>> {
        if self.parts.len() < 4 {
            return Vec::new();
        }
        let mut random = ChaCha8Rng::seed_from_u64(0);
        let mut order: Vec<usize> = (0..self.parts.len()).collect();
        let mut halves: Vec<Vec<usize>> = Vec::new();
        for _ in 0..HALVES {
            order.shuffle(&mut random);
            let (one, other) = order.split_at(order.len() / 2);
            halves.extend([one.to_vec(), other.to_vec()]);
        }
        let choice = |half: &Vec<usize>| {
            let mut sum = NormalEquations::empty(self.columns.len());
            half.iter().for_each(|&part| sum.add(&self.parts[part].1, 1.0));
            self.beside(&sum).select(costs).into_iter().map(|pick| pick.candidate).collect()
        };
        halves.iter().map(choice).collect()
    }
}

impl Beside {
    fn select(&self, costs: &[usize]) -> Vec<super::selection::Pick> {
        select(self.gram.diagonal().as_slice(), self.moment.as_slice(), costs, MOST_FORMULAS, |candidate| {
            self.gram.column(candidate).iter().copied().collect()
        })
    }

    fn correlation(&self, one: usize, other: usize) -> f64 {
        let sizes = self.gram[(one, one)] * self.gram[(other, other)];
        if sizes > 0.0 { self.gram[(one, other)] / sizes.sqrt() } else { 0.0 }
    }
}

/// Half of the 95 % interval, by the values that were found with each part left out in turn (the jackknife); `None` with fewer
/// than three.
fn half_width(values: &[f64]) -> Option<f64> {
    let count = values.len();
    (count >= 3).then(|| interval_quantile(count) * jackknife_error(values.iter().copied()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The values of a mean with each of n numbers left out have the jackknife error s/√n.
    #[test]
    fn the_interval_of_a_mean_is_that_of_students_t() {
        let numbers = [1.0, 2.0, 4.0, 9.0];
        let (count, sum) = (numbers.len() as f64, numbers.iter().sum::<f64>());
        let mean = sum / count;
        let variance = numbers.iter().map(|number| (number - mean).powi(2)).sum::<f64>() / (count - 1.0);
        let without: Vec<f64> = numbers.iter().map(|number| (sum - number) / (count - 1.0)).collect();
        let expected = interval_quantile(numbers.len()) * (variance / count).sqrt();
        assert!((half_width(&without).unwrap() - expected).abs() < 1e-12);
        assert_eq!(half_width(&without[..2]), None);
    }

    #[test]
    fn formulas_correlate_by_their_angle() {
        let gram = DMatrix::from_row_slice(3, 3, &[4.0, 3.0, 0.0, 3.0, 9.0, 0.0, 0.0, 0.0, 0.0]);
        let beside = Beside { gram, moment: DVector::zeros(3) };
        assert_eq!((beside.correlation(0, 1), beside.correlation(1, 1)), (0.5, 1.0));
        assert_eq!(beside.correlation(0, 2), 0.0, "what is nothing correlates with nothing");
    }
}
