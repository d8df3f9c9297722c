//! On which channels the remainder depends, whatever the formula: a flexible basis of one channel, or of two with their
//! products, is asked to predict blocks that were left out.

use std::ops::Range;

use nalgebra::DMatrix;

use super::rows::{Rows, Thinning};
use super::{Dependence, Step};
use crate::effect::sign;
use crate::model::least_squares::NormalEquations;
use crate::recording::Pick;
use crate::recording::Trajectory;
use crate::statistics::ends;

/// Parts of the data, each of which is left out once.
const FOLDS: usize = 5;
/// Share of a column's squared length that prices its factor.
const DAMPING: f64 = 3e-3;
/// A part where the basis has to guess beyond its data counts no worse than so many times the error without it.
const WORST: f64 = 1.5;
/// Speeds below this share of the largest count as near zero.
const NEAR: f64 = 0.05;
/// A pair is told if it predicts so much more than either of its channels.
const MORE: f64 = 0.03;
/// The next channel in the order must predict so much more.
const ENOUGH: f64 = 0.02;
/// Most channels in an order, and most pairs that are told.
const MOST: usize = 4;

/// A channel of the motion and its basis.
struct Channel {
    name: String,
    /// The columns of its functions.
    own: Range<usize>,
    /// Those functions that are multiplied with another channel's: the series of each along the trajectories.
    factors: Vec<Vec<Vec<f64>>>,
}

/// All channels and pairs, as columns of one matrix.
pub struct Basis {
    channels: Vec<Channel>,
    /// Two channels and the columns of their products.
    pairs: Vec<([usize; 2], Range<usize>)>,
    /// Prepared rows of all columns.
    columns: DMatrix<f64>,
}

/// What the basis finds in a remainder.
pub struct Found {
    /// Each channel alone, the best first.
    pub alone: Vec<Dependence>,
    /// Pairs that predict more than their channels do.
    pub pairs: Vec<Dependence>,
    /// Which channel first, which next.
    pub order: Vec<Step>,
    /// Share of the remainder that the best of all this predicts.
    pub predicted: f64,
}

/// Functions of a channel between −1 and 1: Chebyshev's polynomials, and around a standstill where it is a speed.
fn functions(values: &[f64], [low, high]: [f64; 2], is_speed: bool, count: usize) -> Vec<Vec<f64>> {
    let middle = 0.5 * (low + high);
    let half = (0.5 * (high - low)).max(f64::MIN_POSITIVE);
    let largest = low.abs().max(high.abs()).max(f64::MIN_POSITIVE);
    let polynomial = |order: usize| {
        let value = |&value: &f64| (order as f64 * ((value - middle) / half).clamp(-1.0, 1.0).acos()).cos();
        values.iter().map(value).collect()
    };
    let mut functions: Vec<Vec<f64>> = (1..=count).map(polynomial).collect();
    if is_speed {
        functions.push(values.iter().map(|&speed| sign(speed)).collect());
        functions.push(values.iter().map(|&speed| (speed / (NEAR * largest)).tanh()).collect());
    }
    functions
}

impl Basis {
    /// The basis of all channels along a recording, and of the pairs of positions and speeds.
    pub fn new(thinning: &Thinning) -> Basis {
        let joints = thinning.runs().next().map_or(0, Trajectory::joint_count);
        let signals: [(&str, Pick, usize); 3] =
            [("q", |run| &run.q, 6), ("qd", |run| &run.qd, 5), ("qdd", |run| &run.qdd, 3)];
        let mut basis = Basis { channels: Vec::new(), pairs: Vec::new(), columns: DMatrix::zeros(0, 0) };
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for (word, signal, count) in signals {
            for joint in 0..joints {
                let series: Vec<Vec<f64>> = thinning.runs().map(|run| signal(run)[joint].to_vec()).collect();
                basis.add(format!("{word}{}", joint + 1), &series, word == "qd", count, thinning, &mut columns);
            }
        }
        let time: Vec<Vec<f64>> = thinning.runs().map(|run| run.since_start().collect()).collect();
        basis.add("t".to_owned(), &time, false, 4, thinning, &mut columns);
        // Pairs of positions and speeds.
        for first in 0..2 * joints {
            for second in first + 1..2 * joints {
                let start = columns.len();
                for one in 0..basis.channels[first].factors.len() {
                    for other in 0..basis.channels[second].factors.len() {
                        let [one, other] =
                            [&basis.channels[first].factors[one], &basis.channels[second].factors[other]];
                        let product = |(one, other): (&Vec<f64>, &Vec<f64>)| {
                            one.iter().zip(other).map(|(one, other)| one * other).collect()
                        };
                        let series: Vec<Vec<f64>> = one.iter().zip(other).map(product).collect();
                        columns.push(thinning.rows_of(&series));
                    }
                }
                basis.pairs.push(([first, second], start..columns.len()));
            }
        }
        let rows = columns.first().map_or(0, Vec::len);
        basis.columns = DMatrix::from_iterator(rows, columns.len(), columns.into_iter().flatten());
        basis
    }

