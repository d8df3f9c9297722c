//! Bodies that can exist, and whose torque is as near as possible to one that was identified without asking whether any can.
//!
//! Each body is the one that it is expected to be, changed by an upper triangular factor with positive diagonal:
//!
//! ```text
//! J = U₀ E(θ) E(θ)ᵀ U₀ᵀ,    J₀ = U₀ U₀ᵀ,    E(θ) = e^α [ e^d₁ s₁₂  s₁₃  t₁ ]
//!                                                    [      e^d₂ s₂₃  t₂ ]
//!                                                    [           e^d₃ t₃ ]
//!                                                    [                1  ]
//! ```
//!
//! so that its pseudo-inertia J is positive definite whatever θ is, θ = 0 is what is expected, and all of θ are numbers without units.
//! The torque is linear in the ten parameters of each body, so what is minimised is a quadratic form of them, and λ ‖θ‖² beside it
//! for what no torque tells. By the method of Levenberg and Marquardt, from a large λ down to a small one.
//! Source: Rucker and Wensing, Smooth parameterization of rigid-body inertia, IEEE Robotics and Automation Letters 7 (2022) 2771.

use nalgebra::{DMatrix, DVector, Matrix4};

use super::body::Body;
use super::chain::PER_LINK;

/// From the strongest to the weakest hold of what is expected, against the share of the torque's energy that is missed.
const HOLDS: [f64; 8] = [1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7];
/// Steps for each of them, and the fall of the cost, as a share of the hold, at which they end.
const MOST_STEPS: usize = 50;
const ENOUGH: f64 = 1e-3;
/// How much shorter or longer a step becomes with its failure or success, and where it is given up.
const DAMPING: [f64; 2] = [10.0, 0.2];
const MOST_DAMPING: f64 = 1e12;
/// Places of s and t in E.
const BESIDE: [(usize, usize); 6] = [(0, 1), (0, 2), (1, 2), (0, 3), (1, 3), (2, 3)];

/// The squared error of a torque as a function of the parameters π of all bodies: πᵀ H π − 2 gᵀ π + what no body changes.
#[derive(Debug, Clone, PartialEq)]
pub struct Misfit {
    /// H.
    pub square: DMatrix<f64>,
    /// g.
    pub product: DVector<f64>,
}

impl Misfit {
    fn of(&self, parameters: &DVector<f64>) -> f64 {
        parameters.dot(&(&self.square * parameters)) - 2.0 * self.product.dot(parameters)
    }
}

/// The bodies nearest to a torque; `expected` are what they are where it tells nothing. They can exist if those can.
///
/// `None` if one of the expected bodies can't exist.
///
/// # Panics
/// If the misfit is not one of ten parameters for each body.
pub fn nearest(misfit: &Misfit, expected: &[Body]) -> Option<Vec<Body>> {
    assert_eq!(misfit.product.len(), PER_LINK * expected.len(), "ten parameters a body");
    let factors = expected.iter().map(|body| upper_factor(&body.pseudo_inertia())).collect::<Option<Vec<_>>>()?;
    let mut theta = DVector::zeros(PER_LINK * expected.len());
    for hold in HOLDS {
        theta = settled(misfit, &factors, theta, hold);
    }
    let body = |(factor, theta): (&Matrix4<f64>, &[f64])| {
        let whole = factor * change(theta);
        Body::of_pseudo_inertia(&(whole * whole.transpose()))
    };
    Some(factors.iter().zip(theta.as_slice().chunks_exact(PER_LINK)).map(body).collect())
}

