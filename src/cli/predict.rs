use std::path::PathBuf;

use anyhow::Context;
use clap::Args;

use super::data::Data;
use super::failure::OrUsage;
use super::of_part::OfPart;
use super::{progress, write_file};
use crate::export::torques;
use crate::recording::write::Form;

/// Write a model's torque and its components, sample by sample.
///
/// With `--model FILE` the saved model is used, with a preset it is identified or trained first. Columns are time, measured
/// and predicted torque, the residual (measured less predicted), one torque per term, power and, where the model has them, inertial, Coriolis and gravity torque, the mass
/// matrix (row after row) with its eigenvalues, and energies.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope predict arm.npz --add coulomb-friction -o torques.csv
  torquescope predict arm.npz --model structured-delan -o torques.npz
  torquescope predict arm.npz --add coulomb-friction --part held-out -o torques.parquet")]
pub struct Predict {
    #[command(flatten)]
    of: OfPart,
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
        let recording = session.recording.context("no recording was read")?;
        let stretches = self.of.part.stretches(&recording, &session.split)?;
        let table =
            progress::watch("predict", move |monitor| torques::table(&fitted, &recording, &stretches, monitor))?;
        write_file(&self.output, &table.to_bytes(form)?)?;
        progress::told(format_args!(
            "saved {}: {} samples, {} columns",
            self.output.display(),
            table.row_count(),
            table.names().len()
        ));
        Ok(())
    }
}
