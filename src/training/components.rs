//! The parts of a model's torque that have a physical name.

use super::{TrainError, fit};
use crate::arm::Arm;
use crate::arm::stated::StatedArm;
use crate::model::{Fitted, RigidBody, Term};
use crate::recording::{Channels, Trajectory};
use crate::signals::Signals;

/// Inertial, Coriolis and gravity torque \[N m\], mass matrix (row after row) and its eigenvalues \[kg m²\], energies \[J\] and the
/// power of the whole torque \[W\], as far as the model has them.
///
/// # Errors
/// [`TrainError`] if the trajectory does not fit the model.
pub fn components(fitted: &Fitted, trajectory: &Trajectory) -> Result<Vec<(&'static str, Signals)>, TrainError> {
    if let Some(networks) = fit::networks(fitted) {
        let columns = fit::effect_columns(fitted, trajectory)?;
        let parts = networks.components(trajectory, &columns)?;
        let mut named = vec![];
        match parts.lagrangian {
            Some(inside) => {
                let eigenvalues = inside.mass_eigenvalues();
                named.push(("inertial", inside.inertial));
                named.push(("coriolis", inside.coriolis));
                named.push(("gravity", inside.gravity));
                named.push(("mass_matrix", inside.mass_matrix));
                named.push(("mass_eigenvalue", eigenvalues));
                named.extend(inside.kinetic.map(|energy| ("kinetic_energy", energy)));
                named.extend(inside.potential.map(|energy| ("potential_energy", energy)));
            }
            None => {
                named.push(("inertial", parts.read_off.inertial));
                named.push(("coriolis", parts.read_off.coriolis));
                named.push(("gravity", parts.read_off.gravity));
            }
        }
        named.push(("power", power(&parts.torque, trajectory)));
        return Ok(named);
    }
    // The rigid body is linear in its parameters, so its parts are its torque at other speeds and accelerations.
    let still = Signals::zeros(trajectory.joint_count(), trajectory.len());
    let rigid = |qd: &Signals, qdd: &Signals| -> Result<Signals, TrainError> {
        let (qd, qdd) = (qd.clone(), qdd.clone());
        let motion = Trajectory::new(&trajectory.name, Channels { qd, qdd, ..Channels::clone(trajectory) })?;
        Ok(fitted.predict(&motion).map_err(|error| TrainError::Model(error.to_string()))?.terms.swap_remove(0))
    };
    let gravity = rigid(&still, &still)?;
    let less_gravity = |mut torque: Signals| {
        torque.add(&gravity, -1.0);
        torque
    };
    let inertial = less_gravity(rigid(&still, &trajectory.qdd)?);
    let coriolis = less_gravity(rigid(&trajectory.qd, &still)?);
    let mut named = vec![("inertial", inertial), ("coriolis", coriolis), ("gravity", gravity)];
    let total = fitted.predict(trajectory).map_err(|error| TrainError::Model(error.to_string()))?.total;
    named.push(("power", power(&total, trajectory)));
    if let Some(Term::RigidBody(RigidBody::Stated(StatedArm::Planar(arm)))) = fitted.model.terms.first() {
        named.extend(energies(arm, trajectory));
    }
    Ok(named)
}

/// Σ τ q̇ over the joints, a single signal.
fn power(torque: &Signals, trajectory: &Trajectory) -> Signals {
    let at = |t: usize| torque.at(t).zip(trajectory.qd.at(t)).map(|(torque, velocity)| torque * velocity).sum();
    Signals::from_fn(1, trajectory.len(), |_, t| at(t))
}

fn energies(arm: &Arm, trajectory: &Trajectory) -> [(&'static str, Signals); 2] {
    let state = |signal: &Signals, sample: usize| signal.at(sample).collect::<Vec<f64>>();
    let along = |energy: &dyn Fn(usize) -> f64| Signals::from_fn(1, trajectory.len(), |_, t| energy(t));
    let kinetic = along(&|t| arm.kinetic_energy(&state(&trajectory.q, t), &state(&trajectory.qd, t)));
    let potential = along(&|t| arm.potential_energy(&state(&trajectory.q, t)));
    [("kinetic_energy", kinetic), ("potential_energy", potential)]
}