/// The θ of the smallest cost from this one on.
fn settled(misfit: &Misfit, factors: &[Matrix4<f64>], mut theta: DVector<f64>, hold: f64) -> DVector<f64> {
    let cost = |theta: &DVector<f64>, parameters: &DVector<f64>| misfit.of(parameters) + hold * theta.norm_squared();
    let (mut parameters, mut slopes) = along(factors, &theta);
    let mut now = cost(&theta, &parameters);
    let mut damping = 1e-3;
    for _ in 0..MOST_STEPS {
        let square = slopes.transpose() * &misfit.square * &slopes;
        let downhill = slopes.transpose() * (&misfit.product - &misfit.square * &parameters) - hold * &theta;
        let before = now;
        while damping < MOST_DAMPING {
            let mut damped = square.clone();
            (0..theta.len())
                .for_each(|place| damped[(place, place)] += hold + damping * (hold + square[(place, place)]));
            let Some(root) = damped.cholesky() else {
                damping *= DAMPING[0];
                continue;
            };
            let moved = &theta + root.solve(&downhill);
            let (moved_parameters, moved_slopes) = along(factors, &moved);
            let after = cost(&moved, &moved_parameters);
            // What is not a number is no success.
            if after < now {
                (theta, parameters, slopes, now) = (moved, moved_parameters, moved_slopes, after);
                damping *= DAMPING[1];
                break;
            }
            damping *= DAMPING[0];
        }
        if before - now <= ENOUGH * hold {
            break;
        }
    }
    theta
}

/// The parameters of all bodies at θ, and how they change with it.
fn along(factors: &[Matrix4<f64>], theta: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
    let mut parameters = DVector::zeros(theta.len());
    let mut slopes = DMatrix::zeros(theta.len(), theta.len());
    for (number, (factor, theta)) in factors.iter().zip(theta.as_slice().chunks_exact(PER_LINK)).enumerate() {
        let start = number * PER_LINK;
        let own = change(theta);
        let whole = factor * own;
        let place = |column: &[f64; PER_LINK], into: &mut [f64]| into.copy_from_slice(column);
        place(&linear(&(whole * whole.transpose())), &mut parameters.as_mut_slice()[start..start + PER_LINK]);
        for (index, slope) in changes(theta, &own).iter().enumerate() {
            let half = factor * slope * whole.transpose();
            let column = linear(&(half + half.transpose()));
            slopes.view_mut((start, start + index), (PER_LINK, 1)).copy_from_slice(&column);
        }
    }
    (parameters, slopes)
}

/// E(θ); θ = α, d₁ d₂ d₃, s₁₂ s₁₃ s₂₃, t₁ t₂ t₃.
fn change(theta: &[f64]) -> Matrix4<f64> {
    let mut own = Matrix4::identity();
    (0..3).for_each(|place| own[(place, place)] = theta[1 + place].exp());
    BESIDE.iter().zip(&theta[4..]).for_each(|(place, value)| own[*place] = *value);
    own * theta[0].exp()
}

/// ∂E/∂θ.
fn changes(theta: &[f64], own: &Matrix4<f64>) -> [Matrix4<f64>; PER_LINK] {
    let mut all = [Matrix4::zeros(); PER_LINK];
    all[0] = *own;
    (0..3).for_each(|place| all[1 + place][(place, place)] = own[(place, place)]);
    all[4..].iter_mut().zip(BESIDE).for_each(|(slope, place)| slope[place] = theta[0].exp());
    all
}

/// The ten parameters, which are linear in a pseudo-inertia.
fn linear(pseudo: &Matrix4<f64>) -> [f64; PER_LINK] {
    let trace = pseudo[(0, 0)] + pseudo[(1, 1)] + pseudo[(2, 2)];
    let inertia = |row: usize, column: usize| {
        let own = -pseudo[(row, column)];
        if row == column { trace + own } else { own }
    };
    let moment = |axis: usize| pseudo[(axis, 3)];
    [
        pseudo[(3, 3)],
        moment(0),
        moment(1),
        moment(2),
        inertia(0, 0),
        inertia(0, 1),
        inertia(0, 2),
        inertia(1, 1),
        inertia(1, 2),
        inertia(2, 2),
    ]
}

