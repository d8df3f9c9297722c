use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use clap::{Args, ValueEnum};

use super::data::Files;
use super::failure::OrUsage;
use super::{output_folder, progress, write_file};
use crate::recording::Recording;
use crate::recording::split::Segment;
use crate::recording::write::{self, Form, WriteError};

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
    /// Only what a model learns from, or only what is held out.
    #[arg(long)]
    part: Option<Part>,
    /// Where to save: NPZ, CSV, Parquet or MCAP by its ending; a folder for a CSV of each run.
    #[arg(short, long, value_name = "LOG.npz|csv|parquet|mcap|FOLDER")]
    output: PathBuf,
}

/// A part of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Part {
    /// What a model learns from.
    Training,
    /// Where its error is measured.
    HeldOut,
}

impl Convert {
    /// Reads and saves.
    pub fn run(&self) -> anyhow::Result<()> {
        self.files.check_output(&self.output)?;
        let session = self.files.session()?;
        let recording = session.recording.as_deref().context("no recording was read")?;
        let cut = match self.part {
            None => None,
            Some(Part::Training) => Some(cut(recording, &session.split.train)?),
            Some(Part::HeldOut) => Some(cut(recording, &session.split.held_out)?),
        };
        let recording = cut.as_ref().unwrap_or(recording);
        save(recording, &self.output)?;
        tell(recording, &self.output);
        Ok(())
    }
}

/// These stretches as runs of their own, named after the runs that they are of.
fn cut(recording: &Recording, part: &[Segment]) -> anyhow::Result<Recording> {
    if part.is_empty() {
        return Err(anyhow!("nothing of this recording is in that part"));
    }
    let run = |segment: &Segment| {
        let whole = &recording.trajectories[segment.trajectory];
        let mut run = whole.slice(segment.samples.clone());
        if segment.samples.len() < whole.len() {
            let from = whole.time.get(segment.samples.start).copied().unwrap_or_default();
            run.name = format!("{} from {from:.3} s", whole.name);
        }
        run
    };
    Ok(recording.with_trajectories(part.iter().map(run).collect()))
}

/// A recording as the ending of the path says; without one, a folder with a CSV of each run.
///
/// # Errors
/// If it says nothing that is known, or the recording has several runs and the path names one CSV.
pub fn save(recording: &Recording, path: &Path) -> anyhow::Result<()> {
    // What is there and no folder, such as a pipe, holds one file.
    let is_one = path.extension().is_none() && path.exists() && !path.is_dir();
    match Form::of(path).map_err(|error| anyhow!("{error}, or name a folder")).or_usage()? {
        Some(form) => match write::to_bytes(recording, form) {
            Err(error @ WriteError::SeveralRuns(_)) => {
                let folder = path.with_extension("");
                Err(anyhow!("{error}; for a CSV of each run name a folder, such as -o {}", folder.display()))
                    .or_usage()?
            }
            bytes => write_file(path, &bytes?)?,
        },
        None if is_one => write_file(path, &write::to_bytes(recording, Form::Npz)?)?,
        None => {
            output_folder(&path.to_owned())?;
            for run in &recording.trajectories {
                write_file(&path.join(file_name(&run.name)), &write::to_csv_bytes(run))?;
            }
        }
    }
    Ok(())
}

/// Says what was saved, and what of the recording the file can't hold.
pub fn tell(recording: &Recording, path: &Path) {
    let form = Form::of(path).ok().flatten().unwrap_or(Form::Csv);
    let what = match (form.lacks(), recording.seal.is_some()) {
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

/// The file of a run: its name without what names of files can't have.
fn file_name(run: &str) -> String {
    let kept = |letter: char| if letter.is_alphanumeric() || "-_.#".contains(letter) { letter } else { '-' };
    format!("{}.csv", run.chars().map(kept).collect::<String>())
}
