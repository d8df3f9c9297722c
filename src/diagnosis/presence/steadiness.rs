//! Whether what is left is as strong at all times, as noise is, or comes and goes, as what the arm does.
//!
//! Teeth that bounce in their play or a tool that chatters leave a remainder that looks as white as noise from one sample to the
//! next. It comes in bursts. The energies of short windows tell: those of steady noise scatter as χ² does, and what the quietest of
//! them hold bounds the noise in all of them.

use nalgebra::DVector;

use crate::diagnosis::candidates::Library;
use crate::diagnosis::search::Search;
use crate::model::equations::MOST_LAG;

/// Independent samples in a window: so many that the energies of steady noise scatter by a half, so few that a burst fills it.
const FREEDOM: f64 = 8.0;
/// Of all windows this share is taken for quiet, and its quantile of the standard normal distribution.
const QUIET: f64 = 0.2;
const QUIET_QUANTILE: f64 = -0.8416;
/// Fewer windows say nothing.
const FEWEST: usize = 20;

/// The share that steady noise can be of the energy that these factors of all columns leave of a joint, at most 1.
pub fn of(search: &Search, joint: usize, factors: &DVector<f64>) -> f64 {
    let Library { equations, columns, torque, .. } = &search.library;
    let correlations = equations.correlations(columns, factors, torque, joint, MOST_LAG);
    steadiness(equations.residuals(columns, factors, torque, joint), &correlations)
}

/// The share of a residual's energy that steady noise can be, at most 1. `residuals` are stretches of it, `correlations` its ρ₁, ρ₂ …
fn steadiness(residuals: impl Iterator<Item = Vec<f64>>, correlations: &[f64]) -> f64 {
    let positive = correlations.iter().take_while(|&&rho| rho > 0.0);
    // Squares of a Gaussian signal are correlated by ρ².
    let resembling = 1.0 + 2.0 * positive.map(|rho| rho * rho).sum::<f64>();
    let length = (FREEDOM * resembling).ceil() as usize;
    let energy = |window: &[f64]| window.iter().map(|value| value * value).sum::<f64>() / window.len() as f64;
    let mut energies: Vec<f64> =
        residuals.flat_map(|stretch| stretch.chunks_exact(length).map(energy).collect::<Vec<_>>()).collect();
    let mean = energies.iter().sum::<f64>() / energies.len() as f64;
    if energies.len() < FEWEST || mean <= 0.0 {
        return 1.0;
    }
    energies.sort_by(f64::total_cmp);
    let quiet = energies[(QUIET * energies.len() as f64) as usize];
    (quiet / quantile_of_quiet(length as f64 / resembling) / mean).min(1.0)
}

/// The quiet quantile of χ² over its degrees of freedom (Wilson and Hilferty, Proc. Natl. Acad. Sci. 17 (1931) 684).
fn quantile_of_quiet(freedom: f64) -> f64 {
    let spread = 2.0 / (9.0 * freedom);
    (1.0 - spread + QUIET_QUANTILE * spread.sqrt()).powi(3)
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    /// Gaussian noise through a first-order filter, ρₖ = 0.8ᵏ.
    fn noise(seed: u64) -> (Vec<f64>, Vec<f64>) {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let mut last = 0.0;
        let mut next = || {
            let new: f64 = StandardNormal.sample(&mut random);
            last = 0.8 * last + 0.6 * new;
            last
        };
        ((0..20_000).map(|_| next()).collect(), (1..30).map(|lag| 0.8f64.powi(lag)).collect())
    }

    #[test]
    fn steady_noise_is_steady() {
        for seed in 0..5 {
            let (noise, correlations) = noise(seed);
            let steady = steadiness([noise].into_iter(), &correlations);
            assert!(steady > 0.93, "{steady}");
        }
    }

    /// Bursts in a third of the time, of four times the energy of the noise: noise is a share of 1 / (1 + 4/3).
    #[test]
    fn what_comes_and_goes_is_no_steady_noise() {
        let (quiet, correlations) = noise(1);
        let (loud, _) = noise(2);
        let burst = |n: usize| if (n / 400).is_multiple_of(3) { 2.0 } else { 0.0 };
        let sum = quiet.iter().zip(&loud).enumerate().map(|(n, (quiet, loud))| quiet + burst(n) * loud).collect();
        let steady = steadiness([sum].into_iter(), &correlations);
        assert!((0.3..0.55).contains(&steady), "{steady}");
    }

    #[test]
    fn of_little_nothing_is_said() {
        assert_eq!(steadiness([vec![1.0; 30]].into_iter(), &[]), 1.0);
        assert_eq!(steadiness(std::iter::empty(), &[]), 1.0);
        assert_eq!(steadiness([vec![0.0; 3000]].into_iter(), &[]), 1.0);
    }
}
