//! The torque of a planar arm as a linear function of its lumped parameters, and the base parameters that data can show.
//!
//! With the lumped parameters β = (K₁₁, K₁₂, …, Kₙₙ, G₁, …, Gₙ) of [`crate::arm`] the inverse dynamics are τ = Y(q, q̇, q̈) β:
//!
//! ```text
//! τ_k = s · Σ_{i ≥ k} f_i,    f_i = Σⱼ Kᵢⱼ [cos(θᵢ − θⱼ) θ̈ⱼ + sin(θᵢ − θⱼ) θ̇ⱼ²] + g Gᵢ cos θᵢ
//! ```
//!
//! No link length is needed. Which of the β a recording can show (they are the base parameters of that motion) is found by
//! the rank of the stacked regressor: [`base_columns`].

use std::f64::consts::FRAC_PI_2;

use nalgebra::DMatrix;

use super::kinematics::Absolute;
use super::{Arm, Posture};
use crate::signals::Signals;

/// How many lumped parameters an arm of `joints` joints has: n (n + 1) / 2 inertias and n gravity moments.
pub fn parameter_count(joints: usize) -> usize {
    joints * (joints + 1) / 2 + joints
}

/// Names of the lumped parameters, in the order of the columns: `K11`, `K12`, …, `G1`, …
pub fn parameter_names(joints: usize) -> Vec<String> {
    let inertias = (0..joints).flat_map(|i| (i..joints).map(move |j| format!("K{}{}", i + 1, j + 1)));
    inertias.chain((0..joints).map(|i| format!("G{}", i + 1))).collect()
}

/// Unit of the lumped parameter with this index: `kg m²` for K, `kg m` for G.
pub fn parameter_unit(joints: usize, index: usize) -> &'static str {
    if index < joints * (joints + 1) / 2 { "kg m²" } else { "kg m" }
}

impl Arm {
    /// The lumped parameters of this arm, in the order of [`parameter_names`].
    pub fn lumped_parameters(&self) -> Vec<f64> {
        let n = self.links.len();
        let outboard = |i: usize| self.links[i + 1..].iter().map(|link| link.mass).sum::<f64>();
        let moment = |i: usize| self.links[i].mass * self.links[i].com + self.links[i].length * outboard(i);
        let mut beta = Vec::with_capacity(parameter_count(n));
        for i in 0..n {
            let link = &self.links[i];
            beta.push(link.inertia + link.mass * link.com.powi(2) + link.length.powi(2) * outboard(i));
            beta.extend((i + 1..n).map(|j| link.length * moment(j)));
        }
        beta.extend((0..n).map(moment));
        beta
    }
}

/// Fills the regressor of one state: `rows[joint][parameter]`, n × [`parameter_count`], row after row.
///
/// # Panics
/// If `rows` does not have n · [`parameter_count`] elements.
pub fn fill(posture: Posture, gravity: f64, q: &[f64], qd: &[f64], qdd: &[f64], rows: &mut [f64]) {
    let n = q.len();
    let width = parameter_count(n);
    assert_eq!(rows.len(), n * width, "the regressor of {n} joints has {n} × {width} elements");
    rows.fill(0.0);
    let sign = posture.sign();
    let Absolute { angle: theta, velocity: theta_d, acceleration: theta_dd } =
        Absolute::of(posture, q.iter().copied(), qd.iter().copied(), qdd.iter().copied());
    // K_ij acts on the absolute angles i and j; joint k feels every absolute angle from k outwards.
    let mut add = |angle: usize, column: usize, force: f64| {
        for joint in 0..=angle {
            rows[joint * width + column] += sign * force;
        }
    };
    let mut column = 0;
    for i in 0..n {
        add(i, column, theta_dd[i]);
        column += 1;
        for j in i + 1..n {
            let (sin, cos) = (theta[i] - theta[j]).sin_cos();
            add(i, column, cos * theta_dd[j] + sin * theta_d[j].powi(2));
            add(j, column, cos * theta_dd[i] - sin * theta_d[i].powi(2));
            column += 1;
        }
    }
    for (i, angle) in theta[..n].iter().enumerate() {
        add(i, column, gravity * angle.cos());
        column += 1;
    }
}

