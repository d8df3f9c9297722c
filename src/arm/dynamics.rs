//! H, c, g, energies, inverse and forward dynamics.
//!
//! The Lagrangian of [`crate::arm`] gives the generalized force on each absolute angle, and joint k feels every angle from
//! k outwards:
//!
//! ```text
//! fᵢ = Σⱼ Kᵢⱼ [cos(θᵢ − θⱼ) θ̈ⱼ + sin(θᵢ − θⱼ) θ̇ⱼ²] + g Gᵢ cos θᵢ        τ_k = s · Σ_{i ≥ k} fᵢ
//! ```
//!
//! which is H q̈ + c + g term by term. (Hollerbach, IEEE Trans. SMC 10 (1980) 730, has the same sums for any chain.)
//!
//! As in all of [`crate::arm`], states have one value per link, and there are at most [`super::MOST_JOINTS`] links: more is
//! a programming error, kept out by [`Arm::check`]. Links without mass are fine.

use nalgebra::{DMatrix, DVector};

use super::kinematics::{Absolute, PerLink};
use super::{Arm, MOST_JOINTS, Posture};
use crate::signals::Signals;

/// The three parts of the torque along a trajectory, `part[joint][sample]` \[N m\].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Components {
    /// H(q) q̈
    pub inertial: Signals,
    /// c(q, q̇): Coriolis and centrifugal torque.
    pub coriolis: Signals,
    /// g(q)
    pub gravity: Signals,
}

/// The mass matrix can't be inverted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "the mass matrix at q = {q:?} rad is not positive definite, so torque does not decide the acceleration: give every \
     link a mass away from its joint or an inertia"
)]
pub struct SingularMassMatrix {
    /// Joint positions \[rad\].
    pub q: Vec<f64>,
}

impl Arm {
    /// H(q), n × n \[kg m²\].
    pub fn mass_matrix(&self, q: &[f64]) -> DMatrix<f64> {
        Lumped::of(self).mass_matrix(&self.absolute(q, &[], &[]))
    }

    /// c(q, q̇): Coriolis and centrifugal torque, one per joint \[N m\].
    pub fn coriolis(&self, q: &[f64], qd: &[f64]) -> Vec<f64> {
        let [_, coriolis, _] = Lumped::of(self).components(&self.absolute(q, qd, &[]));
        coriolis[..self.joint_count()].to_vec()
    }

    /// g(q): the torque that holds the arm still, one per joint \[N m\].
    pub fn gravity_torque(&self, q: &[f64]) -> Vec<f64> {
        let [_, _, gravity] = Lumped::of(self).components(&self.absolute(q, &[], &[]));
        gravity[..self.joint_count()].to_vec()
    }

    /// T(q, q̇) \[J\].
    pub fn kinetic_energy(&self, q: &[f64], qd: &[f64]) -> f64 {
        Lumped::of(self).kinetic_energy(&self.absolute(q, qd, &[]))
    }

    /// V(q) \[J\], 0 where all centres of mass are as high as the base.
    pub fn potential_energy(&self, q: &[f64]) -> f64 {
        Lumped::of(self).potential_energy(&self.absolute(q, &[], &[]))
    }

    /// τ = H(q) q̈ + c(q, q̇) + g(q), one per joint \[N m\].
    pub fn inverse_dynamics(&self, q: &[f64], qd: &[f64], qdd: &[f64]) -> Vec<f64> {
        let parts = Lumped::of(self).components(&self.absolute(q, qd, qdd));
        (0..self.joint_count()).map(|joint| total(&parts, joint)).collect()
    }

    /// The acceleration q̈ \[rad/s²\] that the joint torques `tau` \[N m\] cause.
    ///
    /// # Errors
    /// [`SingularMassMatrix`] if a link has nothing that resists its rotation.
    pub fn forward_dynamics(&self, q: &[f64], qd: &[f64], tau: &[f64]) -> Result<Vec<f64>, SingularMassMatrix> {
        let lumped = Lumped::of(self);
        let state = self.absolute(q, qd, &[]);
        let parts = lumped.components(&state);
        let excess = DVector::from_fn(self.joint_count(), |joint, _| tau[joint] - total(&parts, joint));
        let decomposed = lumped.mass_matrix(&state).cholesky().ok_or_else(|| SingularMassMatrix { q: q.to_vec() })?;
        Ok(decomposed.solve(&excess).as_slice().to_vec())
    }

