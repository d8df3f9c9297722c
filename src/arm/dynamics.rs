//! H, c, g, energies, inverse and forward dynamics.

use super::{Arm, regressor};

impl Arm {
    /// Inverse dynamics along a trajectory: `q[joint][sample]` and so on in, torque \[N m\] in the same shape out.
    pub fn inverse_dynamics_along(&self, q: &[Vec<f64>], qd: &[Vec<f64>], qdd: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let n = q.len();
        let beta = self.lumped_parameters();
        let mut rows = vec![0.0; n * beta.len()];
        let mut tau = vec![vec![0.0; q[0].len()]; n];
        for t in 0..q[0].len() {
            let at = |s: &[Vec<f64>]| s.iter().map(|j| j[t]).collect::<Vec<f64>>();
            regressor::fill(self.posture, self.gravity, &at(q), &at(qd), &at(qdd), &mut rows);
            for j in 0..n {
                tau[j][t] = rows[j * beta.len()..(j + 1) * beta.len()].iter().zip(&beta).map(|(a, b)| a * b).sum();
            }
        }
        tau
    }
}
