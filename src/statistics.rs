//! What is said of many values at once.

/// Median of |x| for a Gaussian x of deviation 1.
const MEDIAN_SIZE: f64 = 0.6745;
/// Deviation of the third differences of white noise of deviation 1: √(1 + 9 + 9 + 1).
const THIRD_DIFFERENCE: f64 = 4.472_135_954_999_579;
/// Fewest differences that tell a deviation.
const FEWEST: usize = 50;

/// The least and the greatest value; of none the least is infinite and the greatest too, below it.
pub fn ends(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let wider = |[least, most]: [f64; 2], value: f64| [least.min(value), most.max(value)];
    values.into_iter().fold([f64::INFINITY, f64::NEG_INFINITY], wider)
}

/// How far values lie apart; negative if there are none.
pub fn range<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    let [least, most] = ends(values.into_iter().copied());
    most - least
}

/// The integral of samples over ascending places, from 0 at the first on, by trapezoids.
pub fn integral(values: &[f64], over: &[f64]) -> Vec<f64> {
    let mut sum = 0.0;
    let mut integral = vec![0.0; values.len()];
    for place in 1..values.len() {
        sum += 0.5 * (values[place] + values[place - 1]) * (over[place] - over[place - 1]);
        integral[place] = sum;
    }
    integral
}

/// The value in the middle, the upper one of two; `None` of nothing.
pub fn median(values: Vec<f64>) -> Option<f64> {
    above(values, 0.5)
}

/// The value above this share of all, from 0 to 1; `None` of nothing.
pub fn above(mut values: Vec<f64>, share: f64) -> Option<f64> {
    let place = (values.len() as f64 * share) as usize;
    let place = place.min(values.len().checked_sub(1)?);
    Some(*values.select_nth_unstable_by(place, f64::total_cmp).1)
}

/// Deviation of the white noise in `runs` of a signal that is slow beside it, by the median size of third differences: slow signals
/// vanish in them, and jumps (dry friction) do not count. `None` if the runs are too short to tell.
pub fn white_noise(runs: impl IntoIterator<Item = impl AsRef<[f64]>>) -> Option<f64> {
    let mut sizes = Vec::new();
    for run in runs {
        sizes.extend(run.as_ref().windows(4).map(|x| (x[3] - 3.0 * x[2] + 3.0 * x[1] - x[0]).abs()));
    }
    if sizes.len() < FEWEST {
        return None;
    }
    median(sizes).map(|size| size / (MEDIAN_SIZE * THIRD_DIFFERENCE))
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    #[test]
    fn of_nothing_there_is_nothing_to_say() {
        assert_eq!(ends([]), [f64::INFINITY, f64::NEG_INFINITY]);
        assert!(range([]) < 0.0);
        assert_eq!((median(Vec::new()), white_noise([[0.0; 20]])), (None, None));
        assert_eq!(
            [0.0, 0.9, 1.0].map(|share| above((0..20).map(f64::from).collect(), share)),
            [0.0, 18.0, 19.0].map(Some)
        );
    }

    #[test]
    fn noise_is_told_beneath_a_slow_signal_with_jumps() {
        assert_eq!(
            (ends([3.0, -1.0, 2.0]), range(&[3.0, -1.0, 2.0]), median(vec![3.0, -1.0, 2.0])),
            ([-1.0, 3.0], 4.0, Some(2.0))
        );
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let slow = |sample: usize| 9.0 * (0.004 * sample as f64).sin() + if sample % 500 < 250 { 2.0 } else { -2.0 };
        let signal: Vec<f64> = (0..20_000)
            .map(|sample| slow(sample) + 0.3 * Distribution::<f64>::sample(&StandardNormal, &mut random))
            .collect();
        let told = white_noise(signal.chunks(5_000)).unwrap();
        assert!((told / 0.3 - 1.0).abs() < 0.03, "{told}");
    }
}