    /// Inverse dynamics along a trajectory: `q[joint][sample]` and so on in, torque \[N m\] in the same shape out.
    pub fn inverse_dynamics_along(&self, q: &Signals, qd: &Signals, qdd: &Signals) -> Signals {
        let mut torque = self.zeros_like(q);
        self.walk(q, qd, qdd, |joint, sample, [inertial, coriolis, gravity]| {
            torque[joint][sample] = inertial + coriolis + gravity;
        });
        torque
    }

    /// Derivative of the gravity torque by the posture's zero angle \[N m/rad\] along a trajectory. Gravity torques are
    /// cosines of that angle, so it is the gravity torque of an arm turned by a quarter.
    pub fn turned_gravity_along(&self, q: &Signals) -> Signals {
        let still = self.zeros_like(q);
        let mut turned = self.clone();
        turned.posture.zero_angle += std::f64::consts::FRAC_PI_2;
        turned.inverse_dynamics_along(q, &still, &still)
    }

    /// The parts of [`Arm::inverse_dynamics_along`]; they add up to it.
    pub fn components_along(&self, q: &Signals, qd: &Signals, qdd: &Signals) -> Components {
        let mut parts =
            Components { inertial: self.zeros_like(q), coriolis: self.zeros_like(q), gravity: self.zeros_like(q) };
        self.walk(q, qd, qdd, |joint, sample, [inertial, coriolis, gravity]| {
            parts.inertial[joint][sample] = inertial;
            parts.coriolis[joint][sample] = coriolis;
            parts.gravity[joint][sample] = gravity;
        });
        parts
    }

    /// Hands inertial, Coriolis and gravity torque of each joint at each sample to `take`, without allocating.
    fn walk(&self, q: &Signals, qd: &Signals, qdd: &Signals, mut take: impl FnMut(usize, usize, [f64; 3])) {
        let lumped = Lumped::of(self);
        for sample in 0..q.sample_count() {
            let state = Absolute::of(self.posture, q.at(sample), qd.at(sample), qdd.at(sample));
            let [inertial, coriolis, gravity] = lumped.components(&state);
            for joint in 0..lumped.joints {
                take(joint, sample, [inertial[joint], coriolis[joint], gravity[joint]]);
            }
        }
    }

    fn zeros_like(&self, q: &Signals) -> Signals {
        Signals::zeros(self.joint_count(), q.sample_count())
    }

    fn absolute(&self, q: &[f64], qd: &[f64], qdd: &[f64]) -> Absolute {
        Absolute::of(self.posture, q.iter().copied(), qd.iter().copied(), qdd.iter().copied())
    }
}

fn total(parts: &[PerLink; 3], joint: usize) -> f64 {
    parts.iter().map(|part| part[joint]).sum()
}

/// [`Arm::lumped_parameters`] unpacked for speed.
struct Lumped {
    joints: usize,
    posture: Posture,
    /// Kᵢⱼ, both triangles \[kg m²\].
    inertia: [PerLink; MOST_JOINTS],
    /// g Gᵢ \[N m\].
    weight: PerLink,
}

impl Lumped {
    fn of(arm: &Arm) -> Self {
        let joints = arm.joint_count();
        let mut inertia = [[0.0; MOST_JOINTS]; MOST_JOINTS];
        let mut weight = [0.0; MOST_JOINTS];
        let parameters = arm.lumped_parameters();
        let pairs = (0..joints).flat_map(|i| (i..joints).map(move |j| (i, j)));
        let (inertias, moments) = parameters.split_at(parameters.len() - joints);
        for ((i, j), value) in pairs.zip(inertias) {
            (inertia[i][j], inertia[j][i]) = (*value, *value);
        }
        for (place, moment) in weight.iter_mut().zip(moments) {
            *place = arm.gravity * moment;
        }
        Lumped { joints, posture: arm.posture, inertia, weight }
    }