    fn add(
        &mut self,
        name: String,
        series: &[Vec<f64>],
        is_speed: bool,
        count: usize,
        thinning: &Thinning,
        columns: &mut Vec<Vec<f64>>,
    ) {
        let range = ends(series.iter().flatten().copied());
        let by_run: Vec<Vec<Vec<f64>>> =
            series.iter().map(|values| functions(values, range, is_speed, count)).collect();
        let functions = by_run.first().map_or(0, Vec::len);
        let start = columns.len();
        let series_of = |function: usize| by_run.iter().map(|run| run[function].clone()).collect::<Vec<_>>();
        columns.extend((0..functions).map(|function| thinning.rows_of(&series_of(function))));
        // The first three polynomials, and the direction of a speed.
        let multiplied = (0..functions.min(3)).chain(is_speed.then_some(count));
        let factors = multiplied.map(series_of).collect();
        self.channels.push(Channel { name, own: start..columns.len(), factors });
    }

    /// What it finds in the remainder of a joint.
    pub fn find(&self, rows: &Rows) -> Found {
        let columns = rows.beside_model(self.columns.clone());
        let share = |places: &[usize]| predicted(&columns, rows, places);
        let own = |channel: usize| self.channels[channel].own.clone();
        let shares: Vec<f64> =
            (0..self.channels.len()).map(|channel| share(&own(channel).collect::<Vec<_>>())).collect();
        let named = |channels: &[usize], share: f64| {
            let channels = channels.iter().map(|&channel| self.channels[channel].name.clone()).collect();
            Dependence { channels, share }
        };
        let mut alone: Vec<Dependence> = (0..shares.len()).map(|channel| named(&[channel], shares[channel])).collect();
        alone.sort_by(|one, other| other.share.total_cmp(&one.share));
        let all_of = |chosen: &[usize]| -> Vec<usize> {
            let inside = self.pairs.iter().filter(|([one, other], _)| chosen.contains(one) && chosen.contains(other));
            chosen
                .iter()
                .flat_map(|&channel| own(channel))
                .chain(inside.flat_map(|(_, products)| products.clone()))
                .collect()
        };
        let mut pairs: Vec<([usize; 2], f64)> =
            self.pairs.iter().map(|(pair, _)| (*pair, share(&all_of(pair)))).collect();
        pairs.sort_by(|one, other| other.1.total_cmp(&one.1));
        let best_alone = shares.iter().copied().fold(0.0, f64::max);
        let mut order: Vec<usize> = Vec::new();
        let mut steps: Vec<Step> = Vec::new();
        // Two channels that only together say something are found as a pair.
        if let Some(&(pair, together)) = pairs.first()
            && together > best_alone + ENOUGH
            && !pair.iter().any(|&channel| shares[channel] >= best_alone - ENOUGH)
        {
            order = pair.to_vec();
            order.sort_by(|&one, &other| shares[other].total_cmp(&shares[one]));
            steps = vec![
                Step { channel: self.channels[order[0]].name.clone(), share: shares[order[0]].max(0.0) },
                Step { channel: self.channels[order[1]].name.clone(), share: together },
            ];
        }
        while order.len() < MOST {
            let before = steps.last().map_or(0.0, |step| step.share);
            let with = |&channel: &usize| {
                let chosen: Vec<usize> = order.iter().copied().chain([channel]).collect();
                (channel, share(&all_of(&chosen)))
            };
            let rest: Vec<usize> = (0..self.channels.len()).filter(|channel| !order.contains(channel)).collect();
            let best = rest.iter().map(with).max_by(|one, other| one.1.total_cmp(&other.1));
            let Some((channel, share)) = best.filter(|(_, share)| *share > before + ENOUGH) else { break };
            order.push(channel);
            steps.push(Step { channel: self.channels[channel].name.clone(), share });
        }
        let predicted = steps.last().map_or(0.0, |step| step.share).max(best_alone);
        let is_more =
            |&([one, other], share): &([usize; 2], f64)| share > shares[one].max(shares[other]).max(0.0) + MORE;
        let pairs = pairs.into_iter().filter(is_more).take(MOST).map(|(pair, share)| named(&pair, share)).collect();
        Found { alone, pairs, order: steps, predicted }
    }
}

