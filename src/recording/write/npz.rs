//! A recording as NPZ in our own layout.

use std::io::{Cursor, Write};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::super::layout::{CHANNELS, MANIFEST, Manifest, TIME, TRAJECTORY, TRUTH, VERSION};
use super::super::{Recording, npy};
use super::WriteError;

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
