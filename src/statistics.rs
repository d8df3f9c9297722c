//! What is said of many values at once.

/// Median of |x| for a Gaussian x of deviation 1.
const MEDIAN_SIZE: f64 = 0.6745;
/// Deviation of the third differences of white noise of deviation 1: √(1 + 9 + 9 + 1).
const THIRD_DIFFERENCE: f64 = 4.472_135_954_999_579;
/// The same of sixth differences: √(Σ binomial(6, k)²).
const SIXTH_DIFFERENCE: f64 = 30.397_368_307_141_33;
/// Noise is white if what is told at one step between samples is less than so many times that at half the step: a filter of first order
/// makes it up to twice as much, interpolation and what is no noise 63 times.
const OF_HALF_THE_STEP: f64 = 2.2;
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

/// Deviation of the white noise in `runs` of a signal that is smooth beside it, by the median size of sixth differences of neighbours, of
/// every second sample, every fourth and so on, not further apart than the `widest` step. `None` if these disagree: then what changes fast
/// was filtered out, or is none, or the signal is not smooth; and if they are too few to tell.
pub fn white_noise_of_smooth(runs: &[&[f64]], widest: usize) -> Option<f64> {
    let steps = std::iter::successors(Some(1), |step| Some(2 * step)).take_while(|step| *step <= widest);
    let told = |step: usize| {
        let of_run = |run: &&[f64]| -> Vec<f64> {
            let difference = |t: usize| {
                let [a, b, c, d, e, f, g] = std::array::from_fn(|k| run[t + k * step]);
                a - 6.0 * b + 15.0 * c - 20.0 * d + 15.0 * e - 6.0 * f + g
            };
            (0..run.len().saturating_sub(6 * step)).map(|t| difference(t).abs()).collect()
        };
        let sizes: Vec<f64> = runs.iter().flat_map(of_run).collect();
        let enough = sizes.len() >= FEWEST;
        median(sizes).filter(|_| enough).map(|size| size / (MEDIAN_SIZE * SIXTH_DIFFERENCE))
    };
    let told: Vec<f64> = steps.map(told).collect::<Option<_>>()?;
    if told.len() < 2 {
        return None;
    }
    let octaves = (told.len() - 1) as f64;
    let [least, most] = ends(told);
    (least > 0.0 && most < OF_HALF_THE_STEP.powf(octaves) * least).then_some(most)
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

    /// A slow wave with noise: as it is, rounded, behind a filter that keeps a tenth, and without any.
    #[test]
    fn white_noise_of_a_smooth_signal_is_told_unless_it_was_filtered() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let mut noise = || -> f64 { StandardNormal.sample(&mut random) };
        let slow = |sample: usize| 2.0 * (0.01 * sample as f64).sin();
        let noisy: Vec<f64> = (0..20_000).map(|sample| slow(sample) + 0.01 * noise()).collect();
        let told = white_noise_of_smooth(&noisy.chunks(5_000).collect::<Vec<_>>(), 8).unwrap();
        assert!((told / 0.01 - 1.0).abs() < 0.05, "{told}");
        let rounded: Vec<f64> = noisy.iter().map(|value| (value / 0.02).round() * 0.02).collect();
        let told = white_noise_of_smooth(&[&rounded], 8).unwrap();
        assert!((0.7..2.0).contains(&(told / 0.01f64.hypot(0.02 / 12f64.sqrt()))), "{told}");
        let filtered = crate::recording::differentiate::low_pass(&noisy, 0.001, 50.0);
        let still: Vec<f64> = (0..20_000).map(slow).collect();
        assert_eq!([&filtered, &still].map(|signal| white_noise_of_smooth(&[signal], 8)), [None, None]);
        assert_eq!(white_noise_of_smooth(&[&noisy[..80]], 8), None, "eight samples apart there are few");
        assert_eq!(white_noise_of_smooth(&[&noisy], 1), None, "nobody can say whether it is white");
    }
}