/// Share of the remainder that these columns predict of parts of the data that they have not seen; negative if they do harm.
fn predicted(columns: &DMatrix<f64>, rows: &Rows, places: &[usize]) -> f64 {
    let mut folds = vec![NormalEquations::empty(places.len()); FOLDS];
    for (number, block) in rows.blocks.iter().enumerate() {
        let part = columns.rows_range(block.clone()).select_columns(places);
        let target = rows.target.rows_range(block.clone());
        let equations =
            NormalEquations { gram: part.tr_mul(&part), moment: part.tr_mul(&target), energy: target.norm_squared() };
        folds[number % FOLDS].add(&equations, 1.0);
    }
    let mut whole = NormalEquations::empty(places.len());
    folds.iter().for_each(|fold| whole.add(fold, 1.0));
    let after = |fold: &NormalEquations| {
        let factors = whole.without(fold).damped(DAMPING).solve().factors;
        fold.residual_energy(&factors).min(WORST * fold.energy)
    };
    if whole.energy <= 0.0 { 0.0 } else { 1.0 - folds.iter().map(after).sum::<f64>() / whole.energy }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;

    /// Chebyshev's polynomials are cos(n arccos x) between the ends, and a speed has its direction, sharp and soft.
    #[test]
    fn a_channel_is_laid_out_between_its_ends() {
        let values = [1.0, 2.0, 3.0, 4.0, 5.0];
        let found = functions(&values, [1.0, 5.0], false, 3);
        let x = [-1.0, -0.5, 0.0, 0.5, 1.0];
        let exact = [x.map(|x| x), x.map(|x| 2.0 * x * x - 1.0), x.map(|x| 4.0 * x * x * x - 3.0 * x)];
        assert_eq!(found.len(), exact.len());
        for (found, exact) in found.iter().zip(exact) {
            assert!(found.iter().zip(exact).all(|(found, exact)| (found - exact).abs() < 1e-12), "{found:?}");
        }
        let speeds = [-2.0, 0.0, 1.0];
        let found = functions(&speeds, [-2.0, 1.0], true, 1);
        assert_eq!(found.len(), 3);
        assert_eq!(found[1], [-1.0, 0.0, 1.0]);
        assert_eq!(found[2], speeds.map(|speed| (speed / (2.0 * NEAR)).tanh()));
    }

    /// A column that is the target predicts all of it but what its price takes, one that has nothing to do with it nothing, and of
    /// nothing there is nothing to predict.
    #[test]
    fn what_is_predicted_is_a_share_of_what_was_left_out() {
        let wave = |rate: f64| DVector::from_fn(200, |row, _| (rate * row as f64).sin());
        let target = wave(0.37);
        let columns = DMatrix::from_columns(&[target.clone(), wave(1.91)]);
        let rows = Rows::of_blocks((0..20).map(|block| 10 * block..10 * block + 10).collect(), target);
        let share = |places: &[usize]| predicted(&columns, &rows, places);
        assert!((1.0 - share(&[0])).abs() < 1e-4 && share(&[1]).abs() < 0.05, "{} {}", share(&[0]), share(&[1]));
        assert!(share(&[0, 1]) > 0.99);
        let nothing = Rows::of_blocks(vec![0..100, 100..200], DVector::zeros(200));
        assert_eq!(predicted(&columns, &nothing, &[0]), 0.0);
    }
}
