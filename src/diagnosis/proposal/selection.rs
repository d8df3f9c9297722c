//! Forward selection: the formula that takes most of what is left, then the one that takes most beside it, and so on
//! (orthogonal least squares: Chen, Billings and Luo, Int. J. Control 50 (1989) 1873).

/// Of formulas that explain nearly as much as the best, within this share, the simplest is taken.
const NEARLY: f64 = 0.015;
/// Share of a formula's own size that must be left beside those before it.
const INDEPENDENT: f64 = 1e-4;

/// One formula that was selected.
#[derive(Debug, Clone, PartialEq)]
pub struct Pick {
    /// Which.
    pub candidate: usize,
    /// By how much every candidate would lower the squared error at this step.
    pub gains: Vec<f64>,
}

/// Selects up to `steps` candidates. `sizes` are their squared lengths beside the model, `moments` their products with what is
/// left, and `products` gives those of one with all.
pub fn select(
    sizes: &[f64],
    moments: &[f64],
    costs: &[usize],
    steps: usize,
    mut products: impl FnMut(usize) -> Vec<f64>,
) -> Vec<Pick> {
    let (mut left, mut moments) = (sizes.to_vec(), moments.to_vec());
    // Coordinates of every candidate along the directions of those that were picked.
    let mut along: Vec<Vec<f64>> = Vec::new();
    let mut picks: Vec<Pick> = Vec::new();
    for _ in 0..steps {
        let gain = |candidate: usize| match left[candidate] > INDEPENDENT * sizes[candidate] {
            true => moments[candidate].powi(2) / left[candidate],
            false => 0.0,
        };
        let gains: Vec<f64> = (0..sizes.len()).map(gain).collect();
        let best = gains.iter().copied().fold(0.0, f64::max);
        let close = (0..sizes.len()).filter(|&candidate| gains[candidate] >= (1.0 - NEARLY) * best);
        let simplest =
            close.min_by(|&one, &other| costs[one].cmp(&costs[other]).then(gains[other].total_cmp(&gains[one])));
        let Some(candidate) = simplest.filter(|_| best > 0.0) else { break };
        let length = left[candidate].sqrt();
        let mut coordinates = products(candidate);
        for earlier in &along {
            let own = earlier[candidate];
            coordinates.iter_mut().zip(earlier).for_each(|(coordinate, earlier)| *coordinate -= own * earlier);
        }
        coordinates.iter_mut().for_each(|coordinate| *coordinate /= length);
        let moment = moments[candidate] / length;
        for (place, coordinate) in coordinates.iter().enumerate() {
            left[place] -= coordinate.powi(2);
            moments[place] -= coordinate * moment;
        }
        along.push(coordinates);
        picks.push(Pick { candidate, gains });
    }
    picks
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;

    /// Six columns, of which the fourth is nearly the first and dearer.
    fn columns() -> DMatrix<f64> {
        let mut columns = DMatrix::from_fn(60, 6, |i, j| ((i * (j + 3)) as f64 * 0.37 + j as f64).sin());
        let nearly = columns.column(0) * 2.0 + columns.column(5) * 1e-3;
        columns.set_column(3, &nearly);
        columns
    }

    fn picked(columns: &DMatrix<f64>, target: &DVector<f64>, costs: &[usize]) -> Vec<Pick> {
        let gram = columns.tr_mul(columns);
        let moments = columns.tr_mul(target);
        select(gram.diagonal().as_slice(), moments.as_slice(), costs, 3, |place| {
            gram.column(place).iter().copied().collect()
        })
    }

    #[test]
    fn what_made_the_target_is_picked_and_of_equals_the_simplest() {
        let columns = columns();
        let target = columns.column(3) * 1.0 + columns.column(4) * 0.7;
        let order =
            |costs: &[usize]| picked(&columns, &target, costs).iter().map(|pick| pick.candidate).collect::<Vec<_>>();
        assert_eq!(order(&[1, 1, 1, 5, 1, 1])[..2], [0, 4]);
        assert_eq!(order(&[5, 1, 1, 1, 1, 1])[..2], [3, 4]);
    }

    /// The gain of a step is what least squares gains by it.
    #[test]
    fn gains_are_those_of_least_squares() {
        let columns = columns();
        let target = DVector::from_fn(60, |i, _| (i as f64 * 0.11).cos());
        let left = |chosen: &[usize]| {
            let matrix = columns.select_columns(chosen);
            let factors = matrix.clone().svd(true, true).solve(&target, 1e-12).unwrap();
            (&target - matrix * factors).norm_squared()
        };
        let picks = picked(&columns, &target, &[1; 6]);
        let chosen: Vec<usize> = picks.iter().map(|pick| pick.candidate).collect();
        let mut before = target.norm_squared();
        for (step, pick) in picks.iter().enumerate() {
            let after = left(&chosen[..=step]);
            assert!((before - after - pick.gains[pick.candidate]).abs() < 1e-9 * target.norm_squared());
            before = after;
        }
    }
}
