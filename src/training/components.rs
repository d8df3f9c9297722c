//! The parts of a model's torque that have a physical name.

use super::{TrainError, fit};
use crate::arm::Arm;
use crate::model::{Fitted, RigidBody, Term};
use crate::recording::{PerJoint, Trajectory};

/// Inertial, Coriolis and gravity torque \[N m\], mass matrix (row after row) and its eigenvalues \[kg m²\], energies \[J\] and the
/// power of the whole torque \[W\], as far as the model has them.
///
/// # Errors
/// [`TrainError`] if the trajectory does not fit the model.
pub fn components(fitted: &Fitted, trajectory: &Trajectory) -> Result<Vec<(&'static str, PerJoint)>, TrainError> {
    let joints = trajectory.joint_count();
    let by_joint = |values: &[f64]| -> PerJoint {
        (0..joints).map(|joint| values.iter().skip(joint).step_by(joints).copied().collect()).collect()
    };
    if let Some(networks) = fit::networks(fitted) {
        let columns = fit::effect_columns(fitted, trajectory)?;
        let parts = networks.components(trajectory, &columns)?;
        let mut named = vec![];
        match &parts.lagrangian {
            Some(inside) => {
                named.push(("inertial", by_joint(&inside.inertial)));
                named.push(("coriolis", by_joint(&inside.coriolis)));
                named.push(("gravity", by_joint(&inside.gravity)));
                let entry = |k: usize| inside.mass_matrix.iter().skip(k).step_by(joints * joints).copied().collect();
                named.push(("mass_matrix", (0..joints * joints).map(entry).collect()));
                named.push(("mass_eigenvalue", by_joint(&inside.mass_eigenvalues(joints))));
                named.extend(inside.kinetic.clone().map(|energy| ("kinetic_energy", vec![energy])));
                named.extend(inside.potential.clone().map(|energy| ("potential_energy", vec![energy])));
            }
            None => {
                named.push(("inertial", by_joint(&parts.read_off.inertial)));
                named.push(("coriolis", by_joint(&parts.read_off.coriolis)));
                named.push(("gravity", by_joint(&parts.read_off.gravity)));
            }
        }
        named.push(("power", vec![power(&by_joint(&parts.torque), trajectory)]));
        return Ok(named);
    }
    // The rigid body is linear in its parameters, so its parts are its torque at other speeds and accelerations.
    let still = vec![vec![0.0; trajectory.len()]; joints];
    let rigid = |qd: &PerJoint, qdd: &PerJoint| -> Result<PerJoint, TrainError> {
        let motion = Trajectory { qd: qd.clone(), qdd: qdd.clone(), ..trajectory.clone() };
        Ok(fitted.predict(&motion).map_err(|error| TrainError::Model(error.to_string()))?.terms.swap_remove(0))
    };
    let gravity = rigid(&still, &still)?;
    let less_gravity = |torque: PerJoint| -> PerJoint {
        let subtract =
            |(all, part): (Vec<f64>, &Vec<f64>)| all.iter().zip(part).map(|(all, part)| all - part).collect();
        torque.into_iter().zip(&gravity).map(subtract).collect()
    };
    let inertial = less_gravity(rigid(&still, &trajectory.qdd)?);
    let coriolis = less_gravity(rigid(&trajectory.qd, &still)?);
    let mut named = vec![("inertial", inertial), ("coriolis", coriolis), ("gravity", gravity)];
    let total = fitted.predict(trajectory).map_err(|error| TrainError::Model(error.to_string()))?.total;
    named.push(("power", vec![power(&total, trajectory)]));
    if let Some(Term::RigidBody(RigidBody::Stated(arm))) = fitted.model.terms.first() {
        named.extend(energies(arm, trajectory));
    }
    Ok(named)
}

/// Σ τ q̇ over the joints, for each sample.
fn power(torque: &PerJoint, trajectory: &Trajectory) -> Vec<f64> {
    let at = |t: usize| torque.iter().zip(&trajectory.qd).map(|(torque, velocity)| torque[t] * velocity[t]).sum();
    (0..trajectory.len()).map(at).collect()
}

fn energies(arm: &Arm, trajectory: &Trajectory) -> [(&'static str, PerJoint); 2] {
    let state = |signal: &PerJoint, sample: usize| signal.iter().map(|joint| joint[sample]).collect::<Vec<f64>>();
    let samples = 0..trajectory.len();
    let kinetic = samples.clone().map(|t| arm.kinetic_energy(&state(&trajectory.q, t), &state(&trajectory.qd, t)));
    let potential = samples.map(|t| arm.potential_energy(&state(&trajectory.q, t)));
    [("kinetic_energy", vec![kinetic.collect()]), ("potential_energy", vec![potential.collect()])]
}
