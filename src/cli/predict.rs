use std::path::PathBuf;

use anyhow::{Context, bail};
use clap::Args;

use super::data::Data;
use super::failure::OrUsage;
use super::{progress, write_file};
use crate::model::{Fitted, Term};
use crate::recording::Recording;
use crate::recording::table::Table;
use crate::recording::write::Form;
use crate::training::components;

/// Write a model's torque and its components, sample by sample.
///
/// With `--model FILE` the saved model is used, with a preset it is identified or trained first. Columns are time, measured
/// and predicted torque, one torque per term, power and, where the model has them, inertial, Coriolis and gravity torque, the mass
/// matrix (row after row) with its eigenvalues, and energies.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope predict arm.npz --add coulomb-friction -o torques.csv
  torquescope predict arm.npz --model structured-delan -o torques.npz")]
pub struct Predict {
    /// Where to save: NPZ, CSV, Parquet or MCAP by its ending.
    #[arg(short, long, value_name = "TORQUES.npz|csv|parquet|mcap")]
    output: PathBuf,
    #[command(flatten)]
    data: Data,
}

impl Predict {
    /// Reads, predicts, saves.
    pub fn run(&self) -> anyhow::Result<()> {
        self.data.check_output(&self.output)?;
        let form = Form::of(&self.output).or_usage()?.unwrap_or(Form::Npz);
        let (session, fitted) = match self.data.saved_model()? {
            Some(fitted) => (self.data.session()?, fitted),
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
        write_file(&self.output, &table.to_bytes(form)?)?;
        progress::told(format_args!(
            "saved {}: {} samples, {} columns",
            self.output.display(),
            recording.sample_count(),
            table.names().len()
        ));
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
                    table.extend(&format!("{}@{}", effect.effect.id, joint + 1), &torque[joint]);
                }
                Term::Effect(effect) => table.extend_joints(effect.effect.id, torque),
                other => table.extend_joints(&other.label().replace(' ', "-"), torque),
            }
        }
        for (name, torque) in components(fitted, trajectory)? {
            table.extend_joints(name, &torque);
        }
    }
    Ok(table)
}