    /// Inertial, Coriolis and gravity torque of each joint.
    fn components(&self, state: &Absolute) -> [PerLink; 3] {
        let turn = Turn::of(state, self.joints);
        let [mut inertial, mut coriolis, mut gravity] = [[0.0; MOST_JOINTS]; 3];
        for i in 0..self.joints {
            for j in 0..self.joints {
                let (sin, cos) = turn.difference(i, j);
                inertial[i] += self.inertia[i][j] * cos * state.acceleration[j];
                coriolis[i] += self.inertia[i][j] * sin * state.velocity[j].powi(2);
            }
            gravity[i] = self.weight[i] * turn.cos[i];
        }
        [inertial, coriolis, gravity].map(|forces| self.on_joints(forces))
    }

    /// From forces on absolute angles to torques of the joints: τ_k = s · Σ_{i ≥ k} fᵢ.
    fn on_joints(&self, mut forces: PerLink) -> PerLink {
        let mut sum = 0.0;
        for force in forces[..self.joints].iter_mut().rev() {
            sum += *force;
            *force = self.posture.sign() * sum;
        }
        forces
    }

    /// H_kl = Σ_{i ≥ k} Σ_{j ≥ l} Kᵢⱼ cos(θᵢ − θⱼ); the sense of rotation enters twice and cancels.
    fn mass_matrix(&self, state: &Absolute) -> DMatrix<f64> {
        let turn = Turn::of(state, self.joints);
        let mut mass = DMatrix::from_fn(self.joints, self.joints, |i, j| self.inertia[i][j] * turn.difference(i, j).1);
        for k in (1..self.joints).rev() {
            for l in 0..self.joints {
                mass[(k - 1, l)] += mass[(k, l)];
            }
        }
        for l in (1..self.joints).rev() {
            for k in 0..self.joints {
                mass[(k, l - 1)] += mass[(k, l)];
            }
        }
        mass
    }

    fn kinetic_energy(&self, state: &Absolute) -> f64 {
        let turn = Turn::of(state, self.joints);
        let mut twice = 0.0;
        for i in 0..self.joints {
            for j in 0..self.joints {
                twice += self.inertia[i][j] * turn.difference(i, j).1 * state.velocity[i] * state.velocity[j];
            }
        }
        0.5 * twice
    }

    fn potential_energy(&self, state: &Absolute) -> f64 {
        self.weight.iter().zip(state.angle).map(|(weight, angle)| weight * angle.sin()).sum()
    }
}

/// Sine and cosine of the absolute angles. Those of their differences follow from them, which saves most of the calls.
struct Turn {
    sin: PerLink,
    cos: PerLink,
}

impl Turn {
    fn of(state: &Absolute, joints: usize) -> Self {
        let [mut sin, mut cos] = [[0.0; MOST_JOINTS]; 2];
        for i in 0..joints {
            (sin[i], cos[i]) = state.angle[i].sin_cos();
        }
        Turn { sin, cos }
    }

