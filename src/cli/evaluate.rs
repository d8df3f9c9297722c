use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use serde::Serialize;

use super::data::{Data, read_model};
use super::table::{number, table};
use crate::model::{Evaluation, JointError};
use crate::recording::split::{Segment, Split};

/// Measure a model's error on recordings.
///
/// With `--model FILE.json` the saved model is measured on all samples. With a preset, the preset is identified on the
/// training part and measured on the held-out part.
#[derive(Args)]
pub struct Evaluate {
    #[command(flatten)]
    data: Data,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Answer {
    data: &'static str,
    joints: Vec<JointError>,
    mean_r2: f64,
    noise_floor_nmse: Option<Vec<f64>>,
}

impl Evaluate {
    /// Reads, predicts, prints.
    pub fn run(&self) -> anyhow::Result<()> {
        let (data, evaluation) = match self.data.model_file() {
            Some(path) => ("all samples", self.evaluate_saved(&path)?),
            None => {
                let session = self.data.session_with_model()?;
                let step = session.current().context("no model was fitted")?;
                ("held-out samples", step.evaluation.clone())
            }
        };
        let joints = evaluation.held_out;
        let mean_r2 = joints.iter().map(|joint| joint.r2).sum::<f64>() / joints.len().max(1) as f64;
        if self.json {
            let answer = Answer { data, joints, mean_r2, noise_floor_nmse: evaluation.noise_floor_nmse };
            println!("{}", serde_json::to_string_pretty(&answer)?);
        } else {
            println!("{data}:\n{}", error_table(&joints));
            if let Some(floor) = &evaluation.noise_floor_nmse {
                println!("noise floor (nMSE): {}", super::table::numbers(floor));
            }
        }
        Ok(())
    }

    fn evaluate_saved(&self, path: &PathBuf) -> anyhow::Result<Evaluation> {
        let fitted = read_model(path)?;
        let session = self.data.session()?;
        let recording = session.recording.as_deref().context("no recording was read")?;
        let joints = fitted.setting().kinds.len();
        if recording.joint_count() != joints {
            anyhow::bail!(
                "{} is a model of {joints} joints, the recording has {}: use recordings of the arm that it was trained on",
                path.display(),
                recording.joint_count()
            );
        }
        let everything = recording.trajectories.iter().enumerate();
        let held_out = everything.map(|(trajectory, data)| Segment { trajectory, samples: 0..data.len() }).collect();
        Ok(Evaluation::of(&fitted, recording, &Split { train: Vec::new(), held_out })?)
    }
}

/// Errors by joint as text.
pub fn error_table(joints: &[JointError]) -> String {
    let row = |(joint, error): (usize, &JointError)| {
        vec![(joint + 1).to_string(), number(error.mse), number(error.nmse), format!("{:.4}", error.r2)]
    };
    let rows: Vec<Vec<String>> = joints.iter().enumerate().map(row).collect();
    table(&["joint", "MSE [(N m)²]", "nMSE", "R²"], &rows)
}
