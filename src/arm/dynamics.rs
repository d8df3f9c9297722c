//! H, c, g, energies, inverse and forward dynamics.

use super::Arm;

impl Arm {
    /// Inverse dynamics along a trajectory: `q[joint][sample]` and so on in, torque \[N m\] in the same shape out.
    pub fn inverse_dynamics_along(&self, _q: &[Vec<f64>], _qd: &[Vec<f64>], _qdd: &[Vec<f64>]) -> Vec<Vec<f64>> {
        todo!()
    }
}
