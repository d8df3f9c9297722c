use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;

use super::data::Files;
use super::failure::OrUsage;
use super::of_part::OfPart;
use super::{progress, tell_folder};
use crate::export::recorded::{self, RecordedError};
use crate::recording::Recording;

/// Write recordings as they were understood: in SI units, cut, set right, with what was derived.
///
/// As one NPZ, which keeps everything that is known of the arm; as CSV or Parquet with the columns time, q, qd, qdd and tau of every
/// joint (CSV: a file for each run); or as MCAP with sensor_msgs/JointState, as ROS 2 logs it. `predict` writes torques and components of a model beside what was measured.
#[derive(Args)]
#[command(after_help = "Examples:
  torquescope convert log.db3 -o log.csv
  torquescope convert pos_read_data.csv+curr_data.csv --map tx40 -o tx40.npz
  torquescope convert log.csv -o log.mcap
  torquescope convert log.mcap --part held-out -o held-out            # a CSV for each run, in this folder")]
pub struct Convert {
    #[command(flatten)]
    files: Files,
    #[command(flatten)]
    of: OfPart,
    /// Where to save: NPZ, CSV, Parquet or MCAP by its ending; a folder for a CSV of each run.
    #[arg(short, long, value_name = "LOG.npz|csv|parquet|mcap|FOLDER")]
    output: PathBuf,
}

impl Convert {
    /// Reads and saves.
    pub fn run(&self) -> anyhow::Result<()> {
        self.files.check_output(&self.output)?;
        let session = self.files.opened()?;
        let recording = session.recording.as_deref().context("no recording was read")?;
        let part = self.of.part.cut(recording, &session.split)?;
        save(&part, &self.output)?;
        tell(&part, &self.output);
        Ok(())
    }
}

/// A recording as the ending of the path says; without one, a folder with a CSV of each run.
///
/// # Errors
/// If it says nothing that is known, or the recording has several runs and the path names one CSV.
pub fn save(recording: &Recording, path: &Path) -> anyhow::Result<()> {
    let files = match recorded::files(recording, path) {
        Err(error @ (RecordedError::Form(_) | RecordedError::SeveralRuns { .. })) => return Err(error).or_usage(),
        files => files?,
    };
    if let Some(folder) = &files.folder {
        tell_folder(folder);
    }
    Ok(files.write()?)
}

/// Says what was saved, and what of the recording the file can't hold.
pub fn tell(recording: &Recording, path: &Path) {
    let what = match (recorded::lacks(path), recording.seal.is_some()) {
        ("", true) => "; the truth is sealed in it".to_owned(),
        ("", false) => String::new(),
        (lacking, _) => format!("; left out: {lacking} (an NPZ keeps all)"),
    };
    progress::told(format_args!(
        "saved {}: {} joints, {} trajectories, {} samples{what}",
        path.display(),
        recording.joint_count(),
        recording.trajectories.len(),
        recording.sample_count()
    ));
}
