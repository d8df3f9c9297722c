//! Recordings and tables as files: NPZ (recordings in our own layout, which reads back bit by bit), CSV, Parquet and MCAP. Equal
//! recordings give equal bytes.

pub(super) mod mcap;
mod npz;
pub(super) mod parquet;

use std::path::Path;

pub use npz::to_npz_bytes;

use super::layout::{CHANNELS, TIME, TRAJECTORY};
use super::table::Table;
use super::{Recording, RecordingError, Trajectory};

pub(crate) use mcap::joint_states;

/// What recordings and tables are written as: the one list of it, for endings, texts and help.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Arrays for numpy; a recording in our own layout, which keeps all that is known of it.
    Npz,
    /// Text, a line a sample.
    Csv,
    /// A table by columns.
    Parquet,
    /// A log of ROS 2 messages.
    Mcap,
}

impl Form {
    /// All of them.
    pub const ALL: [Form; 4] = [Form::Npz, Form::Csv, Form::Parquet, Form::Mcap];

    /// How its files end, without the dot.
    pub fn ending(self) -> &'static str {
        match self {
            Form::Npz => "npz",
            Form::Csv => "csv",
            Form::Parquet => "parquet",
            Form::Mcap => "mcap",
        }
    }

    /// What a path is to be written as; `None` if it has no ending.
    ///
    /// # Errors
    /// [`UnknownForm`] for other endings.
    pub fn of(path: &Path) -> Result<Option<Form>, UnknownForm> {
        let Some(ending) = path.extension() else { return Ok(None) };
        let ending = ending.to_string_lossy().to_lowercase();
        match Form::ALL.into_iter().find(|form| form.ending() == ending) {
            Some(form) => Ok(Some(form)),
            None => Err(UnknownForm(ending)),
        }
    }

    /// What of a recording it can't hold, in words; empty if it holds all.
    pub fn lacks(self) -> &'static str {
        match self {
            Form::Npz => "",
            Form::Csv | Form::Parquet => "names of joints, the stated arm and the seal",
            Form::Mcap => "accelerations, the stated arm and the seal",
        }
    }
}

/// Nothing is written with this ending.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("nothing is written as .{0}: end the name with {endings}", endings = endings())]
pub struct UnknownForm(String);

fn endings() -> String {
    Form::ALL.map(|form| format!(".{}", form.ending())).join(", ")
}

