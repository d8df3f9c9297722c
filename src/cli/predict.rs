use std::path::PathBuf;

use anyhow::{Context, bail};
use clap::Args;

use super::data::{Data, read_model};
use super::write_file;
use crate::arm::Arm;
use crate::model::{Fitted, Term};
use crate::recording::table::Table;
use crate::recording::{PerJoint, Recording, Trajectory};
use crate::training;

/// Write a model's torque and its components, sample by sample.
///
/// With `--model FILE` the saved model is used, with a preset it is identified or trained first. Columns are time, measured
/// and predicted torque, one torque per term and, where the model has them, inertial, Coriolis and gravity torque, energies
/// and the eigenvalues of the mass matrix.
#[derive(Args)]
pub struct Predict {
    #[command(flatten)]
    data: Data,
    /// Where to save: NPZ, or CSV by its ending.
    #[arg(short, long, value_name = "TORQUES.npz|csv")]
    output: PathBuf,
}

impl Predict {
    /// Reads, predicts, saves.
    pub fn run(&self) -> anyhow::Result<()> {
        let (session, fitted) = match self.data.model_file() {
            Some(path) => (self.data.session()?, read_model(&path)?),
            None => {
                let session = self.data.session_with_model()?;
                let fitted = session.current().context("no model was fitted")?.fitted.clone();
                (session, fitted)
            }
        };
        let recording = session.recording.as_deref().context("no recording was read")?;
        if recording.joint_count() != fitted.setting().kinds.len() {
            let joints = fitted.setting().kinds.len();
            bail!(
                "the model has {joints} joints, the recording {}: use recordings of its arm",
                recording.joint_count()
            );
        }
        let table = table(&fitted, recording)?;
        let is_csv = self.output.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv"));
        let bytes = if is_csv { table.to_csv_bytes() } else { table.to_npz_bytes()? };
        write_file(&self.output, &bytes)?;
        println!(
            "saved {}: {} samples, {} columns",
            self.output.display(),
            recording.sample_count(),
            table.names().len()
        );
        Ok(())
    }
}

/// All columns, trajectory after trajectory.
fn table(fitted: &Fitted, recording: &Recording) -> anyhow::Result<Table> {
    let mut table = Table::default();
    for (number, trajectory) in recording.trajectories.iter().enumerate() {
        let prediction = fitted.predict(trajectory)?;
        table.extend("trajectory", &vec![number as f64 + 1.0; trajectory.len()]);
        table.extend("time", &trajectory.time);
        table.extend_joints("tau_measured", &trajectory.tau);
        table.extend_joints("tau_predicted", &prediction.total);
        for (term, torque) in fitted.model.terms.iter().zip(&prediction.terms) {
            match term {
                // An effect of one joint is zero at all others.
                Term::Effect(effect) if effect.joint.is_some() => {
                    let joint = effect.joint.unwrap_or_default();
                    table.extend(&format!("{}@{}", effect.effect, joint + 1), &torque[joint]);
                }
                Term::Effect(effect) => table.extend_joints(&effect.effect, torque),
                other => table.extend_joints(&other.label().replace(' ', "-"), torque),
            }
        }
        for (name, torque) in components(fitted, trajectory)? {
            table.extend_joints(name, &torque);
        }
    }
    Ok(table)
}

/// Inertial, Coriolis and gravity torque, energies and eigenvalues of the mass matrix, as far as the model has them.
pub fn components(fitted: &Fitted, trajectory: &Trajectory) -> anyhow::Result<Vec<(&'static str, PerJoint)>> {
    let joints = trajectory.joint_count();
    let by_joint = |values: &[f64]| -> PerJoint {
        (0..joints).map(|joint| values.iter().skip(joint).step_by(joints).copied().collect()).collect()
    };
    if let Some(networks) = training::fit::networks(fitted) {
        let columns = training::fit::effect_columns(fitted, trajectory)?;
        let parts = networks.components(trajectory, &columns)?;
        let mut named = vec![];
        match &parts.lagrangian {
            Some(inside) => {
                named.push(("inertial", by_joint(&inside.inertial)));
                named.push(("coriolis", by_joint(&inside.coriolis)));
                named.push(("gravity", by_joint(&inside.gravity)));
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
        return Ok(named);
    }
    // The rigid body is linear in its parameters, so its parts are its torque at other speeds and accelerations.
    let still = vec![vec![0.0; trajectory.len()]; joints];
    let rigid = |qd: &PerJoint, qdd: &PerJoint| -> anyhow::Result<PerJoint> {
        let motion = Trajectory { qd: qd.clone(), qdd: qdd.clone(), ..trajectory.clone() };
        Ok(fitted.predict(&motion)?.terms.swap_remove(0))
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
    if let Some(Term::RigidBody(crate::model::RigidBody::Stated(arm))) = fitted.model.terms.first() {
        named.extend(energies(arm, trajectory));
    }
    Ok(named)
}

fn energies(arm: &Arm, trajectory: &Trajectory) -> [(&'static str, PerJoint); 2] {
    let state = |signal: &PerJoint, sample: usize| signal.iter().map(|joint| joint[sample]).collect::<Vec<f64>>();
    let samples = 0..trajectory.len();
    let kinetic = samples.clone().map(|t| arm.kinetic_energy(&state(&trajectory.q, t), &state(&trajectory.qd, t)));
    let potential = samples.map(|t| arm.potential_energy(&state(&trajectory.q, t)));
    [("kinetic_energy", vec![kinetic.collect()]), ("potential_energy", vec![potential.collect()])]
}