/// U of J = U Uᵀ; `None` if J is not positive definite.
fn upper_factor(pseudo: &Matrix4<f64>) -> Option<Matrix4<f64>> {
    let turned = |matrix: &Matrix4<f64>| Matrix4::from_fn(|row, column| matrix[(3 - row, 3 - column)]);
    Some(turned(&turned(pseudo).cholesky()?.l()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::body::tests::brick;

    fn bodies() -> [Body; 2] {
        [brick(2.0, [0.3, 0.1, 0.6], [0.1, -0.2, 0.4]), brick(0.7, [0.1, 0.1, 0.2], [-0.1, 0.0, 0.2])]
    }

    /// The misfit to these parameters of which `seen` are told, each in units of its own size.
    fn misfit(parameters: &[f64], seen: impl Fn(usize) -> bool) -> Misfit {
        let weight = |(place, value): (usize, &f64)| if seen(place) { value.powi(-2) } else { 0.0 };
        let weights = DVector::from_iterator(parameters.len(), parameters.iter().enumerate().map(weight));
        let product = weights.component_mul(&DVector::from_row_slice(parameters));
        Misfit { square: DMatrix::from_diagonal(&weights), product }
    }

    #[test]
    fn slopes_are_those_of_the_parameters() {
        let factors: Vec<_> = bodies().iter().map(|body| upper_factor(&body.pseudo_inertia()).unwrap()).collect();
        let theta = DVector::from_fn(20, |place, _| 0.3 * (place as f64 + 1.0).sin());
        let (at, slopes) = along(&factors, &theta);
        for place in 0..20 {
            let mut moved = theta.clone();
            moved[place] += 1e-7;
            let change = (along(&factors, &moved).0 - &at) / 1e-7;
            assert!((change - slopes.column(place)).norm() < 1e-5, "{place}");
        }
        let linear: Vec<f64> = bodies().iter().flat_map(|body| linear(&body.pseudo_inertia())).collect();
        let direct: Vec<f64> = bodies().iter().flat_map(Body::parameters).collect();
        assert!(linear.iter().zip(&direct).all(|(a, b)| (a - b).abs() < 1e-14));
    }

    #[test]
    fn bodies_that_exist_are_found_from_others() {
        let expected = [brick(1.0, [0.2, 0.2, 0.2], [0.0; 3]), brick(3.0, [0.5, 0.2, 0.2], [0.1, 0.1, 0.0])];
        let wanted: Vec<f64> = bodies().iter().flat_map(Body::parameters).collect();
        // The y of the second body's centre is 0, which weighs nothing; it is given a size of its own.
        let sized: Vec<f64> = wanted.iter().map(|value| if *value == 0.0 { 1e-2 } else { *value }).collect();
        let mut misfit = misfit(&sized, |_| true);
        misfit.product = &misfit.square * DVector::from_row_slice(&wanted);
        let found: Vec<f64> = nearest(&misfit, &expected).unwrap().iter().flat_map(Body::parameters).collect();
        for ((found, wanted), size) in found.iter().zip(&wanted).zip(&sized) {
            assert!((found - wanted).abs() < 2e-3 * size.abs(), "{found} is not {wanted}");
        }
    }

    #[test]
    fn what_can_not_exist_becomes_what_can_and_what_is_not_told_stays() {
        let expected = bodies();
        // Only mass and inertia about x of the first body are told, and the mass is negative.
        let mut wanted: Vec<f64> = expected.iter().flat_map(Body::parameters).collect();
        wanted[0] = -1.0;
        let found = nearest(&misfit(&wanted, |place| place == 0), &expected).unwrap();
        assert!(found.iter().all(Body::is_possible) && found[0].mass < 0.05, "{found:?}");
        assert!(
            (found[1].inertia - expected[1].inertia).norm() < 1e-12 && (found[1].com - expected[1].com).norm() < 1e-12
        );
        let flat = Body { inertia: nalgebra::Matrix3::zeros(), ..expected[0] };
        assert!(nearest(&misfit(&wanted, |_| true), &[flat, expected[1]]).is_none());
    }
}