/// The recording can't be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// It does not keep its promises, so it could not be read back.
    #[error("{0}")]
    Recording(#[from] RecordingError),
    /// A CSV holds one run.
    #[error("it has {0} runs, and a CSV holds one; an NPZ, a Parquet file or an MCAP log holds all")]
    SeveralRuns(usize),
    /// The archive could not be made.
    #[error("the archive could not be made: {0}")]
    Archive(#[from] zip::result::ZipError),
    /// The same, while writing an entry.
    #[error("the archive could not be made: {0}")]
    Entry(#[from] std::io::Error),
    /// The description could not be made.
    #[error("the description of the recording could not be made: {0}")]
    Manifest(#[from] serde_json::Error),
    /// The Parquet file could not be made.
    #[error("the Parquet file could not be made: {0}")]
    Parquet(#[from] ::parquet::errors::ParquetError),
    /// The log could not be made.
    #[error("the MCAP log could not be made: {0}")]
    Mcap(#[from] ::mcap::McapError),
    /// A log has no samples before its clock begins.
    #[error(
        "time goes from {from} s to {to} s, which the stamps of a ROS 2 message can't hold; write an NPZ or Parquet"
    )]
    Stamp {
        /// The first time \[s\].
        from: f64,
        /// The last time \[s\].
        to: f64,
    },
}

/// A recording as a file of this form.
///
/// As CSV and Parquet it has the columns `time`, `q1`…, `qd1`…, `qdd1`…, `tau1`… in SI units; Parquet counts several runs in the
/// column `trajectory`, which reads them back. As MCAP it is `sensor_msgs/JointState` on `/joint_states`, runs one after another
/// with a pause between.
///
/// # Errors
/// [`WriteError`]
pub fn to_bytes(recording: &Recording, form: Form) -> Result<Vec<u8>, WriteError> {
    recording.verify()?;
    match (form, recording.trajectories.as_slice()) {
        (Form::Npz, _) => to_npz_bytes(recording),
        (Form::Csv, [run]) => Ok(to_csv_bytes(run)),
        (Form::Csv, runs) => Err(WriteError::SeveralRuns(runs.len())),
        (Form::Parquet, runs) => table_of(runs).to_bytes(Form::Parquet),
        (Form::Mcap, runs) => {
            let names: Vec<&str> = recording.joints.iter().map(|joint| joint.name.as_str()).collect();
            joint_states(runs, &names, Some(::mcap::Compression::Zstd))
        }
    }
}

/// One trajectory as CSV: `time,q1…,qd1…,qdd1…,tau1…` in SI units, with as many digits as it takes to read the same
/// numbers back.
pub fn to_csv_bytes(trajectory: &Trajectory) -> Vec<u8> {
    table_of(std::slice::from_ref(trajectory)).to_csv_bytes()
}

/// Runs as columns; several are counted from 1.
fn table_of(runs: &[Trajectory]) -> Table {
    let mut table = Table::default();
    for (number, run) in runs.iter().enumerate() {
        if runs.len() > 1 {
            table.extend(TRAJECTORY, &vec![number as f64 + 1.0; run.len()]);
        }
        table.extend(TIME, &run.time);
        for (name, (_, signal)) in CHANNELS.into_iter().zip(run.signals()) {
            for (joint, values) in signal.iter().enumerate() {
                table.extend(&format!("{name}{}", joint + 1), values);
            }
        }
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Monitor;
    use crate::recording::read::{ReadOptions, read};
    use crate::recording::{Channels, Origin};
    use crate::signals::Signals;

    #[test]
    fn csv_has_a_header_and_all_digits() {
        let joint = |values: [f64; 2]| Signals::from_samples(1, &values);
        let channels = Channels {
            time: vec![0.0, 0.1],
            q: joint([1.0 / 3.0, -0.0]),
            qd: joint([1e-300, 1e300]),
            qdd: joint([0.1 + 0.2, 5e-324]),
            tau: joint([1.0, 2.0]),
        };
        let trajectory = Trajectory::new("t", channels).unwrap();
        let text = String::from_utf8(to_csv_bytes(&trajectory)).unwrap();
        assert_eq!(
            text,
            "time,q1,qd1,qdd1,tau1\n0.0,0.3333333333333333,1e-300,0.30000000000000004,1.0\n0.1,-0.0,1e300,5e-324,2.0\n"
        );
    }

    /// Two runs of two joints whose clocks begin elsewhere.
    fn recording() -> Recording {
        let run = |name: &str, start: f64| {
            let time: Vec<f64> = (0..50).map(|sample| start + 0.01 * f64::from(sample)).collect();
            let wave = |factor: f64| {
                Signals::from_samples(
                    2,
                    &time.iter().flat_map(|t| [(factor * t).sin(), factor + t * t]).collect::<Vec<_>>(),
                )
            };
            let channels = Channels { q: wave(1.0), qd: wave(2.0), qdd: wave(3.0), tau: wave(4.0), time: time.clone() };
            Trajectory::new(name, channels).unwrap()
        };
        Recording::of_runs(vec![run("a", 0.5), run("b", -2.0)])
    }

    fn read_back(bytes: &[u8], form: Form) -> Recording {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(format!("log.{}", form.ending()));
        std::fs::write(&path, bytes).unwrap();
        read(&[path], &ReadOptions::default(), &Monitor::new()).unwrap().recording
    }

    #[test]
    fn parquet_reads_back_bit_by_bit() {
        let written = recording();
        let read = read_back(&to_bytes(&written, Form::Parquet).unwrap(), Form::Parquet);
        assert_eq!(read.trajectories.iter().map(|run| run.name.as_str()).collect::<Vec<_>>(), ["log#1", "log#2"]);
        for (read, written) in read.trajectories.iter().zip(&written.trajectories) {
            assert_eq!((&read.time, read.signals()), (&written.time, written.signals()));
        }
        assert_eq!(read.provenance.acceleration, Origin::Measured);
    }

    #[test]
    fn mcap_reads_back_without_acceleration_and_runs_are_apart() {
        let written = recording();
        let read = read_back(&to_bytes(&written, Form::Mcap).unwrap(), Form::Mcap);
        assert_eq!(read.joints, written.joints);
        assert_eq!(read.trajectories.len(), 2);
        for (read, written) in read.trajectories.iter().zip(&written.trajectories) {
            // The acceleration is derived, which leaves out some samples at both ends.
            let cut = (written.len() - read.len()) / 2;
            let written = written.slice(cut..cut + read.len());
            assert_eq!((&read.q, &read.qd, &read.tau), (&written.q, &written.qd, &written.tau));
            let shift = read.time[0] - written.time[0];
            assert!(read.time.iter().zip(&written.time).all(|(read, written)| (read - written - shift).abs() < 2e-9));
        }
        assert!(matches!(read.provenance.acceleration, Origin::Derived(_)));
    }

    #[test]
    fn a_csv_holds_one_run_and_the_ending_names_the_form() {
        assert!(matches!(to_bytes(&recording(), Form::Csv), Err(WriteError::SeveralRuns(2))));
        assert_eq!(Form::of(Path::new("a.PARQUET")), Ok(Some(Form::Parquet)));
        assert_eq!(Form::of(Path::new("folder")), Ok(None));
        let problem = Form::of(Path::new("a.xlsx")).unwrap_err().to_string();
        assert_eq!(problem, "nothing is written as .xlsx: end the name with .npz, .csv, .parquet, .mcap");
    }
}