    /// sin(θᵢ − θⱼ) and cos(θᵢ − θⱼ).
    fn difference(&self, i: usize, j: usize) -> (f64, f64) {
        (self.sin[i] * self.cos[j] - self.cos[i] * self.sin[j], self.cos[i] * self.cos[j] + self.sin[i] * self.sin[j])
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;
    use proptest::prelude::*;

    use super::*;
    use crate::arm::testing::{arm_and_state, close};
    use crate::arm::{Link, Sense};

    /// ∂L/∂q̇ by central differences; exact up to rounding, since L is quadratic in q̇.
    fn momentum(arm: &Arm, q: &[f64], qd: &[f64]) -> Vec<f64> {
        slopes(qd, 0.1, |qd| arm.kinetic_energy(q, qd))
    }

    fn slopes(at: &[f64], step: f64, value: impl Fn(&[f64]) -> f64) -> Vec<f64> {
        (0..at.len())
            .map(|k| {
                let shifted = |by: f64| {
                    let mut moved = at.to_vec();
                    moved[k] += by;
                    value(&moved)
                };
                (shifted(step) - shifted(-step)) / (2.0 * step)
            })
            .collect()
    }

    /// The state a short time later (or earlier) under constant acceleration.
    fn later(q: &[f64], qd: &[f64], qdd: &[f64], t: f64) -> (Vec<f64>, Vec<f64>) {
        let position = (0..q.len()).map(|k| q[k] + qd[k] * t + 0.5 * qdd[k] * t * t).collect();
        (position, (0..q.len()).map(|k| qd[k] + qdd[k] * t).collect())
    }

    proptest! {
        #[test]
        fn torque_follows_from_the_lagrangian((arm, [q, qd, qdd]) in arm_and_state()) {
            let step = 1e-4;
            let at = |t: f64| {
                let (q, qd) = later(&q, &qd, &qdd, t);
                momentum(&arm, &q, &qd)
            };
            let (before, after) = (at(-step), at(step));
            let force = slopes(&q, step, |q| arm.kinetic_energy(q, &qd) - arm.potential_energy(q));
            let expected: Vec<f64> =
                (0..q.len()).map(|k| (after[k] - before[k]) / (2.0 * step) - force[k]).collect();
            close(&arm.inverse_dynamics(&q, &qd, &qdd), &expected, 1e-5)?;
        }

        #[test]
        fn joint_power_is_the_change_of_energy((arm, [q, qd, qdd]) in arm_and_state()) {
            let step = 1e-4;
            let energy = |t: f64| {
                let (q, qd) = later(&q, &qd, &qdd, t);
                arm.kinetic_energy(&q, &qd) + arm.potential_energy(&q)
            };
            let power: f64 = arm.inverse_dynamics(&q, &qd, &qdd).iter().zip(&qd).map(|(tau, qd)| tau * qd).sum();
            let largest = arm.kinetic_energy(&q, &qd) + arm.gravity_torque(&q).iter().map(|g| g.abs()).sum::<f64>();
            let change = (energy(step) - energy(-step)) / (2.0 * step);
            prop_assert!((power - change).abs() < 1e-5 * (1.0 + power.abs() + 10.0 * largest), "{power} is not {change}");
        }

        #[test]
        fn the_parts_add_up_and_each_is_what_its_name_says((arm, [q, qd, qdd]) in arm_and_state()) {
            let still = vec![0.0; q.len()];
            let mass = arm.mass_matrix(&q);
            prop_assert!((&mass - mass.transpose()).amax() < 1e-12 * mass.amax());
            prop_assert!(mass.clone().cholesky().is_some(), "{mass} is not positive definite");
            let velocity = DVector::from_column_slice(&qd);
            close(&[arm.kinetic_energy(&q, &qd)], &[0.5 * velocity.dot(&(&mass * &velocity))], 1e-11)?;
            close(&arm.gravity_torque(&q), &slopes(&q, 1e-4, |q| arm.potential_energy(q)), 1e-6)?;

            let inertial = &mass * DVector::from_column_slice(&qdd);
            let (coriolis, gravity) = (arm.coriolis(&q, &qd), arm.gravity_torque(&q));
            let sum: Vec<f64> = (0..q.len()).map(|k| inertial[k] + coriolis[k] + gravity[k]).collect();
            close(&arm.inverse_dynamics(&q, &qd, &qdd), &sum, 1e-11)?;
            close(&arm.coriolis(&q, &still), &still, 1e-12)?;
        }

        #[test]
        fn forward_dynamics_undoes_inverse_dynamics((arm, [q, qd, qdd]) in arm_and_state()) {
            let tau = arm.inverse_dynamics(&q, &qd, &qdd);
            let back = arm.forward_dynamics(&q, &qd, &tau).unwrap();
            close(&arm.inverse_dynamics(&q, &qd, &back), &tau, 1e-9)?;
        }

        #[test]
        fn turning_the_other_way_mirrors_the_torque((arm, [q, qd, qdd]) in arm_and_state()) {
            let mirrored = Arm {
                posture: Posture {
                    sense: match arm.posture.sense {
                        Sense::Clockwise => Sense::CounterClockwise,
                        Sense::CounterClockwise => Sense::Clockwise,
                    },
                    ..arm.posture
                },
                ..arm.clone()
            };
            let negative = |values: &[f64]| values.iter().map(|value| -value).collect::<Vec<_>>();
            let other = mirrored.inverse_dynamics(&negative(&q), &negative(&qd), &negative(&qdd));
            close(&other, &negative(&arm.inverse_dynamics(&q, &qd, &qdd)), 1e-12)?;
        }

        #[test]
        fn along_a_trajectory_it_is_the_same((arm, [q, qd, qdd]) in arm_and_state()) {
            let samples = |state: &[f64], scale: f64| Signals::from_fn(state.len(), 2, |joint, sample| [1.0, scale][sample] * state[joint]);
            let (qs, qds, qdds) = (samples(&q, 0.5), samples(&qd, -2.0), samples(&qdd, 3.0));
            let second = |signal: &Signals| signal.at(1).collect::<Vec<_>>();
            let torque = arm.inverse_dynamics_along(&qs, &qds, &qdds);
            close(&second(&torque), &arm.inverse_dynamics(&second(&qs), &second(&qds), &second(&qdds)), 1e-14)?;
            let parts = arm.components_along(&qs, &qds, &qdds);
            close(&second(&parts.coriolis), &arm.coriolis(&second(&qs), &second(&qds)), 1e-14)?;
            close(&second(&parts.gravity), &arm.gravity_torque(&second(&qs)), 1e-14)?;
            for joint in 0..q.len() {
                for sample in 0..2 {
                    let sum = parts.inertial[joint][sample] + parts.coriolis[joint][sample] + parts.gravity[joint][sample];
                    prop_assert_eq!(torque[joint][sample], sum);
                }
            }
        }
    }

    /// A pendulum by hand: τ = (I + m r²) q̈ + m g r cos θ.
    #[test]
    fn one_link_is_the_textbook_pendulum() {
        let link = Link { mass: 2.0, length: 0.7, com: 0.4, inertia: 0.05 };
        let hanging = Arm { links: vec![link], gravity: 9.81, posture: Posture::DOWN };
        let tau = hanging.inverse_dynamics(&[0.3], &[1.5], &[2.0])[0];
        let expected = (0.05 + 2.0 * 0.16) * 2.0 + 2.0 * 9.81 * 0.4 * 0.3_f64.sin();
        assert!((tau - expected).abs() < 1e-12, "{tau} is not {expected}");
    }

    #[test]
    fn an_arm_left_alone_keeps_its_energy() {
        for posture in [Posture::RIGHT, Posture::UP, Posture { sense: Sense::Clockwise, ..Posture::DOWN }] {
            let arm = Arm { posture, ..Arm::uniform(3) };
            let energy = |x: &[f64]| arm.kinetic_energy(&x[..3], &x[3..]) + arm.potential_energy(&x[..3]);
            let rate = |x: &[f64]| [&x[3..], &arm.forward_dynamics(&x[..3], &x[3..], &[0.0; 3]).unwrap()].concat();
            let moved = |x: &[f64], rate: &[f64], h: f64| -> Vec<f64> {
                x.iter().zip(rate).map(|(x, rate)| x + h * rate).collect()
            };
            let mut x = vec![0.4, -0.9, 0.2, 0.5, -1.0, 2.0];
            let start = energy(&x);
            let h = 5e-4;
            for _ in 0..4000 {
                let a = rate(&x);
                let b = rate(&moved(&x, &a, h / 2.0));
                let c = rate(&moved(&x, &b, h / 2.0));
                let d = rate(&moved(&x, &c, h));
                let mean: Vec<f64> = (0..6).map(|i| (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]) / 6.0).collect();
                x = moved(&x, &mean, h);
            }
            let drift = (energy(&x) - start).abs();
            assert!(drift < 1e-6, "energy drifted by {drift} J from {start} J");
        }
    }

    #[test]
    fn a_link_that_nothing_holds_back_has_no_forward_dynamics() {
        let mut arm = Arm::uniform(2);
        arm.links[1] = Link { mass: 0.0, length: 1.0, com: 0.0, inertia: 0.0 };
        let message = arm.forward_dynamics(&[0.0; 2], &[0.0; 2], &[1.0; 2]).unwrap_err().to_string();
        assert!(message.contains("give every link a mass"), "{message}");
    }

    #[test]
    fn no_samples_and_no_joints_give_no_torque() {
        let none = Signals::zeros(2, 0);
        assert_eq!(Arm::uniform(2).inverse_dynamics_along(&none, &none, &none), none);
        let no_joint = Signals::zeros(0, 0);
        assert_eq!(Arm::uniform(0).inverse_dynamics_along(&no_joint, &no_joint, &no_joint), no_joint);
    }
}
