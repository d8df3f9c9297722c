//! The least value of a function between two places, by Brent's method.
//!
//! Source: R. Brent, Algorithms for Minimization without Derivatives (1973), chapter 5.

/// Enough steps for a minimum as sharp as the function is smooth.
pub const FINE: usize = 24;
/// Places nearer than this share of the first interval are the same.
const PRECISION: f64 = 1e-5;

/// The place of the least `cost` between `low` and `high`, and that cost, in at most so many steps. Parabolas through the best
/// three places where they help, golden sections elsewhere.
///
/// # Errors
/// Those of `cost`.
pub fn minimum<E>(
    low: f64,
    high: f64,
    steps: usize,
    mut cost: impl FnMut(f64) -> Result<f64, E>,
) -> Result<(f64, f64), E> {
    let golden = (3.0 - 5f64.sqrt()) / 2.0;
    let near = PRECISION * (high - low);
    let (mut low, mut high) = (low, high);
    let first = low + golden * (high - low);
    // The best place, the second best, and the one before that, each with its cost.
    let mut best = (first, cost(first)?);
    let (mut second, mut third) = (best, best);
    let (mut step, mut step_before) = (0.0f64, 0.0f64);
    for _ in 0..steps {
        let middle = 0.5 * (low + high);
        if (best.0 - middle).abs() <= 2.0 * near - 0.5 * (high - low) {
            break;
        }
        let parabola = parabola_step(best, second, third);
        let helps = |&step: &f64| {
            let place = best.0 + step;
            step.abs() < 0.5 * step_before.abs() && place > low + near && place < high - near
        };
        (step_before, step) = match parabola.filter(helps) {
            Some(parabola) => (step, parabola),
            None => {
                let wider = if best.0 < middle { high - best.0 } else { low - best.0 };
                (wider, golden * wider)
            }
        };
        let place = best.0 + if step.abs() >= near { step } else { near.copysign(step) };
        let tried = (place, cost(place)?);
        if tried.1 <= best.1 {
            if tried.0 >= best.0 {
                low = best.0
            } else {
                high = best.0
            }
            (third, second, best) = (second, best, tried);
        } else {
            if tried.0 < best.0 {
                low = tried.0
            } else {
                high = tried.0
            }
            if tried.1 <= second.1 || second.0 == best.0 {
                (third, second) = (second, tried);
            } else if tried.1 <= third.1 || third.0 == best.0 || third.0 == second.0 {
                third = tried;
            }
        }
    }
    Ok(best)
}

/// From `best` to the lowest point of the parabola through three places; `None` where they lie on no parabola that opens upward.
fn parabola_step(best: (f64, f64), second: (f64, f64), third: (f64, f64)) -> Option<f64> {
    let r = (best.0 - second.0) * (best.1 - third.1);
    let q = (best.0 - third.0) * (best.1 - second.1);
    let step = -((best.0 - third.0) * q - (best.0 - second.0) * r) / (2.0 * (q - r));
    step.is_finite().then_some(step)
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;

    fn search(low: f64, high: f64, cost: impl Fn(f64) -> f64) -> (f64, usize) {
        let mut asked = 0;
        let found = minimum::<Infallible>(low, high, FINE, |place| {
            asked += 1;
            Ok(cost(place))
        });
        let Ok((place, _)) = found;
        (place, asked)
    }

    #[test]
    fn smooth_minima_are_found_in_few_steps() {
        let (place, asked) = search(-1.0, 3.0, |x| (x - 0.7).powi(2) + 0.1 * (x - 0.7).powi(4));
        assert!((place - 0.7).abs() < 1e-4 && asked < 16, "{place} after {asked}");
        let (place, asked) = search(0.0, 2.0, |x| (1.3 * x).exp() - 5.0 * x);
        assert!((place - (5.0f64 / 1.3).ln() / 1.3).abs() < 1e-4 && asked < 16, "{place} after {asked}");
    }

    #[test]
    fn kinks_and_ends_are_found_too() {
        assert!((search(0.0, 1.0, |x| (x - 0.3).abs()).0 - 0.3).abs() < 1e-3);
        assert!(search(0.0, 1.0, |x| x).0 < 1e-3);
        assert!(search(0.0, 1.0, |x| -x).0 > 1.0 - 1e-3);
    }

    #[test]
    fn an_error_stops_the_search() {
        assert_eq!(minimum(0.0, 1.0, FINE, |_| Err::<f64, _>("no")), Err("no"));
    }
}
