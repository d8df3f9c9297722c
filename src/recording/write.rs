//! Recordings as bytes: NPZ in our own layout, which reads back bit by bit, and CSV. Equal recordings give equal bytes.

use std::fmt::Write as _;
use std::io::{Cursor, Write};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::layout::{CHANNELS, MANIFEST, Manifest, TIME, TRAJECTORY, TRUTH, VERSION};
use super::npy;
use super::{Recording, RecordingError, Trajectory};

/// The recording can't be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// It does not keep its promises, so it could not be read back.
    #[error("{0}")]
    Recording(#[from] RecordingError),
    /// The archive could not be made.
    #[error("the archive could not be made: {0}")]
    Archive(#[from] zip::result::ZipError),
    /// The same, while writing an entry.
    #[error("the archive could not be made: {0}")]
    Entry(#[from] std::io::Error),
    /// The description could not be made.
    #[error("the description of the recording could not be made: {0}")]
    Manifest(#[from] serde_json::Error),
}

/// The whole recording as an NPZ file.
///
/// Arrays, all f64 but `trajectory` (i64): `time` \[N\], `trajectory` \[N\], `q`, `qd`, `qdd`, `tau` \[N, n\], where N counts
/// the samples of all trajectories in turn. Names, provenance and the like stand in the entry `torquescope.json`, the
/// sealed truth in `truth.sealed`. `numpy.load` opens it.
///
/// # Errors
/// [`WriteError::Recording`] if the recording does not pass [`Recording::verify`].
pub fn to_npz_bytes(recording: &Recording) -> Result<Vec<u8>, WriteError> {
    recording.verify()?;
    let (samples, joints) = (recording.sample_count(), recording.joint_count());
    let trajectories = &recording.trajectories;
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    // Stored, with a fixed time: the same recording gives the same bytes everywhere, and numpy can map them.
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    let mut entry = |name: &str, bytes: &[u8]| -> Result<(), WriteError> {
        archive.start_file(name, options.large_file(bytes.len() > u32::MAX as usize / 2))?;
        archive.write_all(bytes)?;
        Ok(())
    };

    let time = trajectories.iter().flat_map(|t| &t.time).flat_map(|value| value.to_le_bytes());
    entry(&format!("{TIME}.npy"), &npy::encode("<f8", &[samples], time))?;
    let number = trajectories.iter().enumerate().flat_map(|(index, t)| std::iter::repeat_n(index as i64, t.len()));
    entry(&format!("{TRAJECTORY}.npy"), &npy::encode("<i8", &[samples], number.flat_map(i64::to_le_bytes)))?;
    for (index, name) in CHANNELS.into_iter().enumerate() {
        let rows = trajectories.iter().flat_map(|t| {
            let (_, channel) = t.signals()[index];
            (0..t.len()).flat_map(move |sample| channel.at(sample))
        });
        entry(&format!("{name}.npy"), &npy::encode("<f8", &[samples, joints], rows.flat_map(f64::to_le_bytes)))?;
    }
    let manifest = Manifest {
        format: VERSION,
        name: recording.name.clone(),
        joints: recording.joints.clone(),
        trajectories: trajectories.iter().map(|t| t.name.clone()).collect(),
        provenance: recording.provenance.clone(),
        posture: recording.posture,
        stated_arm: recording.stated_arm.clone(),
        chain: recording.chain.clone(),
        torque: recording.torque.clone(),
        encoders: recording.encoders,
    };
    entry(MANIFEST, &serde_json::to_vec_pretty(&manifest)?)?;
    if let Some(seal) = &recording.seal {
        entry(TRUTH, seal.as_bytes())?;
    }
    Ok(archive.finish()?.into_inner())
}

/// One trajectory as CSV: `time,q1…,qd1…,qdd1…,tau1…` in SI units, with as many digits as it takes to read the same
/// numbers back.
///
/// # Panics
/// Never for a trajectory of a recording that passes [`Recording::verify`].
pub fn to_csv_bytes(trajectory: &Trajectory) -> Vec<u8> {
    let mut text = TIME.to_owned();
    for name in CHANNELS {
        for joint in 1..=trajectory.joint_count() {
            // Writing to a String can't fail.
            let _ = write!(text, ",{name}{joint}");
        }
    }
    text.push('\n');
    for (sample, time) in trajectory.time.iter().enumerate() {
        let _ = write!(text, "{time:?}");
        for value in trajectory.signals().into_iter().flat_map(|(_, channel)| channel.at(sample)) {
            let _ = write!(text, ",{value:?}");
        }
        text.push('\n');
    }
    text.into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Channels;
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
}