/// The torque \[N m/rad\] along a trajectory that the arm with these lumped parameters needs more for each radian by which the
/// first moment of `link` (from 0; its own and of what it carries at its end) leans from the line between its joints, in the
/// direction of growing q.
///
/// Only Gⱼ and the Kᵢⱼ of the links before it are about that moment, so it is their part with θⱼ a quarter further.
///
/// # Panics
/// If `lumped` does not have [`parameter_count`] elements, or there is no such link.
pub fn leaning_along(
    posture: Posture,
    gravity: f64,
    lumped: &[f64],
    link: usize,
    q: &Signals,
    qd: &Signals,
    qdd: &Signals,
) -> Signals {
    let n = q.joint_count();
    assert_eq!(lumped.len(), parameter_count(n), "the lumped parameters of {n} joints");
    let sign = posture.sign();
    let inertia = |before: usize| lumped[before * n - before * before.saturating_sub(1) / 2 + link - before];
    let moment = lumped[n * (n + 1) / 2 + link];
    let mut torque = Signals::zeros(n, q.sample_count());
    for sample in 0..q.sample_count() {
        let Absolute { angle: theta, velocity, acceleration } =
            Absolute::of(posture, q.at(sample), qd.at(sample), qdd.at(sample));
        let leaning = theta[link] + sign * FRAC_PI_2;
        let mut add = |angle: usize, force: f64| (0..=angle).for_each(|joint| torque[joint][sample] += sign * force);
        for before in 0..link {
            let (sin, cos) = (theta[before] - leaning).sin_cos();
            add(before, inertia(before) * (cos * acceleration[link] + sin * velocity[link].powi(2)));
            add(link, inertia(before) * (cos * acceleration[before] - sin * velocity[before].powi(2)));
        }
        add(link, gravity * moment * leaning.cos());
    }
    torque
}

/// The base parameters that a stacked regressor can show: indices of the columns that are linearly independent, in order.
///
/// Rank-revealing QR by modified Gram–Schmidt with the columns in their own order, so that of two columns that can't be told
/// apart the first is kept. A column counts as dependent if less than `tolerance` of its length is left after the columns
/// before it were projected out (1e-8 is a good value for exact data), or if all of it is shorter than `tolerance` of the
/// longest column. Columns that hold a value that is not finite never count.
pub fn base_columns(stacked: &DMatrix<f64>, tolerance: f64) -> Vec<usize> {
    let mut basis: Vec<nalgebra::DVector<f64>> = Vec::new();
    let mut independent = Vec::new();
    let longest = stacked.column_iter().map(|column| column.norm()).fold(0.0, f64::max);
    for (index, column) in stacked.column_iter().enumerate() {
        let mut rest = column.clone_owned();
        // Twice is enough: the second pass removes what rounding left in the first.
        for _ in 0..2 {
            for direction in &basis {
                let overlap = direction.dot(&rest);
                rest.axpy(-overlap, direction, 1.0);
            }
        }
        let length = column.norm();
        if length > tolerance * longest && rest.norm() > tolerance * length {
            let scale = 1.0 / rest.norm();
            basis.push(rest * scale);
            independent.push(index);
        }
    }
    independent
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;
    use proptest::prelude::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::arm::testing::{arm_and_state, close};

    proptest! {
        #[test]
        fn times_the_parameters_it_is_the_inverse_dynamics((arm, [q, qd, qdd]) in arm_and_state()) {
            let n = q.len();
            let mut rows = vec![f64::NAN; n * parameter_count(n)];
            fill(arm.posture, arm.gravity, &q, &qd, &qdd, &mut rows);
            let torque = DMatrix::from_row_slice(n, parameter_count(n), &rows)
                * DVector::from_vec(arm.lumped_parameters());
            close(torque.as_slice(), &arm.inverse_dynamics(&q, &qd, &qdd), 1e-12)?;
        }
    }

    proptest! {
        /// The part of the regressor about that moment, with the moment turned a little to either side.
        #[test]
        fn a_leaning_moment_is_the_derivative_of_its_torque((arm, [q, qd, qdd]) in arm_and_state(), share in 0.0..1.0) {
            let n = q.len();
            let link = (share * n as f64) as usize;
            let one = |values: &[f64]| Signals::from_samples(n, values);
            let lumped = arm.lumped_parameters();
            let found = leaning_along(arm.posture, arm.gravity, &lumped, link, &one(&q), &one(&qd), &one(&qdd));
            let torque = |lean: f64| {
                let mut turned = q.clone();
                turned[link] += lean;
                let mut only = vec![0.0; lumped.len()];
                let names = parameter_names(n);
                for (index, name) in names.iter().enumerate() {
                    let of_link = (0..link).any(|before| *name == format!("K{}{}", before + 1, link + 1));
                    if of_link || *name == format!("G{}", link + 1) {
                        only[index] = lumped[index];
                    }
                }
                let mut rows = vec![0.0; n * parameter_count(n)];
                fill(arm.posture, arm.gravity, &turned, &qd, &qdd, &mut rows);
                DMatrix::from_row_slice(n, parameter_count(n), &rows) * DVector::from_vec(only)
            };
            let slope = (torque(1e-6) - torque(-1e-6)) / 2e-6;
            for joint in 0..n {
                let scale = slope.amax().max(1.0);
                prop_assert!((found[joint][0] - slope[joint]).abs() < 1e-7 * scale, "{} {}", found[joint][0], slope[joint]);
            }
        }
    }

    #[test]
    fn every_parameter_has_a_name_and_a_unit() {
        assert_eq!(parameter_names(2), ["K11", "K12", "K22", "G1", "G2"]);
        let units: Vec<_> = (0..5).map(|index| parameter_unit(2, index)).collect();
        assert_eq!(units, ["kg m²", "kg m²", "kg m²", "kg m", "kg m"]);
        for joints in 1..=7 {
            assert_eq!(parameter_names(joints).len(), parameter_count(joints));
            assert_eq!(Arm::uniform(joints).lumped_parameters().len(), parameter_count(joints));
        }
    }

    /// Names of the base parameters of `joints` joints under random motion; those in `still` do not move.
    fn base_names(joints: usize, gravity: f64, still: &[usize]) -> Vec<String> {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let width = parameter_count(joints);
        let mut rows = Vec::new();
        for _ in 0..50 {
            let mut state = |scale: f64| -> Vec<f64> {
                let draw = (0..joints).map(|_| random.random_range(-scale..scale)).collect::<Vec<_>>();
                draw.into_iter().enumerate().map(|(k, value)| if still.contains(&k) { 0.0 } else { value }).collect()
            };
            let mut sample = vec![0.0; joints * width];
            fill(Posture::RIGHT, gravity, &state(3.0), &state(3.0), &state(5.0), &mut sample);
            rows.extend(sample);
        }
        let names = parameter_names(joints);
        let base = base_columns(&DMatrix::from_row_slice(50 * joints, width, &rows), 1e-8);
        base.into_iter().map(|column| names[column].clone()).collect()
    }

    #[test]
    fn rich_motion_shows_every_parameter() {
        for joints in 1..=7 {
            assert_eq!(base_names(joints, 9.81, &[]).len(), parameter_count(joints));
        }
    }

    #[test]
    fn without_gravity_there_are_no_gravity_moments() {
        assert_eq!(base_names(2, 0.0, &[]), ["K11", "K12", "K22"]);
    }

    /// Two links that do not turn against each other are one link: of K₁₁, K₁₂, K₂₂ the motion shows K₁₁ + K₁₂ on joint 1
    /// and K₁₂ + K₂₂ on joint 2, so two of the three.
    #[test]
    fn a_still_joint_hides_what_only_it_would_show() {
        assert_eq!(base_names(2, 9.81, &[1]), ["K11", "K12", "G1", "G2"]);
        assert_eq!(base_names(1, 9.81, &[0]), ["G1"]);
    }

    #[test]
    fn of_columns_that_are_alike_the_first_is_kept() {
        let columns = DMatrix::from_columns(&[
            DVector::from_vec(vec![1.0, 0.0, 0.0]),
            DVector::from_vec(vec![-2.0, 0.0, 0.0]),
            DVector::from_vec(vec![0.0, 0.0, 0.0]),
            DVector::from_vec(vec![1.0, 1e-3, 0.0]),
            DVector::from_vec(vec![5.0, 7.0, 0.0]),
            DVector::from_vec(vec![f64::NAN, 0.0, 1.0]),
        ]);
        assert_eq!(base_columns(&columns, 1e-8), [0, 3]);
        assert_eq!(base_columns(&columns, 1e-2), [0, 4]);
        assert!(base_columns(&DMatrix::zeros(3, 0), 1e-8).is_empty());
        assert!(base_columns(&DMatrix::zeros(0, 3), 1e-8).is_empty());
    }
}
